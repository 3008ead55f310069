"""Bodies of quadratic elements, straight and curved, for the tests."""

from dataclasses import replace

import numpy as np
from skfem import MeshHex, MeshHex2, MeshQuad, MeshQuad2, MeshTet, MeshTet2, MeshTri, MeshTri2

import frictopt as fo

SECOND = {MeshTri: MeshTri2, MeshQuad: MeshQuad2, MeshTet: MeshTet2, MeshHex: MeshHex2}


def box(kind, *sides, bulge=None, steps=2, linear=False):
    """A box with (low, high) along each axis.

    `bulge` moves all nodes of the quadratic mesh, at corners and between them.
    """
    straight = kind.init_tensor(
        *(
            np.linspace(*side, n + 1)
            for side, n in zip(sides, np.broadcast_to(steps, len(sides)), strict=True)
        )
    )
    named = {
        f"{'xyz'[axis]}{end}": (lambda x, a=axis, c=side[end]: np.isclose(x[a], c))
        for axis, side in enumerate(sides)
        for end in (0, 1)
    }
    straight = straight.with_boundaries(named)
    if linear:
        return straight
    mesh, boundaries = SECOND[kind].from_mesh(straight), straight.boundaries
    return replace(
        mesh, doflocs=mesh.p if bulge is None else bulge(mesh.p.copy()), _boundaries=boundaries
    )


def dimensions(kind):
    return 3 if kind in (MeshTet, MeshHex) else 2


def waves(p):
    """Curve a box 1 wide, between heights 0 and 1 or -1 and 0, except its lower and upper face."""
    p[0] += 0.06 * np.sin(2 * np.pi * p[-1]) * (1 + p[0])
    return p


def two_boxes(kind, material, bulge=waves, turn=None):
    """Two boxes, one on the other, that meet at height 0, turned as a whole."""
    turn = np.eye(dimensions(kind)) if turn is None else turn
    bodies = {}
    for name, low, face, far in (("upper", 0.0, "0", "1"), ("lower", -1.0, "1", "0")):
        mesh = box(kind, *[(0.0, 1.0)] * (dimensions(kind) - 1), (low, low + 1.0), bulge=bulge)
        axis = "xyz"[mesh.dim() - 1]
        contact = mesh.boundaries[axis + face]
        named = {
            "contact": contact,
            "far": mesh.boundaries[axis + far],
            "outline": np.setdiff1d(mesh.boundary_facets(), contact),
        }
        bodies[name] = fo.fem.Body(
            replace(mesh, doflocs=turn @ mesh.p, _boundaries=named), material
        )
    return bodies


def arched(p):
    """Bend the level lines of a box between heights -1 and 1 into arcs, the higher ones less."""
    p[-1] += 0.1 * p[0] ** 2 * (1 - p[-1] ** 2) + 0.08 * p[0] * (1 - p[0]) * (1 - p[-1] ** 2)
    return p
