"""Extreme residual slips among the safe ones."""

from typing import Any

import cvxpy as cp
import numpy as np

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_array, finite_number, frozen, warns_of_odd_values
from ..solve.solvers import NoOptimum, solve
from .admissible import SlipClaim
from .question import pose
from .safe_model import safe_set
from .shakedown import shakedown_problem


@warns_of_odd_values
def safe_vertices(system: ContactSystem, cycle: LoadCycle, friction: Any, load_factor: float, directions: Any) -> Array:
    """Vertices of the safe slips at a load factor: for each direction, the safe slip whose tractions go furthest along it, with all nodes closed.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    directions
        (D, N), in space (D, N, 2), directions in the space of the nodal tractions over the mean pressures. Where the body may slide as a whole, as
        many components as there are such slides carry no traction of their own, and do not count.

    Returns
    -------
    Array
        (d, N) or (d, N, 2) slips, length. d = 0 where no slip is safe with all nodes closed; directions in which the safe slips have no end give
        none.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> fo.starts.safe_vertices(system, cycle, friction=0.5, load_factor=0.3, directions=[[1.0, 0.0], [0.0, 1.0]]).shape
    (2, 2)
    """
    factor = finite_number("load_factor", load_factor, least=0.0)
    task = pose(system, cycle, friction, simplify=False)
    v = safe_set(task)
    v.ask(task)
    given = finite_array("directions", directions, (None, *system.slip_shape))
    directions = np.moveaxis(given.reshape(len(given), system.nodes, system.tangents), 2, 1).reshape(len(given), system.nodes * system.tangents)[
        :, v.loaded
    ]
    direction = cp.Parameter(v.traction.size, name="direction")
    at = v.load_factor == factor / task.load_unit
    problem = cp.Problem(cp.Maximize(direction @ v.traction), [*shakedown_problem(v).constraints, at])

    def vertex() -> SlipClaim:
        return SlipClaim(v.solved_slip, task.violation(factor, v.solved_slip))

    found = []
    for along in directions:
        direction.value = along / (np.abs(along).max(initial=0.0) or 1.0)
        try:
            found.append(solve(problem, vertex)[0].slip)
        except NoOptimum:
            continue
    return frozen(np.array(found).reshape(-1, *system.slip_shape))
