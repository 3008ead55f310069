"""Search for nodes that open and close in each cycle.

On a line between two corners an order of events changes by pivots at the corners. The previous
order is a limiting case of the new one, so that the load factors between the limits of the two are
safe, too. Then, and for other cycles at once, transients are followed just above the best limit: a
transient that comes to rest shows the next order (`settled_order.py`).

The search calls a function that returns a limit; it does not depend on the program behind it. Each
limit passes the usual checks, and its bound holds for its own order only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cache
from typing import Generic, TypeVar

import numpy as np

from ..base import Array, Bar, Booleans, progress_bar
from ..errors import FrictoptError
from .lift_off import LiftOff, Nodes, Order, among, with_order
from .likely_sets import SEARCH
from .load_path import path_of
from .open_nodes import TOUCHES
from .question import Question, with_open
from .set_search import keep_best
from .settled_order import Settled, settled_orders
from .shakedown_answer import ShakedownAnswer

# A shakedown limit.
L = TypeVar("L", bound=ShakedownAnswer)


def best_order(
    limit_of: Callable[[LiftOff | None, Settled, float], L],
    best: L,
    enough: float = np.inf,
) -> L:
    """The best limit with nodes that open and close in each cycle, starting from `best`.

    The result is `best` itself if no order is better. `limit_of(question, settled, above)` computes
    the limit of a question with an order, or without a question, if the order has no events, the
    limit with its open nodes. It may raise an error if this limit is at most `above`. The first
    limit that reaches `enough` ends the search.
    """
    question = best._question
    with progress_bar(True, "events", "program") as bar:
        search = _OrderSearch(limit_of, best, bar)
        path = path_of(question.cycle)
        if path is not None and not path.closed and not question.fixed:
            while search.below(enough) and any(
                search.gains(order) for order in _pivots(search.best, search.order)
            ):
                pass
        while search.below(enough) and any(
            search.gains_settled(settled) for settled in settled_orders(search.best)
        ):
            pass
    return search.best


class _OrderSearch(Generic[L]):
    """The orders that have been tried, and the best limit so far with its order."""

    def __init__(
        self, limit_of: Callable[[LiftOff | None, Settled, float], L], start: L, bar: Bar
    ) -> None:
        self.best = start
        self.order = Order(_nodes(start.open))
        self._question = start._question
        self._limit_of = limit_of
        self._tried = set[Order]()
        self._programs = min(SEARCH.programs, SEARCH.work // start.slip.size)
        self._with_open = cache(self._of_set)
        self._bar = bar
        keep_best(bar, lambda: self.best)

    def _of_set(self, nodes: Nodes) -> Question | None:
        return with_open(self._question, among(nodes, self._question.system.nodes))

    def below(self, enough: float) -> bool:
        """Whether the best limit is below `enough`, or none is known."""
        return not self.best.load_factor >= enough

    def gains(self, order: Order) -> bool:
        """Whether an order with a pivot has a higher limit. If so, it becomes the best one."""
        limit = self._higher(Settled(order))
        if limit is None:
            return False
        self._keep(order, limit, self.best.least)
        return True

    def gains_settled(self, settled: Settled) -> bool:
        """Whether the order of a transient at rest has a higher limit; if so, it is the best one.

        It does not count if the load factors between both limits are not safe.
        """
        limit = self._higher(settled)
        if limit is None:
            return False
        least = limit.least
        if not np.isnan(self.best.load_factor):
            if least > self.best.load_factor * (1 + SEARCH.gain):
                return False
            # It is NaN if one of the two is missing.
            least = float(np.minimum(least, self.best.least))
        self._keep(settled.order, limit, least)
        return True

    def _higher(self, settled: Settled) -> L | None:
        """The limit of a new order, if it is higher than the best one."""
        order = settled.order
        if not order.events and len(order.start) == self._question.system.nodes:
            return None  # nothing touches: see `best_open_set`
        if order in self._tried or len(self._tried) >= self._programs:
            return None
        self._tried.add(order)
        self._bar.update()
        above = self.best.load_factor * (1 + SEARCH.gain)
        if np.isnan(above):
            above = -np.inf
        # An order whose answer fails the checks does not count.
        with suppress(FrictoptError):
            question = with_order(self._question, order, self._with_open)
            if question is None:
                return None
            limit = self._limit_of(question if order.events else None, settled, above)
            if limit.load_factor > above:
                return limit
        return None

    def _keep(self, order: Order, limit: L, least: float) -> None:
        self.best = replace(limit, least=least)
        self.order = order


def _nodes(chosen: Booleans) -> Nodes:
    return frozenset(np.flatnonzero(chosen).tolist())


def _pivots(limit: ShakedownAnswer, order: Order) -> Iterator[Order]:
    """Neighbouring orders: nodes open or close at a corner.

    First all nodes without pressure open there, and all without gap close: on symmetric contacts
    only one of two twin nodes may have a multiplier, and opening this node alone does not raise the
    limit. Then the nodes that govern open together, and close one by one.
    """
    bare, shut = _touching(limit)
    yield from _all_at_once(bare, shut, order)

    start, events, _ = order
    open_first = order.between[0]
    open_last = order.between[-1]
    governs_first, governs_last = _governing(limit)
    opens_first = (bare[0] & governs_first) - open_first
    opens_last = (bare[1] & governs_last) - open_last
    if opens_last:
        for first in dict.fromkeys([opens_first, Nodes()]):
            before = (first,) if first else ()
            yield Order(start | first, (*before, *events, opens_last))
    if opens_first:
        yield Order(start | opens_first, (opens_first, *events))
    for node in sorted(shut[1] & governs_last & open_last):
        yield Order(start, (*events, Nodes({node})))
    for node in sorted(shut[0] & governs_first & open_first):
        yield Order(start - {node}, (Nodes({node}), *events))


def _all_at_once(bare: list[Nodes], shut: list[Nodes], order: Order) -> Iterator[Order]:
    """Orders in which all nodes without pressure open at a corner, or all without gap close."""
    start, events, _ = order
    open_first = order.between[0]
    open_last = order.between[-1]
    opens_first = bare[0] - open_first
    opens_last = bare[1] - open_last
    for last in dict.fromkeys([opens_last, Nodes()]):
        for first in dict.fromkeys([opens_first, Nodes()]):
            before = (first,) if first else ()
            after = (last,) if last else ()
            if before or after:
                yield Order(start | first, (*before, *events, *after))
    closes_first = shut[0] & open_first
    closes_last = shut[1] & open_last
    if closes_last:
        yield Order(start, (*events, closes_last))
    if closes_first:
        yield Order(start - closes_first, (closes_first, *events))


def _touching(limit: ShakedownAnswer) -> tuple[list[Nodes], list[Nodes]]:
    """Nodes without pressure, and nodes without gap, at the first and the last corner."""
    question = limit._question
    u, r = question.states(limit.load_factor, limit.slip)
    bare = r[:, -1] <= TOUCHES * question.force
    shut = u[:, -1] <= TOUCHES * question.clearance
    return [_nodes(bare[k]) for k in (0, -1)], [_nodes(shut[k]) for k in (0, -1)]


def _governing(limit: ShakedownAnswer) -> list[Nodes]:
    """Nodes that govern the limit at the first and the last corner."""
    system = limit._question.system
    motion: Array = limit._motion.parts(system).sum(axis=0)[[0, -1]]  # (2, N)
    governs = motion > SEARCH.governs_touching * motion.max()
    return [_nodes(governs[k]) for k in (0, -1)]
