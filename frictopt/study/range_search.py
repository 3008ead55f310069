"""Search over residual slips for more or less steady dissipation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..base import LEVEL, PERIODIC, RESIDUAL, Array, Outcome, kept
from ..errors import NoContinuation, SolverError
from ..limits import Question
from ..transients import SteadyState, steady_state
from ..transients.classify import Settled, distance_left
from ..transients.cycles import Run
from ..transients.exact import ExactPath
from ..transients.march import path_of
from ..transients.steady import reported
from ..transients.stepped import SteppedPath
from ..transients.transient import Transient
from .ascent import Ascent
from .range_starts import shortened

# Numbers of the search.

# Smallest relative gain of work in a step.
_LEAST_GAIN = 100 * RESIDUAL
# First and last radius of the trust region, relative to the spread of the slips of the orbit.
_FIRST_RADIUS = 0.25
_LAST_RADIUS = 0.25e-5
# Largest number of transients in a climb.
_CLIMB_TRANSIENTS = 20
# A climb stops if even this multiple of its next gain would not reach the best work found
# elsewhere.
_LEAP = 400.0
# Smallest and largest number of random starts around an orbit.
_LEAST_AROUND = 8
MOST_AROUND = 200
# Within these two limits, the number of random starts is the following number divided by the number
# of nodes: with many nodes a transient is slower, and the works of the starts differ less.
_NODES_AROUND = 1000
# Largest and smallest distance of random starts, relative to the spread of the slips of the
# orbit.
_WIDEST = 2.0
_NARROWEST = 0.05
# Number of cycles after which a transient is given up. Some transients need thousands.
_MOST_CYCLES = 200
# Increments from corner to corner in a rough search, a quarter of the usual number.
_ROUGH_STEPS = 5
# Smallest relative gain of work in a rough search, and largest relative change of work in the
# later cycles that it leaves out.
_ROUGH_SHARE = 1e-3
# Number of successive works of a rough transient from which the later change is estimated.
_ROUGH_WORKS = 4
STOPPED = f"stopped after {_CLIMB_TRANSIENTS} transients"
FAR = "far from the end of the range, and its steps gain too little"


@kept
@dataclass(frozen=True, eq=False)
class Orbit:
    """The transient from one start, and the steady state that it leads to.

    `name` is the name of the first start of the search; `start` is the slip at which this transient
    starts, (N,) or (N, 2), length. `state` is the steady state, and `path` the transient that has
    reached it at the last corner. Both are None if the transient has no result. `end` says why the
    search from this orbit ended; it is "followed" if no search went on from it.
    """

    name: str
    start: Array
    state: SteadyState | None
    end: str
    path: Transient | None = None

    @property
    def work(self) -> float:
        """Steady dissipation, NaN without a result."""
        return np.nan if self.state is None else self.state.dissipation


def levels_of(orbits: Iterable[Orbit]) -> list[Orbit]:
    """An orbit for each different work of friction, in the order of rising work."""
    levels = list[Orbit]()
    results = [orbit for orbit in orbits if orbit.state is not None]
    for orbit in sorted(results, key=lambda orbit: orbit.work):
        if not levels or orbit.work - levels[-1].work > LEVEL * orbit.work:
            levels.append(orbit)
    return levels


class Search:
    """Transients of one contact at one load factor, their number, and the orbits that they reach.

    `count_one` is called for each transient. A rough search ends a transient before its state
    repeats: when later cycles change its work by less than a thousandth.
    """

    def __init__(
        self,
        question: Question,
        load_factor: float,
        steps: int | None,
        count_one: Callable[[], object],
        rough: bool = False,
    ) -> None:
        self._question = question
        self._load_factor = load_factor
        self._asked = question.system, question.cycle, question.friction, load_factor
        self._steps = steps
        self._count_one = count_one
        self.rough = rough
        self._least_gain = _ROUGH_SHARE if rough else _LEAST_GAIN
        self.transients = 0
        # (M,) states after one cycle, in slip scales, with the orbits that follow from them
        self._met = list[tuple[Array, Orbit]]()
        self._extremes = list[float]()  # works of the local extremes
        self._rng = np.random.default_rng(0)

    @property
    def orbits(self) -> list[Orbit]:
        """The orbits with a steady state, without repetitions."""
        return [orbit for _, orbit in self._met]

    def in_few_increments(self) -> Search | None:
        """A rough search of the same contact; None if its increments would not be much fewer."""
        if self._path(None).steps < 2 * _ROUGH_STEPS:
            return None
        return Search(self._question, self._load_factor, _ROUGH_STEPS, self._count_one, rough=True)

    def follow(
        self, name: str, start: Array, least: float = 0.0, most: int = _MOST_CYCLES
    ) -> Orbit:
        """Follow the transient from a start for at most `most` cycles.

        The transient is given up if two successive cycles have less work than `least`, because the
        work of a transient usually falls from cycle to cycle. In a thousand random transients the
        work rose by at most some 2 %.
        """
        self.transients += 1
        self._count_one()
        try:
            return self._orbit(name, start, least, most)
        except (NoContinuation, SolverError) as error:
            return Orbit(name, start, None, f"{type(error).__name__}: {error}")

    def follow_all(self, starts: Mapping[str, Array]) -> list[Orbit]:
        """Follow the transients from named starts."""
        return [self.follow(name, start) for name, start in starts.items()]

    def _orbit(self, name: str, start: Array, least: float, most: int) -> Orbit:
        path = self._path(start).start()
        run = Run(path, most)
        settled: Settled | None = None
        while settled is None:
            settled = run.advance()
            if settled is None and self.rough:
                settled = _nearly_settled(run)
            if len(run.works) == 1:
                # If the state after one cycle was met before, the transient continues as the
                # earlier one.
                after_one_cycle = path.state.u / path.length
                for state, orbit in self._met:
                    if np.abs(after_one_cycle - state).max() <= PERIODIC:
                        return replace(orbit, name=name, start=start)
            elif len(run.works) > 2 and max(run.works[-2:]) < least:
                return Orbit(name, start, None, "less work than requested")
        step_error = np.inf if path.steps else 0.0  # not known yet, see `final_state`
        steady = reported(run, settled, step_error)
        orbit = Orbit(name, start, steady, "followed", settled.path)
        self._met.append((after_one_cycle, orbit))
        return orbit

    def further(self, starts: list[tuple[str, Array]]) -> list[Orbit]:
        """Orbits from named starts in turn, until a start leads to a state that was met before."""
        orbits = list[Orbit]()
        for name, start in starts:
            known = len(self._met)
            orbits.append(self.follow(name, start))
            if len(self._met) == known:
                break
        return orbits

    def final_state(self, orbit: Orbit) -> SteadyState:
        """The steady state of an orbit; an orbit followed in increments gets its step error."""
        assert orbit.state is not None
        if not orbit.state.steps:
            return orbit.state
        return steady_state(
            *self._asked, initial_slip=orbit.start, steps=self._steps, progress=False
        )

    def around(self, orbit: Orbit, least: float) -> list[Orbit]:
        """Orbits with a work of at least `least` from random starts around one orbit.

        Without `least` no transient ends early, so there are no random starts if the contact has
        many nodes.
        """
        assert orbit.path is not None
        count = _NODES_AROUND // len(orbit.start)
        if not least and count < 2 * _LEAST_AROUND:
            return []
        count = int(np.clip(count, _LEAST_AROUND, MOST_AROUND))
        spread = _spread(orbit.start, orbit.path)
        narrowing = (_NARROWEST / _WIDEST) ** np.linspace(0, 1, count) ** 2
        orbits = list[Orbit]()
        for distance in spread * _WIDEST * narrowing:
            start = orbit.start + distance * self._rng.uniform(-1, 1, orbit.start.shape)
            start = shortened(start, self._question.slip_bound)
            orbits.append(self.follow(f"around {orbit.name}", start, least))
        return [near for near in orbits if near.work >= least]

    def climb(self, orbit: Orbit, sense: int) -> Orbit:
        """Climb from an orbit by linear programs to more (sense 1) or less (sense -1) work.

        The radius of the trust region is doubled after a step that gains work, and divided by four
        after any other step.
        """
        last_transient = self.transients + _CLIMB_TRANSIENTS
        best = max(sense * known.work for known in self.orbits)
        radius = _FIRST_RADIUS
        unit = 0.0
        ascent: Ascent | None = None
        while self.transients < last_transient:
            if ascent is None:
                try:
                    ascent = self._ascent(orbit, sense)
                except (NoContinuation, SolverError) as error:
                    return replace(orbit, end=f"not searched from: {error}")
                unit = unit or _spread(ascent.before, ascent.path)
            step = ascent.step(radius * unit)
            end = self._end_of_climb(orbit, sense, step, radius, best)
            if step is None or end:
                return replace(orbit, end=end)
            change, _ = step
            least = orbit.work if sense > 0 else 0.0
            tried = self.follow(orbit.name, ascent.before + change, least)
            if sense * (tried.work - orbit.work) > self._least_gain * orbit.work:
                orbit = tried
                ascent = None
                radius *= 2.0
                if any(abs(orbit.work - known) <= LEVEL * known for known in self._extremes):
                    return replace(orbit, end="local extreme known before")
            else:
                radius *= 0.25
        return replace(orbit, end=STOPPED)

    def _end_of_climb(
        self,
        orbit: Orbit,
        sense: int,
        step: tuple[Array, float] | None,
        radius: float,
        best: float,
    ) -> str:
        """The reason to end a climb before a step is tried; "" if there is none."""
        gain = 0.0 if step is None else step[1]
        if not gain > self._least_gain * orbit.work or radius < _LAST_RADIUS:
            self._extremes.append(orbit.work)
            return "local extreme"
        return FAR if sense * orbit.work + _LEAP * gain < best else ""

    def _ascent(self, orbit: Orbit, sense: int) -> Ascent:
        state = orbit.state
        repeats = state is not None and state.outcome is Outcome.CYCLIC_SLIP and state.period == 1
        if orbit.path is None or not repeats:
            raise NoContinuation("its slip does not repeat in every cycle")
        return Ascent(orbit.path, sense, self._question.slip_bound)

    def _path(self, start: Array | None) -> ExactPath | SteppedPath:
        return path_of(*self._asked, start, steps=self._steps)


def _nearly_settled(run: Run) -> Settled | None:
    """The last cycle as the steady state, if its work is final up to a thousandth.

    The later change is estimated from the last works; the first cycle is not used, because it
    begins at the mean load.
    """
    works = run.works[1:][-_ROUGH_WORKS:]
    if run.period > 1 or len(works) < _ROUGH_WORKS or not run.last:
        return None
    changes = [abs(later - earlier) for earlier, later in pairwise(works)]
    later_change = distance_left(changes, 0.0)
    if not later_change < _ROUGH_SHARE * works[-1]:
        return None
    cycle = replace(run.last[-1], change=0.0)
    work_error = later_change / works[-1]
    return Settled(Outcome.CYCLIC_SLIP, run.path, cycle, work_error, (cycle,))


def _spread(slip: Array, path: Transient) -> float:
    """Largest minus smallest slip; the slip scale of the mean load if all slips are equal."""
    return float(np.ptp(slip, axis=0).max()) or path.force / path.system.stiffness_scale
