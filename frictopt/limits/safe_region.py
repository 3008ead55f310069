"""The amplitudes of two loads that vary independently at which some residual slip is safe: a polygon, each side of which is a mechanism."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle, friction_coefficients
from ..contact.checks import Array, check_name, checked_loads, finite_number, frozen, listed
from ..contact.record import Recorded, SolveRecord
from ..contact.show import Plotted, frame
from ..contact.system import checked_plane
from ..contact.tolerances import RESIDUAL, ZERO_LOAD_FACTOR
from ..errors import ModelError, SolverError
from .mechanism import Mechanism
from .question import pose
from .reduced import rest_of
from .shakedown import shakedown_limit
from .shakedown_result import ShakedownLimit

__all__ = ["SafeRegion", "safe_region"]

_ONE_SIDE = 10 * RESIDUAL  # a point this close to a line, over the distance of the line from zero, is on it: both have errors up to the residual
_MOST_SIDES = 1000


@dataclass(frozen=True, eq=False, repr=False)
class SafeRegion(Recorded, Plotted):
    """The amplitudes `(a, b)` of two loads at which some residual slip is safe.

    The region is convex, and holds all smaller amplitudes with any that it holds: both loads come back to zero, so that the mean load is in every
    domain, and must be safe. Its border is a chain of straight sides from an amplitude of the first load alone to one of the second load alone.

    Attributes
    ----------
    loads
        Names of the two loads.
    vertices
        (V, 2) amplitudes at the ends of the sides, from the first load alone to the second; inf where there is no limit, empty where none is safe.
    sides
        One row for each side, between vertex and next vertex: columns a, b, bound. Amplitudes are safe if `a * first + b * second <= bound` for all
        sides; a, b and bound are works of the side's mechanism, scaled to `bound = 1` where the mean load has a resistance.
    mechanisms
        For each side, which nodes limit the amplitudes: columns node, x, corner (of `cycle(a, b)`), direction, share, as in `ShakedownLimit`.
    unlimited
        Names of the loads whose amplitude has no limit.
    reason
        Why the region is what it is, in words.
    record
        How it was found. Its `residual` is the largest of: the residuals of the limits at all vertices, and the distance of each side from its two
        vertices, relatively. At most 2e-8.

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
    sides: pd.DataFrame = field(repr=False)
    mechanisms: tuple[pd.DataFrame, ...] = field(repr=False)
    unlimited: tuple[str, ...]
    reason: str
    record: SolveRecord
    _mean: Mapping[str, float] = field(repr=False)
    _parts: tuple[Sequence[Mapping[str, float]], Sequence[Mapping[str, float]]] = field(repr=False)

    def contains(self, first: float, second: float) -> bool:
        """Whether some residual slip is safe at these amplitudes, >= 0.

        Raises
        ------
        ModelError
            Amplitudes that are not finite or negative.
        """
        a, b = finite_number("first", first, least=0.0), finite_number("second", second, least=0.0)
        return bool(len(self.vertices)) and bool((self.sides["a"] * a + self.sides["b"] * b <= self.sides["bound"]).all())

    def cycle(self, first: float, second: float) -> LoadCycle:
        """The vertices of the domain of loads at these amplitudes, as a load cycle for other functions.

        Raises
        ------
        ModelError
            Amplitudes that are not finite or negative.
        """
        amplitudes = finite_number("first", first, least=0.0), finite_number("second", second, least=0.0)
        return _domain(self._mean, self._parts, amplitudes)

    def to_frame(self) -> pd.DataFrame:
        """One row for each vertex: its two amplitudes."""
        return frame({name: self.vertices[:, number] for number, name in enumerate(self.loads)})

    def _answer(self) -> Mapping[str, Any]:
        return {"loads": self.loads, "sides": len(self.sides), "unlimited": self.unlimited, "residual": self.residual, "reason": self.reason}


def safe_region(system: ContactSystem, mean: Mapping[str, float], loads: Sequence[Any], friction: Any) -> SafeRegion:
    """Which amplitudes of two loads that vary independently around a mean load leave a safe residual slip.

    The amplitudes and slips with `abs(q) <= f p` at all nodes for all loads of the domain are a polyhedron, and its shadow on the plane of the two
    amplitudes is a convex polygon. Each shakedown limit along a ray gives a point of its border and, by its mechanism, a straight line that no
    safe amplitudes are beyond. The next ray goes to the point where two neighbouring lines meet: if it is safe, it is a vertex, else its limit gives
    a line between them. So all vertices and sides are found, by one linear program each, and each is proven by its slip and by its mechanism.
    Theory, eq. (17).

    Parameters
    ----------
    system
        The contact.
    mean
        Static load, load case name -> amplitude.
    loads
        The two loads. Each is the name of a load case, which varies between plus and minus its amplitude; or a list of corners at amplitude 1, load
        case name -> amplitude, for a load that varies within their hull and comes back to zero. The two share no load case.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks, or vertex and side do not meet within the tolerance.

    Examples
    --------
    >>> import frictopt as fo
    >>> bonded = {"P": ([0.0], [2.0]), "Q": ([1.0], [0.0]), "R": ([0.0], [-1.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], bonded)
    >>> region = fo.safe_region(node, {"P": 1.0}, ["Q", "R"], friction=0.5)  # Q <= 0.5 (2 - R)
    >>> region.vertices.round(9).tolist()
    [[1.0, 0.0], [0.0, 2.0]]
    >>> region.sides[["a", "b", "bound"]].round(9).values.tolist()
    [[1.0, 0.5, 1.0]]
    """
    search = _Search(system, mean, loads, friction)
    first, second = search.ray(1.0, 0.0), search.ray(0.0, 1.0)
    limits = first.limit.load_factor, second.limit.load_factor
    if np.isnan(limits).any():
        found = first if np.isnan(limits[0]) else second
        return search.region([], (), f"no amplitudes are safe: {found.limit.reason}")
    unlimited = tuple(name for name, limit in zip(search.names, limits, strict=True) if np.isinf(limit))
    if len(unlimited) == 2:
        return search.region([], unlimited, f"all amplitudes are safe: {first.limit.reason}")
    if unlimited:
        held = second if np.isinf(limits[0]) else first
        # The region is convex and closed: with all amplitudes of one load it holds all that the other one may have alone.
        why = f"the amplitude of {unlimited[0]!r} has no limit: it shears no node beyond its bound"
        return search.region([_Side(held, held, held)], unlimited, why)
    search.unit = np.array([limit or 1.0 for limit in limits])
    return search.region(_merged(search.between(first, second)), (), "beyond each side its mechanism slips for ever")


@dataclass(frozen=True, eq=False)
class _Point:
    """The end of a ray, and the line through it that no safe amplitudes are beyond: `line @ amplitudes <= bound`."""

    limit: ShakedownLimit
    at: Array
    line: Array
    bound: float
    motion: Mechanism

    def beyond(self, at: Array) -> float:
        """By how much a point is beyond the line, over the distance of the line from zero; below zero inside."""
        return float((self.line @ at - self.bound) / (self.bound or 1.0))


@dataclass(frozen=True, eq=False)
class _Side:
    """A side from the point `start` to the point `end`, both safe, on the line of `of`."""

    start: _Point
    end: _Point
    of: _Point


class _Search:
    """The rays of one region."""

    def __init__(self, system: ContactSystem, mean: Mapping[str, float], loads: Sequence[Any], friction: Any) -> None:
        self._system = checked_plane(system, "ask shakedown_limit for each proportion of the two loads")
        self._mean = dict(checked_loads("mean", mean))
        self._friction = friction_coefficients(friction, system.nodes)
        pair = listed("loads", loads)
        if len(pair) != 2:
            raise ModelError(f"loads: {len(pair)}; give two, each a load case name or a list of corners")
        parts = [_part(f"loads[{number}]", load) for number, load in enumerate(pair)]
        self._parts = parts[0], parts[1]
        names = [load if isinstance(load, str) else " ".join(sorted(set[str]().union(*part))) for load, part in zip(pair, parts, strict=True)]
        self.names, self.unit, self._started = (names[0], names[1]), np.ones(2), perf_counter()
        self._limits: list[ShakedownLimit] = []
        domains = (_domain(self._mean, self._parts, amplitudes) for amplitudes in ((1.0, 0.0), (0.0, 1.0)))
        self._corners = _domain(self._mean, self._parts, (1.0, 1.0)).corner_names
        self._unit = [pose(system, domain, self._friction) for domain in domains]  # of the closed nodes, once a limit tells which are open

    def ray(self, first: float, second: float) -> _Point:
        """The largest safe amplitudes in the proportion of those given."""
        if len(self._limits) > 2 * _MOST_SIDES:
            raise SolverError(f"safe region: more than {_MOST_SIDES} sides; coarsen the contact, or ask for the limit of each proportion by itself")
        cycle = _domain(self._mean, self._parts, (first, second))
        limit = shakedown_limit(self._system, cycle, self._friction)
        self._limits.append(limit)
        reach, bound = limit.load_factor if np.isfinite(limit.load_factor) else 0.0, limit.bound
        if limit.open.any() and self._unit[0].whole is None:
            self._unit = [rest for task in self._unit if (rest := rest_of(task, limit.open))]
        nodes = limit._task.open
        if reach <= ZERO_LOAD_FACTOR * limit._task.load_unit:
            reach = bound = 0.0
        motion = self._ruled(limit._motion if nodes is None else nodes.closed_part(limit._motion, self._system))
        drives = [unit.work(motion)[1] for unit in self._unit]
        motion = motion if nodes is None else nodes.expanded(motion, self._friction)
        return _Point(limit, reach * np.array([first, second]), np.array(drives), float(bound), motion)

    def _ruled(self, motion: Mechanism) -> Mechanism:
        """The same motions at the corners that rule them where both amplitudes are above zero: a ray of one load alone leaves the other's open."""
        (one, other), f, nodes = (unit.loads for unit in self._unit), motion.friction, np.arange(len(motion.friction))
        q, p, w = one.q1 + other.q1, one.p1 + other.p1, one.w1 + other.w1
        forward, backward, opening, press = (np.zeros_like(part) for part in (q, q, q, w))
        forward[(-(q + f * p)).argmax(axis=0), nodes] = np.maximum(motion.slips, 0.0).sum(axis=0)
        backward[(q - f * p).argmax(axis=0), nodes] = np.maximum(-motion.slips, 0.0).sum(axis=0)
        opening[(-p).argmax(axis=0), nodes] = motion.opening.sum(axis=0)
        press[w.argmin(axis=0), np.arange(w.shape[1])] = 0.0 if motion.press is None else motion.press.sum(axis=0)
        return Mechanism(forward - backward, opening + 2 * f * np.minimum(forward, backward), f, press=press)

    def between(self, one: _Point, other: _Point) -> list[_Side]:
        """The sides between two points of the border."""
        if abs(one.beyond(other.at)) <= _ONE_SIDE:
            return [_Side(one, other, one)]
        if abs(other.beyond(one.at)) <= _ONE_SIDE:
            return [_Side(one, other, other)]
        lines = np.array([one.line, other.line]) * self.unit
        corner = self.unit * np.linalg.solve(lines, [one.bound, other.bound])
        middle = self.ray(*np.maximum(corner, 0.0))
        if middle.limit.load_factor >= 1 - _ONE_SIDE:
            return [_Side(one, middle, one), _Side(middle, other, other)]
        return self.between(one, middle) + self.between(middle, other)

    def region(self, sides: list[_Side], unlimited: tuple[str, ...], reason: str) -> SafeRegion:
        """The region with these sides."""
        free = np.array([name in unlimited for name in self.names])
        points = [side.start for side in sides] + [side.end for side in sides[-1:]]
        vertices = [np.where(free, np.inf, point.at) for point in ([] if free.all() else points[:1] if free.any() else points)]
        if free.all():
            vertices = [np.full(2, np.inf)]
        rows = [(*np.where(free, 0.0, side.of.line) / (side.of.bound or 1.0), float(side.of.bound > 0)) for side in sides]
        errors = [abs(side.of.beyond(point.at)) for side in sides for point in (side.start, side.end)]
        residual = max((point.limit.residual for point in points), default=0.0)
        if (error := max(errors, default=0.0)) > 2 * _ONE_SIDE:
            raise SolverError(f"safe region: its sides and vertices differ by {error:.1e}; check for reactions of very different sizes")
        attempts = tuple(attempt for limit in self._limits for attempt in limit.record.attempts)
        seconds = perf_counter() - self._started
        return SafeRegion(
            loads=self.names,
            vertices=frozen(np.reshape(vertices, (-1, 2))),
            sides=pd.DataFrame(rows, columns=["a", "b", "bound"]),
            mechanisms=tuple(side.of.motion.table(self._system, self._corners) for side in sides),
            unlimited=unlimited,
            reason=reason,
            record=SolveRecord(self._limits[0].record.solver, attempts, max(residual, error), self._limits[0].record.left_out, seconds),
            _mean=self._mean,
            _parts=self._parts,
        )


def _part(name: str, load: Any) -> list[Mapping[str, float]]:
    """The corners of one load at amplitude 1; zero is in their hull."""
    if isinstance(load, str):
        check_name(name, load)
        return [{load: -1.0}, {load: 1.0}]
    corners = [dict(checked_loads(f"{name}[{number}]", corner)) for number, corner in enumerate(listed(name, load))]
    if not any(corners):
        raise ModelError(f"{name}: no corners with a load; give the name of a load case, or a list of corners")
    return [{}, *corners]


def _domain(mean: Mapping[str, float], parts: tuple[Sequence[Mapping[str, float]], ...], amplitudes: tuple[float, float]) -> LoadCycle:
    scaled = [
        [{case: factor * amplitude for case, amplitude in corner.items()} for corner in part] for factor, part in zip(amplitudes, parts, strict=True)
    ]
    return LoadCycle.vertices(mean, *scaled)


def _merged(sides: list[_Side]) -> list[_Side]:
    """Sides in a row that share a line are one, and those between the same two points are none."""
    merged: list[_Side] = []
    for side in sides:
        if merged and max(abs(merged[-1].of.beyond(side.end.at)), abs(side.of.beyond(merged[-1].start.at))) <= _ONE_SIDE:
            merged[-1] = _Side(merged[-1].start, side.end, merged[-1].of)
        else:
            merged.append(side)
    return merged
