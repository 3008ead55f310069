"""The nodes that the mean load leaves open, and whether a slip is safe under it."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ...base import COUNTS, RESIDUAL, Array, Booleans
from ...contact import LoadCycle
from ...errors import ModelError, NoContinuation, SolverError
from .question import Question

# A closed node tends to open if its pressure is at most this share of the mean force. An open node
# tends to close if its gap is at most this share of the clearance.
TOUCHES = COUNTS


def open_under_mean(question: Question, friction: Array | None = None) -> list[Booleans]:
    """Masks (N,) of the nodes that the mean load leaves open in a contact without earlier slip.

    The list is empty if no node opens, or if the contact finds no state of rest. If the fixed parts
    of the corners differ, there is a mask for each corner at load factor 0, and one of the nodes
    that all corners leave open. `friction` replaces the friction of the question.
    """
    # Imported here, because a closed contact does not need it.
    from ...transients.march import open_at_rest

    if friction is None:
        friction = question.friction
    loads_at_zero = question.cycle.unscaled if question.fixed else question.cycle.unscaled[:1]
    sets = list[Booleans]()
    for loads in loads_at_zero:
        cycle = LoadCycle(loads, question.cycle.corners)
        with suppress(ModelError, NoContinuation):
            sets.append(open_at_rest(question.system, cycle, friction))
    if sets:
        sets.append(np.logical_and.reduce(sets))
    different = {tuple(opened.tolist()) for opened in sets}
    return [np.array(opened) for opened in sorted(different, reverse=True) if any(opened)]


def is_safe_at_mean_load(question: Question, slip: Array | None) -> bool:
    """Whether one of three likely slips is safe under the mean load alone.

    These slips are zero slip, the given slip if it is not None, and the slip after the mean load is
    applied in one step.
    """
    if question.settles_closed:
        return True
    if slip is not None and question.violation(0.0, slip) <= RESIDUAL:
        return True
    # Imported here, because one of the slips above is usually safe.
    from ...transients.march import mean_state

    try:
        state = mean_state(question.system, question.cycle, question.friction, steps=1)
    except (ModelError, NoContinuation, SolverError):
        return False
    return question.violation(0.0, state.slip) <= RESIDUAL
