"""The shakedown limit in plain cvxpy, as a reader would write it, without frictopt's limits."""

import cvxpy as cp
import numpy as np

import frictopt as fo


def plain_limit(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: float, solver: str
) -> float:
    """Shakedown limit of a contact in the plane, with all nodes closed."""
    slip, load_factor = cp.Variable(system.nodes), cp.Variable(nonneg=True)
    q0, p0 = system.reaction(cycle.mean)
    constraints = []
    for corner in cycle.corners:
        q1, p1 = system.reaction(corner)
        q = q0 + load_factor * q1 + system.A @ slip
        p = p0 + load_factor * p1 + system.B @ slip
        constraints += [cp.abs(q) <= friction * p, p >= 0]
    problem = cp.Problem(cp.Maximize(load_factor), constraints)
    # cvxpy multiplies infinite bounds of variables by zero.
    with np.errstate(invalid="ignore"):
        return float(problem.solve(solver=solver))
