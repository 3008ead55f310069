"""Search over the starts for more or less steady dissipation: transients from extreme slips, and from where linear programs point."""

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..base import LEVEL, PERIODIC, RESIDUAL, ROUNDING, Array, Outcome, kept
from ..contact import LoadCycle, lengths, reactions
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import guaranteed_limit, shakedown_limit
from ..limits.open_nodes import open_under_mean
from ..limits.programs import free_slips
from ..limits.question import Question, pose, with_open
from ..limits.safe_vertices import furthest
from ..transients import SteadyState, steady_state
from ..transients.transient import Transient
from ..transients.classify import Settled, distance_left
from ..transients.cycles import Run
from ..transients.march import path_of
from ..transients.steady import reported
from .ascent import Ascent

_WORK_GAIN = 100 * RESIDUAL  # a step that gains less work, relative, is none
_FIRST = 0.25  # first trust region, over the spread of the slips of the orbit
_LEAST = 1e-5 * _FIRST  # last one, over the same
_TRANSIENTS = 20  # of one climb
_LEAP = (
    _TRANSIENTS**2
    # times the gain of a step: a climb that would not reach with so much what another start has is
    # given up
)
_AROUND = (
    8,
    200,
    # starts around an end at least, and at most: of many nodes few, because each costs more and their
    # works differ less
)
_EACH = 1000  # nodes of these starts together, otherwise
_WIDEST, _NARROWEST = (
    2.0,
    0.05,
)  # distances of these starts, over the spread of the slips of the end
_CYCLES = 200  # of a transient, after which it is given up: some take thousands
_ROUGH_STEPS = 5  # increments of a rough search, from corner to corner: a quarter of the usual ones
# of a work, what later cycles change of it and what a step gains that a rough search does not see
_ROUGH = 1e-3
_TELLING = 4  # cycles in turn whose works tell how much later ones change
_CORNERS = 12  # of a sampled history, furthest apart, at which starts are looked for
_BEYOND = (
    3.0,
    10.0,
)  # multiples of the extreme slips from which nodes open on the way to the mean load
STOPPED, FAR = (
    f"stopped after {_TRANSIENTS} transients",
    "far from the end of the range, and with a step hardly nearer",
)


@kept
@dataclass(frozen=True, eq=False)
class Orbit:
    """What came of one start: its name, that of the start that the search began with; and its slip, (N,) or (N, 2), length.

    The steady state that it leads to, and the path that has reached it, at the last corner, are
    None where the transient has no result. The end says why the search from it ended: "followed"
    where there was none.
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
    """Transients of one contact at one load factor, counted; `tell` is called for each.

    A rough search ends transients where later cycles change their work by a thousandth, before
    their state comes back.
    """

    def __init__(
        self,
        task: Question,
        load_factor: float,
        steps: int | None = None,
        tell: Callable[[], object] = lambda: None,
        rough: bool = False,
    ) -> None:
        self._task, self._steps, self._rough = task, steps, rough
        self._asked = task.system, task.cycle, task.friction, load_factor
        self._gain = _ROUGH if rough else _WORK_GAIN
        self.transients, self._tell = 0, tell
        self._extremes: list[float] = []  # works of the local extremes so far
        self._rng = np.random.default_rng(0)
        self._met: list[
            tuple[Array, Orbit]
        ] = []  # states after one cycle, in slip scales, and what came of them

    @property
    def orbits(self) -> list[Orbit]:
        """Those that led to a steady state that no other one had met before."""
        return [orbit for _, orbit in self._met]

    def in_few_increments(self) -> "Search | None":
        """A rough search of the same contact; None on the exact path, and where the increments are few already."""
        steps = path_of(*self._asked, steps=self._steps).steps
        return (
            Search(self._task, self._asked[-1], _ROUGH_STEPS, self._tell, rough=True)
            if steps >= 2 * _ROUGH_STEPS
            else None
        )

    def follow(self, name: str, start: Array, least: float = 0.0, most: int = _CYCLES) -> Orbit:
        """The steady state that one start leads to, unless two cycles one after the other have less work than the least that is looked for.

        The work of a transient falls from cycle to cycle, up to some 2 % in a thousand random ones.
        Where one cycle brings two transients to the same state, the second one goes on as the first
        did.
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
                        if (
                            abs(place[0] - other[0]) <= PERIODIC
                            and np.abs(place - other).max() <= PERIODIC
                        ):  # the first one is quick to tell
                            return replace(met, name=name, start=start)
                elif max(run.works[-2:]) < least and len(run.works) > 2:
                    return Orbit(name, start, None, "less work than looked for")
            orbit = Orbit(
                name,
                start,
                reported(run, found, np.inf if path.steps else 0.0),
                "followed",
                found.path,
            )
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
        return (
            steady_state(*self._asked, initial_slip=orbit.start, steps=self._steps, progress=False)
            if orbit.state.steps
            else orbit.state
        )

    def around(self, orbit: Orbit, least: float) -> list[Orbit]:
        """Orbits of at least so much work from random starts around one; none where any work counts and many nodes let no transient end early."""
        assert orbit.path is not None
        size, count = _spread(orbit.start, orbit.path), _EACH // len(orbit.start)
        if not least and count < 2 * _AROUND[0]:
            return []
        sizes = (
            size
            * _WIDEST
            * (_NARROWEST / _WIDEST) ** np.linspace(0, 1, int(np.clip(count, *_AROUND))) ** 2
        )
        starts = [
            shortened(
                orbit.start + one * self._rng.uniform(-1, 1, orbit.start.shape), self._task.most
            )
            for one in sizes
        ]
        return [
            found
            for start in starts
            if (found := self.follow(f"around {orbit.name}", start, least)).work >= least
        ]

    def climb(self, orbit: Orbit, sense: int) -> Orbit:
        """The orbit with more (sense 1) or less (sense -1) work that steps of linear programs lead to."""
        limit, aim = self.transients + _TRANSIENTS, max(sense * met.work for _, met in self._met)
        radius, unit, ascent = _FIRST, 0.0, None
        while self.transients < limit:
            if ascent is None:
                try:
                    ascent = self._ascent(orbit, sense)
                except (NoContinuation, SolverError) as error:
                    return replace(orbit, end=f"not searched from: {error}")
                unit = unit or _spread(ascent.before, ascent.path)
            step = ascent.step(radius * unit)
            if step is None or not step[1] > self._gain * orbit.work or radius < _LEAST:
                self._extremes.append(orbit.work)
                return replace(orbit, end="local extreme")
            if sense * orbit.work + _LEAP * step[1] < aim:
                return replace(orbit, end=FAR)
            tried = self.follow(
                orbit.name, ascent.before + step[0], orbit.work if sense > 0 else 0.0
            )
            if not sense * (tried.work - orbit.work) > self._gain * orbit.work:
                radius *= 0.25
                continue
            orbit, ascent, radius = tried, None, 2.0 * radius
            if any(abs(orbit.work - known) <= LEVEL * known for known in self._extremes):
                return replace(orbit, end="local extreme known before")
        return replace(orbit, end=STOPPED)

    def _ascent(self, orbit: Orbit, sense: int) -> Ascent:
        path, state = orbit.path, orbit.state
        if (
            path is None
            or state is None
            or state.outcome is not Outcome.CYCLIC_SLIP
            or state.period > 1
        ):
            raise NoContinuation("its slip does not repeat in every cycle")
        return Ascent(path, sense, self._task.most)

    @staticmethod
    def levels(orbits: list[Orbit]) -> list[Orbit]:
        """One orbit of each level of work, the least first."""
        levels: list[Orbit] = []
        for orbit in sorted(
            (orbit for orbit in orbits if orbit.state is not None), key=lambda orbit: orbit.work
        ):
            if not levels or orbit.work - levels[-1].work > LEVEL * orbit.work:
                levels.append(orbit)
        return levels


def _nearly(run: Run) -> Settled | None:
    """The steady state as the last cycle shows it, once later ones change its work by no more than a thousandth, if the last changes tell."""
    works = run.works[1:][-_TELLING:]  # not of the cycle from the mean load
    if run.period > 1 or len(works) < _TELLING or not run.last:
        return None
    left, cycle = (
        distance_left([abs(later - earlier) for earlier, later in pairwise(works)], 0.0),
        replace(run.last[-1], change=0.0),
    )
    return (
        Settled(Outcome.CYCLIC_SLIP, run.path, cycle, left / works[-1], (cycle,))
        if left < _ROUGH * works[-1]
        else None
    )


def _spread(slip: Array, path: Transient) -> float:
    """Largest less least slip; the slip scale of the mean load where all are the same."""
    return float(np.ptp(slip, axis=0).max()) or path.force / path.system.stiffness_scale


class RangeStarts:
    """Starts of a search: extreme slips that one contact can hold under the loads of its cycle at one load factor."""

    def __init__(self, task: Question, load_factor: float) -> None:
        self._task, self._load_factor = task, load_factor

    def simple(self) -> dict[str, Array]:
        """No slip, and the slip that is safe at the shakedown limit, if a solver proves one."""
        task = self._task
        starts = {"no slip": np.zeros(task.system.slip_shape)}
        with suppress(SolverError):
            limit = shakedown_limit(task.system, task.cycle, task.friction, slip_bound=task.most)
            starts |= (
                {"safe at the shakedown limit": limit.slip}
                if np.isfinite(limit.load_factor)
                else {}
            )
        return starts

    @cached_property
    def under_mean_load(self) -> dict[str, Array]:
        """The admissible slips under the mean load that go furthest in each direction, each once."""
        return self._furthest(self._task.cycle.mean, "under the mean load")

    def at_corners(self) -> dict[str, Array]:
        """The same at every corner, of many at those that are furthest apart."""
        cycle, loads, slips = (
            self._task.cycle,
            self._task.cycle.at(self._load_factor),
            dict[str, Array](),
        )
        for k in _furthest_apart(reactions(self._task.system, loads)):
            slips |= self._furthest(loads[k], f"at {cycle.corner_names[k]}")
        return slips

    def _furthest(self, loads: Mapping[str, float], place: str) -> dict[str, Array]:
        system, friction, most = self._task.system, self._task.friction, self._task.most

        def extremes(task: Question) -> list[Array | None]:
            give, unit = (
                free_slips(task)[1],
                np.tile(task.node_unit, system.tangents),
            )  # a traction counts by the slip that it makes
            ways = (
                unit * (give @ (way.T * ~task.open).ravel()) for way in self._directions.values()
            )
            return furthest(task, 0.0, ways)

        slips = list[
            Array | None
        ]()  # some starts less where none is found; the range is that of the starts followed
        with suppress(ModelError, SolverError):
            task = pose(system, LoadCycle(loads, [{}]), friction, slip_bound=most)
            with suppress(
                SolverError
            ):  # solvers tell no slip at all from an answer that is none only where both are plain
                slips = extremes(task)
            if (
                all(slip is None for slip in slips)
                and (opened := open_under_mean(task))
                and (rest := with_open(task, opened[0]))
            ):
                slips = extremes(rest)
        found = dict[str, Array]()
        for name, slip in zip(self._directions, slips, strict=False):
            if slip is not None and all(
                np.abs(slip - other).max() > RESIDUAL * np.abs(slip).max()
                for other in found.values()
            ):
                found[f"{name}, {place}"] = slip
        return found

    def beyond(self) -> list[list[tuple[str, Array]]]:
        """Multiples of each extreme slip under the mean load, as far as the slip bound allows: more than the closed contact can hold."""
        most, extreme = self._task.most, self.under_mean_load
        return [
            [(f"{factor:g} x {name}", shortened(factor * slip, most)) for factor in _BEYOND]
            for name, slip in extreme.items()
        ]

    def witness(self) -> dict[str, Array]:
        """The witness of the guaranteed limit, from which slip goes on just above it."""
        task = self._task
        try:
            lower = guaranteed_limit(task.system, task.cycle, task.friction, slip_bound=task.most)
        except (ModelError, SolverError):
            return {}  # in space it is not known where a part of the cycle is fixed
        return (
            {"witness of the guaranteed limit": lower.slip}
            if np.isfinite(lower.load_factor)
            else {}
        )

    @cached_property
    def _directions(self) -> Mapping[str, Array]:
        """Directions of slip, (N,) or (N, 2): along changes of the load, stretched, squeezed, turned, and those that unload an end of the contact."""
        system, q1 = self._task.system, self._task.cycle.corner_reactions(self._task.system)[0]
        changes: dict[str, Array] = {}
        for name, step in zip(
            self._task.cycle.corner_names, np.roll(q1, -1, axis=0) - q1, strict=True
        ):
            size = float(np.linalg.norm(step))
            if size > 0 and not any(
                np.abs(step / size - other).max() <= ROUNDING for other in changes.values()
            ):
                changes |= {
                    f"along the load after {name}": step / size,
                    f"against the load after {name}": -step / size,
                }
        if system.tangents == 1:
            x = system.x - system.x.mean()
            return changes | {
                "stretched": x,
                "squeezed": -x,
                "left end unloaded": -system.B[0],
                "right end unloaded": -system.B[-1],
            }
        x, y = np.einsum(
            "nij,nj->in", system.frames[:, :2], system.points - system.points.mean(axis=0)
        )
        still, ends = (
            np.zeros_like(x),
            sorted({int(along.argmax()) for along in (x + y, x - y, y - x, -x - y)}),
        )
        ways = {
            "stretched along tangent 1": (x, still),
            "stretched along tangent 2": (still, y),
            "turned": (-y, x),
        }
        fields = {name: np.transpose(way) for name, way in ways.items()}
        unloaded = {f"node {node} unloaded": -system.B[node].reshape(2, -1).T for node in ends}
        return (
            changes
            | fields
            | unloaded
            | {f"{name}, reversed": -field for name, field in fields.items()}
        )


def _furthest_apart(vectors: Array) -> list[int]:
    """Numbers of those of many vectors that are furthest apart: each next one is as far as can be from the nearest one chosen, and from zero."""
    if len(vectors) <= _CORNERS:
        return list(range(len(vectors)))
    chosen, distance = list[int](), np.linalg.norm(vectors, axis=1)
    for _ in range(_CORNERS):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(vectors - vectors[chosen[-1]], axis=1))
    return sorted(chosen)


def shortened(slip: Array, most: Array | None) -> Array:
    """A slip, (N,) or (N, 2), cut to lengths of at most `most`, (N,), if that is given."""
    if most is None:
        return slip
    size = lengths(slip, most)
    return np.asarray((slip.T * np.minimum(1.0, most / np.where(size > 0, size, 1.0))).T)
