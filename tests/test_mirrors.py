"""Contacts that are mirror-symmetric in one or two planes are asked as a half or a quarter, and the answer is that of the whole contact."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import ortho_group

import frictopt as fo
from frictopt.contact.parts import joined
from frictopt.limits.parts import half_of, images_of, rest_of
from frictopt.limits.question import pose

SEEDS = pytest.mark.parametrize("seed", range(12))


def reflections(points, planes, tangents):
    """(M, M) what each mirror plane does to the motions of the nodes, found node by node."""
    n, found = len(points), []
    for plane in planes:
        image = points * np.where(np.arange(points.shape[1]) == plane, -1.0, 1.0)
        P = np.zeros((n * (tangents + 1),) * 2)
        for i, place in enumerate(image):
            j = int(np.flatnonzero(np.abs(points - place).max(axis=1) < 1e-9).item())
            for axis in range(tangents + 1):
                P[axis * n + j, axis * n + i] = -1.0 if axis == plane else 1.0
        found.append(P)
    return found


def scene(seed, tangents=2, *, planes=None):
    """A random symmetric contact with nodes on its mirror planes or none, gaps in some cases; its cycle, friction, slip bound and reflections.

    The load case "swing" turns its sign in the first mirror plane, so that its two corners are the images of each other.
    """
    rng = np.random.default_rng(seed)
    planes = ((0, 1), (0,), (1,))[seed % 3] if planes is None else planes
    planes = planes if tangents == 2 else (0,)
    lines = []
    for axis in range(tangents):
        half = np.sort(rng.uniform(0.2, 2.0, 1 + (seed + axis) % 2))
        middle = [0.0] if (seed // 2 + axis) % 2 else []
        lines.append(np.r_[-half[::-1], middle, half] if axis in planes else np.r_[half, 3.0 + half])
    points = np.column_stack([*(line.ravel() for line in np.meshgrid(*lines, indexing="ij")), np.zeros(np.prod([len(line) for line in lines]))])
    mirrors = reflections(points, planes, tangents)
    n, m = len(points), len(points) * (tangents + 1)

    def even(x, turns=False):
        for number, P in enumerate(mirrors):
            x = (x + (-1.0 if turns and number == 0 else 1.0) * (P @ x @ P.T if x.ndim == 2 else P @ x)) / 2
        return x

    def scalar(values):
        return even(np.r_[np.zeros(m - n), values])[m - n :]

    G = rng.normal(size=(m, m))
    S = even(G @ G.T / m + 0.3 * np.eye(m))
    S[m - n :, : m - n] *= 0.6
    S[: m - n, m - n :] *= 0.6
    bonded = {"one": even(rng.normal(size=m)), "swing": even(rng.normal(size=m), turns=True)}
    bonded["mean"] = even(np.r_[0.1 * rng.normal(size=m - n), rng.uniform(0.5, 1.5, n)])
    for name in ("one", "swing"):
        bonded[name][m - n :] *= 0.3
    gap = 0.2 * scalar(rng.uniform(size=n)) if seed % 4 == 0 else None
    swing, one = rng.normal(size=2)
    corners = [{"swing": swing, "one": one}, {"swing": -swing, "one": one}, {"one": rng.normal()}]
    friction, most = scalar(rng.uniform(0.1, 0.8, n)), scalar(rng.uniform(0.1, 2.0, n)) if seed % 5 == 1 else None
    if tangents == 1:
        friction *= scalar(rng.random(n)) > 0.2  # a node in space without friction leaves no limit
    return fo.ContactSystem(S, points, bonded, gap=gap), fo.LoadCycle({"mean": 1.0}, corners), friction, most, mirrors


def changed(contact, **change):
    return replace(contact, **{"bonded": {name: joined(*pair) for name, pair in contact.bonded.items()}, **change})


@pytest.mark.parametrize("tangents", [1, 2])
@SEEDS
def test_the_limit_of_the_part_is_that_of_the_whole(seed, tangents):
    """Two solutions of the same question, and the proof of the smaller one by referee and balance of the whole contact."""
    contact, cycle, friction, most, mirrors = scene(seed, tangents)
    lean, full = (fo.shakedown_limit(contact, cycle, friction, slip_bound=most, simplify=simplify) for simplify in (True, False))
    assert "mirror symmetry" in lean.record.left_out[0] and not any("mirror" in text for text in full.record.left_out)
    assert lean.kind is full.kind and lean.load_factor == pytest.approx(full.load_factor, rel=1e-7, nan_ok=True)
    assert lean.bound == pytest.approx(full.bound, rel=1e-7, nan_ok=True)
    if lean.kind is fo.LimitKind.FINITE and not lean.open.any():
        slip, motion, n = lean.slip.T.ravel(), lean._motion, contact.nodes
        for P in mirrors:
            assert P[: len(slip), : len(slip)] @ slip == pytest.approx(slip, abs=1e-9)
            assert P[-n:, -n:] @ lean.friction_rate == pytest.approx(lean.friction_rate, abs=1e-9)
        assert lean.mechanism["share"].sum() == pytest.approx(1.0)
        stress = contact.S[:-n] @ motion.moves.sum(axis=0).ravel() - (0.0 if motion.hold is None else motion.hold.ravel())
        assert np.abs(stress).max() < 1e-8 * motion.size.max() * np.abs(contact.S).max()
        resistance, drive = motion.work(pose(contact, cycle, friction, slip_bound=most))
        assert resistance / drive == pytest.approx(lean.load_factor, rel=1e-7) and (motion.opening >= 0).all()


def test_a_bound_holds_a_node_on_a_mirror_plane_once():
    """Three nodes that do not feel each other; the middle one needs a slip of -0.1 from 2 lam = 0.6 on, which is its bound."""
    shear = np.array([[0.1, 0.0], [2.0, 0.0], [0.1, 0.0]])
    bonded = {"mean": (np.zeros((3, 2)), np.ones(3)), "shear": (shear, np.zeros(3))}
    contact = fo.ContactSystem(np.eye(9), [[0.0, -1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]], bonded)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"shear": -0.2}, {"shear": 1.0}])
    limit = fo.shakedown_limit(contact, cycle, 0.5, slip_bound=0.1)
    assert "mirror symmetry" in limit.record.left_out[0] and limit.load_factor == pytest.approx(0.3)
    resistance, drive = limit._motion.work(pose(contact, cycle, 0.5, slip_bound=0.1))
    assert resistance / drive == pytest.approx(0.3)


@pytest.mark.parametrize("tangents", [1, 2])
@SEEDS
def test_the_margin_of_the_part_is_that_of_the_whole(seed, tangents):
    contact, cycle, friction, most, _ = scene(seed, tangents)
    for factor in (0.0, 0.3, 1.5):
        lean, full = (fo.safe_slip(contact, cycle, friction, factor, slip_bound=most, simplify=simplify) for simplify in (True, False))
        assert "mirror symmetry" in lean.record.left_out[0] or lean.open.any()
        assert lean.exists is full.exists and lean.margin == pytest.approx(full.margin, rel=1e-7, abs=1e-8)
        assert lean.bound == pytest.approx(full.bound, rel=1e-7, abs=1e-8) and (lean.certificate is None) is lean.exists


@pytest.mark.parametrize("tangents", [1, 2])
def test_of_a_contact_that_lifts_off_the_closed_nodes_of_a_part_are_asked(tangents):
    """Some two nodes of five are far apart, and open under the mean load."""
    both = 0
    for seed in range(12):
        contact, cycle, friction, most, mirrors = scene(seed, tangents)
        n, gap = contact.nodes, np.r_[np.zeros(contact.nodes * tangents), np.random.default_rng(seed).uniform(size=contact.nodes)]
        for P in mirrors:
            gap = (gap + P @ gap) / 2
        contact = changed(contact, gap=np.where(gap[-n:] > np.quantile(gap[-n:], 0.6), 2 * gap[-n:], 0.0))
        lean, full = (fo.shakedown_limit(contact, cycle, friction, slip_bound=most, simplify=simplify) for simplify in (True, False))
        assert lean.kind is full.kind and (lean.open == full.open).all()
        assert lean.load_factor == pytest.approx(full.load_factor, rel=1e-7, nan_ok=True)
        if lean.kind is fo.LimitKind.FINITE and lean.open.any():
            assert lean.record.left_out[0].startswith("mirror symmetry: the slip is its own image, and nodes that are open under the mean load, ")
            resistance, drive = lean._motion.work(pose(contact, cycle, friction, slip_bound=most))
            assert resistance / drive == pytest.approx(lean.load_factor, rel=1e-7)
            asked = contact, cycle, friction, 0.5 * lean.load_factor
            lean, full = (fo.safe_slip(*asked, slip_bound=most, simplify=simplify) for simplify in (True, False))
            assert lean.margin == pytest.approx(full.margin, rel=1e-7, abs=1e-8)
            both += 1
    assert both >= 4


def test_nodes_that_are_open_without_their_images_leave_no_part():
    contact, cycle, friction, _, _ = scene(3, planes=(0,))
    task, first = pose(contact, cycle, friction), np.arange(contact.nodes) == 0
    alone, pair = rest_of(task, first), rest_of(task, first | (images_of(task)[1][:, : contact.nodes].min(axis=0) == 0))
    assert half_of(alone) is alone and len(half_of(pair).friction) < len(pair.friction)


@pytest.mark.parametrize("tangents", [1, 2])
@pytest.mark.parametrize("seed", range(6))
def test_critical_nodes_of_the_part_are_those_of_the_whole(seed, tangents):
    contact, cycle, friction, most, _ = scene(seed, tangents)
    lean, full = (fo.guaranteed_limit(contact, cycle, friction, slip_bound=most, simplify=simplify) for simplify in (True, False))
    assert lean.kind is full.kind and lean.load_factor == pytest.approx(full.load_factor, rel=1e-7, nan_ok=True)


@pytest.mark.parametrize("turned", [False, True])
def test_both_planes_of_a_contact_are_found_however_it_lies(turned):
    contact, cycle, friction, _, _ = scene(3)
    if turned:
        Q = ortho_group.rvs(3, random_state=1)
        Q *= np.linalg.det(Q)
        contact = changed(contact, points=contact.points @ Q.T + [5.0, -3.0, 1.0], frames=contact.frames @ Q.T)
    task = pose(contact, cycle, friction)
    assert len(images_of(task)[0]) == 4 and half_of(replace(task, simplify=False)).whole is None
    assert len(half_of(task).friction) < len(friction) / 2


def test_what_breaks_a_symmetry_a_little_leaves_the_other():
    """Each change is in one node off the second plane's mirror image: none is left, or the second plane."""
    contact, cycle, friction, _, _ = scene(3, planes=(0, 1))
    n, rng, task = contact.nodes, np.random.default_rng(0), pose(contact, cycle, friction, slip_bound=1.0)
    left = contact.points[:, 0] < 0  # symmetric in the second plane alone
    m = contact.S.shape[0]
    assert len(images_of(task)[0]) == 4

    def planes(**change):
        found = images_of(pose(change.pop("contact", contact), change.pop("cycle", cycle), change.pop("friction", friction), **change))
        moved = contact.points[np.arange(n) if found is None else found[1][:, :n]] - contact.points
        return np.flatnonzero(np.abs(moved).max(axis=tuple(range(moved.ndim - 1))) > 1e-3).tolist()

    second = [1]
    assert planes(friction=friction + 1e-12 * left) == second
    assert planes(slip_bound=1.0 + 1e-12 * left) == second
    assert planes(contact=changed(contact, gap=contact.gap + 1e-9 * left)) == second
    assert planes(contact=changed(contact, points=contact.points + 1e-6 * np.outer(left, [1.0, 0.0, 0.0]))) == second
    stiffer = contact.S + 1e-11 * np.diag(np.tile(left, 3).astype(float)) * np.abs(contact.S).max()
    assert planes(contact=changed(contact, S=stiffer)) == second
    for case in ("mean", "one", "swing"):
        loads = {name: joined(*pair) for name, pair in contact.bonded.items()}
        for more in (np.r_[np.zeros(m - n), left], np.r_[left, np.zeros(m - n)]):
            assert planes(contact=changed(contact, bonded={**loads, case: loads[case] + 1e-10 * more})) == second
    assert planes(cycle=fo.LoadCycle({"mean": 1.0}, cycle.corners[:1])) == second
    assert planes(cycle=fo.LoadCycle({"mean": 1.0, "swing": 1e-10}, cycle.corners)) == second
    assert planes(cycle=fo.LoadCycle({"mean": 1.0}, cycle.corners, fixed=[{"swing": 1e-10}, {}, {}])) == second
    assert len(planes(cycle=fo.LoadCycle({"mean": 1.0}, cycle.corners, fixed=[{"swing": 0.1}, {"swing": -0.1}, {}]))) == 2
    assert planes(friction=friction + 1e-12 * rng.uniform(size=n)) == []
    frames = contact.frames.copy()
    frames[0, :2] = frames[0, [1, 0]] * [[1.0], [-1.0]]
    assert planes(contact=changed(contact, frames=frames)) == []
    one = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"mean": ([0.0], [1.0])})
    assert images_of(pose(one, fo.LoadCycle({"mean": 1.0}, [{"mean": 0.1}]), 0.4)) is None


def test_frictions_of_different_symmetry_in_one_model():
    """Nodes of equal number are in the program, but not the same ones: the model keeps their programs apart."""
    contact, cycle = fo.scenes.SquarePunch(elements=2, growth=2.0).condense(), fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    x, y = (np.sign(contact.points[:, axis]) for axis in (0, 1))
    frictions = [np.full(9, 0.4), 0.4 + 0.1 * x, 0.4 + 0.1 * y, 0.4 + 0.1 * x + 0.05 * y]
    lean, full = (fo.ShakedownModel(contact, cycle, simplify=simplify).sweep(frictions) for simplify in (True, False))
    assert lean.load_factor.to_numpy() == pytest.approx(full.load_factor.to_numpy(), rel=1e-7)


@pytest.mark.parametrize("corners", [[{"sigma": -1.0}, {"sigma": 1.0}], [{"Qx": 1.0}, {"Qy": 1.0}, {"Qx": -1.0}, {"Qy": -1.0}]])
@pytest.mark.parametrize("elements", [3, 4])
@pytest.mark.parametrize("planes", [1, 2])
def test_a_square_punch_is_asked_as_its_quarter_or_half(corners, elements, planes):
    """The half may slide along its mirror plane as a whole."""
    contact, cycle = fo.scenes.SquarePunch(elements=elements).condense(), fo.LoadCycle({"P": 1.0}, corners)
    friction = np.where(contact.points[:, 0] < 0, 0.5, (0.3, 0.5)[planes - 1])
    lean, full = (fo.shakedown_limit(contact, cycle, friction, simplify=simplify) for simplify in (True, False))
    across = (elements + 2) // 2
    asked = across**2 if planes == 2 else across * (elements + 1)
    assert lean.record.left_out[0].endswith(f"{asked} of {(elements + 1) ** 2} nodes are in the program")
    assert lean.load_factor == pytest.approx(full.load_factor, rel=1e-8)


def test_a_middle_node_alone_limits_the_load():
    """Little friction in the middle: it cannot slip in a symmetric state, but lifts off at load factor 1; no node else feels the load."""
    one, friction = np.eye(3), [0.5, 0.001, 0.5]
    cases = {"mean": ([0, 0, 0], [1, 1, 1]), "lift": ([0, 0, 0], [0, -1, 0]), "shear": ([0.5, 0, -0.5], [0, 0, 0])}
    contact = fo.ContactSystem.from_blocks(one, np.diag([0.1, 0.0, -0.1]), one, [0.0, 1.0, 2.0], cases)
    for other in ({"mean": 0.0}, {"shear": 0.1}):
        cycle = fo.LoadCycle({"mean": 1.0}, [{"lift": 1.0}, other])
        for simplify in (True, False):
            limit = fo.shakedown_limit(contact, cycle, friction, simplify=simplify)
            assert limit.load_factor == pytest.approx(1.0) and set(limit.mechanism.node) == {1}
            assert fo.safe_slip(contact, cycle, friction, 1.0, simplify=simplify).margin == pytest.approx(0.0, abs=1e-10)
