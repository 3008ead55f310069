"""Constraints of the user's own in the linear program of the shakedown limit: rows in its unknowns, and proofs that there is no limit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np
from cvxpy.reductions.dcp2cone.dcp2cone import Dcp2Cone

from ..contact.checks import Array, shown
from ..contact.record import Attempt
from ..errors import ModelError
from ..solve.polish import Program, polish, standard_form
from ..solve.solvers import TOLERANCE, solve
from .kinds import LimitKind
from .mechanism import Mechanism
from .posed import LimitQuestion
from .safe_set import SafeProblem
from .scaling import Loads
from .shakedown_result import LimitClaim, own_names

__all__ = ["OwnRows", "Physical", "no_limit_under", "own_rows"]

_EQUATIONS, _AT_MOST, _AT_LEAST = (
    (cp.constraints.Equality, cp.constraints.Zero),
    (cp.constraints.Inequality, cp.constraints.NonPos),
    cp.constraints.NonNeg,
)


class Physical:
    """What a safe-slip program decides on, as affine cvxpy expressions in the user's units.

    Attributes
    ----------
    load_factor, slip, q, p
        Scalar, (N,) length, and (K, N) reactions of the closed contact at the corners, force per depth.
    """

    def __init__(self, safe: SafeProblem, loads: Loads) -> None:
        scaled, v = safe.scaled, safe.symbols
        self.load_factor: cp.Expression = cp.Parameter(nonneg=True, name="load_unit") * safe.problem.var_dict["load_factor"]
        self.slip: cp.Expression = scaled.slip @ v.traction + (0.0 if v.slide is None else scaled.rigid @ v.slide)
        changes = cp.multiply(scaled.unit, scaled.shear @ v.traction), cp.multiply(scaled.unit, scaled.normal @ v.traction)
        self.q, self.p = (
            np.ones((loads.corners, 1)) @ cp.reshape(mean + change, (1, len(mean)), order="C") + cp.Constant(cyclic) * self.load_factor
            for mean, cyclic, change in zip((loads.q0, loads.p0), (loads.q1, loads.p1), changes, strict=True)
        )


@dataclass(frozen=True, eq=False)
class OwnRows:
    """Inequalities that say what constraints of the user's own say, well scaled; their own variables are scaled too."""

    constraints: list[cp.Constraint]
    variables: list[tuple[cp.Variable, cp.Expression]]

    def save(self) -> None:
        """Put the values of a solution into the variables of the user."""
        for variable, scaled in self.variables:
            variable.save_value(np.asarray(scaled.value))


def own_rows(constraints: Sequence[Any], physical: Physical, load_unit: float) -> OwnRows:
    """The rows of linear constraints, an equation as two; those of abs, max, norm1 and the like bring variables of their own.

    Raises
    ------
    ModelError
        Not a cvxpy constraint, not convex, not linear, or on unknowns of another model.
    """
    known = {variable.id for part in (physical.load_factor, physical.slip) for variable in part.variables()}
    (unit,) = physical.load_factor.parameters()
    unit.value = load_unit
    rows: list[cp.Constraint] = []
    for index, constraint in enumerate(constraints):
        name = f"constraints[{index}]"
        _check(name, constraint, known)
        linear, _ = Dcp2Cone(quad_obj=False).apply(cp.Problem(cp.Minimize(0), [constraint]))
        for part in linear.constraints:
            if not isinstance(part, (*_EQUATIONS, _AT_MOST, _AT_LEAST)):
                raise ModelError(
                    f"{name}: it needs a {type(part).__name__} cone; the limit is a linear program, so that its multipliers prove it: "
                    "give linear constraints, or such of abs, max, min, norm1 and norm_inf"
                )
            signs = (1, -1) if isinstance(part, _EQUATIONS) else (-1,) if isinstance(part, _AT_LEAST) else (1,)
            rows += [(sign * part.expr <= 0).set_label(constraint.label or name) for sign in signs]
    return _scaled(rows, known)


def _scaled(rows: list[cp.Constraint], known: set[int]) -> OwnRows:
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
    return OwnRows(scaled, [(variable, own[variable.id]) for variable in others])


def _check(name: str, constraint: Any, known: set[int]) -> None:
    if not isinstance(constraint, cp.Constraint):
        raise ModelError(
            f"{name}: {shown(constraint)}; give a cvxpy constraint on slip, load_factor, q and p of the model, such as model.slip <= 1e-3"
        )
    if not constraint.is_dcp(dpp=True):
        raise ModelError(f"{name}: it is not convex (DCP), or not affine in its parameters (DPP); give a constraint that is")
    for variable in constraint.variables():
        if variable.id not in known and variable.name() in ("load_factor", "traction", "slide"):
            raise ModelError(f"{name}: it is on the {variable.name()} of another model; use the expressions of the model that solves")
        if any(variable.attributes.values()):
            raise ModelError(f"{name}: variable {variable.name()} has attributes; give a plain one, and its bounds as constraints")
    for parameter in constraint.parameters():
        if parameter.value is None:
            raise ModelError(f"{name}: parameter {parameter.name()} has no value; give it one before solving")


def no_limit_under(own: Sequence[cp.Constraint], task: LimitQuestion, problem: cp.Problem, solver: str | None) -> LimitClaim | None:
    """The claim that a program with constraints of the user's own has no finite limit, and which of them rule; None where neither can be proven."""
    names, nothing = own_names(own), np.zeros((task.loads.corners, task.system.nodes))
    excess, unsafe = _least_excess(problem, solver), np.full(task.system.nodes, np.nan)
    still = Mechanism(nothing, nothing, nothing, nothing[0])
    if excess.bound > TOLERANCE:
        parts = np.split(excess.multipliers, np.cumsum([row.size for row in problem.constraints])[:-1])
        ruling = {row.label for row, part in zip(problem.constraints, parts, strict=True) if part.max(initial=0.0) > TOLERANCE}
        why = f"no residual slip that is safe at any load factor obeys {', '.join(n for n in names if n in ruling)}: drop or relax them"
        return LimitClaim(task, LimitKind.NO_SAFE_SLIP, np.nan, unsafe, still, np.nan, excess.residual, why, names)
    growing = _least_excess(problem, solver, growing=True)
    if growing.bound > TOLERANCE or growing.value > TOLERANCE or excess.value > TOLERANCE:
        return None
    why = f"every load factor has a safe residual slip that obeys {', '.join(names)}"
    return LimitClaim(task, LimitKind.UNBOUNDED, np.inf, unsafe, still, np.inf, max(excess.residual, growing.residual), why, names)


@dataclass(frozen=True, eq=False)
class Excess:
    """The least excess by which the rows of a linear program cannot hold.

    Attributes
    ----------
    value, bound
        That of a solution, and the least that the multipliers prove.
    multipliers
        One for each row.
    residual, attempts
        Distance of the two where they do not prove an excess, and the solver runs.
    """

    value: float
    bound: float
    multipliers: Array
    residual: float
    attempts: tuple[Attempt, ...] = ()


@dataclass(frozen=True, eq=False)
class _Relaxed:
    problem: cp.Problem

    def refine(self) -> None:
        polish(self.problem)

    def claim(self) -> Excess:
        program = Program(self.problem)
        value, bound = (-side for side in program.bounds)
        return Excess(value, bound, program.y[:-1], 0.0 if bound > TOLERANCE else abs(value - bound))


def _least_excess(problem: cp.Problem, solver: str | None, *, growing: bool = False) -> Excess:
    """The least `e >= 0` with `matrix @ z + e >= right`, of a linear program in its standard form.

    A bound above 0 proves that the rows contradict each other (Farkas's lemma). For `growing`, the objective has to grow by 1 while no row
    falls: a value of 0 proves that a program that has a solution has no largest one.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    matrix, right, objective = standard_form(problem)
    if growing:
        matrix, right = np.vstack([matrix, objective]), np.append(np.zeros(len(right)), 1.0)
    z, excess = cp.Variable(matrix.shape[1], name="z"), cp.Variable(name="excess")
    model = _Relaxed(cp.Problem(cp.Minimize(excess), [matrix @ z + excess >= right, excess >= 0]))
    return solve(model, model.claim, solver).claim
