"""Constraints and objectives of the user's own in the linear programs over safe slips: expressions, rows, and what the multipliers prove."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import cvxpy as cp
import numpy as np
from cvxpy.reductions.dcp2cone.dcp2cone import Dcp2Cone

from ..contact.checks import Array, shown
from ..contact.record import Attempt
from ..contact.tolerances import RESIDUAL
from ..errors import ModelError
from ..solve.polish import Program, polish, standard_form
from ..solve.solvers import solve
from .loads import Loads
from .ruling_corners import RulingLoads
from .safe_set import SafeProblem

__all__ = ["Contradiction", "Expressions", "Extendable", "Extended", "contradiction", "is_unbounded"]

_EQUATIONS, _AT_MOST, _AT_LEAST = (
    (cp.constraints.Equality, cp.constraints.Zero),
    (cp.constraints.Inequality, cp.constraints.NonPos),
    cp.constraints.NonNeg,
)


class Extendable(ABC):
    """Base of models that take constraints of the user's own: what they decide on, in the user's units."""

    @property
    @abstractmethod
    def _expressions(self) -> "Expressions": ...

    @property
    def load_factor(self) -> cp.Expression:
        """The load factor, an affine cvxpy expression for constraints of your own."""
        return self._expressions.load_factor

    @property
    def slip(self) -> cp.Expression:
        """(N,) residual slip, length, an affine cvxpy expression for constraints of your own."""
        return self._expressions.slip

    @property
    def q(self) -> cp.Expression:
        """(K, N) shear forces at the corners of the cycle, force per depth, an affine cvxpy expression for constraints of your own."""
        return self._expressions.q

    @property
    def p(self) -> cp.Expression:
        """(K, N) normal forces at the corners of the cycle, compression positive, an affine cvxpy expression for constraints of your own."""
        return self._expressions.p


@dataclass(frozen=True, eq=False)
class Extended:
    """A program over safe slips with constraints, and maybe an objective, of the user's own.

    Attributes
    ----------
    model
        The program; its rows `own` are those of the user.
    objective_unit
        Unit of its objective where that is the user's own, else None.
    variables
        The user's variables, and what they are in the well-scaled program.
    """

    model: SafeProblem
    objective_unit: float | None
    variables: list[tuple[cp.Variable, cp.Expression]]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the constraints, each once."""
        return tuple(dict.fromkeys(row.label for row in self.model.own))

    def save(self) -> None:
        """Put the values of a solution into the variables of the user."""
        for variable, scaled in self.variables:
            variable.save_value(np.asarray(scaled.value))


class Expressions:
    """What a program over safe slips decides on, as affine cvxpy expressions in the user's units.

    Parameters
    ----------
    safe
        The program of the whole contact, with the rows `no_opening`.
    loads
        Reactions of the load cycle.
    load_factor
        The load factor, with one parameter.

    Attributes
    ----------
    scaled
        Unknowns and units of the whole contact.
    load_factor, slip, q, p
        Scalar, (N,) length, and (K, N) reactions of the closed contact at the corners, force per depth.
    """

    def __init__(self, safe: SafeProblem, loads: Loads, load_factor: cp.Expression) -> None:
        scaled, v = safe.scaled, safe.symbols
        self._safe, self._last = safe, (list[Any](), Extended(safe, None, []))
        self.scaled = scaled
        self.load_factor: cp.Expression = load_factor
        self.slip: cp.Expression = scaled.slip @ v.traction + (0.0 if v.slide is None else scaled.rigid @ v.slide)
        changes = cp.multiply(scaled.unit, scaled.shear @ v.traction), cp.multiply(scaled.unit, scaled.normal @ v.traction)
        self.q, self.p = (
            np.ones((loads.corners, 1)) @ cp.reshape(mean + change, (1, len(mean)), order="C") + cp.Constant(cyclic) * self.load_factor
            for mean, cyclic, change in zip((loads.q0, loads.p0), (loads.q1, loads.p1), changes, strict=True)
        )

    def unknown(self, name: str) -> cp.Variable:
        """An unknown of the program by its name."""
        return self._safe.problem.var_dict[name]

    def extended(self, constraints: list[Any], objective: Any, rows: RulingLoads, opening: bool, load_factor: float | None = None) -> Extended:
        """The program with constraints and an objective to be largest (None for its own), compiled once for the same ones, and its parameters set.

        Without the rows `no_opening` where friction implies them.

        Raises
        ------
        ModelError
            What is no cvxpy constraint or expression, not convex, not linear, or on unknowns of another model.
        """
        (parameter,) = self.load_factor.parameters()
        parameter.value = rows.load_unit if load_factor is None else load_factor
        asked = [*constraints, objective, opening]
        if [*map(id, self._last[0])] != [*map(id, asked)]:
            self._last = asked, self._compiled(constraints, objective, opening)
        self._last[1].model.set(rows, load_factor)
        return self._last[1]

    def _compiled(self, constraints: list[Any], objective: Any, opening: bool) -> Extended:
        problem, goal = self._safe.problem, cp.Variable(name="objective")
        kept = [row for row in problem.constraints if opening or row.label != "no_opening"]
        known = {variable.id for part in (problem.variables(), self.slip.variables()) for variable in part}
        named = {f"constraints[{index}]": constraint for index, constraint in enumerate(constraints)}
        if objective is not None:
            if not isinstance(objective, cp.Expression) or objective.size != 1:
                raise ModelError(f"objective: {shown(objective)}; give a scalar cvxpy expression on slip, load_factor, q and p of the model")
            named["objective"] = goal <= cp.reshape(objective, (), order="C")
        rows, variables = own_rows(named, known)
        if objective is None:
            return Extended(replace(self._safe, problem=cp.Problem(problem.objective, [*kept, *rows]), own=tuple(rows)), None, variables)
        scaled = next(scaled for variable, scaled in variables if variable is goal)
        (inner,) = scaled.variables()
        program = cp.Problem(cp.Maximize(inner), [*kept, *rows])
        inner.save_value(np.ones(()))
        return Extended(replace(self._safe, problem=program, own=tuple(rows)), float(scaled.value), variables)


def own_rows(constraints: Mapping[str, Any], known: set[int]) -> tuple[list[cp.Constraint], list[tuple[cp.Variable, cp.Expression]]]:
    """Well-scaled inequalities that say what named linear constraints say (an equation is two), and their variables besides the known ones.

    Constraints of abs, max, norm1 and the like bring variables of their own.

    Raises
    ------
    ModelError
        Not a cvxpy constraint, not convex, not linear, or on unknowns of another model.
    """
    rows: list[cp.Constraint] = []
    for name, constraint in constraints.items():
        _check(name, constraint, known)
        linear, _ = Dcp2Cone(quad_obj=False).apply(cp.Problem(cp.Minimize(0), [constraint]))
        for part in linear.constraints:
            if not isinstance(part, (*_EQUATIONS, _AT_MOST, _AT_LEAST)):
                raise ModelError(
                    f"{name}: it needs a {type(part).__name__} cone; the program is linear, so that its multipliers prove the answer: "
                    "give linear constraints, or such of abs, max, min, norm1 and norm_inf"
                )
            signs = (1, -1) if isinstance(part, _EQUATIONS) else (-1,) if isinstance(part, _AT_LEAST) else (1,)
            rows += [(sign * part.expr <= 0).set_label(constraint.label or name) for sign in signs]
    return _scaled(rows, known)


def _scaled(rows: list[cp.Constraint], known: set[int]) -> tuple[list[cp.Constraint], list[tuple[cp.Variable, cp.Expression]]]:
    """The rows divided by their size, which spreads from the unknowns of the model to the other variables."""
    data = cp.Problem(cp.Minimize(0), rows).get_problem_data("CLARABEL")[0]
    size, constant, columns = abs(data["A"].toarray()), np.abs(data["b"]), data["param_prob"].var_id_to_col
    others = [variable for variable in cp.Problem(cp.Minimize(0), rows).variables() if variable.id not in known]
    at = {variable.id: slice(columns[variable.id], columns[variable.id] + variable.size) for variable in others}
    unit = np.ones(size.shape[1])
    for place in at.values():
        unit[place] = 0.0  # not known yet
    for _ in others:
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where((size > 0) & (unit == 0), (size @ unit)[:, None] / size, 0.0).max(axis=0, initial=0.0)
        unit = np.where(unit == 0, reach, unit)
    unit = np.where(unit == 0, 1.0, unit)
    sizes = np.linalg.norm(size * unit, axis=1)
    sizes = np.where(sizes > 0, sizes, np.where(constant > 0, constant, 1.0))
    own = {v.id: cp.multiply(unit[at[v.id]].reshape(v.shape, order="F"), cp.Variable(v.shape, name=v.name())) for v in others}
    swap = {id(variable): own[variable.id] for variable in others}
    parts = np.split(sizes, np.cumsum([row.size for row in rows])[:-1])
    scaled = [
        (row.expr.tree_copy(swap) / part.reshape(row.shape, order="F") <= 0).set_label(row.label) for row, part in zip(rows, parts, strict=True)
    ]
    return scaled, [(variable, own[variable.id]) for variable in others]


def _check(name: str, constraint: Any, known: set[int]) -> None:
    if not isinstance(constraint, cp.Constraint):
        raise ModelError(
            f"{name}: {shown(constraint)}; give a cvxpy constraint on slip, load_factor, q and p of the model, such as model.slip <= 1e-3"
        )
    if not constraint.is_dcp(dpp=True):
        raise ModelError(
            f"{name}: not convex (an objective: not concave) by the rules of DCP, or not affine in its parameters (DPP); change it so that it is"
        )
    for variable in constraint.variables():
        if variable.id not in known and variable.name() in ("load_factor", "margin", "traction", "slide"):
            raise ModelError(f"{name}: it is on the {variable.name()} of another model; use the expressions of the model that solves")
        if any(variable.attributes.values()):
            raise ModelError(f"{name}: variable {variable.name()} has attributes; give a plain one, and its bounds as constraints")
    for parameter in constraint.parameters():
        if parameter.value is None:
            raise ModelError(f"{name}: parameter {parameter.name()} has no value; give it one before solving")


@dataclass(frozen=True, eq=False)
class Contradiction:
    """The least excess by which the rows of a linear program cannot hold.

    Attributes
    ----------
    value, bound
        That of a solution, and the least that the multipliers prove: above 0, the rows contradict each other (Farkas's lemma).
    ruling
        Names of the rows with multipliers.
    residual, attempts
        Distance of value and bound where they do not prove an excess, and the solver runs.
    """

    value: float
    bound: float
    ruling: frozenset[str]
    residual: float
    attempts: tuple[Attempt, ...] = ()


@dataclass(frozen=True, eq=False)
class _Relaxed:
    problem: cp.Problem
    labels: list[str]

    def refine(self) -> None:
        polish(self.problem)

    def claim(self) -> Contradiction:
        program = Program(self.problem)
        value, bound = (-side for side in program.bounds)
        ruling = frozenset(label for label, y in zip(self.labels, program.y[: len(self.labels)], strict=True) if y > RESIDUAL)
        return Contradiction(value, bound, ruling, 0.0 if bound > RESIDUAL else abs(value - bound))


def contradiction(problem: cp.Problem, solver: str | None) -> Contradiction:
    """The least `e >= 0` with `matrix @ z + e >= right`, of a linear program in its standard form.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    matrix, right, _ = standard_form(problem)
    return _least_excess(matrix, right, [row.label for row in problem.constraints for _ in range(row.size)], solver)


def is_unbounded(problem: cp.Problem, solver: str | None) -> Contradiction | None:
    """Proof that a linear program that has a solution has no largest one, for its objective can grow while no row falls; None if it cannot.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    matrix, right, objective = standard_form(problem)
    growing = _least_excess(np.vstack([matrix, objective]), np.append(np.zeros(len(right)), 1.0), [], solver)
    return None if max(growing.bound, growing.value) > RESIDUAL else growing


def _least_excess(matrix: Array, right: Array, labels: list[str], solver: str | None) -> Contradiction:
    z, excess = cp.Variable(matrix.shape[1], name="z"), cp.Variable(name="excess")
    model = _Relaxed(cp.Problem(cp.Minimize(excess), [matrix @ z + excess >= right, excess >= 0]), labels)
    return solve(model, model.claim, solver).claim
