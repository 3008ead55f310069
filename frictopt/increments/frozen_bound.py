"""One friction increment as a sequence of convex quadratic programs, in each of which the friction bound is frozen.

With the bound g of every node given, the increment minimises (Klarbring, Mikelic & Shillor 1988: friction with a given bound)::

    1/2 u' S u + trial' u + g' |dv|    over  u = [dv, w],  w >= 0

because its optimality conditions are the contact law with g in place of f p. The law itself is the fixed point `g = f p`.
"""

from functools import partial
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import ContactSystem
from ..contact.checks import Array, finite_number, flag, whole_number
from ..errors import SolverError
from ..solve.explain import explain
from ..solve.solvers import TOLERANCE, Attempt, Kind, NoOptimum, solve, solver_order
from .halved import HalvedIncrement
from .increment import Increment, Law, PosedIncrement
from .newton import State, guessed, settle
from .status_search import StateClaim

__all__ = ["FrozenBoundIncrement"]

_TITLE = "friction increment, frozen bound"
_CONVERGED = 1e-11  # change of the bound, in units of the mean normal force, that counts as none
_SWEEP = 1e-6  # largest violation with which a sweep may end: it only guides the next one and the exact state
_CORRECTIONS = 3  # of the status that a sweep ends with, before the next sweep
_LEAST, _REGAIN = 1 / 16, 1.2  # a growing change halves the relaxation, down to this share; a falling one lets it grow by this factor


class FrozenBoundIncrement:
    """One friction increment by quadratic programs with frozen friction bound, compiled once.

    After each sweep the state of the status that the program ends with is solved exactly, with the bound free; if the referee accepts it, it is the
    answer. Otherwise the bound moves to `f p` and the program is solved again. This need not converge where friction and coupling are strong. The
    `problem` of a result is the program of the last sweep, with the bound of that sweep.

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.
    simplify
        Leave out what the increment does not need: the program where the trial state obeys the law, the gaps where nothing opens, half
        of a contact that is mirror-symmetric with its slip and its load.
    solver
        One of "CLARABEL", "HIGHS_QP"; by default each in this order until an answer passes.
    sweeps
        Largest number of quadratic programs for one increment.
    relaxation
        Share of the way from the old bound to `f p`, above 0 and at most 1; less where the change of the bound grows from sweep to sweep.

    Raises
    ------
    ModelError
        Bad input.
    """

    def __init__(
        self, system: ContactSystem, friction: Any, *, simplify: bool = True, solver: str | None = None, sweeps: int = 100, relaxation: float = 1.0
    ) -> None:
        self._law, self._simplify, self._solver = Law(system, friction), flag("simplify", simplify), solver
        solver_order(solver, Kind.QP)
        self._sweeps = whole_number("sweeps", sweeps, least=1)
        self._relaxation = finite_number("relaxation", relaxation, above=0.0, below=1.0 + 1e-12)
        self._halved = HalvedIncrement(self._law, partial(FrozenBoundIncrement, solver=solver, sweeps=sweeps, relaxation=relaxation))
        self._models: dict[bool, _FrozenProblem] = {}

    @property
    def problem(self) -> cp.Problem:
        """The quadratic program with gaps."""
        return self._model(True).problem

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the quadratic program by its names."""
        explain(_TITLE, self.problem, None, {}, (), pd.DataFrame(), file)

    def solve(self, slip: Any, bonded: Any) -> Increment:
        """The state to which a slip moves under a load.

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
        SolverError
            The bound does not converge, or a program has no solution.
        """
        posed = self._law.pose(slip, bonded)
        if self._simplify and posed.stuck:
            return posed.closed_form(_TITLE)
        halved = self._halved.solve(_TITLE, posed) if self._simplify else None
        if halved is not None:
            return halved
        pressure = posed.trial[self._law.nodes :]
        return self._iterate(posed, self._law.friction * np.maximum(pressure, 0.0), separation=not self._simplify or bool(pressure.min() < 0))

    def _model(self, separation: bool) -> "_FrozenProblem":
        if separation not in self._models:
            self._models[separation] = _FrozenProblem(self._law, separation)
        return self._models[separation]

    def _iterate(self, posed: PosedIncrement, bound: Array, separation: bool) -> Increment:
        law, attempts, relaxation, last = self._law, list[Attempt](), self._relaxation, np.inf
        for sweep in range(1, self._sweeps + 1):
            model = self._model(separation)
            frozen = self._sweep(model, posed, bound, attempts)
            pressure = np.maximum(frozen.r[law.nodes :], 0.0)
            result = self._released(model, posed, frozen, sweep, attempts)
            if result.residual <= TOLERANCE:
                return result
            separation = separation or bool(frozen.r[law.nodes :].min() < 0)
            step = law.friction * pressure - bound
            change = float(np.abs(step).max())
            if change <= _CONVERGED and model.separation == separation:
                break
            relaxation = max(relaxation / 2, _LEAST * self._relaxation) if change > last else min(_REGAIN * relaxation, self._relaxation)
            bound, last = bound + relaxation * step, change
        raise SolverError(
            f"friction increment: did not converge in {sweep} sweeps with frozen bound; the bound still changes by {change:.1e} of the mean normal "
            f"force, most at node {int(np.abs(step).argmax())}, and the residual is {result.residual:.1e}; try smaller load steps, less relaxation "
            f"than {self._relaxation:g}, more sweeps, or an ExactIncrement (above the critical friction there may be no state, or several)"
        )

    def _sweep(self, model: "_FrozenProblem", posed: PosedIncrement, bound: Array, attempts: list[Attempt]) -> State:
        model.set(posed.trial, bound)
        try:
            answer = solve(model, model.claim, self._solver, kind=Kind.QP, tolerance=_SWEEP)
        except NoOptimum as error:
            raise SolverError(
                f"friction increment: no state of rest with the friction bound frozen at {bound.sum():.3g} times the mean normal force in sum "
                f"({error}); check the supports of the body and whether the load exceeds friction; where slip would raise the pressure enough "
                "to hold it, an ExactIncrement may find the state"
            ) from error
        attempts += answer.attempts
        return answer.claim.state

    def _released(self, model: "_FrozenProblem", posed: PosedIncrement, frozen: State, sweep: int, attempts: list[Attempt]) -> Increment:
        """The exact state of the sweep's status, its friction bound free."""
        law, none = self._law, np.zeros(self._law.nodes)
        state = settle(law.S, law.friction, none, posed.trial, frozen.status, _CORRECTIONS)
        left_out = () if model.separation else ("gaps: no unknowns of the program, because the trial pressures are positive",)
        return posed.result(_TITLE, state, sweep, attempts[-1].solver, tuple(attempts), left_out, model.problem)


class _FrozenProblem:
    """The quadratic program with its data."""

    def __init__(self, law: Law, separation: bool) -> None:
        self.law, self.separation, self.problem = law, separation, _frozen_problem(law, separation)
        self._trial, self._bound = np.zeros(2 * law.nodes), np.zeros(law.nodes)

    def set(self, trial: Array, bound: Array) -> None:
        """Set the parameters in place."""
        self._trial, self._bound = trial, bound
        self.problem.param_dict["trial_reaction"].value = trial if self.separation else trial[: self.law.nodes]
        self.problem.param_dict["friction_bound"].value = bound

    def refine(self) -> None:
        """Move the solution onto the exact state of its status."""
        bound = self._bound
        u, r = self._values()
        none = np.zeros(self.law.nodes)
        state = settle(self.law.S, none, bound, self._trial, guessed(none, bound, u, r, self.separation), _CORRECTIONS, self.separation)
        for name, part in zip(("slip_increment", "gap"), np.split(state.u, 2), strict=True):
            if name in self.problem.var_dict:
                self.problem.var_dict[name].save_value(part)

    def claim(self) -> StateClaim:
        """Judge what stands in the variables by the optimality conditions of the frozen problem."""
        bound = self._bound
        u, r = self._values()
        (dv, w), (q, p) = np.split(u, 2), np.split(r, 2)
        off_bound = np.where(dv > 0, bound + q, bound - q)
        violations = [np.abs(q) - bound, np.minimum(np.abs(dv), np.abs(off_bound))]
        if self.separation:
            violations += [-w, -p, np.minimum(w, p)]
        residual = float(np.max(violations))
        status = guessed(np.zeros(self.law.nodes), bound, u, r, self.separation)
        return StateClaim(State(status, u, r), residual if np.isfinite(residual) else np.inf)

    def _values(self) -> tuple[Array, Array]:
        dv = np.asarray(self.problem.var_dict["slip_increment"].value)
        u = np.r_[dv, self.problem.var_dict["gap"].value if self.separation else np.zeros_like(dv)]
        return u, self._trial + self.law.S @ u


def _frozen_problem(law: Law, separation: bool) -> cp.Problem:
    n = law.nodes
    dv = cp.Variable(n, name="slip_increment")
    bound = cp.Parameter(n, nonneg=True, name="friction_bound")
    dissipation = bound @ cp.abs(dv)
    if not separation:
        trial = cp.Parameter(n, name="trial_reaction")
        return cp.Problem(cp.Minimize(cp.quad_form(dv, cp.psd_wrap(law.S[:n, :n])) / 2 + trial @ dv + dissipation))
    trial = cp.Parameter(2 * n, name="trial_reaction")
    gap = cp.Variable(n, name="gap")
    u = cp.hstack([dv, gap])
    energy = cp.quad_form(u, cp.psd_wrap(law.S)) / 2 + trial @ u
    return cp.Problem(cp.Minimize(energy + dissipation), [(gap >= 0).set_label("no_overlap")])
