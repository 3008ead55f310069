"""The load factors at which a fatigue parameter reaches a value in every or some state of rest.

If the corners have the same fixed loads, ranges are proportional to the load factor, and stresses
are linear in load factor and slip together. So on one plane of one point each parameter is such a
linear function, or the load factor times one (Smith, Watson and Topper; Fatemi and Socie).

The largest value over all states of rest may fall with the load factor, so that no bisection finds
where it first reaches a value. A program for each plane does. The least value over all states of
rest never falls, if the mean load is a mean of the loads of the corners.
"""

from __future__ import annotations

from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

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
from .stress_levels import SETTINGS, Stresses, StressLevels, stress_terms, tensors_at_rest


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


class StressCrossings:
    """Where a parameter reaches an allowable value > 0 in states of rest at rising load factors.

    `planes`: see `StressLevels`.
    """

    def __init__(
        self,
        question: Question,
        stress_map: StressMap,
        name: str,
        weight: float,
        planes: int,
        allowable: float,
    ) -> None:
        self._question = question
        self._stress_map = stress_map
        self._name = name
        self._weight = weight
        self._planes = planes
        self._allowable = allowable
        self._points = range(stress_map.count)
        self._mean = tensors_at_rest(question, stress_map, 0.0)
        self._whole = tensors_at_rest(question, stress_map, 1.0)
        # The stresses of the mean load with the ranges of load factor 1.
        self._starts = self._stresses(np.stack([self._mean[:, 0], self._whole[:, 1]], axis=1))
        self._ends = self._stresses(self._whole)

    def _stresses(self, tensors: Array) -> Stresses:
        return Stresses(self._question, self._stress_map, tensors, self._name, self._weight)

    def levels(self, load_factor: float) -> StressLevels:
        """The ends of the parameter at a load factor."""
        stresses = self._stresses(self._mean + load_factor * (self._whole - self._mean))
        return StressLevels(Rests(self._question, load_factor), stresses, self._planes)

    def first(self) -> Crossing | None:
        """The least load factor at which some state of rest has the value; None if none has it.

        If planes are searched, the largest value at this load factor is searched, too, and its
        plane is added.
        """
        levels = self.levels(1.0)
        queue = list[tuple[float, int, Plane, Crossing]]()
        numbers = count()

        def add(planes: list[Plane], tangent: float, least: float = 0.0) -> None:
            for plane in planes:
                crossing = self._crossing(plane, tangent, least)
                if np.isfinite(crossing.load_factor):
                    heappush(queue, (crossing.load_factor, next(numbers), plane, crossing))

        for point in self._points:
            add(self._planes_of(point, levels.planes_of(point)), self._question.load_unit)
        while queue:
            load_factor, _, plane, crossing = queue[0]
            level = plane.at(crossing)
            short = load_factor * level < self._allowable * (1 - SETTINGS.agreed)
            if self._name in NOT_NEGATIVE and short:
                # The next tangent of `allowable / load factor` leaves this load factor out.
                heappop(queue)
                add([plane], load_factor or self._allowable / level, load_factor)
                continue
            if self._name in SEARCHED:
                levels = self.levels(load_factor)
                for point in self._points:
                    end = levels.most(point)
                    if end.value > self._allowable * (1 + SETTINGS.agreed):
                        add(self._planes_of(point, end.normal[None]), load_factor)
            if queue[0][0] >= load_factor * (1 - SETTINGS.gain):
                return crossing
        return None

    def _planes_of(self, point: int, normals: Array) -> list[Plane]:
        starts, rates = self._starts.on(point, normals)
        ends, _ = self._ends.on(point, normals)
        return [Plane(*plane) for plane in zip(starts, ends - starts, rates, strict=True)]

    def _crossing(self, plane: Plane, tangent: float, least: float) -> Crossing:
        """The least load factor, from `least` on, at which a plane reaches the value.

        A parameter that is the load factor times the plane's function has a lower bound of it: the
        function reaches the tangent of `allowable / load factor` at the load factor `tangent`.
        """
        value, fall = self._allowable, 0.0
        if self._name in NOT_NEGATIVE:
            value, fall = 2 * value / tangent, value / tangent**2
        program = at_corners(self._question, residual=True)
        program.row("later", {"load_factor": 1.0}, -least)
        by_load = np.array([program.unknown("load_factor")]), np.array([plane.rate + fall])
        terms = [by_load, *stress_terms(program, plane.rates[None])]
        program.add("reached", LINEAR, [terms], np.array([plane.start - value]), np.array([value]))

        def claimed(solution: Solution) -> Crossing:
            bound, error = solution.bound
            load_factor, slip = solution.load_factor, solution.slip_of_nodes
            off = self._question.violation(load_factor, slip)
            return Crossing(load_factor, bound - error, slip, worst([off, solution.gap]))

        def never(outcome: str, arrays: Arrays) -> Crossing | None:
            found = infeasible(arrays)
            nowhere = np.full(self._question.system.slip_shape, np.nan)
            return None if found is None else Crossing(np.inf, np.inf, nowhere, found[1])

        crossing, _ = solve(stuck(program), "load_factor", -1.0, claimed, no_optimum=never)
        assert crossing is not None
        return crossing

    def last(self, largest: float) -> Crossing | None:
        """The largest load factor at which some state of rest has at most the value.

        None if it is at least `largest`.
        """

        def above(load_factor: float) -> float:
            return self.levels(load_factor).least(self._points).value - self._allowable

        if above(largest) <= 0:
            return None
        load_factor = 0.0
        if above(0.0) < 0:
            load_factor = brentq(above, 0.0, largest, xtol=SETTINGS.gain * largest)
        level = self.levels(load_factor).least(self._points)
        for further in 10.0 ** np.arange(-7, 0):
            bound = min(load_factor * (1 + further), largest)
            if self.levels(bound).least(self._points).bound > self._allowable:
                break
        return Crossing(load_factor, bound, level.slip, level.residual)
