"""Onset of slip and separation of the bonded contact in three dimensions: node by node, the roots of a quadratic."""

from typing import Any

import numpy as np

from ..contact import LoadCycle, Onset, OnsetEvent, friction_coefficients
from ..contact.checks import Array
from ..contact.cycle import checked_cycle
from ..contact.tolerances import ROUNDING, SIMULTANEOUS
from .system import ContactSystem3D, checked_3d

__all__ = ["onset", "reach"]


def onset(system: ContactSystem3D, cycle: LoadCycle, friction: Any) -> Onset:
    """Find the first slip and the first separation of the bonded contact as the load grows towards each corner, `mean + lam * corner`, `lam >= 0`.

    Closed form, node by node: slip starts where `|q| = f p`, against q; separation where `p = 0`.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Bad friction, no load cycle, or a load case that the system lacks.
    """
    f = friction_coefficients(friction, checked_3d(system).nodes)
    q0, p0 = checked_cycle(cycle).mean_reaction(system)
    floor = ROUNDING * float(np.abs(p0).mean())
    slips, separations, residual = [], [], 0.0
    for corner, (q1, p1) in enumerate(zip(*cycle.corner_reactions(system), strict=True)):
        slack = f * p0 - np.linalg.norm(q0, axis=1)
        lam, node = _first(np.where(slack < -floor, 0.0, np.maximum(reach(q0, f * p0, q1, f * p1), 0.0)))
        q = np.zeros(2) if node is None else q0[node] + lam * q1[node]
        size = float(np.linalg.norm(q))
        slips.append(OnsetEvent(corner, "slip", lam, node, (0.0 - float(q[0]) / size, 0.0 - float(q[1]) / size) if size > 0 else (0.0, 0.0)))
        with np.errstate(divide="ignore", invalid="ignore"):
            lam, node = _first(np.where(p0 < -floor, 0.0, np.where(p1 < 0, np.maximum(p0, 0.0) / -p1, np.inf)))
        separations.append(OnsetEvent(corner, "separation", lam, node, (0.0, 0.0)))
        lam = min(slips[-1].load_factor, separations[-1].load_factor)
        lam = lam if np.isfinite(lam) else 0.0
        unit = max(lam, 1.0)  # the load itself may be too large for a number
        residual = max(residual, _violation(f, q0 / unit + lam / unit * q1, p0 / unit + lam / unit * p1))
    beyond = np.linalg.norm(q0, axis=1) - f * p0 > floor
    return Onset(tuple(slips), tuple(separations), _listed(beyond), _listed(p0 < -floor), residual, system, cycle, f)


def reach(q0: Array, g0: Array, q1: Array, g1: Array) -> Array:
    """Largest lam with `|q0 + lam q1| <= g0 + lam g1`, inf where there is none; such lam form an interval, because the cone is convex.

    q0, q1 are (..., 2), the bounds g0, g1 (...,). Where no lam obeys it, the one nearest to it.
    """
    a, b, c = (q1**2).sum(axis=-1) - g1**2, (q0 * q1).sum(axis=-1) - g0 * g1, g0**2 - (q0**2).sum(axis=-1)  # a lam^2 + 2 b lam <= c
    root = np.sqrt(np.maximum(b**2 + a * c, 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        last = np.where(b > 0, c / (b + root), np.where(a > 0, (root - b) / a, np.inf))  # each without cancellation
    return np.where(g1 >= np.linalg.norm(q1, axis=-1), np.inf, last)


def _first(factors: Array) -> tuple[float, int | None]:
    """The least load factor and its node, of simultaneous ones the first."""
    least = float(factors.min())
    return (least, int(np.argmax(factors <= least * (1 + SIMULTANEOUS)))) if np.isfinite(least) else (np.inf, None)


def _listed(nodes: np.ndarray) -> tuple[int, ...]:
    return tuple(int(i) for i in np.flatnonzero(nodes))


def _violation(f: Array, q: Array, p: Array) -> float:
    """Violation of the contact law by reactions of the contact that is closed and does not slip."""
    force = float(max(np.abs(q).max(), np.abs(p).max(), (f * np.abs(p)).max())) or 1.0
    return float(max((np.linalg.norm(q, axis=1) - f * p).max(), -p.min(), 0.0)) / force
