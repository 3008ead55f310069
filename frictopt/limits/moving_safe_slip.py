"""Safe slips of uncoupled contacts whose areas open and close, at a given load factor.

If slip changes no pressure (B = 0), the load factor decides which nodes open and close, and when,
also if it scales normal loads, and if fixed parts differ between the corners. The nodes that never
open have an ordinary question (`moving_limit.py`).
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from .moving_areas import MovingAreas, areas_at, holds_for_all_openings
from .moving_limit import at_all_instants, checked_at_instants, ordinary_question
from .normal_path import NoPath
from .question import Question


def moving_areas_at(question: Question, load_factor: float) -> MovingAreas | None:
    """The areas at a load factor, if loads alone open and close some nodes; else None.

    A contact without friction at all nodes has the areas that it has with friction.
    """
    asked = question
    if not question.friction.any():
        asked = replace(question, friction=np.ones_like(question.friction))
    if not holds_for_all_openings(asked):
        return None
    try:
        areas = areas_at(question, load_factor)
    except NoPath:
        return None
    return areas if areas.at_instant.touching.any() else None


def safe_with_moving_areas(
    question: Question, load_factor: float, safe_slip_of: Callable[[Question, float], Any]
) -> Any:
    """The `SafeSlip`, if loads alone open and close nodes at the load factor; else None.

    It is also None if no node has friction, and no slip is safe.

    `safe_slip_of` is the safe slip of an ordinary question. SolverError if the states at the
    instants of a safe slip violate the contact law by more than 1e-9.
    """
    areas = moving_areas_at(question, load_factor)
    if areas is None:
        return None
    ordinary, instants = ordinary_question(areas)
    safe = safe_slip_of(ordinary, load_factor)
    if not safe.exists and not question.friction.any():
        # Without friction a state of rest need not stop the slip of nodes that press.
        return None
    motion = at_all_instants(safe._motion, areas, instants)
    record = safe.record
    if safe.exists:
        record = checked_at_instants("safe slip", areas, load_factor, safe.slip, record)
    slip = areas.completed(load_factor, safe.slip)
    return replace(safe, slip=slip, record=record, _question=areas, _motion=motion)
