"""Search for nodes that open and close in each cycle.

If the load goes to and fro on a line between two corners, an order of events is changed by pivots:
in a pivot, nodes open or close at one of the corners. The previous order is a limiting case of the
new one. Therefore the load factors between the limits of the two orders are safe, too. If no pivot
raises the limit, transients are followed just above the best limit. A transient that comes to rest
shows the next order (`settled_orders`). For other cycles there are no pivots, only transients.

The search calls functions that return the limit for given open nodes, or for an order. Each limit
passes the usual checks, and its bound holds for its own order only.

If on each segment with events only the scaled or only the fixed loads vary, the limit of an order
is one convex program. If both vary on such a segment, the program has products of the load factor
and the places of events. Then linearised programs are solved one after another.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from ...base import Array, Bar, Booleans, LimitKind, Outcome, progress_bar
from ...contact import ContactSystem
from ...errors import FrictoptError
from ..answers.reasons import nothing_with_events
from ..answers.shakedown_answer import ShakedownAnswer
from ..events.lift_off import (
    LiftOff,
    LoadPath,
    Nodes,
    Order,
    ends_of,
    may_open_and_close,
    meets_mean_load,
    path_of,
    with_order,
)
from ..events.ordered import About, ordered_program, read_solution
from ..program.question import Question, pose_like, with_open
from ..program.rest_program import slip_units
from ..program.solution import Judged, Solution, solve
from .likely_sets import GAIN, GOVERNS_TOUCHING, PROGRAMS, WORK, touching
from .set_search import keep_best

# Numbers of the transients.

# How far above the limit transients are followed, relative to the limit.
_ABOVE = 0.003
# How far above a limit of 0 transients are followed, relative to the unit of the load.
_ABOVE_ZERO = 1e-3
# Load factors of the transients if no safe load factor is known, in units of the load. If the cycle
# has fixed parts, the first load factor is 0.
_FIRST = (0.005, 0.05, 0.3, 1.0)
# Load factor of an overload before the cycles, divided by the load factor of the cycles. The
# overload leaves another slip.
_OVERLOAD = 5.0
# In contacts of at most this many nodes, further transients start from the slip of the limit, after
# the slip of one node is changed by its unit, forwards or backwards. These transients may settle to
# other orders.
_MOVED = 6
# Cycles after which a transient is given up.
_CYCLES = 300
# A node is open if its gap is above this share of the largest gap. An interval counts if it is
# longer than this share of a segment.
_COUNTS = 1e-9


# An order of events, and where its events lie at the load factor of a transient.
Settled = tuple[Order, About]


def settled_orders(limit: ShakedownAnswer) -> Iterator[Settled]:
    """Orders that transients show just above a limit or, without a limit, at small load factors."""
    question = limit._question
    path = path_of(question.cycle)
    assert path is not None  # a static load has no events
    for load_factor, start in _starts(limit):
        settled = _settled(question, path, load_factor, start)
        if settled is not None:
            yield settled


def _starts(limit: ShakedownAnswer) -> Iterator[tuple[float, dict[str, Any]]]:
    """Load factors of transients, and the states from which they start."""
    unit = limit._question.load_unit
    if np.isnan(limit.load_factor):
        at_zero = (0.0,) if limit._question.fixed else ()
        for share in (*at_zero, *_FIRST):
            yield share * unit, {}
    elif np.isfinite(limit.load_factor):
        load_factor = limit.load_factor * (1 + _ABOVE) or _ABOVE_ZERO * unit
        yield load_factor, {"initial_state": limit.state}
        yield load_factor, {}
        yield load_factor, {"overload": _OVERLOAD * load_factor}
        units = slip_units(limit._question).reshape(limit.slip.shape, order="F")
        entries = np.ndindex(units.shape) if limit.system.nodes <= _MOVED else ()
        for entry in entries:
            for sense in (-1.0, 1.0):
                slip = limit.slip.copy()
                slip[entry] += sense * units[entry]
                yield load_factor, {"initial_slip": slip}


def _settled(
    question: Question, path: LoadPath, load_factor: float, start: dict[str, Any]
) -> Settled | None:
    """The order of the state of rest to which a transient settles; None if it does not settle."""
    # Imported here, because only the search of events needs it.
    from ...transients.steady import steady_state

    with suppress(FrictoptError):
        steady = steady_state(
            question.system,
            question.cycle,
            question.friction,
            load_factor,
            most_cycles=_CYCLES,
            progress=False,
            **start,
        )
        if steady.outcome is Outcome.SHAKEDOWN and steady.period == 1:
            states = steady.states()
            return _order_of(question.system, path, states.time, states.gap, load_factor)
    return None


def _order_of(
    system: ContactSystem, path: LoadPath, time: Array, gap: Array, load_factor: float
) -> Settled:
    """The order of a cycle, from its states.

    A node is open between two states if it has a gap in one of them.

    A cycle of states begins at the last corner; at time k the load is at corner k - 1.
    """
    corners = max(path.stops) + 1
    begins, ends = time[:-1], time[1:]
    segment = np.floor((begins + ends) / 2)
    segments = (segment - np.floor(time[0]) - 1).astype(int) % corners
    shares = (begins - segment).clip(0.0)
    size = max(float(gap.max()), np.finfo(float).tiny)
    opened = gap[:-1] + gap[1:] > _COUNTS * size
    counts = ends - begins > _COUNTS
    if not path.closed:
        counts &= segments == 0
    along = np.lexsort([shares, segments])
    along = along[counts[along]]

    sets = [_nodes(opened[j]) for j in along]
    events = list[tuple[int, float, Nodes]]()
    for j, before, after in zip(along[1:], sets[:-1], sets[1:], strict=True):
        if after != before:
            events.append((int(segments[j]), float(shares[j]), before ^ after))
    # Nodes that differ between the last and the first interval change at the first corner.
    if path.closed and sets[-1] != sets[0]:
        events.append((corners - 1, 1.0, sets[-1] ^ sets[0]))
    order = Order(
        sets[0], tuple(nodes for *_, nodes in events), tuple(segment for segment, *_ in events)
    )
    return order, About(load_factor, tuple(share for _, share, _ in events))


# A shakedown limit.
L = TypeVar("L", bound=ShakedownAnswer)


class Limits(NamedTuple, Generic[L]):
    """The functions of `shakedown.py` that return limits."""

    of_set: Callable[..., L]  # of a question with given open nodes
    of_order: Callable[..., L]  # of a program of an order of events


def best_order(limits: Limits[L], best: L, enough: float) -> L:
    """The best limit with nodes that open and close in each cycle, starting from `best`.

    The result is `best` itself if no order is better. The first limit that reaches `enough` ends
    the search.
    """
    question = best._question
    with progress_bar(True, "events", "program") as bar:
        search = _OrderSearch(limits, best, bar)
        path = path_of(question.cycle)
        if path is not None and not path.closed and not question.fixed:
            while search.below(enough) and any(
                search.gains(order) for order in _pivots(search.best, search.order)
            ):
                pass
        while search.below(enough) and any(
            search.gains_settled(*settled) for settled in settled_orders(search.best)
        ):
            pass
    return search.best


class _OrderSearch(Generic[L]):
    """The orders that have been tried, and the best limit so far with its order."""

    def __init__(self, limits: Limits[L], start: L, bar: Bar) -> None:
        self.best = start
        self.order = Order(_nodes(start.open))
        self._question = start._question
        self._limits = limits
        self._tried = set[Order]()
        self._programs = min(PROGRAMS, WORK // start.slip.size)
        self._bar = bar
        keep_best(bar, lambda: self.best)

    def below(self, enough: float) -> bool:
        """Whether the best limit is below `enough`, or none is known."""
        return not self.best.load_factor >= enough

    def gains(self, order: Order) -> bool:
        """Whether the order that a pivot gives has a higher limit; if so, it becomes the best."""
        limit = self._higher(order)
        if limit is None:
            return False
        self._keep(order, limit, self.best.least)
        return True

    def gains_settled(self, order: Order, about: About) -> bool:
        """Whether the order that a transient shows has a higher limit. If so, it is the best one.

        The order does not count if its least safe load factor is above the best limit so far,
        because load factors in between may not be safe.
        """
        limit = self._higher(order, about)
        if limit is None:
            return False
        least = limit.least
        if not np.isnan(self.best.load_factor):
            if least > self.best.load_factor * (1 + GAIN):
                return False
            # `least` becomes NaN if the least safe load factor of either limit is not known.
            least = float(np.minimum(least, self.best.least))
        self._keep(order, limit, least)
        return True

    def _higher(self, order: Order, about: About | None = None) -> L | None:
        """The limit of an order, if the order is new and its limit is the highest so far."""
        if not order.events and len(order.start) == self._question.system.nodes:
            return None  # no node ever touches: see `best_open_set`
        if order in self._tried or len(self._tried) >= self._programs:
            return None
        self._tried.add(order)
        self._bar.update()
        above = self.best.load_factor * (1 + GAIN)
        if np.isnan(above):
            above = -np.inf
        # An order whose answer fails the checks does not count.
        with suppress(FrictoptError):
            question = with_order(self._question, order)
            if question is None:
                return None
            if order.events:
                limit = _limit_of(self._limits.of_order, question, about, above)
            else:
                limit = self._limits.of_set(question.sets[0], above=above)
            if limit.load_factor > above:
                return limit
        return None

    def _keep(self, order: Order, limit: L, least: float) -> None:
        self.best = replace(limit, least=least)
        self.order = order


def _nodes(chosen: Booleans) -> Nodes:
    return frozenset(np.flatnonzero(chosen).tolist())


def _pivots(limit: ShakedownAnswer, order: Order) -> Iterator[Order]:
    """Neighbouring orders, in which nodes open or close at a corner.

    First, all nodes without pressure at a corner open there, and all nodes without gap close there.
    To open them one by one would not do: on symmetric contacts only one of two twin nodes may have
    a multiplier, and opening this node alone does not raise the limit. Then only nodes that govern
    change: they open together, and close one by one.
    """
    bare, shut = _touching(limit)
    opened = order.between[0], order.between[-1]
    opens = [nodes - already for nodes, already in zip(bare, opened, strict=True)]
    closes = [nodes & already for nodes, already in zip(shut, opened, strict=True)]
    yield from _openings(order, *opens)
    yield from _closings(order, *closes)

    first, last = _governing(limit)
    yield from _openings(order, opens[0] & first, opens[1] & last)
    for node in sorted(closes[1] & last):
        yield from _closings(order, Nodes(), Nodes({node}))
    for node in sorted(closes[0] & first):
        yield from _closings(order, Nodes({node}), Nodes())


def _openings(order: Order, first: Nodes, last: Nodes) -> Iterator[Order]:
    """Orders in which nodes open at the first corner, at the last one, or at both."""
    for at_last in dict.fromkeys([last, Nodes()]):
        for at_first in dict.fromkeys([first, Nodes()]):
            before = (at_first,) if at_first else ()
            after = (at_last,) if at_last else ()
            if before or after:
                yield Order(order.start | at_first, (*before, *order.events, *after))


def _closings(order: Order, first: Nodes, last: Nodes) -> Iterator[Order]:
    """Orders in which nodes close at the last corner, and at the first one."""
    if last:
        yield Order(order.start, (*order.events, last))
    if first:
        yield Order(order.start - first, (first, *order.events))


def _touching(limit: ShakedownAnswer) -> tuple[list[Nodes], list[Nodes]]:
    """Nodes without pressure, and nodes without gap, at the first and the last corner."""
    bare, shut = touching(limit._question, limit.load_factor, limit.slip)
    return [_nodes(bare[k]) for k in (0, -1)], [_nodes(shut[k]) for k in (0, -1)]


def _governing(limit: ShakedownAnswer) -> list[Nodes]:
    """Nodes that govern the limit at the first and the last corner."""
    system = limit._question.system
    motion: Array = limit._motion.parts(system).sum(axis=0)[[0, -1]]  # (2, N)
    governs = motion > GOVERNS_TOUCHING * motion.max()
    return [_nodes(governs[k]) for k in (0, -1)]


# Numbers of the programs with products of the load factor and places of events.

# Largest number of linearised programs.
_LINEARISED = 20
# The solution no longer changes if load factor (in its unit) and places change by less than this.
_STAYS = 1e-8


def best_with_events(limits: Limits[L], best: L, enough: float = np.inf) -> L:
    """The best limit with nodes that open and close in each cycle; `best` if none is better.

    `best` is the limit of nodes that stay open or closed. The search ends with the first limit that
    reaches `enough`. No order is searched if nodes cannot open and close in a state of rest.
    """
    question = best._question
    path = path_of(question.cycle)
    if path is None or not may_open_and_close(question, path):
        return best
    if path.closed or len(question.cycle.corners) == 2:
        found = best_order(limits, best, enough)
    else:
        found = _between_ends(limits, best, enough, path)
    if found.kind is LimitKind.NO_SAFE_SLIP:
        return replace(found, _why=nothing_with_events(found))
    return found


def _between_ends(limits: Limits[L], best: L, enough: float, path: LoadPath) -> L:
    """The best limit of a load on a line, whose two ends replace all its corners in the search."""
    question = best._question
    ends = pose_like(question, ends_of(question.cycle, path), question.friction)
    opened = with_open(ends, question.open_nodes)
    assert opened is not None  # the set has a limit with all corners
    found = best_order(limits, limits.of_set(opened), enough)
    if isinstance(found._question, LiftOff):
        order = found._question.order
        with_corners = with_order(question, order)
        assert with_corners is not None  # the order has a limit between the ends
        about = About(found.load_factor, found._question.shares)
        limit = _limit_of(limits.of_order, with_corners, about, -np.inf)
    elif (found.open == best.open).all():
        return best
    else:
        opened = with_open(question, found.open)
        assert opened is not None  # the set has a limit
        limit = limits.of_set(opened)
    return replace(limit, least=found.least)


def _limit_of(
    limit_of_order: Callable[..., L], question: LiftOff, about: About | None, above: float
) -> L:
    """The limit of an order; SolverError if it is proven to be at most `above`.

    `about` says where a transient shows the events; None if the order comes from a pivot. If the
    load passes through the mean load on a line, all smaller load factors are safe. Else a second
    program gives the least safe load factor, unless the order comes from a pivot.
    """
    if question.both_vary:
        assert about is not None  # there are no pivots if fixed parts differ
        return _limit_of_products(limit_of_order, question, about)
    program = ordered_program(question)
    limit = limit_of_order(question, program, 1.0, above)
    if meets_mean_load(question, question.path):
        return replace(limit, least=0.0)
    if about is None:
        return limit
    return replace(limit, least=limit_of_order(question, program, -1.0).load_factor)


def _limit_of_products(limit_of_order: Callable[..., L], question: LiftOff, about: About) -> L:
    """The limit of an order whose program has products of the load factor and places.

    The program is linearised about the last solution and solved again, until the solution no longer
    changes. The solution obeys the contact law. It has no bound, and the least safe load factor is
    not known.
    """
    for _ in range(_LINEARISED):
        program = ordered_program(question, about=about)
        judged, _ = solve(program, _judged)
        placed, _, _ = read_solution(question, judged.said)
        assert isinstance(placed, LiftOff)  # so is the question
        load_factor = judged.said.load_factor
        change = abs(load_factor - about.load_factor) / question.load_unit
        moved = np.abs(np.subtract(placed.shares, about.places)).max()
        about = About(load_factor, placed.shares)
        if max(change, moved) <= _STAYS:
            break
    return replace(limit_of_order(question, program, 1.0), bound=np.inf)


def _judged(solution: Solution) -> Judged:
    """A solution of a linearised program, which counts if its multipliers prove its optimum."""
    return Judged(solution, solution.gap)
