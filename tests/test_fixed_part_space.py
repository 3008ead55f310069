"""Load cycles in space of which a part is fixed: against cone programs with one circle for each corner, transients, and by hand."""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import frictopt as fo
from spatial import random_contact, vectors


def in_space(seed):
    """A coupled contact, its friction, and a cycle whose corners differ at load factor 0."""
    rng = np.random.default_rng(seed)
    nodes = int(rng.integers(1, 6))
    contact = random_contact(rng, nodes, coupling=rng.choice([0.0, 0.5]))
    contact = fo.ContactSystem(contact.S, contact.points, vectors(contact) | {name: 0.3 * rng.normal(size=3 * nodes) for name in "de"})
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"a": -1.0}, {"b": 0.7}], [{"d": 0.6}, {}, {"e": -0.5}])
    return contact, cycle, rng.uniform(0.3, 0.8, size=nodes)


@settings(max_examples=15)
@given(st.integers(0, 10**6))
def test_a_limit_in_space_is_that_of_circles_at_all_corners(seed):
    contact, cycle, f = in_space(seed)
    lam, v, circles = cp.Variable(nonneg=True), cp.Variable(2 * contact.nodes), []
    for loads, corner in zip(cycle.unscaled, cycle.corners, strict=True):
        (q0, p0), (q1, p1) = contact.reaction(loads), contact.reaction(corner)
        slipped = cp.reshape(contact.A @ v, (contact.nodes, 2), order="F")
        circles.append(cp.SOC(cp.multiply(f, p0 + lam * p1 + contact.B @ v), q0 + lam * q1 + slipped, axis=1))
    problem = cp.Problem(cp.Maximize(lam), circles)
    problem.solve(solver="CLARABEL")
    limit = fo.shakedown_limit(contact, cycle, f)
    assume(not limit.open.any())
    if problem.status == "optimal":
        assert limit.load_factor == pytest.approx(problem.value, rel=1e-6) and limit.residual <= 1e-9
        assert fo.safe_slip(contact, cycle, f, 0.5 * (limit.least + limit.load_factor)).exists
    else:
        assert not np.isfinite(limit.load_factor)


@pytest.mark.parametrize("seed", [1, 3])
def test_a_transient_in_space_rests_on_a_safe_slip(seed):
    contact, cycle, f = in_space(seed)
    limit = fo.shakedown_limit(contact, cycle, f)
    below = limit.least + 0.98 * (limit.load_factor - limit.least)
    state = fo.safe_slip(contact, cycle, f, below).state
    assert fo.steady_state(contact, cycle, f, below, initial_state=state, steps=4).outcome is fo.Outcome.SHAKEDOWN


def test_a_node_in_space_that_nothing_presses_at_some_corners():
    """Node 0 has no bound where a corner leaves it bare, so no shear then; it carries one load factor alone, 2, or only those of the other node."""
    S = np.eye(6)
    loads = {"P": [0, 0, 0, 0, 0, 1.0], "X": [1.0, 0.2, 0, 0, 0, 0], "Q": [2.0, 0, 0, 0, 0, 0], "N": [0, 0, 0, 0, 1.0, 0]}
    pair = fo.ContactSystem(S, [[0.0, 0, 0], [1.0, 0, 0]], loads)
    free = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": 1.0}, {"X": -1.0}], [{}, {}, {"N": 9.0}])
    assert fo.shakedown_limit(pair, free, 0.5).load_factor == pytest.approx(2.25)  # 2 q1 <= 0.5 * 9 at node 0, 2 * 0.2 q1 <= 2 * 0.5 at node 1
    meets = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {}], [{}, {"Q": 1.0}])
    limit = fo.shakedown_limit(pair, meets, 0.5)
    assert (limit.load_factor, limit.least) == pytest.approx((2.0, 2.0), rel=1e-6)
    parted = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}], [{}, {"N": 0.0, "P": 0.5}])
    assert fo.shakedown_limit(pair, parted, 0.5).load_factor == 0.0


def test_a_corner_in_space_whose_fixed_part_alone_is_outside_of_the_hull_of_the_others_counts():
    """Bounds of 1.5 hold a shear of 2 only with a slip of -0.5 or less, and then the cyclic shear only up to 1."""
    node = fo.ContactSystem(np.eye(3), [[0.0, 0.0, 0.0]], {"P": [0.0, 0.0, 3.0], "X": [1.0, 0.0, 0.0]})
    cycle = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}, {}], [{}, {}, {"X": 2.0}])
    assert fo.shakedown_limit(node, cycle, 0.5).load_factor == pytest.approx(1.0)
