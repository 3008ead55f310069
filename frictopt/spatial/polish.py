"""The exact solution of a cone program whose active cones a solver has found: Newton's method on their equations."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lstsq

from ..contact.checks import Array
from ..contact.tolerances import NOT_UNIQUE, POLISHED
from .scaling import ScaledCones

__all__ = ["ConeForm", "Point", "on_active_cones"]

_STEPS = 8  # of Newton's method at most; mostly three do


@dataclass(frozen=True, eq=False)
class ConeForm:
    """A cone program over m scalars x and the shear forces t of a residual slip, for K corners and N nodes.

    Maximise `goal x` subject to `|q| <= f p - reserve x` (and `p >= reserve x` for little friction) with `q = q_given + q_rate x + t` and
    `p = p_given + p_rate x + G t`, and to caps `row x <= right`.
    """

    goal: Array
    q_given: Array
    p_given: Array
    q_rate: Array
    p_rate: Array
    reserve: Array
    caps: Mapping[str, tuple[Array, float]]


@dataclass(frozen=True, eq=False)
class Point:
    """Variables and multipliers of a cone program, dimensionless.

    Attributes
    ----------
    x
        (m,) scalars.
    traction
        (2N,) shear forces of the residual slip.
    force, slips
        (K, N) and (K, N, 2) multipliers of the circles, `|slips| <= force`: sizes and directions of slips.
    opening
        (K, N) multipliers of the rows against opening.
    caps
        Multipliers of the caps.
    """

    x: Array
    traction: Array
    force: Array
    slips: Array
    opening: Array
    caps: Mapping[str, float]

    @property
    def weight(self) -> Array:
        """(K, N) multipliers of the reserve at each node."""
        return np.asarray(np.maximum(self.force, np.linalg.norm(self.slips, axis=-1)) + self.opening)


def on_active_cones(c: ScaledCones, form: ConeForm, point: Point) -> Point:
    """Solve the optimality conditions of the cones that are active at a point near the solution, by Newton's method.

    A circle is active where the slip that belongs to it exceeds its slack, and at its apex, with all three components zero, where the slack of the
    multiplier exceeds its radius. Whether the answer is better is for a residual to say.
    """
    active = _Active(c, form, point)
    best, least, z, m = None, np.inf, np.r_[point.x, point.traction], None
    for _ in range(_STEPS):
        jacobian, values, hessian = active.equations(z, m)
        if m is None:
            m = active.multipliers(point)
            jacobian, values, hessian = active.equations(z, m)
        error = max(float(np.abs(active.goal + jacobian.T @ m).max()), float(np.abs(values).max(initial=0.0)))
        if not error < least:
            break
        best, least = (z, m), error
        if error <= POLISHED:
            break
        rows = len(values)
        matrix = np.block([[hessian, jacobian.T], [jacobian, np.zeros((rows, rows))]])
        step = lstsq(matrix, -np.r_[active.goal, values], cond=NOT_UNIQUE, lapack_driver="gelsy", check_finite=False)[0]
        z, m = z + step[: len(z)], step[len(z) :]
    return point if best is None else active.point(*best)


class _Active:
    """Equations of the active rows: circles on their boundary, circles at their apex, rows against opening, caps, and balance."""

    def __init__(self, c: ScaledCones, form: ConeForm, point: Point) -> None:
        self._c, self._form, self._m = c, form, len(form.goal)
        self.goal = np.r_[form.goal, np.zeros(2 * c.nodes)]
        q, p = self._reactions(np.r_[point.x, point.traction])
        reserve = point.x @ form.reserve
        bound, radius, slid = c.friction * p - reserve, np.linalg.norm(q, axis=-1), np.linalg.norm(point.slips, axis=-1)
        apex = bound + radius < point.force - slid
        self._on = np.argwhere((point.force + slid > bound - radius) & ~apex & (radius > 0))
        self._apex = np.argwhere(apex)
        self._shut = np.argwhere(c.opening & (point.opening > p - reserve))
        self._caps = [name for name, (row, right) in form.caps.items() if point.caps[name] > right - row @ point.x]

    def _reactions(self, z: Array) -> tuple[Array, Array]:
        form, x, t = self._form, z[: self._m], z[self._m :]
        q = form.q_given + np.tensordot(x, form.q_rate, 1) + np.stack(np.split(t, 2), axis=-1)
        return q, form.p_given + np.tensordot(x, form.p_rate, 1) + self._c.G @ t

    def _shear_rows(self, where: np.ndarray) -> Array:
        """(rows, 2, m + 2N) gradients of q."""
        n, count = self._c.nodes, len(where)
        rows = np.zeros((count, 2, self._m + 2 * n))
        rows[:, :, : self._m] = np.moveaxis(self._form.q_rate[:, where[:, 0], where[:, 1]], 0, -1)
        for axis in (0, 1):
            rows[np.arange(count), axis, self._m + axis * n + where[:, 1]] = 1.0
        return rows

    def _pressure_rows(self, where: np.ndarray, friction: Array) -> Array:
        """(rows, m + 2N) gradients of `friction p - reserve x`."""
        form, (corner, node) = self._form, where.T
        scalars = friction[:, None] * form.p_rate[:, corner, node].T - form.reserve[:, node].T
        return np.hstack([scalars, friction[:, None] * self._c.G[node]])

    def equations(self, z: Array, m: Array | None) -> tuple[Array, Array, Array]:
        """Gradients of the active rows, their values, and the Hessian of their sum weighted by the multipliers m."""
        c, form = self._c, self._form
        q, p = self._reactions(z)
        x = z[: self._m]
        f, ones = c.friction, np.ones(len(self._shut))
        shear = self._shear_rows(self._on)
        on_q = q[tuple(self._on.T)]
        radius = np.linalg.norm(on_q, axis=1)
        unit = on_q / radius[:, None]
        along = np.einsum("ri,riz->rz", unit, shear)

        def bound(where: np.ndarray, friction: Array) -> Array:
            return np.asarray(friction * p[tuple(where.T)] - (x @ form.reserve)[where[:, 1]])

        f_on, f_apex = f[self._on[:, 1]], f[self._apex[:, 1]]
        apex = self._shear_rows(self._apex)
        caps = np.array([np.r_[-form.caps[name][0], np.zeros(2 * c.nodes)] for name in self._caps]).reshape(-1, len(z))
        balance = np.hstack([np.zeros((len(c.balance), self._m)), c.balance])
        jacobian = np.vstack(
            [
                self._pressure_rows(self._on, f_on) - along,
                self._pressure_rows(self._apex, f_apex),
                apex[:, 0],
                apex[:, 1],
                self._pressure_rows(self._shut, ones),
                caps,
                balance,
            ]
        )
        at_apex = q[tuple(self._apex.T)]
        values = np.concatenate(
            [
                bound(self._on, f_on) - radius,
                bound(self._apex, f_apex),
                at_apex[:, 0],
                at_apex[:, 1],
                bound(self._shut, ones),
                [form.caps[name][1] - form.caps[name][0] @ x for name in self._caps],
                c.balance @ z[self._m :],
            ]
        )
        hessian = np.zeros((len(z), len(z)))
        if m is not None:
            across = np.einsum("ri,riz->rz", np.stack([-unit[:, 1], unit[:, 0]], axis=1), shear)
            hessian = -(across.T * (m[: len(self._on)] / radius)) @ across
        return jacobian, values, hessian

    def multipliers(self, point: Point) -> Array:
        """Multipliers of the active rows at a point; those of the balance fit best."""
        apex = tuple(self._apex.T)
        slips = point.slips[apex]
        m = np.concatenate(
            [
                point.force[tuple(self._on.T)],
                point.force[apex],
                slips[:, 0],
                slips[:, 1],
                point.opening[tuple(self._shut.T)],
                [point.caps[name] for name in self._caps],
            ]
        )
        jacobian, _, _ = self.equations(np.r_[point.x, point.traction], None)
        rest = self.goal + jacobian[: len(m)].T @ m
        return np.concatenate([m, lstsq(jacobian[len(m) :].T, -rest)[0] if len(self._c.balance) else []])

    def point(self, z: Array, m: Array) -> Point:
        """The point that variables and multipliers of the active rows make."""
        form = self._form
        q, _ = self._reactions(z)
        on, apex = tuple(self._on.T), tuple(self._apex.T)
        force, slips, opening = np.zeros(form.p_given.shape), np.zeros(form.q_given.shape), np.zeros(form.p_given.shape)
        parts = np.split(m, np.cumsum([len(self._on), *[len(self._apex)] * 3, len(self._shut), len(self._caps)]))
        force[on], force[apex] = np.maximum(parts[0], 0.0), parts[1]
        slips[on] = -force[on][:, None] * q[on] / np.linalg.norm(q[on], axis=1)[:, None]
        slips[apex] = np.stack([parts[2], parts[3]], axis=-1)
        opening[tuple(self._shut.T)] = np.maximum(parts[4], 0.0)
        caps = dict.fromkeys(form.caps, 0.0) | {name: max(float(value), 0.0) for name, value in zip(self._caps, parts[5], strict=True)}
        return Point(z[: self._m], z[self._m :], force, slips, opening, caps)
