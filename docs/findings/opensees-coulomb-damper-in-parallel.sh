#!/usr/bin/env bash
# OpenSees' `CoulombDamper` is a spring beside a friction force, and without speed only a spring.
#
# Guess: `CoulombDamper tag tangent force` is an elastic slider: it sticks with the tangent as its
# stiffness, slides at the given force, and dissipates in a static analysis too.
# Seen: the stress is the tangent times the strain, without a bound, plus the given force in the
# direction of the speed. So a static path to and fro is elastic, and in motion the spring, not
# friction, holds the load. `ElasticPP` is the elastic slider.
# Versions: openseespy 3.7.1.2, openseespylinux 3.7.1.2, Python 3.11; 2026-11-28.
# Output: stress at strains 0.01, 0.02, 0.01 and 0 of tangent 1000 and force 3:
# "static: 10 20 10 0", "in motion: 13 23 7 -3", "ElasticPP: 3 3 -3 -3", then "as described".
. "$(dirname "$0")/common.sh"
packages openseespy==3.7.1.2 openseespylinux==3.7.1.2

cat > "$folder/path.py" <<'PYTHON'
import openseespy.opensees as ops


def stresses(speed, *material):
    """Stresses on the way out and back, at a speed of this size."""
    ops.wipe()
    ops.uniaxialMaterial(material[0], 1, *material[1:])
    ops.testUniaxialMaterial(1)
    seen = []
    for strain, direction in ((0.01, 1), (0.02, 1), (0.01, -1), (0.0, -1)):
        ops.setStrain(strain, speed * direction)
        seen.append(ops.getStress())
    return " ".join(f"{stress:.0f}" for stress in seen)


print("static:", stresses(0.0, "CoulombDamper", 1000.0, 3.0))
print("in motion:", stresses(1.0, "CoulombDamper", 1000.0, 3.0))
print("ElasticPP:", stresses(0.0, "ElasticPP", 1000.0, 0.003))
PYTHON

"$folder/venv/bin/python" "$folder/path.py" 2> /dev/null | grep : | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
static: 10 20 10 0
in motion: 13 23 7 -3
ElasticPP: 3 3 -3 -3
OUTPUT
echo "as described"
