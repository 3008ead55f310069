"""Constraints and objectives of the user's own as well-scaled rows and cones, and what their multipliers are in the user's units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cvxpy as cp
import numpy as np
from cvxpy.reductions.dcp2cone.dcp2cone import Dcp2Cone

from ..contact import Array, shown
from ..errors import ModelError
from ..solve.standard_form import StandardForm, compiled

OF_A_MODEL = "model."
"""How the names of the unknowns begin that a model gives the user; the program that is solved has expressions in their place."""

_EQUATIONS, _AT_MOST, _AT_LEAST = (
    (cp.constraints.Equality, cp.constraints.Zero),
    (cp.constraints.Inequality, cp.constraints.NonPos),
    cp.constraints.NonNeg,
)


@dataclass(frozen=True, eq=False)
class Bound:
    """A row of what a constraint of the user's own bounds, with its name, 1 (-1: the row takes it from below), and the size it was divided by."""

    name: str
    sign: int
    row: cp.Constraint
    size: Array


@dataclass(frozen=True, eq=False)
class OwnRows:
    """What constraints, and maybe an objective, of the user's own are in a program.

    Attributes
    ----------
    rows
        Their rows and cones.
    variables
        The user's variables, and what they are in the well-scaled program.
    bounds
        Which rows bound what the constraints bound.
    objective_unit
        Unit of the program's objective where that is the user's own, else None.
    """

    rows: Sequence[cp.Constraint] = ()
    variables: Sequence[tuple[cp.Variable, cp.Expression]] = ()
    bounds: Sequence[Bound] = ()
    objective_unit: float | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Their names, each once."""
        return tuple(dict.fromkeys(row.label for row in self.rows))

    @property
    def violation(self) -> float:
        """Their largest violation."""
        return max((float(np.max(row.violation())) for row in self.rows), default=0.0)

    def prices(self, unit: float) -> dict[str, Array]:
        """Rate of the objective, of a `unit`, as each constraint gives way, in the user's units: >= 0; of an equation with its right side."""
        found = dict[str, Array]()
        for bound in self.bounds:
            dual = np.asarray(bound.row.dual_value[0] if isinstance(bound.row, cp.SOC) else bound.row.dual_value)
            found[bound.name] = found.get(bound.name, 0.0) + bound.sign * unit * dual / bound.size.reshape(dual.shape, order="F")
        return found

    def save(self) -> None:
        """Put the values of a solution into the variables of the user."""
        for variable, scaled in self.variables:
            variable.save_value(np.asarray(scaled.value))


def extended(
    problem: cp.Problem, variables: Sequence[cp.Variable], meant: Mapping[cp.Variable, cp.Expression], constraints: Sequence[Any], objective: Any
) -> tuple[cp.Problem, OwnRows]:
    """A problem under constraints, and with an objective to be largest (None for its own), on unknowns of a model.

    These are `meant` as expressions of the problem's own variables, and of `variables` that it may lack.

    Raises
    ------
    ModelError
        What is no cvxpy constraint or expression, not convex, no linear or cone program, or on unknowns of another model.
    """
    goal, known = cp.Variable(name="objective"), {variable.id for variable in (*problem.variables(), *variables)}
    named = {f"constraints[{index}]": constraint for index, constraint in enumerate(constraints)}
    if objective is not None:
        if not isinstance(objective, cp.Expression) or objective.size != 1:
            raise ModelError(f"objective: {shown(objective)}; give a scalar cvxpy expression to be largest, of slip, load_factor, q and p")
        named["objective"] = goal <= cp.reshape(objective, (), order="C")
    own = _own_rows(named, known, {id(variable): expression for variable, expression in meant.items()})
    if objective is None:
        return cp.Problem(problem.objective, [*problem.constraints, *own.rows]), own
    scaled = next(scaled for variable, scaled in own.variables if variable is goal)
    (inner,) = scaled.variables()
    program = cp.Problem(cp.Maximize(inner), [*problem.constraints, *own.rows])
    inner.save_value(np.ones(()))
    return program, replace(own, objective_unit=float(scaled.value), bounds=[bound for bound in own.bounds if bound.row.label != "objective"])


def _own_rows(constraints: Mapping[str, Any], known: set[int], meant: Mapping[int, cp.Expression]) -> OwnRows:
    """Well-scaled rows and cones that say what named constraints say (an equation is two rows), and their variables besides the known ones.

    Constraints of abs, max, norms and the like bring variables and rows of their own; the last rows bound what the constraint itself bounds.

    Raises
    ------
    ModelError
        Not a cvxpy constraint, not convex, no linear or second-order cone program, or on unknowns of another model.
    """
    rows: list[cp.Constraint] = []
    last: list[tuple[int, str, int]] = []
    for name, given in constraints.items():
        constraint = _checked(name, given, meant)
        conic, _ = Dcp2Cone(quad_obj=False).apply(cp.Problem(cp.Minimize(0), [constraint]))
        called = name if any(given.label == other for _, other, _ in last) else given.label or name
        for part in conic.constraints:
            if not isinstance(part, (*_EQUATIONS, _AT_MOST, _AT_LEAST, cp.SOC)):
                raise ModelError(
                    f"{name}: it needs a {type(part).__name__} cone; the multipliers of linear rows and second-order cones prove the answer: "
                    "give linear constraints, or such of abs, max, min and norms of vectors, in space for each node: cp.norm(model.slip, 2, axis=1)"
                )
            cone = isinstance(part, cp.SOC)
            signs = (1, -1) if isinstance(part, _EQUATIONS) else (-1,) if isinstance(part, _AT_LEAST) else (1,)
            rows += [row.set_label(called) for row in ([part] if cone else [sign * part.expr <= 0 for sign in signs])]
        last += [(len(rows) - len(signs) + k, called, sign if len(signs) > 1 else 1) for k, sign in enumerate(signs)]
    scaled, sizes, variables = _scaled(rows, known) if rows else ([], [], [])
    return OwnRows(scaled, variables, [Bound(name, sign, scaled[k], sizes[k]) for k, name, sign in last])


def _scaled(rows: list[cp.Constraint], known: set[int]) -> tuple[list[cp.Constraint], list[Array], list[tuple[cp.Variable, cp.Expression]]]:
    """The rows and cones divided by their size, which spreads from the unknowns of the model to the other variables; with these sizes."""
    problem = cp.Problem(cp.Minimize(0), rows)
    form, columns = StandardForm(problem), compiled(problem)["param_prob"].var_id_to_col
    size, constant = abs(form.matrix.toarray()), np.abs(form.right)
    others = [variable for variable in problem.variables() if variable.id not in known]
    at = {variable.id: slice(columns[variable.id], columns[variable.id] + variable.size) for variable in others}
    unit = np.ones(size.shape[1])
    for place in at.values():
        unit[place] = 0.0  # not known yet
    for _ in others:
        given = (size @ unit)[:, None]  # by its known part a row allows a variable this much, over its coefficient
        with np.errstate(divide="ignore", invalid="ignore"):
            least = np.where((size > 0) & (given > 0), given / size, np.inf).min(axis=0)
        unit = np.where((unit == 0) & np.isfinite(least), least, unit)
    unit = np.where(unit == 0, 1.0, unit)
    sizes = np.linalg.norm(size * unit, axis=1)
    sizes = np.where(sizes > 0, sizes, np.where(constant > 0, constant, 1.0))
    own = {v.id: cp.multiply(unit[at[v.id]].reshape(v.shape, order="F"), cp.Variable(v.shape, name=v.name())) for v in others}
    swap = {id(variable): own[variable.id] for variable in others}
    of = dict(zip(map(id, form.rows), np.split(sizes, np.cumsum([row.size for row in form.rows])[:-1]), strict=True))
    largest = [of[id(row)].reshape(row.num_cones(), -1).max(axis=1) if isinstance(row, cp.SOC) else of[id(row)] for row in rows]
    scaled = [_over(row, part, swap).set_label(row.label) for row, part in zip(rows, largest, strict=True)]
    return scaled, largest, [(variable, own[variable.id]) for variable in others]


def _over(row: cp.Constraint, largest: Array, swap: Mapping[int, cp.Expression]) -> cp.Constraint:
    """A row over its size, a cone over its largest one, with other variables."""
    if not isinstance(row, cp.SOC):
        return row.expr.tree_copy(swap) / largest.reshape(row.shape, order="F") <= 0
    bound, vectors = (part.tree_copy(swap) for part in row.args)
    across = largest if vectors.ndim == 1 else largest[:, None] if row.axis == 1 else largest[None, :]
    return cp.SOC(bound / largest.reshape(bound.shape), vectors / (across if vectors.ndim > 1 else largest[0]), axis=row.axis)


def _checked(name: str, given: Any, meant: Mapping[int, cp.Expression]) -> cp.Constraint:
    """A constraint of the user's own on the variables of a problem."""
    if not isinstance(given, cp.Constraint):
        raise ModelError(f"{name}: {shown(given)}; give a cvxpy constraint on slip, load_factor, q and p of the model, such as model.slip <= 1e-3")
    constraint = given.tree_copy(meant)
    if not constraint.is_dcp(dpp=True):
        raise ModelError(
            f"{name}: not convex (an objective: not concave) by the rules of DCP, or not affine in its parameters (DPP); change it so that it is"
        )
    for variable in constraint.variables():
        if variable.name().startswith(OF_A_MODEL):
            raise ModelError(f"{name}: it is on the {variable.name().removeprefix(OF_A_MODEL)} of another model; use those of the model that solves")
        if any(variable.attributes.values()):
            raise ModelError(f"{name}: variable {variable.name()} has attributes; give a plain one, and its bounds as constraints")
    for parameter in constraint.parameters():
        if parameter.value is None:
            raise ModelError(f"{name}: parameter {parameter.name()} has no value; give it one before solving")
    return constraint
