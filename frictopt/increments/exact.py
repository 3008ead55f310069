"""One friction increment as a mixed-integer program: the contact law itself, its alternatives switched by booleans.

Each node sticks, slips along or against +x, or is open. With `u = [dv, w]`, `[q, p] = trial + S u` and one boolean for each status but sticking::

    slip_low (backward + open) <= dv <= slip_high (forward + open)      0 <= w <= gap_high open
    0 <= f p + q <= forward_high (1 - forward - open)                   0 <= p <= pressure_high (1 - open)
    0 <= f p - q <= backward_high (1 - backward - open)                 forward + backward + open <= 1

The bounds are derived (`EnergyBounds`), so the program has a solution exactly where the law has one.
"""

from functools import partial
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem
from ..contact.checks import Array, flag, shown
from ..errors import ModelError, NoContinuation, SolverError
from ..solve.explain import explain
from ..solve.solvers import TOLERANCE, Attempt, Kind, NoOptimum, solve, solver_order
from .halved import HalvedIncrement
from .increment import Increment, Law, PosedIncrement
from .increment_bounds import EnergyBounds
from .newton import BACKWARD, FORWARD, OPEN, STICK, State, Status, classified, settle
from .status_search import StatusSearch

__all__ = ["ExactIncrement"]

_STATUS = {"forward": FORWARD, "backward": BACKWARD, "opened": OPEN}  # booleans and what they stand for
_TITLE = "friction increment, mixed-integer"
_GUESSES = 40  # corrections of the status that the search starts from
_TRIES = 16  # statuses of one and the same state that are passed over in search of another state
_SAME = 1e-7  # dimensionless distance up to which two states are one


class ExactIncrement:
    """One friction increment by the contact law itself as a mixed-integer program, compiled once.

    The program decides the status of every node; the state of that status is then solved exactly and judged by the referee. Its objective, the number
    of nodes whose status differs from that of a semismooth Newton method, only says where to look first. The effort can grow exponentially with the
    number of nodes where the guess is wrong.

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.
    simplify
        Leave out what the increment does not need: the program where the trial state obeys the law; half of a contact that is mirror-symmetric with
        its slip and its load; motions of nodes that stick, and gaps of nodes that are closed, in a state that obeys the law and is known before.
    solver
        One of "HIGHS_MIP", "HIGHS_MIP_LOOSE" (looser tolerances); by default both in this order until an answer passes, and both before a claim that
        there is no state is believed.

    Raises
    ------
    ModelError
        Bad input.
    """

    def __init__(self, system: ContactSystem, friction: Any, *, simplify: bool = True, solver: str | None = None) -> None:
        self._law, self._simplify, self._solver = Law(system, friction), flag("simplify", simplify), solver
        solver_order(solver, Kind.MILP)
        self._halved = HalvedIncrement(self._law, partial(ExactIncrement, solver=solver))
        self._bounds = EnergyBounds(self._law)
        self._problem = _exact_problem(self._law)

    @property
    def problem(self) -> cp.Problem:
        """The mixed-integer program."""
        return self._problem

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the mixed-integer program by its names."""
        explain(_TITLE, self._problem, None, {}, (), pd.DataFrame(), file)

    def solve(self, slip: Any, bonded: Any) -> Increment:
        """A state to which a slip can move under a load.

        Parameters
        ----------
        slip
            (N,) slip before the increment, length.
        bonded
            `(q^w, p^w)`, (N,) bonded reactions of the load after it, force per depth.

        Raises
        ------
        ModelError
            Arrays that do not fit.
        NoContinuation
            No state obeys the law.
        SolverError
            No bound on the motion can be derived, or the solver gave no answer that passes, and no state is known from the search for a start either.
        """
        posed = self._law.pose(slip, bonded)
        if self._simplify and posed.stuck:
            return posed.closed_form(_TITLE)
        halved = self._halved.solve(_TITLE, posed) if self._simplify else None
        if halved is not None:
            return halved
        guess = self._guess(posed)
        try:
            found = self._search(posed, guess, None, held=self._simplify and posed.residual(guess) <= TOLERANCE)
        except SolverError:
            if posed.residual(guess) > TOLERANCE:
                raise
            why = "mixed-integer program: it gives no answer for this load, but a state that the referee accepts is known"
            return posed.result(_TITLE, guess, 0, "status iteration", (), (why,), None)
        if found is None:
            q, p = np.split(posed.trial, 2)
            worst = int(np.argmax(np.maximum(np.abs(q) - self._law.friction * p, -p)))
            raise NoContinuation(
                f"friction increment: no state obeys the law under this load (the mixed-integer program has no solution within derived bounds); "
                f"the trial state violates it most at node {worst}; reduce friction below the critical value, or take another load"
            )
        return found

    def another(self, increment: Increment, slip: Any, bonded: Any) -> Increment | None:
        """A state that obeys the law as well but differs from the one given; None if there is none, which below the critical friction is so.

        Parameters
        ----------
        increment
            The state found for this slip and load.
        slip, bonded
            As for `solve`.

        Raises
        ------
        ModelError
            Arrays that do not fit.
        SolverError
            The solver gave no answer, or more than a few statuses describe one state (nodes exactly at a bound), which leaves it open.
        """
        if not isinstance(increment, Increment) or len(increment.slip) != self._law.nodes:
            raise ModelError(f"increment: {shown(increment)}; give one that this engine found for its {self._law.nodes} nodes")
        posed = self._law.pose(slip, bonded)
        return self._search(posed, self._guess(posed), np.r_[increment.slip - posed.slip, increment.gap] / posed.length)

    def _search(self, posed: PosedIncrement, guess: State, known: Array | None, held: bool = False) -> Increment | None:
        """A state, other than the known one, or None; with `held`, nodes that stick or stay closed in the guess (then a state) do so here."""
        left_out = self._set(posed, classified(self._law.friction, guess), guess.status if held else None)
        problem, attempts, passed = self._problem, list[Attempt](), list[cp.Constraint]()
        for _ in range(_TRIES):
            model = StatusSearch(problem, posed, partial(_read_status, self._problem))
            try:
                answer = solve(model, model.claim, self._solver, kind=Kind.MILP)
            except NoOptimum:  # both tolerances say so
                if known is None and posed.residual(guess) <= TOLERANCE:  # a state that obeys the law disproves it
                    return posed.result(_TITLE, guess, 0, "status iteration", tuple(attempts), (), problem)
                return None
            attempts += answer.attempts
            state = answer.claim.state
            if known is None or np.abs(state.u - known).max() > _SAME * max(1.0, float(np.abs(known).max())):
                return posed.result(_TITLE, state, 0, answer.solver, tuple(attempts), left_out, problem)
            passed.append(_another_status(self._problem, len(passed)))
            problem = cp.Problem(self._problem.objective, [*self._problem.constraints, *passed])
        raise SolverError(
            f"mixed-integer increment: {_TRIES} statuses describe the known state, which leaves open whether another state exists; nodes are exactly "
            "at a bound: change the load a little"
        )

    def _guess(self, posed: PosedIncrement) -> State:
        """State by a semismooth Newton method, on the closed contact first: let open at once, nodes open and stick by turns for ever."""
        law, none = self._law, np.zeros(self._law.nodes)
        closed = settle(law.S, law.friction, none, posed.trial, np.full(law.nodes, STICK, dtype=np.int8), _GUESSES, separation=False)
        return settle(law.S, law.friction, none, posed.trial, closed.status, _GUESSES)

    def _set(self, posed: PosedIncrement, expected: Status, held: Status | None) -> tuple[str, ...]:
        """Set the parameters in place, without the motions that a known state does not have; says what is left out."""
        bounds, values = self._bounds.of(posed), self._problem.param_dict
        values["slip_low"].value = bounds.slip_low
        for name in ("slip_high", "gap_high", "pressure_high", "forward_high", "backward_high"):
            values[name].value = np.maximum(getattr(bounds, name), 0.0)  # below 0 only where there is no state: left for the program to find
        values["trial_reaction"].value = posed.trial
        values["preference"].value = np.array([1.0 - 2.0 * (expected == status) for status in _STATUS.values()])
        if held is None:
            return ()
        still = held == STICK
        for name, off in (("slip_low", still), ("slip_high", still), ("gap_high", held != OPEN)):
            values[name].value = np.where(off, 0.0, values[name].value)
        count = f"{int(still.sum())} of {len(still)} nodes stick and {int((held != OPEN).sum())} stay closed in a known state"
        return (f"motions: {count}, no bounds but 0 in the program",)


def _read_status(problem: cp.Problem) -> Status:
    booleans = np.array([problem.var_dict[name].value for name in _STATUS]) > 0.5
    return np.select(list(booleans), list(_STATUS.values()), STICK).astype(np.int8)


def _exact_problem(law: Law) -> cp.Problem:
    n, f = law.nodes, law.friction
    dv, w = cp.Variable(n, name="slip_increment"), cp.Variable(n, name="gap")
    forward, backward, opened = (cp.Variable(n, boolean=True, name=name) for name in _STATUS)
    trial, preference = cp.Parameter(2 * n, name="trial_reaction"), cp.Parameter((3, n), name="preference")
    slip_low, slip_high = cp.Parameter(n, nonpos=True, name="slip_low"), cp.Parameter(n, nonneg=True, name="slip_high")
    gap_high, pressure_high = cp.Parameter(n, nonneg=True, name="gap_high"), cp.Parameter(n, nonneg=True, name="pressure_high")
    forward_high, backward_high = cp.Parameter(n, nonneg=True, name="forward_high"), cp.Parameter(n, nonneg=True, name="backward_high")

    r = trial + law.S @ cp.hstack([dv, w])
    q, p = r[:n], r[n:]
    rows = {
        "one_status": forward + backward + opened <= 1,
        "moves_forward": dv <= cp.multiply(slip_high, forward + opened),
        "moves_backward": cp.multiply(slip_low, backward + opened) <= dv,
        "no_overlap": w >= 0,
        "opens": w <= cp.multiply(gap_high, opened),
        "no_tension": p >= 0,
        "no_force_across_a_gap": p <= cp.multiply(pressure_high, 1 - opened),
        "forward_bound": cp.multiply(f, p) + q >= 0,
        "on_forward_bound": cp.multiply(f, p) + q <= cp.multiply(forward_high, 1 - forward - opened),
        "backward_bound": cp.multiply(f, p) - q >= 0,
        "on_backward_bound": cp.multiply(f, p) - q <= cp.multiply(backward_high, 1 - backward - opened),
    }
    unexpected = cp.sum(cp.multiply(preference, cp.vstack([forward, backward, opened])))
    return cp.Problem(cp.Minimize(unexpected), [row.set_label(name) for name, row in rows.items()])


def _another_status(problem: cp.Problem, count: int) -> cp.Constraint:
    """A row that passes over the status that now stands in the booleans."""
    terms = []
    for name in _STATUS:
        variable = problem.var_dict[name]
        terms.append(cp.sum(cp.multiply(np.where(variable.value > 0.5, -1.0, 1.0), variable)) + float((variable.value > 0.5).sum()))
    return (sum(terms) >= 1).set_label(f"other_status_{count}")
