"""The amplitudes of two loads at which some residual slip is safe, between two polygons.

The loads vary independently. The vertices of the inner polygon are the ends of rays (`Rays`). The
limit at each end has a mechanism, whose line is a side of the outer polygon.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from time import perf_counter
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from ..base import (
    RESIDUAL,
    ZERO_LOAD_FACTOR,
    Array,
    Bar,
    Booleans,
    Loads,
    PerNode,
    Plotted,
    Recorded,
    SolveRecord,
    Table,
    checked_loads,
    finite_number,
    frame,
    listed,
    progress_bar,
    warns_of_odd_values,
)
from ..base.checks import check_name
from ..contact import ContactSystem, LoadCycle, checked_system, friction_coefficients
from ..errors import ModelError, SolverError
from .answers.sentences import (
    ALL_AMPLITUDES,
    GAP_OF_SIDES,
    NO_AMPLITUDES,
    NO_AMPLITUDES_ABOVE_ZERO,
    ONE_UNLIMITED,
    SIDES,
)
from .program.question import Question, pose, with_open
from .program.solution import Mechanism
from .shakedown import ShakedownLimit, limit_of_any_set, limit_of_question

# The corners of each of two loads, at amplitude 1.
Corners: TypeAlias = tuple[Sequence[Loads], Sequence[Loads]]


# One file because the rays span the region.


@dataclass(frozen=True, eq=False)
class BorderPoint:
    """The end of a ray, which is safe, and a line through it with no safe amplitudes beyond it.

    All safe amplitudes obey `line @ amplitudes <= bound`.
    """

    amplitudes: Array  # (2,)
    limit: ShakedownLimit
    line: Array  # (2,)
    bound: float
    motion: Mechanism

    def excess(self, amplitudes: Array) -> float:
        """Distance beyond the line, relative to the line's distance from zero; < 0 inside."""
        return float((self.line @ amplitudes - self.bound) / (self.bound or 1.0))


@dataclass(eq=False)
class Rays:
    """The rays of one region, and the amplitudes that they have reached.

    Attributes
    ----------
    system, mean, friction
        The contact, its static load, and friction (N,).
    names, parts
        Names and corners of the two loads.
    bar
        Counts the rays. An interrupt keeps the safe amplitudes at their ends.
    open_nodes
        (N,) mask of the nodes that are open in all limits; None: each limit searches them.
    ends
        The ends of all rays so far.
    """

    system: ContactSystem
    mean: Loads
    friction: Array
    names: tuple[str, str]
    parts: Corners
    bar: Bar
    open_nodes: Booleans | None = None
    ends: list[BorderPoint] = field(default_factory=list)

    @cached_property
    def _of_unit_loads(self) -> list[Question]:
        """The questions of each load alone at amplitude 1, with all nodes closed."""
        cycles = [domain(self.mean, self.parts, unit) for unit in ((1.0, 0.0), (0.0, 1.0))]
        return [pose(self.system, cycle, self.friction) for cycle in cycles]

    def to(self, first: float, second: float) -> BorderPoint:
        """The largest safe amplitudes in the ratio `first : second`, with their line."""
        most_sides = 1000
        if len(self.ends) > 2 * most_sides:
            plane = self.system.tangents == 1
            advice = "coarsen the contact" if plane else "give a larger tolerance"
            raise SolverError(
                f"safe region: more than {most_sides} sides; {advice}, or compute the limit of "
                "each ratio of the amplitudes separately"
            )
        limit = self._limit(domain(self.mean, self.parts, (first, second)))
        self.bar.update()

        reach, bound = limit.load_factor, limit.bound
        if not ZERO_LOAD_FACTOR * limit._question.load_unit < reach < np.inf:
            reach = 0.0
            bound = 0.0
        units = [with_open(unit, limit.open) or unit for unit in self._of_unit_loads]
        motion = _at_governing_corners(limit._motion, units)
        line = np.array([motion.drive(unit) for unit in units])
        end = BorderPoint(reach * np.array([first, second]), limit, line, float(bound), motion)
        self.ends.append(end)
        note = "the attribute `table` has the safe amplitudes at the ends of rays"
        self.bar.keep("table", self._table, note)
        return end

    def _limit(self, cycle: LoadCycle) -> ShakedownLimit:
        """The limit with the open nodes of all rays or, before these are known, with the best set.

        Nodes that open and close have other mechanisms, whose lines do not bound a region.
        """
        question = pose(self.system, cycle, self.friction)
        if self.open_nodes is None:
            return limit_of_any_set(question)
        return limit_of_question(question, self.open_nodes, events=False)

    def along_axes(self) -> tuple[BorderPoint, BorderPoint]:
        """The ends of the rays of each load alone."""
        return self.to(1.0, 0.0), self.to(0.0, 1.0)

    def keep_one_set(self, first: BorderPoint, second: BorderPoint) -> None:
        """Give all further rays the open nodes of the limit under both loads.

        The region is convex only for one set of open nodes. `first` and `second` are the ends of
        the rays of each load alone.
        """
        amplitudes = [1.0, 1.0]
        for number, point in enumerate((first, second)):
            if 0 < point.limit.load_factor < np.inf:
                amplitudes[number] = point.limit.load_factor
        self.open_nodes = self.to(*amplitudes).limit.open

    def _table(self) -> Table:
        """The safe amplitudes at the ends of the rays."""
        safe = [end.amplitudes for end in self.ends if np.isfinite(end.limit.load_factor)]
        return frame(sorted(map(tuple, safe)), names=list(self.names))


def checked_parts(loads: Sequence[Any]) -> tuple[tuple[str, str], Corners]:
    """Names and corners of the two loads of a region."""
    pair = listed("loads", loads)
    if len(pair) != 2:
        raise ModelError(
            f"loads: {len(pair)}; give two, each a load case name or a list of corners"
        )
    first, second = (_checked_part(f"loads[{number}]", load) for number, load in enumerate(pair))
    return (first[0], second[0]), (first[1], second[1])


def _checked_part(argument: str, load: Any) -> tuple[str, list[Loads]]:
    """Name of one load, and its corners at amplitude 1. Their hull contains zero."""
    if isinstance(load, str):
        check_name(argument, load)
        return load, [{load: -1.0}, {load: 1.0}]
    corners = [
        dict(checked_loads(f"{argument}[{number}]", corner))
        for number, corner in enumerate(listed(argument, load))
    ]
    if not any(corners):
        raise ModelError(
            f"{argument}: no corners with a load; give the name of a load case, or a list of "
            "corners"
        )
    cases = set[str]().union(*corners)
    return " ".join(sorted(cases)), [{}, *corners]


def domain(mean: Loads, parts: Corners, amplitudes: tuple[float, float]) -> LoadCycle:
    """Cycle through the vertices of the domain, in which each load varies within its hull."""
    scaled = [
        [{case: factor * amplitude for case, amplitude in corner.items()} for corner in part]
        for factor, part in zip(amplitudes, parts, strict=True)
    ]
    return LoadCycle.vertices(mean, *scaled)


def _at_governing_corners(motion: Mechanism, units: Sequence[Question]) -> Mechanism:
    """The mechanism with each motion at the corner that drives it most if both loads act.

    A ray of one load alone does not determine the corners of the other load.
    """
    first, second = units
    n = first.system.nodes
    nodes = np.arange(n)
    r1 = first.r1 + second.r1  # (K, t + 1, N)
    moves = np.zeros_like(r1)
    for slip, size in zip(motion.moves, motion.size, strict=True):
        along = np.vstack([slip[:-1], motion.friction * size])  # (t + 1, N) slip, and its lift
        corner = (-r1 * along).sum(axis=1).argmax(axis=0)
        moves[corner, :, nodes] += along.T
    # Nodes that open without slip do so at the corner of the least pressure.
    least_pressed = r1[:, -1].argmin(axis=0)
    moves[least_pressed, -1, nodes] += motion.opening.sum(axis=0)
    if first.compliance is not None:
        # Open nodes follow without force, except for forces that keep them from touching.
        opened = np.flatnonzero(first.open_nodes)
        forces = motion.moves.reshape(len(motion.moves), -1) @ first.system.S
        touching = -forces[:, -n:][:, opened].sum(axis=0)
        narrowest = (first.rate + second.rate)[:, -n:][:, opened].argmin(axis=0)
        moves[:, :, opened] = 0.0
        moves[narrowest, -1, opened] = touching.clip(0.0)
    return Mechanism.of(first, moves.reshape(len(moves), -1))


# A point is on a line if its distance from the line is at most this share of the line's distance
# from zero: point and line have errors up to the residual.
_ON_LINE = 10 * RESIDUAL

_DIFFER = (
    "safe region: its sides and vertices differ by {error:.1e}; check for reactions of very "
    "different sizes"
)


@dataclass(frozen=True, eq=False, repr=False)
class SafeRegion(Recorded, Plotted):
    """The amplitudes `(a, b)` of two loads at which some residual slip is safe.

    The region is convex. If it contains a pair of amplitudes, it contains all pairs of smaller
    amplitudes, because both loads return to zero. The mean load is in every domain of loads, and
    must be safe. The border leads from an amplitude of only the first load to an amplitude of only
    the second load. In the plane it has straight sides. In space it is a curve between two
    polygons: `vertices` are proven safe, and `outer` follows from mechanisms.

    Attributes
    ----------
    loads, unlimited
        Names of the two loads, and names of the loads whose amplitude has no limit.
    vertices
        (V, 2) amplitudes on the border, each proven safe. The first row has only the first load,
        the last row only the second load. An amplitude without a limit is inf. Empty if no
        amplitudes are safe. All amplitudes in the polygon of the vertices are also safe.
    outer
        (W, 2) amplitudes at the ends of the sides; in the plane they equal `vertices`.
    sides
        One row for each side, between two points of `outer`: columns a, b, bound. No amplitudes are
        safe with `a * first + b * second > bound`. `a` and `b` are the works of the two loads, at
        unit amplitude, on the mechanism of the side. `bound` is the work that is needed to move the
        mechanism under the mean load. The three are scaled to `bound = 1`, unless `bound` is 0.
    gap
        Largest distance between the two polygons, along rays from zero and relative to the length
        of the ray: 0 in the plane, at most the tolerance in space.
    mechanisms
        For each side, a table of the nodes that limit the amplitudes, as in
        `ShakedownLimit.mechanism`, with the corners of `cycle(a, b)`.
    reason
        Explanation of the region in words.
    record
        Solver, attempts and time. Its `residual`, at most 2e-8, is the larger of two errors: the
        largest residual of a limit at a vertex, and the largest relative distance of a vertex from
        its side.

    Examples
    --------
    >>> import frictopt as fo
    >>> bonded = {"P": ([0.0], [2.0]), "Q": ([1.0], [0.0]), "R": ([0.0], [-1.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], bonded)
    >>> region = fo.safe_region(node, {"P": 1.0}, ["Q", "R"], friction=0.5)
    >>> region.contains(0.5, 0.9), region.contains(0.5, 1.1)
    (True, False)
    """

    loads: tuple[str, str]
    vertices: Array
    outer: Array = field(repr=False)
    sides: Table = field(repr=False)
    mechanisms: tuple[Table, ...] = field(repr=False)
    unlimited: tuple[str, ...]
    gap: float
    reason: str
    record: SolveRecord
    _mean: Loads = field(repr=False)
    _parts: Corners = field(repr=False)

    def contains(self, first: float, second: float) -> bool:
        """Whether some slip is proven safe at these amplitudes: they are in the inner polygon.

        ModelError if an amplitude is not finite or negative.
        """
        amplitudes = np.array(_checked_amplitudes(first, second))
        for start, end in pairwise(self.vertices):
            across = _outward(start, end)
            if across @ amplitudes > across @ start:
                return False
        return bool((amplitudes <= self.vertices.max(axis=0, initial=-1.0)).all())

    def cycle(self, first: float, second: float) -> LoadCycle:
        """Load cycle through the vertices of the domain of loads, for other functions.

        ModelError if an amplitude is not finite or negative.
        """
        return domain(self._mean, self._parts, _checked_amplitudes(first, second))

    def to_frame(self) -> Table:
        """A row for each vertex: its two amplitudes."""
        return frame({name: self.vertices[:, number] for number, name in enumerate(self.loads)})

    def _answer(self) -> Mapping[str, object]:
        answer: dict[str, object] = {
            "loads": self.loads,
            "sides": len(self.sides),
            "unlimited": self.unlimited,
        }
        if self.gap:
            answer["gap"] = self.gap
        return answer | {"residual": self.residual, "reason": self.reason}


def _checked_amplitudes(first: float, second: float) -> tuple[float, float]:
    return finite_number("first", first, least=0.0), finite_number("second", second, least=0.0)


@warns_of_odd_values
def safe_region(
    system: ContactSystem,
    mean: Loads,
    loads: Sequence[Any],
    friction: PerNode,
    *,
    tolerance: float = 1e-3,
    progress: bool = True,
) -> SafeRegion:
    """Amplitudes of two independent loads for which a safe residual slip exists.

    The amplitudes and slips that are safe for all loads of the domain are a convex set. So is the
    safe region, the projection of this set on the two amplitudes. Each shakedown limit along a ray
    gives a point of the border. The mechanism of the limit gives a straight line beyond which no
    amplitudes are safe. The next ray leads to the point where two neighbouring lines meet. If this
    point is safe, it is a vertex; otherwise the limit along the ray gives a new line between the
    two lines. In the plane all vertices and sides are found, with one linear program each. In space
    the border is curved, and each ray needs a cone program. Rays are added until the polygons of
    points and of lines agree within the tolerance. Theory, eq. (17).

    If nodes stay open, the region holds for the open nodes of the limit under both loads. With
    other open nodes, larger amplitudes may be safe. Ctrl-C raises KeyboardInterrupt with an
    attribute `table`, the safe amplitudes found so far.

    Parameters
    ----------
    system, friction
        See `shakedown_limit`.
    mean
        Static load, load case name -> amplitude.
    loads
        The two loads. Each is the name of a load case, which varies between plus and minus its
        amplitude, or a list of corners at amplitude 1 (load case name -> amplitude): such a load
        varies within the hull of its corners and zero. The two loads have no load case in common.
    tolerance
        In space the largest `SafeRegion.gap`; in the plane the gap is 0.
    progress
        Whether to show the progress after two seconds, see `shakedown_limit`.

    Returns
    -------
    SafeRegion
        The vertices of the region, and the mechanism of each side.

    Raises
    ------
    ModelError, SolverError
        Bad input; no solver gave an answer that passes the checks; the distance of a vertex from
        its side exceeds their errors.

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
    started = perf_counter()
    checked_system(system)
    names, parts = checked_parts(loads)
    static = dict(checked_loads("mean", mean))
    coefficients = friction_coefficients(friction, system)
    tolerance = finite_number("tolerance", tolerance, above=0.0)
    if system.tangents == 1:
        tolerance = 0.0
    with progress_bar(progress, "safe region", "ray") as bar:
        rays = Rays(system, static, coefficients, names, parts, bar)
        first, second = rays.along_axes()
        if (first.limit.open | second.limit.open).any():
            rays.keep_one_set(first, second)
            first, second = rays.along_axes()
        points, unlimited, reason = _border(rays, first, second, tolerance)
        return _region(rays, points, unlimited, reason, started)


def _border(
    rays: Rays, first: BorderPoint, second: BorderPoint, tolerance: float
) -> tuple[list[BorderPoint], tuple[str, ...], str]:
    """The border between the ends of the rays of each load alone.

    Returned are its points, the loads without a limit, and the reason. The border has no points if
    no amplitudes are safe or all are safe, and one point if one load is unlimited.
    """
    for point in (first, second):
        if np.isnan(point.limit.load_factor):
            return [], (), NO_AMPLITUDES.format(limit=point.limit.reason)
    if np.isinf(first.limit.load_factor) and np.isinf(second.limit.load_factor):
        return [], rays.names, ALL_AMPLITUDES.format(limit=first.limit.reason)

    # If one load is unlimited, the other one has the limit that it has alone: the region is convex
    # and closed.
    for load, point, limited in zip(rays.names, (first, second), (second, first), strict=True):
        if np.isinf(point.limit.load_factor):
            return [limited], (load,), ONE_UNLIMITED.format(load=load)

    points = [first, *_points_between(rays, first, second, tolerance), second]
    limit = first.limit
    reason = SIDES.format(opened=limit._opened, node_states=limit._question.node_states)
    if first.limit.load_factor == 0 and second.limit.load_factor == 0:
        reason = NO_AMPLITUDES_ABOVE_ZERO.format(limit=limit.reason)
    return points, (), reason


def _points_between(
    rays: Rays, left: BorderPoint, right: BorderPoint, tolerance: float
) -> list[BorderPoint]:
    """Points of the border between two points, one for each side between them.

    In space points are added until neighbouring lines meet close to the chord of their points.
    """
    corner = meeting_point(left, right)
    if corner is left.amplitudes or corner is right.amplitudes:
        return []
    if beyond_chord(left.amplitudes, right.amplitudes, corner) < tolerance:
        return []
    first, second = np.maximum(corner, 0.0)
    middle = rays.to(first, second)
    if middle.limit.load_factor >= 1 - _ON_LINE:
        return [middle]
    return [
        *_points_between(rays, left, middle, tolerance),
        middle,
        *_points_between(rays, middle, right, tolerance),
    ]


def meeting_point(left: BorderPoint, right: BorderPoint) -> Array:
    """The point where the lines of two neighbours meet.

    If the point of one neighbour is on the line of the other, the same array of this point is
    returned, so that callers can compare by `is`.
    """
    left_off = left.excess(right.amplitudes)
    right_off = right.excess(left.amplitudes)
    if abs(left_off) <= _ON_LINE:
        return right.amplitudes
    if abs(right_off) <= _ON_LINE:
        return left.amplitudes
    try:
        return np.asarray(np.linalg.solve([left.line, right.line], [left.bound, right.bound]))
    except np.linalg.LinAlgError as parallel:
        error = max(abs(left_off), abs(right_off))
        raise SolverError(_DIFFER.format(error=error)) from parallel


def _outward(start: Array, end: Array) -> Array:
    """A vector across the chord of two points of the border, away from zero."""
    return np.array([end[1] - start[1], start[0] - end[0]])


def beyond_chord(start: Array, end: Array, amplitudes: Array) -> float:
    """Distance of amplitudes beyond a chord, along their ray, divided by their length."""
    across = _outward(start, end)
    return float(1 - across @ start / (across @ amplitudes))


class Side(NamedTuple):
    """A side of the outer polygon, on the line of a point of the border."""

    start: Array  # (2,)
    end: Array  # (2,)
    point: BorderPoint


def _region(
    rays: Rays,
    points: Sequence[BorderPoint],
    no_limit: tuple[str, ...],
    reason: str,
    started: float,
) -> SafeRegion:
    """The region of a border."""
    meeting = [meeting_point(left, right) for left, right in pairwise(points)]
    sides = _sides(points, meeting, bool(no_limit))
    error = _checked_error(sides)
    unlimited = np.array([name in no_limit for name in rays.names])
    outer = np.reshape(
        [*(side.start for side in sides), *(side.end for side in sides[-1:])], (-1, 2)
    )
    vertices = outer
    gap = 0.0
    if rays.system.tangents > 1:
        vertices = np.reshape([point.amplitudes for point in points], (-1, 2))
        gap = _largest_gap(points, meeting)
    if unlimited.any():
        vertices = outer = _half_plane(vertices, unlimited)
    if gap > 0:
        reason += GAP_OF_SIDES.format(gap=gap)
    corners = domain(rays.mean, rays.parts, (1.0, 1.0)).corner_names
    record, *others = (end.limit.record for end in rays.ends)
    return SafeRegion(
        loads=rays.names,
        vertices=vertices,
        outer=outer,
        sides=_table(sides, unlimited),
        mechanisms=tuple(side.point.motion.table(rays.system, corners) for side in sides),
        unlimited=no_limit,
        gap=gap,
        reason=reason,
        record=replace(
            record.joined(others, started),
            residual=max([error, *(point.limit.residual for point in points)]),
        ),
        _mean=rays.mean,
        _parts=rays.parts,
    )


def _checked_error(sides: Sequence[Side]) -> float:
    """Largest distance of a vertex from the line of its side; SolverError if it is too large.

    Distances are relative to the distances of the lines from zero.
    """
    off = [side.point.excess(end) for side in sides for end in (side.start, side.end)]
    error = max(map(abs, off), default=0.0)
    if error > 2 * _ON_LINE:
        raise SolverError(_DIFFER.format(error=error))
    return error


def _half_plane(vertices: Array, unlimited: Booleans) -> Array:
    """(1, 2) the limited amplitude, and inf for a load without a limit."""
    limited = vertices[0] if len(vertices) else np.zeros(2)
    return np.where(unlimited, np.inf, limited).reshape(1, 2)


def _table(sides: Sequence[Side], unlimited: Booleans) -> Table:
    """See `SafeRegion.sides`."""
    rows: list[tuple[float, float, float]] = []
    for side in sides:
        bound = side.point.bound
        a, b = np.where(unlimited, 0.0, side.point.line) / (bound or 1.0)
        rows.append((a, b, float(bound > 0)))
    return frame(rows, names=["a", "b", "bound"])


def _sides(points: Sequence[BorderPoint], meeting: Sequence[Array], unlimited: bool) -> list[Side]:
    """The sides between the ends of the border and the meeting points of neighbouring lines.

    Sides on the same line are joined. A side without length counts only if one load is unlimited.
    """
    sides: list[Side] = []
    ends = [
        *(point.amplitudes for point in points[:1]),
        *meeting,
        *(point.amplitudes for point in points[-1:]),
    ]
    for (start, end), point in zip(pairwise(ends), points, strict=True):
        last = sides[-1] if sides else None
        if last and max(abs(last.point.excess(end)), abs(point.excess(last.start))) <= _ON_LINE:
            sides[-1] = last._replace(end=end)
        elif start is not end or unlimited:
            sides.append(Side(start, end, point))
    return sides


def _largest_gap(points: Sequence[BorderPoint], meeting: Sequence[Array]) -> float:
    """Largest distance of a meeting point beyond the chord of its neighbours, see `SafeRegion`."""
    gap = 0.0
    for (left, right), end in zip(pairwise(points), meeting, strict=True):
        if end is not left.amplitudes and end is not right.amplitudes:
            gap = max(gap, beyond_chord(left.amplitudes, right.amplitudes, end))
    return gap
