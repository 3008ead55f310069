"""The exact solution of a cone program whose active cones a solver has found: Newton's method on their equations."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lstsq

from ..contact.checks import Array
from ..contact.tolerances import NOT_UNIQUE, POLISHED, ROUNDING, STALLED
from .cone_scaling import ScaledCones

__all__ = ["ConeForm", "Point", "on_active_cones"]

_STEPS = 8  # of Newton's method at most; mostly three do
_GAPS = 4  # between ratios of multiplier to slack that are tried
_REVISIONS = 4  # of the active cones from one such gap
_LEAST_RATIO = 1e-12  # ratios below it, and above its inverse, are alike


@dataclass(frozen=True, eq=False)
class ConeForm:
    """A cone program over m scalars x and the tractions t of a residual slip, for K corners and N nodes.

    Maximise `goal x` subject to `|q| <= f p - reserve x` (and `p >= reserve x` for little friction) with `q = q_given + q_rate x + shear t` and
    `p = p_given + p_rate x + G t`, and to caps `row x <= right`. Where `bare`, the circle is the point `q = 0`.
    """

    goal: Array
    q_given: Array
    p_given: Array
    q_rate: Array
    p_rate: Array
    reserve: Array
    caps: Mapping[str, tuple[Array, float]]
    bare: np.ndarray

    def reactions(self, c: ScaledCones, x: Array, t: Array) -> tuple[Array, Array]:
        """(K, N, 2) shear forces q and (K, N) pressures p."""
        q = self.q_given + np.tensordot(x, self.q_rate, 1) + np.stack(np.split(c.shear * t, 2), axis=-1)
        return q, self.p_given + np.tensordot(x, self.p_rate, 1) + c.G @ t


@dataclass(frozen=True, eq=False)
class Point:
    """Variables and multipliers of a cone program, dimensionless.

    Attributes
    ----------
    x
        (m,) scalars.
    traction
        (2N,) tractions of the residual slip.
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
    def admissible(self) -> "Point":
        """The same without negative multipliers."""
        slips = np.where((self.force < 0)[..., None], 0.0, self.slips)
        caps = {name: max(value, 0.0) for name, value in self.caps.items()}
        return Point(self.x, self.traction, np.maximum(self.force, 0.0), slips, np.maximum(self.opening, 0.0), caps)

    @property
    def weight(self) -> Array:
        """(K, N) multipliers of the reserve at each node."""
        return np.asarray(np.maximum(self.force, np.linalg.norm(self.slips, axis=-1)) + self.opening)


def first_of(bare: np.ndarray) -> np.ndarray:
    """(K, N) the first corner at which the circle of a node is a point: it keeps the shear at zero for all."""
    return np.asarray(bare & (np.cumsum(bare, axis=0) == 1))


def on_active_cones(c: ScaledCones, form: ConeForm, point: Point) -> Point:
    """Solve the optimality conditions of the cones that are active at a point near the solution, by Newton's method.

    Which cones are active is read from the ratios of multiplier to slack, which an interior-point method leaves large for active cones and small for
    the others. Where the widest gap between the ratios does not part them rightly, the next ones are tried; cones that the solution contradicts
    change sides. The answer is the point that breaks the conditions of the whole program least; whether it is good enough is for a residual to say.
    """
    best, least = point, _error(c, form, point)
    with np.errstate(all="ignore"):  # a step of a wrong guess may go anywhere, and its error tells
        for share in _shares(c, form, point):
            found, active = point, _Active(c, form, point, share)
            for _ in range(_REVISIONS):
                found = _newton(active, found)
                error = _error(c, form, found.admissible)
                if error < least:
                    best, least = found.admissible, error
                if least <= ROUNDING:
                    return best
                before, active = active, _Active(c, form, found, share)
                if active.same_as(before):
                    break
    return best


def _shares(c: ScaledCones, form: ConeForm, point: Point) -> list[float]:
    """Ratios of multiplier to slack in the middle of the widest gaps between those of all cones, the widest gap first."""
    pairs = _pairs(c, form, point)
    circles = ~form.bare
    slack, multiplier = (np.concatenate([pair[side][circles] for pair in pairs[:2]] + [pair[side].ravel() for pair in pairs[2:]]) for side in (0, 1))
    ratios = np.where(slack > 0, multiplier / np.where(slack > 0, slack, 1.0), np.inf)
    powers = np.sort(np.log10(np.clip(ratios, _LEAST_RATIO, 1 / _LEAST_RATIO)))
    return [float(10 ** powers[[k, k + 1]].mean()) for k in np.argsort(-np.diff(powers), kind="stable")[:_GAPS]]


def _pairs(c: ScaledCones, form: ConeForm, point: Point) -> tuple[tuple[Array, Array], ...]:
    """(K, N) slacks and multipliers of the circles on their boundary, at their apex, and of the rows against opening."""
    q, p = form.reactions(c, point.x, point.traction)
    reserve = point.x @ form.reserve
    bound, radius, slid = c.friction * p - reserve, np.linalg.norm(q, axis=-1), np.linalg.norm(point.slips, axis=-1)
    boundary, apex = (bound - radius, point.force + np.copysign(slid, point.force)), (bound + radius, point.force - slid)
    return (boundary, apex, (p - reserve, point.opening)) if c.opening else (boundary, apex)


def _newton(active: "_Active", point: Point) -> Point:
    """Newton's method on the equations of active cones."""
    best, least, z, m = None, np.inf, np.r_[point.x, point.traction], active.multipliers(point)
    for _ in range(_STEPS):
        jacobian, values, hessian = active.equations(z, m)
        error = max(float(np.abs(active.goal + jacobian.T @ m).max()), float(np.abs(values).max(initial=0.0)))
        if error < least:
            best, least = (z, m), error
        elif least <= STALLED or not np.isfinite(error):
            break
        if error <= POLISHED:
            break
        rows = len(values)
        matrix = np.block([[hessian, jacobian.T], [jacobian, np.zeros((rows, rows))]])
        step = lstsq(matrix, -np.r_[active.goal, values], cond=NOT_UNIQUE, lapack_driver="gelsy", check_finite=False)[0]
        z, m = z + step[: len(z)], step[len(z) :]
    return point if best is None else active.point(*best)


def _error(c: ScaledCones, form: ConeForm, point: Point) -> float:
    """Largest violation of the optimality conditions of the whole program: rows, balance of the multipliers, and their work on the slacks."""
    if not all(np.isfinite(part).all() for part in (point.x, point.traction, point.force, point.slips, point.opening)):
        return np.inf
    q, p = form.reactions(c, point.x, point.traction)
    reserve = point.x @ form.reserve
    bound, force = c.friction * p - reserve, np.maximum(point.force, np.linalg.norm(point.slips, axis=-1))
    caps = [(row, right - row @ point.x, point.caps[name]) for name, (row, right) in form.caps.items()]
    slacks = [bound - np.linalg.norm(q, axis=-1), np.array([room for _, room, _ in caps]), *([p - reserve] if c.opening else [])]
    work = np.sum(force * bound) + np.sum(point.slips * q) + np.sum(point.opening * (p - reserve)) + sum(room * by for _, room, by in caps)
    lift = c.friction * force + point.opening
    stress = c.shear * point.slips.sum(axis=0).T.ravel() + c.G.T @ lift.sum(axis=0)
    if c.balance.size:
        stress = stress - c.balance.T @ lstsq(c.balance.T, stress)[0]
    goal = form.goal + (form.p_rate * lift).sum(axis=(1, 2)) + (form.q_rate * point.slips).sum(axis=(1, 2, 3))
    goal = goal - form.reserve @ (force + point.opening).sum(axis=0) - sum(by * row for row, _, by in caps)
    return float(max(*(-slack.min() for slack in slacks), np.abs(stress).max(), np.abs(goal).max(), abs(work)))


class _Active:
    """Equations of the active rows: circles on their boundary, circles at their apex, rows against opening, caps, and balance."""

    def __init__(self, c: ScaledCones, form: ConeForm, point: Point, share: float) -> None:
        self._c, self._form, self._m = c, form, len(form.goal)
        self.goal = np.r_[form.goal, np.zeros(2 * c.nodes)]
        (slack, slid), (tip, excess), *opening = _pairs(c, form, point)
        apex = share * tip < excess
        q, _ = self._reactions(np.r_[point.x, point.traction])
        self._on = np.argwhere((slid > share * slack) & ~apex & ~form.bare & q.any(axis=-1))
        self._apex = np.argwhere((apex & ~form.bare) | first_of(form.bare))
        self._shut = np.concatenate([np.zeros((0, 2), dtype=int), *(np.argwhere(multiplier > share * room) for room, multiplier in opening)])
        self._caps = [name for name, (row, right) in form.caps.items() if point.caps[name] > share * (right - row @ point.x)]

    def same_as(self, other: "_Active") -> bool:
        """Whether the same cones are active."""
        rows = ((self._on, other._on), (self._apex, other._apex), (self._shut, other._shut))
        return self._caps == other._caps and all(np.array_equal(*pair) for pair in rows)

    def _reactions(self, z: Array) -> tuple[Array, Array]:
        return self._form.reactions(self._c, z[: self._m], z[self._m :])

    def _shear_rows(self, where: np.ndarray) -> Array:
        """(rows, 2, m + 2N) gradients of q."""
        n, count = self._c.nodes, len(where)
        rows = np.zeros((count, 2, self._m + 2 * n))
        rows[:, :, : self._m] = np.moveaxis(self._form.q_rate[:, where[:, 0], where[:, 1]], 0, -1)
        for axis in (0, 1):
            rows[np.arange(count), axis, self._m + axis * n + where[:, 1]] = self._c.shear[axis * n + where[:, 1]]
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
        radius = np.where(radius > 0, radius, 1.0)
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
        force[on], force[apex] = parts[0], parts[1]
        slips[on] = -force[on][:, None] * q[on] / np.linalg.norm(q[on], axis=1)[:, None]
        slips[apex] = np.stack([parts[2], parts[3]], axis=-1)
        force = np.where(form.bare, np.linalg.norm(slips, axis=-1), force)
        opening[tuple(self._shut.T)] = parts[4]
        caps = dict.fromkeys(form.caps, 0.0) | {name: float(value) for name, value in zip(self._caps, parts[5], strict=True)}
        return Point(z[: self._m], z[self._m :], force, slips, opening, caps)
