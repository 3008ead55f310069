#!/usr/bin/env bash
# pyHarm's `Penalty3D` has no friction where it has no preload, however strongly it is pressed.
#
# Guess: without preload, N0 = 0, the friction of `Penalty3D` follows the normal force of its gap,
# as that of `DLFT3D` does, which its documentation calls the same element by another method.
# Seen: the normal force of `Penalty3D` is right and its friction is zero. With a preload the
# contact closes towards negative displacements, and without one towards positive ones. The
# friction expects the first, and takes the second for an open contact. `DLFT3D` closes towards
# negative displacements in both cases. So a contact with an initial gap damps nothing, and
# exchanging one element for the other turns it around. Use `DLFT3D` without preload, and then
# mind the side of the gap.
# Versions: pyHarm-os 1.2.2, jax 0.5.3, numba 0.63.1, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: friction coefficient 0.5, no preload, both stiffnesses 1000, and sliding of amplitude
# 0.1. For the normal displacements -0.01 and 0.01 the normal force and the work of friction per
# cycle: "Penalty3D: 0 0.00, 10 0.00" and "DLFT3D: -10 1.90, 0 0.00", then "as described". By hand
# the work for a force of 10 is 1.90.
. "$(dirname "$0")/common.sh"
packages --no-deps pyHarm-os==1.2.2
# What it needs without notebooks.
"$folder/venv/bin/pip" install --quiet click==8.3.1 h5py==3.15.1 jax==0.5.3 jaxlib==0.5.3 \
  numba==0.63.1 numpy==2.3.5 pandas==2.3.3 psutil==7.1.3 pydantic==2.12.5 scipy==1.16.3 \
  tomli-w==1.2.0 2> /dev/null
cd "$folder"

cat > contact.py <<'PYTHON'
import numpy as np
from pyHarm.Maestro import Maestro

AMPLITUDE = 0.1


def cycle(kind, preload, normal):
    """Normal force, and work of friction, as a contact slides at a constant normal displacement."""
    mass = {"matrix": {name: np.eye(3) for name in "MCKG"}, "nnodes": 1, "ndofs": 3}
    law = {"mu": 0.5, "N0": preload, "g": 0.0, "k_n": 1e3, "k_t": 1e3, "eps": 1e3}
    contact = {"type": kind, "connect": {"mass": [0]}, "dirs": [0, 1, 2], **law}
    system = Maestro(
        {
            "system": {"type": "Base", "nh": 1, "nti": 512},
            "substructures": {"mass": mass},
            "connectors": {"contact": contact},
        }
    ).system
    (element,) = [e for e in system.LE if e.flag_nonlinear]
    dofs = system.expl_dofs
    (static,) = dofs.index[(dofs.dof_num == 0) & (dofs.harm == 0)]
    cosine, sine = dofs.index[(dofs.dof_num == 1) & (dofs.harm == 1)]
    x, force = np.zeros(len(dofs)), np.zeros(len(dofs))
    x[static], x[cosine] = normal, AMPLITUDE
    # Elements of the DLFT method also ask for the forces of the linear ones, here zero.
    linear = [np.zeros(len(dofs))] if kind == "DLFT3D" else []
    force[element.indices] = element.evalResidual(x, 1.0, *linear)
    return force[static], np.pi * AMPLITUDE * abs(force[sine])


for kind in ("Penalty3D", "DLFT3D"):
    seen = [cycle(kind, 0.0, normal) for normal in (-0.01, 0.01)]
    print(f"{kind}:", ", ".join(f"{normal:.0f} {work:.2f}" for normal, work in seen))
PYTHON

JAX_PLATFORMS=cpu venv/bin/python contact.py > log 2> errors
grep -E '^(Penalty3D|DLFT3D):' log | tee seen
diff - seen <<'OUTPUT'
Penalty3D: 0 0.00, 10 0.00
DLFT3D: -10 1.90, 0 0.00
OUTPUT
echo "as described"
