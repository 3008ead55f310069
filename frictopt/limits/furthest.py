"""Safe slips that go furthest in given directions.

Free slides of the body as a whole are excluded.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..base import Array
from ..solve.answer import answer
from ..solve.solvers import NoOptimum
from . import assembled
from .question import Question
from .solution import Judged, Solution


def furthest(
    question: Question, load_factor: float, directions: Iterable[Array]
) -> list[Array | None]:
    """The safe slip, length, that goes furthest in each direction.

    Directions (t N,) are directions of tractions divided by their units. None stands for a
    direction without an end, and for all directions if no slip is safe.
    """
    program = assembled.furthest(question, load_factor)

    def checked(x: Array, y: Array) -> Judged:
        slip = Solution(program, x, y[program.slides :], "").slip_of_nodes
        return Judged(slip, question.violation(load_factor, slip))

    unit = np.tile(question.shear_unit / question.node_unit, question.system.tangents)
    slips: list[Array | None] = []
    for along in directions:
        largest = np.abs(along).max(initial=0.0) or 1.0
        cost = np.zeros(program.width)
        slip = program.slips[0]
        cost[slip.shear] = -(unit * along / largest)[slip.elastic.slips]
        try:
            found, _ = answer(program.with_cost(cost), checked)
            slips.append(None if found is None else found.said)
        except NoOptimum:
            slips.append(None)
    return slips
