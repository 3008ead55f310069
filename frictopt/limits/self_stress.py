"""Contact forces that balance themselves, and the load at which transients slide off.

Statics treats all forces within friction that balance the loads as possible. Without loads these
forces form a cone: the contact forces within friction that balance themselves in all rigid motions,
and press somewhere. If this cone contains only zero, as for a block on a plane, the loads bound all
contact forces, and equilibrium is sufficient. If it is not, as of a shaft in a shrunk hub, of a
plate in a clip or of a locked bolt, statics may add as much of these forces as friction needs,
whatever the fit gives. The cone includes friction, because a wedge below its angle of friction
holds itself by friction. Faces whose normals lean from one direction by less than 90 degrees less
the angle of friction have no such forces.

Elasticity alone knows how far a fit presses. So transients from no slip, up to their steady states,
find the load.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..base import Array
from ..contact import ContactSystem, LoadCycle, contact_law, reactions
from ..errors import NoContinuation, SolverError

# Forces balance themselves if their sums in the rigid motions are below this share of the sum of
# their pressures.
_BALANCED = 1e-6

_UNDECIDED = (
    "self-stress: the solver does not decide whether contact forces balance themselves ({})"
)
_OUTSIDE = (
    "self-stress: contact forces that balance themselves are outside friction by more than rounding"
)


@dataclass(frozen=True)
class SlidingOffSearch:
    """Numbers of the search for the load factor at which transients slide off."""

    # Load factor of the first transient, divided by the load factor of statics, or by the unit of
    # the loads.
    start: float = 1e-2
    # Share of the load factor of statics. A transient that goes on there confirms statics.
    end: float = 0.99
    # Largest load factor, over the unit of the loads, if that of statics is infinite.
    end_without_statics: float = 1e6
    # Ratio of two load factors while the search looks for one below and one above.
    growth: float = 4.0
    # Number of times that the load factor shrinks before the answer is 0.
    most_shrinks: int = 10
    # Parts of a bracket, which are tried from below.
    parts: int = 8
    # Width of the last bracket, over its upper end, in the plane and in space.
    tolerance: tuple[float, float] = (2e-4, 2e-3)
    # Increments from corner to corner in space.
    steps_in_space: int = 2


SEARCH = SlidingOffSearch()


@dataclass(frozen=True)
class Bracket:
    """The transient goes on at load factor `low` and ends at `high`; `why` is its error.

    `low` is 0 if it ends at every load factor. `why` is "" if it ends nowhere.
    """

    low: float
    high: float
    why: str


def self_stress(system: ContactSystem, friction: Array, N: Array) -> Array | None:
    """Contact forces (t + 1, N) within friction that balance themselves; None if there are none.

    They do no work in the rigid motions N, and their pressures add up to 1.
    """
    # A node with a shear strength does not wedge: its bound does not grow with the pressure.
    wedging_friction = contact_law(system, friction).wedging_slope

    forces = cp.Variable((system.tangents + 1, system.nodes))
    pressure = forces[-1]
    within = cp.norm(forces[:-1], axis=0) <= cp.multiply(wedging_friction, pressure)
    sums = N.T @ cp.vec(forces, order="C")
    problem = cp.Problem(
        cp.Minimize(cp.norm1(sums)), [within, pressure >= 0, cp.sum(pressure) == 1]
    )
    try:
        problem.solve(solver=cp.CLARABEL)
    except cp.SolverError as error:
        raise SolverError(_UNDECIDED.format(error)) from error
    if problem.status != cp.OPTIMAL:
        raise SolverError(_UNDECIDED.format(f"status {problem.status}"))
    if problem.value > _BALANCED:
        return None

    stress = np.asarray(forces.value)
    q = np.linalg.norm(stress[:-1], axis=0)
    p = stress[-1]
    if (q > wedging_friction * p.clip(0.0) + _BALANCED).any() or p.min() < -_BALANCED:
        raise SolverError(_OUTSIDE)
    return stress


def sliding_off(
    system: ContactSystem, cycle: LoadCycle, friction: Array, statics: float
) -> tuple[float, str]:
    """Load factor above which the transient from no slip finds no continuation, and its error.

    `statics` is the load factor of statics, the answer with the error "" if the transient goes on
    up to there.
    """
    # Imported here, because limits of other contacts need neither transients nor their compiler.
    from ..transients.march import path_of
    from ..transients.steady import steady_without_step_error

    steps = SEARCH.steps_in_space if system.tangents == 2 else None
    tolerance = SEARCH.tolerance[system.tangents - 1]

    def follow_first_cycle(load_factor: float) -> None:
        path = path_of(system, cycle, friction, load_factor, steps=steps).start()
        path.follow(path.legs)

    def follow_all_cycles(load_factor: float) -> None:
        steady_without_step_error(system, cycle, friction, load_factor, None, steps)

    def end_in_first_cycle(load_factor: float) -> str:
        return _end_of(follow_first_cycle, load_factor)

    def end_in_any_cycle(load_factor: float) -> str:
        return _end_of(follow_all_cycles, load_factor)

    if np.isfinite(statics):
        start = SEARCH.start * statics
        end = SEARCH.end * statics
    else:
        unit = _load_unit(system, cycle)
        start = SEARCH.start * unit
        end = SEARCH.end_without_statics * unit

    # The first cycle takes little time, also near the load that is sought, and nearly always
    # decides.
    bracket = _approached(end_in_first_cycle, start, end, tolerance)
    if bracket.low > 0 and end_in_any_cycle(bracket.low):
        first = SEARCH.start * bracket.low
        bracket = _approached(end_in_any_cycle, first, bracket.low, tolerance)
    return (bracket.low, bracket.why) if bracket.why else (statics, "")


def _end_of(follow: Callable[[float], None], load_factor: float) -> str:
    """Why the transient at a load factor finds no continuation; "" if it continues."""
    try:
        follow(load_factor)
    # Increments in space find no state of a body that slides off, and prove nothing.
    except (NoContinuation, SolverError) as error:
        return str(error).split("; ")[0]
    return ""


def _load_unit(system: ContactSystem, cycle: LoadCycle) -> float:
    """Load factor at which the cyclic reactions are as large as the other reactions."""
    constant = float(np.abs(reactions(system, cycle.unscaled)).max())
    cyclic = float(np.abs(reactions(system, cycle.corners)).max())
    return constant / cyclic if constant > 0 and cyclic > 0 else 1.0


def _approached(
    end_at: Callable[[float], str], start: float, end: float, tolerance: float
) -> Bracket:
    """The narrow bracket in which transients begin to end; `end_at` says why one ends, or "".

    A transient that continues takes far less time than a transient that finds no continuation. So
    the load factor is approached from below.
    """
    why = end_at(start)
    if why:
        bracket = _bracket_below(end_at, start, why)
    else:
        bracket = _bracket_above(end_at, start, end)
    if bracket.low == 0 or not bracket.why:
        return bracket
    while bracket.high - bracket.low > tolerance * bracket.high:
        bracket = _first_part_with_an_end(end_at, bracket)
    return bracket


def _bracket_below(end_at: Callable[[float], str], high: float, why: str) -> Bracket:
    for _ in range(SEARCH.most_shrinks):
        low = high / SEARCH.growth
        why_below = end_at(low)
        if not why_below:
            return Bracket(low, high, why)
        high, why = low, why_below
    return Bracket(0.0, high, why)


def _bracket_above(end_at: Callable[[float], str], low: float, end: float) -> Bracket:
    while low < end:
        high = min(SEARCH.growth * low, end)
        why = end_at(high)
        if why:
            return Bracket(low, high, why)
        low = high
    return Bracket(end, end, "")


def _first_part_with_an_end(end_at: Callable[[float], str], bracket: Bracket) -> Bracket:
    low = bracket.low
    width = (bracket.high - bracket.low) / SEARCH.parts
    for trial in (bracket.low + width * np.arange(1, SEARCH.parts)).tolist():
        why = end_at(trial)
        if why:
            return Bracket(low, trial, why)
        low = trial
    return Bracket(low, bracket.high, bracket.why)
