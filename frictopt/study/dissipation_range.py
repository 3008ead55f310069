"""The range of steady dissipation that searches over the starts find: an inner estimate of the true one, made of steady states that occur."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import pandas as pd
from numpy.typing import ArrayLike

from ..base import LEVEL, Array, Kept, Plotted, bar_of, finite_number, frozen, warns_of_odd_values
from ..contact import ContactSystem, LoadCycle
from ..errors import NoContinuation
from ..limits.question import pose
from ..transients import SteadyState
from ..transients.steady import MOST_CYCLES
from .range_search import FAR, STOPPED, Orbit, RangeStarts, Search

_CLIMBED, _DESCENDED = (
    12,
    2,
)  # levels of work, the highest and the lowest, from which the search goes on
_CLIMBED_BESIDE, _ROUNDS = (
    4,
    8,
    # the best levels around the ends from which it goes on to each, and how often it looks around them
)
_WIDER = 1e-3  # how much an end moves, over itself, where the search looks around again
_SURE = 4  # levels of a rough search at each end that are followed in all increments
_BESIDE = 0.2  # how far from an end these levels are at most, over the range


@dataclass(frozen=True, eq=False, repr=False)
class DissipationRange(Kept, Plotted):
    """The least and the largest steady dissipation of all starts tried: two that occur, not bounds of what may occur.

    The true range is at least as wide. Only `least = 0` is known to be the true least, for no work
    of friction is negative.

    Attributes
    ----------
    least, most
        Least and largest work of friction per cycle, force times length per depth, in space force
        times length.
    least_start, worst_start
        (N,) or (N, 2) residual slips that lead to them, for `steady_state`, length.
    least_state, most_state
        Their steady states. In space `step_error` says what the increments leave, of the work over
        itself.
    levels
        Works of friction where searches ended, each once, in rising order; of ten increments or
        more those of the last searches alone.
    transients, residual
        Number of transients followed, and largest residual of the steady states of `least` and
        `most`, at most 1e-9.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> span = fo.dissipation_range(rod, cycle, friction=0.5, load_factor=1.0)  # without coupling every start has the same work
    >>> round(span.least, 6), round(span.most, 6)
    (1.0, 1.0)
    """

    least: float
    most: float
    least_start: Array = field(repr=False)
    worst_start: Array = field(repr=False)
    least_state: SteadyState = field(repr=False)
    most_state: SteadyState = field(repr=False)
    transients: int
    levels: tuple[float, ...]
    residual: float
    _orbits: tuple[Orbit, ...] = field(repr=False)

    @property
    def steady_states(self) -> list[SteadyState]:
        """One steady state of each work of friction found, the least first."""
        return [
            orbit.state for orbit in Search.levels(list(self._orbits)) if orbit.state is not None
        ]

    def to_frame(self) -> pd.DataFrame:
        """One row for each start that the search began with, and for each end of a search in all increments.

        Columns: start, its name; dissipation, work of friction per steady cycle, NaN where the
        transient has no result; outcome; open, the number of nodes that open in the steady cycle;
        end, "followed" for a start, otherwise why the search from it ended; or the text of the
        error.
        """
        told = [
            ("FAILED", 0)
            if one.state is None
            else (one.state.outcome.name, int(one.state.open.sum()))
            for one in self._orbits
        ]
        rows = [
            (one.name, one.work, *of, one.end) for one, of in zip(self._orbits, told, strict=True)
        ]
        return pd.DataFrame(rows, columns=["start", "dissipation", "outcome", "open", "end"])

    def _answer(self) -> Mapping[str, object]:
        lost = sum(orbit.state is None for orbit in self._orbits)
        failed = (
            {"failed": f"{lost} of {len(self._orbits)} starts and ends of searches"} if lost else {}
        )
        return (
            {name: getattr(self, name) for name in ("least", "most", "transients", "residual")}
            | failed
            | {"proven": False}
        )


@warns_of_odd_values
def dissipation_range(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    slip_bound: ArrayLike | None = None,
    steps: int | None = None,
    progress: bool = True,
) -> DissipationRange:
    """Find the least and the most that the contact dissipates per steady cycle, over all residual slips that it may start with.

    Transients, exact in the plane and in increments in space, start from no slip, from the slip
    that is safe at the shakedown limit, and from extreme slips that the contact can hold under the
    mean load or at a corner (of more than twelve the twelve that are furthest apart). These go
    furthest along the changes of the load, stretched, squeezed or turned, or unload an end of the
    contact. If slip stops from all of these, the witness of the guaranteed limit follows. From the
    best of them, sequential linear programming goes on over the slips of the nodes that stay
    locked, on which alone the work depends, by the derivative of a cycle. Each step is judged by a
    transient. Such steps end where they find nothing better, which need not be a local extreme. So
    random starts around both ends are followed too, and the search goes on from the best of them.
    Around the start of least work there are none where the contact has more than 62 nodes and that
    work is not zero.

    Where there are ten increments or more, all this is done with five, and transients end where
    later cycles change their work by a thousandth. The four levels with the most work and the four
    with the least are then followed in all increments, and the search goes on from the best at each
    end. It takes some hundreds of transients, whatever the number of nodes. A transient without a
    steady state in 200 cycles, of these levels in 2000, is given up: `to_frame` says which.

    The result is an inner estimate, which no theorem closes: other starts may have more work.
    Orbits on which nodes open are counted but not searched from.

    Parameters
    ----------
    system, cycle, friction, load_factor
        The contact, its load cycle, its coefficient of friction, one or one per node, and the load
        factor, >= 0.
    slip_bound
        Largest residual slip `abs(v)` of the starts, one or one per node, length; None for no
        bound. A slide of the whole body counts.
    steps, progress
        Number of increments from corner to corner (None: the exact path in the plane, 20 in space),
        and whether to show after two seconds how far it is. Ctrl-C stays a KeyboardInterrupt; its
        attribute `range` is that of the transients in all increments by then, without their step
        error.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        No transient from any start has a result.

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> span = fo.dissipation_range(pair, cycle, friction=0.6, load_factor=0.5)
    >>> span.least, round(span.most, 6)
    (0.0, 0.042928)
    >>> worst = fo.steady_state(pair, cycle, friction=0.6, load_factor=0.5, initial_slip=span.worst_start)
    >>> worst.dissipation == span.most
    True
    """
    task = pose(system, cycle, friction, slip_bound=slip_bound)
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    starts, runs = (
        RangeStarts(task, load_factor),
        Search(task, load_factor, steps, lambda: bar.update()),
    )

    def told() -> str:
        works = [orbit.work for orbit in runs.orbits]
        return f"work from {min(works):.4g} to {max(works):.4g} so far" if works else ""

    def kept(_: object) -> tuple[str, object, str] | None:
        found = runs.orbits
        why = f"{told()}: the attribute `range` is that of the transients by then"
        return (
            (
                "range",
                _result(found, lambda orbit: orbit.state, runs.levels(found), runs.transients),
                why,
            )
            if found
            else None
        )

    with bar_of(progress, "dissipation range", "transient", best=told, keeps=kept) as bar:
        return _range(runs, starts)


def _range(runs: Search, starts: RangeStarts) -> DissipationRange:
    """The range that a search from these starts finds."""
    parts = starts.simple, lambda: starts.under_mean_load, starts.at_corners
    followed = [
        runs.follow(name, slip) for part in parts for name, slip in part().items()
    ]  # by turns with their programs, which the bar waits for
    if not any(orbit.work > 0 for orbit in followed):
        followed += [runs.follow(name, slip) for name, slip in starts.witness().items()]
    if any(orbit.state is not None and orbit.state.open.any() for orbit in followed):
        followed += [orbit for row in starts.beyond() for orbit in runs.further(row)]
    levels = runs.levels(followed)
    rough = runs.in_few_increments()
    begun = (
        rough.levels([rough.follow(orbit.name, orbit.start) for orbit in followed]) if rough else []
    )
    if rough and begun:
        found = rough.levels([*begun, *_searched(rough, begun)])
        followed += [
            runs.follow(orbit.name, orbit.start, most=MOST_CYCLES)
            for orbit in dict.fromkeys((*found[:_SURE], *found[-_SURE:]))
        ]
        levels = runs.levels(followed)
    if not levels:
        raise NoContinuation(
            f"dissipation range: none of {len(followed)} transients has a result; the first one says: {followed[0].end}"
        )
    ends = _climbed(runs, levels[:1], levels[-1:]) if begun else _searched(runs, levels)
    known = runs.levels([end for end in ends if end.end != FAR] or levels)
    return _result(
        [*followed, *ends], runs.told, known, runs.transients + (rough.transients if rough else 0)
    )


def _result(
    orbits: Sequence[Orbit],
    told: Callable[[Orbit], SteadyState | None],
    levels: Sequence[Orbit],
    transients: int,
) -> DissipationRange:
    """The range of orbits of which at least one has a steady state; `told` gives that of an end."""
    found = [orbit for orbit in orbits if orbit.state is not None]
    low, high = min(found, key=lambda orbit: orbit.work), max(found, key=lambda orbit: orbit.work)
    least = told(low)
    most = least if high is low else told(high)
    assert least is not None and most is not None
    return DissipationRange(
        least=least.dissipation,
        most=most.dissipation,
        least_start=frozen(low.start),
        worst_start=frozen(high.start),
        least_state=least,
        most_state=most,
        transients=transients,
        levels=tuple(orbit.work for orbit in levels),
        residual=max(least.residual, most.residual),
        _orbits=tuple(replace(orbit, path=None) for orbit in orbits),  # paths are large
    )


def _searched(runs: Search, levels: list[Orbit]) -> list[Orbit]:
    """Where the search ends from the levels with the most and the least work, and from the best random starts around both ends.

    A local extreme may have more or less work beside it, or a basin of its own far away. An end
    that is no local extreme is searched from again.
    """
    ends = _climbed(runs, levels[:_DESCENDED], levels[::-1][:_CLIMBED])
    for _ in range(_ROUNDS):
        found = runs.levels([*levels, *ends])
        low, high, far = found[0], found[-1], _BESIDE * (found[-1].work - found[0].work)
        near = [
            *runs.around(high, high.work - far),
            *runs.around(low, 0.0 if low.work > 0 else high.work - far),
        ]
        new = [
            orbit
            for orbit in runs.levels(near)
            if all(abs(orbit.work - end.work) > LEVEL * end.work for end in ends)
        ]
        for best, sense in ((high, 1), (low, -1)) if low.work > 0 else ((high, 1),):
            beside = [orbit for orbit in new[::-sense] if sense * (best.work - orbit.work) <= far][
                :_CLIMBED_BESIDE
            ]
            ends += [runs.climb(orbit, sense) for orbit in [best] * (best.end == STOPPED) + beside]
        if all(low.work * (1 - _WIDER) <= end.work <= high.work * (1 + _WIDER) for end in ends):
            break
    return ends


def _climbed(runs: Search, low: list[Orbit], high: list[Orbit]) -> list[Orbit]:
    """Where the search ends from some levels with the most work, and, where no start came to rest, from some with the least."""
    return [runs.climb(orbit, 1) for orbit in high if orbit.work > 0] + [
        runs.climb(orbit, -1) for orbit in low if low[0].work > 0
    ]
