"""The slip with the largest least pressure, or the proof that no slip presses all nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..base import RESIDUAL, SolveRecord, worst
from ..contact import ContactSystem, LoadCycle
from .assembled import most_pressed
from .mechanism import Mechanism
from .question import pose
from .solution import Solution, solve


@dataclass(frozen=True)
class Pressing:
    """The least normal reaction under the best slip, with its proof.

    `least` is divided by the mean normal force, and at most 1. If it is negative, `motion` is the
    proof: a mechanism that opens nodes. `residual` is the error of both.
    """

    least: float
    motion: Mechanism
    residual: float

    @property
    def impossible(self) -> bool:
        """Whether no slip presses every node at every corner."""
        # A tension within the error of an answer is no proof.
        return self.least < -RESIDUAL


def best_pressed(
    system: ContactSystem, cycle: LoadCycle, load_factor: float, slip_bound: Any
) -> tuple[Pressing, SolveRecord]:
    """The largest least normal reaction over nodes and corners that a residual slip can give."""
    question = pose(system, cycle, 0.0, slip_bound=slip_bound)

    def claimed(solution: Solution) -> Pressing:
        slip = solution.slip_of_nodes
        bound, defect = solution.bound
        _, r = question.states(load_factor, slip)
        reached = float(min(r[:, -1].min() / question.force, 1.0))
        gap = abs(bound - reached) + defect
        residual = worst([gap, question.excess_over_slip_bound(slip)])
        return Pressing(reached, solution.motion, residual)

    pressing, record = solve(most_pressed(question, load_factor), "least", 1.0, claimed)
    assert pressing is not None
    return pressing, record
