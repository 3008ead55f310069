"""What multipliers prove by weak duality, and the exact solution next to a rough one."""

from unittest.mock import patch

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import null_space
from scipy.sparse import csr_array

from frictopt.solve import solvers
from frictopt.solve.arrays import Arrays, _Active, polish
from frictopt.solve.compiled import Compiled, Proof, proof
from helpers.cases import few


def random_program(rng, equations):
    """A bounded random program over six unknowns, and a point inside of it.

    It has rows, cones of two sizes and perhaps equations.
    """
    z = cp.Variable(6)
    size = cp.Variable(6)
    inside = 0.1 * rng.normal(size=6)
    G, h = rng.normal(size=(8, 6)), rng.uniform(0.5, 1.0, 8)
    flat, wide = rng.normal(size=(4, 6)), rng.normal(size=(2, 4, 6))
    rows = [
        G @ (z - inside) <= h,
        cp.SOC(
            cp.Constant(np.array([1.0, 0.7])), cp.vstack([wide[0][:2] @ z, wide[1][:2] @ z]), axis=1
        ),
    ]
    rows += [
        cp.SOC(1.5 + flat[0] @ z * 0.1, flat[1:] @ z),
        z <= size,
        -z <= size,
        cp.sum(size) <= 5,
    ]
    rows += [rng.normal(size=(2, 6)) @ (z - inside) == 0] if equations else []
    return cp.Problem(cp.Maximize(rng.normal(size=6) @ z), rows)


def arrays(compiled):
    """A compiled program without dense equations as solvers take it, nothing reduced."""
    n = len(compiled.cost)
    sizes = np.r_[np.ones(compiled.nonneg, dtype=int), np.array(compiled.soc, dtype=int)]
    return Arrays(
        compiled.matrix, np.zeros((0, n)), compiled.right, compiled.cost, compiled.zero, sizes
    )


def solved(problem, tolerance):
    """The compiled program, and its solution as Clarabel leaves it that ends at a tolerance."""
    compiled = Compiled(problem)
    with patch.dict(
        solvers._CLARABEL, dict.fromkeys(["tol_gap_abs", "tol_gap_rel", "tol_feas"], tolerance)
    ):
        _, z, y = solvers.run(arrays(compiled), "CLARABEL", -np.inf)
    return compiled, z, y


def proven(compiled, z, y, units=1.0):
    """Value, bound and defect, once z stands in the problem."""
    y = arrays(compiled).admissible(y)
    compiled.save(z, y)
    return proof(compiled, z, y, np.broadcast_to(units, len(z)), 1.0)


@settings(max_examples=few(15))
@given(seed=st.integers(0, 10**6), equations=st.booleans(), by=st.floats(0.0, 1.0))
def test_no_multipliers_prove_less_than_the_optimum(seed, equations, by):
    rng = np.random.default_rng(seed)
    problem = random_program(rng, equations)
    best, (compiled, z, y) = problem.solve(solver="CLARABEL"), solved(problem, 1e-8)
    proof = proven(compiled, z, y)
    assert (proof.value, proof.bound) == pytest.approx((best, best), abs=1e-5) and proof.gap < 1e-4
    idle = null_space(compiled.matrix.T.toarray())  # multipliers that balance each other
    idle = idle @ rng.normal(size=idle.shape[1])
    y = y - by * np.sign(compiled.right @ idle) * 10.0 * idle + (by > 0.5) * rng.normal(size=len(y))
    proof = proven(compiled, z, y, units=5.0)  # no unknown of a solution is larger
    assert proof.bound + proof.defect >= best - 1e-7


@pytest.mark.parametrize("share", [0.1, 0.9])
@pytest.mark.parametrize("multipliers", [0.0, 1e-9])
def test_no_multipliers_prove_nothing_of_a_share_of_the_optimum(share, multipliers):
    """No z as small as this one has more: that is always so, and says nothing of larger ones."""
    z = cp.Variable(name="z")
    compiled = Compiled(cp.Problem(cp.Maximize(z), [z <= 2e9]))
    assert proven(compiled, np.array([2e9]), np.ones(1)).gap < 1e-12
    assert proven(compiled, np.array([share * 2e9]), np.array([multipliers])).gap > 0.1


def test_what_multipliers_lack_in_balance_is_part_of_the_gap():
    z = cp.Variable(2)
    compiled = Compiled(cp.Problem(cp.Maximize(z[0]), [z[0] <= 1, z[1] <= 0]))
    # The right bound, and 1e-3 too much of an unknown that may be anything.
    y = np.array([1.0, 1e-3])
    proof = proven(compiled, np.zeros(2) + [1.0, 0.0], y, units=[1.0, 10.0])
    assert (proof.value, proof.bound, proof.defect) == pytest.approx((1.0, 1.0, 1e-2))
    assert proof.gap == pytest.approx(1e-2)


def test_a_small_value_counts_over_a_part_of_its_unit():
    assert Proof(0.0, 1e-9, 0.0, 1.0).gap == pytest.approx(1e-6)
    assert Proof(0.0, 1e-9, 0.0, 1e3).gap == pytest.approx(1e-9)


def test_a_least_objective_has_its_bound_below():
    z = cp.Variable()
    compiled = Compiled(cp.Problem(cp.Minimize(z + 3), [z >= 2]))
    proof = proven(compiled, np.array([2.0]), np.ones(1))
    assert (proof.value, proof.bound, proof.defect) == (5.0, 5.0, 0.0)
    assert proven(compiled, np.array([2.5]), np.ones(1)).gap == pytest.approx(0.5 / 5.5)


def test_what_a_point_breaks_and_multipliers_that_are_in_their_cones():
    """Violations of a point, and multipliers in their cones, by hand.

    The rows are z[0] == 1, z[1] <= 2, |z| <= 3.
    """
    z = cp.Variable(2)
    program = arrays(
        Compiled(cp.Problem(cp.Maximize(z[1]), [z[0] == 1, z[1] <= 2, cp.SOC(cp.Constant(3.0), z)]))
    )
    broken = [
        program.violation(np.array(point))
        for point in ([1.0, 0.0], [1.5, 0.0], [0.0, -2.0], [1.0, 2.5], [1.0, -5.0])
    ]
    assert broken == pytest.approx([0.0, 0.5, 1.0, 0.5, np.hypot(1, 5) - 3])
    for given_y, nearby in (
        ([-5, -1, 1, 3, -4], [-5, 0, 5, 3, -4]),
        ([5, 1, -1, 3, 4], [5, 1, 0, 0, 0]),
        ([0, 2, 6, 3, 4], [0, 2, 6, 3, 4]),
    ):
        assert program.admissible(np.array(given_y, dtype=float)) == pytest.approx(np.array(nearby))


@settings(max_examples=few(15))
@given(seed=st.integers(0, 10**6), equations=st.booleans())
def test_a_rough_solution_becomes_the_exact_one(seed, equations):
    """A rough solution becomes the exact one.

    The rough solution is that of an interior point method that stops early, the exact one that of
    the same method at its best.
    """
    problem = random_program(np.random.default_rng(seed), equations)
    best = problem.solve(solver="CLARABEL", tol_gap_abs=1e-10, tol_gap_rel=1e-10, tol_feas=1e-10)
    compiled, z, y = solved(problem, 1e-4)
    rough = arrays(compiled).off(z, y)
    at, slopes = polish(arrays(compiled), z, y)
    assert arrays(compiled).off(at, slopes) <= max(1e-11, 1e-6 * rough)
    proof = proven(compiled, at, slopes)
    assert (proof.value, proof.bound) == pytest.approx((best, best), abs=1e-8)
    assert arrays(compiled).violation(at) < 1e-10


@pytest.mark.parametrize("seed", few(range(10)))
def test_a_guess_from_which_no_way_leads_to_the_solution_is_made_no_worse(seed):
    rng = np.random.default_rng(seed)
    program = arrays(Compiled(random_program(rng, bool(seed % 2))))
    z = rng.normal(size=len(program.cost))
    y = program.admissible(rng.normal(size=len(program.right)))
    at, slopes = polish(program, z, y)
    assert program.off(at, slopes) <= program.off(z, y)


@pytest.mark.parametrize("seed", few(range(1, 6)))
def test_a_vertex_of_more_rows_than_unknowns_keeps_its_proof(seed):
    """Many multipliers balance the objective there, so that their equations are singular."""
    rng = np.random.default_rng(seed)
    rows = rng.uniform(0.2, 1.0, (5, 2))
    vertex = rng.standard_normal(2)
    z = cp.Variable(2)
    least = rows @ rng.uniform(0.2, 1.0, 2)  # of these multipliers, a combination of the columns
    program = arrays(
        Compiled(cp.Problem(cp.Maximize((rows.T @ least) @ z), [rows @ z <= rows @ vertex]))
    )
    at, slopes = polish(
        program, vertex + 1e-7 * rng.standard_normal(2), least + 1e-6 * rng.random(5)
    )
    assert program.off(at, slopes) < 1e-12


def test_equations_of_a_boundary_that_meet_its_tip_have_an_answer():
    """The point that solves them may be the tip, where the boundary has no direction."""
    z = cp.Variable(3)
    program = arrays(Compiled(cp.Problem(cp.Maximize(-z[0]), [cp.SOC(z[0], z[1:])])))
    multipliers = np.array([1.0, -0.6, -0.8])
    active = _Active(program, np.array([1.0, 0.6, 0.8]), multipliers, share=0.1)
    found, y = active.solved(np.zeros(3), multipliers)
    assert program.off(found, program.admissible(y)) < np.inf


def test_a_solution_at_the_tip_of_a_cone():
    z = cp.Variable(3)
    program = arrays(
        Compiled(cp.Problem(cp.Maximize(-z[0] + 0.3 * z[1]), [cp.SOC(z[0], z[1:]), z[2] <= 1]))
    )
    _, at, y = solvers.run(program, "CLARABEL", -np.inf)
    assert polish(program, at + 1e-5, y)[0] == pytest.approx(np.zeros(3), abs=1e-12)


def test_a_point_without_numbers_is_never_the_answer():
    z = cp.Variable(2)
    program = arrays(Compiled(cp.Problem(cp.Maximize(z[0]), [z[0] <= 1, cp.abs(z[1]) <= 1])))
    right = np.ones(len(program.right))
    assert program.off(np.full(len(program.cost), np.nan), right) == np.inf
    assert program.off(np.zeros(len(program.cost)), np.nan * right) == np.inf


def test_a_program_without_unknowns_is_as_it_stands():
    program = Arrays(
        csr_array((2, 0)),
        np.zeros((0, 0)),
        np.array([1.0, -0.5]),
        np.zeros(0),
        0,
        np.ones(2, dtype=int),
    )
    x, y = polish(program, np.zeros(0), np.zeros(2))
    assert not len(x) and program.off(x, y) == 0.5  # by which the second row is missed


@pytest.mark.parametrize("multiplier", [0.0, 0.25, 1.0])
def test_multipliers_that_do_not_balance_are_off_by_what_is_missing(multiplier):
    """At the optimum x = 1 of min x, x >= 1 the slack is zero, so only the balance can be wrong."""
    z = cp.Variable()
    program = arrays(Compiled(cp.Problem(cp.Minimize(z), [z >= 1])))
    off = program.off(np.array([1.0]), np.array([multiplier]))
    assert off == pytest.approx(1.0 - multiplier, abs=1e-15)
