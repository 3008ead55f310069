"""The load factors at which a fatigue parameter reaches a value in every or some state of rest.

If the corners have the same fixed loads, ranges are proportional to the load factor, and stresses
are linear in load factor and slip together. So on one plane of one point each parameter is such a
linear function, or the load factor times one (Smith, Watson and Topper; Fatemi and Socie).

The largest value over all states of rest may fall with the load factor, so that no bisection finds
where it first reaches a value. A program for each plane does. The least value over all states of
rest never falls, if the mean load is a mean of the loads of the corners.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple

import numpy as np
import scipy  # a part of it is imported when it is used

from ...base import Array, worst
from ...contact import StressMap
from ...solve.answer import infeasible
from ...solve.arrays import Arrays
from ...solve.rows import LINEAR
from ...transients.critical_plane import NOT_NEGATIVE, SEARCHED
from ..program.assembled import at_corners, stuck
from ..program.question import Question
from ..program.rest_slips import Rests
from ..program.solution import Solution, solve
from .stress_levels import (
    AGREED,
    GAIN,
    Level,
    Stresses,
    StressLevels,
    stress_terms,
    tensors_at_rest,
)


class Crossing(NamedTuple):
    """A load factor at which a parameter reaches a value, its proven bound, and the slip.

    The load factor is inf if the parameter does not reach the value.
    """

    load_factor: float
    bound: float
    slip: Array  # (N,) or (N, 2)
    residual: float


class Plane(NamedTuple):
    """The function `start + rate * load factor + rates @ slip` of one plane of one point."""

    start: float
    rate: float
    rates: Array  # (t N,)

    def at(self, crossing: Crossing) -> float:
        """The value at a load factor and a slip."""
        added = self.rates @ crossing.slip.T.ravel()
        return float(self.start + self.rate * crossing.load_factor + added)


@dataclass(frozen=True, eq=False)
class StressCrossings:
    """Where a parameter reaches an allowable value > 0 in states of rest at rising load factors.

    `planes`: see `StressLevels`.
    """

    question: Question
    stress_map: StressMap
    name: str
    weight: float
    planes: int
    allowable: float

    def _stresses(self, tensors: Array) -> Stresses:
        return Stresses(self.question, self.stress_map, tensors, self.name, self.weight)

    def levels(self, load_factor: float) -> StressLevels:
        """The ends of the parameter at a load factor."""
        tensors = tensors_at_rest(self.question, self.stress_map, load_factor)
        rests = Rests(self.question, load_factor)
        return StressLevels(rests, self._stresses(tensors), self.planes)

    def _least(self, load_factor: float) -> Level:
        return self.levels(load_factor).least(range(self.stress_map.count))

    def first(self) -> Crossing | None:
        """The least load factor at which some state of rest has the value; None if none has it.

        If planes are searched, the largest value at this load factor is searched, too, and its
        plane is added.
        """
        mean, whole = (tensors_at_rest(self.question, self.stress_map, at) for at in (0.0, 1.0))
        of_whole = self._stresses(whole)
        # The stresses of the mean load with the ranges of load factor 1.
        of_mean = self._stresses(np.stack([mean[:, 0], whole[:, 1]], axis=1))
        queue = list[tuple[float, int, Plane, Crossing]]()
        numbers = count()

        def add(plane: Plane, tangent: float, least: float = 0.0) -> None:
            crossing = self._crossing(plane, tangent, least)
            if np.isfinite(crossing.load_factor):
                heappush(queue, (crossing.load_factor, next(numbers), plane, crossing))

        def add_all(point: int, normals: Array, tangent: float) -> None:
            starts, rates = of_mean.on(point, normals)
            ends, _ = of_whole.on(point, normals)
            for plane in zip(starts, ends - starts, rates, strict=True):
                add(Plane(*plane), tangent)

        levels = self.levels(1.0)
        for point in range(self.stress_map.count):
            add_all(point, levels.planes_of(point), self.question.load_unit)
        while queue:
            load_factor, _, plane, crossing = queue[0]
            level = plane.at(crossing)
            short = load_factor * level < self.allowable * (1 - AGREED)
            if self.name in NOT_NEGATIVE and short:
                # The next tangent of `allowable / load factor` leaves this load factor out.
                heappop(queue)
                add(plane, load_factor or self.allowable / level, load_factor)
                continue
            if self.name in SEARCHED:
                levels = self.levels(load_factor)
                for point in range(self.stress_map.count):
                    end = levels.most(point)
                    if end.value > self.allowable * (1 + AGREED):
                        add_all(point, end.normal[None], load_factor or self.question.load_unit)
            if queue[0][0] >= load_factor * (1 - GAIN):
                return crossing
        return None

    def _crossing(self, plane: Plane, tangent: float, least: float) -> Crossing:
        """The least load factor, from `least` on, at which a plane reaches the value.

        A parameter that is the load factor times the plane's function has a lower bound of it: the
        function reaches the tangent of `allowable / load factor` at the load factor `tangent`.
        """
        value, fall = self.allowable, 0.0
        if self.name in NOT_NEGATIVE:
            value, fall = 2 * value / tangent, value / tangent**2
        program = at_corners(self.question, residual=True)
        program.row("later", {"load_factor": 1.0}, -least)
        by_load = np.array([program.unknown("load_factor")]), np.array([plane.rate + fall])
        terms = [by_load, *stress_terms(program, plane.rates[None])]
        program.add("reached", LINEAR, [terms], np.array([plane.start - value]), np.array([value]))

        def claimed(solution: Solution) -> Crossing:
            bound, error = solution.bound
            load_factor, slip = solution.load_factor, solution.slip_of_nodes
            off = self.question.violation(load_factor, slip)
            return Crossing(load_factor, bound - error, slip, worst([off, solution.gap]))

        def never(outcome: str, arrays: Arrays) -> Crossing | None:
            found = infeasible(arrays)
            nowhere = np.full(self.question.system.slip_shape, np.nan)
            return None if found is None else Crossing(np.inf, np.inf, nowhere, found[1])

        crossing, _ = solve(stuck(program), "load_factor", -1.0, claimed, no_optimum=never)
        return crossing

    def last(self, largest: float) -> Crossing | None:
        """The largest load factor at which some state of rest has at most the value.

        None if it is at least `largest`.
        """

        def above(load_factor: float) -> float:
            return self._least(load_factor).value - self.allowable

        if above(largest) <= 0:
            return None
        load_factor = 0.0
        if above(0.0) < 0:
            load_factor = scipy.optimize.brentq(above, 0.0, largest, xtol=GAIN * largest)
        level = self._least(load_factor)
        for further in 10.0 ** np.arange(-7, 0):
            bound = min(load_factor * (1 + further), largest)
            if self._least(bound).bound > self.allowable:
                break
        else:
            bound = largest
        return Crossing(load_factor, bound, level.slip, level.residual)
