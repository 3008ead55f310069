"""The search of nodes that stay open.

It is compared with closed forms, every set of open nodes, transients, and rounded punches.
"""

from itertools import product

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits import pose
from frictopt.limits.search.likely_sets import settled_sets
from helpers.cases import few
from helpers.separation import pulled_system, rests
from helpers.systems import CYCLE, NODE, all_closed, system, unit_nodes
from studies.validation.blocks import block
from studies.validation.open_sets import largest_with_open
from studies.validation.stays_open import interval_of_set

ROUNDED = [  # elements, rounding, open nodes at each side, limit with them open
    (24, 20.0, 4, 0.7821287715),
    (48, 20.0, 8, 0.4481514660),
    (24, 100.0, 6, 1.9856619085),
    (48, 100.0, 11, 0.6026058693),
]
THREE = fo.LoadCycle({"mean": 1.0}, [{"cyclic": -1.0}, {"cyclic": 0.8}, {"cyclic": 0.3}])
MOST = 30.0  # load factor up to which sets are compared


def rounded(contact, size, flat=0.6):
    return contact.with_gap(size * np.maximum(np.abs(contact.x) - flat, 0.0) ** 2)


def random_question(seed, least, most):
    rng = np.random.default_rng(seed)
    return pulled_system(rng, int(rng.integers(least, most))), float(rng.uniform(0.1, 1.0))


def best_of_all_sets(contact, cycle, friction):
    """Largest load factor of all sets of nodes that stay open, by scipy.

    Load factors end at MOST. The set of all nodes is left out, and the value is nan if no set is
    safe.
    """
    sets = [
        np.tile(opened, (len(cycle.corners), 1))
        for opened in product([False, True], repeat=contact.nodes)
        if not all(opened)
    ]
    claims = [largest_with_open(contact, cycle, friction, opened, MOST) for opened in sets]
    return max((claim[0] for claim in claims if claim), default=np.nan)


def limits_by_friction(contact, cycle, frictions):
    return np.array([fo.shakedown_limit(contact, cycle, f).load_factor for f in frictions])


@pytest.mark.parametrize(("elements", "size", "count", "limit"), ROUNDED)
def test_rounded_punches_by_sets_of_open_nodes(elements, size, count, limit, punch, paper_cycle):
    contact = rounded(punch(elements, grading=3, growth=1.09), size)
    best = fo.shakedown_limit(contact, paper_cycle, 0.6)
    assert best.load_factor == pytest.approx(limit, abs=1e-8)
    ends = (np.arange(contact.nodes) < count) | (np.arange(contact.nodes) >= contact.nodes - count)
    assert np.array_equal(best.open, ends)
    assert best.residual < 1e-9
    assert best.largest_slip == np.abs(best.slip[~ends]).max()
    assert best.bound == pytest.approx(limit, abs=1e-7)
    assert rests(contact, paper_cycle, 0.6, 0.999 * limit, initial_slip=best.slip)
    assert not rests(contact, paper_cycle, 0.6, 1.001 * limit, initial_slip=best.slip)


def test_an_open_node_that_presses_the_one_that_rules_is_not_taken_for_slip():
    """An open node may press the node that governs the limit.

    The mean load pulls both nodes. Open by 0.5, the first node presses the second one with 0.3,
    which slips at f p = 0.15.
    """
    contact = system(
        np.eye(2), np.zeros((2, 2)), 0.0, [-1.0, -0.2], [0.0, 1.0], 0.0, C=[[2.0, 1.0], [1.0, 2.0]]
    )
    limit = fo.shakedown_limit(contact, CYCLE, 0.5)
    assert limit.load_factor == pytest.approx(0.15)
    assert limit.open.tolist() == [True, False]
    assert "only residual slip presses" not in limit.reason


@pytest.mark.parametrize(
    ("seed", "cycle", "most"),
    [(seed, CYCLE, 6) for seed in few(range(2, 10))]
    + [(seed, THREE, 5) for seed in few(range(20, 25))],
)
def test_small_contacts_against_every_set_of_open_nodes(seed, cycle, most):
    contact, friction = random_question(seed, 1, most)
    limit = fo.shakedown_limit(contact, cycle, friction)
    best = best_of_all_sets(contact, cycle, friction)
    assert min(limit.load_factor, MOST) == pytest.approx(best, rel=1e-6, nan_ok=True)


@pytest.mark.parametrize("seed", few(range(1000, 1008)))
def test_a_set_is_not_below_what_the_mean_load_opens_nor_a_set_next_to_it_and_rests(seed):
    contact, friction = random_question(seed, 3, 7)
    limit = fo.shakedown_limit(contact, CYCLE, friction)
    if not np.isfinite(limit.load_factor):
        return
    settled = fo.march(contact, CYCLE, friction, 0.0, cycles=1).status[-1] == 2
    shares = limit.mechanism.groupby("node")["share"].sum()
    flips = (
        [np.arange(contact.nodes) == node for node in shares.index[shares > 0.1 * shares.max()]]
        if limit.open.any()
        else []
    )
    for opened in [
        settled,
        np.zeros(contact.nodes, dtype=bool),
        *(limit.open ^ flip for flip in flips),
    ]:
        claim = largest_with_open(
            contact, CYCLE, friction, np.tile(opened, (2, 1)), 2 * limit.load_factor
        )
        assert claim is None or claim[0] <= limit.load_factor * (1 + 1e-6)
    assert rests(contact, CYCLE, friction, 0.999 * limit.load_factor, initial_slip=limit.slip)


def test_sets_that_less_friction_opens_are_tried_where_few_nodes_want_to_open(paper_cycle):
    """With 0.9 the closed contact still has a small limit. The two sides of the best set open only
    together, as under the mean load with less friction."""
    flat = fo.scenes.PunchOnHalfPlane(elements=12).condense()
    contact = flat.with_gap(2.0 * flat.x**4)
    limit = fo.shakedown_limit(contact, paper_cycle, 0.9)
    closed = all_closed(contact, paper_cycle, 0.9)
    assert 0 < closed.load_factor < 0.03 < 0.95 < limit.load_factor
    assert np.flatnonzero(limit.open).tolist() == [0, 1, 2, 10, 11, 12]
    assert (
        np.diff(limits_by_friction(contact, paper_cycle, np.linspace(0.1, 1.2, few(6, 4)))).min()
        > 0
    )


@pytest.mark.parametrize("seed", few([0, 5, 10, 13], 1, 4))
def test_the_limit_never_falls_as_friction_grows(seed):
    limits = limits_by_friction(random_question(seed, 3, 6)[0], CYCLE, np.linspace(0.1, 1.2, 8))
    assert (limits[1:] >= limits[:-1] * (1 - 1e-7)).all()


@pytest.mark.parametrize("load_factor", few([0.95, 0.2, 0.45, 0.7], 1, 4))
def test_required_friction_is_the_threshold_of_the_limit(load_factor, punch, paper_cycle):
    contact = punch(12).with_gap(2.0 * punch(12).x ** 4)
    required = fo.required_friction(contact, paper_cycle, load_factor)
    assert required.open.any()
    assert required.required * (1 - 1e-5) < required.bound < required.required
    below, above = (
        fo.shakedown_limit(contact, paper_cycle, required.required * (1 + sign * 1e-4)).load_factor
        for sign in (-1, 1)
    )
    assert below < load_factor < above


def test_a_load_below_the_least_of_the_best_set_rests_with_other_nodes_open():
    """With friction 0.3 the closed contact rests from 0.31 to 1.83, and the contact with node 0
    open up to 0.73. All load factors up to 1.83 are safe."""
    S = np.array(
        [
            [0.67, -0.19, 0.1, -0.35],
            [-0.19, 0.43, 0.12, -0.26],
            [0.1, 0.12, 0.32, -0.13],
            [-0.35, -0.26, -0.13, 0.87],
        ]
    )
    loads = {
        "P": [1.53, 0.36, 0.29, 0.08],
        "0": [-0.76, 1.11, 0.61, -0.2],
        "1": [-0.69, 0.35, 0.71, 0.42],
    }
    contact = fo.ContactSystem(S, [[0, 0], [1, 0]], loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"0": 1.0}, {"1": 1.0}])
    limit = fo.shakedown_limit(contact, cycle, 0.3)
    low = fo.safe_slip(contact, cycle, 0.3, 0.05)
    assert limit.least > 0.3
    assert not limit.open.any()
    assert low.exists
    assert low.open.tolist() == [True, False]
    assert rests(contact, cycle, 0.3, 0.05, initial_state=low.state)
    both = fo.safe_slip(contact, cycle, 0.3, 1.5)
    assert both.exists and not both.open.any()


def test_apart_is_the_distance_from_the_slip_that_the_mean_load_leaves(rounded):
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    limit = fo.shakedown_limit(rounded, cycle, 0.6)
    settled = fo.march(rounded, cycle, 0.6, 0.0, cycles=1).slip[-1]
    assert limit.apart == pytest.approx(np.abs(settled - limit.slip).max(), rel=1e-6)
    assert limit.apart > 0


def test_a_contact_that_is_pulled_apart_has_no_state_of_rest(punch):
    limit = fo.shakedown_limit(
        punch(8), fo.LoadCycle({"P": -1.0}, [{"sigma": 1.0}, {"sigma": -1.0}]), 0.6
    )
    assert np.isnan(limit.load_factor)
    assert limit.state is None
    assert not limit.open.any()
    assert np.isnan(limit.slip).all()
    assert "the mean load pulls the bodies apart" in limit.reason and limit.reason in repr(limit)


def test_a_contact_whose_nodes_are_all_open_for_ever_is_none():
    contact = system(1.0, 0.0, 0.2, -1.0, 0.5, 0.5, C=[[1.0]])  # open as long as 0.5 lam <= 1
    limit = fo.shakedown_limit(contact, CYCLE, 0.5)
    assert limit.kind is fo.LimitKind.NO_SAFE_SLIP
    assert "compression must be positive" in limit.reason


@pytest.mark.parametrize("shear", [0.3, 0.0])
def test_nodes_that_only_the_corners_press_rest_in_an_interval(shear):
    """Node 0 is always open, node 1 sticks if 0.1 lam <= 0.5 (lam - 1), and node 2 sticks if
    `shear` lam <= 0.5. Below the interval node 1 slips unless it is open, too."""
    loads = {
        "P": ([0, 0, 0], [-5.0, -1.0, 1.0]),
        "N": ([0, 0, 0], [0, 1.0, 0]),
        "Q": ([0, 0.1, shear], [0, 0, 0]),
    }
    contact = unit_nodes(loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": 1.0, "Q": 1.0}, {"N": 1.0, "Q": -1.0}])
    first = fo.shakedown_limit(contact, cycle, 0.5)
    opened = np.array([True, False, False])
    assert (first.load_factor, first.least) == pytest.approx((1.0, 0.0))
    assert first.open.tolist() == [True, True, False]
    # Between them none is safe.
    limit = fo.shakedown_limit(contact, cycle, 0.5, open_nodes=opened)
    assert limit.load_factor == pytest.approx(5 / 3 if shear else np.inf)
    assert limit.least == pytest.approx(1.25)
    assert limit.open.tolist() == [True, False, False]
    assert "from 1.25 on" in limit.reason or "no slip is safe below 1.25" in limit.reason
    for load_factor, at_rest in ((1.1, False), (1.2, False), (1.26, True), (1.66, True)):
        assert rests(contact, cycle, 0.5, load_factor) == at_rest
    assert [
        fo.safe_slip(contact, cycle, 0.5, lam).exists for lam in (0.9, 1.1, 1.2, 1.26, 1.66)
    ] == [True, False, False, True, True]


def test_a_node_that_the_corners_lift_rests_open_far_above_the_limit_which_no_search_near_it_finds():
    """No search near the limit finds this. The node is pressed by 1, lifted by lam at both corners,
    and sheared by +-lam. Closed, it slips where 0.5 (1 - lam) < lam; from lam = 1 on it is open."""
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": -1.0, "Q": 1.0}, {"N": -1.0, "Q": -1.0}])
    limit = fo.shakedown_limit(NODE, cycle, 0.5)
    assert (limit.least, limit.load_factor) == (0.0, pytest.approx(1 / 3))
    assert "at higher load factors the contact may shake down again" in limit.covers
    closed = fo.shakedown_limit(NODE, cycle, 0.5, open_nodes=[False])
    assert "the contact may shake down above it" in closed.covers
    for load_factor, at_rest in ((0.3, True), (0.5, False), (0.9, False), (1.1, True), (5.0, True)):
        assert rests(NODE, cycle, 0.5, load_factor) == at_rest


def test_a_static_load_opens_a_node_above_the_limit_of_the_closed_contact():
    """Node 1 slips as it is unloaded: without shear its pressure is 1 - lam - 0.006 lam.

    Above 1 / 1.006 it opens, and any load finds a state of rest.
    """
    B = np.diag([0.0, 0.01])
    pair = system(np.eye(2), B, 0.0, [2.0, 1.0], [0.5, 0.6], [0.0, -1.0])
    static = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}])
    closed = fo.shakedown_limit(pair, static, 0.5, open_nodes=[False, False])
    assert closed.load_factor == pytest.approx(1 / 1.006)
    assert "at which a body slides off" in closed.reason
    limit = fo.shakedown_limit(pair, static, 0.5)
    assert limit.load_factor == np.inf and limit.open.tolist() == [False, True]
    steady = fo.steady_state(pair, static, 0.5, 1.5)
    assert steady.outcome is fo.Outcome.SHAKEDOWN


def test_a_static_load_opens_no_further_nodes_of_a_large_contact():
    """The search opens only the nodes that the mean load opens, here none."""
    contact, static, friction = block(47, nodes=16, corners=1)
    limit = fo.shakedown_limit(contact, static, friction)
    assert "at which a body slides off" in limit.reason
    assert not fo.march(contact, static, friction, 0.0, cycles=1).gap[-1].any()
    assert not limit.open.any()
    (corner,) = static.corners
    twice = fo.LoadCycle(static.mean, [corner, corner])
    again = fo.shakedown_limit(contact, twice, friction)
    assert again.load_factor == pytest.approx(limit.load_factor) and again.reason == limit.reason


@pytest.mark.parametrize(
    ("lift", "pressed", "friction", "other"), [(0.5, 0.1, 1.2, 0.6), (-0.5, -0.05, 0.7, 1.05)]
)
def test_the_search_begins_with_what_the_mean_load_opens_with_less_or_more_friction(
    lift, pressed, friction, other
):
    """A mean shear of 1 slips node 0 by 1 - f where f < 1. By half of the slip this lifts node 1,
    which is pressed by 0.1, or it presses node 1, which is pulled by 0.05."""
    pair = system(np.eye(2), [[0.0, 0.0], [lift, 0.0]], [1.0, 0.0], [1.0, pressed], [0.1, 0.0], 0.0)
    starts = settled_sets(pose(pair, CYCLE, friction), tending=True, safe=True)
    assert not fo.march(pair, CYCLE, friction, 0.0, cycles=1).gap.any()
    assert fo.march(pair, CYCLE, other, 0.0, cycles=1).gap[-1, 1] > 0.0
    assert [False, True] in [opened.tolist() for opened in starts]


def test_the_search_looks_beside_the_set_that_the_mean_load_opens_with_least_friction():
    """A plain program with 19 nodes of a block open has a limit that the search has to reach.

    The best of the sets that the mean load opens has .441 at most, and so have sets beside it.
    """
    contact, cycle, friction = block(6, 30)
    opened = np.ones(30, dtype=bool)
    opened[[15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 27]] = False
    _, largest = interval_of_set(contact, cycle, friction, opened)
    assert largest > 0.5
    assert fo.shakedown_limit(contact, cycle, friction).load_factor >= largest * (1 - 1e-7)
