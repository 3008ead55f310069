#!/usr/bin/env bash
# The friction of fedoo's `IPCContact` fades with the number of increments, and during a pause.
#
# Guess: a pressed block that slides carries the friction coefficient times the normal force, more
# increments change that little, and the shear force remains when the motion stops.
# Seen: friction depends on the slip of the increment alone. Where this is below `eps_v`, the force
# is Coulomb's times 2 s - s^2 with s = slip / `eps_v`. Sixteen times as many increments leave an
# eighth of the force. If the ends are held afterwards, the contact goes on slipping until there is
# no shear force. So contact that should stick creeps, and a path in small steps has no hysteresis.
# The documentation calls `eps_v` the slip of an increment below which friction is regularized. Set
# it far below the slip of each increment, and expect no shear force that lasts.
# Versions: fedoo 1.1.0, ipctk 1.6.1, numpy 2.3.5, scipy 1.16.3, Python 3.11; 2026-11-28.
# Output: shear force over normal force in the middle of a slide with the friction coefficient 0.5,
# the same by hand, and after a pause of as many increments: "10 increments: 0.500, by hand 0.500,
# after a pause 0.026", and likewise 0.219 and 0.000 for 40, 0.061 and 0.000 for 160, then "as
# described".
. "$(dirname "$0")/common.sh"
packages fedoo==1.1.0 ipctk==1.6.1 numpy==2.3.5 scipy==1.16.3

cat > "$folder/slide.py" <<'PYTHON'
from functools import partial

import fedoo as fd
import numpy as np

FRICTION, WAY, EPS_V = 0.5, 0.01, 1e-3  # EPS_V is the default


def ratios(increments):
    """Shear over normal force in all increments of a slide, and of a pause after it."""
    fd.ModelingSpace("2D")
    ground = fd.mesh.rectangle_mesh(2, 2, 0, 4, -1, 0, elm_type="quad4")
    block = fd.mesh.rectangle_mesh(3, 3, 1.5, 2.5, 0.08, 1.08, elm_type="quad4")
    mesh = fd.Mesh.stack(ground, block)
    held = np.flatnonzero(mesh.nodes[:, 1] < 0.01)
    top = np.flatnonzero(mesh.nodes[:, 1] > 1.07)
    contact = fd.constraint.IPCContact(
        mesh,
        surface_mesh=fd.mesh.extract_surface(mesh),
        dhat=0.1,
        dhat_is_relative=False,
        barrier_stiffness=100.0,
        adaptive_barrier_stiffness=False,
        use_area_weighting=True,
        line_search_energy=False,
        friction_coefficient=FRICTION,
        eps_v=EPS_V,
    )
    elastic = fd.constitutivelaw.ElasticIsotrop(1000.0, 0.0)
    solid = fd.Assembly.create(fd.weakform.StressEquilibrium(elastic, nlgeom=False), mesh)
    problem = fd.problem.NonLinear(fd.Assembly.sum(solid, contact))
    problem.set_nr_criterion("Force", tol=1e-6, err0=1.0, max_subiter=200)
    problem.bc.add("Dirichlet", held, "Disp", 0)
    ends = np.linspace(0, 1, 4)  # press, slide, pause
    for axis, way in (("DispX", [0, 0, WAY, WAY]), ("DispY", [0, -0.05, -0.05, -0.05])):
        follow = partial(np.interp, xp=ends, fp=way)
        problem.bc.add("Dirichlet", top, axis, 1.0, time_func=follow)
    seen = []

    def keep(_):
        shear, normal = np.reshape(solid.get_global_vector(), (2, -1))[:, top].sum(axis=1)
        seen.append(abs(shear / normal))

    problem.nlsolve(
        dt=1 / increments,
        tmax=3,
        update_dt=False,
        print_info=0,
        callback=keep,
        exec_callback_at_each_iter=True,
    )
    assert len(seen) == 3 * increments
    return seen[increments : 2 * increments], seen[2 * increments :]


for increments in (10, 40, 160):
    slide, pause = ratios(increments)
    part = min(WAY / increments / EPS_V, 1)
    hand = FRICTION * (2 * part - part**2)
    line = f"{slide[increments // 2]:.3f}, by hand {hand:.3f}, after a pause {pause[-1]:.3f}"
    print(f"{increments} increments: {line}")
PYTHON

"$folder/venv/bin/python" -W ignore "$folder/slide.py" 2> /dev/null | grep increments: | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
10 increments: 0.500, by hand 0.500, after a pause 0.026
40 increments: 0.219, by hand 0.219, after a pause 0.000
160 increments: 0.061, by hand 0.061, after a pause 0.000
OUTPUT
echo "as described"
