"""The least and the largest values of a fatigue parameter over a set of residual slips.

Every slip of the set gives the same changes of stress during the cycle, and stresses are linear in
the slip. So on a given plane at a given point, each parameter rises with one normal stress. The
least and the largest value of the parameter are solutions of linear programs, in space of cone
programs (theory, "The fatigue band").

- `Stresses`: stress and strain at the points, and the rates of stress with the residual slip.
- `StressLevels.least`: the least value, over all slips, of the largest value over points. A program
  contains some planes of each point. The critical planes for the slip of its solution are added
  until the bound of the program equals the value at this slip.
- `StressLevels.most`: the largest value of one point over all slips. First a program is solved for
  each plane. Then the best plane for a slip and the best slip for a plane are computed in turn.
- `StressCrossings`: the least load factor at which a parameter reaches a value in some state of
  rest, and the largest load factor at which some state of rest has at most this value. If the
  corners have the same fixed loads, ranges are proportional to the load factor, and stresses are
  linear in load factor and slip together. So on a given plane at a given point, each parameter is
  such a linear function, or such a function times the load factor (Smith, Watson and Topper; Fatemi
  and Socie). The largest value over all states of rest may fall with the load factor, so that no
  bisection finds where it first reaches a value. A program for each plane finds this load factor.
  The least value over all states of rest never falls, if the mean load is a mean of the loads of
  the corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple

import numpy as np
import scipy  # a part of it is imported when it is used

from ...base import Array, worst
from ...contact import StressMap
from ...errors import SolverError
from ...solve.arrays import LINEAR, Term
from ...solve.solvers import NoOptimum
from ...transients.critical_plane import (
    NOT_NEGATIVE,
    SEARCHED,
    half_sphere,
    largest,
    parameter_on,
)
from ..program.assembled import at_corners, stuck, wedging
from ..program.question import Question
from ..program.rest_program import RestProgram, elastic
from ..program.rest_slips import Furthest, Rests, SteadyCycles
from ..program.solution import Judged, Solution, contradiction, solve

# Numbers of the search for the least and the largest values.

# Distance of the proven bound from the least value, relative to the value.
AGREED = 1e-7
# The same distance for the least value of a single point, which only a picture shows.
DRAWN = 1e-4
# The smallest value by which these distances are divided, relative to the values without slip.
_FLOOR = 0.1
# Largest number of programs of the least value; usually less than ten are enough.
_ROUNDS = 60
# Number of planes from which plane and slip are improved in turn, and largest number of turns.
_BEST = 3
_TURNS = 20
# The turns end if a turn gains less than this share of the value.
GAIN = 1e-9


def tensors_at_rest(question: Question, stress_map: StressMap, load_factor: float) -> Array:
    """(K, 2, P, 3, 3) stress and strain at the corners at a load factor, without slip."""
    system = stress_map.system
    motions, _ = question.states(load_factor, np.zeros(system.slip_shape))
    loads = question.cycle.at(load_factor)
    states = zip(loads, motions, strict=True)
    return np.array(
        [stress_map.at(load, motion.ravel() - system.opening) for load, motion in states]
    )


def stress_terms(program: RestProgram, rates: Array) -> list[Term]:
    """Terms of n rows: the stresses that the residual slip causes by its forces, without the loads.

    `rates` (n, t N) are stresses per unit slip.
    """
    closed = elastic(program.question)
    by_force = rates[:, closed.slips] @ closed.compliance
    last = np.full(len(rates), len(program.start) - 1)
    return [
        (program.force(last, np.full(len(rates), entry)), weights)
        for entry, weights in zip(closed.slips, by_force.T, strict=True)
    ]


class Level(NamedTuple):
    """A value with one slip, and a proven bound for all slips.

    The value is either the largest value over some points, or the load factor of a crossing, at
    which a parameter reaches its allowable value: inf if it never does.
    """

    value: float
    bound: float
    slip: Array  # (N,) or (N, 2)
    residual: float


class End(NamedTuple):
    """The largest value of one point over all slips, with its slip and the normal of its plane."""

    value: float
    slip: Array
    normal: Array


class Stresses:
    """Stress and strain of P points at K states, and a fatigue parameter.

    Parameters
    ----------
    question
        The closed and the open nodes.
    stress_map
        The map of the points.
    tensors
        (K, 2, P, 3, 3) stress and strain without a slip of the set.
    name, weight
        The parameter, see `parameter_on`.
    """

    def __init__(
        self, question: Question, stress_map: StressMap, tensors: Array, name: str, weight: float
    ) -> None:
        self.sigma = tensors[:, 0]  # (K, P, 3, 3)
        self.epsilon = tensors[:, 1]
        self.name = name
        self.weight = weight
        by_motion = np.asarray(stress_map.motions)[:, 0]
        rates = by_motion.reshape(len(by_motion), -1)
        if question.compliance is not None:
            # Open nodes follow the slip of the closed nodes without force.
            rates = rates - question.system.S @ (question.compliance @ rates)
        slips = len(rates) - question.system.nodes
        closed = np.tile(~question.open_nodes, question.system.tangents)
        # (t N, P, 3, 3) stress due to unit slips of the closed nodes.
        self.rates = (closed[:, None] * rates[:slips]).reshape(slips, *by_motion.shape[1:])

    def on(self, point: int, normals: Array) -> tuple[Array, Array]:
        """(planes,) values without slip, and (planes, t N) their rates with the slip."""
        states = self.sigma[:, point], self.epsilon[:, point]
        values, tensors = parameter_on(self.name, *states, self.weight, normals)
        return values, np.einsum("pij,vij->pv", tensors, self.rates[:, point])

    def critical(self, points: Sequence[int], slip: Array) -> tuple[Array, list[Array]]:
        """The parameter of points with a slip, and the normals (planes, 3) of their planes."""
        added = np.tensordot(slip.T.ravel(), self.rates[:, points], 1)
        states = self.sigma[:, points] + added, self.epsilon[:, points]
        return largest(self.name, *states, self.weight)

    def values(self, slip: Array) -> Array:
        """(P,) the parameter of all points with a slip."""
        return self.critical(range(self.sigma.shape[1]), slip)[0]


class StressLevels:
    """The least and the largest values of a parameter over a set of slips.

    `planes`: the number of planes at which the search for a largest value begins.
    """

    def __init__(self, slips: Rests | SteadyCycles, stresses: Stresses, planes: int) -> None:
        self._slips = slips
        self._furthest = Furthest(slips)
        self._stresses = stresses
        system = slips.question.system
        self._none = np.zeros(system.slip_shape)
        self._grid = half_sphere(planes)
        # If no shear acts out of the section x, y, only this section and the planes normal to it
        # are searched.
        if not (stresses.sigma[..., :2, 2].any() or stresses.rates[..., :2, 2].any()):
            angles = np.pi * np.arange(planes) / planes
            in_section = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(planes)])
            self._grid = np.vstack([in_section, np.eye(3)[2:]])

    @cached_property
    def wedges(self) -> bool:
        """Whether friction wedges the bodies: then slips of any size may obey the contact law."""
        question = self._slips.question
        if question.slip_bound is not None:
            return False

        def judged(solution: Solution) -> Judged:
            return Judged(solution.value, solution.program.violation(solution.x))

        wedge, _ = solve(wedging(question), judged)
        # `wedge.said` is 0 or 1: if a slip wedges the bodies, all multiples of this slip do so,
        # too.
        return bool(wedge.said > 0.5)

    def least(self, points: Sequence[int], agreed: float = AGREED) -> Level:
        """The least, over all slips, of the largest value of some points.

        The value is -inf if friction wedges the bodies and this lowers the value without end.
        """
        stresses = self._stresses
        planes = {point: self.planes_of(point) for point in points}
        size = max(float(np.abs(stresses.on(point, planes[point])[0]).max()) for point in points)
        size = size or 1.0
        best = Level(np.inf, -np.inf, self._none, 0.0)
        for _ in range(_ROUNDS):
            try:
                level = self._level(planes, size)
            except NoOptimum:
                if not self.wedges:
                    raise
                return Level(-np.inf, -np.inf, np.full_like(self._none, np.nan), 0.0)
            values, critical = stresses.critical(points, level.slip)
            value = float(values.max())
            bound = max(best.bound, level.bound)
            best = level._replace(value=value) if value < best.value else best
            best = best._replace(bound=min(bound, best.value))
            tolerance = agreed * max(abs(best.value), _FLOOR * size)
            if best.value - best.bound <= tolerance:
                break
            for point, of_point, normals in zip(points, values, critical, strict=True):
                if of_point > best.bound + tolerance / 2:
                    planes[point] = np.vstack([planes[point], normals])
        return best

    def planes_of(self, point: int) -> Array:
        """The planes with which a search begins or, without a search, the critical planes."""
        if self._stresses.name in SEARCHED:
            return self._grid
        return self._stresses.critical([point], self._none)[1][0]

    def _level(self, planes: dict[int, Array], size: float) -> Level:
        """The least level that, with some slip, no value of the points on these planes exceeds."""
        of_points = [self._stresses.on(point, normals) for point, normals in planes.items()]
        values = np.concatenate([values for values, _ in of_points])
        rates = np.concatenate([rates for _, rates in of_points])
        program = self._slips.program({"level": size})
        count = len(values)
        own = np.full(count, program.unknown("level")), np.ones(count)
        terms = [own, *stress_terms(program, -rates)]
        program.add("level", LINEAR, [terms], -values, np.full(count, size))
        if self._stresses.name in NOT_NEGATIVE:
            program.row("not_negative", {"level": 1.0})

        def claimed(solution: Solution) -> Level:
            bound, error = solution.bound
            slip = solution.slip_of_nodes
            residual = worst([self._slips.violation(slip), solution.gap])
            return Level(solution.value, bound - error, slip, residual)

        level, _ = solve(program, claimed, -1.0)
        return level

    def most(self, point: int) -> End:
        """The largest value of a point over all slips; inf if friction wedges and lets it grow."""
        stresses = self._stresses
        not_negative = stresses.name in NOT_NEGATIVE
        ends = self._ends(point, self.planes_of(point))
        tried = sorted(ends, key=_value, reverse=True)
        best = tried[0]
        turning = tried[:_BEST] if stresses.name in SEARCHED else []
        for end in turning if np.isfinite(best.value) else []:
            for _ in range(_TURNS):
                before = end
                [end] = self._ends(point, stresses.critical([point], before.slip)[1][0])
                if end.value - before.value <= GAIN * abs(before.value):
                    break
            best = max(best, before, end, key=_value)
        return best._replace(value=max(best.value, 0.0)) if not_negative else best

    def _ends(self, point: int, normals: Array) -> list[End]:
        """The largest value on each plane over all slips."""
        values, rates = self._stresses.on(point, normals)
        ends = zip(values.tolist(), self._along(rates), normals, strict=True)
        return [End(value + added, slip, normal) for value, (added, slip), normal in ends]

    def _along(self, rates: Array) -> list[tuple[float, Array]]:
        """For each rate, the most that a slip adds, and this slip.

        If friction wedges and nothing ends the slips along a rate, they are inf and NaN.
        """
        ends = []
        for rate in rates:
            slip = self._furthest.along(rate)
            if slip is not None:
                ends.append((float(rate @ slip.T.ravel()), slip))
            elif self.wedges:
                ends.append((np.inf, np.full_like(self._none, np.nan)))
            else:
                raise SolverError(
                    "fatigue band: no solver found an end of the slips, which friction bounds; "
                    "give a `slip_bound`"
                )
        return ends

    def on_plane(self, point: int, normal: Array) -> dict[str, float]:
        """The load corner with the largest normal stress on a plane, and the range of this stress.

        The range is given for two slips, which have the least and the largest stress.
        """
        square = np.outer(normal, normal)
        along = np.einsum("ij,kij->k", square, self._stresses.sigma[:, point])
        rate = np.einsum("ij,vij->v", square, self._stresses.rates[:, point])
        row = {"corner": float(along.argmax())}
        (less, _), (more, _) = self._along(np.array([-rate, rate]))
        for name, added in (("least", -less), ("most", more)):
            row[f"from_{name}"] = float(along.min()) + added
            row[f"to_{name}"] = float(along.max()) + added
        return row


def _value(end: End) -> float:
    return end.value


class Plane(NamedTuple):
    """The function `start + rate * load factor + rates @ slip` of one plane of one point."""

    start: float
    rate: float
    rates: Array  # (t N,)

    def at(self, crossing: Level) -> float:
        """The value of the function at a load factor and a slip."""
        added = self.rates @ crossing.slip.T.ravel()
        return float(self.start + self.rate * crossing.value + added)


@dataclass(frozen=True, eq=False)
class StressCrossings:
    """The load factors at which a parameter reaches an allowable value > 0 in states of rest.

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
        """The least and the largest values of the parameter at a load factor."""
        tensors = tensors_at_rest(self.question, self.stress_map, load_factor)
        rests = Rests(self.question, load_factor)
        return StressLevels(rests, self._stresses(tensors), self.planes)

    def _least(self, load_factor: float) -> Level:
        return self.levels(load_factor).least(range(self.stress_map.count))

    def first(self) -> Level | None:
        """The least load factor at which some state of rest has the value; None if none has it.

        For a parameter whose critical plane is searched, the largest value over all planes at this
        load factor is computed. If it is above the allowable value, its plane is added, and the
        search goes on.
        """
        mean, whole = (tensors_at_rest(self.question, self.stress_map, at) for at in (0.0, 1.0))
        of_whole = self._stresses(whole)
        # The stresses under the mean load, with the ranges at load factor 1.
        of_mean = self._stresses(np.stack([mean[:, 0], whole[:, 1]], axis=1))
        queue = list[tuple[float, int, Plane, Level]]()
        numbers = count()

        def add(plane: Plane, tangent: float, least: float = 0.0) -> None:
            crossing = self._crossing(plane, tangent, least)
            if np.isfinite(crossing.value):
                heappush(queue, (crossing.value, next(numbers), plane, crossing))

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
                # The tangent of `allowable / load factor` at this load factor gives a higher lower
                # bound.
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

    def _crossing(self, plane: Plane, tangent: float, least: float) -> Level:
        """The least load factor, from `least` on, at which a plane's function reaches the value.

        If the parameter is the load factor times the function of the plane, the function reaches
        `allowable / load factor` there. The program replaces this convex curve by its tangent at
        the load factor `tangent`, which is below the curve. So the result is a lower bound.
        """
        value, fall = self.allowable, 0.0
        if self.name in NOT_NEGATIVE:
            value, fall = 2 * value / tangent, value / tangent**2
        program = at_corners(self.question, residual=True)
        program.row("later", {"load_factor": 1.0}, -least)
        by_load = np.array([program.unknown("load_factor")]), np.array([plane.rate + fall])
        terms = [by_load, *stress_terms(program, plane.rates[None])]
        program.add("reached", LINEAR, [terms], np.array([plane.start - value]), np.array([value]))

        def claimed(solution: Solution) -> Level:
            bound, error = solution.bound
            load_factor, slip = solution.load_factor, solution.slip_of_nodes
            off = self.question.violation(load_factor, slip)
            return Level(load_factor, bound - error, slip, worst([off, solution.gap]))

        def never(outcome: str) -> Level | None:
            found = contradiction(program)
            nowhere = np.full(self.question.system.slip_shape, np.nan)
            return None if found is None else Level(np.inf, np.inf, nowhere, found[1])

        crossing, _ = solve(stuck(program), claimed, -1.0, no_optimum=never)
        return crossing

    def last(self, largest: float) -> Level | None:
        """The largest load factor at which some state of rest has at most the value.

        None if this load factor is at least `largest`.
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
        return Level(load_factor, bound, level.slip, level.residual)
