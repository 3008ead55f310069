"""Slip bounds, constraints and objectives of the user's own in space: against cone programs over raw slips, and against the plane."""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from frictopt.limits.pressing import best_pressed
from spatial import cycle, random_contact, single
from studies.validation.fuzz.embedded import embedded
from systems import CYCLE, explained, random_system


class Oracle:
    """Raw slips, load factor and reactions of a contact in space, with a circle for each node at each corner."""

    def __init__(self, contact, f, loads, most=None):
        n, (q0, p0), (q1, p1) = contact.nodes, loads.mean_reaction(contact), loads.corner_reactions(contact)
        self.lam, self.v = cp.Variable(), cp.Variable((n, 2))
        flat = cp.vec(self.v, order="F")
        shear, self.p = cp.reshape(contact.A @ flat, (n, 2), order="F"), [p0 + self.lam * p + contact.B @ flat for p in p1]
        self.q = [q0 + self.lam * q + shear for q in q1]
        self.rows = [cp.norm(q, 2, axis=1) <= f * p for q, p in zip(self.q, self.p, strict=True)] + [self.lam >= 0]
        self.rows += [] if most is None else [cp.norm(self.v, 2, axis=1) <= most]

    def largest(self, own=(), goal=None):
        problem = cp.Problem(cp.Maximize(self.lam if goal is None else goal), [*self.rows, *own])
        problem.solve(solver="CLARABEL")
        return problem.status, problem.value


def agrees(limit, status, value):
    kinds = {"optimal": "FINITE", "infeasible": "NO_SAFE_SLIP", "unbounded": "UNBOUNDED"}
    assert limit.kind.name == kinds[status] and limit.residual <= 1e-9
    if status == "optimal":
        assert limit.load_factor == pytest.approx(value, rel=1e-6, abs=1e-7) and limit.bound == pytest.approx(limit.load_factor, rel=1e-8, abs=1e-8)


@settings(max_examples=15)
@given(seed=st.integers(0, 10**6), nodes=st.integers(1, 5), f=st.floats(0.1, 1.2), size=st.sampled_from([0.0, 0.02, 0.2, 5.0]))
def test_slips_at_most_so_large(seed, nodes, f, size):
    rng = np.random.default_rng(seed)
    contact, most = random_contact(rng, nodes), size * rng.uniform(0.5, 2.0, nodes)
    limit = fo.shakedown_limit(contact, cycle(), f, slip_bound=most)
    agrees(limit, *Oracle(contact, f, cycle(), most).largest())
    if limit.kind.name == "FINITE":
        assert (np.linalg.norm(limit.slip, axis=1) <= most * (1 + 1e-12)).all()
        safe = fo.safe_slip(contact, cycle(), f, limit.load_factor, slip_bound=most)
        assert safe.margin == pytest.approx(0.0, abs=1e-8)


@settings(max_examples=10)
@given(seed=st.integers(0, 10**6), f=st.floats(0.2, 1.0), at=st.floats(-0.1, 0.1))
def test_rows_equations_and_norms_of_slip_load_factor_and_reactions(seed, f, at):
    rng = np.random.default_rng(seed)
    contact, weights = random_contact(rng, 3), rng.normal(size=(3, 2))
    model, oracle = fo.ShakedownModel(contact, cycle()), Oracle(contact, f, cycle())
    own = [
        cp.sum(cp.multiply(weights, model.slip)) == at,
        cp.norm(model.slip[0]) <= 0.1 + 0.01 * model.load_factor,
        model.q[1, 2, 0] <= 0.9 * f * model.p[1, 2],
        cp.norm(model.q[2, 1]) <= 0.8 * f * model.p[2, 1],
    ]
    same = [
        cp.sum(cp.multiply(weights, oracle.v)) == at,
        cp.norm(oracle.v[0]) <= 0.1 + 0.01 * oracle.lam,
        oracle.q[1][2, 0] <= 0.9 * f * oracle.p[1][2],
        cp.norm(oracle.q[2][1]) <= 0.8 * f * oracle.p[2][1],
    ]
    status, value = oracle.largest(same)
    agrees(model.solve(f, own), status, value)
    if status == "optimal" and value > 1e-3:
        chosen = model.solve(f, [*own, model.load_factor >= value / 2], objective=-cp.norm(cp.vec(model.slip, order="F")))
        expected = oracle.largest([*same, oracle.lam >= value / 2], -cp.norm(cp.vec(oracle.v, order="F")))[1]
        assert chosen.objective == pytest.approx(expected, rel=1e-5, abs=1e-6) and chosen.bound == pytest.approx(chosen.objective, rel=1e-7, abs=1e-8)


@pytest.mark.parametrize("seed", range(6))
def test_a_plane_contact_in_space_has_the_answers_of_the_plane(seed):
    """Slip bound, a constraint on one slip, required friction with a bound, and the constraint in the margin."""
    rng = np.random.default_rng(seed)
    flat = random_system(rng, int(rng.integers(1, 5)))
    solid, along = embedded(flat, rng)
    f, most = rng.uniform(0.2, 0.8), rng.uniform(0.02, 0.4)
    pair = [fo.shakedown_limit(contact, CYCLE, f, slip_bound=most) for contact in (flat, solid)]
    assert pair[0].kind is pair[1].kind and pair[0].load_factor == pytest.approx(pair[1].load_factor, rel=1e-7, nan_ok=True)
    needed = [fo.required_friction(contact, CYCLE, 0.2, slip_bound=most).required for contact in (flat, solid)]
    assert needed[0] == pytest.approx(needed[1], rel=2e-5)
    models = [fo.SafeSlipModel(contact, CYCLE) for contact in (flat, solid)]
    first = models[0].slip[0], models[1].slip[0] @ along[0]
    margins = [model.solve(f, 0.3, [slip <= -0.05]).margin for model, slip in zip(models, first, strict=True)]
    assert margins[0] == pytest.approx(margins[1], abs=1e-7)


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


def test_constraints_that_nothing_obeys_are_named_and_an_objective_without_end_is_refused():
    contact = random_contact(np.random.default_rng(1), 3)
    model = fo.ShakedownModel(contact, cycle())
    above = model.solve(0.4).load_factor * 1.01
    small, large = (cp.norm(model.slip[0]) <= 10.0).set_label("small"), (model.load_factor >= above).set_label("service load")
    limit = model.solve(0.4, [small, large])
    assert limit.kind.name == "NO_SAFE_SLIP" and "obeys service load:" in limit.reason
    safe = fo.SafeSlipModel(contact, cycle())
    with pytest.raises(fo.ModelError, match=r"obeys this at load factor 0\.1"):
        safe.solve(0.4, 0.1, [safe.slip >= 1, cp.norm(safe.slip[0]) <= 1])
    free = fo.ContactSystem(np.zeros((3, 3)), [[0, 0, 0]], {"P": [0, 0, 1.0], "X": [1, 0, 0]})
    endless = fo.ShakedownModel(free, fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}]))
    with pytest.raises(fo.ModelError, match="objective: it grows without end"):
        endless.solve(0.5, objective=endless.slip[0, 0])


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
