"""An earlier state as the beginning of an exact path."""

from typing import Any

import numpy as np

from ...contact import ContactState, ContactSystem, referee
from ...contact.checks import Array
from ...contact.tolerances import RESIDUAL
from ...errors import ModelError
from .kernel import OPEN, State, new_state

__all__ = ["standing"]


def standing(system: ContactSystem, friction: Array, begin: ContactState, force: float) -> State:
    """The kernel's state at an earlier state, whose forces are of the size `force`.

    Raises
    ------
    ModelError
        It violates the contact law.
    """
    n, bonded = system.nodes, np.concatenate([begin.bonded_q, begin.bonded_p])
    u = np.concatenate([begin.slip, begin.gap - system.gap])
    r = bonded + system.S @ u
    opened = begin.gap * system.stiffness_scale > r[n:]  # of gap and pressure the smaller one is rounding
    r[np.r_[opened, opened]] = 0.0
    u[n:][~opened] = -system.gap[~opened]
    claim: dict[str, Any] = {"v": u[:n], "w": u[n:] + system.gap, "q": r[:n], "p": r[n:]}
    verdict = referee(system, (bonded[:n], bonded[n:]), friction, **claim, force_scale=force)
    if not verdict.residual <= RESIDUAL:
        raise ModelError(
            f"initial_state: it violates the contact law by {verdict.residual:.1e} ({verdict}); give a state of this system under this friction, or "
            "an initial_slip"
        )
    state = new_state(u, r, np.array(system.gap))
    state.status[opened] = OPEN
    return state
