"""Rays of a safe region: shakedown limits of two loads in a fixed ratio of their amplitudes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from ..base import (
    ZERO_LOAD_FACTOR,
    Array,
    Bar,
    Booleans,
    Table,
    checked_loads,
    frame,
    listed,
    number_of,
)
from ..base.checks import check_name
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError, SolverError
from .mechanism import Mechanism
from .question import Question, pose, with_open
from .shakedown import ShakedownLimit, ShakedownLimits

_MANY_SIDES = (
    "safe region: more than {most} sides; {advice}, or compute the limit of each ratio of the "
    "amplitudes separately"
)

# The corners of each of two loads, at amplitude 1.
Corners: TypeAlias = tuple[Sequence[Mapping[str, float]], Sequence[Mapping[str, float]]]


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
    limits, reached
        The limits of all rays, and the pairs of safe amplitudes at their ends.
    """

    system: ContactSystem
    mean: Mapping[str, float]
    friction: Array
    names: tuple[str, str]
    parts: Corners
    bar: Bar
    open_nodes: Booleans | None = None
    limits: list[ShakedownLimit] = field(default_factory=list)
    reached: list[tuple[float, float]] = field(default_factory=list)

    @cached_property
    def _of_unit_loads(self) -> list[Question]:
        """The questions of each load alone at amplitude 1, with all nodes closed."""
        cycles = [domain(self.mean, self.parts, unit) for unit in ((1.0, 0.0), (0.0, 1.0))]
        return [pose(self.system, cycle, self.friction) for cycle in cycles]

    def to(self, first: float, second: float) -> BorderPoint:
        """The largest safe amplitudes in the ratio `first : second`, with their line."""
        most_sides = 1000
        if len(self.limits) > 2 * most_sides:
            plane = self.system.tangents == 1
            advice = "coarsen the contact" if plane else "give a larger tolerance"
            raise SolverError(_MANY_SIDES.format(most=most_sides, advice=advice))
        limit = self._limit(domain(self.mean, self.parts, (first, second)))
        self.limits.append(limit)
        self.bar.update()

        reach = 0.0
        bound = limit.bound
        if np.isfinite(limit.load_factor):
            reach = limit.load_factor
        if reach <= ZERO_LOAD_FACTOR * limit._question.load_unit:
            reach = 0.0
            bound = 0.0
        if np.isfinite(limit.load_factor):
            self.reached.append((reach * first, reach * second))
            pairs = number_of(len(self.reached), "pair")
            note = f"the attribute `table` has {pairs} of safe amplitudes, the ends of rays"
            self.bar.keep("table", self._table, note)

        units = [with_open(unit, limit.open) or unit for unit in self._of_unit_loads]
        motion = _at_governing_corners(limit._motion, units)
        line = np.array([motion.drive(unit) for unit in units])
        return BorderPoint(reach * np.array([first, second]), limit, line, float(bound), motion)

    def _limit(self, cycle: LoadCycle) -> ShakedownLimit:
        """The limit with the open nodes of all rays, or of the best set.

        Nodes that open and close have other mechanisms, whose lines do not bound a region.
        """
        question = pose(self.system, cycle, self.friction, question_name="shakedown_limit")
        limits = ShakedownLimits()
        if self.open_nodes is None:
            return limits.of_any_set(question)
        return limits.of_question(question, self.open_nodes, events=False)

    def along_axes(self) -> tuple[BorderPoint, BorderPoint]:
        """The ends of the rays of each load alone."""
        return self.to(1.0, 0.0), self.to(0.0, 1.0)

    def with_one_set(self, first: BorderPoint, second: BorderPoint) -> Rays:
        """New rays, with the open nodes of the limit under both loads.

        The region is convex only for one set of open nodes. `first` and `second` are the ends of
        the rays of each load alone.
        """
        amplitudes = [1.0, 1.0]
        for number, point in enumerate((first, second)):
            if 0 < point.limit.load_factor < np.inf:
                amplitudes[number] = point.limit.load_factor
        both = self.to(*amplitudes)
        return replace(self, open_nodes=both.limit.open, limits=[])

    def _table(self) -> Table:
        """The safe amplitudes at the ends of the rays."""
        return frame(sorted(self.reached), names=list(self.names))


def checked_parts(loads: Sequence[Any]) -> tuple[tuple[str, str], Corners]:
    """Names and corners of the two loads of a region."""
    pair = listed("loads", loads)
    if len(pair) != 2:
        raise ModelError(
            f"loads: {len(pair)}; give two, each a load case name or a list of corners"
        )
    first, second = (_checked_part(f"loads[{number}]", load) for number, load in enumerate(pair))
    return (first[0], second[0]), (first[1], second[1])


def _checked_part(argument: str, load: Any) -> tuple[str, list[Mapping[str, float]]]:
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


def domain(mean: Mapping[str, float], parts: Corners, amplitudes: tuple[float, float]) -> LoadCycle:
    """Cycle through the vertices of the domain: each load varies within its hull, on the mean."""
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
        narrowest = (first.w1 + second.w1).argmin(axis=0)
        moves[:, :, opened] = 0.0
        moves[narrowest, -1, opened] = touching.clip(0.0)
    return Mechanism.of(first, moves.reshape(len(moves), -1))
