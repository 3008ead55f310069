"""The check that the states of one period of a steady state come back to where they began, with the work of the steady state."""

import numpy as np

from ..base import COUNTS, RESIDUAL, SAME_STATE, Array, Outcome
from ..contact import reactions
from ..errors import SolverError
from .trajectory import Trajectory
from .transient import Scales, scales

# times the errors with which a steady state is accepted: a cycle from it may differ by so much
_ACCEPTED = 10


def check_return(
    path: Trajectory, load_factor: float, outcome: Outcome, work: Array, work_error: float
) -> None:
    """Check the states of one period against the steady state, of which `work` (N,) is the work per period; SolverError if they differ.

    Changes that count as none in `steady_state` count as none here, too: of slips `RESIDUAL` slip
    scales, of works `work_error`, and after shakedown the work of such a slip.
    """
    system, cycle = path.system, path.cycle
    mean, *corners = reactions(system, [cycle.mean, *cycle.at(load_factor)])
    units = scales(system.S, mean, np.array(corners), system.nodes)
    error = _work_change(
        path,
        work,
        units.force * units.length * RESIDUAL
        if outcome is Outcome.SHAKEDOWN
        else work_error * work.sum(),
    )
    if outcome is not Outcome.RATCHETING:
        error = max(error, _motion_change(path, units))
    if not error <= SAME_STATE:
        raise SolverError(
            f"steady state: a cycle from it differs from it by {error:.1e} (tolerance {SAME_STATE:g})"
        )


def _motion_change(path: Trajectory, units: Scales) -> float:
    """Largest change of a slip or gap from the first state to the last, over the largest motion."""
    n = path.system.nodes
    change = np.zeros(n)
    for values in (path.slip, path.gap):
        change = np.maximum(change, np.abs(values[-1] - values[0]).reshape(n, -1).max(axis=1))
    change[change <= _ACCEPTED * RESIDUAL * units.length] = 0.0
    return float(change.max()) / (_largest_motion(path) or 1.0)


def _work_change(path: Trajectory, work: Array, known: Array) -> float:
    """Largest change of the work of a node beyond what is `known`, over the largest work or, if that is rounding, over the unit of work."""
    change = float((np.abs(path.work[-1] - work) - _ACCEPTED * known).max())
    force = float(np.abs(path.p).max()) or 1.0
    motion = max(_largest_motion(path), COUNTS * force / path.system.stiffness_scale)
    return max(change, 0.0) / max(float(path.work.max()), force * motion)


def _largest_motion(path: Trajectory) -> float:
    return max(float(np.abs(path.slip).max()), float(path.gap.max()))
