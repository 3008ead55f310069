"""The search for the open nodes with the largest limit: from what the mean load opens, by the nodes that rule."""

from collections.abc import Iterator

import numpy as np

from ..contact.checks import Booleans
from ..errors import FrictoptError, SolverError
from .open_nodes import open_under_mean
from .open_sets import open_set_limit
from .question import LimitQuestion
from .shakedown import ShakedownModel
from .shakedown_result import ShakedownLimit

_RULING = 6  # nodes with the largest shares of the mechanism that are moved one by one
_FURTHER = 16  # sets without a limit from which others are tried


def best_open_set(task: LimitQuestion, most_sets: int) -> ShakedownLimit | None:
    """The largest limit of the sets of open nodes that are tried, at most so many; None if no load factor keeps one of them.

    The first one is that of `shakedown_limit`. From the best set so far those next to it are tried, see `_moved`, as long as one is better; from sets
    without a limit others further off.
    """
    model, tried = ShakedownModel(task.system, task.cycle), set[bytes]()
    first = model.solve(task.friction)
    try:
        settled = None if first.open.any() else open_under_mean(task)  # else it is that of the first one
    except SolverError:  # the search has one set less to begin with
        settled = None
    best = None if np.isnan(first.load_factor) else first
    waiting = [first.open, *([] if settled is None else [settled])]
    others = [opened for opened in waiting if best is None or (best.open != opened).any()]
    for _ in range(most_sets if best is not None else _FURTHER):
        found = best
        for other in others:
            if len(tried) < most_sets and other.tobytes() not in tried and (best is None or best.load_factor < np.inf):
                best = _better(best, model, task, other)
                tried.add(other.tobytes())
        if best is not found and best is not None:
            waiting = [best.open]
        elif best is None:
            waiting += others
        if not waiting or len(tried) >= most_sets:
            break
        opened = waiting.pop(0)
        ruling = best.mechanism["node"].unique().tolist() if best is not None and (best.open == opened).all() else []
        others = [other for other in _moved(opened, ruling, task.system.tangents == 1) if other.tobytes() not in tried]
    return best


def _better(best: ShakedownLimit | None, model: ShakedownModel, task: LimitQuestion, opened: Booleans) -> ShakedownLimit | None:
    """The limit of a set if it is larger; one without an answer that passes the checks is none of those known to rest."""
    try:
        limit = open_set_limit(model, task, opened)
    except FrictoptError:
        return best
    return limit if limit is not None and (best is None or limit.load_factor > best.load_factor) else best


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
