"""When the slips of a closed contact keep their order: a condition on stiffness and friction."""

from __future__ import annotations

import numpy as np

from ..contact import CONDENSATION, Array, ContactSystem, checked_plane, frozen

_PULL = CONDENSATION  # a stiffness between two nodes up to this share of the largest entry of A and B counts as none: the data have this error


def order_preserving(system: ContactSystem) -> Array:
    """Largest coefficient of friction of each node with which slip at one node only ever pulls the others along.

    These are the largest f with `f_i |B_ij| <= -A_ij` for all i != j. With no more at any node, and while all nodes stay closed, two starts with
    `v <= v'` at every node have `v <= v'` ever after under the same loads. Slips between two safe ones, node by node, then stay between them. It
    orders slips, not the work of friction: that may be more or less from the larger start.

    Parameters
    ----------
    system
        The contact, in the plane.

    Returns
    -------
    Array
        (N,) coefficients of friction, of which the least one holds for all nodes; inf where nothing limits it, below 0 where none keeps the order.

    Raises
    ------
    ModelError
        Values out of these ranges.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=16).condense()
    >>> most = fo.reference.order_preserving(punch)
    >>> round(float(most.min()), 6), (most < 0.43).nonzero()[0].tolist()
    (0.428576, [1, 15])
    """
    contact = checked_plane(system, "in space slips have no order, ask guaranteed_limit")
    pull, coupling = -contact.A, np.abs(contact.B)
    rounding = _PULL * max(float(np.abs(contact.A).max()), float(coupling.max()))
    coupled = coupling > rounding
    shares = np.where(coupled, pull / np.where(coupled, coupling, 1.0), np.where(pull >= -rounding, np.inf, -np.inf))
    np.fill_diagonal(shares, np.inf)
    return frozen(shares.min(axis=1))
