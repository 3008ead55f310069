"""A contact under a load cycle in the unknowns and units in which its cone programs are well scaled."""

from dataclasses import dataclass, replace

import numpy as np

from ..contact.checks import Array
from ..contact.stiffness import slip_modes
from .loads import Loads

__all__ = ["ScaledCones", "scaled_cones"]


@dataclass(frozen=True, eq=False)
class ScaledCones:
    """Data of the cone programs, dimensionless: forces in a unit of each node, load factors in a unit of their own.

    Attributes
    ----------
    friction
        (N,) coefficients of friction.
    q0, p0, q1, p1
        Loads as in `Loads`, in the units of the nodes and of the load factor.
    shear
        (2N,) shear force by each traction, at most 1: the tractions are the unknowns, in units in which they make pressures of at most 1, too.
    G
        (N, 2N) pressures by the tractions of a residual slip.
    balance
        (k, 2N) work of the tractions on the k slips that need no force.
    slip
        (2N, 2N) slip by its tractions, length.
    unit
        (N,) force unit of each node.
    load_unit
        Unit of the load factor.
    clearance
        (N,) mean friction bound in the units of the nodes.
    bare
        (K, N) where the friction bound of a node vanishes at a corner, whatever the slip and the load factor.
    opening
        Whether there is so little friction somewhere that keeping nodes closed needs rows of its own.
    """

    friction: Array
    q0: Array
    p0: Array
    q1: Array
    p1: Array
    shear: Array
    G: Array
    balance: Array
    slip: Array
    unit: Array
    load_unit: float
    clearance: Array
    bare: np.ndarray
    opening: bool

    @property
    def nodes(self) -> int:
        """Number of node pairs, N."""
        return len(self.p0)

    @property
    def corners(self) -> int:
        """Number of corners that have rows, K."""
        return len(self.p1)

    @property
    def traction_unit(self) -> Array:
        """(N, 2) unit of each traction, force."""
        return self.unit[:, None] * self.tangential

    @property
    def tangential(self) -> Array:
        """(N, 2) `shear`, by node."""
        return np.stack(np.split(self.shear, 2), axis=-1)

    def under(self, loads: Loads) -> "ScaledCones":
        """The same under other loads of the corners that have rows."""
        at, unit = self.unit[:, None], self.load_unit
        return replace(self, q0=loads.q0 / at, p0=loads.p0 / self.unit, q1=loads.q1 / at * unit, p1=loads.p1 / self.unit * unit)

    @property
    def mean_q(self) -> Array:
        """(K, N, 2) mean load at each corner."""
        return np.broadcast_to(self.q0, self.q1.shape)

    @property
    def mean_p(self) -> Array:
        """(K, N) mean load at each corner."""
        return np.broadcast_to(self.p0, self.p1.shape)


def scaled_cones(
    A: Array, B: Array, stiffness: Array, friction: Array, loads: Loads, scales: tuple[float, float, float], bare: np.ndarray, opening: bool
) -> ScaledCones:
    """Choose unknowns and units for a contact under loads.

    `scales` are its force, the unit of its load factors and its mean friction bound; `stiffness` (3N,) is each direction's own, > 0.
    """
    force, load_unit, mean_bound = scales
    unit = loads.units(force)
    slips, values, held = slip_modes(A, B, *np.split(stiffness, [len(A)]))
    slip = (slips[:, held] / values[held]) @ slips[:, held].T * np.tile(unit, 2)
    G = B @ slip / unit[:, None]
    shear = 1 / np.maximum(np.abs(G).max(axis=0), 1.0)
    balance = slips[:, ~held].T * (np.tile(unit, 2) * shear)
    norms = np.linalg.norm(balance, axis=1, keepdims=True)
    return ScaledCones(
        friction=friction,
        q0=loads.q0 / unit[:, None],
        p0=loads.p0 / unit,
        q1=loads.q1 / unit[:, None] * load_unit,
        p1=loads.p1 / unit * load_unit,
        shear=shear,
        G=G * shear,
        balance=balance / norms,
        slip=slip * shear,
        unit=unit,
        load_unit=load_unit,
        clearance=mean_bound / unit,
        bare=bare,
        opening=opening,
    )
