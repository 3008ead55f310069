"""The limit of a contact with a given set of open nodes: that of its closed nodes, see `open_nodes`, or where all are open of their gaps alone."""

from dataclasses import replace

import numpy as np

from ..contact.answers import LimitKind
from ..contact.checks import Booleans
from ..contact.parts import joined, parted
from ..contact.record import SolveRecord
from ..contact.tolerances import RESIDUAL
from ..errors import SolverError
from .mechanism import Mechanism
from .open_nodes import compliance, rest_of
from .question import LimitQuestion
from .shakedown import ShakedownModel
from .shakedown_result import ShakedownLimit


def open_set_limit(model: ShakedownModel, task: LimitQuestion, opened: Booleans) -> ShakedownLimit | None:
    """The limit with the nodes `opened` (N,) open and the others closed; None if no load factor has such a state, or it leaves a body free.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    if opened.all():
        return _all_open(task)
    rest = rest_of(task, opened) if opened.any() else task
    limit = None if rest is None else model.of_set(rest)
    return None if limit is None or np.isnan(limit.load_factor) else limit


def _all_open(task: LimitQuestion) -> ShakedownLimit | None:
    """The load factors at which all nodes are open: where no gap closes at any corner."""
    n, axes, still = task.system.nodes, task.system.tangents + 1, np.zeros(task.system.slip_shape)
    give = compliance(task.system, np.ones(n, dtype=bool))
    if give is None:
        return None
    opened = replace(task, closed=np.zeros(n, dtype=bool), give=give)
    slips, gap, _, _ = opened.states(0.0, still)
    rates = (-joined(task.q1, task.p1) @ give)[:, -n:]
    rate = rates if task.fixed else np.broadcast_to(rates.min(axis=0), rates.shape)
    least = float(np.divide(-gap, rate, out=np.where(gap < 0, np.inf, 0.0), where=rate > 0).max(initial=0.0))
    touching = np.divide(gap, -rates, out=np.full(gap.shape, np.inf), where=rates < 0)
    load_factor = float(touching.min())
    if not (least <= load_factor and np.isfinite(least)):
        return None
    finite = np.isfinite(load_factor)
    if not (residual := opened.violation(load_factor if finite else least, still)) <= RESIDUAL:
        raise SolverError(f"open set: the states at the limit violate the contact law by {residual:.1e} (tolerance {RESIDUAL:g})")
    press, touch = np.zeros_like(task.p1), np.unravel_index(int(touching.argmin()), touching.shape)
    press[touch] = -1 / rates[touch] if finite else 0.0
    motion = Mechanism(*parted(-press @ give[-n:], axes), np.zeros(n), open=~opened.closed)
    kind, slip = (LimitKind.FINITE, slips[0]) if finite else (LimitKind.UNBOUNDED, np.full_like(still, np.nan))
    return ShakedownLimit(load_factor, kind, slip, load_factor, SolveRecord(residual=residual), opened, motion, least)
