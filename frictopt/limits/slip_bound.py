"""A bound on the residual slip, `abs(v) <= most`, in the linear programs."""

from dataclasses import dataclass
from typing import Any

import cvxpy as cp
import numpy as np

from ..contact.checks import Array, finite_array, real_array
from ..errors import ModelError
from .scaling import ScaledContact

__all__ = ["SlipBound", "scaled_slip_bound", "slip_bounds"]


@dataclass(frozen=True, eq=False)
class SlipBound:
    """Rows `-most <= slip @ traction + rigid @ slide <= most` of the nodes, each divided by its norm. The slip includes the rigid slide.

    Attributes
    ----------
    slip, rigid, most
        (n, m), (n, k) and (n,) coefficients of these rows.
    norm
        (n,) norm of each row, length.
    """

    slip: Array
    rigid: Array
    most: Array
    norm: Array

    def rows(self, traction: cp.Variable, slide: cp.Variable | None) -> list[cp.Constraint]:
        """The constraints; the slide stands for rigid slides, where there are any."""
        slip = self.slip @ traction + (0.0 if slide is None else self.rigid @ slide)
        rows = {"forward_slip_bound": slip <= self.most, "backward_slip_bound": slip >= -self.most}
        return [row.set_label(name) for name, row in rows.items()]


def scaled_slip_bound(scaled: ScaledContact, most: Array) -> SlipBound:
    """The rows of a bound (N,) on the slip of each node."""
    norm = np.linalg.norm(np.hstack([scaled.slip, scaled.rigid]), axis=1)
    return SlipBound(scaled.slip / norm[:, None], scaled.rigid / norm[:, None], most / norm, norm)


def slip_bounds(slip_bound: Any, nodes: int) -> Array | None:
    """Check a slip bound, one or one per node, and return it as (N,); None for no bound.

    Raises
    ------
    ModelError
        Not real finite numbers, negative, or of a length other than 1 and N.
    """
    if slip_bound is None:
        return None
    shape = real_array("slip_bound", slip_bound).shape
    if shape not in ((), (nodes,)):
        raise ModelError(f"slip_bound: shape {shape}; give one length or one for each of the {nodes} nodes")
    most = finite_array("slip_bound", slip_bound, shape)
    if most.min() < 0:
        raise ModelError(f"slip_bound: {most.min():g}; it bounds the size of the slip, give a length >= 0, or None for no bound")
    return np.broadcast_to(most, (nodes,))
