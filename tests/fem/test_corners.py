"""Corners at which three bodies meet, in the plane and in space.

They are compared with uniform stress, and with glued bodies by dense algebra.
"""

import re
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from skfem import (
    Basis,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshHex,
    MeshQuad,
    MeshTet,
    MeshTri,
    condense,
    solve,
)
from skfem.models.elasticity import linear_elasticity

import frictopt as fo
from helpers import quadratic
from helpers.meshes import matrices_of
from helpers.multipliers import glued_pairs
from helpers.quadratic import dimensions
from helpers.spatial import vectors

KINDS = [MeshQuad, MeshTri, MeshHex, MeshTet]
SHIMS = {"left": (0.0, 1.0, 0.0, 0.75), "right": (1.0, 2.0, 0.0, 0.75)}
PLATES = {"below": (0.0, 2.0, -0.5, 0.0), "above": (0.0, 2.0, 0.75, 1.25)}
JOINTS = [
    (shim, plate, *sides)
    for plate, sides in (("below", ("y0", "y1")), ("above", ("y1", "y0")))
    for shim in SHIMS
]
JOINTS.append(("left", "right", "x1", "x0"))


def box(kind, x0, x1, y0, y1, across, up=3):
    """A box with sides x0, x1, y0 and y1 in the plane, or of the depth 0 .. 1 in space."""
    sides = [(x0, x1), (y0, y1), (0.0, 1.0)][: dimensions(kind)]
    return quadratic.box(kind, *sides, steps=[across, up, 3][: len(sides)], linear=True)


def shims(kind, plate=4, element=None, up=3, contacts=None):
    """Two shims side by side between two plates.

    They are free to strain under P across the plates and S along them.
    """
    meshes = {name: box(kind, *sizes, 2, up) for name, sizes in SHIMS.items()} | {
        name: box(kind, *sizes, plate) for name, sizes in PLATES.items()
    }
    bodies = {
        name: fo.fem.Body(mesh, fo.fem.Material(2.0, 0.3), element) for name, mesh in meshes.items()
    }
    supports = [fo.fem.Support("below", f"{axis}0", axis) for axis in "yxz"[: kind().dim()]]
    squeeze = [
        (body, side, sign)
        for body in bodies
        for side, sign in (("x0", 1.0), ("x1", -1.0))
        if side in outer(body)
    ]
    loads = {
        "P": [fo.fem.Traction("above", "y1", y=-1.0)],
        "S": [fo.fem.Traction(body, side, x=sign) for body, side, sign in squeeze],
    }
    joints = contacts or [fo.fem.Contact(*joint, name=f"{joint[0]} {joint[1]}") for joint in JOINTS]
    return fo.fem.ContactModel(bodies, supports, loads, joints)


def outer(body):
    return {"left": ["x0"], "right": ["x1"]}.get(body, ["x0", "x1"])


OFTEN = [(MeshQuad, "linear"), (MeshQuad, "quadratic"), (MeshHex, "linear"), (MeshTet, "quadratic")]


@pytest.mark.parametrize(
    ("kind", "element", "plate"),
    [
        *((*one, 4) for one in product(KINDS, ["linear", "quadratic"])),
        *((*one, n) for one in OFTEN for n in (3, 5, 8)),
    ],
)
def test_uniform_stresses_pass_through_by_superposition(kind, element, plate):
    """P presses only the level faces, and S only the upright face. At the corner of the shims
    plates of 3 or 5 elements have no node."""
    system = shims(kind, plate, element).condense()
    d = 2 if kind in (MeshQuad, MeshTri) else 3
    level = np.abs(system.normals[:, 1]) > 0.5
    for load, pressed, area in (("P", level, 4.0), ("S", ~level, 0.75)):
        q, p = system.reaction({load: 1.0})
        assert np.abs(q).max() < 1e-12
        assert np.abs(p[~pressed]).max() < 1e-12
        assert p.sum() == pytest.approx(area, rel=1e-12)
        if d == 2 or plate != 4:
            assert p[pressed] == pytest.approx(system.width[pressed], rel=1e-12)
    # Two of four rows of nodes are corners of the level faces.
    assert (~level).sum() == (2 if d == 2 else 8)


def test_the_first_contact_of_the_list_has_the_corner():
    """In either order the reactions balance a lateral load on the shims; the means belong to the
    last contact."""
    order = [JOINTS[i] for i in (4, 0, 1, 2, 3)]
    model = shims(
        MeshQuad, contacts=[fo.fem.Contact(*joint, name=" ".join(joint[:2])) for joint in order]
    )
    counts = (
        "{'left right': 4, 'left below': 3, 'right below': 2, 'left above': 3, 'right above': 2}"
    )
    assert f"contacts={counts}" in repr(model)
    system = model.condense()
    _, p = system.reaction({"P": 1.0})
    assert p[np.abs(system.normals[:, 1]) > 0.5].sum() == pytest.approx(4.0)
    assert np.ptp(system.width[4:]) > 0


def test_a_face_that_is_all_corners_is_refused():
    with pytest.raises(
        fo.ModelError,
        match=re.escape(
            "all nodes of 'left right' are corners of contacts that are listed before it; mesh it"
        ),
    ):
        shims(MeshQuad, up=1)


@pytest.mark.parametrize(("floor", "arch"), [(4, 0.0), (5, 0.0), (4, 0.8)])
@pytest.mark.parametrize("kind", KINDS)
def test_a_face_with_two_names_is_one_face(kind, floor, arch):
    """It is on a floor whose nodes match or not, and is bent to an arch."""
    systems = []
    for names in ({"face": (0.0, 1.0)}, {"left": (0.0, 0.5), "right": (0.5, 1.0)}):
        faces = {
            name: (lambda x, a=a, b=b: np.isclose(x[1], 0) & (a < x[0]) & (x[0] < b))
            for name, (a, b) in names.items()
        }
        meshes = [box(kind, 0, 1, 0, 1, 4).with_boundaries(faces), box(kind, 0, 1, -1, 0, floor)]
        bent = [
            replace(
                mesh,
                doflocs=mesh.p
                + arch * np.outer(np.arange(len(mesh.p)) == 1, mesh.p[0] * (1 - mesh.p[0])),
            )
            for mesh in meshes
        ]
        contacts = [fo.fem.Contact("block", "floor", name, "y1") for name in faces]
        loads = {"P": [fo.fem.Traction("block", "y1", x=0.3, y=-1.0)]}
        bodies = dict(zip(("block", "floor"), map(fo.fem.Body, bent), strict=True))
        systems.append(
            fo.fem.ContactModel(bodies, [fo.fem.Support("floor", "y0")], loads, contacts).condense()
        )
    one, two = systems
    order = [np.linalg.norm(two.points - point, axis=1).argmin() for point in one.points]
    rows = (np.array(order) + one.nodes * np.arange(one.tangents + 1)[:, None]).ravel()
    assert one.nodes == two.nodes
    assert len(set(two.contact)) == 2
    assert np.allclose(two.width[order], one.width, rtol=1e-12)
    assert np.allclose(two.frames[order], one.frames, rtol=0, atol=1e-12)
    assert np.allclose(two.S[np.ix_(rows, rows)], one.S, rtol=0, atol=1e-10 * np.abs(one.S).max())
    assert np.allclose(vectors(two)["P"][rows], vectors(one)["P"], rtol=0, atol=1e-10)


def corner_block():
    """A block that stands on a floor and leans on a wall, two bodies that meet in a point."""
    bodies = {
        "block": fo.fem.Body(box(MeshQuad, 0, 1, 0, 1, 2, 2)),
        "floor": fo.fem.Body(box(MeshQuad, 0, 1, -1, 0, 2, 2)),
        "wall": fo.fem.Body(box(MeshQuad, -1, 0, 0, 1, 2, 2)),
    }
    contacts = [
        fo.fem.Contact("block", "floor", "y0", "y1"),
        fo.fem.Contact("block", "wall", "x0", "x1"),
    ]
    supports = [fo.fem.Support("floor", "y0"), fo.fem.Support("wall", "x0")]
    loads = {
        "P": [fo.fem.Traction("block", "y1", y=-1.0)],
        "Q": [fo.fem.Traction("block", "x1", x=-1.0)],
    }
    return bodies, supports, loads, contacts


def test_a_corner_is_in_both_contacts_of_bodies_that_do_not_meet_otherwise():
    model = fo.fem.ContactModel(*corner_block())
    system = model.condense()
    assert system.nodes == 6 and (np.linalg.norm(system.points, axis=1) < 1e-9).sum() == 2
    frames = system.frames
    S = glued_pairs(
        model,
        ("floor", 1, -1),
        ("wall", 0, -1),
        others=np.where(frames[:, 1, 1] > 0.5, "floor", "wall").tolist(),
    )
    assert np.allclose(system.S, S, rtol=0, atol=1e-9 * np.abs(S).max())
    for load, axis in (("P", 1), ("Q", 0)):
        q, p = system.reaction({load: 1.0})
        on_block = (q[:, None] * frames[:, 0] + p[:, None] * frames[:, 1]).sum(axis=0)
        assert on_block == pytest.approx(np.eye(2)[axis], abs=1e-12)
    v = np.random.default_rng(2).normal(size=6)
    fields = model.recover({"P": 1.0}, v, None)
    q, p = system.reaction({"P": 1.0})
    assert np.allclose(fields.q, q + system.A @ v, atol=1e-9)
    assert np.allclose(fields.p, p + system.B @ v, atol=1e-9)


@pytest.mark.parametrize("exchanged", [(), (0,), (1,), (0, 1)])
@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
@pytest.mark.parametrize("kind", [MeshQuad, MeshHex])
def test_a_held_block_in_a_notch_is_glued_as_one_body_whichever_body_is_the_first(
    kind, order, exchanged
):
    """Two faces of two bodies meet at a corner, each with either body as body 1. The displacements
    are those of one mesh without a contact. Next to the corner all nodes of the block are held,
    except the nodes of its faces, and most of the seat lies behind the floor."""
    steps = [np.array([0.0, 1.0, 1.2]), np.array([0.0, 0.2, 1.2]), np.array([0.0, 0.5])]
    whole = kind.init_tensor(*steps[: 2 if kind is MeshQuad else 3])
    x, y = whole.p[:2, whole.t].mean(axis=1)
    block = (x < 1.0) & (y < 0.2)
    sides = {
        "wall": lambda x: np.isclose(x[0], 1.0) & (x[1] <= 0.2),
        "floor": lambda x: np.isclose(x[1], 0.2) & (x[0] <= 1.0),
        "top": lambda x: np.isclose(x[1], 1.2),
        "end": lambda x: np.isclose(x[0], 0.0),
    }
    parts = {"block": block, "seat": ~block}
    bodies = {
        name: fo.fem.Body(whole.restrict(np.flatnonzero(part)).with_boundaries(sides))
        for name, part in parts.items()
    }
    pairs = [("seat", "block") if i in exchanged else ("block", "seat") for i in range(2)]
    contacts = [fo.fem.Contact(*pairs[i], *2 * [("wall", "floor")[i]]) for i in order]
    model = fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("block", "end")],
        {"P": [fo.fem.Traction("seat", "top", x=1.0, y=-2.0)]},
        contacts,
    )
    fields = model.recover({"P": 1.0}, np.zeros(model.condense().slip_shape))
    element = ElementVector(whole.elem())
    basis = Basis(whole, element)
    held = whole.p[:, (whole.p[0] == 0) & (whole.p[1] <= 0.2)]
    loaded = FacetBasis(
        whole, element, facets=whole.facets_satisfying(sides["top"], boundaries_only=True)
    )
    F = LinearForm(lambda v, w: v[0] - 2 * v[1]).assemble(loaded)
    K = linear_elasticity(*fo.fem.Material().lame).assemble(basis)
    u = solve(*condense(K, F, D=basis.nodal_dofs[:, nodes_at(whole, held)].ravel()))
    for name, body in bodies.items():
        found = u[basis.nodal_dofs[:, nodes_at(whole, body.mesh.p)]]
        assert np.allclose(fields.displacement[name], found, rtol=0, atol=1e-10 * np.abs(u).max())
    arguments = matrices_of(model)
    assert fo.condense(**arguments).compliance[0, 0] == pytest.approx(F @ u, rel=1e-10)
    with pytest.raises(fo.ModelError, match="does not point from body 2 into body 1"):
        fo.condense(**{**arguments, "pairs": arguments["pairs"][:, ::-1]})


def nodes_at(mesh, points):
    return [np.linalg.norm(mesh.p - point[:, None], axis=0).argmin() for point in points.T]


def cracked(kind, material, off=0.0, **traction):
    """A plate with a crack from its side, and the number of nodes of a lip.

    The lips have no node at the tip. The lower nodes are moved along the crack by a given distance.
    """
    whole = box(kind, -1.0, 1.0, -1.0, 1.0, 4, 4)
    lower = np.flatnonzero((whole.p[1] == 0) & (whole.p[0] < 0.25))
    copies = np.arange(whole.p.shape[1])
    copies[lower] = len(copies) + np.arange(len(lower))
    points = np.hstack([whole.p, whole.p[:, lower]])
    above = whole.p[1, whole.t].mean(axis=0) > 0
    points[0, lower] += off * (points[0, lower] > -1)
    mesh = kind(points, np.where(above, copies[whole.t], whole.t))
    outline = mesh.boundary_facets()
    lips = (mesh.p[1, mesh.facets[:, outline]] == 0).all(axis=0)
    above = mesh.p[1, mesh.t[:, mesh.f2t[0, outline]]].mean(axis=0) > 0
    ends = {"y0": lambda x: x[1] == -1, "y1": lambda x: x[1] == 1}
    mesh = mesh.with_boundaries(
        {"above": outline[lips & above], "below": outline[lips & ~above], **ends}
    )
    loads = {"P": [fo.fem.Traction("plate", "y1", **traction)]}
    contact = fo.fem.Contact("plate", "plate", "above", "below")
    return (
        fo.fem.ContactModel(
            {"plate": fo.fem.Body(mesh, material)},
            [fo.fem.Support("plate", "y0")],
            loads,
            [contact],
        ),
        len(lower),
    )


@pytest.mark.parametrize("off", [1e-7, 1e-4, 0.1])
@pytest.mark.parametrize("kind", KINDS)
def test_a_uniform_pressure_passes_through_a_crack_the_lips_of_which_do_not_match(kind, off):
    model, count = cracked(kind, fo.fem.Material(nu=0.0), off, y=-1.0)
    system = model.condense()
    assert system.nodes == count
    assert np.allclose(system.bonded["P"][1], system.width, rtol=1e-10)
    assert np.abs(system.bonded["P"][0]).max() < 1e-10
