"""The certificate that no slip opens a node.

It is compared with linear programs in all slips and loads, and with transients.
"""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import frictopt as fo
from helpers import spatial
from helpers.cases import few
from helpers.separation import pulled_system
from helpers.systems import CYCLE, random_system

PIN = fo.LoadCycle({"fit": 1.0}, [{"Fx": -1.0}, {"Fx": 1.0}])
THREE = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0}, {"a": -0.7, "b": -0.8}])


def least_pressures(contact, cycle, friction, load_factor):
    """Least normal force of each node, (N,), by scipy.

    It is the least over all slips that friction holds, and over all mixtures of the mean load and
    the corners.
    """
    n, corners = contact.nodes, len(cycle.corners)
    (q0, p0) = contact.closed_reaction(cycle.mean)
    (q1, p1) = cycle.corner_reactions(contact)
    shear, normal = np.hstack([contact.A, q1.T]), np.hstack([contact.B, p1.T])
    less = np.vstack(
        [sign * shear - friction * normal for sign in (1, -1)]
        + [np.r_[np.zeros(n), np.ones(corners)][None]]
    )
    right = np.r_[friction * p0 - q0, friction * p0 + q0, load_factor]
    bounds = [(None, None)] * n + [(0, None)] * corners
    found = [linprog(row, less, right, bounds=bounds) for row in normal]
    return np.array(
        [each.fun + p if each.status == 0 else -np.inf for each, p in zip(found, p0, strict=True)]
    )


@settings(max_examples=few(20))
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(2, 5),
    f=st.floats(0.1, 1.0),
    more=st.floats(0.3, 3),
    coupling=st.sampled_from([0.0, 0.3, 1.0]),
)
def test_it_is_said_where_the_least_pressure_is_positive_and_nowhere_else(
    seed, nodes, f, more, coupling
):
    contact = random_system(
        np.random.default_rng(seed), nodes, loads=("mean", "a", "b"), coupling=coupling
    )
    limit = fo.shakedown_limit(contact, THREE, f)
    assume(limit.kind is fo.LimitKind.FINITE and limit.load_factor > 0 and not limit.open.any())
    least = least_pressures(contact, THREE, f, more * limit.load_factor).min()
    # It is 0 where some slip takes all pressure off a node, for friction holds none below.
    assume(not 1e-10 < least < 1e-7)
    assert limit.stays_closed(more * limit.load_factor) == (least > 1e-7)


@settings(max_examples=few(15))
@given(st.integers(0, 10**6))
def test_no_start_with_closed_nodes_opens_one_or_rests_above_the_limit(seed):
    rng = np.random.default_rng(seed)
    contact, f = random_system(rng, 3, coupling=0.3), float(rng.uniform(0.2, 0.8))
    limit = fo.shakedown_limit(contact, CYCLE, f)
    assume(
        limit.kind is fo.LimitKind.FINITE
        and limit.load_factor > 0
        and not limit.open.any()
        and limit.stays_closed(1.5 * limit.load_factor)
    )
    for load_factor in (1.05 * limit.load_factor, 1.5 * limit.load_factor):
        start = limit.slip + rng.normal(size=3) * np.abs(limit.slip).max()
        path = fo.march(contact, CYCLE, f, load_factor, initial_slip=start, cycles=4)
        assert path.gap.max() <= 1e-12
        assert (
            fo.steady_state(contact, CYCLE, f, load_factor, initial_slip=start).outcome
            is fo.Outcome.CYCLIC_SLIP
        )


@pytest.mark.parametrize(
    ("f", "limit", "up_to"), [(0.1, 0.5314, 1.5), (0.2, 1.0973, 1.0), (0.5, 2.4372, 0.0)]
)
def test_a_pin_stays_closed_up_to_a_load_that_falls_with_friction(f, limit, up_to):
    found = fo.shakedown_limit(fo.scenes.PinInPlate(elements=16).condense(), PIN, f)
    assert found.load_factor == pytest.approx(limit, abs=1e-4)
    assert [found.stays_closed(share * found.load_factor) for share in (1.0, 1.5, 3.0)] == [
        share <= up_to for share in (1.0, 1.5, 3.0)
    ]


@pytest.mark.parametrize("share", [0.3, 1.2])
@pytest.mark.parametrize("seed", few(range(4)))
def test_in_space_it_is_that_of_cone_programs_written_out(seed, share):
    contact = spatial.random_contact(np.random.default_rng(seed), 3)
    cycle = spatial.cycle()
    limit = fo.shakedown_limit(contact, cycle, 0.4)
    load_factor, n = share * limit.load_factor, contact.nodes
    r0, *r1 = (
        np.r_[q.T.ravel(), p]
        for q, p in (
            contact.closed_reaction(cycle.mean),
            *zip(*cycle.corner_reactions(contact), strict=True),
        )
    )
    v, shares = cp.Variable(2 * n), cp.Variable(len(r1), nonneg=True)
    r = r0 + np.transpose(r1) @ shares + contact.S[:, : 2 * n] @ v
    held = [cp.norm(cp.hstack([r[i], r[n + i]])) <= 0.4 * r[2 * n + i] for i in range(n)]
    least = min(
        cp.Problem(cp.Minimize(r[2 * n + i]), [*held, cp.sum(shares) <= load_factor]).solve(
            solver="CLARABEL"
        )
        for i in range(n)
    )
    assert not 1e-7 < least < 1e-3
    assert not limit.open.any()
    assert limit.stays_closed(load_factor) == (least > 1e-3)


def test_each_corner_may_open_a_node():
    """Each corner may open a node, by hand.

    One corner on its own presses the node less and less, down to zero at load factor 1.
    """
    loads = {"P": ([0.0], [1.0]), "shear": ([0.2], [0.0]), "lift": ([0.0], [-1.0])}
    node = fo.ContactSystem.from_blocks([[1.0]], [[0.1]], [[1.0]], [0.0], loads)
    corners = [{"shear": 1.0}, {"lift": 1.0}]
    for order in (corners, corners[::-1]):
        limit = fo.shakedown_limit(node, fo.LoadCycle({"P": 1.0}, order), 0.5)
        assert limit.stays_closed(0.9) and not limit.stays_closed(1.1)


def test_nothing_is_said_with_open_nodes_or_of_a_load_factor_that_is_none():
    contact = pulled_system(np.random.default_rng(1), 4)
    limit = fo.shakedown_limit(contact, CYCLE, 0.5)
    assert limit.open.any() and not limit.stays_closed(limit.load_factor)
    with pytest.raises(fo.ModelError, match="load_factor"):
        limit.stays_closed(-1.0)
