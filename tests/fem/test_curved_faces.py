"""Normals at the nodes of curved faces, also at their free ends and rims.

A body that turns about the axis of its face turns freely, whatever the mesh.
"""

import numpy as np
import pytest
from scipy.optimize import linprog
from skfem import MeshHex, MeshQuad

import frictopt as fo

RADII = {"shaft": [0.5, 0.75, 1.0], "hub": [1.0, 1.25, 1.5]}
FACES = {"shaft": ("bore", "contact"), "hub": ("contact", "rim")}


def arc(radii, edges, half=np.pi / 3):
    mesh = MeshQuad.init_tensor(
        np.array(radii), np.linspace(np.pi / 2 - half, np.pi / 2 + half, edges + 1)
    )
    r, angle = mesh.p
    return mesh, np.array([r * np.cos(angle), r * np.sin(angle)])


def extruded_arc(radii, edges, rows=2, taper=0.0, moved=0.0, half=np.pi / 3):
    """An arc with a length.

    Its radii grow along it by a taper, and nodes amid the face are moved along it at random. With
    half = pi it is closed.
    """
    mesh = MeshHex.init_tensor(
        np.array(radii),
        np.linspace(np.pi / 2 - half, np.pi / 2 + half, edges + 1),
        np.linspace(0, 0.5, rows + 1),
    )
    r, angle, z = mesh.p
    inner = (np.abs(angle - np.pi / 2) < half - 1e-9) & (np.abs(z - 0.25) < 0.25 - 1e-9)
    place = np.unique(np.round(mesh.p[1:], 9), axis=1, return_inverse=True)[1].ravel()
    along, up = (
        np.random.default_rng(0).uniform(-moved, moved, size=(2, place.max() + 1))[:, place] * inner
    )
    angle, z = angle + along * 2 * half / edges, z + up * 0.5 / rows
    grown = r * (1 + taper * z)
    points = np.array([grown * np.cos(angle), grown * np.sin(angle), z])
    _, first, number = np.unique(
        np.round(points, 9), axis=1, return_index=True, return_inverse=True
    )
    joined = MeshHex(np.array([r, angle, z])[:, first], number.ravel()[mesh.t])
    return joined, points[:, first]


def cap(radii, edges):
    """A part of a thick sphere, its cells of several sizes."""
    places = np.linspace(-0.5, 0.5, edges + 1)
    mesh = MeshHex.init_tensor(np.array(radii), places + 0.1, places * (1 + 0.3 * places))
    r, u, v = mesh.p
    return mesh, r * np.array([v, np.ones_like(r), u]) / np.sqrt(1 + u**2 + v**2)


def bodies(shape, *size, tetrahedra=False, **options):
    """A shell on a shaft: both bodies with their faces, whose nodes match."""
    found = {}
    for name, radii in RADII.items():
        mesh, points = shape(radii, *size, **options)
        r = mesh.p[0]
        of_nodes = {
            face: np.flatnonzero(np.abs(r - radius) < 1e-9)
            for face, radius in zip(FACES[name], (radii[0], radii[-1]), strict=True)
        }
        whole = type(mesh)(points, mesh.t)
        if tetrahedra:
            whole = whole.to_meshtet()
        outline = whole.boundary_facets()
        sides = {
            face: outline[np.isin(whole.facets[:, outline], nodes).all(axis=0)]
            for face, nodes in of_nodes.items()
        }
        found[name] = fo.fem.Body(whole.with_boundaries(sides))
    return found


def torque():
    return [fo.fem.BodyForce("hub", x=lambda x, y, *_: -y, y=lambda x, *_: x)]


def pressed(shape):
    """A force towards the axis, or to the centre of a sphere."""
    inward = {"x": lambda x, *_: -x, "y": lambda x, y, *_: -y}
    return [
        fo.fem.BodyForce("hub", **inward, **({"z": lambda x, y, z: -z} if shape is cap else {}))
    ]


def moment(system, case):
    """Of the forces of a glued contact about the axis."""
    q, p = system.bonded[case]
    force = np.einsum("nr,nra->na", np.column_stack([q, p]), system.frames)
    x = system.points
    return np.sum(x[:, 0] * force[:, 1] - x[:, 1] * force[:, 0])


SHAPES = [(arc, 3), (arc, 12), (extruded_arc, 6, 1), (extruded_arc, 6, 3), (cap, 3), (cap, 5)]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: f"{shape[0].__name__} {shape[1:]}")
def test_without_friction_no_torque_is_carried(shape):
    loads = {"P": pressed(shape[0]), "T": torque()}
    system = fo.fem.ContactModel(
        bodies(*shape), [fo.fem.Support("shaft", "bore")], loads, [fo.fem.Contact("hub", "shaft")]
    ).condense()
    assert (
        fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"T": 1.0}, {"T": -1.0}]), 0.0).load_factor
        < 1e-9
    )


@pytest.mark.parametrize("edges", [3, 8, 24])
def test_gross_slip_on_an_arc_is_that_of_radial_normals(edges):
    loads = {"P": [fo.fem.BodyForce("hub", y=-1.0)], "T": torque()}
    system = fo.fem.ContactModel(
        bodies(arc, edges),
        [fo.fem.Support("shaft", "bore")],
        loads,
        [fo.fem.Contact("hub", "shaft")],
    ).condense()
    x, n, f = system.points, system.nodes, 0.2
    resultants = {}
    for case, (q, p) in system.bonded.items():
        force = np.einsum("nr,nra->na", np.column_stack([q, p]), system.frames)
        resultants[case] = np.r_[force.sum(axis=0), moment(system, case)]
    tangents = np.column_stack([x[:, 1], -x[:, 0]])
    # All nodes have the radius 1.
    balance = np.vstack([np.hstack([tangents.T, x.T]), np.r_[-np.ones(n), np.zeros(n)]])
    friction = np.vstack(
        [np.hstack([sign * np.eye(n), -f * np.eye(n), np.zeros((n, 1))]) for sign in (1, -1)]
    )
    bounds = [(None, None)] * n + [(0, None)] * (n + 1)
    equations = np.column_stack([balance, -resultants["T"]])
    best = linprog(
        np.r_[np.zeros(2 * n), -1.0], friction, np.zeros(2 * n), equations, resultants["P"], bounds
    )
    found = fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"T": 1.0}, {"T": -1.0}]), f)
    assert found.load_factor == pytest.approx(-best.fun, rel=1e-7)


def normals_along(points):
    """Normals of a block whose lower face goes through some points, at their nodes."""
    mesh = MeshQuad.init_tensor(np.arange(len(points), dtype=float), np.array([0.0, 1.0]))
    low, column = mesh.p[1] == 0, mesh.p[0].astype(int)
    upper = type(mesh)(
        np.where(low, points[column].T, [points[column, 0], np.full(len(low), 3.0)]), mesh.t
    )
    lower = type(mesh)(
        np.where(low, [points[column, 0], np.full(len(low), -3.0)], points[column].T), mesh.t
    )
    facets = [one.boundary_facets() for one in (upper, lower)]
    meshes = []
    for one, outline in zip((upper, lower), facets, strict=True):
        on = [
            np.isin(k, np.flatnonzero(low == (one is upper))).all()
            for k in one.facets[:, outline].T
        ]
        meshes.append(one.with_boundaries({"face": outline[on]}))
    model = fo.fem.ContactModel(
        dict(zip(("upper", "lower"), map(fo.fem.Body, meshes), strict=True)),
        [
            fo.fem.Support("lower", (points[0, 0], -3.0)),
            fo.fem.Support("lower", (points[-1, 0], -3.0)),
        ],
        {"P": [fo.fem.BodyForce("upper", y=-1.0)]},
        [fo.fem.Contact("upper", "lower", "face", "face")],
    )
    system = model.condense()
    return system.normals[np.argsort(system.points[:, 0])]


@pytest.mark.parametrize("angle", [5.0, 15.0, 40.0])
@pytest.mark.parametrize("edges", [1, 2, 4])
def test_a_corner_of_two_flat_faces_is_not_rounded(angle, edges):
    slope = np.tan(np.radians(angle / 2))
    x = np.linspace(-1, 1, 2 * edges + 1)
    normals = normals_along(np.column_stack([x, -slope * np.abs(x)]))
    across = np.array(
        [
            np.sign(x) * np.sin(np.radians(angle / 2)),
            np.where(x == 0, 1.0, np.cos(np.radians(angle / 2))),
        ]
    ).T
    assert np.allclose(normals, across, rtol=0, atol=1e-12)


def test_flat_edges_beside_corners_stay_flat():
    """A chain has three flat faces, 12 degrees apart. The first and the last face have two edges,
    the face between them has one."""
    ways = np.radians([12.0, 12.0, 0.0, -12.0, -12.0])
    points = np.vstack(
        [[0.0, 0.0], np.cumsum(np.column_stack([np.cos(ways), np.sin(ways)]), axis=0)]
    )
    normals = normals_along(points)
    ends = np.array([[-np.sin(ways[0]), np.cos(ways[0])], [-np.sin(ways[-1]), np.cos(ways[-1])]])
    assert np.allclose(normals[[0, 1, -1, -2]], ends[[0, 0, 1, 1]], rtol=0, atol=1e-12)


def test_one_flat_edge_before_a_corner_stays_flat():
    """Beyond the corner a face of three edges is flat, so that nothing bends on."""
    ways = np.radians([12.0, 0.0, 0.0, 0.0])
    points = np.vstack(
        [[0.0, 0.0], np.cumsum(np.column_stack([np.cos(ways), np.sin(ways)]), axis=0)]
    )
    end = [-np.sin(ways[0]), np.cos(ways[0])]
    assert np.allclose(normals_along(points)[[0, -1]], [end, [0.0, 1.0]], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "curve",
    [lambda t: (2 * np.cos(t), np.sin(t)), lambda t: (t, t**2 / 3), lambda t: (t, np.exp(t) / 8)],
)
def test_normals_at_free_ends_converge_with_the_square_of_the_edges(curve):
    def worst(edges):
        t = np.linspace(2.4, 0.7, edges + 1)
        ahead, back = (np.array(curve(t + step)) for step in (1e-6, -1e-6))
        tangent = ((ahead - back) / np.linalg.norm(ahead - back, axis=0)).T
        order = np.argsort(np.array(curve(t))[0])
        normals = normals_along(np.array(curve(t)).T[order])
        return np.abs(np.sum(normals * tangent[order], axis=1))[[0, -1]].max()

    errors = np.array([worst(edges) for edges in (10, 20, 40)])
    assert (errors[:-1] > 3 * errors[1:]).all() and errors[-1] < 0.01


@pytest.mark.parametrize("taper", [0.0, 0.3])
def test_free_triangles_on_a_cylinder_or_a_cone_have_its_normals(taper):
    model = fo.fem.ContactModel(
        bodies(extruded_arc, 8, 4, tetrahedra=True, taper=taper, moved=0.3),
        [fo.fem.Support("shaft", "bore")],
        {"T": torque()},
        [fo.fem.Contact("hub", "shaft")],
    )
    system = model.condense()
    radial = system.points[:, :2] / np.linalg.norm(system.points[:, :2], axis=1)[:, None]
    assert np.allclose(
        system.normals,
        np.column_stack([radial, np.full(system.nodes, -taper)]) / np.hypot(1, taper),
        rtol=0,
        atol=1e-9,
    )


@pytest.mark.parametrize("tetrahedra", [False, True])
def test_beyond_its_friction_a_fit_in_space_slides_off(tetrahedra):
    """Its pressures are self-stress, which statics does not know: contact forces within friction
    balance any torque."""
    parts = bodies(extruded_arc, 12, 2, tetrahedra=tetrahedra, moved=0.3, half=np.pi)
    loads = {"T": torque(), "fit": [fo.fem.Interference("contact", 0.01)]}
    system = fo.fem.ContactModel(
        parts, [fo.fem.Support("shaft", "bore")], loads, [fo.fem.Contact("hub", "shaft")]
    ).condense()
    cycle = fo.LoadCycle({"fit": 1.0}, [{"T": 1.0}, {"T": -1.0}])
    friction = 0.2
    most = friction * system.bonded["fit"][1].sum() / abs(moment(system, "T"))
    slide = fo.gross_slip(system, cycle, friction)
    assert slide.bound == np.inf and slide.load_factor == pytest.approx(most, rel=0.05)
    for factor in (1.2, 4.0):
        with pytest.raises(fo.NoContinuation, match="the body turns as a whole"):
            fo.steady_state(system, cycle, friction, factor * most, steps=2, progress=False)
    assert (
        fo.steady_state(system, cycle, friction, 0.8 * most, steps=2, progress=False).residual
        < 1e-9
    )
