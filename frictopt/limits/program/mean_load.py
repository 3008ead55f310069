"""The nodes that the mean load leaves open, and the proof that no node opens."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from ...base import COUNTS, RESIDUAL, Array, Booleans
from ...contact import LoadCycle
from ...errors import ModelError, NoContinuation, SolverError
from .assembled import least_pressure
from .question import Question
from .solution import Judged, Solution, solve

# A closed node tends to open if its pressure is at most this share of the mean force. An open node
# tends to close if its gap is at most this share of the clearance.
TOUCHES = COUNTS


def open_under_mean(question: Question, friction: Array | None = None) -> list[Booleans]:
    """Masks (N,) of the nodes that the mean load, applied without slip before, leaves open.

    The list is empty if no node opens, or if the contact finds no state of rest. If fixed parts
    differ, there is a mask for each corner at load factor 0, and one of the nodes that all corners
    leave open. `friction` replaces the friction of the question.
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
    """Whether a likely slip is safe under the mean load alone.

    Likely are zero, the slip given, and the slip after the mean load is applied in one step.
    """
    no_slip = np.zeros(question.system.slip_shape)
    for likely in (no_slip, slip):
        if likely is not None and question.violation(0.0, likely) <= RESIDUAL:
            return True
    # Imported here, because one of the slips above is usually safe.
    from ...transients.march import mean_state

    try:
        state = mean_state(question.system, question.cycle, question.friction, steps=1)
    except (ModelError, NoContinuation, SolverError):
        return False
    return question.violation(0.0, state.slip) <= RESIDUAL


def stays_closed(question: Question, load_factor: float) -> bool:
    """Whether all nodes stay pressed under any slip that friction can hold, proven for each node.

    See `ShakedownLimit.stays_closed`. One convex program for each node minimizes its normal force
    over all slips and loads. The loads are `r0 + sum of shares[k] r1_k`: the shares are >= 0, and
    their sum is at most the load factor. Nodes with little pressure come first, because they decide
    most often.
    """
    for node in np.argsort(question.r0[:, -1].min(axis=0)).tolist():
        program = least_pressure(question, node, load_factor)
        try:
            proven, _ = solve(program, "pressure", -1.0, _least_pressure)
        except SolverError:
            return False
        if not proven.said > RESIDUAL * question.force:
            return False
    return True


def _least_pressure(solution: Solution) -> Judged:
    """The proven lower bound of a normal force."""
    bound, defect = solution.bound
    return Judged(bound - defect, solution.gap)
