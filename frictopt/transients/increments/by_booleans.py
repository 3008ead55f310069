"""A friction increment by the contact law itself, as a program with booleans.

Solvers keep booleans to a tolerance. So a program without a solution proves nothing, and Newton's
method follows.
"""

from __future__ import annotations

import cvxpy as cp
import numpy as np

from ...base import RESIDUAL, Array, PerNode, SolveRecord, finite_number, warns_of_odd_values
from ...contact import ContactSystem, checked_law, checked_plane
from ...errors import SolverError
from ...solve.solvers import MILP, NoOptimum
from ..transient import OPEN
from .by_newton import NewtonIncrement
from .increment import Increment, Posed
from .newton import newton
from .programs import ByProgram, Statuses, exact, put_into

# Boolean of the program -> status of a node at which it is 1.
_BOOLEANS = {"forward": 1, "backward": -1, "opened": OPEN}


_WITHIN = "slip increments and gaps up to {motion:.3g} and pressures up to {force:.3g}"
_TOUCHED = (
    "mixed-integer increment: the computed state reaches {within}; give a larger reach than "
    "{reach:g}"
)
_NO_STATE = (
    "mixed-integer increment: {why}, and Newton's method finds no state either; a state may still "
    "exist (reach {reach:g}); {remedy}, or give another reach"
)


@warns_of_odd_values
class ExactIncrement(ByProgram):
    """A friction increment by the contact law itself as a mixed-integer program, compiled once.

    The program decides the status of every node. A few steps of Newton's method make the state
    exact. The state is checked against the contact law. The objective counts the nodes whose status
    differs from the status by Newton's method. It only guides the search: without it contacts of 40
    nodes take minutes. The effort can grow exponentially with the number of nodes whose guess is
    wrong.

    If several states obey the law (above the critical friction), one of them is returned. The
    program takes no user constraints. Theory, eq. (4).

    Parameters
    ----------
    system
        The contact, in the plane.
    friction
        Coefficient of friction, one or one per node.
    reach
        Largest motion and pressure that the program considers, above 1. It is relative to the trial
        state, or to the state by Newton's method if this state is larger and obeys the law. With
        much larger values, booleans become inaccurate, because solvers satisfy them only to a
        tolerance. If the program finds no state, Newton's method follows.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     [[2.0]], [[0.5]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    ... )
    >>> load = system.reaction({"P": 1.0, "Q": 1.0})
    >>> fo.increments.ExactIncrement(system, friction=0.5).solve([0.0], load).slip.round(6).tolist()
    [-0.285714]
    """

    _title = "friction increment, mixed-integer"

    def __init__(self, system: ContactSystem, friction: PerNode, *, reach: float = 1e3) -> None:
        self._reach = finite_number("reach", reach, above=1.0)
        plane = checked_plane(system, "choose NewtonIncrement or FrozenBoundIncrement")
        super().__init__(checked_law(plane, "ExactIncrement"), friction)

    def _listing(self, system: ContactSystem) -> cp.Problem:
        return exact(system, self.friction)

    def _solved(self, posed: Posed) -> Increment:
        guess = newton(self.law, posed.trial, np.zeros_like(posed.trial))
        by_guess = posed.result(guess, SolveRecord("NEWTON"))
        obeys = by_guess.residual <= RESIDUAL
        sizes = [1.0, _size(posed.trial)]
        if obeys:
            sizes += [_size(guess.u), _size(guess.r)]
        largest = self._reach * max(sizes)  # motion and pressure, dimensionless
        within = _WITHIN.format(motion=largest * posed.length, force=largest * posed.force)

        failure = ""
        try:
            ends = self._most(largest, largest)
            found = self._found(posed, MILP, unexpected=_unexpected(guess.status), **ends)
        except NoOptimum:
            failure = f"the solvers find no state with {within}"
        else:
            if not found.residual <= RESIDUAL:
                failure = f"the computed statuses have a residual of {found.residual:.1e}"
        # A state touches the end of the reach above this share of the largest motion or pressure.
        touches = 0.999
        if failure:
            found = by_guess if obeys else self._by_newton(posed, failure)
        elif _size(_moved(posed, found)) >= touches * largest:
            raise SolverError(_TOUCHED.format(within=within, reach=self._reach))
        return self._answer(posed, found, guess.status)

    def _answer(self, posed: Posed, found: Increment, guess: Statuses) -> Increment:
        largest = self._reach * max(1.0, _size(posed.trial), _size(_moved(posed, found)))
        values = {
            "slip_step": found.slip - posed.slip,
            "gap": found.gap,
            "q": found.q,
            "p": found.p,
        }
        for name, status in _BOOLEANS.items():
            values[name] = (found.status == status).astype(np.float64)
        ends = self._most(largest * posed.length, largest * posed.force)
        parameters = {"trial": posed.reactions, "unexpected": _unexpected(guess), **ends}
        return put_into(self.problem, found, values, **parameters)

    def _by_newton(self, posed: Posed, failure: str) -> Increment:
        """The state that some way of Newton's method finds.

        SolverError if none does. `failure` says why the program has no state.
        """
        try:
            return NewtonIncrement(self.system, self.friction)._solved(posed)
        except SolverError as error:
            text = _NO_STATE.format(why=failure, reach=self._reach, remedy=self._remedy)
            raise SolverError(text) from error

    def _most(self, motion: float, force: float) -> dict[str, Array]:
        """The parameters of the program that bound motions and forces."""
        n = len(self.friction)
        return {
            "most_motion": np.full(n, motion),
            "most_force": np.full(n, force),
            "most_slack": 2 * force * self.friction,
        }

    def _motions(self) -> Array:
        """(M,) slip steps and gaps in the program; those that its booleans forbid are zero."""
        values = {name: variable.value for name, variable in self._scaled.var_dict.items()}
        forward, backward, opened = (values[name] > 0.5 for name in _BOOLEANS)
        slip_step = np.where(forward | backward | opened, values["slip_step"], 0.0)
        gap = np.where(opened, values["gap"], 0.0)
        return np.concatenate([slip_step, gap])


def _unexpected(guess: Statuses) -> Array:
    """(3, N) for each boolean: -1 if the guess expects it to be 1, else 1."""
    return np.array([np.where(guess == status, -1.0, 1.0) for status in _BOOLEANS.values()])


def _size(values: Array) -> float:
    return float(np.abs(values).max())


def _moved(posed: Posed, found: Increment) -> Array:
    """Slip increments, gaps and pressures of a state, dimensionless."""
    slip_step = (found.slip - posed.slip) / posed.length
    return np.concatenate([slip_step, found.gap / posed.length, found.p / posed.force])
