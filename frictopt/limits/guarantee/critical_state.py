"""The critical states of nodes: their pressure just keeps them stuck under the cyclic load.

A critical node is on its friction bound at two opposite corners, or at three corners that enclose
its mean traction. Eq. (10) of the theory gives the shear c and the pressure rho that the node
needs: the smallest disc that contains the discs with centres `-q1_k` and radii `-f p1_k` has the
centre c and the radius `f rho`. If the fixed parts of the corners differ, each pair of corners that
governs at some load factor has its own critical state, affine in the load factor.
"""

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from ...base import ROUNDING, Array, kept
from ...contact import lengths
from ..program.question import Question, ruling


@kept
@dataclass(frozen=True, eq=False)
class CriticalState:
    """The reactions that a slip adds at a node to make it critical, affine in the load factor.

    `[A v, B v] = at_zero + load_factor rate`, each (t + 1,), force. At `corners` the node is on its
    bound; in the plane, this is the bound of forward slip at the first corner, and of backward slip
    at the second.
    """

    node: int
    corners: tuple[int, ...]
    at_zero: Array
    rate: Array

    def distance(self, question: Question, load_factor: float, slip: Array) -> float:
        """Distance of this state from the reactions that a slip adds, over the force unit."""
        q, p = question.reactions_of_slip(slip)
        added = np.r_[q[self.node], p[self.node]]
        return float(np.abs(added - self.at_zero - load_factor * self.rate).max()) / question.force


def needed(friction: Array, q1: Array, p1: Array) -> tuple[Array, Array]:
    """Shear c (N,) or (N, 2) and friction bound `f rho` (N,) that nodes need at load factor 1."""
    fp1 = friction * p1
    if q1.ndim == 3:
        return smallest_discs(-q1.transpose(1, 0, 2), -fp1.T)
    forward_demand = (-q1 - fp1).max(axis=0)
    backward_demand = (q1 - fp1).max(axis=0)
    return (forward_demand - backward_demand) / 2, (forward_demand + backward_demand) / 2


def critical_states(question: Question) -> list[list[CriticalState]]:
    """The critical states of each node.

    A node has no critical state if it has no friction or can only lift off. If all corners are the
    same at load factor 0, any other node has a single critical state; otherwise it has one for each
    pair of corners that govern. In space no critical state is computed if the corners differ at
    load factor 0: such contacts only come here if they are uncoupled, and then need no critical
    state.
    """
    if question.fixed and question.q1.ndim == 3:
        return [[] for _ in question.friction]
    if question.fixed:
        return _states_of_pairs(question)
    f = question.friction
    q1 = question.q1
    p1 = question.p1
    shear, bound = needed(f, q1, p1)
    size = (lengths(q1, p1) + f * np.abs(p1)).max(axis=0)
    q = q1 + shear
    # Corners that are equally far from the bound, up to rounding, govern together.
    governs = lengths(q, p1) - f * p1 >= bound - ROUNDING * size  # (K, N)
    cyclic = (bound > (-f * p1).max(axis=0) + ROUNDING * size) & (f > 0)

    states: list[list[CriticalState]] = [[] for _ in f]
    for i in np.flatnonzero(cyclic).tolist():
        corners = tuple(np.flatnonzero(governs[:, i]).tolist())
        if q.ndim == 2:
            forward = next(k for k in corners if q[k, i] < 0)
            backward = next(k for k in corners if q[k, i] > 0)
            corners = (forward, backward)
        at_zero = -question.r0[0, :, i]
        states[i].append(CriticalState(i, corners, at_zero, np.r_[shear[i], bound[i] / f[i]]))
    return states


def _states_of_pairs(question: Question) -> list[list[CriticalState]]:
    """The critical states in the plane if the corners differ at load factor 0."""
    q0, p0 = question.r0.swapaxes(0, 1)
    q1, p1 = question.q1, question.p1
    fp0 = question.friction * p0
    fp1 = question.friction * p1
    rows = np.stack([q0, fp0, q1, fp1])  # (4, K, N)
    rounding = ROUNDING * np.abs(rows).max(axis=1)
    forward = ruling(-(q0 + fp0), -(q1 + fp1))
    backward = ruling(q0 - fp0, q1 - fp1)

    states: list[list[CriticalState]] = [[] for _ in question.friction]
    for i, friction in enumerate(question.friction):
        if not friction > 0:
            continue
        ends = product(np.flatnonzero(forward[:, i]), np.flatnonzero(backward[:, i]))
        for k, j in ends:
            if not (np.abs(rows[:, k, i] - rows[:, j, i]) > rounding[:, i]).any():
                continue
            pair = [k, j]
            at_zero = _at_both_bounds(friction, q0[pair, i], p0[pair, i])
            rate = _at_both_bounds(friction, q1[pair, i], p1[pair, i])
            states[i].append(CriticalState(i, (int(k), int(j)), at_zero, rate))
    return states


def _at_both_bounds(friction: float, q: Array, p: Array) -> Array:
    """(2,) shear and pressure that put a node on its bounds of forward and of backward slip.

    `q` (2,) and `p` (2,) are the reactions at the corners of forward and of backward slip, to which
    this shear and this pressure are added.
    """
    q_k, q_j = q
    b_k, b_j = friction * p
    return -np.array([q_k + q_j + b_k - b_j, (q_k - q_j + b_k + b_j) / friction]) / 2


def smallest_discs(centres: Array, radii: Array) -> tuple[Array, Array]:
    """Centres (n, 2) and radii (n,) of the smallest discs that contain n groups of K discs.

    `centres` (n, K, 2) and `radii` (n, K) describe the K discs of each group; radii may be
    negative. The search computes the smallest disc around a few discs of a group, and adds the disc
    that sticks out most to these few, until no disc sticks out.
    """
    cases = np.arange(len(radii))[:, None]
    spread = np.abs(centres - centres.mean(axis=1, keepdims=True)).max(axis=(1, 2))
    rounding = ROUNDING * (spread + np.abs(radii).max(axis=1))
    some = radii.argmax(axis=1)[:, None]
    while True:
        centre, radius = _smallest(centres[cases, some], radii[cases, some], rounding)
        far_ends = _reach(centres, radii, centre)
        if (far_ends.max(axis=1) <= radius + rounding).all():
            return centre, far_ends.max(axis=1)
        some = np.column_stack([some, far_ends.argmax(axis=1)])


def _smallest(centres: Array, radii: Array, rounding: Array) -> tuple[Array, Array]:
    """The smallest disc around each group of a few discs; it touches one, two or three of them."""
    centre = centres[:, 0]
    radius = np.full(len(radii), np.inf)
    for size in (1, 2, 3):
        for subset in map(list, combinations(range(radii.shape[1]), size)):
            for candidate in _touching(centres[:, subset], radii[:, subset]):
                around = _reach(centres, radii, candidate).max(axis=1)
                is_smaller = around < radius - rounding  # False for NaN: there is no such disc
                centre = np.where(is_smaller[:, None], candidate, centre)
                radius = np.where(is_smaller, around, radius)
    return centre, radius


def _reach(centres: Array, radii: Array, centre: Array) -> Array:
    """(n, K) distances from a centre (n, 2) to the far ends of discs."""
    return np.asarray(np.linalg.norm(centres - centre[:, None], axis=-1) + radii)


def _touching(centres: Array, radii: Array) -> list[Array]:
    """Centres (n, 2) of the discs that one, two or three given discs touch from inside.

    `centres` (n, m, 2), `radii` (n, m). A centre is NaN if there is no such disc.
    """
    first = centres[:, 0]
    offsets = centres[:, 1:] - centres[:, :1]
    radius_steps = radii[:, 1:] - radii[:, :1]
    right_side = np.stack(
        [((offsets**2).sum(axis=-1) - radius_steps**2) / 2, radius_steps], axis=-1
    )
    u, w = np.moveaxis(np.linalg.pinv(offsets) @ right_side, 2, 0)
    a = 1 - (w**2).sum(axis=-1)
    b = (u * w).sum(axis=-1)
    c = (u**2).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        if offsets.shape[1] == 1:
            # If the larger disc nearly contains the smaller one, rounding spoils a.
            distance = np.linalg.norm(offsets[:, 0], axis=-1)
            return [
                first + offsets[:, 0] * ((distance + radius_steps[:, 0]) / (2 * distance))[:, None]
            ]
        root = b + np.copysign(np.sqrt(b**2 + a * c), b)
        return [first + u + w * s[:, None] for s in (root / a, -c / root)]
