"""Objectives of the user's own in the shakedown limit, against linear programs over raw slips with every row of every corner."""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

import frictopt as fo
from systems import CYCLE, corner_rows, random_system
from test_own_constraints import TWO
from test_slip_bound import freed


@settings(max_examples=40)
@given(seed=st.integers(0, 10**6), f=st.floats(0.1, 1.0), cost=st.sampled_from([0.0, 0.3, 3.0]), free=st.booleans())
def test_an_objective_against_all_signs_of_the_slip(seed, f, cost, free):
    """Largest `2 load_factor - cost * sum abs(v)`: the best over the signs of v, in each of which it is linear."""
    contact = random_system(np.random.default_rng(seed), 3)
    contact = freed(contact) if free else contact
    rows, right = corner_rows(contact, CYCLE, f)
    best = -np.inf
    for signs in np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T:
        bounds = [(0, None) if sign > 0 else (None, 0) for sign in signs] + [(0, None)]
        answer = linprog(np.append(cost * signs, -2.0), rows.reshape(-1, 4), right.ravel(), bounds=bounds)
        best = max(best, -answer.fun) if answer.status == 0 else best
    model = fo.ShakedownModel(contact, CYCLE)
    limit = model.solve(f, objective=2 * model.load_factor - cost * cp.norm1(model.slip))
    assert (limit.kind is fo.LimitKind.FINITE) == np.isfinite(best)
    if np.isfinite(best):
        assert [limit.objective, limit.bound] == pytest.approx([best, best], rel=1e-7, abs=1e-8)
        assert 2 * limit.load_factor - cost * np.abs(limit.slip).sum() == pytest.approx(limit.objective, abs=1e-8)
        assert (
            limit.load_factor <= fo.shakedown_limit(contact, CYCLE, f).load_factor * (1 + 1e-8)
            and "no limit" in limit.reason
            and f"objective={limit.objective:.6g}" in repr(limit)
        )


def test_the_rate_of_an_objective_is_its_slope():
    contact = random_system(np.random.default_rng(1), 3)
    model = fo.ShakedownModel(contact, CYCLE)
    goal = 3 * model.load_factor - 0.4 * cp.norm1(model.slip)
    low, at, high = (model.solve(f, objective=goal) for f in (0.4 - 1e-5, 0.4, 0.4 + 1e-5))
    assert at.friction_rate.sum() == pytest.approx((high.objective - low.objective) / 2e-5, rel=1e-3)
    assert at.load_rates.rate.isna().all()


@pytest.mark.parametrize(
    ("objective", "message"),
    [
        (lambda model: 3.0, "objective: 3.0"),
        (lambda model: model.slip, "objective: .*scalar"),
        (lambda model: cp.norm1(model.slip), "objective: not convex"),
        (lambda model: cp.sum(cp.Variable(2)), "objective: it grows without end"),
    ],
)
def test_bad_objectives_are_refused(objective, message):
    model = fo.ShakedownModel(*TWO)
    with pytest.raises(fo.ModelError, match=message):
        model.solve(0.4, objective=objective(model))
