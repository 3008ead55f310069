"""Slips that the contact can hold at a load factor, the furthest in given directions (`models.furthest`); free slides of the body take no part."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import cvxpy as cp
import numpy as np

from ..base import Array, SolveRecord, finite_array, finite_number, frozen, warns_of_odd_values
from ..contact import ContactSystem, LoadCycle
from ..solve.solvers import NoOptimum
from . import models
from .models import unknowns
from .programs import listed_rows
from .question import Question, pose


def furthest(
    question: Question, load_factor: float, directions: Iterable[Array]
) -> list[Array | None]:
    """For each direction (t N,) of tractions over their units, the safe slip that goes furthest, length; None without an end, or if none is safe."""
    unit, found = np.tile(question.node_unit, question.system.tangents), list[Array | None]()
    x = unknowns(
        question.system.slip_shape,
        range(len(question.r1)),
        cp.Parameter(nonneg=True, name="load_factor", value=load_factor),
    )
    direction = cp.Parameter(len(unit), name="direction", value=np.zeros(len(unit)))
    program = listed_rows(question, x, cp.Parameter(question.system.nodes, nonneg=True, name="f"))
    program.compiled(models.furthest(x, direction, program.rows), question.force)

    def judged() -> SolveRecord:
        return SolveRecord(residual=question.violation(load_factor, program.slip))

    for along in directions:
        direction.value = along / unit * (question.force / (np.abs(along).max(initial=0.0) or 1.0))
        try:
            program.chain.solve(judged)
            found.append(program.slip)
        except NoOptimum:
            found.append(None)
    return found


@warns_of_odd_values
def safe_vertices(
    system: ContactSystem, cycle: LoadCycle, friction: Any, load_factor: float, directions: Any
) -> Array:
    """Vertices of the safe slips at a load factor: for each direction, the safe slip whose tractions go furthest along it, with all nodes closed.

    Parameters
    ----------
    system, cycle, friction
        See `shakedown_limit`.
    load_factor
        Load factor, >= 0.
    directions
        (D, N), in space (D, N, 2), directions in the space of the nodal tractions over the mean
        pressures. Where the body may slide as a whole, as many components as there are such slides
        carry no traction of their own, and do not count.

    Returns
    -------
    Array
        (d, N) or (d, N, 2) slips, length; d = 0 where no slip is safe. Directions in which the safe
        slips have no end give none.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> system = fo.ContactSystem.from_blocks([[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]], [0, 1], loads)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> fo.starts.safe_vertices(system, cycle, friction=0.5, load_factor=0.3, directions=[[1.0, 0.0], [0.0, 1.0]]).shape
    (2, 2)
    """
    factor, question = (
        finite_number("load_factor", load_factor, least=0.0),
        pose(system, cycle, friction, simplify=False),
    )
    given = finite_array("directions", directions, (None, *system.slip_shape))
    along = np.moveaxis(given.reshape(len(given), system.nodes, system.tangents), 2, 1).reshape(
        len(given), system.nodes * system.tangents
    )
    found = furthest(question, factor, along)
    return frozen(
        np.reshape([slip for slip in found if slip is not None], (-1, *system.slip_shape))
    )
