"""The contact in the unknowns and units in which its linear programs are well scaled."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import qr

from ..contact import ContactSystem
from ..contact.checks import Array, frozen

__all__ = ["Interface", "scaled_interface"]

_NULL = 1e-12  # eigenvalues of A below this share of the largest are rigid sliding, which needs no force
_SMALL_NODE = 1e-6  # rows are divided by the node's mean pressure, or by this share of the average one where it is less


@dataclass(frozen=True, eq=False)
class Interface:
    """Response of the interface to residual slip, with nodal tractions instead of slips as unknowns.

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
    mirror
        Whether v is taken odd and the right half left out.
    force
        Mean normal force of the mean load over the nodes, force per depth.
    """

    nodes: np.ndarray[Any, np.dtype[np.intp]]
    unit: Array
    shear: Array
    normal: Array
    slip: Array
    mirror: bool
    force: float


def scaled_interface(system: ContactSystem, q0: Array, p0: Array, mirror: bool) -> Interface:
    """Choose unknowns and units for a contact whose mean load gives the closed reactions `q0, p0`."""
    n, half = system.nodes, system.nodes // 2
    force = float(np.abs(p0).mean() or np.abs(q0).mean() or 1.0)
    unit = np.maximum(np.abs(p0), _SMALL_NODE * force)
    nodes = np.arange(n - half if mirror else n)
    free = np.eye(n)[:, : half if mirror else n]  # slips of all nodes for the independent ones
    if mirror:
        free = free - free[::-1]
    A_free = free.T @ system.A @ free
    values, vectors = np.linalg.eigh(A_free)
    rigid = values <= _NULL * values[-1:]
    tractions = unit[: len(A_free), None] * _balanced(vectors[:, rigid])
    compliance = (vectors[:, ~rigid] / values[~rigid]) @ vectors[:, ~rigid].T
    slip = free @ compliance @ tractions * (1 + mirror)
    return Interface(
        nodes=nodes,
        unit=frozen(unit[nodes]),
        shear=frozen(system.A[nodes] @ slip / unit[nodes, None]),
        normal=frozen(system.B[nodes] @ slip / unit[nodes, None]),
        slip=frozen(slip),
        mirror=mirror,
        force=force,
    )


def _balanced(rigid: Array) -> Array:
    """Basis of the nodal forces that do no work on the rigid slips (columns): unit forces, balanced by forces at as many nodes as there are slips."""
    count, k = rigid.shape
    if not k:
        return np.eye(count)
    _, _, pivots = qr(rigid.T, pivoting=True)
    balancing, loaded = pivots[:k], np.sort(pivots[k:])
    basis = np.zeros((count, count - k))
    basis[loaded, np.arange(count - k)] = 1.0
    basis[balancing] = -np.linalg.solve(rigid[balancing].T, rigid[loaded].T)
    return basis
