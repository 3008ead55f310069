"""Which nodes stay open in a state of rest: a search near the settled mean load, one program for each set of open nodes.

The largest limit over all sets is no design number: sets far from the settled state obey the law too, and nothing leads there. The search is local.
It starts from what the mean load leaves open, with the friction as it is and with less, and from what corners open: the limit of a given set never
falls as friction grows, so that sets of less friction are good starts. From the best, nodes that rule it are opened or closed as long as that gains.
The answer is a state of rest, judged as every other one; its bound is that of its set.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace

import numpy as np

from ..contact import RESIDUAL, Booleans
from ..errors import FrictoptError, SolverError
from .open_nodes import open_under_mean
from .question import Question, with_open
from .shakedown_result import ShakedownLimit

_SHARES = 1.0, 0.7, 0.5, 0.35, 0.2, 0.1, 0.02  # of the friction, with which the mean load may open other nodes
_RULES = 0.02  # part of the largest motion from which on a node rules
_GAINS = 1e-7  # relative gain that counts
_TOUCHES = 1e3 * RESIDUAL  # pressure, over the mean force, up to which a closed node wants to open
_MOST = 60  # programs
_GROUP, _FEW = 4, 16  # nodes that are flipped at once in space, where more than few of them rule


def best_pattern(task: Question, of_set: Callable[[Question, float], ShakedownLimit], closed: ShakedownLimit, at: float = np.inf) -> ShakedownLimit:
    """The best limit that the search finds; `of_set` asks for the one of a question with given open nodes, which counts above a load factor.

    `closed` is the one with all nodes closed. It is the answer where it is safe from the mean load on, and no node that rules it wants to open.
    Sets whose safe load factors begin above `at`, or only above where those of the best one end, do not count. Under a static load, of one corner, no
    node is opened or closed: sets would follow each other up to where the body slides off.
    """
    best, tried, turns = closed, {closed.open.tobytes()}, len(task.cycle.corners) > 1

    def counts(limit: ShakedownLimit) -> bool:
        return not (np.isnan(limit.load_factor) or limit.least > at)

    def gains(opened: Booleans) -> bool:
        nonlocal best
        if opened.tobytes() in tried or len(tried) > _MOST:
            return False
        tried.add(opened.tobytes())
        with suppress(FrictoptError):  # one without an answer that passes the checks is none of those known to rest
            reached = best.load_factor if counts(best) else -np.inf
            rest = None if opened.all() else with_open(task, opened)  # a contact that is open for ever is none
            limit = None if rest is None else of_set(rest, reached)
            if limit is not None and counts(limit) and limit.load_factor > reached * (1 + _GAINS):
                if counts(best) and limit.least > max(best.load_factor, at if at < np.inf else 0.0) * (1 + _GAINS):  # between them none is safe
                    return False
                best = replace(limit, least=min(best.least, limit.least)) if counts(best) else limit
                return True
        return False

    def climb() -> None:
        while turns and counts(best) and np.isfinite(best.load_factor) and any(gains(opened) for opened in _next_to(best)):
            pass

    climb()
    wants = len(tried) > 1
    if wants or not closed.least <= 0:
        for opened in _settled(task, wants, counts(best)):
            gains(opened)
        climb()
    return best


def _settled(task: Question, wants: bool, safe: bool) -> Iterator[Booleans]:
    """What the mean load leaves open, with the friction and with parts of it: where it opens none, only if a node `wants` to open."""
    for share in _SHARES:
        try:
            opened = open_under_mean(replace(task, friction=share * task.friction))
        except SolverError:  # of the way to the mean load: the search has one set less to begin with
            if share == 1.0 and not safe:  # nothing else is known to rest
                raise
            continue
        yield from opened
        if share == 1.0 and not (opened or wants):
            return


def _next_to(best: ShakedownLimit) -> Iterator[Booleans]:
    """Sets next to one, by nodes that are opened or closed.

    Those that rule its limit, all at once and those at its border; the whole border, from outside or inside, as a mechanism may rule on one side
    only; the ruling ones one by one, in space in small groups.
    """
    task = best._task
    moved = best._motion.parts(task.system).sum(axis=(0, 1))
    ruling = np.argsort(-moved, kind="stable")[: int((moved > _RULES * moved.max()).sum())]
    if not best.open.any():
        pressed = best.reactions[1].min(axis=0) > _TOUCHES * task.force
        ruling = ruling[~pressed[ruling] | (task.r0[:, -1, ruling].max(axis=0) < 0)]
    near = np.roll(best.open, 1) != best.open
    border = near | np.roll(near, -1)
    plane = task.system.tangents == 1
    size = 1 if plane or len(ruling) <= _FEW else _GROUP
    edge, inner = ruling[border[ruling]], ruling[~border[ruling]]
    sides = [np.flatnonzero(border & (best.open == state)) for state in (False, True) if plane]
    groups = [ruling, edge, *sides, *(part[k : k + size] for part in (edge, inner) for k in range(0, len(part), size))]
    for nodes in groups:
        opened = best.open.copy()
        opened[nodes] ^= True
        yield opened
