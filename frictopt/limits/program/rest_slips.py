"""Sets of residual slips under which all changes of a load cycle are the same, and their ends.

`Rests` are the states of rest at a load factor. `SteadyCycles` are steady cycles that differ by a
slip that does not change in time: of an uncoupled contact all, otherwise a family of them (theory,
"The fatigue band").
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...base import Array, Booleans, kept
from ...contact import joined, lengths
from ...solve.answer import answer
from ...solve.rows import EQUATION
from ...solve.solvers import NoOptimum
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
        """The program of the slips; at its last instant the forces are those of the slip alone."""
        question = self.question
        return assembled.stuck(
            assembled.at_corners(question, self.load_factor, units, residual=True)
        )

    def violation(self, slip: Array) -> float:
        """How far a slip (N,) or (N, 2) is from being one of them."""
        return self.question.violation(self.load_factor, slip)


@kept
@dataclass(frozen=True, eq=False)
class SteadyCycles:
    """The slips that make other steady cycles of one steady cycle, if added at all instants."""

    question: Question
    q: Array  # (T, N) or (T, N, 2) shear forces of the steady cycle
    p: Array  # (T, N) normal forces
    moved: Booleans  # (N,) nodes that slip or open: their forces stay as they are

    def program(self, units: Mapping[str, Any]) -> RestProgram:
        """The program of the slips; at its last instant the forces are those of the slip alone."""
        count, n = self.p.shape
        axes = self.question.system.tangents + 1
        forces = np.array([joined(q, p) for q, p in zip(self.q, self.p, strict=True)])
        start = np.vstack([forces, np.zeros(forces.shape[1])])
        program = RestProgram([self.question], units, start, {})
        closed = np.zeros((count + 1, n), dtype=bool)
        closed[:count] = ~self.moved
        assembled.law_rows(program, self.question, closed, np.zeros_like(closed))
        nodes = np.flatnonzero(self.moved)
        last = np.full(len(nodes), count)
        unit = self.question.shear_unit[nodes]
        for axis in range(axes):
            same = [(program.force(last, axis * n + nodes), np.ones(len(nodes)))]
            program.add("same", EQUATION, [same], np.zeros(len(nodes)), unit, last, nodes)
        return program

    def violation(self, slip: Array) -> float:
        """How far a slip (N,) or (N, 2) is from being one of them."""
        question = self.question
        shear, pressure = question.reactions_of_slip(slip)
        p = self.p + pressure
        excess = lengths(self.q + shear, p) - question.friction * p
        changed = np.maximum(lengths(shear, pressure), np.abs(pressure))
        off = np.where(self.moved, changed, excess.max(axis=0))
        return float(off.max()) / question.force


def furthest(slips: Rests | SteadyCycles, directions: Iterable[Array]) -> list[Array | None]:
    """The slip, length, that goes furthest in each direction (t N,), without free slides.

    None stands for a direction without an end, and for all directions if there is no slip.
    """
    program = slips.program({})
    arrays = program.with_cost(np.zeros(program.width))
    unknowns = program.slips[0]

    def checked(x: Array, y: Array) -> Judged:
        slip = Solution(program, x, y[program.slides :], "").slip_of_nodes
        return Judged(slip, slips.violation(slip))

    found = list[Array | None]()
    for direction in directions:
        rates, _ = unknowns.rates_of(direction)
        cost = np.zeros(program.width)
        cost[unknowns.shear] = -rates / (np.abs(rates).max(initial=0.0) or 1.0)
        try:
            claim, _ = answer(replace(arrays, cost=cost), checked)
            found.append(None if claim is None else claim.said)
        except NoOptimum:
            found.append(None)
    return found
