"""Slip bounds, constraints and objectives of the user's own in space: against cone programs over raw slips, and against the plane."""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.limits.required_friction import best_pressed
from spatial import cycle, random_contact, single
from systems import explained


def test_constraints_on_a_contact_with_a_node_without_friction_say_that_nothing_is_safe():
    loads = {"P": [0, 0, 0, 0, 1, 1], "X": [1, 0.4, 0, 0, 0, 0], "Y": [0, 0, 1, 0.3, 0, 0]}
    pair = fo.ContactSystem(np.eye(6), [[0, 0, 0], [1, 0, 0]], loads)
    model = fo.ShakedownModel(pair, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"Y": 1.0}]))
    small = cp.norm(model.slip, 2, axis=1) <= 0.1
    with pytest.raises(fo.ModelError, match="constraints: node 1 has no friction"):
        model.solve([0.5, 0.0], [small])
    assert model.solve([0.5, 0.0]).load_factor == 0.0
    limit = model.solve([0.5, 0.3], [small])
    assert limit.kind.name == "FINITE" and np.linalg.norm(limit.slip, axis=1).max() <= 0.1 + 1e-9
    printed = explained(limit)
    assert "1 of 2 rows bind" in printed
    with pytest.raises(fo.ModelError, match="PSD cone"):
        model.solve([0.5, 0.3], [cp.norm(model.slip, 2) <= 0.1])


def test_a_bound_is_a_circle_whatever_the_directions_of_the_tangents():
    """One node, unit stiffness, sheared to one side by 2 q: it needs a slip of q to be centred, and carries f p + most without more."""
    turned = np.deg2rad(31.0)
    pull = fo.LoadCycle({"P": 1.0}, [{"X": 2 * np.cos(turned), "Y": 2 * np.sin(turned)}, {"P": 0.0}])
    limit = fo.shakedown_limit(single(), pull, 0.5, slip_bound=0.25)
    assert limit.load_factor == pytest.approx((0.5 + 0.25) / 2, rel=1e-8) and limit.largest_slip == pytest.approx(0.25, rel=1e-8)
    printed = explained(limit)
    assert "slip_bound" in printed and "1 of 1 rows bind" in printed


@pytest.mark.parametrize("seed", range(5))
def test_no_friction_is_enough_in_space_where_no_slip_presses_a_node(seed):
    """Against the least pressure by a linear program over raw slips; where it is negative the answer is inf."""
    rng = np.random.default_rng(seed)
    contact, load_factor = random_contact(rng, 2, coupling=0.2), 40.0
    least, v = cp.Variable(), cp.Variable(4)
    p0, p1 = cycle().mean_reaction(contact)[1], cycle().corner_reactions(contact)[1]
    rows = [p0 + load_factor * p + contact.B @ v >= least for p in p1] + [cp.abs(v) <= 0.1]
    bound = np.full(2, 0.1)
    pressed = best_pressed(contact, cycle(), load_factor, bound)[0]
    cp.Problem(cp.Maximize(least), [*rows[:-1], cp.norm(cp.reshape(v, (2, 2), order="F"), 2, axis=1) <= bound]).solve(solver="CLARABEL")
    force = float(np.abs(p0).mean())
    assert pressed.least == pytest.approx(min(least.value / force, 1.0), rel=1e-6) and pressed.residual <= 1e-9
    if pressed.least < -1e-6:
        answer = fo.required_friction(contact, cycle(), load_factor, slip_bound=0.1)
        assert answer.required == np.inf and "at (" in answer.reason and len(answer.mechanism)
