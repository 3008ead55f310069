"""Slips that the contact can hold at a load factor, the furthest ones in given directions: starts of transients.

In full, with dimensionless nodal tractions::

    max direction tractions    s.t.   |q_k| <= f p_k,  p_k >= 0   where   q_k = q0 + lam q1_k + A v,   p_k = p0 + lam p1_k + B v

A slide of the whole body, where nothing resists one, has no part in it; a bound `abs(v) <= slip_bound` counts with its slide.
"""

from collections.abc import Iterable
from typing import Any

import cvxpy as cp
import numpy as np

from ..contact import Array, ContactSystem, LoadCycle, SolveRecord, finite_array, finite_number, frozen, warns_of_odd_values
from ..solve.solvers import NoOptimum, solve
from .friction_bounds import safe_set
from .parts import on_whole
from .question import LimitQuestion, pose
from .safe_set import SafeSet


def admissible_problem(v: SafeSet) -> cp.Problem:
    """The slip that is safe at the given load factor of `v` and goes furthest in a direction, in dimensionless tractions."""
    along = cp.Parameter(v.traction.size, name="direction") @ v.traction
    return v.program(cp.Maximize(along), v.stuck(None))


class AdmissibleSlips:
    """The furthest admissible slips of one contact under one load after the other.

    Parameters
    ----------
    task
        The contact, friction and slip bound, and loads of the size of the others.

    Attributes
    ----------
    unknowns
        The unknowns of the programs, see `SafeSet`.
    problem
        The program of the last load; None before there is one.
    """

    def __init__(self, task: LimitQuestion) -> None:
        self.unknowns = safe_set(task)
        self.problem: cp.Problem | None = None

    def furthest(self, task: LimitQuestion, load_factor: float, directions: Iterable[Array]) -> list[Array | None]:
        """For each direction of the tractions, (m,), the slip that is safe for a question at a load factor and goes furthest in it, length.

        Of a question on the closed nodes it is that of the whole contact, whose open nodes follow. None in directions in which these slips have no
        end, and in all where no slip is safe.

        Raises
        ------
        SolverError
            No solver gave an answer that passes the checks.
        """
        v = self.unknowns
        v.ask(task, load_factor)
        if self.problem is None or task.system.tangents > 1:  # in the plane the loads are parameters
            self.problem = admissible_problem(v)
        found = list[Array | None]()

        def judged() -> SolveRecord:
            whole, slip, _ = on_whole(task, v.solved_slip, None)
            return SolveRecord(residual=whole.violation(load_factor, slip))

        for along in directions:
            self.problem.param_dict["direction"].value = along / (np.abs(along).max(initial=0.0) or 1.0)
            try:
                solve(self.problem, judged)
                found.append(on_whole(task, v.solved_slip, None)[1])
            except NoOptimum:
                found.append(None)
        return found


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
    factor, task = finite_number("load_factor", load_factor, least=0.0), pose(system, cycle, friction, simplify=False)
    slips, given = AdmissibleSlips(task), finite_array("directions", directions, (None, *system.slip_shape))
    along = np.moveaxis(given.reshape(len(given), system.nodes, system.tangents), 2, 1).reshape(len(given), system.nodes * system.tangents)
    found = slips.furthest(task, factor, along[:, slips.unknowns.loaded])
    return frozen(np.reshape([slip for slip in found if slip is not None], (-1, *system.slip_shape)))
