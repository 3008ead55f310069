"""Forces and gaps that are linear in the load factor, until the first node slips, opens or touches.

Closed nodes stick, and open nodes follow the load without force.
"""

from typing import NamedTuple

import numpy as np

from ..base import CONDENSATION, RESIDUAL, Array
from ..contact import ContactState, ContactSystem, LoadCycle, joined, parted, reactions
from ..errors import NoContinuation


class LinearForces(NamedTuple):
    """Shear forces, normal forces and gaps, (K, N) or (N,); in space the shear has two columns.

    Gaps of closed nodes are inf: they cannot touch.
    """

    q: Array
    p: Array
    gap: Array


def linear_forces(
    system: ContactSystem, cycle: LoadCycle, state: ContactState | None
) -> tuple[LinearForces, LinearForces]:
    """Forces at load factor 0, and what a load factor of 1 adds, with a row for each corner.

    The forces at load factor 0 have one row if they are the same for all corners.
    """
    if state is None:
        q, p = cycle.unscaled_reactions(system)
        q_rate, p_rate = cycle.corner_reactions(system)
        start = LinearForces(q, p, np.full_like(p, np.inf))
        return start, LinearForces(q_rate, p_rate, np.zeros_like(p_rate))
    stress = system.S @ joined(state.slip, state.gap - system.gap)
    gap = np.where(state.open, state.gap, np.inf)
    start = _settled(system, state, reactions(system, cycle.unscaled) + stress, gap)
    no_gap = np.zeros(system.nodes)
    return start, _settled(system, state, reactions(system, cycle.corners), no_gap)


def _settled(system: ContactSystem, state: ContactState, load: Array, gap: Array) -> LinearForces:
    """Forces under bonded reactions (K, M) if closed nodes stick and open nodes carry nothing."""
    S = system.S
    opened = np.tile(state.open, system.tangents + 1)
    moved = np.zeros_like(load)
    block = S[np.ix_(opened, opened)]
    moved[:, opened] = -np.linalg.lstsq(block, load[:, opened].T, rcond=CONDENSATION)[0].T
    r = load + moved @ S
    if np.abs(r[:, opened]).max(initial=0.0) > RESIDUAL * np.abs(load).max():
        raise NoContinuation(
            "onset: nothing holds the open nodes against the load; hold the bodies by supports, "
            "or press them"
        )
    r[:, opened] = 0.0
    q, p = parted(r, system.tangents + 1)
    return LinearForces(q, p, gap + moved[:, -system.nodes :])


def first_zero(slack: Array, rate: Array, floor: float) -> Array:
    """First zero of `slack + lam * rate`; inf if there is none, 0 if the slack is negative."""
    with np.errstate(divide="ignore", invalid="ignore"):
        zero = np.where(rate < 0, np.maximum(slack, 0.0) / -rate, np.inf)
    return np.where(slack < -floor, 0.0, zero)
