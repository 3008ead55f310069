"""The limit with separation against closed forms, every pattern of open nodes, transients, and the published cases of rounded punches."""

import pickle
import re
from importlib import import_module
from itertools import product

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
import spatial
from frictopt.limits.question import pose
from frictopt.limits.separated_sets import open_set_limit
from frictopt.solve import solvers as policy
from separation import pulled_system, resting_starts, rests
from studies.validation.open_patterns import every_pattern, largest_with_open
from systems import CYCLE, NODE, explained, system

ROUNDED = [  # elements, rounding, open nodes at each side, limit with them open
    (24, 20.0, 4, 0.7821287715),
    (48, 20.0, 8, 0.4481514660),
    (24, 100.0, 6, 1.9856619085),
    pytest.param(48, 100.0, 11, 0.6026058693, marks=pytest.mark.slow),
    pytest.param(96, 100.0, 22, 0.48761, marks=pytest.mark.slow),
]
THREE = fo.LoadCycle({"mean": 1.0}, [{"cyclic": -1.0}, {"cyclic": 0.8}, {"cyclic": 0.3}])


def rounded(contact, size, flat=0.6):
    return contact.with_gap(size * np.maximum(np.abs(contact.x) - flat, 0.0) ** 2)


@pytest.mark.parametrize(("elements", "size", "count", "limit"), ROUNDED)
def test_rounded_punches_by_sets_of_open_nodes(elements, size, count, limit, punch, paper_cycle):
    contact = rounded(punch(elements, grading=3, growth=1.09), size)
    best = fo.separated_limit(contact, paper_cycle, 0.6)
    assert best.load_factor == pytest.approx(limit, abs=1e-5 if elements == 96 else 1e-8)
    ends = (np.arange(contact.nodes) < count) | (np.arange(contact.nodes) >= contact.nodes - count)
    assert np.array_equal(best.open, ends) and best.residual < 1e-9
    assert best.bound == np.inf and "booleans is not tried" in best.reason and best.largest_slip == np.abs(best.slip[~ends]).max()
    assert rests(contact, paper_cycle, 0.6, 0.999 * limit, initial_slip=best.slip)
    assert not rests(contact, paper_cycle, 0.6, 1.01 * limit, initial_slip=best.slip)


def test_one_node_on_a_vertical_spring_opens_and_never_slips():
    contact = system(1.0, 0.0, 0.0, 2.0, 0.0, 1.0, C=[[3.0]])
    limit = fo.separated_limit(contact, CYCLE, 0.5)
    assert limit.load_factor == pytest.approx(2.0) == fo.shakedown_limit(contact, CYCLE, 0.5).load_factor
    assert limit.bound == np.inf and "at any load factor" in limit.reason and not limit.open.any()
    beyond = fo.limit_after_protocol(contact, CYCLE, 0.5, start=limit.slip, up_to=100.0)
    assert beyond.load_factor == pytest.approx(100.0) and beyond.upper == np.inf  # it opens and closes in each cycle
    sheared = system(1.0, 0.0, 0.0, 2.0, 1.0, 0.5, C=[[3.0]])  # slips at f p0 / q1, still closed
    assert fo.separated_limit(sheared, CYCLE, 0.5).load_factor == pytest.approx(1.0, rel=1e-9)


def test_an_open_node_that_presses_the_one_that_rules_is_not_taken_for_slip():
    """The mean load pulls both nodes; open by 0.5, the first presses the second with 0.3, which slips at f p = 0.15."""
    contact = system(np.eye(2), np.zeros((2, 2)), 0.0, [-1.0, -0.2], [0.0, 1.0], 0.0, C=[[2.0, 1.0], [1.0, 2.0]])
    limit = fo.shakedown_limit(contact, CYCLE, 0.5)
    assert limit.load_factor == pytest.approx(0.15) and limit.open.tolist() == [True, False] and "residual slip alone" not in limit.reason


@pytest.mark.parametrize(("seed", "cycle", "most_nodes"), [(seed, CYCLE, 3) for seed in range(2, 10)] + [(seed, THREE, 2) for seed in range(20, 25)])
def test_small_contacts_against_every_pattern_of_open_nodes(seed, cycle, most_nodes):
    """The limit against every set of nodes that stay open, the bound against every pattern at the corners."""
    rng = np.random.default_rng(seed)
    contact, friction = pulled_system(rng, int(rng.integers(1, most_nodes + 1))), float(rng.uniform(0.1, 1.0))
    limit = fo.separated_limit(contact, cycle, friction)
    most = float(re.search(r"up to (\S+)", limit.covers)[1])
    sets = [np.tile(opened, (len(cycle.corners), 1)) for opened in product([False, True], repeat=contact.nodes)]
    constant = [claim[0] for claim in (largest_with_open(contact, cycle, friction, opened, most) for opened in sets) if claim]
    assert max(constant, default=np.nan) == pytest.approx(limit.load_factor, rel=1e-6, nan_ok=True)
    tried = every_pattern(contact, cycle, friction, most)
    if np.isfinite(limit.bound):
        assert limit.bound == pytest.approx(max(tried[0][0], limit.load_factor), rel=1e-6)
    else:
        assert "at any load factor" in limit.reason and tried[0][0] == pytest.approx(most, rel=1e-6)


@pytest.mark.parametrize("seed", range(1000, 1006))
def test_random_contacts_rest_at_the_limit_and_above_a_proven_one_nothing_does(seed):
    rng = np.random.default_rng(seed)
    contact, friction = pulled_system(rng, int(rng.integers(2, 4))), float(rng.uniform(0.1, 1.0))
    limit, closed = fo.separated_limit(contact, CYCLE, friction), fo.shakedown_limit(contact, CYCLE, friction)
    assert (limit.residual <= 1e-9 and limit.bound >= limit.load_factor) or np.isnan(limit.bound)
    if limit.state is None or np.isinf(limit.load_factor):
        return
    assert not limit.load_factor < closed.load_factor
    assert rests(contact, CYCLE, friction, limit.load_factor, initial_state=limit.state)
    for factor in (1 + 2e-6, 1.001, 1.05, 1.5) if limit.proven else ():
        assert not resting_starts(contact, CYCLE, friction, factor * limit.load_factor, limit.slip, 10, rng), factor


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("large", [1, 400])
def test_sets_of_open_nodes_are_given_up_only_where_their_limit_is_not_above_a_load_factor(seed, large, monkeypatch):
    monkeypatch.setattr("frictopt.solve.chain._LARGE", large)
    rng = np.random.default_rng(seed)
    contact, opened = spatial.random_contact(rng, 6), np.arange(6) < seed % 3
    cases = {name: r + (name == "mean") * np.r_[np.zeros(12), -5.0 * opened] for name, r in spatial.vectors(contact).items()}
    contact = fo.ContactSystem(contact.S, contact.points, cases)
    model, task = fo.ShakedownModel(contact, spatial.cycle()), pose(contact, spatial.cycle(), 0.6)
    limit = open_set_limit(model, task, opened)
    assert limit is not None and 0 < limit.load_factor < np.inf
    for share in (0.5, 0.999, 1 - 1e-7):
        found = open_set_limit(model, task, opened, share * limit.load_factor)
        assert (found.load_factor, found.bound) == pytest.approx((limit.load_factor, limit.load_factor), rel=1e-8)
    for share in (1.001, 3.0):
        with pytest.raises(fo.SolverError, match="so not above"):
            open_set_limit(model, task, opened, share * limit.load_factor)


def test_programs_that_were_solved_before_with_several_threads_change_nothing():
    """As HiGHS does by default on three processors and more."""
    contact = system(1.0, 0.0, 0.0, 2.0, 1.0, 0.5, C=[[3.0]])
    alone = fo.separated_limit(contact, CYCLE, 0.5)
    cp.Problem(cp.Maximize(cp.Variable(boolean=True))).solve(solver="HIGHS", highs_options={"threads": 2})
    after = fo.separated_limit(contact, CYCLE, 0.5)
    assert (after.load_factor, after.bound, after.reason) == (alone.load_factor, alone.bound, alone.reason)


def test_what_is_said_of_it(paper_cycle):
    flat = fo.scenes.PunchOnHalfPlane(elements=4).condense()
    limit = fo.separated_limit(flat.with_gap(2.0 * flat.x**4), paper_cycle, 0.6)
    assert limit.proven and limit.kind is fo.LimitKind.FINITE
    assert "no state above it" in limit.reason and "opens or closes at most once" in limit.covers
    text = explained(limit)
    assert limit.reason in text and limit.covers in text and "opened                   2 x 5, boolean" in text
    assert limit.problem.is_mixed_integer() and pickle.loads(pickle.dumps(limit)).load_factor == limit.load_factor
    table = limit.to_frame()
    assert list(table.columns) == ["node", "x", "slip", "open", "gap"] and np.array_equal(table["open"], limit.open)
    assert np.array_equal(limit.slip, limit.state.slip) and not limit.slip.flags.writeable


@pytest.mark.parametrize(("name", "value", "reason"), [("_MOTION", 0.3, "a big-M bound is active"), ("_PRESSURE", 0.3, "outside of what the bound")])
def test_an_answer_that_touches_the_largest_motion_or_pressure_is_no_bound(name, value, reason, monkeypatch):
    monkeypatch.setattr(import_module("frictopt.limits.separated_limit"), name, value)
    limit = fo.separated_limit(pulled_system(np.random.default_rng(3), 3), CYCLE, 0.5)
    assert limit.bound == np.inf and not limit.proven and reason in limit.reason


def test_a_contact_that_is_pulled_apart_has_no_state_of_rest(punch):
    limit = fo.separated_limit(punch(8), fo.LoadCycle({"P": -1.0}, [{"sigma": 1.0}, {"sigma": -1.0}]), 0.6)
    assert np.isnan(limit.load_factor) and limit.state is None and not limit.open.any() and np.isnan(limit.slip).all()
    assert "the mean load pulls the bodies apart" in limit.reason and limit.reason in repr(limit)
    assert limit.proven and f"finds none at load factors up to {limit.covers.split()[-1]}: " in limit.reason


def test_all_nodes_open_for_ever():
    contact = system(1.0, 0.0, 0.2, -1.0, 0.5, 0.5, C=[[1.0]])  # open as long as 0.5 lam <= 1
    limit = fo.separated_limit(contact, CYCLE, 0.5)
    assert limit.load_factor == pytest.approx(2.0) and limit.open.all() and not np.any(limit.reactions)


def test_a_node_that_the_mean_load_opens_and_all_corners_open_further_rests_at_every_load_factor():
    node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0])})
    limit = fo.separated_limit(node, fo.LoadCycle({"P": -1.0}, [{"P": -1.0}, {"P": -2.0}]), 0.5)
    assert (limit.least, limit.load_factor) == (0.0, np.inf) and limit.open.all()
    assert np.isnan(limit.slip).all() and np.isnan(limit.largest_slip)


def test_where_rounding_hides_the_least_load_factor_it_is_said_so():
    """Sheared to and fro by 0.04 with a friction of 1e-6: it rests only once the load has pressed the node some 1e5 times."""
    loads = {"P": ([0.0], [0.5]), "Q": ([1.0], [0.0]), "N": ([-1.4], [-0.06])}
    node = fo.ContactSystem.from_blocks([[1.0]], [[-0.05]], [[1.0]], [0.0], loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": -1.0}] * 2, fixed=[{"Q": 0.4}, {"Q": 0.36}])
    limit = fo.separated_limit(node, cycle, 1e-6)
    assert limit.load_factor == np.inf and limit.least != 0
    assert "at every load factor from" in limit.reason and ("from some on" in limit.reason or limit.least > 0)
    assert not rests(node, cycle, 1e-6, 1.0)


def test_a_search_tree_without_nodes_left_says_what_to_give(punch, paper_cycle):
    limit = fo.separated_limit(rounded(punch(12), 2.0), paper_cycle, 0.6, most_nodes=1)
    assert limit.bound == np.inf and "separated_limit(..., most_nodes=...)" in limit.reason
    with pytest.raises(fo.ModelError, match="most_nodes"):
        fo.separated_limit(punch(4), paper_cycle, 0.6, most_nodes=0)


def test_where_the_solver_of_the_bound_fails_the_reason_says_so(punch, paper_cycle, monkeypatch):
    monkeypatch.setattr(policy, "_HIGHS_BOUND", {"threads": -1})
    limit = fo.separated_limit(rounded(punch(4), 2.0), paper_cycle, 0.6)
    assert limit.bound == np.inf and "HiGHS fails: " in limit.reason and "(threads, -1)" in limit.reason and "nodes left" not in limit.reason


@pytest.mark.parametrize("shear", [0.3, 0.0])
def test_nodes_that_only_the_corners_press_rest_in_an_interval(shear):
    """Node 0 is open always, node 1 sticks if 0.1 lam <= 0.5 (lam - 1), node 2 if `shear` lam <= 0.5. Below, node 1 slips unless it is open too."""
    loads = {"P": ([0, 0, 0], [-5.0, -1.0, 1.0]), "N": ([0, 0, 0], [0, 1.0, 0]), "Q": ([0, 0.1, shear], [0, 0, 0])}
    contact = fo.ContactSystem.from_blocks(np.eye(3), np.zeros((3, 3)), np.eye(3), [0, 1, 2], loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": 1.0, "Q": 1.0}, {"N": 1.0, "Q": -1.0}])
    limit = fo.separated_limit(contact, cycle, 0.5)
    assert limit.proven and limit.load_factor == pytest.approx(5 / 3 if shear else np.inf) and limit.least == pytest.approx(1.25)
    assert "from 1.25 on" in limit.reason
    for load_factor, at_rest in ((1.1, False), (1.2, False), (1.26, True), (1.66, True)):
        assert rests(contact, cycle, 0.5, load_factor) == at_rest


def test_a_node_that_the_corners_lift_rests_open_from_some_load_on():
    """Pressed by 1 and lifted by lam at both corners, sheared by +-lam: closed it slips where 0.5 (1 - lam) < lam, from lam = 1 on it is open."""
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": -1.0, "Q": 1.0}, {"N": -1.0, "Q": -1.0}])
    model, task = fo.ShakedownModel(NODE, cycle), pose(NODE, cycle, 0.5)
    opened, closed = (open_set_limit(model, task, np.array([state])) for state in (True, False))
    assert (opened.least, opened.load_factor) == (1.0, np.inf) and (closed.least, closed.load_factor) == (0.0, pytest.approx(1 / 3))
    limit = fo.separated_limit(NODE, cycle, 0.5)
    assert (limit.least, limit.load_factor) == (1.0, np.inf) and "at every load factor from 1 on" in limit.reason
    assert fo.shakedown_limit(NODE, cycle, 0.5).load_factor == pytest.approx(1 / 3)
    for load_factor, at_rest in ((0.3, True), (0.5, False), (0.9, False), (1.1, True), (5.0, True)):
        assert rests(NODE, cycle, 0.5, load_factor) == at_rest


def test_nodes_that_rest_open_only_together_and_far_above_the_limit_are_found():
    """Closed, nodes 0 and 1 slip where 0.5 (p0 - lam) < lam, from 1/3 and 0.4 on; open they are from 1 and 1.2 on. Node 2 sticks up to 5."""
    loads = {"P": ([0, 0, 0], [1.0, 1.2, 10.0]), "N": ([0, 0, 0], [1.0, 1.0, 0]), "Q": ([1.0, 1.0, 1.0], [0, 0, 0])}
    contact = fo.ContactSystem.from_blocks(np.eye(3), np.zeros((3, 3)), np.eye(3), [0, 1, 2], loads)
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": -1.0, "Q": 1.0}, {"N": -1.0, "Q": -1.0}])
    assert fo.shakedown_limit(contact, cycle, 0.5).load_factor == pytest.approx(1 / 3)
    limit = fo.separated_limit(contact, cycle, 0.5)
    assert limit.open.tolist() == [True, True, False] and limit.proven
    assert (limit.least, limit.load_factor) == (pytest.approx(1.2), pytest.approx(5.0))
    for load_factor, at_rest in ((0.3, True), (0.5, False), (1.1, False), (1.3, True), (4.9, True), (5.1, False)):
        assert rests(contact, cycle, 0.5, load_factor) == at_rest
