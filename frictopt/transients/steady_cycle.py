"""Check that the states of one period of a steady state come back, with the same work."""

import numpy as np

from ..base import COUNTS, RESIDUAL, SAME_STATE, Array, Outcome
from ..contact import reactions
from ..errors import SolverError
from .trajectory import Trajectory
from .transient import Scales, scales

# A cycle from a steady state may differ from it by this factor times the accepted errors.
_ACCEPTED = 10


def check_return(
    path: Trajectory, load_factor: float, outcome: Outcome, work: Array, work_error: float
) -> None:
    """Check the states of one period against the steady state; SolverError if they differ.

    `work` (N,) is the work per period of the steady state. Changes that `steady_state` neglects are
    neglected here, too: slips of `RESIDUAL` slip scales, a relative work of `work_error` and, after
    shakedown, the work of such a slip.
    """
    system = path.system
    cycle = path.cycle
    mean, *corners = reactions(system, [cycle.mean, *cycle.at(load_factor)])
    units = scales(system.S, mean, np.array(corners), system.nodes)
    if outcome is Outcome.SHAKEDOWN:
        accepted_work = units.force * units.length * RESIDUAL
    else:
        accepted_work = work_error * work.sum()
    error = _work_change(path, work, accepted_work)
    if outcome is not Outcome.RATCHETING:
        error = max(error, _motion_change(path, units))
    if not error <= SAME_STATE:
        raise SolverError(
            "steady state: a cycle from this state does not return to it, the difference is "
            f"{error:.1e} (tolerance {SAME_STATE:g})"
        )


def _work_change(path: Trajectory, work: Array, accepted: Array) -> float:
    """Largest change of the work of a node beyond what is accepted, relative to the largest work.

    If all works are rounding, the change is relative to the unit of work.
    """
    change = float((np.abs(path.work[-1] - work) - _ACCEPTED * accepted).max())
    force = float(np.abs(path.p).max()) or 1.0
    motion = max(_largest_motion(path), COUNTS * force / path.system.stiffness_scale)
    return max(change, 0.0) / max(float(path.work.max()), force * motion)


def _motion_change(path: Trajectory, units: Scales) -> float:
    """Largest change of a slip or gap from first to last state, relative to the largest motion."""
    n = path.system.nodes
    change = np.zeros(n)
    for values in (path.slip, path.gap):
        change = np.maximum(change, np.abs(values[-1] - values[0]).reshape(n, -1).max(axis=1))
    change[change <= _ACCEPTED * RESIDUAL * units.length] = 0.0
    return float(change.max()) / (_largest_motion(path) or 1.0)


def _largest_motion(path: Trajectory) -> float:
    return max(float(np.abs(path.slip).max()), float(path.gap.max()))
