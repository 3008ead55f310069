"""The residual of a claimed state in three dimensions: Coulomb's law with the friction circle."""

from typing import Any

import numpy as np

from ..contact import Verdict, friction_coefficients
from ..contact.checks import Array, finite_number, real_array
from ..errors import ModelError
from .system import ContactSystem3D, checked_3d, joined, parted

__all__ = ["off_law", "referee"]


def referee(
    system: ContactSystem3D,
    bonded: tuple[Any, Any],
    friction: Any,
    *,
    v: Any,
    w: Any,
    q: Any,
    p: Any,
    previous_slip: Any = None,
    force_scale: float | None = None,
) -> Verdict:
    """Compute the residual of a claimed state, or of T states at once, in every line of the contact law.

    Parameters
    ----------
    system
        The contact.
    bonded
        `(q^w, p^w)`, bonded reactions of the load of that state, (N, 2) and (N,), or with T in front, force.
    friction
        Coefficient of friction, one or one per node.
    v, w, q, p
        The claimed slip (N, 2), gap (N,), shear forces (N, 2) and normal forces (N,), or with T in front; `w` includes the initial gap.
    previous_slip
        Slip at the previous state; None: the slip has not changed.
    force_scale
        Unit of the forces; by default the mean of |p^w|.

    Raises
    ------
    ModelError
        Bad friction or arrays that do not match the system.
    """
    f = friction_coefficients(friction, checked_3d(system).nodes)
    if not isinstance(bonded, tuple | list) or len(bonded) != 2:
        raise ModelError(f"bonded: a {type(bonded).__name__}; give the pair (q^w, p^w)")
    vectors = {"bonded q": bonded[0], "v": v, "q": q, "previous_slip": v if previous_slip is None else previous_slip}
    scalars = {"bonded p": bonded[1], "w": w, "p": p}
    qw, v, q, before = (_states(name, value, (system.nodes, 2)) for name, value in vectors.items())
    pw, w, p = (_states(name, value, (system.nodes,)) for name, value in scalars.items())
    rows = {array.shape[0] for array in (qw, v, q, before) if array.ndim == 3} | {array.shape[0] for array in (pw, w, p) if array.ndim == 2}
    if len(rows) > 1:
        raise ModelError(f"states: arrays of {sorted(rows)} states; give all for the same number of states, or one for all")
    if force_scale is not None:
        force = finite_number("force_scale", force_scale, above=0.0)
    else:
        force = float(np.abs(pw).mean()) or float(max(np.abs(qw).max(), np.abs(q).max())) or 1.0
    with np.errstate(invalid="ignore", over="ignore"):  # what is not finite ends as an infinite residual
        length, shape = force / system.stiffness_scale, np.broadcast_shapes(v.shape[:-1], w.shape)
        u = joined(np.broadcast_to(v, (*shape, 2)), np.broadcast_to(w - system.gap, shape))
        errors = [claimed - given - follows for claimed, given, follows in zip((q, p), (qw, pw), parted(u @ system.S), strict=True)]
        rounding = 4 * np.finfo(float).eps * np.maximum(np.linalg.norm(v, axis=-1), np.linalg.norm(before, axis=-1)) / length
        bound, direction = off_law(f, q / force, p / force, (v - before) / length, rounding)
        return Verdict(
            equilibrium=max(_worst(np.abs(error) / force) for error in errors),
            contact=max(_worst(-p / force), _worst(-w / length), _worst(np.minimum(p / force, w / length))),
            bound=_worst(bound),
            direction=_worst(direction),
        )


def off_law(f: Array, q: Array, p: Array, moved: Array, rounding: Array) -> tuple[Array, Array]:
    """Dimensionless excess over the friction circle, and friction that does not oppose the slip `moved`.

    The latter is the smaller of that slip and the distance of q from the point of the circle that opposes it, less the distance by which rounding of
    the slips turns that point: a small slip is the difference of two large ones.
    """
    slid = np.linalg.norm(moved, axis=-1)
    sense = moved / np.where(slid > 0, slid, 1.0)[..., None]
    turned = np.abs(f * p) * rounding / np.where(slid > 0, slid, 1.0)
    off = np.linalg.norm(q + (f * p)[..., None] * sense, axis=-1) - turned
    return np.linalg.norm(q, axis=-1) - f * p, np.minimum(slid, np.maximum(off, 0.0))


def _states(name: str, value: Any, shape: tuple[int, ...]) -> Array:
    array = real_array(name, value)
    if array.ndim not in (len(shape), len(shape) + 1) or array.shape[-len(shape) :] != shape or not array.size:
        raise ModelError(f"{name}: shape {array.shape}; give {shape} or (states, {str(shape)[1:]}")
    return array


def _worst(violations: Array) -> float:
    return float(np.max(violations, initial=0.0)) if not np.isnan(violations).any() else float("nan")
