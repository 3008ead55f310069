"""A friction increment by the contact law itself with booleans. A program that finds no state is no proof: Newton's method is asked then."""

from __future__ import annotations

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ...base import RESIDUAL, Array, SolveRecord, finite_number, warns_of_odd_values
from ...contact import ContactSystem, checked_law, checked_plane
from ...errors import SolverError
from ...solve.solvers import MILP, NoOptimum
from ..transient import OPEN
from .by_newton import NewtonIncrement
from .increment import Increment, Posed
from .newton import newton
from .programs import ByProgram, exact

_BOOLEANS = {"forward": 1, "backward": -1, "opened": OPEN}
_TOUCHES = 0.999  # share of the largest motion or pressure from which on a state touches it


@warns_of_odd_values
class ExactIncrement(ByProgram):
    """A friction increment by the contact law itself as a mixed-integer program, compiled once.

    The program decides the status of every node. A few steps of Newton's method make the state
    exact, and the referee judges it. The objective counts the nodes whose status differs from that
    of a `NewtonIncrement`: it only says where to look first. Without it contacts of 40 nodes take
    minutes. The effort can grow exponentially with the number of nodes where the guess is wrong.

    Where several states obey the law (above the critical friction) one of them is returned. The
    program takes no constraints of your own. Theory, eq. (4).

    Parameters
    ----------
    system
        The contact, in the plane.
    friction
        Coefficient of friction, one or one per node.
    reach
        Largest motion and pressure that the program considers, over those of the trial state or,
        where it obeys the law, of the Newton state; above 1. Far larger values blur the booleans,
        which solvers keep to a tolerance. If the program then finds no state, Newton's method is
        asked.

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

    def __init__(self, system: ContactSystem, friction: ArrayLike, *, reach: float = 1e3) -> None:
        self._reach = finite_number("reach", reach, above=1.0)
        super().__init__(
            checked_law(
                checked_plane(system, "choose NewtonIncrement or FrozenBoundIncrement"),
                "ExactIncrement",
            ),
            friction,
        )

    def _listing(self, system: ContactSystem) -> cp.Problem:
        return exact(system, self.friction)

    def _solved(self, posed: Posed) -> Increment:
        guess = newton(self.law, posed.trial, np.zeros_like(posed.trial))
        start = posed.result(guess, SolveRecord("NEWTON"))
        known = start if start.residual <= RESIDUAL else None
        largest = self._reach * max(
            1.0, _size(posed.trial), 0.0 if known is None else _size(np.r_[guess.u, guess.r])
        )
        unexpected = np.array(
            [np.where(guess.status == status, -1.0, 1.0) for status in _BOOLEANS.values()]
        )
        within = f"slip increments and gaps up to {largest * posed.length:.3g} and pressures up to {largest * posed.force:.3g}"
        try:
            found = self._found(posed, MILP, unexpected=unexpected, **self._most(largest, largest))
            why = (
                ""
                if found.residual <= RESIDUAL
                else f"the statuses that were found leave a residual of {found.residual:.1e}"
            )
        except NoOptimum:
            why = f"the solvers find no state with {within}"
        if why:  # booleans are kept to a tolerance, so this proves nothing
            found = known or self._by_newton(posed, why)
            largest = max(largest, self._reach * _size(_moved(posed, found)))
        elif _size(_moved(posed, found)) >= _TOUCHES * largest:
            raise SolverError(
                f"mixed-integer increment: the state that was found touches {within}; give a larger reach than {self._reach:g}"
            )
        booleans = {
            name: (found.status == status).astype(np.float64) for name, status in _BOOLEANS.items()
        }
        most = self._most(largest * posed.length, largest * posed.force)
        values = {
            "slip_step": found.slip - posed.slip,
            "gap": found.gap,
            "q": found.q,
            "p": found.p,
            **booleans,
        }
        return self._answer(posed, found, values, unexpected=unexpected, **most)

    def _by_newton(self, posed: Posed, why: str) -> Increment:
        """The state that all ways of Newton's method find; SolverError if they find none, `why` says what the program did."""
        try:
            return NewtonIncrement(self.system, self.friction)._solved(posed)
        except SolverError as error:
            raise SolverError(
                f"mixed-integer increment: {why}, and Newton's method finds no state either, which is no proof that there is none (reach "
                f"{self._reach:g}); {self._remedy}, or give another reach"
            ) from error

    def _most(self, motion: float, force: float) -> dict[str, Array]:
        whole = np.ones(len(self.friction))
        return {
            "most_motion": motion * whole,
            "most_force": force * whole,
            "most_slack": 2 * force * self.friction,
        }

    def _motions(self) -> Array:
        """Those that the booleans forbid are zero."""
        values = {name: variable.value for name, variable in self._scaled.var_dict.items()}
        forward, backward, opened = (values[name] > 0.5 for name in _BOOLEANS)
        motions: Array = np.r_[
            np.where(forward | backward | opened, values["slip_step"], 0.0),
            np.where(opened, values["gap"], 0.0),
        ]
        return motions


def _size(values: Array) -> float:
    return float(np.abs(values).max())


def _moved(posed: Posed, found: Increment) -> Array:
    """Slip increments, gaps and pressures of a state, dimensionless."""
    return np.concatenate(
        [(found.slip - posed.slip) / posed.length, found.gap / posed.length, found.p / posed.force]
    )
