"""The check of the contact law: how much a state violates each equation of the contact law.

Flicek et al. 2015, section 2.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    CONDENSATION,
    Array,
    Kept,
    PerNode,
    finite_number,
    real_array,
    warns_of_odd_values,
)
from ..errors import ModelError
from .components import joined
from .law import ContactLaw, contact_law, friction_coefficients
from .system import ContactSystem


@dataclass(frozen=True, repr=False)
class Verdict(Kept):
    """Largest violation of each equation of the contact law, dimensionless; 0 for an exact state.

    Attributes
    ----------
    equilibrium, bound
        `|r - r^w - S u|`, and `|q|` minus the friction bound, in units of the mean normal force.
    contact
        Tension `-p`, overlap `-w`, and contact force across an open gap (the smaller of p and w).
        Forces are in units of the mean normal force, lengths in units of the slip scale.
    direction
        Friction that does not oppose the slip since the previous state: the smallest change of the
        slip increment, of q, or of both, after which q lies on the bound and opposes the slip. A
        slip of at most 1e-10 of the largest motion of the state is rounding and counts as zero.

    Examples
    --------
    >>> import frictopt as fo
    >>> verdict = fo.results.Verdict(equilibrium=1e-15, contact=0.0, bound=0.2, direction=0.0)
    >>> verdict.residual
    0.2
    """

    equilibrium: float
    contact: float
    bound: float
    direction: float

    @property
    def residual(self) -> float:
        """The largest of the four violations; inf if any of them is NaN."""
        violations = np.array([self.equilibrium, self.contact, self.bound, self.direction])
        if np.isnan(violations).any():
            return np.inf
        return float(violations.max())

    def _answer(self) -> Mapping[str, object]:
        return {"residual": self.residual, **vars(self)}


@warns_of_odd_values
def check_contact_law(
    system: ContactSystem,
    bonded: tuple[ArrayLike, ArrayLike],
    friction: PerNode,
    *,
    v: ArrayLike,
    w: ArrayLike,
    q: ArrayLike,
    p: ArrayLike,
    previous_slip: ArrayLike | None = None,
    force_scale: float | None = None,
) -> Verdict:
    """Compute the residual of a state, or of T states, in every equation of the contact law.

    Theory, eq. (4).

    Parameters
    ----------
    system, friction
        The contact and its coefficient of friction, one or one per node.
    bonded
        `(q^w, p^w)`, bonded reactions under the load of the state, force: q (N,) in the plane and
        (N, 2) in space, p (N,). For T states, each array has an additional first axis of length T.
    v, w, q, p
        Slip, gap and reactions of the state, in the shapes of `bonded`; `w` includes the initial
        gap.
    previous_slip
        Slip at the previous state; None: the slip has not changed.
    force_scale
        Unit of the forces, by default the mean of `abs(p^w)`. The unit of the slips is this force
        divided by `system.stiffness_scale`.

    Returns
    -------
    Verdict
        The largest residual, and the residual of each equation.

    Raises
    ------
    ModelError
        Bad friction or arrays that do not match the system.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
    >>> bonded = node.reaction({"P": 1.0, "Q": 0.8})

    A state that sticks although its shear force exceeds the bound, and the state that slips:

    >>> fo.reference.check_contact_law(node, bonded, 0.5, v=[0.0], w=[0.0], q=[0.8], p=[1.0])
    Verdict(residual=0.3, equilibrium=0, contact=0, bound=0.3, direction=0)
    >>> fo.reference.check_contact_law(
    ...     node, bonded, 0.5, v=[-0.3], w=[0.0], q=[0.5], p=[1.0]
    ... ).residual < 1e-12
    True
    """
    f = friction_coefficients(friction, system)
    if not isinstance(bonded, tuple | list) or len(bonded) != 2:
        raise ModelError(f"bonded: a {type(bonded).__name__}; give the pair (q^w, p^w)")
    before = v if previous_slip is None else previous_slip
    bonded_q = _states("bonded q", bonded[0], system.slip_shape)
    bonded_p = _states("bonded p", bonded[1], (system.nodes,))
    slip = _states("v", v, system.slip_shape)
    shear = _states("q", q, system.slip_shape)
    slip_before = _states("previous_slip", before, system.slip_shape)
    gap = _states("w", w, (system.nodes,))
    pressure = _states("p", p, (system.nodes,))

    arrays = (bonded_q, bonded_p, slip, shear, slip_before, gap, pressure)
    counts = sorted({len(array) for array in arrays} - {1})
    if len(counts) > 1:
        raise ModelError(
            f"states: arrays of {counts} states; give all for the same number of states, or one "
            "for all"
        )
    count = counts[0] if counts else 1

    if force_scale is not None:
        force = finite_number("force_scale", force_scale, above=0.0)
    else:
        force = _force_scale(bonded_q, bonded_p, shear)
    opening = gap - system.gap
    return Verdict(
        *off_law(
            system,
            contact_law(system, f),
            _by_component(bonded_q, bonded_p, count),
            _by_component(slip, opening, count),
            _by_component(shear, pressure, count),
            force,
            _by_component(slip_before, gap, count),
        ).tolist()
    )


def _states(name: str, value: object, shape: tuple[int, ...]) -> Array:
    """Check an array of one state or several, and return it as (states, *shape)."""
    array = real_array(name, value)
    fits = array.ndim in (len(shape), len(shape) + 1) and array.shape[-len(shape) :] == shape
    if not fits or not array.size:
        raise ModelError(f"{name}: shape {array.shape}; give {shape} or (states, {str(shape)[1:]}")
    return array.reshape(-1, *shape)


def _by_component(tangential: Array, normal: Array, count: int) -> Array:
    """(count, M) values ordered by component; a single state is repeated."""
    tangential = np.broadcast_to(tangential, (count, *tangential.shape[1:]))
    normal = np.broadcast_to(normal, (count, *normal.shape[1:]))
    return joined(tangential, normal)


def _force_scale(bonded_q: Array, bonded_p: Array, q: Array) -> float:
    """The mean normal force; if it is zero, the largest shear force; without any force 1."""
    pressing = float(np.abs(bonded_p).mean())
    shearing = float(max(np.abs(bonded_q).max(), np.abs(q).max()))
    return pressing or shearing or 1.0


def off_law(
    system: ContactSystem,
    law: ContactLaw,
    bonded: Array,
    u: Array,
    r: Array,
    force: float,
    before: Array | None = None,
) -> Array:
    """(4,) largest violations of the law, in the order of `Verdict`; NaN if a state is not finite.

    The states `u = [v, w - gap]`, their loads `bonded` and reactions `r` are (..., M), ordered by
    component. `before` are the previous states; None: no slip has changed.

    The error of the direction of friction is the smallest of three changes: set the slip increment
    to zero; move q to the bound, opposite to the slip; or remove the part of the slip normal to q
    and move q to the bound. The third change is needed in space, where rounding changes the
    direction of small slips.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        length = force / system.stiffness_scale
        by_node = (-1, system.tangents + 1, system.nodes)
        unbalanced = np.abs(r - bonded - u @ system.S) / force
        increment = np.zeros_like(u) if before is None else (u - before) / length
        increment = increment.reshape(by_node)[:, :-1]
        u = (u / length).reshape(by_node)
        r = (r / force).reshape(by_node)

        q = r[:, :-1]
        p = r[:, -1]
        w = u[:, -1] + system.gap / length
        contact = np.maximum(np.maximum(-p, -w), np.minimum(p, w))

        size = np.linalg.norm(q, axis=1)
        bound = law.bound(force * p) / force
        over = size - bound

        # A slip that is only rounding beside the motions of its state counts as zero.
        rounding = CONDENSATION * np.abs(u).max(axis=(1, 2), initial=0.0)[:, None]
        slid = np.linalg.norm(increment, axis=1)
        turned = np.linalg.norm(q + bound[:, None] * _unit(increment, slid), axis=1)
        across = np.linalg.norm(increment - _opposed_part(increment, _unit(q, size)), axis=1)
        slid = np.where(slid <= rounding, 0.0, slid)
        across = np.where(across <= rounding, 0.0, across)
        direction = np.minimum(np.minimum(slid, turned), np.maximum(across, np.abs(over)))

        violations = unbalanced, contact, over, direction
        return np.array([np.max(violation, initial=0.0) for violation in violations])


def _unit(vectors: Array, sizes: Array) -> Array:
    """Directions of vectors (T, t, N) of sizes (T, N); zero where the vector is zero."""
    return vectors / np.where(sizes > 0, sizes, 1.0)[:, None]


def _opposed_part(increment: Array, pull: Array) -> Array:
    """The part of slip increments (T, t, N) opposite to the directions `pull` of friction."""
    along = np.minimum((increment * pull).sum(axis=1), 0.0)
    return np.asarray(along[:, None] * pull)
