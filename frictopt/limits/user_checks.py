"""Checks of the constraints and objectives of the user."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import cvxpy as cp
import numpy as np
from cvxpy.reductions.dcp2cone.dcp2cone import Dcp2Cone
from scipy.sparse import issparse

from ..base import shown
from ..errors import ModelError
from .models import Row

# Attributes of the user's own variables that cvxpy turns into linear rows.
_LINEAR_ATTRIBUTES = {"nonneg", "nonpos", "pos", "neg", "bounds", "symmetric"}

# Names of unknowns of models, before the number of the corner.
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
    """The user's constraints, checked, named by their labels if unique, else `constraints[i]`."""
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
    """Refuse a constraint that multipliers of linear rows and second-order cones do not prove.

    It also refuses constraints that are not convex, or on unknowns of another model.
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
    """Refuse unknowns of another model, integers, and attributes that are no linear rows."""
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
