"""Supports along normals: turned models, sectors of a ring, multipliers, and what they refuse."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import special_ortho_group
from skfem import MeshHex, MeshQuad, MeshTet, MeshTri

import frictopt as fo
from helpers.meshes import extruded, ring, rotation, turned, two_blocks
from helpers.multipliers import Assembled, by_multipliers

STEEL, ALLOY = fo.fem.Material(E=2.0, nu=0.3), fo.fem.Material(E=0.7, nu=0.2)


def held(kinds, upper, lower, turn, element="linear", written=np.array):
    """Two blocks whose sides and bottom are held along their normals.

    A matrix turns the whole model, and a function gives the coordinates as they are written.
    """
    d, meshes = len(turn), two_blocks(kinds, upper, lower)
    bodies = {}
    for (name, mesh), material in zip(meshes.items(), (STEEL, ALLOY), strict=True):
        oblique = turned(mesh, turn)
        oblique = replace(oblique, doflocs=written(oblique.p))
        bodies[name] = fo.fem.Body(oblique, material, element)
    sides = [("upper", "x-"), ("lower", "x-"), ("lower", "yz"[d - 2] + "-")] + [
        ("upper", "y+"),
        ("lower", "y+"),
    ] * (d == 3)
    loads = {
        "P": [fo.fem.Pressure("upper", "yz"[d - 2] + "+", 1.0)],
        "E": [fo.fem.Expansion("lower", lambda *x: 0.1 * np.sum(np.square(x), axis=0))],
        "fit": [fo.fem.Interference("contact", 0.1)],
    }
    loads["Q"] = [
        fo.fem.Traction("upper", "x+", **dict(zip("xyz", turn @ [0.3, 0.5, 0.2][:d], strict=False)))
    ]
    return fo.fem.ContactModel(
        bodies,
        [fo.fem.Support(body, side, normal=True) for body, side in sides],
        loads,
        [fo.fem.Contact("upper", "lower")],
    )


SPACE = special_ortho_group(3, seed=4).rvs()
TURNED = [
    ((MeshQuad, MeshQuad), (5,), (4,), rotation(0.7), "linear"),
    ((MeshTri, MeshQuad), (4,), (4,), rotation(2.0), "quadratic"),
    ((MeshHex, MeshHex), (3, 3), (2, 4), SPACE, "linear"),
    ((MeshTet, MeshHex), (2, 2), (2, 2), SPACE, "quadratic"),
]


@pytest.mark.parametrize(("kinds", "upper", "lower", "turn", "element"), TURNED)
def test_a_model_may_be_turned(kinds, upper, lower, turn, element):
    d = len(turn)
    model, other = (held(kinds, upper, lower, each, element) for each in (np.eye(d), turn))
    plain, system = model.condense(), other.condense()
    ways = np.einsum("nka,ab,nlb->nkl", system.frames, turn, plain.frames)
    assert np.allclose(ways[:, -1, -1], 1.0, atol=1e-9)
    for one, two in zip(plain.bonded.values(), system.bonded.values(), strict=True):
        r, s = (
            np.concatenate([pair[0].reshape(len(pair[1]), -1).T, pair[1][None]])
            for pair in (one, two)
        )
        assert np.allclose(np.einsum("nkl,ln->kn", ways, r), s, atol=1e-9)
    S = plain.S.reshape(d, plain.nodes, d, plain.nodes)
    assert np.allclose(
        np.einsum("nkl,lnpm,mqp->knqm", ways, S, ways).reshape(system.S.shape),
        system.S,
        atol=1e-9 * np.abs(S).max(),
    )
    assert np.allclose(
        plain.compliance, system.compliance, atol=1e-9 * np.abs(plain.compliance).max()
    )
    v, w = np.random.default_rng(1).normal(size=plain.slip_shape), np.zeros(plain.nodes)
    slip = np.einsum("nkl,nl->nk", ways[:, :-1, :-1], v.reshape(plain.nodes, -1)).reshape(v.shape)
    fields = [
        one.recover({"P": 1.0, "Q": 0.5}, slips, w) for one, slips in ((model, v), (other, slip))
    ]
    for name in ("upper", "lower"):
        u, moved = (one.displacement[name] for one in fields)
        assert np.allclose(turn @ u, moved, atol=1e-9 * np.abs(u).max())


def seven_digits(points):
    return np.array([float(f"{x:.6e}") for x in points.ravel()]).reshape(points.shape)


def far_away(points):
    return points + 1e4


@pytest.mark.parametrize("written", [seven_digits, far_away])
@pytest.mark.parametrize("lower", [(3, 3), (2, 4)])
def test_rounded_coordinates_do_not_loosen_pairs_on_a_plane_of_symmetry(written, lower):
    """The coordinates of a turned model have few digits, or few digits after the point.

    Its stiffness and its limit are those of the model before the turn, up to these digits.
    """
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 0.5}, {"Q": -0.5}])
    kinds = MeshHex, MeshHex
    plain = held(kinds, (3, 3), lower, np.eye(3)).condense()
    rounded = held(kinds, (3, 3), lower, SPACE, written=written).condense()
    sizes, of_rounded = (np.linalg.eigvalsh(system.S) for system in (plain, rounded))
    assert of_rounded == pytest.approx(sizes, abs=1e-5 * sizes[-1])
    limit, of_rounded = (fo.shakedown_limit(each, cycle, 0.3) for each in (plain, rounded))
    assert 0 < limit.load_factor < np.inf
    assert of_rounded.load_factor == pytest.approx(limit.load_factor, rel=1e-5)


def in_a_bore(turn, written=np.array, first="upper", third=False):
    """Two tubes on end, one on the other, in the bore of one cylinder, under pressure and torque.

    The lower tube stands on its foot. A matrix turns the model, a function gives the coordinates as
    they are written, and one of the tubes is body 1. The model is the whole, or a third of it.
    """
    flat = ring([0.5, 1.0, 1.5], 9, "", "")
    if third:
        angle = np.arctan2(*flat.p[::-1, flat.t].mean(axis=1))
        flat = flat.restrict(np.flatnonzero((angle > 0) & (angle < 2 * np.pi / 3)))
    tube = extruded(flat)
    half_side = np.cos(np.pi / 9)
    bodies = {}
    for name, foot in (("upper", 0.0), ("lower", -np.ptp(tube.p[2]))):
        at = tube.translated((0.0, 0.0, foot))
        at = at.with_boundaries(
            {
                "contact": lambda x: x[2] == 0,
                "end": lambda x: abs(x[2]) > 0.5,
                "rim": lambda x: np.hypot(*x[:2]) > 1.49 * half_side,
                "low": lambda x: (abs(x[1]) < 1e-9) & (x[0] > 0),
                "high": lambda x: (abs(np.sqrt(3.0) * x[0] + x[1]) < 1e-9) & (x[1] > 0),
            }
        )
        at = replace(at, doflocs=written(turn @ at.p))
        bodies[name] = fo.fem.Body(at, STEEL if name == "upper" else ALLOY)

    def drag(axis):
        along = np.eye(3)[axis]
        return lambda *x: 0.3 * np.tensordot(np.cross(along, turn[:, 2]), np.array(x), 1)

    drags = {"xyz"[axis]: drag(axis) for axis in range(3)}
    loads = {
        "P": [fo.fem.Pressure("upper", "end", 1.0)],
        "M": [fo.fem.Traction("upper", "end", **drags)],
    }
    supports = [
        *(fo.fem.Cyclic(name, "low", "high", tuple(turn[:, 2])) for name in bodies if third),
        *(fo.fem.Support(name, "rim", normal=True) for name in bodies),
        fo.fem.Support("lower", "end"),
    ]
    second = "lower" if first == "upper" else "upper"
    return fo.fem.ContactModel(bodies, supports, loads, [fo.fem.Contact(first, second)])


@pytest.mark.parametrize(
    ("first", "third"), [("upper", False), ("lower", False), ("upper", True), ("lower", True)]
)
def test_a_contact_may_reach_a_cylinder_with_rounded_coordinates(first, third):
    """No pair at the cylinder slips towards it, also if the radii of its two nodes are rounded.

    Stiffness and limit are those of the model before the turn, up to the digits; a third of the
    model has the limit of the whole, and turns freely about its axis.
    """
    cycle = fo.LoadCycle({"P": 1.0}, [{"M": 1.0}, {"M": -1.0}])
    plain = in_a_bore(np.eye(3), first=first, third=third).condense()
    rounded = in_a_bore(SPACE, seven_digits, first, third).condense()
    sizes, of_rounded = (np.linalg.eigvalsh(system.S) for system in (plain, rounded))
    assert of_rounded == pytest.approx(sizes, abs=1e-5 * sizes[-1])
    limit, of_rounded = (fo.shakedown_limit(each, cycle, 0.3) for each in (plain, rounded))
    whole = in_a_bore(np.eye(3)).condense()
    known = fo.shakedown_limit(whole, cycle, 0.3).load_factor
    assert limit.load_factor == pytest.approx(known, rel=1e-9)
    assert of_rounded.load_factor == pytest.approx(limit.load_factor, rel=1e-5)


def fit(whole):
    """A ring on another ring, pressed by a load with four periods around.

    The model is the whole, or the eighth between two of its planes of symmetry.
    """
    rings = {
        "hub": ring([1.0, 1.3, 1.8], 40, "contact", "outside"),
        "shaft": ring([0.4, 0.7, 1.0], 40, "bore", "contact"),
    }
    supports = [
        fo.fem.Support("shaft", point, axis)
        for point, axis in (((0.4, 0.0), "y"), ((-0.4, 0.0), "y"), ((0.0, 0.4), "x"))
    ]
    if not whole:
        for name, mesh in rings.items():
            middle = np.arctan2(*mesh.p[::-1, mesh.t].mean(axis=1))
            mesh = mesh.restrict(np.flatnonzero((middle > 0) & (middle < np.pi / 4)))
            cuts = {"low": lambda x: abs(x[1]) < 1e-9, "high": lambda x: abs(x[1] - x[0]) < 1e-9}
            rings[name] = mesh.with_boundaries(cuts)
        supports = [
            fo.fem.Support(name, cut, normal=True) for name in rings for cut in ("low", "high")
        ]
    loads = {
        "fit": [fo.fem.Interference("contact", 0.02)],
        "waves": [
            fo.fem.Pressure("hub", "outside", lambda x, y: 0.02 * np.cos(4 * np.arctan2(y, x)))
        ],
        "squeeze": [fo.fem.Pressure("shaft", "bore", 0.01)],
    }
    return fo.fem.ContactModel(
        {name: fo.fem.Body(mesh, STEEL) for name, mesh in rings.items()},
        supports,
        loads,
        [fo.fem.Contact("shaft", "hub")],
    )


def test_a_sector_between_planes_of_symmetry_has_the_answers_of_the_whole():
    whole, part = (fit(each).condense() for each in (True, False))
    cycle = fo.LoadCycle({"fit": 1.0}, [{"waves": 1.0, "squeeze": 0.3}, {"waves": -1.0}])
    assert (whole.nodes, part.nodes) == (40, 6)
    same = [int(np.linalg.norm(whole.points - point, axis=1).argmin()) for point in part.points]
    assert np.allclose(part.bonded["fit"][1][1:-1], whole.bonded["fit"][1][same][1:-1], rtol=1e-9)
    assert part.width.sum() == pytest.approx(whole.width.sum() / 8)
    assert np.allclose(8 * part.compliance, whole.compliance, rtol=1e-9)
    limits = [fo.shakedown_limit(system, cycle, 0.2).load_factor for system in (whole, part)]
    assert limits[0] == pytest.approx(limits[1], rel=1e-8)
    steady = [fo.steady_state(system, cycle, 0.2, 1.5 * limits[0]) for system in (whole, part)]
    assert steady[0].dissipation > 0
    assert steady[0].dissipation == pytest.approx(8 * steady[1].dissipation, rel=1e-8)
    assert np.allclose(steady[1].slip, steady[0].slip[same], atol=1e-9)
    assert abs(steady[1].slip[[0, -1]]).max() == 0


def test_a_tube_is_held_in_a_cylinder_along_the_normal_of_each_node():
    """A tube is held in a cylinder along the normal of each node.

    Multipliers hold the nodes of a tube in space along their radii, and along its axis at both
    ends.
    """
    flat = ring([0.7, 1.0, 1.4], 9, "bore", "contact")
    n = flat.p.shape[1]
    heights, (a, b, c, d) = np.array([0.0, 0.5, 1.1]), flat.t
    points = np.hstack([np.vstack([flat.p, np.full(n, z)]) for z in heights])
    layers = [
        np.array([low + a, high + a, low + d, low + b, high + d, high + b, low + c, high + c])
        for low, high in ((0, n), (n, 2 * n))
    ]
    tube = MeshHex(points, np.hstack(layers)).with_boundaries(
        {
            "bore": lambda x: np.hypot(*x[:2]) < 0.72,
            "contact": lambda x: np.hypot(*x[:2]) > 1.3,
            "ends": lambda x: abs(x[2] - 0.55) > 0.5,
        }
    )
    wall = ring([1.4, 1.8], 9, "contact", "outside")
    points = np.hstack([np.vstack([wall.p, np.full(18, z)]) for z in heights])
    (a, b, c, d), n = wall.t, 18
    layers = [
        np.array([low + a, high + a, low + d, low + b, high + d, high + b, low + c, high + c])
        for low, high in ((0, n), (n, 2 * n))
    ]
    wall = MeshHex(points, np.hstack(layers)).with_boundaries(
        {"contact": lambda x: np.hypot(*x[:2]) < 1.41, "outside": lambda x: np.hypot(*x[:2]) > 1.6}
    )
    bodies = {"tube": fo.fem.Body(tube, STEEL), "wall": fo.fem.Body(wall, ALLOY)}
    supports = [fo.fem.Support("tube", "bore", normal=True), fo.fem.Support("wall", "outside")]
    system = fo.fem.ContactModel(
        bodies, supports, {"P": [fo.fem.BodyForce("tube", x=1.0)]}, [fo.fem.Contact("tube", "wall")]
    ).condense()
    whole = Assembled(bodies)
    G = whole.motions(system.frames, [[("tube", x, 1.0), ("wall", x, -1.0)] for x in system.points])
    bore = tube.p.T[np.hypot(*tube.p[:2]) < 0.71]
    held = np.zeros((len(bore), len(whole.K)))
    for row, point in zip(held, bore, strict=True):
        row[whole.rows("tube", point)] = np.r_[point[:2], 0.0] / np.hypot(*point[:2])
    outside = [whole.rows("wall", point) for point in wall.p.T[np.hypot(*wall.p[:2]) > 1.7]]
    S, _ = by_multipliers(
        whole.K, np.zeros((len(whole.K), 1)), np.vstack([G, held]), np.concatenate(outside)
    )
    inner = np.arange(len(G), len(S))
    S = S[: len(G), : len(G)]
    assert len(inner) == len(bore) == 27 and np.allclose(S, system.S, atol=1e-9 * np.abs(S).max())


def in_a_cylinder(names, element):
    """A tube that is held in a cylinder, of one name or two, and at its flat end, in a wall."""
    tube, wall = (
        extruded(ring(*rings))
        for rings in (([0.7, 1.0, 1.4], 16, "", ""), ([1.4, 1.8], 16, "", ""))
    )
    faces = {
        "all": lambda x: np.hypot(*x[:2]) < 0.72,
        "left": lambda x: (np.hypot(*x[:2]) < 0.72) & (x[1] < 0.2),
        "right": lambda x: (np.hypot(*x[:2]) < 0.72) & (x[1] >= 0.2),
        "end": lambda x: x[2] < 1e-9,
    }
    tube = tube.with_boundaries(faces | {"contact": lambda x: np.hypot(*x[:2]) > 1.3})
    wall = wall.with_boundaries(
        {"contact": lambda x: np.hypot(*x[:2]) < 1.41, "outside": lambda x: np.hypot(*x[:2]) > 1.7}
    )
    supports = [*oblique(*(("tube", name) for name in names)), fo.fem.Support("wall", "outside")]
    bodies = {"tube": fo.fem.Body(tube, STEEL, element), "wall": fo.fem.Body(wall, ALLOY, element)}
    return fo.fem.ContactModel(
        bodies, supports, {"P": [fo.fem.BodyForce("tube", x=1.0)]}, [fo.fem.Contact("tube", "wall")]
    )


@pytest.mark.parametrize("element", ["linear", "quadratic"])
def test_a_cylinder_may_have_two_names_and_its_edge_is_held_along_both_normals(element):
    one, two = (
        in_a_cylinder(names, element) for names in (("all", "end"), ("left", "right", "end"))
    )
    assert np.array_equal(one._assembly.free_rows, two._assembly.free_rows)
    assert np.allclose(one.condense().S, two.condense().S, rtol=0, atol=1e-9)
    edge = (np.hypot(*one._assembly.points[:, :2].T) < 0.71) & (one._assembly.points[:, 2] == 0)
    assert edge.sum() == 16 * (1 + (element == "quadratic"))
    assert ((one._assembly.free_rows[edge] == -1).sum(axis=1) == 2).all()


def test_a_boundary_along_an_axis_is_held_as_by_its_name():
    model = held((MeshQuad, MeshQuad), (4,), (4,), np.eye(2))
    names = {"x-": "x", "y-": "y"}
    plain = [
        fo.fem.Support(support.body, support.where, names[support.where])
        for support in model.supports
    ]
    other = fo.fem.ContactModel(model.bodies, plain, model.loads, model.contacts)
    assert np.array_equal(model.condense().S, other.condense().S)


def refused(turn=None, supports=None, **more):
    model = held((MeshQuad, MeshQuad), (4,), (4,), rotation(0.7) if turn is None else turn)
    loads = {**model.loads, **more}
    return lambda: fo.fem.ContactModel(
        model.bodies, model.supports if supports is None else supports, loads, model.contacts
    ).condense()


def oblique(*sides):
    return [fo.fem.Support(body, side, normal=True) for body, side in sides]


ALL = [("upper", "x-"), ("lower", "x-"), ("lower", "y-")]
REFUSED = {
    "directions 'x' with normal=True": lambda: fo.fem.Support("a", "b", "x", normal=True),
    "where: (0.0, 0.0) with normal=True": lambda: fo.fem.Support("a", (0, 0), normal=True),
    "normal: 1; give True or False": lambda: fo.fem.Support("a", "b", normal=1),
    "moves nodes that a Support holds along oblique normals": refused(
        more=[fo.fem.Displacement("lower", "x-", x=0.1)]
    ),
    "has an edge around": lambda: fo.fem.ContactModel(
        {
            name: fo.fem.Body(
                mesh.with_boundaries({"corner": lambda x: (x[0] < -0.99) | (x[1] > 0.99)})
            )
            for name, mesh in two_blocks((MeshQuad,) * 2, (4,), (4,)).items()
        },
        [fo.fem.Support("upper", "corner", normal=True)],
        {"P": [fo.fem.BodyForce("upper", y=1.0)]},
    ),
    "can still move along": refused(supports=oblique(*ALL[:2])),
    "are held along different normals": refused(
        supports=[*oblique(*ALL[1:]), fo.fem.Support("upper", "x-", "x")]
    ),
}


@pytest.mark.parametrize("message", REFUSED)
def test_what_cannot_be_held_along_normals_is_refused(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        REFUSED[message]()
