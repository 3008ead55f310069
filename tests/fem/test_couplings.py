"""Forces on nodes, and couplings of nodes to a point.

They are compared with dense algebra with the point and multipliers, supports, and resultants by
hand. Wrong couplings are refused.
"""

import itertools
import re

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad, MeshTri

import frictopt as fo
from helpers.cases import few
from helpers.meshes import box
from helpers.multipliers import Assembled

ROTATIONS = {2: "z", 3: "xyz"}


def bodies_in(d):
    kinds = (MeshQuad, MeshTri) if d == 2 else (MeshHex, MeshHex)
    x = [np.array([0.0, 0.4, 1.0])] * (d - 1)
    upper = box(kinds[0], *x, [0.0, 0.5, 1.0])
    lower = box(kinds[1], *x, [-1.0, -0.5, 0.0])
    materials = fo.fem.Material(2.0, 0.3), fo.fem.Material(0.7, 0.2)
    return {"upper": fo.fem.Body(upper, materials[0]), "lower": fo.fem.Body(lower, materials[1])}


def model(bodies, supports=(), loads=None):
    up = "xyz"[bodies["upper"].mesh.dim() - 1]
    loads = loads or {"P": [fo.fem.Traction("upper", f"{up}+", **{up: -1.0})]}
    return fo.fem.ContactModel(bodies, [fo.fem.Support("lower", f"{up}-"), *supports], loads)


def motions(points, about):
    """(n, d, m) displacements of points in unit motions of a point, one by one."""
    d = points.shape[1]
    columns = [np.broadcast_to(axis, points.shape) for axis in np.eye(d)]
    arm = points - about
    if d == 2:
        columns.append(np.column_stack([-arm[:, 1], arm[:, 0]]))
    else:
        x, y, z = arm.T
        o = np.zeros(len(arm))
        columns += [np.column_stack(turn) for turn in ([o, -z, y], [z, o, -x], [-y, x, o])]
    return np.stack(columns, axis=-1)


def by_multipliers(system, bodies, chosen, weights, about, rigid, is_zero, load):
    """Stiffness of the pairs, reactions of a load on the point, and its work.

    The motion of the point is a further unknown, and multipliers enforce all constraints.
    """
    parts = Assembled(bodies)
    d, n = system.points.shape[1], len(parts.K)
    rows = np.array([parts.rows("upper", point) for point in chosen])
    R = motions(chosen, about)
    m = R.shape[2]
    constraints = []
    if rigid:
        for node_rows, of_node in zip(rows, R, strict=True):
            for row, shares in zip(node_rows, of_node, strict=True):
                constraint = np.zeros(n + m)
                constraint[row] = 1.0
                constraint[n:] = -shares
                constraints.append(constraint)
    else:
        square = np.einsum("n,nda,ndb->ab", weights, R, R)
        mean = np.zeros((m, n + m))
        for k in range(m):
            np.add.at(mean[k], rows, weights[:, None] * R[:, :, k])
        mean[:, n:] = -square
        constraints += list(mean)
    for k in np.flatnonzero(is_zero):
        constraints.append(np.eye(n + m)[n + k])
    for row in parts.on("lower", d - 1, -1.0):
        constraints.append(np.eye(n + m)[row])
    C = np.array(constraints)
    pairs = [[("upper", point, 1.0), ("lower", point, -1.0)] for point in system.points]
    G = np.pad(parts.motions(system.frames, pairs), ((0, 0), (0, m)))
    F = np.r_[np.zeros(n), load]
    all_rows = np.vstack([C, G])
    zero = np.zeros((len(all_rows),) * 2)
    matrix = np.block([[np.pad(parts.K, (0, m)), -all_rows.T], [all_rows, zero]])
    right_sides = np.zeros((len(matrix), len(G) + 1))
    right_sides[: n + m, -1] = F
    right_sides[n + m + len(C) :, :-1] = np.eye(len(G))
    answer = np.linalg.lstsq(matrix, right_sides, rcond=1e-13)[0]
    assert np.allclose(matrix @ answer, right_sides, atol=1e-9)
    reactions = answer[n + m + len(C) :]
    return reactions[:, :-1], reactions[:, -1], F @ answer[: n + m, -1]


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("kind", [fo.fem.RigidCoupling, fo.fem.DistributingCoupling, None])
@pytest.mark.parametrize("seed", few(range(6)))
def test_couplings_are_those_of_a_point_with_multipliers(d, kind, seed):
    """The nodes are random nodes off the contact, or a whole side; random motions of the point are
    zero."""
    rng = np.random.default_rng([d, seed])
    bodies = bodies_in(d)
    points = bodies["upper"].mesh.p.T
    side = seed % 2 == 0
    if side:
        chosen = points[points[:, d - 1] == 1.0]
        where = f"{'xyz'[d - 1]}+"
        halves = {0.0: 0.2, 0.4: 0.5, 1.0: 0.3}
        weights = np.array([np.prod([halves[x] for x in point[:-1]]) for point in chosen])
    else:
        off = points[points[:, d - 1] > 0]
        chosen = off[rng.choice(len(off), 4, replace=False)]
        where = [tuple(map(float, point)) for point in chosen]
        weights = np.ones(4)
    about = rng.uniform(-1.0, 2.0, d)
    is_zero = rng.random(d + len(ROTATIONS[d])) < 0.4
    if kind is None:
        is_zero[:] = False
    elif not is_zero.any():
        is_zero[0] = True
    names = [
        "".join(np.array(list(axes))[flags])
        for axes, flags in (("xyz"[:d], is_zero[:d]), (ROTATIONS[d], is_zero[d:]))
    ]
    load = np.where(is_zero, 0.0, rng.normal(size=len(is_zero)))
    if not load.any():
        load[-1], is_zero[-1], names[1] = 1.0, False, names[1][:-1]
    moment = float(load[-1]) if d == 2 else tuple(map(float, load[3:]))
    remote = fo.fem.RemoteForce(
        "upper",
        where,
        **dict(zip("xyz", load[:d], strict=False)),
        moment=moment,
        point=tuple(map(float, about)),
    )
    supports = [] if kind is None else [kind("upper", where, *names, tuple(map(float, about)))]
    system = model(bodies, supports, {"L": [remote]}).condense()
    S, reactions, work = by_multipliers(
        system, bodies, chosen, weights, about, kind is fo.fem.RigidCoupling, is_zero, load
    )
    assert np.allclose(system.S, S, rtol=0, atol=1e-8 * abs(S).max())
    q, p = system.bonded["L"]
    mine = np.concatenate([q, p] if d == 2 else [*q.T, p])
    assert np.allclose(mine, reactions, rtol=0, atol=1e-8 * max(1.0, abs(reactions).max()))
    assert system.compliance[0, 0] == pytest.approx(work, rel=1e-7)


def rings(bodies, supports, loads):
    """An axisymmetric model whose lower body is held."""
    held = [fo.fem.Support("lower", "y-"), *supports]
    return fo.fem.ContactModel(bodies, held, loads, kinematics="axisymmetric")


def test_forces_on_rings_of_an_axisymmetric_model_are_whole():
    x = np.linspace(1.0, 2.0, 5)
    bodies = {
        "upper": fo.fem.Body(box(MeshQuad, x, [0.0, 0.5, 1.0])),
        "lower": fo.fem.Body(box(MeshQuad, x, [-1.0, -0.5, 0.0])),
    }
    loads = {
        "ring": [fo.fem.PointForce("upper", (2.0, 1.0), y=-3.0)],
        "rings": [fo.fem.PointForce("upper", [(2.0, 1.0), (1.0, 1.0)], y=lambda x, y: -x)],
        "far": [fo.fem.RemoteForce("upper", "y+", y=-5.0)],
    }
    system = rings(bodies, [], loads).condense()
    assert [system.bonded[case][1].sum() for case in loads] == pytest.approx([3.0, 3.0, 5.0])
    assert [system.load_size[case] for case in loads] == pytest.approx([3.0, 3.0, 5.0])
    # A rigid ring does not grow.
    pressed = {"P": [fo.fem.Pressure("upper", "x+", 1.0)]}
    held, right = (
        rings(bodies, [support], pressed).condense().S
        for support in (fo.fem.RigidCoupling("upper", "y+", "y"), fo.fem.Support("upper", "y+"))
    )
    assert np.allclose(held, right, rtol=0, atol=1e-9 * abs(right).max())
    with pytest.raises(fo.ModelError, match="has a radial force or a moment"):
        rings(bodies, [], {"L": [fo.fem.RemoteForce("upper", "y+", x=1.0)]})
    with pytest.raises(fo.ModelError, match="a ring moves as a rigid body only along y"):
        rings(bodies, [fo.fem.RigidCoupling("upper", "y+", "x")], loads)


@pytest.mark.parametrize("element", ["linear", "quadratic"])
def test_rings_of_an_axisymmetric_model_count_by_their_areas(element):
    """A force on an annular face is a uniform traction, and the mean displacement is over its area.

    A face without moments takes a force uniformly, in space too. The mean of the displacement is
    integrated here by Simpson's rule, with the values in the middle of each edge.
    """
    x = np.array([1.0, 1.3, 2.0, 3.0])
    upper = fo.fem.Body(box(MeshQuad, x, [0.0, 0.5, 1.0]), fo.fem.Material(2.0, 0.3), element)
    bodies = {"upper": upper, "lower": fo.fem.Body(box(MeshQuad, x, [-1.0, -0.5, 0.0]))}
    uniform = -5.0 / (np.pi * (3.0**2 - 1.0**2))
    loads = {
        "far": [fo.fem.RemoteForce("upper", "y+", y=-5.0)],
        "near": [fo.fem.Traction("upper", "y+", y=uniform)],
    }
    system = rings(bodies, [], loads).condense()
    assert np.allclose(system.bonded["far"][1], system.bonded["near"][1], rtol=1e-9)
    pressed = {"P": [fo.fem.Pressure("upper", "x+", lambda x, y: 1 + y)]}
    held = rings(bodies, [fo.fem.DistributingCoupling("upper", "y+", "y")], pressed)
    moved = held.recover({"P": 1.0}, slip=np.zeros(len(x))).displacement["upper"][1]
    up = {tuple(place): u for place, u in zip(upper.mesh.p.T.round(9).tolist(), moved, strict=True)}
    volume = 0.0
    for a, b in itertools.pairwise(x):
        middle = (a + b) / 2
        ends = up[a, 1.0], up[b, 1.0]
        amid = up[round(middle, 9), 1.0] if element == "quadratic" else sum(ends) / 2
        volume += (b - a) / 6 * (a * ends[0] + 4 * middle * amid + b * ends[1])
    assert abs(volume) < 1e-12 and np.abs(list(up.values())).max() > 0.1


def test_points_lists_and_functions_select_nodes():
    bodies = bodies_in(3)
    ends = [(0.0, 0.0, 1.0), (1.0, 1.0, 1.0)]
    kinds = {
        "list": ends,
        "function": lambda x, y, z: (z == 1.0) & np.isin(x, [0.0, 1.0]) & (x == y),
    }
    loads = {name: [fo.fem.PointForce("upper", where, z=-1.0)] for name, where in kinds.items()}
    loads["one by one"] = [fo.fem.PointForce("upper", end, z=-1.0) for end in ends]
    loads["side"] = [fo.fem.PointForce("upper", "z+", z=-1.0)]
    loads["all"] = [fo.fem.PointForce("upper", lambda x, y, z: z == 1.0, z=-1.0)]
    system = model(bodies, loads=loads).condense()
    p = {case: forces[1] for case, forces in system.bonded.items()}
    assert np.allclose(p["list"], p["function"]) and np.allclose(p["list"], p["one by one"])
    assert np.allclose(p["side"], p["all"]) and p["all"].sum() == pytest.approx(9.0)
    by_point = [fo.fem.Support("upper", end, "x") for end in ends]
    held = [
        model(bodies, supports).condense().S
        for supports in ([fo.fem.Support("upper", kinds["function"], "x")], by_point)
    ]
    assert np.allclose(*held)


SIDE = {"L": [fo.fem.Pressure("lower", "x-", 1.0)]}
UP = [(0.0, 0.0, 1.0), (1.0, 0.0, 1.0)]  # on a line along x
BAD = {
    "cannot carry the moment, because they lie on a line": lambda b: model(
        b, loads={"L": [fo.fem.RemoteForce("upper", UP, moment=(1.0, 0.0, 0.0))]}
    ),
    "its nodes (1) cannot carry the moment": lambda b: model(
        b, loads={"L": [fo.fem.RemoteForce("upper", UP[:1], x=1.0, point=(0.0, 0.0, 3.0))]}
    ),
    "DistributingCoupling(body='upper', where=((0.0, 0.0, 1.0), (1.0": lambda b: model(
        b, [fo.fem.DistributingCoupling("upper", UP, "", "x")], SIDE
    ),
    "which also belongs to a contact or another coupling": lambda b: model(
        b, [fo.fem.RigidCoupling("upper", "x+")], SIDE
    ),
    "the node at (0, 0, 1), which also belongs to a contact": lambda b: model(
        b, [fo.fem.RigidCoupling("upper", "z+"), fo.fem.RigidCoupling("upper", UP)], SIDE
    ),
    "has nodes that other supports hold against its motions": lambda b: model(
        b, [fo.fem.RigidCoupling("upper", "z+"), fo.fem.Support("upper", UP[0], "x")], SIDE
    ),
    "or other supports hold them; name fewer directions": lambda b: model(
        b, [fo.fem.DistributingCoupling("upper", UP, "x"), fo.fem.Support("upper", "z+", "x")], SIDE
    ),
    "z=0.0, moment=None, point=None)] act only where supports hold the body, [RigidC": lambda b: (
        model(
            b,
            [fo.fem.RigidCoupling("upper", "z+", "xyz", "xyz")],
            {"L": [fo.fem.RemoteForce("upper", "z+", x=1.0)]},
        )
    ),
    "where=((0.0, 0.0, 1.0),), x=1.0, y=0.0, z=0.0)] act only where": lambda b: model(
        b, [fo.fem.Support("upper", "z+")], {"L": [fo.fem.PointForce("upper", UP[:1], x=1.0)]}
    ),
    "where: the function raised TypeError": lambda b: model(
        b, loads={"L": [fo.fem.PointForce("upper", lambda x: x == 0, x=1.0)]}
    ),
    "where: the function gave an array of float64": lambda b: model(
        b, loads={"L": [fo.fem.PointForce("upper", lambda x, y, z: x, x=1.0)]}
    ),
    "where: the function is true at no node of body 'upper'": lambda b: model(
        b, loads={"L": [fo.fem.PointForce("upper", lambda x, y, z: x > 9, x=1.0)]}
    ),
    "point: (0.0, 1.0); give the 3 coordinates": lambda b: model(
        b, loads={"L": [fo.fem.RemoteForce("upper", "z+", x=1.0, point=(0.0, 1.0))]}
    ),
    "RemoteForce moment: 1.0; body 'upper' has 3 dimensions": lambda b: model(
        b, loads={"L": [fo.fem.RemoteForce("upper", "z+", moment=1.0)]}
    ),
    "directions: none, and no rotations": lambda b: fo.fem.DistributingCoupling("upper", "z+"),
    "RemoteForce: x, y and z are all missing": lambda b: fo.fem.RemoteForce("upper", "z+"),
}


@pytest.mark.parametrize("message", BAD)
def test_what_cannot_be_is_refused_by_name(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        BAD[message](bodies_in(3))


def test_directions_across_the_plane_are_refused():
    with pytest.raises(fo.ModelError, match="of a plane body; give directions x and y"):
        model(bodies_in(2), [fo.fem.RigidCoupling("upper", "y+", "z")])


def test_a_body_that_its_coupling_lets_turn_is_named():
    bodies = bodies_in(3)
    loads = {"P": [fo.fem.Traction("upper", "x+", z=-1.0)]}
    with pytest.raises(fo.ModelError, match="can still turn about x and y and z"):
        fo.fem.ContactModel(
            bodies, [fo.fem.DistributingCoupling("upper", "z+", "xyz")], loads
        ).condense()
    held = fo.fem.DistributingCoupling("upper", "z+", "xyz", "xyz")
    assert fo.fem.ContactModel(bodies, [held], loads).condense().nodes == 9


def test_on_a_plane_of_symmetry_the_motions_of_the_half_are_allowed():
    bodies = bodies_in(3)
    cut = [fo.fem.Support("upper", "x-", "x"), fo.fem.Support("lower", "x-", "x")]
    rigid = fo.fem.RigidCoupling("upper", "z+", "x", "yz", point=(0.0, 0.5, 1.0))
    loads = {"L": [fo.fem.Pressure("lower", "x+", 1.0)]}
    assert model(bodies, [*cut, rigid], loads).condense().nodes == 9
