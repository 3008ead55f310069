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

from ..contact import RESIDUAL, Booleans, LimitKind, SolveRecord
from ..errors import FrictoptError, SolverError
from .answered import Mechanism
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
    Sets whose safe load factors begin above `at` do not count.
    """
    best, tried = closed, {closed.open.tobytes()}

    def counts(limit: ShakedownLimit) -> bool:
        return not (np.isnan(limit.load_factor) or limit.least > at)

    def gains(opened: Booleans) -> bool:
        nonlocal best
        if opened.tobytes() in tried or len(tried) > _MOST:
            return False
        tried.add(opened.tobytes())
        with suppress(FrictoptError):  # one without an answer that passes the checks is none of those known to rest
            reached = best.load_factor if counts(best) else -np.inf
            limit = _limit(task, of_set, opened, reached)
            if limit is not None and counts(limit) and limit.load_factor > reached * (1 + _GAINS):
                best = limit
                return True
        return False

    def climb() -> None:
        while counts(best) and np.isfinite(best.load_factor) and any(gains(opened) for opened in _next_to(best)):
            pass

    climb()
    wants = len(tried) > 1
    if wants or not closed.least <= 0:
        for opened in _settled(task, wants):
            gains(opened)
        climb()
    return best


def _settled(task: Question, wants: bool) -> Iterator[Booleans]:
    """What the mean load leaves open, with the friction and with parts of it: where it opens none, only if a node `wants` to open."""
    for share in _SHARES:
        with suppress(SolverError):  # of the way to the mean load: the search has one set less to begin with
            if (opened := open_under_mean(replace(task, friction=share * task.friction))) is not None:
                yield opened
            elif share == 1.0 and not wants:
                return


def _next_to(best: ShakedownLimit) -> Iterator[Booleans]:
    """Sets next to one, by nodes that are opened or closed.

    Those that rule its limit, all at once and those at its border; the whole border, from outside or inside, as a mechanism may rule on one side
    only; the ruling ones one by one, in space in small groups.
    """
    task, table = best._task, best.mechanism
    shares = table.groupby("node")["share"].sum().sort_values(ascending=False)
    ruling = np.array(shares.index[shares > _RULES * shares.max()], dtype=int)
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


def _limit(task: Question, of_set: Callable[[Question, float], ShakedownLimit], opened: Booleans, above: float) -> ShakedownLimit | None:
    """The limit with given nodes open; None if they leave a body free, or all are open and touch at every load factor."""
    if opened.all():
        return _all_open(task)
    rest = with_open(task, opened)
    return None if rest is None else of_set(rest, above)


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
