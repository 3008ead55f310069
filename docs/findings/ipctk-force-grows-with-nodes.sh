#!/usr/bin/env bash
# The contact pressure of the IPC Toolkit doubles with each refinement of the mesh.
#
# Guess: the barrier potential stands for a pressure between faces, so that the force between two
# parallel faces at a given distance does not depend on their meshes.
# Seen: each pair of a node and an edge has the same weight, so that the force grows with the number
# of nodes, and the friction with it: the gap, the stiffness and slip of a joint depend on the mesh.
# `NormalCollisions.use_area_weighting`, which is off and called "convergent formulation", weighs
# each pair by its length. The quotient of friction and force is right with both.
# Versions: ipctk 1.6.1, numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: force between a face with 2, 4, 8 and 16 segments of a face and a longer face with
# segments of the same length, divided by the force for 2: "default: 1.0 1.8 3.4 6.6", "with
# weights: 1.0 1.0 1.0 1.0", and "friction: 0.3" for all of them, then "as described".
. "$(dirname "$0")/common.sh"
packages ipctk==1.6.1 numpy==2.3.5
cd "$folder"

cat > faces.py <<'PYTHON'
import ipctk
import numpy as np

GAP, ACTIVE, FRICTION = 0.005, 0.01, 0.3


def force(segments, weighted):
    """Force and shear of a sliding face of length 1, above a face of length 4."""
    below, above = np.linspace(-2, 2, 4 * segments + 1), np.linspace(-0.5, 0.5, segments + 1)
    first = len(below)
    points = np.vstack([np.c_[below, 0 * below], np.c_[above, 0 * above + GAP]])
    edges = [(i + 1, i) for i in range(4 * segments)]
    edges += [(first + i, first + i + 1) for i in range(segments)]
    mesh = ipctk.CollisionMesh(points, np.array(edges), np.zeros((0, 3), int))
    pairs = ipctk.NormalCollisions()
    pairs.use_area_weighting = weighted
    pairs.build(mesh, points, ACTIVE)
    barrier = ipctk.BarrierPotential(ACTIVE, 1.0)
    sliding = ipctk.TangentialCollisions()
    sliding.build(mesh, points, pairs, barrier, FRICTION)
    velocity = np.zeros_like(points)
    velocity[first:, 0] = 1.0
    shear = ipctk.FrictionPotential(1e-4).gradient(sliding, mesh, velocity)
    pressing = barrier.gradient(pairs, mesh, points)
    return -pressing.reshape(-1, 2)[first:, 1].sum(), shear.reshape(-1, 2)[first:, 0].sum()


friction = set()
for name, weighted in (("default", False), ("with weights", True)):
    forces = [force(segments, weighted) for segments in (2, 4, 8, 16)]
    print(f"{name}:", *(f"{pressing / forces[0][0]:.1f}" for pressing, _ in forces))
    friction |= {f"{shear / pressing:.1f}" for pressing, shear in forces}
print("friction:", *friction)
PYTHON

venv/bin/python faces.py | tee seen
diff - seen <<'OUTPUT'
default: 1.0 1.8 3.4 6.6
with weights: 1.0 1.0 1.0 1.0
friction: 0.3
OUTPUT
echo "as described"
