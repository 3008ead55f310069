"""Lower bounds of the load factor at which each node can be critical, computed without a program.

One slip mechanism for each node j gives a bound. Its multipliers obey `A d + B^T (f a) = 0`, with
`a = abs(d)` at all other nodes and a_j = -1. Then no residual slip changes the sum of `d q + f a
p`. Let h(d) be the largest `-(d q1 + f abs(d) p1)` over the corners::

    resistance = sum of d q0 + f a p0   >=   load_factor drive
    drive = d_j c - f rho + sum of h(d) over the others

A fixed-point iteration looks for such multipliers. If it does not converge (large friction), the
bound of node j is 0.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base import CONDENSATION, RESIDUAL, Array, Booleans
from .critical_state import needed
from .elastic import elastic
from .question import Question


@dataclass(frozen=True)
class ScreeningSettings:
    """Numbers of the fixed-point iteration."""

    # Largest number of iterations.
    iterations: int = 300
    # A mechanism has converged if its relative change is at most this.
    settled: float = RESIDUAL
    # Relative excess of the slips of a mechanism, so that it is admissible before it converges.
    spare: float = 1e3 * RESIDUAL
    # A mechanism of this size diverges.
    large: float = 1e6
    # Number of weighted means over rigid slides in one iteration; more hardly raise the bounds.
    means: int = 3
    # In the weights, slips below this share of the largest are raised to it: the means converge.
    near: float = 1e-2
    # Relative rounding error of a bound, due to the errors of the data.
    rounding: float = CONDENSATION


SCREENING = ScreeningSettings()


def load_factor_bounds(question: Question) -> Array:
    """(N,) lower bounds of the load factor at which each node can be critical.

    A bound is 0 if nothing is known, and inf if the node can never be critical.
    """
    nodes = len(question.friction)
    if question.fixed:
        # Which corner governs depends on the load factor.
        return np.zeros(nodes)
    unit = question.node_unit[:, None]
    net_slips = _net_slips(question)
    total_slip, admissible = _settled_mechanisms(net_slips, unit)

    d = net_slips(total_slip) / unit  # (t, N, N) slips, by node and mechanism
    a = total_slip / unit  # (N, N)
    fa = question.friction[:, None] * total_slip / unit
    shear, bound = needed(question.friction, question.q1, question.p1)
    resistance_terms = np.array([_work(d, question.q0[0]), fa * question.p0[0][:, None]])
    drive_terms = _work(d, shear) + a * bound[:, None]
    if nodes > 1:
        corners = zip(question.q1, question.p1, strict=True)
        drive_at_other_nodes = np.max([-_work(d, q) - fa * p[:, None] for q, p in corners], axis=0)
        drive_terms = np.where(np.eye(nodes, dtype=bool), drive_terms, drive_at_other_nodes)
    resistance = resistance_terms.sum(axis=(0, 1))
    drive = drive_terms.sum(axis=0)
    terms = np.abs(resistance_terms).sum(axis=(0, 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        bounds = np.where(drive < 0, resistance / drive, np.inf) * (1 - SCREENING.rounding)
    proven = admissible & (resistance < -SCREENING.rounding * terms)
    return np.asarray(np.where(proven, bounds, 0.0))


def _settled_mechanisms(net_slips: Callable[[Array], Array], unit: Array) -> tuple[Array, Booleans]:
    """Total slips a (N, N) of the mechanisms, in columns, and which of them are admissible."""
    total_slip = -np.eye(len(unit))
    for _ in range(SCREENING.iterations):
        net = np.linalg.norm(net_slips(total_slip), axis=0)
        size = unit * np.abs(total_slip / unit).max(axis=0)
        next_total = (1 + SCREENING.spare) * net + SCREENING.settled * size
        np.fill_diagonal(next_total, -1.0)
        np.fill_diagonal(net, -1.0)
        converged = (np.abs(next_total - total_slip) <= SCREENING.settled * size).all(axis=0)
        admissible: Booleans = (net <= total_slip).all(axis=0) & converged
        diverges = ~(total_slip.max(axis=0) < SCREENING.large)
        if (admissible | diverges).all():
            break
        total_slip = np.where(admissible | diverges, total_slip, next_total)
    return total_slip, admissible


def _work(d: Array, q: Array) -> Array:
    """Work (N, N) of shear forces (N,) or (N, 2) on slips (t, N, N): by node and mechanism."""
    return np.asarray(np.einsum("tij,it->ij", d, q.reshape(d.shape[1], -1)))


def _net_slips(question: Question) -> Callable[[Array], Array]:
    """A function that returns the net slips (t, N, N) in balance with given total slips (N, N).

    Elasticity does not determine rigid slides. They follow from friction: as means of the slips
    over the nodes, with weights from the previous slips.
    """
    n = question.system.nodes
    t = question.system.tangents
    closed = elastic(question)
    unit = np.tile(question.node_unit, t)[:, None]
    # Slips that follow the total slips, and rigid slides.
    follow = np.zeros((t * n, n))
    follow[closed.slips] = -(closed.normal * ~question.open_nodes[:, None]).T
    follow *= unit * question.friction / question.node_unit
    free = closed.slides.shape[1]
    rigid = np.zeros((t * n, free))
    rigid[closed.slips] = closed.slides
    rigid *= unit
    pairs = (rigid[:, :, None] * rigid[:, None]).reshape(t * n, -1)
    bound = question.friction * question.r0[0, -1] / question.node_unit
    positive_bound = np.tile(np.maximum(bound, 0.0), t)[:, None]

    def net_slips(total: Array) -> Array:
        slips = follow @ total
        for _ in range(SCREENING.means if free else 0):
            size = np.linalg.norm(slips.reshape(t, n, n), axis=0)
            floor = SCREENING.near * size.max() or 1.0
            weight = positive_bound / np.tile(np.maximum(size, floor), (t, 1))
            # The slides s with the least sum of `weight (slips - rigid s)^2`.
            square = (weight.T @ pairs).reshape(n, free, free)
            right_side = (rigid.T @ (weight * slips)).T[..., None]
            slides = (np.linalg.pinv(square, hermitian=True) @ right_side)[..., 0].T
            slips = slips - rigid @ slides
        return np.asarray(slips.reshape(t, n, n))

    return net_slips
