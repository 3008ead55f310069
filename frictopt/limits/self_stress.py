"""Contact forces that balance themselves, and the load at which a transient slides off where statics cannot know how far a fit presses.

Statics takes every force within friction for possible that balances the loads. Without loads these
forces form a cone: the contact forces within friction that balance themselves in all rigid motions,
pressed somewhere. If that cone is zero, as of a block on a plane, the loads bound all contact
forces, and statics needs no more. If it is not, as of a shaft in a shrunk hub, of a plate in a clip
or of a locked bolt, statics may add as much of these forces as friction needs, whatever the fit
gives. Friction belongs to the cone: a wedge steeper than its angle of friction holds itself by it.
Faces whose normals lean from one direction by less than 90 degrees less the angle of friction have
no such forces.

How far a fit presses is known to elasticity alone. So the load is found by transients from no slip,
up to their steady states.
"""

from collections.abc import Callable

import cvxpy as cp
import numpy as np

from ..base import Array
from ..contact import ContactSystem, LoadCycle, reactions
from ..errors import NoContinuation, SolverError

# sum of the forces in the rigid motions, over the sum of their pressures, below which they balance
# themselves
_BALANCED = 1e-6
_BELOW = (
    0.99  # share of the load factor of statics at which a transient shows that statics is right
)
_START, _FAR = (
    1e-2,
    1e6,
    # where transients begin, and beyond which none is asked, over a load factor of the size of all
    # loads
)
_FACTOR, _MOST, _PARTS = (
    4.0,
    10,
    8,
    # growth of the load factor, most times that it shrinks, and parts of a range that is searched from
    # below
)
_TOLERANCE = (
    2e-4,
    2e-3,
)  # relative, of the load factor at which the transient slides off, in the plane and in space
_STEPS = 2  # increments from corner to corner in space


def self_stress(system: ContactSystem, friction: Array, N: Array) -> Array | None:
    """(t + 1, N) contact forces within friction that balance themselves in the rigid motions N, their pressures adding up to 1; else None."""
    shape = system.tangents + 1, system.nodes
    holds = np.where(
        np.isfinite(system.shear_strength), 0.0, friction
    )  # the strength of a surface bounds its shear, whatever the pressure
    forces = cp.Variable(shape)
    within = cp.norm(forces[:-1], axis=0) <= cp.multiply(holds, forces[-1])
    sums = N.T @ cp.vec(forces, order="C")
    problem = cp.Problem(
        cp.Minimize(cp.norm1(sums)), [within, forces[-1] >= 0, cp.sum(forces[-1]) == 1]
    )
    try:
        problem.solve(solver=cp.CLARABEL)
    except cp.SolverError as error:
        raise SolverError(
            f"self-stress: the solver does not say whether contact forces balance themselves ({error})"
        ) from error
    if problem.status != cp.OPTIMAL:
        raise SolverError(
            f"self-stress: the solver does not say whether contact forces balance themselves (status {problem.status})"
        )
    if problem.value > _BALANCED:
        return None
    *q, p = found = np.asarray(forces.value)
    if (np.linalg.norm(q, axis=0) > holds * p.clip(0.0) + _BALANCED).any() or p.min() < -_BALANCED:
        raise SolverError(
            "self-stress: contact forces that balance themselves are outside friction by more than rounding"
        )
    return found


def _sliding_off(
    system: ContactSystem, cycle: LoadCycle, friction: Array, most: float
) -> tuple[float, str]:
    """The load factor above which the transient from no slip finds no way on, and why; `most` and "" if it goes on up to there."""
    from ..transients import (
        march,
        steady_state,
    )  # here, for limits of other contacts need no transients and their compiler

    steps = _STEPS if system.tangents == 2 else None
    asked = system, cycle, friction

    def first_cycle(load_factor: float) -> str:
        return _end_of(lambda: march(*asked, load_factor, cycles=1, steps=steps, progress=False))

    def all_cycles(load_factor: float) -> str:
        return _end_of(lambda: steady_state(*asked, load_factor, steps=steps, progress=False))

    if np.isfinite(most):
        far, start = _BELOW * most, _START * most
    else:
        sizes = [
            np.abs(reactions(system, loads)).max() for loads in (cycle.unscaled, cycle.corners)
        ]
        unit = float(sizes[0] / sizes[1]) if min(sizes) > 0 else 1.0
        far, start = _FAR * unit, _START * unit
    tolerance = _TOLERANCE[system.tangents - 1]
    # The first cycle takes little time, also near the load that is sought, and nearly always
    # decides.
    low, why = _approached(first_cycle, start, far, tolerance)
    if low > 0 and (later := all_cycles(low)):
        low, why = _approached(all_cycles, _START * low, low, tolerance)
        why = why or later
    return (low, why) if why else (most, "")


def _end_of(transient: Callable[[], object]) -> str:
    """Why a transient finds no way on; "" if it goes on."""
    try:
        transient()
    except (
        NoContinuation,
        SolverError,
    ) as error:  # increments in space find no state of a body that slides off, and prove nothing
        return str(error).split("; ")[0]
    return ""


def _approached(
    end_at: Callable[[float], str], start: float, far: float, tolerance: float
) -> tuple[float, str]:
    """The largest load factor at which a transient goes on, and why not above it; `far` and "" if it goes on up to there, 0 if it never does.

    A transient that goes on takes far less time than one that finds no way on. So the load factor
    is approached from below.
    """
    low, high, why = 0.0, start, end_at(start)
    if why:
        for _ in range(_MOST):
            trial = high / _FACTOR
            if not (error := end_at(trial)):
                low = trial
                break
            high, why = trial, error
        else:
            return 0.0, why
    while not why:
        if high >= far:
            return far, ""
        low, high = high, min(_FACTOR * high, far)
        why = end_at(high)
    while high - low > tolerance * high:
        part = (high - low) / _PARTS
        for trial in low + part * np.arange(1, _PARTS):
            if error := end_at(float(trial)):
                high, why = float(trial), error
                break
            low = float(trial)
    return low, why
