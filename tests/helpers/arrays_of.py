"""Problems of cvxpy as arrays for solvers, for tests of solvers."""

import numpy as np
from scipy.sparse import csr_array

from frictopt.solve.arrays import Arrays


def arrays_of(problem):
    """The rows and cones that cvxpy compiles of a problem; a largest value is minimised negated."""
    data = problem.get_problem_data("CLARABEL")[0]
    dims = data["dims"]
    sizes = np.r_[np.ones(dims.nonneg, dtype=int), np.array(dims.soc, dtype=int)]
    block = np.zeros((0, len(data["c"])))
    return Arrays(csr_array(data["A"]), block, data["b"], data["c"], int(dims.zero), sizes)
