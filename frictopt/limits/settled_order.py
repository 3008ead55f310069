"""Orders of events that transients settle to, just above a limit.

A transient that comes to rest shows which nodes are open, and when. The limit of its order is at
least its load factor. Just above that limit the next transient starts, from the state of the limit.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base import Array, Outcome
from ..contact import ContactSystem
from ..errors import FrictoptError
from .elastic import slip_units
from .lift_off import Nodes, Order
from .load_path import LoadPath, path_of
from .question import Question
from .shakedown_answer import ShakedownAnswer


@dataclass(frozen=True)
class TransientSettings:
    """Numbers of the transients."""

    # How far above the limit a transient is followed, relative to it.
    above: float = 0.003
    # The same if the limit is 0, relative to the unit of the load.
    above_zero: float = 1e-3
    # Load factors at which transients begin if no safe load factor is known, in units of the load.
    # If the cycle has fixed parts, the first load factor is 0.
    first: tuple[float, ...] = (0.005, 0.05, 0.3, 1.0)
    # An overload before the cycles, relative to the load factor: it leaves another slip.
    overload: float = 5.0
    # Largest number of nodes of a contact in which a transient also starts from the slip of the
    # limit with each slip of a node moved by its unit, in both senses: it may settle to another
    # order.
    moved: int = 6
    # Cycles after which a transient is given up.
    cycles: int = 300
    # A node is open if its gap is above this share of the largest one, and an interval counts if
    # it is longer than this share of a leg.
    counts: float = 1e-9


TRANSIENT = TransientSettings()


@dataclass(frozen=True)
class Settled:
    """An order of events, and the state of rest that shows it, if there is one.

    `shares` are the places of its events on their legs, at `load_factor`.
    """

    order: Order
    shares: tuple[float, ...] = ()
    load_factor: float = 0.0


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
    """Load factors and starts of transients."""
    unit = limit._question.load_unit
    if np.isnan(limit.load_factor):
        at_zero = (0.0,) if limit._question.fixed else ()
        for share in (*at_zero, *TRANSIENT.first):
            yield share * unit, {}
    elif np.isfinite(limit.load_factor):
        load_factor = limit.load_factor * (1 + TRANSIENT.above) or TRANSIENT.above_zero * unit
        yield load_factor, {"initial_state": limit.state}
        yield load_factor, {}
        yield load_factor, {"overload": TRANSIENT.overload * load_factor}
        units = slip_units(limit._question).reshape(limit.slip.shape, order="F")
        entries = np.ndindex(units.shape) if limit.system.nodes <= TRANSIENT.moved else ()
        for entry in entries:
            for sense in (-1.0, 1.0):
                slip = limit.slip.copy()
                slip[entry] += sense * units[entry]
                yield load_factor, {"initial_slip": slip}


def _settled(
    question: Question, path: LoadPath, load_factor: float, start: dict[str, Any]
) -> Settled | None:
    """The order of the state of rest to which a transient settles; None if it finds no rest."""
    # Imported here, because only the search of events needs it.
    from ..transients.steady import steady_state

    with suppress(FrictoptError):
        steady = steady_state(
            question.system,
            question.cycle,
            question.friction,
            load_factor,
            most_cycles=TRANSIENT.cycles,
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
    """The order of a cycle, from its states: a node is open between two states with a gap.

    A cycle of states begins at the last corner; at time k the load is at corner k - 1.
    """
    size = max(float(gap.max()), np.finfo(float).tiny)
    corners = max(path.stops) + 1
    intervals = list[tuple[int, float, Nodes]]()
    for j in range(len(time) - 1):
        middle = (time[j] + time[j + 1]) / 2
        if time[j + 1] - time[j] > TRANSIENT.counts:
            leg = (int(np.floor(middle)) - int(np.floor(time[0])) - 1) % corners
            nodes = np.flatnonzero(gap[j] + gap[j + 1] > TRANSIENT.counts * size)
            share = float(time[j] - np.floor(middle))
            intervals.append((leg, max(share, 0.0), frozenset(nodes.tolist())))
    intervals.sort(key=lambda interval: interval[:2])
    if not path.closed:
        intervals = [interval for interval in intervals if interval[0] == 0]

    events = list[tuple[int, float, Nodes]]()
    now: Nodes = intervals[0][2]
    for leg, share, opened in intervals[1:]:
        if opened != now:
            events.append((leg, share, opened ^ now))
            now = opened
    # What the last interval opens before the first corner, the first one closes there.
    if path.closed and now != intervals[0][2]:
        events.append((corners - 1, 1.0, now ^ intervals[0][2]))
    order = Order(
        intervals[0][2],
        tuple(nodes for _, _, nodes in events),
        tuple(leg for leg, _, _ in events),
    )
    return Settled(order, tuple(share for _, share, _ in events), load_factor)
