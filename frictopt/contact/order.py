"""When the slips of a closed contact keep their order: a condition on stiffness and friction."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .checks import Array, frozen
from .coulomb import friction_coefficients
from .show import Shown, frame
from .system import ContactSystem, checked_plane
from .tolerances import CONDENSATION

if TYPE_CHECKING:
    import pandas as pd

_PULL = CONDENSATION  # a stiffness between two nodes up to this share of the largest entry of A and B counts as none: the data have this error


@dataclass(frozen=True, eq=False, repr=False)
class OrderPreserving(Shown):
    """Whether slip at one node only ever pulls the others along: `f_i |B_ij| <= -A_ij` for all i != j.

    If it holds, and while all nodes stay closed, two starts with `v <= v'` at every node have `v <= v'` ever after under the same loads. Slips
    between two safe ones, node by node, then stay between them. It orders slips, not the work of friction: that may be more or less from the larger
    start.

    Attributes
    ----------
    holds
        Whether the condition holds.
    critical
        (N,) largest coefficient of friction of each node with which it holds; below 0 if it holds with none.
    friction
        (N,) coefficients of friction.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=16).condense()
    >>> fo.reference.order_preserving(punch, friction=0.43).to_frame().query("not holds")["node"].tolist()
    [1, 15]
    """

    _said = ("holds", "largest_friction")
    holds: bool
    critical: Array = field(repr=False)
    friction: Array = field(repr=False)
    x: Array = field(repr=False)

    @property
    def largest_friction(self) -> float:
        """Largest coefficient of friction, one for all nodes, with which it holds; below 0 if it holds with none."""
        return float(self.critical.min())

    def to_frame(self) -> "pd.DataFrame":
        """One row for each node: node, x, friction, critical, and whether the condition holds in its row."""
        columns = {"node": range(len(self.x)), "x": self.x, "friction": self.friction, "critical": self.critical}
        return frame({**columns, "holds": self.friction <= self.critical})


def order_preserving(system: ContactSystem, friction: ArrayLike) -> OrderPreserving:
    """Check whether the slips of a contact keep their order, see `OrderPreserving`.

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=16).condense()
    >>> fo.reference.order_preserving(punch, friction=0.3)
    OrderPreserving(holds=True, largest_friction=0.428576)
    >>> fo.reference.order_preserving(punch, friction=0.7).holds
    False
    """
    f = friction_coefficients(friction, checked_plane(system, "in space slips have no order, ask guaranteed_limit").nodes)
    pull, coupling = -system.A, np.abs(system.B)
    rounding = _PULL * max(float(np.abs(system.A).max()), float(coupling.max()))
    coupled = coupling > rounding
    shares = np.where(coupled, pull / np.where(coupled, coupling, 1.0), np.where(pull >= -rounding, np.inf, -np.inf))
    np.fill_diagonal(shares, np.inf)
    critical = shares.min(axis=1)
    return OrderPreserving(bool(np.all(f <= critical)), frozen(critical), frozen(f), system.x)
