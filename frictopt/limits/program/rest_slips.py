"""Sets of residual slips that all give the same changes during a cycle, and how far they reach.

`Rests` are the states of rest at a load factor. `SteadyCycles` are steady cycles that differ by a
slip that does not change in time. In an uncoupled contact these are all steady cycles, otherwise a
family of them (theory, "The fatigue band").
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base import RESIDUAL, Array, Booleans, kept
from ...contact import joined, lengths
from ...solve.answer import answer, kind_of
from ...solve.solvers import LP, OPTIMAL, NoOptimum, WarmProgram
from . import assembled
from .question import Question
from .rest_program import RestProgram
from .solution import Judged, Solution


@kept
@dataclass(frozen=True, eq=False)
class Rests:
    """The residual slips of the states of rest at a load factor, with the question's open nodes."""

    question: Question
    load_factor: float

    def program(self, units: Mapping[str, Any]) -> RestProgram:
        """The program of the slips; at its last instant the slip alone causes the forces."""
        question = self.question
        return assembled.stuck(
            assembled.at_corners(question, self.load_factor, units, residual=True)
        )

    def violation(self, slip: Array) -> float:
        """How far a slip (N,) or (N, 2) is from belonging to this set."""
        return self.question.violation(self.load_factor, slip)


@kept
@dataclass(frozen=True, eq=False)
class SteadyCycles:
    """The slips that, added at all instants of a steady cycle, give another steady cycle."""

    question: Question
    q: Array  # (T, N) or (T, N, 2) shear forces of the steady cycle
    p: Array  # (T, N) normal forces
    moved: Booleans  # (N,) nodes that slip or open: the slips leave their forces unchanged

    def program(self, units: Mapping[str, Any]) -> RestProgram:
        """The program of the slips; at its last instant the slip alone causes the forces."""
        count, n = self.p.shape
        axes = self.question.system.tangents + 1
        forces = joined(self.q, self.p)
        start = np.vstack([forces, np.zeros(forces.shape[1])])
        program = RestProgram([self.question], units, start, {})
        closed = np.zeros((count + 1, n), dtype=bool)
        closed[:count] = ~self.moved
        assembled.law_rows(program, self.question, closed, np.zeros_like(closed))
        nodes = np.flatnonzero(self.moved)
        last = np.full(len(nodes), count)
        for axis in range(axes):
            program.no_force("same", axis, last, nodes, self.question.shear_unit)
        return program

    def violation(self, slip: Array) -> float:
        """How far a slip (N,) or (N, 2) is from belonging to this set."""
        question = self.question
        shear, pressure = question.reactions_of_slip(slip)
        p = self.p + pressure
        excess = lengths(self.q + shear, p) - question.friction * p
        changed = np.maximum(lengths(shear, pressure), np.abs(pressure))
        off = np.where(self.moved, changed, excess.max(axis=0))
        return float(off.max()) / question.force


class Furthest:
    """The slips of a set that go furthest in a direction, without slides that nothing resists."""

    def __init__(self, slips: Rests | SteadyCycles) -> None:
        self._slips = slips
        self._program = slips.program({})
        self._arrays = self._program.form.arrays
        self._warm: WarmProgram | None = None
        if kind_of(self._arrays) == LP:
            self._warm = WarmProgram(self._arrays)

    def along(self, direction: Array) -> Array | None:
        """The slip, length, furthest in a direction (t N,); None if the slips have no end there."""
        unknowns = self._program.form.slips[0]
        rates, _ = unknowns.rates_of(direction)
        cost = np.zeros(len(self._arrays.cost))
        cost[unknowns.shear] = -rates / (np.abs(rates).max(initial=0.0) or 1.0)
        if self._warm is not None:
            # In the plane each program starts from the solution of the last one, which has the same
            # rows.
            self._warm.price(cost)
            outcome, *solution = self._warm.solve()
            if outcome == OPTIMAL:
                end = self._checked(*solution)
                if end.residual <= RESIDUAL:
                    return np.asarray(end.said)
        try:
            claim, _ = answer(replace(self._arrays, cost=cost), self._checked)
        except NoOptimum:
            return None
        return np.asarray(claim.said)

    def _checked(self, x: Array, y: Array) -> Judged:
        slip = Solution(self._program, x, y[self._program.form.slides :]).slip_of_nodes
        return Judged(slip, self._slips.violation(slip))
