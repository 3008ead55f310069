"""Constraints and objectives of the user's own in the programs over safe slips: expressions, rows, and what the multipliers prove."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, flag, shown
from ..contact.tolerances import RESIDUAL
from ..errors import ModelError
from ..solve.explain import Units
from ..solve.solvers import solve, solver_order
from ..solve.standard_form import StandardForm, polish
from .own_rows import Bound, own_rows
from .program import SafeProgram, kind_of, safe_set
from .question import LimitQuestion, cycle_loads, pose, slip_bounds
from .safe_set import SafeSet

__all__ = ["Contradiction", "OwnProgram", "SafeModel", "contradiction", "is_unbounded"]


@dataclass(frozen=True, eq=False)
class OwnProgram(SafeProgram):
    """A program over safe slips with constraints, and maybe an objective, of the user's own.

    Attributes
    ----------
    objective_unit
        Unit of its objective where that is the user's own, else None.
    variables
        The user's variables, and what they are in the well-scaled program.
    bounds
        Which rows bound what the user's constraints bound.
    """

    objective_unit: float | None = None
    variables: Sequence[tuple[cp.Variable, cp.Expression]] = ()
    bounds: Sequence[Bound] = ()

    @property
    def unit(self) -> float:
        """Unit of its objective."""
        return self.task.load_unit if self.objective_unit is None else self.objective_unit

    @property
    def units(self) -> Units:
        """See `SafeProgram.units`."""
        return {**super().units, "objective": self.unit}

    @property
    def prices(self) -> dict[str, Array]:
        """Rate of the objective as each constraint of the user's own gives way, in the user's units: >= 0; of an equation with its right side."""
        found = dict[str, Array]()
        for bound in self.bounds:
            found[bound.name] = found.get(bound.name, 0.0) + bound.sign * self.unit * bound.multiplier
        return found

    def save(self) -> None:
        """Put the values of a solution into the variables of the user."""
        for variable, scaled in self.variables:
            variable.save_value(np.asarray(scaled.value))


class SafeModel:
    """Base of models that take constraints of the user's own: what they decide on, in the user's units."""

    def __init__(
        self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: ArrayLike | None = None, simplify: bool = True, solver: str | None = None
    ) -> None:
        self._system, self._cycle, self._loads = system, cycle, cycle_loads(system, cycle)
        self._most, self._simplify, self._solver = slip_bounds(slip_bound, system.nodes), flag("simplify", simplify), solver
        solver_order(solver, kind_of(system))
        self._sets: dict[int, SafeSet] = {}  # by the number of nodes: of the whole contact, and of its half
        self._compiled: dict[tuple[int, bool], cp.Problem] = {}  # by what friction can change: half or whole, rows of opening
        self._last: tuple[list[object], OwnProgram | None] = [], None

    def _posed(self, friction: ArrayLike, simplify: bool = True) -> LimitQuestion:
        return pose(self._system, self._cycle, friction, simplify=self._simplify and simplify, most=self._most, loads=self._loads)

    def _set(self, task: LimitQuestion) -> SafeSet:
        known = self._sets if task.lift is None else {}
        return known.get(len(task.friction)) or known.setdefault(len(task.friction), self._unknowns(task))

    def _unknowns(self, task: LimitQuestion) -> SafeSet:
        return safe_set(task)

    def _program(self, listing: Callable[[SafeSet], cp.Problem], task: LimitQuestion, load_factor: float | None = None) -> SafeProgram:
        """The program over safe slips; that of a plane contact, of which no part of the cycle is fixed and no node open, is compiled once."""
        v, kind = self._set(task), (len(task.friction), task.opening)
        v.ask(task, load_factor)
        if task.system.tangents > 1 or task.lift is not None or task.loads.fixed:
            return SafeProgram(task, v, listing(v))
        return SafeProgram(task, v, self._compiled.get(kind) or self._compiled.setdefault(kind, listing(v)))

    @cached_property
    def _v(self) -> SafeSet:
        return self._set(self._posed(1.0))

    @cached_property
    def load_factor(self) -> cp.Expression:
        """The load factor, an affine cvxpy expression for constraints of your own."""
        return cp.Parameter(nonneg=True, name="load_unit") * self._v.load_factor

    @cached_property
    def slip(self) -> cp.Expression:
        """(N,) or (N, 2) residual slip, length, an affine cvxpy expression for constraints of your own."""
        return cp.reshape(self._v.slip, self._system.slip_shape, order="F")

    @cached_property
    def q(self) -> cp.Expression:
        """(K, N) or (K, N, 2) shear forces at the corners of the cycle, force, an affine cvxpy expression for constraints of your own."""
        unit, shape = np.tile(self._v.scaled.unit, self._system.tangents), self._system.slip_shape
        return self._at_corners(self._loads.q0, self._loads.q1, cp.reshape(cp.multiply(unit, self._v.shear), (1, *shape), order="F"))

    @cached_property
    def p(self) -> cp.Expression:
        """(K, N) normal forces at the corners of the cycle, compression positive, force, an affine cvxpy expression for constraints of your own."""
        change = cp.multiply(self._v.scaled.unit, self._v.pressure)
        return self._at_corners(self._loads.p0, self._loads.p1, cp.reshape(change, (1, change.size), order="F"))

    def _at_corners(self, mean: Array, cyclic: Array, change: cp.Expression) -> cp.Expression:
        return cp.Constant(np.broadcast_to(mean, cyclic.shape)) + change + self.load_factor * cp.Constant(cyclic)

    def _own(
        self,
        listing: Callable[[SafeSet], cp.Problem],
        task: LimitQuestion,
        constraints: list[Any],
        objective: Any = None,
        load_factor: float | None = None,
    ) -> OwnProgram:
        """The program with constraints and an objective to be largest (None for its own); in the plane compiled once for the same ones.

        Raises
        ------
        ModelError
            What is no cvxpy constraint or expression, not convex, no linear or cone program, or on unknowns of another model.
        """
        (parameter,) = self.load_factor.parameters()
        parameter.value = task.load_unit if load_factor is None else load_factor
        self._v.ask(task, load_factor)
        asked = [*constraints, objective, task.opening, *([] if task.system.tangents == 1 and not task.loads.fixed else [task])]
        last, program = self._last
        if program is None or [*map(id, last)] != [*map(id, asked)]:
            program = _compiled(task, self._v, listing(self._v), constraints, objective)
            self._last = asked, program
        return replace(program, task=task)


def _compiled(task: LimitQuestion, v: SafeSet, problem: cp.Problem, constraints: list[Any], objective: Any) -> OwnProgram:
    goal = cp.Variable(name="objective")
    known = {variable.id for part in (problem.variables(), v.slip.variables(), [v.load_factor]) for variable in part}
    named = {f"constraints[{index}]": constraint for index, constraint in enumerate(constraints)}
    if objective is not None:
        if not isinstance(objective, cp.Expression) or objective.size != 1:
            raise ModelError(f"objective: {shown(objective)}; give a scalar cvxpy expression on slip, load_factor, q and p of the model")
        named["objective"] = goal <= cp.reshape(objective, (), order="C")
    rows, variables, bounds = own_rows(named, known)
    if objective is None:
        return OwnProgram(task, v, cp.Problem(problem.objective, [*problem.constraints, *rows]), tuple(rows), None, variables, bounds)
    scaled = next(scaled for variable, scaled in variables if variable is goal)
    (inner,) = scaled.variables()
    program = cp.Problem(cp.Maximize(inner), [*problem.constraints, *rows])
    inner.save_value(np.ones(()))
    return OwnProgram(task, v, program, tuple(rows), float(scaled.value), variables, [bound for bound in bounds if bound.row.label != "objective"])


@dataclass(frozen=True, eq=False)
class Contradiction:
    """The least excess by which the rows and cones of a program cannot hold.

    Attributes
    ----------
    value, bound
        That of a solution, and the least that the multipliers prove: above 0, the rows contradict each other (Farkas's lemma).
    ruling
        Names of the rows with multipliers.
    residual
        Distance of value and bound where they do not prove an excess.
    z
        The variables of the solution, in the order of the program's columns.
    """

    value: float
    bound: float
    ruling: frozenset[str]
    residual: float
    z: Array


def contradiction(problem: cp.Problem, solver: str | None) -> Contradiction:
    """The least `e >= 0` by which all slacks but those of equations must be raised to be in their cones.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    form = StandardForm(problem)
    return _least_excess(form, form.right, None, solver)


def is_unbounded(problem: cp.Problem, solver: str | None) -> Contradiction | None:
    """Proof that a program that has a solution has no largest one, for its objective can grow while no slack falls; None if it cannot.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    form = StandardForm(problem)
    growing = _least_excess(form, np.zeros(len(form.right)), form.objective, solver)
    return None if max(growing.bound, growing.value) > RESIDUAL else growing


@dataclass(frozen=True, eq=False)
class _Relaxed:
    problem: cp.Problem
    labels: list[str]

    def refine(self) -> None:
        polish(self.problem)

    def claim(self) -> Contradiction:
        form = StandardForm(self.problem)
        value, bound = (-side for side in form.bounds)
        ruling = frozenset(label for label, y in zip(self.labels, form.y, strict=True) if y > RESIDUAL)
        z = next(variable.value for variable in self.problem.variables() if variable.name() == "z")
        return Contradiction(value, bound, ruling, 0.0 if bound > RESIDUAL else abs(value - bound), z)


def _least_excess(form: StandardForm, right: Array, objective: Array | None, solver: str | None) -> Contradiction:
    """The least excess of slacks `right - matrix @ z`, and of `objective @ z >= 1` where there is an objective."""
    z, excess = cp.Variable(form.matrix.shape[1], name="z"), cp.Variable(name="excess")
    s, names = right - form.matrix @ z, np.array([row.label for row in form.rows for _ in range(row.size)])
    rows, extra = [excess >= 0], [] if objective is None else [objective @ z + excess >= 1]
    rows += [s[: form.zero] == 0] if form.zero else []
    rows += [s[form.linear] + excess >= 0] if len(form.linear) else []
    rows += [cp.SOC(s[cone[:, 0]] + excess, cp.reshape(s[cone[:, 1:].ravel()], cone[:, 1:].shape, order="C"), axis=1) for cone in form.cones]
    labels = [*names[: form.zero], "", *names[form.linear], *([""] * len(extra)), *(names[i] for cone in form.cones for i in cone.ravel())]
    model = _Relaxed(cp.Problem(cp.Minimize(excess), [*rows, *extra]), labels)
    return solve(model, model.claim, solver).claim
