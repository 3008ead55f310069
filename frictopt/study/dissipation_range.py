"""The range of steady dissipation over residual slips: a search from many starts.

The search finds an inner estimate of the true range, because both ends are steady states that
occur.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import pandas as pd

from ..base import (
    LEVEL,
    Array,
    Kept,
    PerNode,
    Plotted,
    finite_number,
    frozen,
    progress_bar,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle
from ..errors import NoContinuation
from ..limits import pose
from ..transients import SteadyState
from ..transients.steady import MOST_CYCLES
from .range_search import FAR, STOPPED, Orbit, Search, levels_of
from .range_starts import RangeStarts

# Numbers of the order in which a range is searched.

# Number of levels with the most work, and with the least work, from which the first search goes on.
# A level is a work of friction that differs from all other works found.
_CLIMBED = 12
_DESCENDED = 2
# Largest number of rounds of random starts around both ends, and number of the best random starts
# at each end from which the search goes on.
_ROUNDS = 8
_CLIMBED_AROUND = 4
# The search goes on from random starts whose work differs from the work of the end by at most this
# share of the range.
_REACH = 0.2
# Relative change of an end after which random starts are tried again.
_MOVED = 1e-3
# Number of levels at each end of a rough search that are followed again in all increments.
_CONFIRMED = 4


@dataclass(frozen=True, eq=False, repr=False)
class DissipationRange(Kept, Plotted):
    """The least and the largest steady dissipation of all starts tried.

    Both values occur. They are no bounds: the true range is at least as wide. Only `least = 0` is
    known to be the true least, because no work of friction is negative.

    Attributes
    ----------
    least, most
        Least and largest work of friction per cycle (force times length per depth; in space, force
        times length).
    least_start, worst_start
        (N,) or (N, 2) residual slips, length, that lead to `least` and to `most`; `steady_state`
        accepts them.
    least_state, most_state
        The steady states of these starts. In space `step_error` is the error of the increments,
        relative to the work.
    levels
        Different works of friction at the ends of the searches, in rising order. With ten
        increments or more, only the last searches are included.
    transients, residual
        Number of transients followed, and largest residual of the steady states of `least` and
        `most`, at most 1e-9.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> span = fo.dissipation_range(rod, cycle, friction=0.5, load_factor=1.0)
    >>> round(span.least, 6), round(span.most, 6)  # without coupling every start has the same work
    (1.0, 1.0)
    """

    _shown_names = ("least", "most", "transients", "residual", "proven")
    proven: ClassVar[bool] = False
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

    def _answer(self) -> Mapping[str, object]:
        failed = sum(orbit.state is None for orbit in self._orbits)
        if not failed:
            return super()._answer()
        text = f"{failed} of {len(self._orbits)} starts and ends of searches"
        return {**super()._answer(), "failed": text}

    @property
    def steady_states(self) -> list[SteadyState]:
        """A steady state of each work of friction found, the least first."""
        return [orbit.state for orbit in levels_of(self._orbits) if orbit.state is not None]

    def to_frame(self) -> pd.DataFrame:
        """A row for each start that the search began with, and for each end of a search.

        Ends of a rough search have no rows. Columns: start, the name of the start; dissipation,
        work of friction per steady cycle, NaN if the transient has no result; outcome; open, the
        number of nodes that open in the steady cycle; end. For a start, `end` is "followed"; for
        the end of a search, it is the reason why the search ended; if the transient failed, it is
        the text of the error.
        """
        rows = []
        for orbit in self._orbits:
            state = orbit.state
            outcome = "FAILED" if state is None else state.outcome.name
            open_nodes = 0 if state is None else int(state.open.sum())
            rows.append((orbit.name, orbit.work, outcome, open_nodes, orbit.end))
        return pd.DataFrame(rows, columns=["start", "dissipation", "outcome", "open", "end"])


@warns_of_odd_values
def dissipation_range(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    load_factor: float,
    *,
    slip_bound: PerNode | None = None,
    steps: int | None = None,
    progress: bool = True,
) -> DissipationRange:
    """Find the least and the largest steady dissipation over all residual slips at the beginning.

    1. Transients are exact in the plane, and consist of increments in space. They start from no
       slip, from the slip that is safe at the shakedown limit, and from extreme slips that the
       contact can hold under the mean load or at a corner. If there are more than twelve corners,
       the twelve corners that are furthest apart are used. An extreme slip is the furthest slip in
       a direction: along or against a change of the load, a direction that stretches, squeezes or
       turns the face, or one that unloads an end of the contact. If slip stops from all these
       starts, the witness of the guaranteed limit is the next start.
    2. Sequential linear programming improves the best starts, with the derivative of a cycle. Its
       unknowns are the slips of the nodes that stay locked, because the work depends only on these.
       A transient checks each step. These steps end if they find no better slip; the end need not
       be a local extreme.
    3. Therefore random starts around both ends are followed, too, and the search goes on from the
       best of them. No random starts are tried around the start with the least work if this work is
       not zero and the contact has more than 62 nodes.

    If ten increments or more are requested, this search uses only five, and transients end when
    later cycles change their work by less than a thousandth. The four levels with the most work and
    the four with the least are then followed in all increments, and the search goes on from the
    best at each end. The search takes some hundreds of transients, for any number of nodes. A
    transient without a steady state after 200 cycles is given up (after 2000 cycles for these eight
    levels); `to_frame` lists such transients.

    The result is an inner estimate without a bound: other starts may have more work. Transients in
    which nodes open are included, but the search does not continue from them.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and its coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    slip_bound
        Largest residual slip `abs(v)` of the starts, one or one per node, length; None for no
        bound. A slide of the whole body counts as slip.
    steps, progress
        Number of increments from corner to corner (None: the exact path in the plane, 20 in space),
        and whether to show the progress after two seconds. Ctrl-C raises KeyboardInterrupt. Its
        attribute `range` is the range so far, from transients with the full number of increments,
        without step error.

    Returns
    -------
    DissipationRange
        The states with the least and the most work found, and their starts.

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
    >>> worst = fo.steady_state(pair, cycle, 0.6, 0.5, initial_slip=span.worst_start)
    >>> worst.dissipation == span.most
    True
    """
    question = pose(system, cycle, friction, slip_bound=slip_bound)
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    starts = RangeStarts(question, load_factor)
    with progress_bar(progress, "dissipation range", "transient") as bar:

        def range_so_far() -> DissipationRange:
            orbits = search.orbits
            return _result(orbits, levels_of(orbits), search.transients, lambda orbit: orbit.state)

        def count() -> None:
            works = [orbit.work for orbit in search.orbits]
            if works:
                best = f"work from {min(works):.4g} to {max(works):.4g} so far"
                note = f"{best}: the attribute `range` has the range of the transients so far"
                bar.keep("range", range_so_far, note, best)
            bar.update()

        search = Search(question, load_factor, steps, count)
        return _range(search, starts)


def _range(search: Search, starts: RangeStarts) -> DissipationRange:
    """The range that a search from these starts finds, first in few increments if possible."""
    followed = _follow_starts(search, starts)
    transients = 0
    rough_levels = list[Orbit]()
    rough = search.in_few_increments()
    if rough is not None:
        rough_levels = levels_of(rough.follow(orbit.name, orbit.start) for orbit in followed)
        if rough_levels:
            rough_levels = levels_of([*rough_levels, *_search_from(rough, rough_levels)])
        transients = rough.transients

    count = _CONFIRMED
    for orbit in dict.fromkeys([*rough_levels[:count], *rough_levels[-count:]]):
        followed.append(search.follow(orbit.name, orbit.start, most=MOST_CYCLES))
    levels = levels_of(followed)
    if not levels:
        raise NoContinuation(
            f"dissipation range: none of {len(followed)} transients has a result; the first "
            f"error is: {followed[0].end}"
        )
    if rough_levels:
        ends = _climb_from(search, low=levels[:1], high=levels[-1:])
    else:
        ends = _search_from(search, levels)

    reached = [end for end in ends if end.end != FAR]
    return _result(
        [*followed, *ends],
        levels_of(reached or levels),
        search.transients + transients,
        search.final_state,
    )


def _follow_starts(search: Search, starts: RangeStarts) -> list[Orbit]:
    """The orbits from all starts. Each group of starts is followed before the next is computed."""
    orbits = search.follow_all(starts.simple())
    orbits += search.follow_all(starts.under_mean_load)
    orbits += search.follow_all(starts.at_corners())
    if not any(orbit.work > 0 for orbit in orbits):
        orbits += search.follow_all(starts.witness())
    if any(orbit.state is not None and orbit.state.open.any() for orbit in orbits):
        for multiples in starts.multiplied():
            orbits += search.further(multiples)
    return orbits


def _search_from(search: Search, levels: list[Orbit]) -> list[Orbit]:
    """Ends of the search from the best levels, and from the best random starts around both ends.

    The random starts are needed, because starts beside a local extreme, or far away from it, may
    have more or less work. If an end is no local extreme, the search goes on from it.
    """
    ends = _climb_from(search, low=levels[:_DESCENDED], high=levels[::-1][:_CLIMBED])
    for _ in range(_ROUNDS):
        known = levels_of([*levels, *ends])
        low, high = known[0], known[-1]
        reach = _REACH * (high.work - low.work)
        near = search.around(high, high.work - reach)
        near += search.around(low, 0.0 if low.work > 0 else high.work - reach)
        new = [
            orbit
            for orbit in levels_of(near)
            if all(abs(orbit.work - end.work) > LEVEL * end.work for end in ends)
        ]
        ends += _climb_around(search, high, 1, new[::-1], reach)
        if low.work > 0:
            ends += _climb_around(search, low, -1, new, reach)
        least = low.work * (1 - _MOVED)
        most = high.work * (1 + _MOVED)
        if all(least <= end.work <= most for end in ends):
            break
    return ends


def _climb_around(
    search: Search, best: Orbit, sense: int, new: list[Orbit], reach: float
) -> list[Orbit]:
    """Ends of the search from the best new levels near one end, and from a stopped end itself."""
    near = [orbit for orbit in new if sense * (best.work - orbit.work) <= reach]
    near = near[:_CLIMBED_AROUND]
    if best.end == STOPPED:
        near.insert(0, best)
    return [search.climb(orbit, sense) for orbit in near]


def _climb_from(search: Search, low: list[Orbit], high: list[Orbit]) -> list[Orbit]:
    """Ends of the search for more work from `high`, and for less from `low` if no work is 0."""
    ends = [search.climb(orbit, 1) for orbit in high if orbit.work > 0]
    if low[0].work > 0:
        ends += [search.climb(orbit, -1) for orbit in low]
    return ends


def _result(
    orbits: Sequence[Orbit],
    levels: Sequence[Orbit],
    transients: int,
    final_state: Callable[[Orbit], SteadyState | None],
) -> DissipationRange:
    """The range of orbits of which at least one has a steady state."""
    results = [orbit for orbit in orbits if orbit.state is not None]
    low = min(results, key=lambda orbit: orbit.work)
    high = max(results, key=lambda orbit: orbit.work)
    least = final_state(low)
    most = least if high is low else final_state(high)
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
