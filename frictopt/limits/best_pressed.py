"""The slip with the largest least pressure, or the proof that no slip presses all nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np

from ..base import RESIDUAL, SolveRecord
from ..contact import ContactSystem, LoadCycle
from .answered import Mechanism
from .models import most_pressed, unknowns
from .programs import listed_rows
from .question import pose


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
    least = cp.Variable(name="least")
    factor = cp.Parameter(nonneg=True, name="load_factor", value=load_factor)
    x = unknowns(system.slip_shape, range(len(cycle.corners)), factor)
    f = cp.Parameter(system.nodes, nonneg=True, name="f")
    program = listed_rows(question, x, f, friction=lambda x, corners: [])
    problem = most_pressed(x, least, question.force, program.corners, program.rows)
    program.compiled(problem, 1.0)

    def checked() -> Pressing:
        slip = program.slip
        proof = program.chain.proof
        _, r = question.states(load_factor, slip)
        reached = float(min(r[:, -1].min() / question.force, 1.0))
        gap = abs(proof.bound - reached) + proof.defect
        residual = max(gap, question.excess_over_slip_bound(slip))
        return Pressing(reached, program.motion, float(np.nan_to_num(residual, nan=np.inf)))

    return program.chain.solve(checked)
