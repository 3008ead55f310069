"""Contact forces that balance themselves, and the load at which transients slide off.

For statics, all forces within friction that balance the loads are possible. If there are no loads,
these forces form a cone: the contact forces within friction that balance themselves in all rigid
motions. For a block on a plane, the cone contains only zero. Then the loads bound all contact
forces, and equilibrium is sufficient. For a shaft in a shrunk hub, a plate in a clip or a locked
bolt, the cone contains more. Then statics may add as much of these forces as are needed to hold the
load by friction, whatever pressure the fit has. The cone depends on friction, because a wedge below
its angle of friction holds itself by friction. The cone contains only zero if the normals of all
faces lean from one direction by less than 90 degrees minus the angle of friction.

Only elasticity shows how strongly a fit presses. So the load is found by transients that start from
no slip and are followed until they settle, or for a number of cycles.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...base import Array, OutOfTime, progress_bar
from ...contact import ContactSystem, LoadCycle, reactions
from ...errors import NoContinuation, SolverError

# Numbers of the search for the load factor at which transients slide off.

# Load factor of the first transient, divided by the sliding-off load by statics. If this load is
# infinite, the unit of the loads takes its place.
_START = 1e-2
# The load factor of statics, or the load factor at which first cycles end, is confirmed if a
# transient goes on at this share of it.
_END = 0.99
# Largest load factor that is tried, over the unit of the loads, if statics gives an infinite one.
_END_WITHOUT_STATICS = 1e6
# Ratio of successive load factors until a transient goes on at one of them and ends at another.
_GROWTH = 4.0
# Number of times that the load factor shrinks before the answer is 0.
_MOST_SHRINKS = 10
# Width of the last bracket of load factors, divided by its upper end.
_TOLERANCE = 2e-4
# In space: number of increments from corner to corner, and width of the bracket, which is below the
# error due to the increments.
_STEPS_IN_SPACE = 2
_TOLERANCE_IN_SPACE = 1e-3
# A transient that has not settled after this number of cycles, for instance because a body drifts,
# is followed no further.
_FOLLOWED_CYCLES = 100
# In space: factor by which increments are made finer, to confirm that there is no state.
_FINER = 4


@dataclass(frozen=True)
class Bracket:
    """The transient goes on at load factor `low` and ends at `high`, with the error `why`.

    `low` is 0 if no load factor is known at which it goes on. If the transient ends at no load
    factor, `why` is "".
    """

    low: float
    high: float
    why: str
    # Whether the search ended in time, and whether all cycles (not only the first) were followed.
    complete: bool = True
    cycles: bool = True


def sliding_off(
    system: ContactSystem, cycle: LoadCycle, friction: Array, statics: float, seconds: float
) -> Bracket:
    """A bracket of the load factor above which transients from no slip find no continuation.

    Transients are followed up to `statics`, the load factor of statics. After `seconds` the search
    ends, and the result is the bracket known by then.
    """
    # Imported here, because limits of other contacts need neither transients nor their compiler.
    from ...transients.cycles import Run
    from ...transients.march import path_of
    from ...transients.steady import MOST_CYCLES

    steps = None
    tolerance = _TOLERANCE
    if system.tangents == 2:
        steps = _STEPS_IN_SPACE
        tolerance = _TOLERANCE_IN_SPACE

    def follow_first_cycle(count: int | None, load_factor: float) -> None:
        path = path_of(system, cycle, friction, load_factor, steps=count, retries=False).start()
        for segment in path.segments:
            path.follow([segment])
            bar.update()

    def follow_all_cycles(load_factor: float) -> None:
        path = path_of(system, cycle, friction, load_factor, steps=steps)
        # The run is left long before it would give up by itself: the error that it would then raise
        # would count as the end of the transient.
        run = Run(path.start(), MOST_CYCLES, bar.update)
        while run.cycles < _FOLLOWED_CYCLES and run.advance() is None:
            pass

    if np.isfinite(statics):
        start = _START * statics
        end = _END * statics
    else:
        unit = _load_unit(system, cycle)
        start = _START * unit
        end = _END_WITHOUT_STATICS * unit

    known = Bracket(0.0, np.inf, "")
    cycles = False

    def approach(follow: Callable[[float], None], start: float, end: float, begin: Bracket) -> None:
        nonlocal known
        for known in _approached(partial(_end_of, follow), start, end, begin, tolerance):
            bar.best = f"they reach {known.low:.4g}"

    try:
        with progress_bar(True, "transients", "segment", seconds=seconds) as bar:
            # The first cycle takes little time, even near the load factor that is searched, and it
            # nearly always decides.
            approach(partial(follow_first_cycle, steps), start, end, known)
            if steps and known.why:
                # Newton's method may also miss a state that exists, but hardly so in finer
                # increments.
                first = known.high if known.low > 0 else start
                without_end = Bracket(known.low, np.inf, "")
                approach(partial(follow_first_cycle, _FINER * steps), first, end, without_end)
            why = _end_of(follow_all_cycles, known.low) if known.low > 0 else ""
            cycles = True
            if why:
                # Most transients that end in a later cycle do so just below the load factor at
                # which first cycles end.
                known = Bracket(0.0, known.low, why)
                approach(follow_all_cycles, _END * known.high, known.high, known)
    except OutOfTime:
        return replace(known, complete=False, cycles=cycles)
    return known


def _end_of(follow: Callable[[float], None], load_factor: float) -> str:
    """Why the transient at a load factor finds no continuation; "" if it continues."""
    try:
        follow(load_factor)
    # In space, increments that find no state do not prove that the body slides off.
    except (NoContinuation, SolverError) as error:
        return str(error).split("; ")[0]
    return ""


def _load_unit(system: ContactSystem, cycle: LoadCycle) -> float:
    """Load factor at which the cyclic reactions are as large as the other reactions."""
    constant = float(np.abs(reactions(system, cycle.unscaled)).max())
    cyclic = float(np.abs(reactions(system, cycle.corners)).max())
    return constant / cyclic if constant > 0 and cyclic > 0 else 1.0


def _approached(
    end_at: Callable[[float], str], start: float, end: float, bracket: Bracket, tolerance: float
) -> Iterator[Bracket]:
    """Ever narrower brackets of the load factor at which transients begin to end.

    `end_at` says why the transient at a load factor ends; "" if it goes on.

    Load factors shrink or grow until one is known at which a transient goes on, and one at which it
    ends. Then the bracket is halved.
    """
    trial = start
    smallest = start / _GROWTH**_MOST_SHRINKS
    while bracket.low < min(end, (1 - tolerance) * bracket.high):
        why = end_at(trial)
        bracket = Bracket(bracket.low, trial, why) if why else replace(bracket, low=trial)
        yield bracket
        if np.isinf(bracket.high):
            trial = min(_GROWTH * bracket.low, end)
        elif bracket.low > 0:
            trial = (bracket.low + bracket.high) / 2
        elif bracket.high > smallest:
            trial = bracket.high / _GROWTH
        else:
            return
