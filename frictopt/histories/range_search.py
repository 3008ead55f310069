"""Search over the starts for more or less steady dissipation: transients from given starts, and from where linear programs point."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ..contact import LEVEL, PERIODIC, RESIDUAL, Array, Outcome
from ..errors import NoContinuation, SolverError
from ..limits.question import Question
from ..transients import SteadyState, steady_state
from ..transients.begin import Transient
from ..transients.classify import Settled, distance_left
from ..transients.cycles import Run
from ..transients.march import path_of
from ..transients.steady import reported
from .ascent import Ascent
from .range_starts import shortened
from .starts import spread

_WORK_GAIN = 100 * RESIDUAL  # a step that gains less work, relative, is none
_FIRST = 0.25  # first trust region, over the spread of the slips of the orbit
_LEAST = 1e-5 * _FIRST  # last one, over the same
_TRANSIENTS = 20  # of one climb
_LEAP = _TRANSIENTS**2  # times the gain of a step: a climb that would not reach with so much what another start has is given up
_AROUND = 8, 200  # starts around an end at least, and at most: of many nodes few, because each costs more and their works differ less
_EACH = 1000  # nodes of these starts together, otherwise
_WIDEST, _NARROWEST = 2.0, 0.05  # distances of these starts, over the spread of the slips of the end
_CYCLES = 200  # of a transient, after which it is given up: some take thousands
_ROUGH_STEPS = 5  # increments of a rough search, from corner to corner: a quarter of the usual ones
_ROUGH = 1e-3  # of a work, what later cycles change of it and what a step gains that a rough search does not see
_TELLING = 4  # cycles in turn whose works tell how much later ones change
STOPPED, FAR = f"stopped after {_TRANSIENTS} transients", "far from the end of the range, and with a step hardly nearer"


@dataclass(frozen=True, eq=False)
class Orbit:
    """What came of one start.

    Attributes
    ----------
    name
        Name of the start that the search began with.
    start
        (N,) or (N, 2) slip from which the steady state is reached, length.
    state
        The steady state; None where the transient has no result.
    end
        Why the search from it ended: "followed" where there was none.
    path
        The path that has reached the steady state, at the last corner; None without a result.
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


class Search:
    """Transients of one contact at one load factor, counted.

    Parameters
    ----------
    task
        The contact, its load cycle, friction, and bound of the starts' slip.
    load_factor
        Load factor of the cycle.
    steps
        Number of increments, see `path_of`.
    tell
        Is called for each transient.
    rough
        Whether works are needed roughly: transients end where later cycles change them by a thousandth, before their state comes back.
    """

    def __init__(
        self, task: Question, load_factor: float, steps: int | None = None, tell: Callable[[], object] = lambda: None, rough: bool = False
    ) -> None:
        self._task, self._load_factor, self._steps, self._rough = task, load_factor, steps, rough
        self._asked = task.system, task.cycle, task.friction, load_factor
        self._gain = _ROUGH if rough else _WORK_GAIN
        self.transients, self._tell = 0, tell
        self._extremes: list[float] = []  # works of the local extremes so far
        self._rng = np.random.default_rng(0)
        self._met: list[tuple[Array, Orbit]] = []  # states after one cycle, in slip scales, and what came of them

    def in_few_increments(self) -> "Search | None":
        """A rough search of the same contact; None on the exact path, and where the increments are few already."""
        steps = path_of(*self._asked, steps=self._steps).steps
        return Search(self._task, self._load_factor, _ROUGH_STEPS, self._tell, rough=True) if steps >= 2 * _ROUGH_STEPS else None

    def follow(self, name: str, start: Array, least: float = 0.0, most: int = _CYCLES) -> Orbit:
        """The steady state that one start leads to, unless two cycles one after the other have less work than the least that is looked for.

        The work of a transient falls from cycle to cycle, up to some 2 % in a thousand random ones. Where one cycle brings two transients to the same
        state, the second one goes on as the first did.
        """
        self.transients += 1
        self._tell()
        try:
            path = path_of(*self._asked, start, steps=self._steps).start()
            run, found = Run(path, most), None
            while found is None:
                found = run.advance() or (_nearly(run) if self._rough else None)
                if len(run.works) == 1:
                    place = path.state.u / path.length
                    for other, met in self._met:
                        if abs(place[0] - other[0]) <= PERIODIC and np.abs(place - other).max() <= PERIODIC:  # the first one is quick to tell
                            return replace(met, name=name, start=start)
                elif max(run.works[-2:]) < least and len(run.works) > 2:
                    return Orbit(name, start, None, "less work than looked for")
            orbit = Orbit(name, start, reported(run, found, np.inf if path.steps else 0.0), "followed", found.path)
            self._met.append((place, orbit))
        except (NoContinuation, SolverError) as error:
            orbit = Orbit(name, start, None, f"{type(error).__name__}: {error}")
        return orbit

    def further(self, row: list[tuple[str, Array]]) -> list[Orbit]:
        """Orbits from starts by their names, one after the other as long as each leads to a state that no transient before it has met."""
        orbits = list[Orbit]()
        for name, start in row:
            known = len(self._met)
            orbits.append(self.follow(name, start))
            if len(self._met) == known:
                break
        return orbits

    def told(self, orbit: Orbit) -> SteadyState:
        """The steady state of an orbit, in increments with their error."""
        assert orbit.state is not None
        return steady_state(*self._asked, initial_slip=orbit.start, steps=self._steps, progress=False) if orbit.state.steps else orbit.state

    def around(self, orbit: Orbit, least: float) -> list[Orbit]:
        """Orbits of at least so much work from random starts around that of an orbit, within two spreads of its slips, and closer.

        None where any work counts and there are many nodes: such transients cannot be given up early.
        """
        assert orbit.path is not None
        size, count = _spread(orbit.start, orbit.path), _EACH // len(orbit.start)
        if not least and count < 2 * _AROUND[0]:
            return []
        sizes = size * _WIDEST * (_NARROWEST / _WIDEST) ** np.linspace(0, 1, int(np.clip(count, *_AROUND))) ** 2
        starts = [orbit.start + one * self._rng.uniform(-1, 1, orbit.start.shape) for one in sizes]
        starts = starts if self._task.most is None else [shortened(start, self._task.most) for start in starts]
        return [found for start in starts if (found := self.follow(f"around {orbit.name}", start, least)).work >= least]

    def climb(self, orbit: Orbit, sense: int) -> Orbit:
        """The orbit with more (sense 1) or less (sense -1) work that steps of linear programs lead to."""
        limit, aim = self.transients + _TRANSIENTS, max(sense * met.work for _, met in self._met)
        radius, unit = _FIRST, 0.0
        while self.transients < limit:
            path = orbit.path
            if path is None or orbit.state is None or orbit.state.outcome is not Outcome.CYCLIC_SLIP or orbit.state.period > 1:
                return replace(orbit, end="no slip that repeats in every cycle: not searched from")
            try:
                ascent = Ascent(path, sense, self._task.most)
            except (NoContinuation, SolverError) as error:
                return replace(orbit, end=f"no derivative: {error}")
            better, unit = None, unit or _spread(ascent.before, path)
            while better is None:
                step = ascent.step(radius * unit)
                if self.transients >= limit:
                    return replace(orbit, end=STOPPED)
                if step is None or not step[1] > self._gain * orbit.work or radius < _LEAST:
                    self._extremes.append(orbit.work)
                    return replace(orbit, end="local extreme")
                if sense * orbit.work + _LEAP * step[1] < aim:
                    return replace(orbit, end=FAR)
                tried = self.follow(orbit.name, ascent.before + step[0], orbit.work if sense > 0 else 0.0)
                better = tried if sense * (tried.work - orbit.work) > self._gain * orbit.work else None
                radius *= 2.0 if better else 0.25
            orbit = better
            if any(abs(orbit.work - known) <= LEVEL * known for known in self._extremes):
                return replace(orbit, end="local extreme known before")
        return replace(orbit, end=STOPPED)

    @staticmethod
    def levels(orbits: list[Orbit]) -> list[Orbit]:
        """One orbit of each level of work, the least first."""
        levels: list[Orbit] = []
        for orbit in sorted((orbit for orbit in orbits if orbit.state is not None), key=lambda orbit: orbit.work):
            if not levels or orbit.work - levels[-1].work > LEVEL * orbit.work:
                levels.append(orbit)
        return levels


def _nearly(run: Run) -> Settled | None:
    """The steady state as the last cycle shows it, once later ones change its work by no more than a thousandth, if the last changes tell."""
    works = run.works[1:][-_TELLING:]  # not of the cycle from the mean load
    if run.period > 1 or len(works) < _TELLING or not run.last:
        return None
    left, cycle = distance_left([abs(later - earlier) for earlier, later in pairwise(works)], 0.0), replace(run.last[-1], change=0.0)
    return Settled(Outcome.CYCLIC_SLIP, run.path, cycle, left / works[-1], (cycle,)) if left < _ROUGH * works[-1] else None


def _spread(slip: Array, path: Transient) -> float:
    """Largest less least slip; the slip scale of the mean load where all are the same."""
    return spread(slip) or path.force / path.system.stiffness_scale
