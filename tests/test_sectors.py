"""Sectors of rings against the whole, made of turned copies of their meshes; cut faces that do not match; and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import special_ortho_group
from skfem import MeshQuad, MeshTet, MeshTri

import frictopt as fo
from frictopt.fem.paraview import contact_face
from meshes import around, extruded, turned

STEEL, ALLOY = fo.Material(E=2.0, nu=0.3, density=0.5), fo.Material(E=0.7, nu=0.2, density=0.2)
FRICTION = 0.2
FILES = Path(__file__).parent.parent / "docs" / "tutorial"


def cuts(count):
    """Where the two cut faces of a sector of the plane lie."""
    a = 2 * np.pi / count
    return {
        "low": lambda x: (abs(x[1]) < 1e-9) & (x[0] > 0),
        "high": lambda x: (abs(x[0] * np.sin(a) - x[1] * np.cos(a)) < 1e-9) & (x[0] * np.cos(a) + x[1] * np.sin(a) > 0),
    }


def circles(faces, count, cells):
    """Where the facets of circles, name -> radius, have their middles, so many in a sector: between the chord and the circle."""
    half = np.cos(np.pi / count / cells)
    return {name: lambda x, r=r: (np.hypot(*x[:2]) > r * half - 1e-9) & (np.hypot(*x[:2]) < r) for name, r in faces.items()}


def polar(kind, radii, count, cells, faces):
    """A sector of a ring, of so many elements around, with its cut faces and circles of these names."""
    grid = kind.init_tensor(np.array(radii), np.linspace(0, 2 * np.pi / count, cells + 1))
    mesh = kind(grid.p[0] * np.array([np.cos(grid.p[1]), np.sin(grid.p[1])]), grid.t)
    return mesh.with_boundaries(cuts(count) | circles(faces, count, cells))


def joined(sectors, count, whole, turn, centre, axis, supports, loads, element="linear", **more):
    """A model of bodies, name -> mesh of a sector about z and the origin: of one sector, or the whole ring; turned by a matrix and moved."""
    d = len(turn)
    step = Rotation.from_rotvec([0, 0, 2 * np.pi / count]).as_matrix()[:d, :d]
    bodies = {}
    for (name, mesh), material in zip(sectors.items(), (STEEL, ALLOY), strict=True):
        own = around(mesh, count, step) if whole else mesh
        bodies[name] = fo.Body(type(own)(turn @ own.p + np.array(centre)[:, None], own.t).with_boundaries(own.boundaries), material, element)
    tied = [] if whole else [fo.Cyclic(name, "low", "high", axis, centre) for name in sectors]
    return fo.ContactModel(bodies, [*supports, *tied], loads, [fo.Contact(*sectors, "contact", "contact")], **more)


def waves(count, turn, centre, body, face):
    """Tractions along the radius and around the axis that repeat from sector to sector of a ring, which is turned and moved."""

    def traction(axis):
        def along(*x):
            own = np.tensordot(turn.T, np.array(x) - np.reshape(centre, (-1, *[1] * np.ndim(x[0]))), 1)
            radius, angle = np.hypot(*own[:2]), count * np.arctan2(own[1], own[0])
            push, drag = 0.02 * np.cos(angle - 0.7), 0.01 * np.cos(angle - 0.2)
            forces = (push * own[0] - drag * own[1]) / radius, (push * own[1] + drag * own[0]) / radius, *[0 * radius] * (len(turn) - 2)
            return np.tensordot(turn, np.array(forces), 1)[axis]

        return along

    return [fo.Traction(body, face, **{"xyz"[axis]: traction(axis) for axis in range(len(turn))})]


def ring_model(count, whole, element="linear", centre=(0.3, -0.2), turn=None):
    turn = np.eye(2) if turn is None else turn
    sectors = {
        "shaft": polar(MeshQuad, [0.4, 0.7, 1.0], count, 6, {"bore": 0.4, "contact": 1.0}),
        "hub": polar(MeshQuad, [1.0, 1.3, 1.8], count, 6, {"contact": 1.0, "outside": 1.8}),
    }
    loads = {"fit": [fo.Interference("contact", 0.02)], "waves": waves(count, turn, centre, "hub", "outside")}
    loads["squeeze"] = [fo.Pressure("hub", "outside", 0.02), fo.Expansion("shaft", 0.001)]
    return joined(sectors, count, whole, turn, centre, (0, 0, 1), [fo.Support("shaft", "bore")], loads, element)


def compared(one, part, count, cycle, load_factor=1.5, **steps):
    """Compare the condensed whole with the sector: stiffness under its loads, limit, steady state; forces at each node, on the seam too."""
    whole, system = one.condense(), part.condense()
    same = np.array([np.linalg.norm(whole.points - point, axis=1).argmin() for point in system.points])
    assert whole.nodes == count * system.nodes and np.allclose(whole.points[same], system.points, atol=1e-9)
    assert np.allclose(whole.normals[same], system.normals, atol=1e-9) and np.allclose(whole.width[same], system.width, rtol=1e-9)
    assert count * system.width.sum() == pytest.approx(whole.width.sum(), rel=1e-9)
    assert np.allclose(count * system.compliance, whole.compliance, rtol=0, atol=1e-9 * np.abs(whole.compliance).max())
    for name, pair in system.bonded.items():
        for own, other in zip(pair, whole.bonded[name], strict=True):
            assert np.allclose(own, other[same], rtol=0, atol=1e-9 * np.abs(whole.bonded[name][1]).max())
    limits = [fo.shakedown_limit(each, cycle, FRICTION).load_factor for each in (whole, system)]
    assert limits[0] == pytest.approx(limits[1], rel=1e-8)
    gross = [fo.gross_slip(each, cycle, FRICTION).load_factor for each in (whole, system)]
    assert gross[0] == pytest.approx(gross[1], rel=1e-8)
    steady = [fo.steady_state(each, cycle, FRICTION, load_factor * limits[0], **steps) for each in (whole, system)]
    assert steady[0].dissipation > 0 and steady[0].dissipation == pytest.approx(count * steady[1].dissipation, rel=1e-9)
    assert np.allclose(steady[1].slip, steady[0].slip[same], rtol=0, atol=1e-9 * np.abs(steady[0].slip).max())
    last = [one.states().p[-1] for one in steady]
    assert np.allclose(last[1], last[0][same], rtol=0, atol=1e-9 * np.abs(last[0]).max())
    return steady, same


CYCLE = fo.LoadCycle({"fit": 1.0}, [{"waves": 1.0, "squeeze": 0.3}, {"waves": -1.0}])


@pytest.mark.parametrize(("count", "element"), [(2, "linear"), (3, "linear"), (3, "quadratic"), (5, "linear")])
def test_a_sector_of_the_plane_has_the_answers_of_the_whole(count, element):
    compared(*(ring_model(count, whole, element) for whole in (True, False)), count, CYCLE)


SPACE = special_ortho_group(3, seed=4).rvs()


def thick_model(count, whole, element="linear"):
    """Rings in space about an oblique axis, which slide on each other along it and around it; one is held along the normals of its bore."""
    sectors = {}
    for name, radii, faces in (("bush", [0.6, 0.8, 1.0], {"bore": 0.6, "contact": 1.0}), ("hub", [1.0, 1.4], {"contact": 1.0, "outside": 1.4})):
        flat = polar(MeshQuad, radii, count, 3, faces)
        sectors[name] = extruded(flat).with_boundaries(cuts(count) | circles(faces, count, 3) | {"end": lambda x: x[2] == 0})
    centre = (0.5, -0.1, 0.3)
    loads = {"fit": [fo.Interference("contact", 0.05)], "waves": waves(count, SPACE, centre, "hub", "outside")}
    along = dict(zip("xyz", 0.01 * SPACE[:, 2], strict=True))
    loads["squeeze"] = [fo.Traction("hub", "outside", **along), fo.Pressure("hub", "outside", 0.03)]
    supports = [fo.Support("bush", "bore", normal=True), fo.Support("bush", "end")]
    return joined(sectors, count, whole, SPACE, centre, tuple(2 * SPACE[:, 2]), supports, loads, element)


@pytest.mark.parametrize(("count", "element"), [(3, "linear"), (4, "quadratic")])
def test_a_sector_in_space_has_the_answers_of_the_whole(count, element):
    one, part = (thick_model(count, whole, element) for whole in (True, False))
    compared(one, part, count, CYCLE, steps=4)


def test_fields_and_pictures_of_a_sector_are_those_of_the_whole():
    one, part = (thick_model(3, whole) for whole in (True, False))
    steady, same = compared(one, part, 3, CYCLE, steps=4)
    whole, own = (model.recover(state) for model, state in zip((one, part), steady, strict=True))
    for name, u in own.displacement.items():
        near = [np.linalg.norm(one.bodies[name].mesh.p.T - point, axis=1).argmin() for point in part.bodies[name].mesh.p.T]
        assert np.allclose(u, whole.displacement[name][:, near], rtol=0, atol=1e-9 * np.abs(u).max())
    faces = [contact_face(model, fields, {}) for model, fields in ((one, whole), (part, own))]
    near = [np.linalg.norm(faces[0].points - point, axis=1).argmin() for point in faces[1].points]
    assert len(faces[1].points) == len(same) + 2  # those on the other cut are drawn, too
    for name, values in faces[1].point_data.items():
        assert np.allclose(values, faces[0].point_data[name][near], rtol=0, atol=1e-9 * max(np.abs(values).max(), 1e-3)), name


@pytest.mark.parametrize("count", [3, 4])
def test_modes_of_a_sector_are_those_of_the_whole_that_repeat(count):
    one, part = (thick_model(count, whole) for whole in (True, False))
    modes, found = part.modes(4), one.modes(25)
    same = [int(np.abs(found.frequency - frequency).argmin()) for frequency in modes.frequency]
    assert np.allclose(found.frequency[same], modes.frequency, rtol=1e-9) and same[:2] == [0, 5]  # four between them do not repeat
    assert np.allclose(count * modes.effective_mass, found.effective_mass[same], rtol=0, atol=1e-8 * found.mass)
    assert count * modes.mass == pytest.approx(found.mass) and modes.effective_mass.max() > 0.1 * modes.mass


def repeated(whole, system, count, turn):
    """The matrix of the slips and gaps of the whole, direction by direction, by those of a sector, turned again and again."""
    T = np.zeros((len(whole.S), len(system.S)))
    for k in range(count):
        step = np.linalg.matrix_power(turn, k)
        to = [int(np.linalg.norm(whole.points - step @ point, axis=1).argmin()) for point in system.points]
        ways = np.einsum("nia,ab,njb->nij", whole.frames[to], step, system.frames)
        for i, j in np.ndindex(*ways.shape[1:]):
            T[i * whole.nodes + np.array(to), j * system.nodes + np.arange(system.nodes)] = ways[:, i, j]
    return T


def flange(whole):
    """The flange of the tutorial with its four bolts, the whole or a quarter, twisted and pulled."""
    steel, turn = fo.Material(210e3, 0.3), Rotation.from_rotvec([0, 0, np.pi / 2]).as_matrix().round()
    parts = fo.split_bodies(fo.read_mesh(FILES / "flange.msh"), dict.fromkeys(("upper", "lower", "bolt"), steel))
    bodies, bolts = {name: parts[name] for name in ("upper", "lower")}, {"bolt": parts["bolt"]}
    supports = [fo.Support("lower", "bottom")]
    if whole:
        bodies = {name: fo.Body(around(body.mesh, 4, turn), steel) for name, body in bodies.items()}
        bolts = {f"bolt {k}": fo.Body(turned(parts["bolt"].mesh, np.linalg.matrix_power(turn, k)), steel) for k in range(4)}
    else:
        supports += [fo.Cyclic(name, "low", "high") for name in bodies]
    contacts = [fo.Contact("upper", "lower", "lower", "upper", name="flange")]
    contacts += [fo.Contact(bolt, side, side, "bolt", name=f"{bolt} {side}") for bolt in bolts for side in bodies]
    loads = {
        "bolts": [fo.BoltPreload(bolt, "section", 25e3) for bolt in bolts],
        "pull": [fo.Traction("upper", "top", z=1.0)],
        "twist": [fo.Traction("upper", "top", x=lambda x, y, z: -y / 33, y=lambda x, y, z: x / 33)],
    }
    return fo.ContactModel(bodies | bolts, supports, loads, contacts), turn


def test_a_quarter_of_a_flange_of_four_bolts_has_the_answers_of_the_whole():
    (one, turn), (part, _) = flange(True), flange(False)
    whole, system = one.condense(), part.condense()
    T = repeated(whole, system, 4, turn)
    assert np.allclose(T.T @ T, 4 * np.eye(len(system.S)), atol=1e-12) and (whole.nodes, system.nodes) == (564, 141)
    assert np.allclose(T.T @ whole.S @ T, 4 * system.S, rtol=0, atol=1e-9 * np.abs(system.S).max())
    assert np.allclose(4 * system.compliance, whole.compliance, rtol=0, atol=1e-9 * np.abs(whole.compliance).max())
    for name, reactions in system.bonded.items():
        r, s = (np.concatenate([pair[0].T, pair[1][None]]).ravel() for pair in (whole.bonded[name], reactions))
        assert np.allclose(r, T @ s, rtol=0, atol=1e-9 * np.abs(r).max())
    same = np.abs(T[-whole.nodes :, -system.nodes :]).argmax(axis=1)
    assert np.allclose(whole.width, system.width[same], rtol=1e-9) and (system.contact == "flange").sum() == 93
    cycle = fo.LoadCycle({"bolts": 1.0, "pull": 0.5}, [{"twist": 1.0}, {"twist": -1.0}])
    states = [fo.march(each, cycle, 0.15, load_factor=20.0, cycles=1, steps=1) for each in (whole, system)]
    assert states[0].work[-1].sum() > 0 and states[0].work[-1].sum() == pytest.approx(4 * states[1].work[-1].sum(), rel=1e-9)
    opened = states[1].gap[-1] > 0
    limits = [fo.shakedown_limit(each, cycle, 0.15, open=nodes).load_factor for each, nodes in ((whole, opened[same]), (system, opened))]
    assert opened.any() and limits[0] > 0 and limits[0] == pytest.approx(limits[1], rel=1e-7)


def standing(mesh, height):
    """The tetrahedra above triangles; those of turned copies of a face are turned copies."""
    n, (a, b, c) = mesh.p.shape[1], np.sort(mesh.t, axis=0)
    points = np.hstack([np.vstack([mesh.p, np.full(n, z)]) for z in (0.0, height)])
    return MeshTet(points, np.hstack([[a, b, c, c + n], [a, b, b + n, c + n], [a, a + n, b + n, c + n]]))


def discs(count, cells, height):
    """Sectors of a disc, which reaches the axis, and of a ring around it, or of cylinders of that height."""
    rim, hub = (polar(MeshTri, radii, count, cells, {}) for radii in ([0.3, 0.7, 1.0], [1.0, 1.3, 1.8]))
    inner = np.flatnonzero(np.hypot(*rim.p) < 0.31)
    core = np.array([inner[:-1], inner[1:], np.full(cells, rim.p.shape[1])])
    shaft = MeshTri(np.hstack([rim.p, np.zeros((2, 1))]), np.hstack([rim.t, core]))
    faces = cuts(count) | circles({"contact": 1.0, "outside": 1.8}, count, cells) | {"end": lambda x: x[-1] == 0.0}
    return {name: (standing(mesh, height) if height else mesh).with_boundaries(faces) for name, mesh in (("shaft", shaft), ("hub", hub))}


@pytest.mark.parametrize(("height", "turn"), [(0.0, np.eye(2)), (0.5, np.eye(3)), (0.5, SPACE)])
def test_a_sector_may_reach_the_axis(height, turn):
    centre, axis = (0.2, 0.1, -0.4)[: len(turn)], tuple(turn[:, 2]) if height else (0, 0, 1)
    loads = {"fit": [fo.Interference("contact", 0.02)], "waves": waves(4, turn, centre, "hub", "outside"), "squeeze": [fo.Expansion("shaft", 0.01)]}
    if height:
        loads["squeeze"] = [fo.Traction("shaft", "end", **dict(zip("xyz", 0.002 * turn[:, 2], strict=True)))]
    held = [fo.Support("hub", "end" if height else tuple(float(x) for x in np.array(centre) + turn @ np.eye(len(turn))[0] * 1.8))]
    one, part = (joined(discs(4, 4, height), 4, whole, turn, centre, axis, held, loads) for whole in (True, False))
    if not height:
        arms = np.array(centre) + 1.8 * np.array([[0, 1], [-1, 0], [0, -1]])
        one = fo.ContactModel(one.bodies, [*held, *(fo.Support("hub", tuple(arm.tolist())) for arm in arms)], loads, one.contacts)
    compared(one, part, 4, CYCLE, **({"steps": 4} if height else {}))
    assert len(part._parts.sector.fixed) == 1 + (height > 0)
