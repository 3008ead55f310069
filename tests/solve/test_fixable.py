"""Linear programs in which entries may be fixed to zero, against scipy."""

from itertools import product

import cvxpy as cp
import numpy as np
import pytest
from scipy.optimize import linprog

from frictopt.solve import chain
from helpers.cases import few


@pytest.mark.parametrize("seed", few(range(12)))
def test_each_choice_of_fixed_entries_has_its_optimum_and_bound(seed):
    rng = np.random.default_rng([seed, 61])
    A, M = rng.normal(size=(2, 4, 4))
    right = rng.uniform(0.5, 1.5, size=4)
    c = rng.normal(size=4)
    x = cp.Variable(4, name="x")
    y = cp.Variable(4, name="y")
    rows = [y == cp.Constant(M) @ x, A @ x <= right, x <= 2, x >= -2, y <= 3]
    units = {x: np.full(4, 0.7), y: 1.3}
    solved = chain.Chain(cp.Problem(cp.Maximize(c @ x), rows), units)
    program = solved.fixable([(x, np.array([0, 2])), (y, np.array([1, 3]))])
    least = np.eye(4)[[0, 2]]
    basis = None
    for fixed in product([False, True], repeat=4):
        chosen = np.array(fixed)
        equations = np.vstack([least, M[[1, 3]]])[chosen]
        known = linprog(
            -c,
            np.vstack([A, M]),
            np.r_[right, np.full(4, 3.0)],
            equations if len(equations) else None,
            np.zeros(len(equations)) if len(equations) else None,
            bounds=(-2, 2),
        )
        best = -known.fun
        solution = program.solve(chosen, basis)
        basis = basis or solution.basis
        assert solution.bound == pytest.approx(best, abs=1e-7) and solution.bound > best - 1e-9
        assert np.abs(solution.entries[chosen]).max(initial=0.0) < 1e-8
        assert solution.entries[:2] == pytest.approx(known.x[[0, 2]], abs=1e-6)
        # It may stop where the value is known to be below.
        assert program.solve(chosen, above=best + 1.0).bound < best + 1.0
        assert program.solve(chosen, above=best - 1.0).bound == pytest.approx(best, abs=1e-7)
