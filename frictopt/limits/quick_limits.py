"""Limits of sets of open nodes, without proof: plain programs for the search.

The search compares many sets, and only the best one becomes an answer, which is solved and proven
as every limit is. The programs in between need no listing, no compilation and no proof. Their rows
are those of `rest` and `stuck` in `models.py`. In the plane they are linear programs over the load
factor and the slips of the closed nodes; for space see `quick_space.py`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..base import RESIDUAL, Array, Integers, LimitKind, SolveRecord
from ..contact import contact_law
from ..errors import SolverError
from ..solve.solvers import CUT_OFF, INFEASIBLE, NONE, OPTIMAL, WarmProgram
from .answered import Mechanism
from .programs import listed_corners
from .question import Question
from .quick_bound import is_at_most
from .quick_space import ConeProgram
from .shakedown_answer import ShakedownAnswer


@dataclass(frozen=True)
class QuickSettings:
    """Numbers of the quick limits."""

    # Largest violation of the contact law by the slip of a quick limit. If it is larger, the set is
    # solved as an answer is.
    violation: float = 1e-7
    # Largest difference of a quick limit from the proven one, in units of the load.
    differs: float = 1e-6
    # Load factors up to this number, in units of the load, are errors of the solver.
    zero: float = 1e-8
    # With less friction the rows `|q| <= f p` imply `p >= 0` only to a few digits.
    low_friction: float = 0.01


QUICK = QuickSettings()


@dataclass(frozen=True, eq=False, repr=False)
class QuickLimit(ShakedownAnswer):
    """A limit for the search alone: its bound is not known, and nothing is proven."""


class _Bound(NamedTuple):
    """Rows `shear * q + press * p <= constant` of some closed nodes, at each corner."""

    nodes: Integers
    shear: float
    press: Array
    constant: Array


def quick_limit(question: Question, above: float = -np.inf) -> QuickLimit:
    """The limit of a question; NaN if no slip is safe at any load factor.

    It may also be NaN if it is proven to be at most `above`.

    SolverError if the program has no finite optimum, or if its slip is not safe.
    """
    if is_at_most(question, above):
        return _none_safe(question)
    program: _QuickProgram | ConeProgram
    if question.system.tangents == 1:
        program = _QuickProgram(question)
    else:
        program = ConeProgram(question, QUICK.low_friction)
    outcome, x, y = program.solve(program.cost, above / question.load_unit)
    if outcome in (INFEASIBLE, NONE, CUT_OFF):
        return _none_safe(question)
    _check(outcome)
    load_factor, slip = program.state(x)
    load_factor = _without_error(load_factor, question)
    violation = question.violation(load_factor, slip)
    if not violation <= QUICK.violation:
        raise SolverError(f"quick limit: its slip violates the contact law by {violation:.1e}")
    least = 0.0
    if question.violation(0.0, slip) > RESIDUAL:
        outcome, lowest, _ = program.solve(-program.cost)
        _check(outcome)
        least, _ = program.state(lowest)
        least = _without_error(least, question)
    return QuickLimit(
        load_factor,
        slip,
        SolveRecord(residual=violation),
        question,
        program.motion(y),
        LimitKind.FINITE,
        bound=np.inf,
        least=least,
    )


def _without_error(load_factor: float, question: Question) -> float:
    """A load factor, 0 if it may be the error of the solver."""
    return load_factor if load_factor > QUICK.zero * question.load_unit else 0.0


def _check(outcome: str) -> None:
    if outcome != OPTIMAL:
        raise SolverError(f"quick limit: HiGHS ends with the status {outcome}")


def _none_safe(question: Question) -> QuickLimit:
    return QuickLimit(
        np.nan,
        np.full(question.system.slip_shape, np.nan),
        SolveRecord(residual=np.inf),
        question,
        Mechanism(np.zeros_like(question.r1), question.friction),
        LimitKind.NO_SAFE_SLIP,
        bound=np.nan,
    )


class _QuickProgram:
    """The linear program of a set of open nodes in the plane, in units.

    Its unknowns are the load factor and the slips.
    """

    def __init__(self, question: Question) -> None:
        self._question = question
        self._closed = np.flatnonzero(~question.open_nodes)
        self._corners = np.array(listed_corners(question))
        slip_unit = question.shear_unit / question.system.own_stiffness[: question.system.nodes]
        self._units = np.r_[question.load_unit, slip_unit[self._closed]]
        self._bounds = list(_bounds(question, self._closed))
        parts = [self._friction_rows(bound) for bound in self._bounds]
        if len(question.W):
            parts.append(self._gap_rows())
        # The corner and the unit of each row.
        self._row_corners = np.concatenate([corners for corners, _, _, _ in parts])
        self._row_units = np.concatenate([unit for _, _, _, unit in parts])
        matrix = np.vstack([rows for _, rows, _, _ in parts]) * self._units
        right = np.concatenate([right for _, _, right, _ in parts])
        self.cost = -np.eye(1, len(self._units))[0]
        most = np.full(len(self._units), np.inf)
        if question.slip_bound is not None:
            most[1:] = question.slip_bound[self._closed] / self._units[1:]
        self._simplex = WarmProgram(
            matrix / self._row_units[:, None],
            np.full(len(right), -np.inf),
            right / self._row_units,
            self.cost,
            np.r_[0.0, -most[1:]],
            most,
            primal=True,
        )

    def _friction_rows(self, bound: _Bound) -> tuple[Integers, Array, Array, Array]:
        """Corners, rows, right sides and units of the rows of a friction bound."""
        question = self._question
        nodes = bound.nodes
        rates = bound.shear * question.q1[:, nodes] + bound.press * question.p1[:, nodes]
        starts = bound.shear * question.q0[:, nodes] + bound.press * question.p0[:, nodes]
        on_slip = np.ix_(nodes, self._closed)
        slopes = bound.shear * question.A[on_slip] + bound.press[:, None] * question.B[on_slip]
        rights = bound.constant - starts
        return self._strictest(rates, slopes, rights, question.node_unit[nodes])

    def _gap_rows(self) -> tuple[Integers, Array, Array, Array]:
        """Corners, rows, right sides and units of the rows of the gaps of open nodes."""
        question = self._question
        slopes = -question.W[:, self._closed]
        unit = np.full(len(slopes), question.clearance)
        return self._strictest(-question.w1, slopes, question.w0, unit)

    def _strictest(
        self, rates: Array, slopes: Array, rights: Array, unit: Array
    ) -> tuple[Integers, Array, Array, Array]:
        """The rows `load_factor * rate + slopes @ slip <= right` that imply those of all corners.

        The slip enters all corners alike. If the right sides are the same, too, the largest rate is
        the strictest row of each node, as the load factor is >= 0.
        """
        rates = rates[self._corners]
        count = len(unit)
        if len(rights) == 1:
            chosen = rates.argmax(axis=0)
            rate = rates[chosen, np.arange(count)]
            return self._corners[chosen], np.column_stack([rate, slopes]), rights[0], unit
        repeated = np.tile(slopes, (len(rates), 1))
        return (
            np.repeat(self._corners, count),
            np.column_stack([rates.ravel(), repeated]),
            rights[self._corners].ravel(),
            np.tile(unit, len(rates)),
        )

    def solve(self, cost: Array, above: float = -np.inf) -> tuple[str, Array, Array]:
        """Status, x and multipliers; the simplex method does not stop at bounds `above`."""
        if cost is not self.cost:
            self._simplex.minimize(cost)
        return self._simplex.solve()

    def state(self, x: Array) -> tuple[float, Array]:
        """The load factor and the slip of a solution."""
        question = self._question
        values = x * self._units
        slip = np.zeros(question.system.nodes)
        slip[self._closed] = values[1:]
        return max(float(values[0]), 0.0), question.slip_at_mean_load(slip)

    def motion(self, y: Array) -> Mechanism:
        """The mechanism of the multipliers, see `Program.motion`."""
        question = self._question
        moves = np.zeros(question.r1.shape)  # (K, 2, N)
        multipliers = self._units[0] * np.maximum(y, 0.0) / self._row_units
        end = 0
        for bound in self._bounds:
            count = len(bound.nodes) * (len(self._corners) if question.fixed else 1)
            rows = slice(end, end + count)
            end += count
            corners = self._row_corners[rows]
            nodes = np.tile(bound.nodes, count // len(bound.nodes))
            press = np.tile(bound.press, count // len(bound.nodes))
            np.add.at(moves[:, 0], (corners, nodes), -bound.shear * multipliers[rows])
            np.add.at(moves[:, 1], (corners, nodes), -press * multipliers[rows])
        press_of_open = np.zeros((len(moves), moves[0].size))
        if end < len(y):
            opened = np.flatnonzero(question.open_nodes)
            places = np.tile(opened, (len(y) - end) // len(opened)) + question.system.nodes
            np.add.at(press_of_open, (self._row_corners[end:], places), multipliers[end:])
        return Mechanism.of(question, moves, press_of_open)


def _bounds(question: Question, closed: Integers) -> Iterator[_Bound]:
    """The rows of the contact law of the closed nodes."""
    for term in contact_law(question.system, question.friction).terms:
        nodes = closed[np.isin(closed, term.nodes)]
        for sign in (1.0, -1.0):
            yield _Bound(nodes, sign, -term.slope[nodes], term.constant[nodes])
    nodes = closed[question.friction[closed] < QUICK.low_friction]
    if len(nodes):
        yield _Bound(nodes, 0.0, -np.ones(len(nodes)), np.zeros(len(nodes)))
