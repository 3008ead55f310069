"""One friction increment as a mixed-integer program: the contact law itself, its alternatives switched by booleans.

Each node sticks, slips along or against +x, or is open. The unknowns are `u = [dv, w]`, the slip increment and the gap, with the reactions
`[q, p] = trial + S u`, and one boolean for each status but sticking.
"""

from typing import Any

import cvxpy as cp
import numpy as np

from ...contact import ContactSystem
from ...contact.checks import finite_number
from ...contact.tolerances import RESIDUAL
from ...errors import NoContinuation, SolverError
from ...solve.solvers import Kind, NoOptimum, solve
from .engine import IncrementEngine, status_program
from .increment import Increment, Law, PosedIncrement
from .newton import NodeStatus, State, Status, classified, settle, sticking

__all__ = ["ExactIncrement"]

_BOOLEANS = {"forward": NodeStatus.FORWARD, "backward": NodeStatus.BACKWARD, "opened": NodeStatus.OPEN}
_GUESSES = 40  # corrections of the status that the search starts from
_TOUCHES = 0.999  # share of the largest motion or pressure from which on a state touches it


def _exact_problem(law: Law) -> cp.Problem:
    n, f = law.nodes, law.friction
    dv, w = cp.Variable(n, name="slip_increment"), cp.Variable(n, name="gap")
    forward, backward, opened = (cp.Variable(n, boolean=True, name=name) for name in _BOOLEANS)
    trial, expected = cp.Parameter(2 * n, name="trial_reaction"), cp.Parameter((3, n), name="expected_status")
    largest = cp.Parameter(nonneg=True, name="largest")  # motion and pressure; with it 2 f largest bounds f p + q and f p - q

    r = trial + law.S @ cp.hstack([dv, w])
    q, bound, p = r[:n], cp.multiply(f, r[n:]), r[n:]
    rows = {
        "one_status": forward + backward + opened <= 1,
        "slips_forward": dv <= largest * (forward + opened),
        "slips_backward": -dv <= largest * (backward + opened),
        "no_overlap": w >= 0,
        "opens": w <= largest * opened,
        "no_tension": p >= 0,
        "no_force_across_a_gap": p <= largest * (1 - opened),
        "forward_bound": bound + q >= 0,
        "on_forward_bound": bound + q <= largest * cp.multiply(2 * f, 1 - forward),
        "backward_bound": bound - q >= 0,
        "on_backward_bound": bound - q <= largest * cp.multiply(2 * f, 1 - backward),
    }
    unexpected = cp.sum(cp.multiply(1 - 2 * expected, cp.vstack([forward, backward, opened])))  # but for a constant, how many booleans differ
    return cp.Problem(cp.Minimize(unexpected), [row.set_label(name) for name, row in rows.items()])


class ExactIncrement(IncrementEngine):
    """One friction increment by the contact law itself as a mixed-integer program, compiled once.

    The program decides the status of every node. The state of that status is then solved exactly and judged by the referee. The objective counts the
    nodes whose status differs from that of a semismooth Newton method: it only says where to look first. Without it contacts of 40 nodes take
    minutes. The effort can grow exponentially with the number of nodes where the guess is wrong.

    Where several states obey the law (above the critical friction) one of them is returned. The program takes no constraints of your own.
    Theory, eq. (4).

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.
    simplify
        Leave out what cannot change the answer: the program where the trial state obeys the law; half of a contact that is mirror-symmetric with
        its slip and its load.
    reach
        Largest motion and pressure that the program considers, over those of the trial state or, where it obeys the law, of the Newton state;
        above 1. Far larger values blur the booleans, which solvers keep to a tolerance.

    Raises
    ------
    ModelError
        Bad input.

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
    >>> load = system.reaction({"P": 1.0, "Q": 1.0})
    >>> fo.ExactIncrement(system, friction=0.5).solve([0.0, 0.0], load).slip.round(6).tolist()
    [-0.326531, -0.122449]
    """

    _title = "friction increment, mixed-integer"

    def __init__(self, system: ContactSystem, friction: Any, *, simplify: bool = True, reach: float = 1e3) -> None:
        self._reach = finite_number("reach", reach, above=1.0)
        super().__init__(system, friction, simplify, reach=reach)
        self._problem = _exact_problem(self._law)

    @property
    def problem(self) -> cp.Problem:
        """The mixed-integer program."""
        return self._problem

    def _solve_program(self, posed: PosedIncrement) -> Increment:
        guess = self._guess(posed)
        known = posed.residual(guess) <= RESIDUAL
        largest = self._reach * max(1.0, float(np.abs(np.r_[posed.trial, guess.u, guess.r] if known else posed.trial).max()))
        self._set(posed, classified(self._law.friction, guess), largest)
        program = status_program(self._problem, posed, self._read_status)
        within = f"slip increments and gaps up to {largest * posed.length:.3g} and pressures up to {largest * posed.force:.3g}"
        try:
            answer = solve(program, program.claim, kind=Kind.MILP)
        except NoOptimum as error:
            if known:  # it disproves what the solvers say
                raise SolverError(
                    f"mixed-integer increment: the solvers find no state with {within}, but a semismooth Newton method does; give a smaller reach "
                    f"than {self._reach:g}"
                ) from error
            raise NoContinuation(
                f"friction increment: no state obeys the law under this load with {within}; larger ones were not looked for (reach {self._reach:g}). "
                f"The trial state violates the law most at node {posed.worst_node}; reduce friction below the critical value, take another load, "
                "or give a larger reach"
            ) from error
        state = answer.claim.state
        if max(np.abs(state.u).max(), state.r[self._law.nodes :].max()) >= _TOUCHES * largest:
            raise SolverError(f"mixed-integer increment: the state that was found touches {within}; give a larger reach than {self._reach:g}")
        return posed.result(self._title, state, 0, answer.solver, answer.attempts, (), self._problem)

    def _set(self, posed: PosedIncrement, expected: Status, largest: float) -> None:
        """Set the parameters in place."""
        values = self._problem.param_dict
        values["trial_reaction"].value, values["largest"].value = posed.trial, largest
        values["expected_status"].value = np.array([expected == status for status in _BOOLEANS.values()], dtype=np.float64)

    def _guess(self, posed: PosedIncrement) -> State:
        """State by a semismooth Newton method, on the closed contact first: let open at once, nodes open and stick by turns for ever."""
        law = self._law
        closed = settle(law.S, law.friction, law.no_bound, posed.trial, sticking(law.nodes), _GUESSES, separation=False)
        return settle(law.S, law.friction, law.no_bound, posed.trial, closed.status, _GUESSES)

    def _read_status(self) -> Status:
        booleans = [self._problem.var_dict[name].value > 0.5 for name in _BOOLEANS]
        return np.select(booleans, list(_BOOLEANS.values()), NodeStatus.STICK).astype(np.int8)
