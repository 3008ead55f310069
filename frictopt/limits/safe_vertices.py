"""Safe slips that go furthest in given directions.

Free slides of the body as a whole are excluded.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..base import Array, finite_array, finite_number, frozen, warns_of_odd_values
from ..contact import ContactSystem, LoadCycle
from ..solve.answer import answer
from ..solve.solvers import NoOptimum
from . import assembled
from .question import Question, pose
from .solution import Judged, Solution


@warns_of_odd_values
def safe_vertices(
    system: ContactSystem, cycle: LoadCycle, friction: Any, load_factor: float, directions: Any
) -> Array:
    """Vertices of the safe slips at a load factor, with all nodes closed.

    For each direction it is the safe slip whose tractions go furthest along it.

    Parameters
    ----------
    system, cycle, friction
        See `shakedown_limit`.
    load_factor
        Load factor, >= 0.
    directions
        (D, N), in space (D, N, 2), directions in the space of the nodal tractions, each divided by
        the mean pressure of its node. If the body can slide as a whole in m directions, m
        components are not independent, and are ignored.

    Returns
    -------
    Array
        (d, N) or (d, N, 2) slips, length; d = 0 if no slip is safe. Directions in which the safe
        slips are unbounded have no vertex.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> A, B, C = [[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]]
    >>> system = fo.ContactSystem.from_blocks(A, B, C, [0, 1], loads)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> fo.starts.safe_vertices(system, cycle, 0.5, 0.3, [[1.0, 0.0], [0.0, 1.0]]).shape
    (2, 2)
    """
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    question = pose(system, cycle, friction, simplify=False)
    directions = finite_array("directions", directions, (None, *system.slip_shape))
    count = len(directions)
    by_node = directions.reshape(count, system.nodes, system.tangents)
    size = system.tangents * system.nodes
    by_component = np.moveaxis(by_node, 2, 1).reshape(count, size)
    slips = [slip for slip in furthest(question, load_factor, by_component) if slip is not None]
    return frozen(np.reshape(slips, (-1, *system.slip_shape)))


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
