"""Mirror images of contacts have mirrored answers.

Contacts that are their own image have answers that are safe when mirrored, too.
"""

from functools import reduce

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.components import joined
from helpers.systems import excess

SEEDS = pytest.mark.parametrize("seed", few(range(6)))
BOTH = pytest.mark.parametrize("tangents", [1, 2])


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
    """A random symmetric contact, its cycle, friction, slip bound and reflections.

    It has nodes on its mirror planes or none, and gaps in some cases. The load case "swing" turns
    its sign in the first mirror plane, so that its two corners are the images of each other.
    """
    rng = np.random.default_rng(seed)
    planes = ((0, 1), (0,), (1,))[seed % 3] if planes is None else planes
    planes = planes if tangents == 2 else (0,)
    lines = []
    for axis in range(tangents):
        half = np.sort(rng.uniform(0.2, 2.0, 1 + (seed + axis) % 2))
        middle = [0.0] if (seed // 2 + axis) % 2 else []
        lines.append(
            np.r_[-half[::-1], middle, half] if axis in planes else np.r_[half, 3.0 + half]
        )
    points = np.column_stack(
        [
            *(line.ravel() for line in np.meshgrid(*lines, indexing="ij")),
            np.zeros(np.prod([len(line) for line in lines])),
        ]
    )
    mirrors = reflections(points, planes, tangents)
    n, m = len(points), len(points) * (tangents + 1)

    def even(x, turns=False):
        for number, P in enumerate(mirrors):
            x = (
                x
                + (-1.0 if turns and number == 0 else 1.0) * (P @ x @ P.T if x.ndim == 2 else P @ x)
            ) / 2
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
    friction = scalar(rng.uniform(0.1, 0.8, n))
    most = scalar(rng.uniform(0.1, 2.0, n)) if seed % 5 == 1 else None
    if tangents == 1:
        friction *= scalar(rng.random(n)) > 0.2  # a node in space without friction leaves no limit
    return (
        fo.ContactSystem(S, points, bonded, gap=gap),
        fo.LoadCycle({"mean": 1.0}, corners),
        friction,
        most,
        mirrors,
    )


def image(contact, friction, most, plane, rng):
    """The mirror image of a contact, its friction and slip bound, with reordered nodes.

    Also returns the effect of the mirror on motions.
    """
    n, tangents = contact.nodes, contact.tangents
    order = rng.permutation(n) if tangents == 2 else np.arange(n)[::-1]  # along the interface
    signs = np.ones(tangents + 1)
    signs[plane] = -1.0
    P = np.kron(np.diag(signs), np.eye(n)[order])
    points = contact.points[order] * np.where(
        np.arange(contact.points.shape[1]) == plane, -1.0, 1.0
    )
    loads = {name: P @ joined(*pair) for name, pair in contact.bonded.items()}
    mirrored = fo.ContactSystem(P @ contact.S @ P.T, points, loads, gap=contact.gap[order])
    return mirrored, friction[order], None if most is None else most[order], P


def uneven(seed, tangents):
    """A contact without symmetry: the symmetric one with other stiffness, loads, friction."""
    contact, cycle, friction, most, _ = scene(seed, tangents)
    rng = np.random.default_rng(seed)
    m = len(contact.S)
    n = contact.nodes
    G = rng.normal(size=(m, m))
    more = {
        name: np.r_[rng.normal(size=m - n), 0.3 * rng.normal(size=n)] for name in contact.bonded
    }
    loads = {name: joined(*pair) + 0.1 * more[name] for name, pair in contact.bonded.items()}
    return (
        fo.ContactSystem(contact.S + 0.1 * G @ G.T / m, contact.points, loads, gap=contact.gap),
        cycle,
        rng.uniform(0.8, 1.0, n) * friction,
        most,
    )


@BOTH
@SEEDS
def test_the_image_of_a_contact_has_the_same_limits_and_the_image_of_a_safe_slip_is_safe(
    seed, tangents
):
    contact, cycle, friction, most = uneven(seed, tangents)
    rng = np.random.default_rng(seed)
    for plane in range(tangents):
        mirrored, f, bound, P = image(contact, friction, most, plane, rng)
        original, other = (
            fo.shakedown_limit(*question, slip_bound=m)
            for question, m in (((contact, cycle, friction), most), ((mirrored, cycle, f), bound))
        )
        assert original.kind is other.kind
        assert [original.load_factor, original.bound, original.least] == pytest.approx(
            [other.load_factor, other.bound, other.least], rel=1e-7, abs=1e-9, nan_ok=True
        )
        assert (
            original.open[np.argmax(P[-contact.nodes :, -contact.nodes :], axis=1)] == other.open
        ).all()
        if original.kind is fo.LimitKind.FINITE:
            n, slip = contact.nodes, original.slip.T.ravel()
            seen = (P[:-n, :-n] @ slip).reshape(tangents, n).T.reshape(original.slip.shape)
            if not original.open.any():
                assert excess(mirrored, cycle, f, original.load_factor, seen) <= 1e-8
            margins = [
                fo.safe_slip(*question, 0.5 * original.load_factor, slip_bound=m).margin
                for question, m in (
                    ((contact, cycle, friction), most),
                    ((mirrored, cycle, f), bound),
                )
            ]
            assert margins[0] == pytest.approx(margins[1], rel=1e-7, abs=1e-8)


@BOTH
@pytest.mark.parametrize("seed", few(range(6)))
def test_the_image_of_a_contact_has_the_same_guaranteed_limit_at_the_image_of_the_node(
    seed, tangents
):
    contact, cycle, friction, most = uneven(seed, tangents)
    mirrored, f, bound, P = image(contact, friction, most, 0, np.random.default_rng(seed))
    original = fo.guaranteed_limit(contact, cycle, friction, slip_bound=most)
    other = fo.guaranteed_limit(mirrored, cycle, f, slip_bound=bound)
    assert original.kind is other.kind
    assert original.load_factor == pytest.approx(other.load_factor, rel=1e-7, abs=1e-9, nan_ok=True)
    if original.node is not None:
        assert P[-contact.nodes + other.node, -contact.nodes + original.node] == 1.0


@BOTH
@SEEDS
def test_a_safe_slip_of_a_contact_that_is_its_own_image_is_safe_mirrored_and_halved(seed, tangents):
    """Safe slips are a convex set that the mirrors keep: the mean of a slip and its images is as
    safe as the slip."""
    contact, cycle, friction, most, mirrors = scene(seed, tangents)
    limit = fo.shakedown_limit(contact, cycle, friction, slip_bound=most)
    if limit.kind is not fo.LimitKind.FINITE or limit.open.any():
        return
    size = contact.nodes * tangents
    even = reduce(
        lambda slip, P: (slip + P[:size, :size] @ slip) / 2, mirrors, limit.slip.T.ravel()
    )
    mean = even.reshape(tangents, -1).T.reshape(limit.slip.shape)
    assert excess(contact, cycle, friction, limit.load_factor, mean) <= 1e-9


def test_a_bound_holds_a_node_on_a_mirror_plane_once():
    """Three nodes do not feel each other. The middle node needs a slip of -0.1 from 2 lam = 0.6 on,
    which is its bound."""
    shear = np.array([[0.1, 0.0], [2.0, 0.0], [0.1, 0.0]])
    bonded = {"mean": (np.zeros((3, 2)), np.ones(3)), "shear": (shear, np.zeros(3))}
    contact = fo.ContactSystem(
        np.eye(9), [[0.0, -1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]], bonded
    )
    cycle = fo.LoadCycle({"mean": 1.0}, [{"shear": -0.2}, {"shear": 1.0}])
    limit = fo.shakedown_limit(contact, cycle, 0.5, slip_bound=0.1)
    assert (limit.load_factor, limit.bound) == pytest.approx((0.3, 0.3))


def test_frictions_of_different_symmetry_in_one_model():
    """Each row of a sweep is the limit of its friction, whatever the symmetry of the others."""
    contact = fo.scenes.SquarePunch(elements=2, growth=2.0).condense()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    x, y = (np.sign(contact.points[:, axis]) for axis in (0, 1))
    frictions = [np.full(9, 0.4), 0.4 + 0.1 * x, 0.4 + 0.1 * y, 0.4 + 0.1 * x + 0.05 * y]
    swept = fo.ShakedownModel(contact, cycle).sweep(frictions)
    alone = [
        fo.shakedown_limit(contact, cycle, friction, simplify=False).load_factor
        for friction in frictions
    ]
    assert swept.load_factor.to_numpy() == pytest.approx(alone, rel=1e-7)


def test_a_middle_node_alone_limits_the_load():
    """It has little friction and cannot slip in a symmetric state, but lifts off at load factor 1.
    No other node feels the load."""
    one, friction = np.eye(3), [0.5, 0.001, 0.5]
    cases = {
        "mean": ([0, 0, 0], [1, 1, 1]),
        "lift": ([0, 0, 0], [0, -1, 0]),
        "shear": ([0.5, 0, -0.5], [0, 0, 0]),
    }
    contact = fo.ContactSystem.from_blocks(
        one, np.diag([0.1, 0.0, -0.1]), one, [0.0, 1.0, 2.0], cases
    )
    for other in ({"mean": 0.0}, {"shear": 0.1}):
        cycle = fo.LoadCycle({"mean": 1.0}, [{"lift": 1.0}, other])
        for simplify in (True, False):
            limit = fo.shakedown_limit(contact, cycle, friction, simplify=simplify)
            assert limit.load_factor == pytest.approx(1.0) and set(limit.mechanism.node) == {1}
            assert fo.safe_slip(
                contact, cycle, friction, 1.0, simplify=simplify
            ).margin == pytest.approx(0.0, abs=1e-10)
