"""Meshes and models of several contacts for the tests, turned by any angle."""

import numpy as np
from scipy.spatial import cKDTree
from skfem import Basis, ElementVector, MeshHex, MeshQuad

import frictopt as fo
from frictopt.fem.elasticity import parts_of
from frictopt.fem.mixed import places_among

RUBBER = fo.fem.Material(2.0, 0.45)
# Thickness of strips of one element.
THICK = 0.7


def rotation(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def turned(mesh, turn):
    """A mesh turned by an angle, or by a matrix."""
    return type(mesh)(
        (rotation(turn) if np.ndim(turn) == 0 else turn) @ mesh.p, mesh.t
    ).with_boundaries(mesh.boundaries)


def box(kind, *lines):
    """A box along the lines of its mesh, with the sides x-, x+, y- and so on.

    The side at height 0 (y in the plane, z in space) is the contact.
    """
    mesh = kind.init_tensor(*(np.asarray(line, dtype=float) for line in lines))
    ends = [
        (f"{'xyz'[k]}{sign}", k, line[end])
        for k, line in enumerate(lines)
        for sign, end in (("-", 0), ("+", -1))
    ]
    named = {
        "contact" if k == len(lines) - 1 and at == 0 else name: (k, at) for name, k, at in ends
    }
    return mesh.with_boundaries(
        {name: lambda x, k=k, at=at: abs(x[k] - at) < 1e-9 for name, (k, at) in named.items()}
    )


def two_blocks(kinds, upper=(5, 6), lower=(4, 3), seed=0):
    """A block 2 wide on another block, with a number of elements across.

    Unless `seed` is None, nodes are moved at random, but the sides stay plane.
    """
    rng, meshes = np.random.default_rng(seed), {}
    for name, kind, cells, heights in (
        ("upper", kinds[0], upper, [0.0, 0.4, 1.0]),
        ("lower", kinds[1], lower, [-1.0, -0.6, 0.0]),
    ):
        mesh = box(kind, *(np.linspace(-1.0, 1.0, n + 1) for n in cells), heights)
        inner = (mesh.p > mesh.p.min(axis=1, keepdims=True)) & (
            mesh.p < mesh.p.max(axis=1, keepdims=True)
        )
        moved = mesh.p + inner * rng.uniform(-0.06, 0.06, mesh.p.shape) * (seed is not None)
        meshes[name] = kind(moved, mesh.t).with_boundaries(mesh.boundaries)
    return meshes


def extruded(mesh):
    """The hexahedra above quadrilaterals, from z = 0 to THICK."""
    (a, b, c, d), n = mesh.t, mesh.p.shape[1]
    points = np.hstack([np.vstack([mesh.p, np.full(n, z)]) for z in (0.0, THICK)])
    return MeshHex(points, np.array([a, n + a, d, b, n + d, n + b, c, n + c]))


def traction(angle, body, boundary, x=0.0, y=0.0):
    return fo.fem.Traction(body, boundary, *(rotation(angle) @ [x, y]))


def ring(radii, elements, inner, outer, start=0.0):
    """Rings of quadrilaterals that begin at an angle.

    The innermost and the outermost circle have names.
    """
    n, angle = elements, start + 2 * np.pi * np.arange(elements) / elements
    points = np.concatenate([r * np.array([np.cos(angle), np.sin(angle)]) for r in radii], axis=1)
    i, j = (index.ravel() for index in np.indices((len(radii) - 1, n)))
    mesh = MeshQuad(
        points,
        np.array([i * n + j, (i + 1) * n + j, (i + 1) * n + (j + 1) % n, i * n + (j + 1) % n]),
    )
    inside = radii[0] * (1 + 1e-9)
    return mesh.with_boundaries(
        {inner: lambda x: np.hypot(*x) < inside, outer: lambda x: np.hypot(*x) > inside}
    )


def trapezium(bottom, top, elements, boundaries):
    """Quadrilaterals between two level segments, each given as (left, right, y).

    There are `elements` across and up, and the four sides have new names.
    """
    s, t = np.linspace(0, 1, elements[0] + 1), np.linspace(0, 1, elements[1] + 1)
    sides = {
        "left": lambda x: x[0] == 0,
        "right": lambda x: x[0] == 1,
        "bottom": lambda x: x[1] == 0,
        "top": lambda x: x[1] == 1,
    }
    mesh = MeshQuad.init_tensor(s, t).with_boundaries(
        {boundaries.get(name, name): where for name, where in sides.items()}
    )
    s, t = mesh.p
    (a, b, low), (c, d, high) = bottom, top
    points = np.array([(1 - t) * (a + s * (b - a)) + t * (c + s * (d - c)), low + t * (high - low)])
    return MeshQuad(points, mesh.t).with_boundaries(mesh.boundaries)


def wedge(angle=0.0, jaws=(4, 6), wedge_up=6, wedge_across=5, loads=None):
    """A wedge between two jaws: three bodies, two contacts.

    The flanks are at 60 degrees to the horizontal, and the whole is turned by `angle`.
    """
    slope = 1 / np.tan(np.pi / 3)
    middle = trapezium(
        (-0.5, 0.5, 0.0),
        (-0.5 - slope, 0.5 + slope, 1.0),
        (wedge_across, wedge_up),
        {"left": "left flank", "right": "right flank"},
    )
    left = trapezium(
        (-2.0, -0.5, 0.0), (-2.0, -0.5 - slope, 1.0), jaws, {"right": "flank", "left": "wall"}
    )
    right = trapezium(
        (0.5, 2.0, 0.0), (0.5 + slope, 2.0, 1.0), jaws, {"left": "flank", "right": "wall"}
    )
    bodies = {"wedge": middle, "left jaw": left, "right jaw": right}
    return fo.fem.ContactModel(
        bodies={name: fo.fem.Body(turned(mesh, angle)) for name, mesh in bodies.items()},
        contacts=[
            fo.fem.Contact("wedge", f"{side} jaw", f"{side} flank", "flank")
            for side in ("left", "right")
        ],
        supports=[fo.fem.Support(f"{side} jaw", "wall") for side in ("left", "right")],
        loads=loads
        or {
            "P": [traction(angle, "wedge", "top", y=-1.0)],
            "Q": [traction(angle, "wedge", "top", x=1.0)],
            "fit": [
                fo.fem.Interference("left flank", 0.01),
                fo.fem.Interference("right flank", 0.02),
            ],
        },
    )


def blocks(kind=MeshQuad, x_punch=None, x_block=None, angle=0.0, material=None, element="linear"):
    """Two blocks, 2 x 1, that meet on y = 0 before the whole is turned by `angle`."""
    x, y = np.array([-1.0, -0.5, 0.1, 1.0]), np.array([0.0, 0.4, 1.0])
    sides = {
        "left": lambda x: x[0] == -1.0,
        "right": lambda x: x[0] == 1.0,
        "contact": lambda x: x[1] == 0.0,
    }
    punch = kind.init_tensor(x if x_punch is None else x_punch, y).with_boundaries(
        {**sides, "top": lambda x: x[1] == 1.0}
    )
    block = kind.init_tensor(x if x_block is None else x_block, -y[::-1]).with_boundaries(
        {**sides, "bottom": lambda x: x[1] == -1.0}
    )
    material = material or fo.fem.Material()
    return {
        name: fo.fem.Body(turned(mesh, angle), material, element)
        for name, mesh in (("punch", punch), ("block", block))
    }


def uniform_loads(angle=0.0):
    """Uniform pressure and uniform shear on two blocks."""
    return {
        "p": [traction(angle, "punch", "top", y=-1.0), traction(angle, "block", "bottom", y=1.0)],
        "tau": [traction(angle, "punch", "top", x=1.0), traction(angle, "block", "bottom", x=-1.0)]
        + [
            traction(angle, body, side, y=sign)
            for body in ("punch", "block")
            for side, sign in (("right", 1.0), ("left", -1.0))
        ],
    }


def hung(angle=0.0):
    """Supports of the block of two blocks that leave it free to strain.

    They hold a corner, and one direction of another corner.
    """
    left, right = (
        tuple(float(value) for value in rotation(angle) @ [x, -1.0]) for x in (-1.0, 1.0)
    )
    return [
        fo.fem.Support("block", left, "xy"),
        fo.fem.Support("block", right, "y" if abs(np.cos(angle)) > 0.5 else "x"),
    ]


def column(**options):
    """Two cubes, one on the other, of material without lateral strain."""
    x = np.array([0.0, 0.5, 1.0])
    parts = MeshHex.init_tensor(x, x, np.r_[x - 1, x[1:]]).with_boundaries(
        {"top": lambda x: x[2] == 1, "bottom": lambda x: x[2] == -1}
    )
    parts = parts.with_subdomains({"a": lambda x: x[2] > 0, "b": lambda x: x[2] < 0})
    bodies = fo.fem.split_bodies(
        parts, {"a": fo.fem.Material(nu=0.0), "b": fo.fem.Material(nu=0.0)}
    )
    return fo.fem.ContactModel(
        **{
            "bodies": bodies,
            "supports": [fo.fem.Support("b", "bottom")],
            "contacts": [fo.fem.Contact("a", "b", "b", "a")],
        }
        | options
    )


def matrices_of(model):
    """The arguments of `condense` for a model whose faces match.

    Each pair has the nodes of both bodies.
    """
    parts, opening = model._assembly, model._assembly.glued.interface.opening.sorted_indices()
    others = [int(row.indices[row.data < 0][0]) for row in opening]
    return {
        "K": parts.glued.K,
        "loads": dict(zip(model.loads, model._cases[0].T, strict=True)),
        "pairs": np.column_stack([parts.glued.interface.nodes, others]),
        "normals": parts.glued.interface.frames[:, -1],
        "unknowns": parts.free_rows,
        "points": parts.points,
        "held": parts.rows[parts.free_rows == -1],
        "contact": [parts.names[number] for number in parts.contact],
    }


def vector_field(mesh, displacement):
    """The vector basis of a mesh in scikit-fem, and its degrees of freedom (d, nodes)."""
    basis = Basis(mesh, ElementVector(mesh.elem()))
    u, own = np.zeros(basis.N), mesh.dofs.element_dofs
    for axis, component in enumerate(displacement):
        u[basis.element_dofs[axis :: mesh.dim()]] = component[own]
    return basis, u


def around(mesh, count, turn):
    """A ring of copies of the mesh of a sector, each turned by a matrix from the copy before.

    Nodes on the cuts are joined, and so are names.
    """
    n, corners = mesh.nvertices, mesh.p[:, : mesh.nvertices]
    points = np.hstack([np.linalg.matrix_power(turn, k) @ corners for k in range(count)])
    pairs = cKDTree(points.T).query_pairs(1e-9, output_type="ndarray").T
    _, first, joined = np.unique(
        parts_of(pairs, points.shape[1]), return_index=True, return_inverse=True
    )
    whole = type(mesh)(points[:, first], joined[np.hstack([mesh.t + k * n for k in range(count)])])
    names = {}
    for name, facets in mesh.boundaries.items():
        corners = np.hstack([mesh.facets[:, facets] + k * n for k in range(count)])
        found = places_among(joined[corners].T, whole.facets.T)
        names[name] = found[whole.f2t[1, found] < 0]
    return whole.with_boundaries(
        {name: np.unique(facets) for name, facets in names.items() if len(facets)}
    )
