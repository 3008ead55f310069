"""The contact and its loads in the unknowns and units in which its linear programs are well scaled."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import qr

from ..contact import ContactSystem
from ..contact.checks import Array, frozen

__all__ = ["NULL", "Loads", "ScaledContact", "scaled_contact"]

NULL = 1e-10
"""Eigenvalues of A below this share of the largest entry of S are rigid sliding, which needs no force."""

_SMALL_NODE = 1e-6  # rows are divided by the node's mean pressure; by its other reactions where it has less than this share of the average


@dataclass(frozen=True, eq=False)
class Loads:
    """Closed reactions of a load cycle: mean (N,) `q0, p0` and corners at load factor 1 (K, N) `q1, p1`, force per depth."""

    q0: Array
    p0: Array
    q1: Array
    p1: Array

    @property
    def corners(self) -> int:
        """Number of corners, K."""
        return len(self.q1)


@dataclass(frozen=True, eq=False)
class ScaledContact:
    """Response of the scaled to residual slip, with nodal tractions instead of slips as unknowns.

    Slips of a graded mesh span decades and A may be singular (a punch that only its loads hold), so the m unknowns are dimensionless
    tractions t: `v = slip t`, `A v = unit * (shear t)`, `B v = unit * (normal t)`.

    Attributes
    ----------
    nodes
        (n,) nodes whose rows are kept: all, or the left half with the middle of a mirror-symmetric scene.
    unit
        (n,) force unit of each kept node, force per depth.
    shear, normal
        (n, m) dimensionless.
    slip
        (N, m) slip of all nodes for unit tractions, length.
    rigid
        (N, k) slips that need no force, length; k is 0 where there are none.
    loaded
        (m,) node that each traction acts on.
    mirror
        Whether v is taken odd and the right half left out.
    force
        Force scale of the loads, force per depth.
    """

    nodes: np.ndarray[Any, np.dtype[np.intp]]
    unit: Array
    shear: Array
    normal: Array
    slip: Array
    rigid: Array
    loaded: np.ndarray[Any, np.dtype[np.intp]]
    mirror: bool
    force: float


def scaled_contact(system: ContactSystem, loads: Loads, force: float, mirror: bool) -> ScaledContact:
    """Choose unknowns and units for a contact under loads of the size of `force`."""
    n, half = system.nodes, system.nodes // 2
    pressure, others = np.abs(loads.p0), np.abs([loads.q0, *loads.q1, *loads.p1]).max(axis=0)
    unit = np.where(pressure > _SMALL_NODE * force, pressure, np.maximum(others, _SMALL_NODE * force))
    nodes = np.arange(n - half if mirror else n)
    free = np.eye(n)[:, : half if mirror else n]  # slips of all nodes for the independent ones
    if mirror:
        free = free - free[::-1]
    A_free = free.T @ system.A @ free
    values, vectors = np.linalg.eigh(A_free)
    rigid = values <= NULL * max(np.abs(system.A).max(), np.abs(system.C).max())
    loaded, basis = _balanced(vectors[:, rigid])
    tractions = unit[: len(A_free), None] * basis
    compliance = (vectors[:, ~rigid] / values[~rigid]) @ vectors[:, ~rigid].T
    slip = free @ compliance @ tractions * (1 + mirror)
    return ScaledContact(
        nodes=nodes,
        unit=frozen(unit[nodes]),
        shear=frozen(system.A[nodes] @ slip / unit[nodes, None]),
        normal=frozen(system.B[nodes] @ slip / unit[nodes, None]),
        slip=frozen(slip),
        rigid=frozen(free @ vectors[:, rigid] * (force / system.stiffness_scale)),
        loaded=loaded,
        mirror=mirror,
        force=force,
    )


def _balanced(rigid: Array) -> tuple[np.ndarray[Any, np.dtype[np.intp]], Array]:
    """Basis of the nodal forces that do no work on the rigid slips (columns), and the nodes that its columns load.

    Unit forces at the loaded nodes are balanced by forces at as many other nodes as there are rigid slips.
    """
    count, k = rigid.shape
    if not k:
        return np.arange(count), np.eye(count)
    _, _, pivots = qr(rigid.T, pivoting=True)
    balancing, loaded = pivots[:k], np.sort(pivots[k:])
    basis = np.zeros((count, count - k))
    basis[loaded, np.arange(count - k)] = 1.0
    basis[balancing] = -np.linalg.solve(rigid[balancing].T, rigid[loaded].T)
    return loaded, basis
