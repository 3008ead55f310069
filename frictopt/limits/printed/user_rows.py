"""Constraints and objectives of the user: their checks, and their rows in a program.

cvxpy compiles only the rows of the user, not the program of the model. The result is slacks in
cones, `right - matrix @ z`, where z are the entries of the variables in these rows. The variables
of a model are linear in the quantities of its program (`rest_program.py`), so they are replaced by
these quantities. All other variables, which are the user's own, become further unknowns of the
program ("own" unknowns).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import cvxpy as cp
import numpy as np
from cvxpy.reductions.dcp2cone.dcp2cone import Dcp2Cone
from scipy.sparse import csr_array, eye_array, hstack, issparse

from ...base import RESIDUAL, Array, Integers, shown
from ...errors import ModelError
from ...solve.arrays import CONE, EQUATION, LINEAR, Rows
from ...solve.by_cvxpy import backend
from ...solve.problem import dual_of, label_of
from ...solve.products import Balance, derived_units
from ..program.rest_program import USER, RestProgram, slip_units
from ..program.solution import Solution, Solved
from .listing import problem_of
from .models import Row, Unknowns

# Attributes of the user's own variables that cvxpy turns into linear rows.
_LINEAR_ATTRIBUTES = {"nonneg", "nonpos", "pos", "neg", "bounds", "symmetric"}

# Names of the unknowns of models, without the number of a corner.
_NAMES = {"slip", "load_factor", "q", "p", "q_r", "p_r", "margin", "preload", "profile"}

_CONES = (
    cp.constraints.Equality,
    cp.constraints.Zero,
    cp.constraints.Inequality,
    cp.constraints.NonPos,
    cp.constraints.NonNeg,
    cp.SOC,
)


def labelled_rows(constraints: Sequence[Any], known: Iterable[cp.Variable]) -> dict[str, Row]:
    """The user's constraints, checked, by name: a unique label, or else `constraints[i]`."""
    known_ids = {variable.id for variable in known}
    places = [f"constraints[{index}]" for index in range(len(constraints))]
    rows = dict[str, Row]()
    for place, row in zip(places, constraints, strict=True):
        if not isinstance(row, cp.Constraint):
            raise ModelError(
                f"{place}: {shown(row)}; give a cvxpy constraint on slip, load_factor, q and p of "
                "the model, such as model.slip <= 1e-3"
            )
        check_rows(place, row, known_ids)
        unique = row.label and row.label not in [*places, *rows]
        rows[row.label if unique else place] = row
    return rows


def check_rows(name: str, row: Row, known_ids: set[int]) -> None:
    """Refuse a constraint that is not made of linear rows and second-order cones.

    With other constraints, multipliers could not prove the answer. Constraints that are not convex,
    or that contain unknowns of another model, are refused, too.
    """
    if not row.is_dcp(dpp=True):
        raise ModelError(
            f"{name}: not convex (an objective: not concave) by the rules of DCP, or not affine in "
            "its parameters (DPP); change it so that it is"
        )
    for variable in row.variables():
        _check_variable(name, variable, known_ids)
    check_values(name, row)
    _check_cones(name, row)


def _check_variable(name: str, variable: cp.Variable, known_ids: set[int]) -> None:
    """Refuse unknowns of another model, integers, and attributes that give no linear rows."""
    part = variable.name().split("[")[0]
    if variable.id not in known_ids and part in _NAMES:
        raise ModelError(
            f"{name}: it contains the {part} of another model; use the variables of this model"
        )
    if variable.attributes["boolean"] or variable.attributes["integer"]:
        raise ModelError(
            f"{name}: variable {variable.name()} is an integer; multipliers cannot prove such an "
            "answer: solve `problem` with it by cvxpy"
        )
    attributes = {kind for kind, value in variable.attributes.items() if value}
    if not attributes <= _LINEAR_ATTRIBUTES:
        refused = ", ".join(sorted(attributes - _LINEAR_ATTRIBUTES))
        raise ModelError(
            f"{name}: variable {variable.name()} is {refused}; give one without this attribute, "
            "and constraints in its place"
        )


def _check_cones(name: str, row: Row) -> None:
    """Refuse cones that are not linear or second-order, or that cvxpy compiles wrongly."""
    problem = cp.Problem(cp.Minimize(0), [row])
    for cone in Dcp2Cone(quad_obj=False).apply(problem)[0].constraints:
        if not isinstance(cone, _CONES):
            raise ModelError(
                f"{name}: it needs a {type(cone).__name__} cone; the multipliers of linear rows "
                "and second-order cones prove the answer: give linear constraints, or constraints "
                "on abs, max, min and norms of vectors, in space for each node: "
                "cp.norm(model.slip, 2, axis=1)"
            )
        # cvxpy fails at axis 2, and mixes up the entries at axis 1.
        if isinstance(cone, cp.SOC) and cone.axis and cone.args[1].ndim > 2:
            raise ModelError(
                f"{name}: it has norms along axis {cone.axis} of {cone.args[1].ndim} axes, which "
                "cvxpy does not compile correctly; give one constraint for each corner k: "
                "cp.norm(model.q[k], 2, axis=1) <= c"
            )


def check_values(name: str, row: Row | cp.Expression) -> None:
    """Refuse parameters without a value, and numbers that are not finite or not real."""
    for leaf in (*row.parameters(), *row.constants()):
        where = f"{name}: a constant"
        if isinstance(leaf, cp.Parameter):
            where = f"{name}: parameter {leaf.name()}"
        if leaf.value is None:
            raise ModelError(f"{where} has no value; give it one before solving")
        numbers = leaf.value.data if issparse(leaf.value) else leaf.value
        if leaf.is_complex() or not np.isfinite(numbers).all():
            raise ModelError(
                f"{where} is not finite or not real; give finite real numbers, and leave out rows "
                "that bound nothing"
            )


def checked_objective(objective: Any, known: Sequence[cp.Variable]) -> cp.Expression:
    """An objective of the user, to be maximized; ModelError for a bad one."""
    if not isinstance(objective, cp.Expression) or objective.size != 1:
        raise ModelError(
            f"objective: {shown(objective)}; give a scalar cvxpy expression of slip, load_factor, "
            "q and p, which is maximized"
        )
    check_rows("objective", cp.Variable() <= objective, {variable.id for variable in known})
    return cp.reshape(objective, (), order="C")


class UserRows:
    """Rows of the user by name, and an objective that is maximized, or None.

    The objective becomes the row `objective <= expression`, where `objective` is the first own
    unknown.

    Parameters
    ----------
    rows, objective
        Checked rows and objective.
    x
        The unknowns of the model.
    named
        Other variables of the model, each with its name in the program.
    open_slip
        Returns (open slips, n) changes of the slips of open nodes per unit of each of the n named
        unknowns. None: these slips do not change.
    """

    def __init__(
        self,
        rows: Mapping[str, Row],
        objective: cp.Expression | None,
        x: Unknowns,
        named: Mapping[cp.Variable, str],
        open_slip: Callable[[RestProgram], Array] | None = None,
    ) -> None:
        self.rows = rows
        self.objective = objective
        self.slip = x.slip
        self.value = cp.Variable(name="objective")
        self._x = x
        self._named = named
        self._open_slip = open_slip
        constraints = [*rows.values()]
        if objective is not None:
            constraints.append(self.value <= objective)
        self._problem = cp.Problem(cp.Minimize(0), constraints)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the rows, and "objective"."""
        return (*self.rows, "objective") if self.objective is not None else tuple(self.rows)

    def add_to(self, program: RestProgram) -> None:
        """Compile the rows with the present values of parameters, and add them to a program.

        The objective, if any, becomes the goal of the program.
        """
        data, self._chain, self._inverse = self._problem.get_problem_data(
            "CLARABEL", enforce_dpp=True, canon_backend=backend(self._problem), solver_opts={}
        )
        _refuse_unread(data)
        program.user = Substituted(self, program, data)
        if self.objective is not None:
            program.goal = "objective"

    def known(
        self, program: RestProgram, columns: Mapping[int, int], count: int
    ) -> tuple[csr_array, Array, Array]:
        """The variables of the model among compiled unknowns, as functions of the quantities.

        `columns`: number of a variable -> its first unknown. Returned are the matrix (count,
        quantities), the constants and the units (count,), which are 0 for all other unknowns.
        """
        question = program.question
        system = question.system
        n, t = system.nodes, system.tangents
        closed = ~question.open_nodes
        is_closed = np.tile(closed, t)
        shear, normal = np.split(np.arange((t + 1) * n), [t * n])
        shear_unit = np.tile(question.shear_unit, t)
        # Each variable, with the quantities that are its entries, in column order.
        entries = [(self.slip, program.first_slip + shear, is_closed, slip_units(question))]
        for k, q in self._x.q.items():
            entries.append((q, program.force(k, shear), is_closed, shear_unit))
            entries.append((self._x.p[k], program.force(k, normal), closed, question.node_unit))
        for variable, name in self._named.items():
            part = program.named[name]
            numbers = program.first_named + np.arange(part.start, part.stop)
            whole = np.ones(len(numbers), dtype=bool)
            entries.append((variable, numbers, whole, program.named_units[part]))

        matrix = csr_array((count, program.first_own))
        constant, unit = np.zeros(count), np.zeros(count)
        for variable, quantities, weights, of_variable in entries:
            if variable.id in columns:
                rows = columns[variable.id] + np.arange(variable.size)
                unit[rows] = of_variable
                places = weights.astype(float), (rows, quantities)
                matrix = matrix + csr_array(places, shape=matrix.shape)
        if question.compliance is not None and self.slip.id in columns:
            # Open nodes have their slips under the mean load.
            opened = np.flatnonzero(~is_closed)
            rows = columns[self.slip.id] + opened
            at_rest = question.slip_at_mean_load(np.zeros(system.slip_shape))
            constant[rows] = at_rest.ravel(order="F")[opened]
            follows = np.zeros((len(opened), program.first_own))
            follows[:, program.first_slip + shear] = question.motions_of_open(opened)
            if self._open_slip is not None:
                follows[:, program.first_named : program.first_slip] = self._open_slip(program)
            matrix = matrix + eye_array(count, format="csr")[:, rows] @ csr_array(follows)
        return matrix, constant, unit

    def listed(self, solved: Solved) -> Solved:
        """A solved program with its printed problem, which has the user's rows and objective.

        If the rows of the user have no part in the proof of an answer, their multipliers are 0.
        """
        solved = replace(solved, unknowns=self._x)
        if "user" in solved.values:
            self.save(solved.values["user"])
        else:
            for row in self.rows.values():
                for dual in row.dual_variables:
                    dual.save_value(np.zeros(dual.shape))
        problem = problem_of(solved, [*self.rows.values()], self.objective)
        count = len(problem.constraints) - len(self.rows)
        taken = {row.label for row in problem.constraints[:count]}
        own = dict[str, Array]()
        for name, row in self.rows.items():
            if row.label in taken:
                raise ModelError(
                    f"constraints: the label {row.label!r} is that of a row of the model; give "
                    "another label"
                )
            dual = dual_of(row)
            if dual is not None:
                # The printed sides of several rows may be equal; then the names differ.
                printed = label_of(row)
                unique = name if printed in taken or printed in own else printed
                own[unique] = np.atleast_1d(np.array(dual, dtype=float))
        return replace(solved, problem=problem, own=own)

    def save(self, values: tuple[Array, Array]) -> None:
        """Put values of the own unknowns, and multipliers, into the rows of the user."""
        z, y = values
        answer = SimpleNamespace(
            x=z,
            z=y,
            status="Solved",
            obj_val=0.0,
            obj_val_dual=0.0,
            solve_time=0.0,
            iterations=0,
        )
        self._problem.unpack_results(answer, self._chain, self._inverse)

    def ruling(self, solution: Solution) -> list[str]:
        """Names of the rows that take part in the contradiction that multipliers prove."""
        self.save(solution.program.user.values(solution))
        sizes = {
            name: max(float(np.abs(dual.value).max(initial=0.0)) for dual in row.dual_variables)
            for name, row in self.rows.items()
        }
        largest = max([*sizes.values(), solution.largest_multiplier])
        return [name for name, size in sizes.items() if size > RESIDUAL * largest]

    def prices(self, solution: Solution) -> dict[str, Array]:
        """Rate of the objective, >= 0, as each of the user's constraints is relaxed; user units.

        For an equation, it is the rate as the right side grows, and may be negative.
        """
        self.save(solution.program.user.values(solution))
        # 0.0 + makes an array without axes a number.
        return {name: 0.0 + np.asarray(dual_of(row)) for name, row in self.rows.items()}


class Substituted:
    """The compiled rows of the user in one program, and their unknowns in its solutions.

    Parameters
    ----------
    of
        The rows.
    program
        The program, to which the rows are added.
    data
        The rows as cvxpy compiles them.
    """

    def __init__(self, of: UserRows, program: RestProgram, data: Mapping[str, Any]) -> None:
        self.of = of
        # Slacks `right - matrix @ unknowns`: equations first, then linear rows, then cones.
        matrix, right = csr_array(data["A"]), np.asarray(data["b"])
        dims = data["dims"]
        sizes = np.array(dims.soc, dtype=int)
        zero, linear = int(dims.zero), int(dims.zero + dims.nonneg)
        columns = data["param_prob"].var_id_to_col
        of_model, self._constant, unit = of.known(program, columns, matrix.shape[1])
        own = np.flatnonzero(unit == 0)
        if of.objective is not None:
            first = columns[of.value.id]
            own = np.r_[first, own[own != first]]

        # The columns of the slip, (rows, t N); zero if no row contains it.
        self._of_slip = csr_array((len(right), of.slip.size))
        if of.slip.id in columns:
            start = columns[of.slip.id]
            self._of_slip = csr_array(matrix[:, start : start + of.slip.size])
        # Both factors of a product get one size, and own unknowns get units from their rows.
        self._balance = Balance(matrix, right, linear + np.cumsum(sizes) - sizes, unit)
        matrix, right = csr_array(self._balance(matrix)), self._balance(right)
        entry_sizes, constants = csr_array(abs(matrix)), np.abs(right)
        unit = derived_units(unit, entry_sizes, lambda unit: entry_sizes @ unit + constants)
        program.own_units = unit[own]

        # The compiled unknowns are `matrix @ quantities + constant`.
        of_user = eye_array(len(unit), format="csr")[:, own]
        self._matrix = csr_array(hstack([of_model, of_user]))
        weights = csr_array(-(matrix @ self._matrix))
        constants = right - matrix @ self._constant
        row_units = np.maximum(entry_sizes @ unit, np.abs(right))
        self._groups = [
            _group(kind, of_kind, weights[part], constants[part], row_units[part])
            for kind, of_kind, part in (
                (EQUATION, np.ones(zero, dtype=int), slice(0, zero)),
                (LINEAR, np.ones(linear - zero, dtype=int), slice(zero, linear)),
                (CONE, sizes, slice(linear, None)),
            )
            if len(of_kind)
        ]
        program.rows += self._groups

    def values(self, solution: Solution) -> tuple[Array, Array]:
        """The values of the compiled unknowns, and the multipliers of the compiled rows."""
        quantities, _ = solution.program.quantities(solution.x)
        z = self._matrix @ quantities + self._constant
        y = np.concatenate([solution.of_rows(rows) for rows in self._groups])
        return z, self._balance(y)

    def completed(self, solved: Solved, solution: Solution) -> Solved:
        """A solved program with what the user's rows may contain: own unknowns, and all slips."""
        z, y = self.values(solution)
        question = solution.program.question
        opened = np.flatnonzero(np.tile(question.open_nodes, question.system.tangents))
        on_slip = -(self._of_slip.T @ y)[opened]
        values = {**solved.values, "slip": solution.slip_of_nodes, "user": (z, y)}
        multipliers = {**solved.multipliers, **dict.fromkeys(("open", "v_r"), on_slip)}
        return replace(solved, values=values, multipliers=multipliers)


def _group(kind: int, sizes: Integers, weights: csr_array, constants: Array, units: Array) -> Rows:
    """The compiled rows of one kind, each row or cone in the unit of its largest term."""
    entries = weights.tocoo()
    starts = np.cumsum(sizes) - sizes
    largest = np.maximum.reduceat(units, starts)
    none = np.full(len(sizes), -1)
    return Rows(
        USER,
        kind,
        sizes,
        entries.row,
        entries.col,
        entries.data,
        constants,
        np.where(largest > 0, largest, 1.0),
        none,
        none,
    )


def _refuse_unread(data: Mapping[str, Any]) -> None:
    """Refuse compiled rows with parts that the arrays do not have."""
    dims = data["dims"]
    bounds = [data.get(f"{side}_bounds") for side in ("lower", "upper")]
    rows = int(dims.zero + dims.nonneg + sum(dims.soc))
    if data.get("P") is not None or any(part is not None for part in bounds):
        raise ModelError(
            "constraints: cvxpy compiles them with a quadratic cost or with bounds of variables; "
            "give them as rows"
        )
    if rows < len(data["b"]):
        raise ModelError(
            "constraints: they need other cones than linear rows and second-order cones; give "
            "constraints on abs, max, min and norms of vectors"
        )
