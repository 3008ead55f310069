"""Which nodes stay open in a state of rest, or open and close in each cycle: a search near the settled mean load (theory, "Contacts that open").

The largest limit over all sets is no design number: sets far from the settled state obey the law
too, and nothing leads there. The limit of a given set never falls as friction grows, so sets of
less friction are good starts; one of more friction is a start from the other side. A new order has
what it came from as its limiting case, so that the load factors in between are safe too. The answer
is judged as every other state of rest; its bound is that of its set.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, suppress
from dataclasses import replace
from functools import cache
from typing import Any, TypeAlias

import numpy as np

from ..base import Bar, Booleans, bar_of, flag
from ..errors import FrictoptError, ModelError, SolverError
from ..transients.statics import Statics
from .lift_off import LiftOff, Nodes, Order, among, with_order
from .open_nodes import TOUCHES, open_under_mean
from .question import Question, with_open

Limit: TypeAlias = Any  # a ShakedownLimit: its file asks this one for the open nodes

_SHARES = (
    1.0,
    1.5,
    0.7,
    0.5,
    0.35,
    0.2,
    0.1,
    0.02,
)  # of the friction, with which the mean load may open other nodes
_GOVERNS = 0.02  # part of the largest motion from which on a node governs
_GAINS = 1e-7  # relative gain that counts
_MOST = 60  # programs
_GROUP, _FEW = 4, 16  # nodes that are flipped at once in space, where more than few of them rule
# programs, times their slips, in which the order of openings is looked for, or sets beside a second
# start
_WORK = 20_000
# part of the largest motion from which on a node at an end of the way may open or close there
_MOVES = 1e-6


def best_pattern(
    of_set: Callable[[Question, float], Limit], closed: Limit, at: float, enough: float
) -> Limit:
    """The best limit that the search finds; `of_set` asks for the one of a question with given open nodes, which counts above a load factor.

    `closed` is the one with all nodes closed, the answer if it is safe from the mean load on and no
    node that governs it wants to open. Sets that are safe only above `at`, or above the end of the
    best one, do not count; the first limit not below `enough` ends the search. Under a static load
    nodes stay: sets would go on until the body slides off.
    """
    question, best, tried, turns = (
        closed._question,
        closed,
        {closed.open.tobytes()},
        not closed._question.static,
    )

    def counts(limit: Limit) -> bool:
        return not (np.isnan(limit.load_factor) or limit.least > at)

    def found(opened: Booleans, above: float = -np.inf) -> Limit | None:
        """The limit of a set that was not tried before, if it counts and is above a load factor; maybe it is the best one now."""
        nonlocal best
        if opened.tobytes() in tried or len(tried) > _MOST:
            return None
        tried.add(opened.tobytes())
        bar.update()
        with suppress(
            FrictoptError
        ):  # one without an answer that passes the checks is none of those known to rest
            rest = (
                None if opened.all() else with_open(question, opened)
            )  # a contact that is open for ever is none
            limit = None if rest is None else of_set(rest, above)
            if limit is None or not counts(limit) or limit.load_factor <= above:
                return None
            if not counts(best):
                best = limit
            elif limit.load_factor > best.load_factor * (1 + _GAINS):
                if limit.least > max(best.load_factor, at if at < np.inf else 0.0) * (
                    1 + _GAINS
                ):  # between them none is safe
                    return None
                best = replace(limit, least=min(best.least, limit.least))
            return limit
        return None

    def climb(here: Limit | None) -> None:
        """From a set to one next to it with a higher limit, as long as there is one."""
        while turns and here and counts(best) and best.load_factor < enough:
            above = here.load_factor * (1 + _GAINS)
            here = next(filter(None, (found(opened, above) for opened in _next_to(here))), None)

    with _search("open nodes", lambda: best) as bar:
        climb(closed)
        wants = len(tried) > 1
        if wants or not closed.least <= 0:
            starts = [
                limit
                for opened in _settled(question, wants, counts(best))
                if (limit := found(opened))
            ]
            climb(max(starts, key=lambda limit: limit.load_factor, default=None))
            if starts and len(tried) * closed.slip.size < _WORK:
                climb(starts[-1])  # that of least friction, from which other sets are near
    return best


def _search(what: str, best: Callable[[], Limit]) -> AbstractContextManager[Bar]:
    """The bar of a search, which counts its programs; an interrupt keeps what is best then."""

    def told() -> str:
        reached = best().load_factor
        return "none safe so far" if np.isnan(reached) else f"at least {reached:.4g} so far"

    return bar_of(
        True,
        what,
        "program",
        best=told,
        keeps=lambda _: ("limit", best(), "the best limit by then is in the attribute `limit`"),
    )


def _settled(question: Question, wants: bool, safe: bool) -> Iterator[Booleans]:
    """What the mean load leaves open, with the friction, with more and with parts of it: where it opens none, only if a node `wants` to open."""
    for share in _SHARES:
        try:
            opened = open_under_mean(question, share * question.friction)
        except (
            SolverError
        ):  # of the way to the mean load: the search has one set less to begin with
            # If nothing else is known to rest, an unknown way is no proof that nothing rests. A
            # body that slides off has no way.
            if share == 1.0 and not safe and not _slides_off(question):
                raise
            continue
        yield from opened
        if share == 1.0 and not (opened or wants):
            return


def _slides_off(question: Question) -> bool:
    """Whether the mean load slides a body off at the pressures of the closed contact."""
    statics = Statics(question.system, question.friction)
    return any(
        statics.slides_off("the mean load", forces.ravel()) is not None for forces in question.r0
    )


def _next_to(best: Limit) -> Iterator[Booleans]:
    """Sets next to one: the nodes that govern its limit opened or closed, all at once, one by one, or in space in small groups.

    And those of them at its border; and the whole border from outside or inside, as a mechanism may
    govern on one side only.
    """
    question = best._question
    moved = best._motion.parts(question.system).sum(axis=(0, 1))
    ruling = np.argsort(-moved, kind="stable")[: int((moved > _GOVERNS * moved.max()).sum())]
    if not best.open.any():
        pressed = best.reactions[1].min(axis=0) > TOUCHES * question.force
        ruling = ruling[~pressed[ruling] | (question.r0[:, -1, ruling].max(axis=0) < 0)]
    near = np.roll(best.open, 1) != best.open
    border = near | np.roll(near, -1)
    plane = question.system.tangents == 1
    size = 1 if plane or len(ruling) <= _FEW else _GROUP
    edge, inner = ruling[border[ruling]], ruling[~border[ruling]]
    sides = [np.flatnonzero(border & (best.open == state)) for state in (False, True) if plane]
    groups = [
        ruling,
        edge,
        *sides,
        *(part[k : k + size] for part in (edge, inner) for k in range(0, len(part), size)),
    ]
    for nodes in groups:
        opened = best.open.copy()
        opened[nodes] ^= True
        yield opened


def best_order(
    best: Limit, of_order: Callable[[LiftOff, float], Limit], at: float = np.inf
) -> Limit:
    """The best limit that pivots reach from one with nodes that stay as they are; that itself where none is better.

    `of_order` asks for that of an order, which counts above a load factor; the first not below `at`
    is enough.
    """
    question, order, tried = best._question, Order(_nodes(best.open)), set[Order]()
    most = min(_MOST, _WORK // best.slip.size)

    @cache
    def of_set(nodes: Nodes) -> Question | None:
        return with_open(question, among(nodes, question.system.nodes))

    def gains(pivot: Order) -> bool:
        nonlocal best, order
        if pivot in tried or len(tried) >= most:
            return False
        tried.add(pivot)
        bar.update()
        with suppress(
            FrictoptError
        ):  # one without an answer that passes the checks is none of those known to rest
            asked = with_order(question, pivot, of_set)
            limit = None if asked is None else of_order(asked, best.load_factor * (1 + _GAINS))
            if limit is not None and limit.load_factor > best.load_factor * (1 + _GAINS):
                best, order = replace(limit, least=best.least), pivot
                return True
        return False

    with _search("events", lambda: best) as bar:
        while best.load_factor < at and any(gains(pivot) for pivot in _pivots(best, order)):
            pass
    return best


def check_events(events: object, question: Question, given: bool) -> None:
    """Refuse to search nodes that open and close in each cycle where there is no such search; `given`: open nodes, or rows of the user's own."""
    reasons = {
        "the load cycle has not two corners, between which it goes to and fro": len(
            question.cycle.corners
        )
        != 2,
        "its corners differ at load factor 0 (fixed)": question.fixed,
        "the slip is bounded": question.slip_bound is not None,
        "the surface has a shear strength": question.system.capped,
        "open, constraints and objectives are about nodes that stay as they are": given,
    }
    wanted = flag("events", events)
    for reason, holds in reasons.items():
        if wanted and holds:
            raise ModelError(f"events: {reason}; ask without events")


def _nodes(chosen: Booleans) -> Nodes:
    return frozenset(np.flatnonzero(chosen).tolist())


def _pivots(best: Limit, order: Order) -> Iterator[Order]:
    """Orders next to one, by nodes that want to open or close at a corner, and by its own events."""
    question, (start, events), sets = best._question, order, order.between
    (u, r), moved = (
        question.states(best.load_factor, best.slip),
        best._motion.parts(question.system).sum(axis=0)[[0, -1]],
    )
    bare, shut = r[:, -1] <= TOUCHES * question.force, u[:, -1] <= TOUCHES * question.clearance
    ruling = moved > _MOVES * moved.max()
    opening = [_nodes(bare[k] & ruling[k]) - sets[k] for k in (0, -1)]
    for last in _together_and_alone(opening[1]):
        for first in dict.fromkeys([opening[0], Nodes()]):
            yield Order(start | first, (*filter(None, [first]), *events, last))
    for first in _together_and_alone(opening[0]):
        yield Order(start | first, (first, *events))
    for node in sorted(_nodes(shut[1] & ruling[1]) & sets[-1]):
        yield Order(start, (*events, Nodes({node})))
    for node in sorted(_nodes(shut[0] & ruling[0]) & sets[0]):
        yield Order(start - {node}, (Nodes({node}), *events))


def _together_and_alone(nodes: Nodes) -> list[Nodes]:
    return [*filter(None, [nodes]), *(Nodes({node}) for node in sorted(nodes) if len(nodes) > 1)]
