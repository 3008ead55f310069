"""The state under the mean load alone, where every cycle begins."""

import numpy as np
from numpy.typing import ArrayLike

from ..contact import ContactState, ContactSystem, LoadCycle
from ..contact.parts import parted
from .begin import OPEN
from .exact import ExactPath
from .stepped import SteppedPath, step_counts

__all__ = ["mean_state"]


def mean_state(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> ContactState:
    """Slip and gap once the mean load has come, from no slip: followed exactly in the plane, by Newton's increments in space.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation, SolverError
        Nothing holds the contact on the way, or an increment has no answer that passes the checks.
    """
    path: ExactPath | SteppedPath
    if system.tangents == 1:
        path = ExactPath(system, cycle, friction, 0.0)
    else:
        path = SteppedPath(system, cycle, friction, 0.0, None, None, "newton", step_counts(None)[0])
    path.start()
    slip, opened = parted(path.state.u, system.tangents + 1)
    gap = np.where(path.state.status == OPEN, (opened + system.gap).clip(0.0), 0.0)
    return ContactState(slip, gap, *system.reaction(cycle.mean))
