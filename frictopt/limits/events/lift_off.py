"""Nodes that open and close in each cycle: the limit of a given order of openings and closings.

Instants are the corners and the events, in the order in which the load meets them. At event m the
load is at an unknown place of a segment between two corners. The limit of a given order is a linear
program, in space a cone program (theory, "Nodes that open and close in each cycle"). At an instant,
a node counts as closed if it is closed before or after it; A, B and the loads at the instant belong
to the contact with these closed nodes. An *episode* is a time in which a node is closed, from a
closing to its next opening. In each episode the node has one slip.

If all corners lie on a line, the states of rest along a segment between the two ends of the line
are a function of the load. So the two ends represent all turning points between them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import accumulate, combinations, pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...base import RESIDUAL, ROUNDING, Array, Booleans, Integers, Loads, kept, number_of, worst
from ...contact import LoadCycle
from ..program.question import Question, outer_corners, with_open

# Two segments lie on one line if their distance is below this share of their length.
_SAME_LINE = 1e-9


@dataclass(frozen=True)
class LoadPath:
    """The corners that the load visits, in order: `stops`.

    A path on a line goes from one end to the other, and comes back the same way: it has two stops.
    Any other path visits all corners, and returns to the first corner.
    """

    stops: tuple[int, ...]

    @property
    def closed(self) -> bool:
        """Whether the path returns to its first corner by a different way."""
        return self.stops[0] == self.stops[-1]

    @property
    def segments(self) -> list[tuple[int, int]]:
        """First and last corner of each straight segment."""
        return list(pairwise(self.stops))


def path_of(cycle: LoadCycle) -> LoadPath | None:
    """The path of a load cycle; None for a static load."""
    corners = outer_corners(cycle)
    if len(corners) == 1:
        return None
    if len(corners) == 2:
        return LoadPath(tuple(corners))
    return LoadPath((*range(len(cycle.corners)), 0))


def ends_of(cycle: LoadCycle, path: LoadPath) -> LoadCycle:
    """The load cycle to and fro between the stops of a path on a line."""
    fixed = None
    if cycle.fixed is not None:
        fixed = [cycle.fixed[k] for k in path.stops]
    return LoadCycle(cycle.mean, [cycle.corners[k] for k in path.stops], fixed)


def places_on(question: Question, path: LoadPath) -> Array:
    """(K,) places of the load corners on a path, in the unit of `LiftOff.way`."""
    if path.closed:
        return np.arange(len(question.r1), dtype=float)
    first, last = path.stops
    load = np.hstack(question.bonded)
    along = load[last] - load[first]
    return np.asarray((load - load[first]) @ along / (along @ along))


def meets_mean_load(question: Question, path: LoadPath) -> bool:
    """Whether the load goes through the mean load on a line, at every load factor.

    If it does, all states of rest at smaller load factors are also states of rest at a larger load
    factor.
    """
    if path.closed or question.fixed:
        return False
    first, last = (question.bonded[1][k] for k in path.stops)
    sizes = np.linalg.norm(first), np.linalg.norm(last)
    return bool(np.abs(sizes[1] * first + sizes[0] * last).max() <= ROUNDING * sizes[0] * sizes[1])


def has_static_shear(question: Question, load_factor: float) -> bool:
    """Whether the shear force of each node is the same at all corners."""
    static = question.r0[:, :-1]
    cyclic = load_factor * question.r1[:, :-1]
    largest = max(np.abs(static).max(), np.abs(cyclic).max())
    return bool(np.ptp(static + cyclic, axis=0).max() <= RESIDUAL * largest)


def may_open_and_close(question: Question, path: LoadPath | None) -> bool:
    """Whether some node can open and close in a state of rest, other than by chance.

    If nothing else opens or closes in between, the bonded reactions of a node are the same at its
    opening as at its closing (theory, "Where events can gain"). So these reactions must return on
    the path on which they came: on a line, or on two segments. Here all other nodes count as
    closed.
    """
    if path is None:
        return False
    if not path.closed:
        return True
    # (K, t + 1, N) bonded reactions at the corners.
    loads = question.bonded[0] + question.load_unit * question.bonded[1]
    loads = loads.reshape(question.r1.shape)
    return any(
        bool(_retraced(*loads[[*first, *second]]).any())
        for first, second in combinations(path.segments, 2)
    )


def _retraced(a: Array, b: Array, c: Array, d: Array) -> Booleans:
    """(N,) nodes whose reactions on segments a to b and c to d have a part of a line in common."""
    along = b - a
    size = (along**2).sum(axis=0)
    unit = np.where(size > 0, size, 1.0)
    off = np.zeros_like(size)
    places = []
    for point in (c, d):
        place = ((point - a) * along).sum(axis=0) / unit
        off = np.maximum(off, ((point - a - place * along) ** 2).sum(axis=0))
        places.append(place)
    low, high = np.minimum(*places), np.maximum(*places)
    common = np.minimum(high, 1.0) - np.maximum(low, 0.0)
    return np.asarray((size > 0) & (off <= _SAME_LINE**2 * size) & (common > _SAME_LINE))


Nodes = frozenset[int]


def among(nodes: Nodes, count: int) -> Booleans:
    """(count,) mask of some nodes."""
    return np.isin(np.arange(count), sorted(nodes))


class Instant(NamedTuple):
    """A corner (`event` is None) or an event, with the open nodes before and after it."""

    segment: int
    event: int | None
    before: Nodes
    after: Nodes

    @property
    def through(self) -> Nodes:
        """Nodes that are open before and after the instant."""
        return self.before & self.after

    @property
    def switching(self) -> Nodes:
        """Nodes that open or close at the instant."""
        return self.before ^ self.after


@kept
class Order(NamedTuple):
    """The nodes that are open at the first corner, and the nodes that switch at each event.

    A node switches if it opens or closes. Events are listed in the order in which the load meets
    them, and `segments` has the segment of each event. Without `segments`, all events are on the
    first segment.
    """

    start: Nodes
    events: tuple[Nodes, ...] = ()
    segments: tuple[int, ...] = ()

    @property
    def between(self) -> list[Nodes]:
        """Open nodes of each interval between events, from the first corner on."""
        return list(accumulate(self.events, frozenset.symmetric_difference, initial=self.start))

    @property
    def on_segments(self) -> tuple[int, ...]:
        """The segment of each event."""
        return self.segments or (0,) * len(self.events)

    def instants(self, path: LoadPath) -> list[Instant]:
        """The corners and events along a path, in their order."""
        sets = self.between
        instants = list[Instant]()
        event = 0
        for segment in range(len(path.segments)):
            instants.append(Instant(segment, None, sets[event], sets[event]))
            while event < len(self.events) and self.on_segments[event] == segment:
                instants.append(Instant(segment, event, sets[event], sets[event + 1]))
                event += 1
        if not path.closed:
            instants.append(Instant(len(path.segments), None, sets[-1], sets[-1]))
        return instants


@kept
@dataclass(frozen=True, eq=False, kw_only=True)
class LiftOff(Question):
    """A question with nodes that open and close in each cycle.

    `open_nodes` are open during the whole cycle. `way` (M,) is the place of each instant on the
    load path: k at its k-th stop, and linear between two stops. `sets` has a question for each
    instant, whose open nodes are open both before and after the instant. `shifts` (M, N) or (M, N,
    2) are, at each instant, the slip of the current episode minus the slip of the first episode.
    """

    order: Order
    way: Array
    sets: tuple[Question, ...]
    shifts: Array

    KEPT_FIELDS: ClassVar[tuple[str, ...]] = (
        *Question.KEPT_FIELDS,
        "order",
        "way",
        "sets",
        "shifts",
    )

    @classmethod
    def from_kept(cls, fields_in_file: Mapping[str, Any]) -> "LiftOff":
        """See `Question.from_kept`."""
        of_question = {name: fields_in_file[name] for name in Question.KEPT_FIELDS}
        own_fields = {name: fields_in_file[name] for name in ("order", "way", "sets", "shifts")}
        return cls(**fields_of(Question.from_kept(of_question)), **own_fields)

    @cached_property
    def path(self) -> LoadPath:
        """The path of the load."""
        path = path_of(self.cycle)
        assert path is not None  # a static load has no events, so it is never the load here
        return path

    @cached_property
    def at(self) -> list[Instant]:
        """The instants."""
        return self.order.instants(self.path)

    @cached_property
    def weights(self) -> Array:
        """(M, K) shares of the corners in the load of each instant."""
        segments = self.path.segments
        segment = np.array([min(instant.segment, len(segments) - 1) for instant in self.at])
        return shares_of_corners(segments, segment, self.way - segment, len(self.r1))

    @cached_property
    def opened(self) -> tuple[Booleans, Booleans]:
        """See `Question.opened`."""
        nodes = self.system.nodes
        before = np.array([among(instant.before, nodes) for instant in self.at])
        return before, np.array([among(instant.after, nodes) for instant in self.at])

    @cached_property
    def episodes(self) -> Integers:
        """See `episodes_of`."""
        return episodes_of(*self.opened, self.path.closed)

    @cached_property
    def later(self) -> list[tuple[int, int]]:
        """Node and number of each episode after the first; such an episode has a slip of its own.

        All instants share the slips of the first episodes.
        """
        instants, nodes = np.nonzero(self.episodes > 0)
        numbers = self.episodes[instants, nodes]
        return list(dict.fromkeys(zip(nodes.tolist(), numbers.tolist(), strict=True)))

    def placed(self, m: int) -> Array:
        """(N, L) 1 at the node of each later episode that lasts at an instant, else 0."""
        row = self.episodes[m]
        placed = np.zeros((len(row), len(self.later)))
        for place, (node, number) in enumerate(self.later):
            placed[node, place] = float(row[node] == number)
        return placed

    def instants(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Motions and reactions at the corners and events; see `Question.instants`."""
        motions = list[Array]()
        reactions = list[Array]()
        for question, shift, weights in zip(self.sets, self.shifts, self.weights, strict=True):
            u, r = question.states(load_factor, slip + shift)
            motions.append(np.tensordot(weights, u, 1))
            reactions.append(np.tensordot(weights, r, 1))
        return np.array(motions), np.array(reactions)

    def states(self, load_factor: float, slip: Array) -> tuple[Array, Array]:
        """Motions and reactions at the corners. They change linearly between two instants."""
        places = places_on(self, self.path)
        later = np.searchsorted(self.way, places).clip(1, len(self.way) - 1)
        length = self.way[later] - self.way[later - 1]
        share = (places - self.way[later - 1]) / np.where(length > 0, length, 1.0)
        share = share[:, None, None]
        u, r = self.instants(load_factor, slip)
        return (
            (1 - share) * u[later - 1] + share * u[later],
            (1 - share) * r[later - 1] + share * r[later],
        )

    def at_instants(self, load_factor: float) -> Array:
        """See `Question.at_instants`."""
        return np.asarray(self.weights @ super().at_instants(load_factor))

    def by_corner(self, moves: Array) -> Array:
        """Motions at the corners; the ends of a segment share the motions at its events."""
        return np.tensordot(self.weights.T, moves, 1)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Loads of the cycle at the corners and events, at load factor 1."""
        return names_of_instants(self.cycle, self.weights)

    @property
    def events(self) -> list[tuple[int, str, float, str]]:
        """See `Question.events`."""
        return events_of(*self.opened, self.way, self.names)

    @property
    def node_states(self) -> str:
        """See `Question.node_states`."""
        count = len(frozenset().union(*self.order.events))
        opened = ", these nodes open" if self.open_nodes.any() else ""
        moving = number_of(count, "node that opens and closes", "nodes that open and close")
        return f" with {moving} in this order{opened} and the others closed"

    @property
    def shares(self) -> tuple[float, ...]:
        """The places of the events on their segments, 0 to 1."""
        events = [m for m, instant in enumerate(self.at) if instant.event is not None]
        return tuple(float(self.way[m] - self.at[m].segment) for m in events)

    @cached_property
    def both_vary(self) -> bool:
        """Whether fixed and scaled loads both vary on a segment that has an event.

        In that case the place of the event times the load factor is not a linear unknown.
        """
        return any(all(varying(self, segment)) for segment in self.order.on_segments)

    def violation(self, load_factor: float, slip: Array) -> float:
        """Distance of a slip from being safe, see `Question.violation`.

        The distance includes forces on a node at the event at which it opens or closes, and events
        that are in the wrong order.
        """
        _, r = self.instants(load_factor, slip)
        before, after = self.opened
        touching = np.abs(r).max(axis=1)[before ^ after].max(initial=0.0) / self.force
        steps = np.diff(self.way, append=float(len(self.path.segments)))
        return worst([super().violation(load_factor, slip), touching, -steps.min()])


def episodes_of(before: Booleans, after: Booleans, closed: bool) -> Integers:
    """(M, N) number of the episode of each node at each instant, -1 while the node is open.

    The masks (M, N) have the nodes that are open just before and just after each instant. Until a
    node first opens, it is in its episode 0; each closing begins the next episode. On a closed
    path, the episode at the end of the cycle is the episode at its beginning.
    """
    opens = after & ~before
    numbers = opens.cumsum(axis=0) - opens
    if closed:
        numbers %= np.maximum(opens.sum(axis=0), 1)
    return np.where(before & after, -1, numbers)


def shares_of_corners(
    segments: Sequence[tuple[int, int]], segment: Integers, part: Array, count: int
) -> Array:
    """(M, count) shares of the corners in the loads at M instants, by their places on segments."""
    shares = np.zeros((len(segment), count))
    instants = np.arange(len(segment))
    first, last = np.array(segments)[segment].T
    shares[instants, first] += 1 - part
    shares[instants, last] += part
    return shares


def names_of_instants(cycle: LoadCycle, weights: Array) -> tuple[str, ...]:
    """Names of the loads at instants; `weights` (M, K) are the shares of the corners in them."""
    fixed = None if cycle.fixed is None else _blends(cycle.fixed, weights)
    return LoadCycle(cycle.mean, _blends(cycle.corners, weights), fixed).corner_names


def events_of(
    before: Booleans, after: Booleans, way: Array, names: Sequence[str]
) -> list[tuple[int, str, float, str]]:
    """The rows of `Question.events`, from the nodes (M, N) that are open around each instant."""
    return [
        (node, "closes" if before[m, node] else "opens", float(way[m]), names[m])
        for m, node in np.argwhere(before ^ after).tolist()
    ]


def _blends(corners: Sequence[Loads], weights: Array) -> list[dict[str, float]]:
    """Loads at the instants, from the loads at the corners."""
    blends = []
    for shares in weights.tolist():
        blend = dict[str, float]()
        for share, loads in zip(shares, corners, strict=True):
            if share:
                for case, amplitude in loads.items():
                    blend[case] = blend.get(case, 0.0) + share * amplitude
        blends.append(blend)
    return blends


def varying(question: LiftOff, segment: int) -> tuple[bool, bool]:
    """Whether the loads at load factor 0, and the scaled loads, vary along a segment."""
    first, last = question.path.segments[segment]
    fixed, scaled = (bool((part[first] != part[last]).any()) for part in question.bonded)
    return fixed, scaled


def fields_of(question: Question) -> dict[str, Any]:
    """Name -> value of the fields of a question."""
    return {part.name: getattr(question, part.name) for part in fields(Question)}


def with_order(question: Question, order: Order) -> LiftOff | None:
    """The question with an order of events, at preliminary places of the events.

    None if there is no such question: the closed nodes do not hold the open ones, or the open nodes
    at the end of the cycle differ from the open nodes at its beginning.
    """
    path = path_of(question.cycle)
    if path is None or (path.closed and order.between[-1] != order.start):
        return None
    instants = order.instants(path)
    through = [instant.through for instant in instants]
    always = frozenset.intersection(*order.between)
    # Instants with the same open nodes share one question.
    sets = dict[Nodes, Question]()
    for nodes in (*through, always):
        if nodes not in sets:
            opened = with_open(question, among(nodes, question.system.nodes))
            if opened is None:
                return None
            sets[nodes] = opened
    return LiftOff(
        **fields_of(sets[always]),
        order=order,
        way=way_of(instants, [0.5] * len(order.events)),
        sets=tuple(sets[nodes] for nodes in through),
        shifts=np.zeros((len(through), *question.system.slip_shape)),
    )


def way_of(instants: Sequence[Instant], shares: Sequence[float]) -> Array:
    """(M,) place `way` of each instant, from the place of each event on its segment."""
    way = []
    for instant in instants:
        share = 0.0 if instant.event is None else shares[instant.event]
        way.append(instant.segment + share)
    return np.array(way)
