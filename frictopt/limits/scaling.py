"""The contact and its loads in the unknowns and units in which its programs are well scaled."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, qr
from scipy.linalg.lapack import dpotri
from scipy.sparse import csr_array

from ..contact.checks import Array, frozen
from ..contact.coulomb import lengths
from ..contact.tolerances import RESIDUAL, RIGID
from .mechanism import Mechanism
from .question import LimitQuestion

__all__ = ["ScaledContact", "rigid_slides", "scaled_contact"]

_NO_PRESSURE = 1e3 * RESIDUAL  # rows are scaled by the pressure of their node unless it is below this share of the mean one: an answer has its error


@dataclass(frozen=True, eq=False)
class ScaledContact:
    """Response of a contact to residual slip, dimensionless, with nodal tractions instead of slips as unknowns.

    Slips of a graded mesh span decades and A may be singular (a punch that only its loads hold), so the m unknowns are dimensionless
    tractions t: `v = slip t`, `A v = unit * (shear t)`, `B v = unit * (normal t)`, ordered by component. They are nodal forces over the unit of the
    node, or over the pressure that they make where that is larger.

    Attributes
    ----------
    unit
        (N,) force unit of each node: its pressure under the mean load, or what else acts on it.
    shear, normal
        (t N, m), sparse, and (N, m), dimensionless, at most 1.
    slip
        (t N, m) slip for unit tractions, length.
    rigid
        (t N, k) slips that need no force, length; k is 0 where there are none.
    loaded, size
        (m,) row of `shear` that each traction acts on alone, and its entry there.
    """

    unit: Array
    shear: csr_array
    normal: Array
    slip: Array
    rigid: Array
    loaded: NDArray[np.intp]
    size: Array

    @property
    def traction_unit(self) -> Array:
        """(m,) force of each unit traction."""
        return np.asarray(self.unit[self.loaded % len(self.unit)] * self.size)

    def defect(self, task: LimitQuestion, motion: Mechanism, slip: Array) -> float:
        """By how much the work bound of a mechanism may be off because its stress is not exactly zero.

        Counted for all slips whose tractions are, node by node, at most those of `slip`, or at most `1 + f` times the node's own pressure where
        that is more; and under a slip bound, for all rigid slides within it.
        """
        tangents = task.system.tangents
        shear_unit = np.tile(self.unit, tangents)
        held = np.zeros(len(shear_unit)) if motion.hold is None else motion.hold.T.ravel()
        work = (shear_unit * motion.slips.sum(axis=0).T.ravel()) @ self.shear + (self.unit * motion.lift.sum(axis=0)) @ self.normal - held @ self.slip
        if task.lift is not None and motion.press is not None:
            work = work + motion.press.sum(axis=0) @ task.lift @ self.slip
        carried = np.abs(task.A[self.loaded] @ slip.T.ravel()) / shear_unit[self.loaded]
        off = float(np.abs(work) @ (np.maximum(carried, 1.0 + np.tile(task.friction, tangents)[self.loaded]) / self.size))
        if task.most is not None and self.rigid.shape[1]:
            off += float(np.abs(held @ self.rigid) @ (np.abs(np.linalg.pinv(self.rigid)) @ np.tile(task.most, tangents)))
        return off


def scaled_contact(task: LimitQuestion) -> ScaledContact:
    """Choose unknowns and units for a contact under its loads."""
    loads, stiffness = task.loads, task.stiffness[: -len(task.friction)]
    pressure = np.abs(loads.p0).max(axis=0)
    acts = np.maximum(lengths(loads.q0, loads.p0).max(axis=0), np.maximum(lengths(loads.q1, loads.p1), np.abs(loads.p1)).max(axis=0))
    unit = np.where(pressure > _NO_PRESSURE * task.force, pressure, np.maximum(acts, _NO_PRESSURE * task.force))
    rigid, compliance = rigid_slides(task)
    each = np.tile(unit, task.system.tangents)[:, None]
    loaded, basis = _balanced(each * rigid)
    forces = csr_array(each * basis)
    slip = (forces.T @ compliance).T
    slip = slip + compliance @ (forces - task.A @ slip)  # without most of its rounding
    normal = task.B @ slip / unit[:, None]
    size = 1 / np.maximum(np.abs(normal).max(axis=0), 1.0)
    return ScaledContact(
        unit=frozen(unit),
        shear=csr_array(basis * size),
        normal=frozen(normal * size),
        slip=frozen(slip * size),
        rigid=frozen(rigid * (task.force / (stiffness @ rigid**2))),
        loaded=loaded,
        size=frozen(size),
    )


def rigid_slides(task: LimitQuestion) -> tuple[Array, Array]:
    """Orthonormal slips that A does not resist, (t N, k), and the compliance (t N, t N) of forces that do no work on them, to slips free of them.

    Each slip and each pressure counts in units of its own stiffness, so that a soft node beside stiff ones is not taken for a free one. A slip that
    changes a pressure is resisted, however little, or S would not be positive semi-definite.
    """
    tangent, normal = np.split(np.sqrt(task.stiffness), [-len(task.friction)])
    scaled, pressure = task.A / np.outer(tangent, tangent), task.B / np.outer(normal, tangent)
    values, soft = eigh(scaled, subset_by_value=(-np.inf, RIGID))
    held = (values > 0) & (np.abs(pressure @ soft).max(axis=0) > RIGID)
    share = np.where(held, 1 / np.where(held, values, 1.0), 0.0) - 1 / (1 + values)
    compliance = np.tril(dpotri(np.linalg.cholesky(scaled + soft @ soft.T), lower=1)[0])  # in which soft slips have the stiffness 1 + value
    compliance += np.tril(compliance, -1).T + (soft * share) @ soft.T
    compliance /= np.outer(tangent, tangent)
    rigid = np.linalg.qr(soft[:, ~held] / tangent[:, None])[0]
    compliance -= rigid @ (rigid.T @ compliance)
    return rigid, np.asarray(compliance - (compliance @ rigid) @ rigid.T)


def _balanced(rigid: Array) -> tuple[NDArray[np.intp], Array]:
    """Basis of the nodal tractions that do no work on rigid slips (columns; each times its unit), and the rows that its columns load.

    Unit tractions at the loaded rows are balanced by forces at as many other rows as there are rigid slips.
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
