"""The contact and its loads in the unknowns and units in which its linear programs are well scaled."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import qr

from ..contact import ContactSystem
from ..contact.checks import Array, frozen
from ..contact.stiffness import slip_modes
from ..contact.symmetry import Part
from .loads import Loads

__all__ = ["ScaledContact", "rigid_slides", "scaled_contact"]


@dataclass(frozen=True, eq=False)
class ScaledContact:
    """Response of a contact to residual slip, dimensionless, with nodal tractions instead of slips as unknowns.

    Slips of a graded mesh span decades and A may be singular (a punch that only its loads hold), so the m unknowns are dimensionless
    tractions t: `v = slip t`, `A v = unit * (shear t)`, `B v = unit * (normal t)`.

    Attributes
    ----------
    part
        The part of the contact that is meant, N nodes.
    unit
        (N,) force unit of each node, force per depth.
    shear, normal
        (N, m) dimensionless.
    slip
        (N, m) slip for unit tractions, length.
    rigid
        (N, k) slips that need no force, length; k is 0 where there are none.
    loaded
        (m,) node that each traction acts on.
    """

    part: Part
    unit: Array
    shear: Array
    normal: Array
    slip: Array
    rigid: Array
    loaded: np.ndarray[Any, np.dtype[np.intp]]


def scaled_contact(part: Part, loads: Loads, force: float) -> ScaledContact:
    """Choose unknowns and units for (a part of) a contact under its loads, of the size of `force`."""
    system, unit = part.system, loads.units(force)
    rigid, compliance = rigid_slides(system)
    loaded, basis = _balanced(rigid)
    slip = compliance @ (unit[:, None] * basis)
    return ScaledContact(
        part=part,
        unit=frozen(unit),
        shear=frozen(system.A @ slip / unit[:, None]),
        normal=frozen(system.B @ slip / unit[:, None]),
        slip=frozen(slip),
        rigid=frozen(rigid * (force / (node_stiffness(system) @ rigid**2))),
        loaded=loaded,
    )


def rigid_slides(system: ContactSystem) -> tuple[Array, Array]:
    """Orthonormal slips that A does not resist, (N, k), and the compliance (N, N) of forces that do no work on them, to slips free of them.

    Each node counts in units of its own stiffness, see `slip_modes`.
    """
    stiffness = node_stiffness(system)
    slips, values, held = slip_modes(system.A, system.B, stiffness, stiffness)
    rigid, resisted = np.linalg.qr(slips[:, ~held])[0], slips[:, held]
    resisted = resisted - rigid @ (rigid.T @ resisted)
    return rigid, (resisted / values[held]) @ resisted.T


def node_stiffness(system: ContactSystem) -> Array:
    """(N,) size of each node's own stiffness, > 0."""
    stiffness = np.maximum(np.diag(system.A), np.diag(system.C))
    return np.asarray(np.where(stiffness > 0, stiffness, system.stiffness_scale))


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
