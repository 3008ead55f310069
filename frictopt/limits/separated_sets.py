"""The open nodes with the largest limit: that of given ones, and the search, from what the mean load opens, by the nodes that rule.

The limit of a contact with a given set of open nodes is that of its closed nodes, see `open_nodes`, or where all are open of their gaps alone.
"""

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from ..contact import RESIDUAL, Booleans, LimitKind, SolveRecord
from ..errors import FrictoptError, SolverError
from .answered import Mechanism
from .open_nodes import open_under_mean
from .question import Question, with_open
from .shakedown import ShakedownModel
from .shakedown_result import ShakedownLimit

_RULING = 6  # nodes with the largest shares of the mechanism that are moved one by one
_FURTHER = 16  # sets without a limit from which others are tried


def best_open_set(task: Question, most_sets: int) -> ShakedownLimit | None:
    """The largest limit of the sets of open nodes that are tried, at most so many; None if no load factor keeps one of them.

    The first one is that of `shakedown_limit`. From the best set so far those next to it are tried, see `_moved`, as long as one is better; from sets
    without a limit others further off.
    """
    model, tried = ShakedownModel(task.system, task.cycle), set[bytes]()
    first = model.solve(task.friction)
    best, waiting = None if np.isnan(first.load_factor) else first, [first.open]
    with suppress(SolverError):  # without it the search has one set less to begin with
        settled = None if first.open.any() else open_under_mean(task)  # else it is that of the first one
        waiting += [] if settled is None else [settled]
    others = waiting if best is None else waiting[1:]
    for _ in range(_FURTHER if best is None else most_sets):
        found = best
        for other in others[: most_sets - len(tried)]:
            tried.add(other.tobytes())
            with suppress(FrictoptError):  # one without an answer that passes the checks is none of those known to rest
                least = -np.inf if best is None else best.load_factor
                limit = open_set_limit(model, task, other, least)
                best = limit if limit is not None and limit.load_factor > least else best
        if best is None:
            waiting = waiting + others
        elif best is not found:
            waiting = [best.open]
        if not waiting or len(tried) >= most_sets or (best is not None and best.load_factor == np.inf):
            break
        opened = waiting.pop(0)
        ruling = best.mechanism["node"].unique().tolist() if best is not None and (best.open == opened).all() else []
        moved = {other.tobytes(): other for other in _moved(opened, ruling, task.system.tangents == 1)}
        others = [other for name, other in moved.items() if name not in tried]
    return best


def _moved(opened: Booleans, active: list[int], plane: bool) -> Iterator[Booleans]:
    """Sets next to one: the nodes that rule its limit opened or closed, one by one and all at once; in the plane also its borders one node further.

    In the plane neighbours follow each other, and the image of a node moves with it, for symmetric contacts, and without it.
    """
    runs = [[node] for node in active[:_RULING]] + [[node for node in active if opened[node] == state] for state in (True, False)]
    if plane:
        edges = np.flatnonzero(np.diff(opened.astype(int)))
        runs += [[node] for node in sorted({*edges.tolist(), *(edges + 1).tolist()})]
    for run in filter(None, runs):
        for moved in [[*run, *(len(opened) - 1 - node for node in run)], run] if plane else [run]:
            other = opened.copy()
            other[moved] = ~opened[run[0]]
            yield other


def open_set_limit(model: ShakedownModel, task: Question, opened: Booleans, above: float = -np.inf) -> ShakedownLimit | None:
    """The limit with the nodes `opened` (N,) open and the others closed; None if no load factor has such a state, or it leaves a body free.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks, or the limit is proven not to be `above` a load factor.
    """
    if opened.all():
        return _all_open(task)
    rest = with_open(task, opened)
    limit = None if rest is None else model.of_set(rest, above=above)
    return None if limit is None or np.isnan(limit.load_factor) else limit


def _all_open(task: Question) -> ShakedownLimit | None:
    """The load factors at which all nodes are open: where no gap closes at any corner."""
    n, (corners, axes, _), still = task.system.nodes, task.r1.shape, np.zeros(task.system.slip_shape)
    opened = with_open(task, np.ones(n, dtype=bool))
    if opened is None or opened.give is None:
        return None
    give, u = opened.give, opened.states(0.0, still)[0]
    gap, rates = np.broadcast_arrays(*opened.w)
    rate = rates if task.fixed else np.broadcast_to(rates.min(axis=0), rates.shape)
    least = float(np.divide(-gap, rate, out=np.where(gap < 0, np.inf, 0.0), where=rate > 0).max(initial=0.0))
    touching = np.divide(gap, -rates, out=np.full(gap.shape, np.inf), where=rates < 0)
    load_factor = float(touching.min())
    if not (least <= load_factor and np.isfinite(least)):
        return None
    finite = np.isfinite(load_factor)
    if not (residual := opened.violation(load_factor if finite else least, still)) <= RESIDUAL:
        raise SolverError(f"open set: the states at the limit violate the contact law by {residual:.1e} (tolerance {RESIDUAL:g})")
    press, touch = np.zeros((corners, n)), np.unravel_index(int(touching.argmin()), touching.shape)
    press[touch] = -1 / rates[touch] if finite else 0.0
    motion = Mechanism((-press @ give[-n:]).reshape(corners, axes, n), np.zeros(n), open=opened.open)
    kind, slip = (LimitKind.FINITE, u[0, :-1].T.reshape(still.shape)) if finite else (LimitKind.UNBOUNDED, np.full_like(still, np.nan))
    return ShakedownLimit(load_factor, slip, SolveRecord(residual=residual), opened, motion, kind, load_factor, least)
