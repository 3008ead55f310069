"""One friction increment as a sequence of convex quadratic programs, in each of which the friction bound is frozen.

With the bound g of every node given, the increment minimises (Klarbring, Mikelic & Shillor 1988: friction with a given bound)::

    1/2 u' S u + trial' u + g' |dv|    over  u = [dv, w],  w >= 0

because its optimality conditions are the contact law with g in place of f p. The law itself is the fixed point `g = f p`.
"""

from typing import Any

import cvxpy as cp
import numpy as np

from ...contact import ContactSystem
from ...contact.checks import Array
from ...contact.record import Attempt
from ...contact.tolerances import CONVERGED, RESIDUAL, SWEEP
from ...errors import SolverError
from ...solve.solvers import Kind, NoOptimum, solve, solver_order
from .engine import CORRECTIONS, IncrementEngine, Program, StateClaim
from .increment import Increment, Law, PosedIncrement
from .newton import State, guessed, settle

__all__ = ["FrozenBoundIncrement"]

_SWEEPS = 100  # quadratic programs for one increment at most


def _frozen_problem(law: Law, separation: bool) -> cp.Problem:
    n = law.nodes
    dv, w = cp.Variable(n, name="slip_increment"), cp.Variable(n, name="gap") if separation else cp.Constant(np.zeros(n))
    trial, bound = cp.Parameter(2 * n, name="trial_reaction"), cp.Parameter(n, nonneg=True, name="friction_bound")

    u = cp.hstack([dv, w])
    energy = cp.quad_form(u, cp.psd_wrap(law.S)) / 2 + trial @ u
    dissipation = bound @ cp.abs(dv)
    return cp.Problem(cp.Minimize(energy + dissipation), [(w >= 0).set_label("no_overlap")] if separation else [])


class FrozenBoundIncrement(IncrementEngine):
    """One friction increment by quadratic programs with frozen friction bound, compiled once.

    After each sweep the state of the status that the program ends with is solved exactly, with the bound free; if the referee accepts it, it is the
    answer. Otherwise the bound moves to `f p` and the program is solved again. This need not converge where friction and coupling are strong. The
    `problem` of a result is the program of the last sweep, with the bound of that sweep.

    It takes no constraints of your own: they would act as forces that the contact law does not have. Theory, eq. (11).

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.
    simplify
        Leave out what cannot change the answer: the program where the trial state obeys the law, the gaps where nothing opens, half
        of a contact that is mirror-symmetric with its slip and its load.
    solver
        One of "OSQP", "CLARABEL"; by default each in this order until an answer passes. OSQP may print "Polishing not needed" where nothing slips.

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
    >>> fo.FrozenBoundIncrement(system, friction=0.5).solve([0.0, 0.0], load).slip.round(6).tolist()
    [-0.326531, -0.122449]
    """

    _title = "friction increment, frozen bound"

    def __init__(self, system: ContactSystem, friction: Any, *, simplify: bool = True, solver: str | None = None) -> None:
        solver_order(solver, Kind.QP)
        super().__init__(system, friction, simplify, solver=solver)
        self._solver, self._problems = solver, dict[bool, cp.Problem]()

    @property
    def problem(self) -> cp.Problem:
        """The quadratic program with gaps."""
        return self._problem(True)

    def _problem(self, separation: bool) -> cp.Problem:
        if separation not in self._problems:
            self._problems[separation] = _frozen_problem(self._law, separation)
        return self._problems[separation]

    def _solve_program(self, posed: PosedIncrement) -> Increment:
        law, n, attempts = self._law, self._law.nodes, list[Attempt]()
        bound, separation = law.friction * np.maximum(posed.trial[n:], 0.0), not self._simplify or bool(posed.trial[n:].min() < 0)
        for sweep in range(1, _SWEEPS + 1):
            frozen = self._sweep(posed, bound, separation, attempts)
            released = settle(law.S, law.friction, law.no_bound, posed.trial, frozen.status, CORRECTIONS)
            residual = posed.residual(released)
            if residual <= RESIDUAL:
                left_out = () if separation else ("gaps: no unknowns of the program, because the trial pressures are positive",)
                return posed.result(self._title, released, sweep, attempts[-1].solver, tuple(attempts), left_out, self._problem(separation))
            step = law.friction * np.maximum(frozen.r[n:], 0.0) - bound
            opens = not separation and bool(frozen.r[n:].min() < 0)
            if np.abs(step).max() <= CONVERGED and not opens:
                break
            bound, separation = bound + step, separation or opens
        raise SolverError(
            f"friction increment: did not converge in {sweep} sweeps with frozen bound; the bound still changes by {np.abs(step).max():.1e} of the "
            f"mean normal force, most at node {int(np.abs(step).argmax())}, and the residual is {residual:.1e}; try smaller load steps or an "
            "ExactIncrement (above the critical friction there may be no state, or several)"
        )

    def _sweep(self, posed: PosedIncrement, bound: Array, separation: bool, attempts: list[Attempt]) -> State:
        """The state with this bound."""
        problem = self._problem(separation)
        problem.param_dict["trial_reaction"].value, problem.param_dict["friction_bound"].value = posed.trial, bound
        program = Program(problem, lambda corrections: _claim(problem, posed, bound, separation, corrections))
        try:
            answer = solve(program, program.claim, self._solver, kind=Kind.QP, tolerance=SWEEP)
        except NoOptimum as error:
            raise SolverError(
                f"friction increment: no state of rest with the friction bound frozen at {bound.sum():.3g} times the mean normal force in sum "
                f"({error}); check the supports of the body and whether the load exceeds friction; where slip would raise the pressure enough "
                "to hold it, an ExactIncrement may find the state"
            ) from error
        attempts += answer.attempts
        return answer.claim.state


def _claim(problem: cp.Problem, posed: PosedIncrement, bound: Array, separation: bool, corrections: int) -> StateClaim:
    """The state that stands in the variables, corrected if need be, judged by the optimality conditions of the frozen problem."""
    none, S = np.zeros_like(bound), posed.law.S
    u = np.r_[problem.var_dict["slip_increment"].value, problem.var_dict["gap"].value if separation else none]
    r = posed.trial + S @ u
    state = State(guessed(none, bound, u, r, separation), u, r)
    if corrections:
        state = settle(S, none, bound, posed.trial, state.status, corrections, separation)
    (dv, w), (q, p) = np.split(state.u, 2), np.split(state.r, 2)
    off_bound = np.where(dv > 0, bound + q, bound - q)
    violations = [np.abs(q) - bound, np.minimum(np.abs(dv), np.abs(off_bound))]
    if separation:
        violations += [-w, -p, np.minimum(w, p)]
    residual = float(np.max(violations))
    return StateClaim(state, residual if np.isfinite(residual) else np.inf)
