"""The amplitudes of two loads that vary independently at which some residual slip is safe, between two polygons: points reached, and mechanisms."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd

from ..base import (
    RESIDUAL,
    ZERO_LOAD_FACTOR,
    Array,
    Booleans,
    Plotted,
    Recorded,
    SolveRecord,
    bar_of,
    checked_loads,
    finite_number,
    frame,
    frozen,
    listed,
    warns_of_odd_values,
)
from ..base.checks import check_name
from ..contact import ContactSystem, LoadCycle, checked_system, friction_coefficients
from ..errors import ModelError, SolverError
from .answered import Mechanism
from .question import Question, pose, with_open
from .shakedown import ShakedownLimit, shakedown_limit


@dataclass(frozen=True, eq=False, repr=False)
class SafeRegion(Recorded, Plotted):
    """The amplitudes `(a, b)` of two loads at which some residual slip is safe.

    The region is convex, and holds all smaller amplitudes with any that it holds: both loads come
    back to zero, so that the mean load is in every domain, and must be safe. Its border goes from
    an amplitude of the first load alone to one of the second load alone: in the plane straight
    sides, in space a curve between the polygon of points that are proven safe, `vertices`, and that
    of mechanisms, `outer`.

    Attributes
    ----------
    loads, unlimited
        Names of the two loads, and of those whose amplitude has no limit.
    vertices
        (V, 2) amplitudes on the border, each proven safe, from the first load alone to the second;
        inf where there is no limit, empty where none is safe. Between them all are safe, too.
    outer
        (W, 2) amplitudes at the ends of the sides; in the plane the vertices.
    sides
        One row for each side, between two of `outer`: columns a, b, bound. No amplitudes are safe
        with `a * first + b * second > bound`; a, b and bound are works of the side's mechanism,
        scaled to `bound = 1` where the mean load has a resistance.
    gap
        Largest distance of the two polygons on a ray from zero, over its length: 0 in the plane, at
        most the tolerance in space.
    mechanisms
        For each side, which nodes limit the amplitudes: as in `ShakedownLimit.mechanism`, corners
        of `cycle(a, b)`.
    reason
        Why the region is what it is, in words.
    record
        How it was found. Its `residual`, at most 2e-8, is the largest of: the residuals of the
        limits at all vertices, and the distance of each side from its two vertices, relatively.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [2.0]), "Q": ([1.0], [0.0]), "R": ([0.0], [-1.0])})
    >>> region = fo.safe_region(node, {"P": 1.0}, ["Q", "R"], friction=0.5)
    >>> region.contains(0.5, 0.9), region.contains(0.5, 1.1)
    (True, False)
    """

    loads: tuple[str, str]
    vertices: Array
    outer: Array = field(repr=False)
    sides: pd.DataFrame = field(repr=False)
    mechanisms: tuple[pd.DataFrame, ...] = field(repr=False)
    unlimited: tuple[str, ...]
    gap: float
    reason: str
    record: SolveRecord
    _mean: Mapping[str, float] = field(repr=False)
    _parts: tuple[Sequence[Mapping[str, float]], Sequence[Mapping[str, float]]] = field(repr=False)

    def contains(self, first: float, second: float) -> bool:
        """Whether some slip is proven safe at these amplitudes, in the polygon of `vertices`; ModelError if not finite or negative."""
        at = np.array(
            [finite_number("first", first, least=0.0), finite_number("second", second, least=0.0)]
        )
        within = all(across @ at <= across @ one for one, across in _chords(self.vertices))
        return within and bool((at <= self.vertices.max(axis=0, initial=-1.0)).all())

    def cycle(self, first: float, second: float) -> LoadCycle:
        """The vertices of the domain of loads at these amplitudes, a load cycle for other functions; ModelError if not finite or negative."""
        amplitudes = (
            finite_number("first", first, least=0.0),
            finite_number("second", second, least=0.0),
        )
        return domain(self._mean, self._parts, amplitudes)

    def to_frame(self) -> pd.DataFrame:
        """One row for each vertex: its two amplitudes."""
        return frame({name: self.vertices[:, number] for number, name in enumerate(self.loads)})

    def _answer(self) -> Mapping[str, object]:
        curved = {"gap": self.gap} if self.gap else {}
        said = {
            "loads": self.loads,
            "sides": len(self.sides),
            "unlimited": self.unlimited,
            **curved,
        }
        return said | {"residual": self.residual, "reason": self.reason}


def domain(
    mean: Mapping[str, float],
    parts: tuple[Sequence[Mapping[str, float]], ...],
    amplitudes: tuple[float, float],
) -> LoadCycle:
    """The vertices of the loads that vary around the mean, each within the hull of its corners, see `SafeRegion.cycle`."""
    scaled = [
        [{case: factor * amplitude for case, amplitude in corner.items()} for corner in part]
        for factor, part in zip(amplitudes, parts, strict=True)
    ]
    return LoadCycle.vertices(mean, *scaled)


def _chords(vertices: Array) -> list[tuple[Array, Array]]:
    """For each two neighbouring points of the border, the first one and a vector across their chord, outwards."""
    return [
        (one, np.array([other[1] - one[1], one[0] - other[0]])) for one, other in pairwise(vertices)
    ]


def beyond_chord(one: Array, other: Array, at: Array) -> float:
    """How far a point is beyond the chord of two points of the border on its ray from zero, over its distance from zero."""
    ((_, across),) = _chords(np.array([one, other]))
    return float(1 - across @ one / (across @ at))


_ONE_SIDE = (
    10 * RESIDUAL
    # a point this close to a line, over the distance of the line from zero, is on it: both have errors
    # up to the residual
)
_MOST_SIDES = 1000


@warns_of_odd_values
def safe_region(
    system: ContactSystem,
    mean: Mapping[str, float],
    loads: Sequence[Any],
    friction: Any,
    *,
    tolerance: float = 1e-3,
    progress: bool = True,
) -> SafeRegion:
    """Which amplitudes of two loads that vary independently around a mean load leave a safe residual slip.

    The amplitudes and slips that are safe for all loads of the domain are a convex set, and so is
    its shadow on the plane of the two amplitudes. Each shakedown limit along a ray gives a point of
    its border and, by its mechanism, a straight line that no safe amplitudes are beyond. The next
    ray goes to the point where two neighbouring lines meet: if it is safe, it is a vertex, else its
    limit gives a line between them. In the plane all vertices and sides of a polygon are found, by
    one linear program each. In space the border is curved, and rays by cone programs go on until
    points and lines are two polygons within the tolerance. Theory, eq. (17). Where nodes stay open,
    the region is that of the open nodes of the limit under both loads: with others open, more may
    be safe. Ctrl-C stays a KeyboardInterrupt with an attribute `table`, safe amplitudes of both
    loads.

    Parameters
    ----------
    system, friction
        See `shakedown_limit`.
    mean
        Static load, load case name -> amplitude.
    loads
        The two loads. Each is the name of a load case, which varies between plus and minus its
        amplitude; or a list of corners at amplitude 1, load case name -> amplitude, for a load that
        varies within their hull and comes back to zero. The two share no load case.
    tolerance
        In space the largest `SafeRegion.gap`; in the plane there is none.
    progress
        Whether to show after two seconds how far it is, see `shakedown_limit`.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks, or vertex and side do not meet
        within their errors.

    Examples
    --------
    >>> import frictopt as fo
    >>> bonded = {"P": ([0.0], [2.0]), "Q": ([1.0], [0.0]), "R": ([0.0], [-1.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], bonded)
    >>> region = fo.safe_region(node, {"P": 1.0}, ["Q", "R"], friction=0.5)  # Q <= 0.5 (2 - R)
    >>> region.vertices.round(9).tolist(), region.sides[["a", "b", "bound"]].round(9).values.tolist()
    ([[1.0, 0.0], [0.0, 2.0]], [[1.0, 0.5, 1.0]])
    """
    search = _Search(
        system, mean, loads, friction, finite_number("tolerance", tolerance, above=0.0)
    )
    with bar_of(progress, "safe region", "ray", keeps=search.kept) as bar:
        search.tell = bar.update
        return _region(search)


def _region(search: _Search) -> SafeRegion:
    """The region that a search finds."""
    first, second = search.ray(1.0, 0.0), search.ray(0.0, 1.0)
    if first.limit.open.any() or second.limit.open.any():
        first, second = search.with_one_set(first, second)
    limits = first.limit.load_factor, second.limit.load_factor
    if np.isnan(limits).any():
        found = first if np.isnan(limits[0]) else second
        return search.region([], (), f"no amplitudes are safe: {found.limit.reason}")
    unlimited = tuple(
        name for name, limit in zip(search.names, limits, strict=True) if np.isinf(limit)
    )
    if len(unlimited) == 2:
        return search.region([], unlimited, f"all amplitudes are safe: {first.limit.reason}")
    if unlimited:
        held = second if np.isinf(limits[0]) else first
        # The region is convex and closed: with all amplitudes of one load it holds all that the
        # other one may have alone.
        why = f"the amplitude of {unlimited[0]!r} has no limit: it shears no node beyond its bound"
        return search.region([held], unlimited, why)
    search.unit = np.array([limit or 1.0 for limit in limits])
    why = f"{first.limit._opened}beyond each side its mechanism slips for ever{first.limit._question.pattern}"
    return search.region([first, *search.between(first, second), second], (), why)


@dataclass(frozen=True, eq=False)
class _Point:
    """The end of a ray, which is safe, and the line through it that no safe amplitudes are beyond: `line @ amplitudes <= bound`."""

    at: Array
    limit: ShakedownLimit
    line: Array
    bound: float
    motion: Mechanism

    def beyond(self, at: Array) -> float:
        """By how much a point is beyond the line, over the distance of the line from zero; below zero inside."""
        return float((self.line @ at - self.bound) / (self.bound or 1.0))


class _Search:
    """The rays of one region."""

    def __init__(
        self,
        system: ContactSystem,
        mean: Mapping[str, float],
        loads: Sequence[Any],
        friction: Any,
        tolerance: float,
    ) -> None:
        self._system = checked_system(system)
        self._apart = 0.0 if self._system.tangents == 1 else tolerance
        self._mean = dict(checked_loads("mean", mean))
        self._friction = friction_coefficients(friction, system.nodes)
        pair = listed("loads", loads)
        if len(pair) != 2:
            raise ModelError(
                f"loads: {len(pair)}; give two, each a load case name or a list of corners"
            )
        parts = [_part(f"loads[{number}]", load) for number, load in enumerate(pair)]
        self._parts = parts[0], parts[1]
        names = [
            load if isinstance(load, str) else " ".join(sorted(set[str]().union(*part)))
            for load, part in zip(pair, parts, strict=True)
        ]
        self.names, self.unit, self._started = (names[0], names[1]), np.ones(2), perf_counter()
        self._limits: list[ShakedownLimit] = []
        self._reached: list[tuple[float, float]] = []
        self.tell: Callable[[], object] = lambda: None
        self._open: Booleans | None = None
        cycles = (
            domain(self._mean, self._parts, amplitudes) for amplitudes in ((1.0, 0.0), (0.0, 1.0))
        )
        self._corners = domain(self._mean, self._parts, (1.0, 1.0)).corner_names
        self._unit = [pose(system, cycle, self._friction) for cycle in cycles]

    def ray(self, first: float, second: float) -> _Point:
        """The largest safe amplitudes in the proportion of those given."""
        if len(self._limits) > 2 * _MOST_SIDES:
            advice = (
                "coarsen the contact" if self._system.tangents == 1 else "give a larger tolerance"
            )
            raise SolverError(
                f"safe region: more than {_MOST_SIDES} sides; {advice}, or ask for the limit of each proportion by itself"
            )
        cycle = domain(self._mean, self._parts, (first, second))
        limit = shakedown_limit(self._system, cycle, self._friction, open=self._open)
        self._limits.append(limit)
        reach, bound = limit.load_factor if np.isfinite(limit.load_factor) else 0.0, limit.bound
        if reach <= ZERO_LOAD_FACTOR * limit._question.load_unit:
            reach = bound = 0.0
        self.tell()
        self._reached += [(reach * first, reach * second)] * bool(np.isfinite(limit.load_factor))
        units = [with_open(unit, limit.open) or unit for unit in self._unit]
        motion = self._ruled(limit._motion, units)
        drives = [motion.drive(unit) for unit in units]
        return _Point(
            reach * np.array([first, second]), limit, np.array(drives), float(bound), motion
        )

    def kept(self, _: object) -> tuple[str, object, str] | None:
        """What an interrupt keeps."""
        found = pd.DataFrame(sorted(self._reached), columns=self.names)
        return (
            (
                "table",
                found,
                f"{len(found)} pairs of safe amplitudes, the ends of rays, are in the attribute `table`",
            )
            if len(found)
            else None
        )

    def with_one_set(self, first: _Point, second: _Point) -> tuple[_Point, _Point]:
        """The two ends of the region of one set of open nodes, for which alone it is convex: that of the limit under both loads."""
        sizes = [
            limit.load_factor if 0 < limit.load_factor < np.inf else 1.0
            for limit in (first.limit, second.limit)
        ]
        self._open = self.ray(*sizes).limit.open
        self._limits.clear()
        return self.ray(1.0, 0.0), self.ray(0.0, 1.0)

    def _ruled(self, motion: Mechanism, units: Sequence[Question]) -> Mechanism:
        """The same motions at the corners that rule them where both amplitudes are above zero: a ray of one load alone leaves the other's open."""
        (one, other), f, nodes, moved = (
            units,
            motion.friction,
            np.arange(len(motion.friction)),
            motion.moves,
        )
        r, w, out = one.r1 + other.r1, one.w1 + other.w1, one.open_nodes
        moves, press = np.zeros_like(r), np.zeros((len(r), r[0].size))
        for slip, size in zip(moved, motion.size, strict=True):
            along = np.vstack(
                [slip[:-1], f * size]
            )  # what it opens besides is at the corner of the least pressure
            moves[(-r * along).sum(axis=1).argmax(axis=0), :, nodes] += along.T
        moves[r[:, -1].argmin(axis=0), -1, nodes] += motion.opening.sum(axis=0)
        if one.compliance is None:
            return Mechanism(moves, f)
        moves[:, :, out] = 0.0
        pressed = -(moved.reshape(len(moved), -1) @ one.system.S)[:, -one.system.nodes :][
            :, out
        ].sum(axis=0)  # what keeps open nodes from touching
        press[w.argmin(axis=0), np.flatnonzero(out) + one.system.tangents * one.system.nodes] = (
            pressed.clip(0.0)
        )
        moves = moves - (
            (moves.reshape(len(moves), -1) @ one.system.S + press) @ one.compliance
        ).reshape(moves.shape)
        return Mechanism(moves, f, open=out)

    def between(self, one: _Point, other: _Point) -> list[_Point]:
        """Points of the border between two, as many as its sides need; in space until their lines meet near enough to the chords."""
        corner = self._corner(one, other)
        if (
            corner is one.at
            or corner is other.at
            or beyond_chord(one.at, other.at, corner) < self._apart
        ):
            return []
        middle = self.ray(*np.maximum(corner, 0.0))
        if middle.limit.load_factor >= 1 - _ONE_SIDE:
            return [middle]
        return [*self.between(one, middle), middle, *self.between(middle, other)]

    def _corner(self, one: _Point, other: _Point) -> Array:
        """Where the lines of two neighbours meet: at one of them, where it is on the line of the other."""
        if abs(one.beyond(other.at)) <= _ONE_SIDE:
            return other.at
        if abs(other.beyond(one.at)) <= _ONE_SIDE:
            return one.at
        try:
            return np.asarray(
                self.unit
                * np.linalg.solve(
                    np.array([one.line, other.line]) * self.unit, [one.bound, other.bound]
                )
            )
        except np.linalg.LinAlgError as parallel:
            off = max(abs(one.beyond(other.at)), abs(other.beyond(one.at)))
            raise SolverError(
                f"safe region: its sides and vertices differ by {off:.1e}; check for reactions of very different sizes"
            ) from parallel

    def region(self, points: list[_Point], unlimited: tuple[str, ...], reason: str) -> SafeRegion:
        """The region with these points of the border in their order."""
        free = np.array([name in unlimited for name in self.names])
        ends = (
            [point.at for point in points[:1]]
            + [self._corner(*pair) for pair in pairwise(points)]
            + [point.at for point in points[-1:]]
        )
        sides = list[tuple[Array, Array, _Point]]()
        for (start, end), point in zip(pairwise(ends), points, strict=True):
            if (
                sides
                and max(abs(sides[-1][2].beyond(end)), abs(point.beyond(sides[-1][0]))) <= _ONE_SIDE
            ):  # on the same line
                sides[-1] = sides[-1][0], end, sides[-1][2]
            elif start is not end or free.any():
                sides.append((start, end, point))
        outer = np.reshape(
            [start for start, _, _ in sides] + [end for _, end, _ in sides[-1:]], (-1, 2)
        )
        vertices = np.reshape([point.at for point in points], (-1, 2)) if self._apart else outer
        if free.any():
            vertices = outer = np.where(
                free, np.inf, vertices[0] if len(vertices) else 0.0
            ).reshape(1, 2)
        met = (
            [end for end in ends if not any(end is point.at for point in points)]
            if self._apart
            else []
        )
        gap = max(
            (beyond_chord(one, other, end) for one, other in pairwise(vertices) for end in met),
            default=0.0,
        )
        rows = [
            (*np.where(free, 0.0, of.line) / (of.bound or 1.0), float(of.bound > 0))
            for _, _, of in sides
        ]
        reason += (
            f"; between points and sides, up to {gap:.1e} apart, nothing is said" if gap else ""
        )
        if (
            error := max((abs(of.beyond(end)) for *pair, of in sides for end in pair), default=0.0)
        ) > 2 * _ONE_SIDE:
            raise SolverError(
                f"safe region: its sides and vertices differ by {error:.1e}; check for reactions of very different sizes"
            )
        record, residuals = self._limits[0].record, [point.limit.residual for point in points]
        attempts = tuple(attempt for limit in self._limits for attempt in limit.record.attempts)
        return SafeRegion(
            loads=self.names,
            vertices=frozen(vertices),
            outer=frozen(outer),
            sides=pd.DataFrame(rows, columns=["a", "b", "bound"]),
            mechanisms=tuple(of.motion.table(self._system, self._corners) for _, _, of in sides),
            unlimited=unlimited,
            gap=gap,
            reason=reason,
            record=replace(
                record,
                attempts=attempts,
                residual=max([error, *residuals]),
                seconds=perf_counter() - self._started,
            ),
            _mean=self._mean,
            _parts=self._parts,
        )


def _part(name: str, load: Any) -> list[Mapping[str, float]]:
    """The corners of one load at amplitude 1; zero is in their hull."""
    if isinstance(load, str):
        check_name(name, load)
        return [{load: -1.0}, {load: 1.0}]
    corners = [
        dict(checked_loads(f"{name}[{number}]", corner))
        for number, corner in enumerate(listed(name, load))
    ]
    if not any(corners):
        raise ModelError(
            f"{name}: no corners with a load; give the name of a load case, or a list of corners"
        )
    return [{}, *corners]
