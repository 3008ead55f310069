#!/usr/bin/env bash
# Siconos' solver SOCLCP reports success, and the error 1e-9, for a sliding contact that flies away.
#
# Guess: all solvers in the list for `fc3d_driver` solve the same contact problem with friction, and
# the residual in `dparam[1]` measures it. The manual gives the solver one line of parameters.
# Seen: SOCLCP solves another problem without Coulomb's term mu |v_t|: the velocity is normal to the
# friction cone, so that a body that slides with v lifts off at mu v while the ground presses it.
# The driver returns 0, and the residual is that of the other problem. `fc3d_compute_error` gives
# the error of the contact problem.
# Versions: python3-siconos 4.4.0+dfsg-2 of Debian 12; 2026-11-28.
# Output: status, normal velocity of a contact that presses, size of the residual, and the error:
# "NSGS: status 0, velocity 0.000, residual below 1e-6, error 0.000", "SOCLCP: status 0, velocity
# 0.656, residual below 1e-6, error 0.275", then "as described".
. "$(dirname "$0")/common.sh"
if ! dpkg-query --show python3-siconos > /dev/null 2>&1; then
    apt-get install --yes --quiet --no-install-recommends python3-siconos=4.4.0+dfsg-2
fi
dpkg-query --show --showformat='${Version}\n' python3-siconos | grep --fixed-strings --quiet 4.4.0

cat > "$folder/slide.py" <<'PYTHON'
import numpy as np
import siconos.numerics as sn

FRICTION = np.array([0.3])
# Velocity (normal, tangential) = compliance @ force + velocity without force.
COMPLIANCE = np.array([[1, 0.4, 0], [0.4, 1, 0], [0, 0, 1.0]])
FREE = np.array([-1, 2.0, 0])

for name in ("NSGS", "SOCLCP"):
    problem = sn.FrictionContactProblem(3, 1, COMPLIANCE, FREE, FRICTION)
    options = sn.SolverOptions(getattr(sn, f"SICONOS_FRICTION_3D_{name}"))
    force, velocity = np.zeros(3), np.zeros(3)
    status = sn.fc3d_driver(problem, force, velocity, options)
    assert force[0] > 1
    residual = "below" if options.dparam[1] < 1e-6 else "above"
    _, error = sn.fc3d_compute_error(
        problem, force, velocity.copy(), 1e-6, options, np.linalg.norm(FREE)
    )
    print(
        f"{name}: status {status}, velocity {abs(velocity[0]):.3f}, "
        f"residual {residual} 1e-6, error {error:.3f}"
    )
PYTHON

env --unset=PYTHONPATH /usr/bin/python3 "$folder/slide.py" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
NSGS: status 0, velocity 0.000, residual below 1e-6, error 0.000
SOCLCP: status 0, velocity 0.656, residual below 1e-6, error 0.275
OUTPUT
echo "as described"
