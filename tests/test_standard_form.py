"""Programs as arrays: what multipliers prove by weak duality, and the exact solution next to a rough one."""

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import null_space

from frictopt.solve.standard_form import StandardForm, _Active, polish


def random_program(rng, equations):
    """A bounded program over six unknowns with rows, cones of two sizes and maybe equations, and a point inside of it."""
    z, inside = cp.Variable(6), 0.1 * rng.normal(size=6)
    G, h = rng.normal(size=(8, 6)), rng.uniform(0.5, 1.0, 8)
    flat, wide = rng.normal(size=(4, 6)), rng.normal(size=(2, 4, 6))
    rows = [G @ (z - inside) <= h, cp.SOC(cp.Constant(np.array([1.0, 0.7])), cp.vstack([wide[0][:2] @ z, wide[1][:2] @ z]), axis=1)]
    rows += [cp.SOC(1.5 + flat[0] @ z * 0.1, flat[1:] @ z), cp.norm(z, 1) <= 5]
    rows += [rng.normal(size=(2, 6)) @ (z - inside) == 0] if equations else []
    return z, cp.Problem(cp.Maximize(rng.normal(size=6) @ z), rows)


def conic(problem):
    """The same with every constraint a row or a cone."""
    z = problem.variables()[0]
    size = cp.Variable(6)
    kept = [row for row in problem.constraints if not (isinstance(row, cp.constraints.Inequality) and row.size == 1)]
    return cp.Problem(problem.objective, [*kept, z <= size, -z <= size, cp.sum(size) <= 5])


@settings(max_examples=30)
@given(seed=st.integers(0, 10**6), equations=st.booleans(), by=st.floats(0.0, 1.0))
def test_no_multipliers_prove_less_than_the_optimum(seed, equations, by):
    rng = np.random.default_rng(seed)
    _, problem = random_program(rng, equations)
    problem = conic(problem)
    best = problem.solve(solver="CLARABEL")
    form = StandardForm(problem)
    assert form.bounds == pytest.approx((best, best), abs=1e-5)
    idle = null_space(form.matrix.T.toarray())  # multipliers that balance each other
    idle = idle @ rng.normal(size=idle.shape[1])
    form.y = form.y - by * np.sign(form.right @ idle) * 10.0 * idle + (by > 0.5) * rng.normal(size=len(form.y))
    form.z = np.maximum(np.abs(form.z), 5.0)  # no unknown of a solution is larger
    assert form.bounds[1] >= best - 1e-7


@pytest.mark.parametrize("share", [0.1, 0.9])
@pytest.mark.parametrize("multipliers", [0.0, 1e-9])
def test_no_multipliers_prove_nothing_of_a_share_of_the_optimum(share, multipliers):
    """No z as small as this one has more: that is always so, and says nothing of larger ones."""
    z = cp.Variable(name="z")
    problem = cp.Problem(cp.Maximize(z), [z <= 2e9])
    problem.solve(solver="HIGHS")
    form = StandardForm(problem)
    assert form.gap < 1e-12
    form.z, form.y = share * form.z, multipliers * form.y
    assert form.gap > 0.1


@settings(max_examples=30)
@given(seed=st.integers(0, 10**6), equations=st.booleans())
def test_a_rough_solution_becomes_the_exact_one(seed, equations):
    """An interior point method that stops early, against the same one at its best."""
    _, problem = random_program(np.random.default_rng(seed), equations)
    problem = conic(problem)
    best = problem.solve(solver="CLARABEL", tol_gap_abs=1e-10, tol_gap_rel=1e-10, tol_feas=1e-10)
    problem.solve(solver="CLARABEL", tol_gap_abs=1e-4, tol_gap_rel=1e-4, tol_feas=1e-4)
    rough = StandardForm(problem)
    polish(problem)
    form = StandardForm(problem)
    assert form.off(form.z, form.y) <= max(1e-11, 1e-6 * rough.off(rough.z, rough.y))
    assert form.bounds == pytest.approx((best, best), abs=1e-8)


@pytest.mark.parametrize("seed", range(1, 6))
def test_a_vertex_of_more_rows_than_unknowns_keeps_its_proof(seed):
    """Many multipliers balance the objective there, so that their equations are singular."""
    rng = np.random.default_rng(seed)
    rows, vertex, z = rng.uniform(0.2, 1.0, (5, 2)), rng.standard_normal(2), cp.Variable(2)
    least = rows @ rng.uniform(0.2, 1.0, 2)  # of these multipliers, a combination of the columns
    problem = cp.Problem(cp.Maximize((rows.T @ least) @ z), [rows @ z <= rows @ vertex])
    problem.solve(solver="CLARABEL")
    z.save_value(vertex + 1e-7 * rng.standard_normal(2))
    problem.constraints[0].save_dual_value(least + 1e-6 * rng.random(5))
    polish(problem)
    form = StandardForm(problem)
    assert form.off(form.z, form.y) < 1e-12


def test_equations_of_a_boundary_that_meet_its_tip_have_an_answer():
    """The point that solves them may be the tip, where the boundary has no direction."""
    z = cp.Variable(3)
    problem = cp.Problem(cp.Maximize(-z[0]), [cp.SOC(z[0], z[1:])])
    problem.solve(solver="CLARABEL")
    form, multipliers = StandardForm(problem), np.array([1.0, -0.6, -0.8])
    active = _Active(form, None, np.array([1.0, 0.6, 0.8]), multipliers, share=0.1)
    found, y = active.solved(np.zeros(3), multipliers)
    assert form.off(found, form.admissible(y)) < np.inf


def test_a_solution_at_the_tip_of_a_cone():
    z = cp.Variable(3)
    problem = cp.Problem(cp.Maximize(-z[0] + 0.3 * z[1]), [cp.SOC(z[0], z[1:]), z[2] <= 1])
    problem.solve(solver="CLARABEL")
    z.save_value(z.value + 1e-5)
    polish(problem)
    assert z.value == pytest.approx(np.zeros(3), abs=1e-12)
