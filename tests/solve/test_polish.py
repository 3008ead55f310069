"""What multipliers prove by weak duality, and the exact solution next to a rough one."""

from unittest.mock import patch

import cvxpy as cp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array

from frictopt.solve import solvers
from frictopt.solve.arrays import Arrays, polish
from helpers.arrays_of import arrays_of
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


def solved(problem, tolerance):
    """The compiled program, and its solution as Clarabel leaves it that ends at a tolerance."""
    program = arrays_of(problem)
    with patch.dict(
        solvers._CLARABEL, dict.fromkeys(["tol_gap_abs", "tol_gap_rel", "tol_feas"], tolerance)
    ):
        _, z, y = solvers.run(program, "CLARABEL", -np.inf)
    return program, z, y


def proven(program, z, y):
    """Largest value, its bound by the multipliers in their cones, and the error of the bound."""
    least, error = program.lower_bound(z, program.admissible(y))
    return -float(program.cost @ z), -least, error


def test_what_multipliers_lack_in_balance_is_part_of_the_error():
    z = cp.Variable(2)
    program = arrays_of(cp.Problem(cp.Maximize(z[0]), [z[0] <= 1, z[1] <= 0]))
    # The right bound, and 1e-3 too much of an unknown that may be anything.
    y = np.array([1.0, 1e-3])
    assert proven(program, np.array([1.0, 10.0]), y) == pytest.approx((1.0, 1.0, 1e-2))
    assert proven(program, np.array([1.0, 0.1]), y) == pytest.approx((1.0, 1.0, 1e-3))


def test_what_a_point_breaks_and_multipliers_that_are_in_their_cones():
    """The rows are z[0] == 1, z[1] <= 2, |z| <= 3."""
    z = cp.Variable(2)
    program = arrays_of(
        cp.Problem(cp.Maximize(z[1]), [z[0] == 1, z[1] <= 2, cp.SOC(cp.Constant(3.0), z)])
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
    """The rough solution is that of an interior point method that stops early, the exact one that
    of the same method at its best."""
    problem = random_program(np.random.default_rng(seed), equations)
    best = problem.solve(solver="CLARABEL", tol_gap_abs=1e-10, tol_gap_rel=1e-10, tol_feas=1e-10)
    compiled, z, y = solved(problem, 1e-4)
    rough = compiled.off(z, y)
    at, slopes = polish(compiled, z, y)
    assert compiled.off(at, slopes) <= max(1e-11, 1e-6 * rough)
    value, bound, _ = proven(compiled, at, slopes)
    assert (value, bound) == pytest.approx((best, best), abs=1e-8)
    assert compiled.violation(at) < 1e-10


@pytest.mark.parametrize("seed", few(range(10)))
def test_a_guess_from_which_no_way_leads_to_the_solution_is_made_no_worse(seed):
    rng = np.random.default_rng(seed)
    program = arrays_of(random_program(rng, bool(seed % 2)))
    z = rng.normal(size=len(program.cost))
    y = program.admissible(rng.normal(size=len(program.right)))
    at, slopes = polish(program, z, y)
    assert program.off(at, slopes) <= program.off(z, y)


def test_a_solution_at_the_tip_of_a_cone():
    z = cp.Variable(3)
    program = arrays_of(
        cp.Problem(cp.Maximize(-z[0] + 0.3 * z[1]), [cp.SOC(z[0], z[1:]), z[2] <= 1])
    )
    _, at, y = solvers.run(program, "CLARABEL", -np.inf)
    assert polish(program, at + 1e-5, y)[0] == pytest.approx(np.zeros(3), abs=1e-12)


def test_a_point_without_numbers_is_never_the_answer():
    z = cp.Variable(2)
    program = arrays_of(cp.Problem(cp.Maximize(z[0]), [z[0] <= 1, cp.abs(z[1]) <= 1]))
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
    program = arrays_of(cp.Problem(cp.Minimize(z), [z >= 1]))
    off = program.off(np.array([1.0]), np.array([multiplier]))
    assert off == pytest.approx(1.0 - multiplier, abs=1e-15)
