#!/usr/bin/env bash
# pyHarm's contact elements with a preload rub with the whole preload again once they are open.
#
# Guess: `Penalty3D`, "the classical friction contact element that allows contact separation", and
# `DLFT3D` have no friction while they are open.
# Seen: friction falls with the normal force, as it should, down to zero where the contact opens.
# Just beyond, it jumps back to the friction coefficient times the preload, and stays there
# however wide the contact opens. The normal force does the same: the change since the preloaded
# state falls from the preload to zero. So a blade that lifts off loses neither its damping nor
# its preload. Trust a result of these elements only if none of the contacts opens.
# Versions: pyHarm-os 1.2.2, jax 0.5.3, numba 0.63.1, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: friction coefficient 0.5, preload 10, both stiffnesses 1000 (so that a normal
# displacement of 0.01 opens the contact), and sliding of amplitude 0.1. For the displacements 0,
# 0.005, 0.0099, 0.0101 and 1 the change of the normal force and the work of friction per cycle,
# for both elements: "0 1.90, 5 0.98, 10 0.02, 0 1.90, 0 1.90". By hand the last two are "10
# 0.00". Then "as described".
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
    seen = [cycle(kind, 10.0, normal) for normal in (0.0, 0.005, 0.0099, 0.0101, 1.0)]
    print(f"{kind}:", ", ".join(f"{normal:.0f} {work:.2f}" for normal, work in seen))
PYTHON

JAX_PLATFORMS=cpu venv/bin/python contact.py > log 2> errors
grep -E '^(Penalty3D|DLFT3D):' log | tee seen
diff - seen <<'OUTPUT'
Penalty3D: 0 1.90, 5 0.98, 10 0.02, 0 1.90, 0 1.90
DLFT3D: 0 1.90, 5 0.98, 10 0.02, 0 1.90, 0 1.90
OUTPUT
echo "as described"
