"""Why a program has no solution, or no largest one: by one more program, whose multipliers prove it."""

from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..contact import RESIDUAL, Array
from .solvers import solve
from .standard_form import StandardForm


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


def _least_excess(form: StandardForm, right: Array, objective: Array | None, solver: str | None) -> Contradiction:
    """The least excess of slacks `right - matrix @ z`, and of `objective @ z >= 1` where there is an objective."""
    z, excess = cp.Variable(form.matrix.shape[1], name="z"), cp.Variable(name="excess")
    s, names = right - form.matrix @ z, np.array([row.label for row in form.rows for _ in range(row.size)])
    rows, extra = [excess >= 0], [] if objective is None else [objective @ z + excess >= 1]
    rows += [s[: form.zero] == 0] if form.zero else []
    for cone in form.cones:
        bound, across = s[cone[:, 0]] + excess, cone[:, 1:]
        rows += [cp.SOC(bound, cp.reshape(s[across.ravel()], across.shape, order="C"), axis=1) if across.size else bound >= 0]
    linear, cones = ([i for cone in form.cones if (cone.shape[1] > 1) is wide for i in cone.ravel()] for wide in (False, True))
    labels = [*names[: form.zero], "", *names[linear], *([""] * len(extra)), *names[cones]]
    problem = cp.Problem(cp.Minimize(excess), [*rows, *extra])

    def claim() -> Contradiction:
        relaxed = StandardForm(problem)
        value, bound = (-side for side in relaxed.bounds)
        ruling = frozenset(label for label, y in zip(labels, relaxed.y, strict=True) if y > RESIDUAL)
        return Contradiction(value, bound, ruling, 0.0 if bound > RESIDUAL else abs(value - bound), z.value)

    return solve(problem, claim, solver)[0]
