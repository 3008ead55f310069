"""The proof that a set of open nodes has no limit above a load factor, by one mechanism.

Nodes stay open only if slip lifts them, and friction bounds the slip. If the load closes an open
node far enough, one mechanism proves that friction cannot hold such a slip, for the price of one
factorisation instead of a program. In the mechanism the open node closes by 1, and the closed nodes
slip by `s` and lift by `f t`, so that no residual slip does work on it:

    A s = B' (f t) + W' e,    |s| <= t.

Friction dissipates at most the work `f t p - s q` at each closed node, at the corner of its own
choice. If the sum of these works and of the gap is negative at a load factor, no slip is safe
there. The sum is concave in the load factor: if it falls from there on, it stays negative.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base import CONDENSATION, RESIDUAL, Array, unresisted
from .question import Question


@dataclass(frozen=True)
class MechanismSettings:
    """Numbers of the mechanism."""

    # Lifts grow by this factor in each round, so that they reach the slips after a few rounds.
    growth: float = 1.01
    # Largest number of rounds. If friction is above the critical value, there is no end.
    rounds: int = 20


MECHANISM = MechanismSettings()


def is_at_most(question: Question, above: float) -> bool:
    """Whether a mechanism proves that the limit of a question is at most `above`.

    False proves nothing.
    """
    if not (np.isfinite(above) and len(question.W)):
        return False
    gaps = (question.w0 + above * question.w1).min(axis=0)
    node = int(gaps.argmin())
    if gaps[node] >= 0:
        return False
    mechanism = _mechanism(question, node)
    if mechanism is None:
        return False
    work, size = _work(question, above, node, *mechanism)
    further, _ = _work(question, above + question.load_unit, node, *mechanism)
    return bool(work < -RESIDUAL * size and further <= work)


def _mechanism(question: Question, node: int) -> tuple[Array, Array] | None:
    """Slips s (t, n) and lifts t (n,) of the closed nodes while the open node closes by 1.

    `node` counts the open nodes. None if friction is too large for such lifts, or if a slide that
    nothing resists closes the node.
    """
    closed = np.flatnonzero(~question.open_nodes)
    nodes, tangents = question.system.nodes, question.system.tangents
    slips = np.concatenate([closed + axis * nodes for axis in range(tangents)])
    sizes = question.system.own_stiffness
    A = question.A[np.ix_(slips, slips)]
    press = question.B[np.ix_(closed, slips)] * question.friction[closed, None]
    pressing = press / np.sqrt(sizes[-nodes:][closed])[:, None]
    slides, compliance = unresisted(A, sizes[slips], pressing)
    by_gap = question.W[node, slips]
    if np.abs(by_gap @ slides).max(initial=0.0) > CONDENSATION * np.abs(by_gap).max():
        return None

    lifts = np.zeros(len(closed))
    for _ in range(MECHANISM.rounds):
        s = (compliance @ (by_gap + lifts @ press)).reshape(tangents, -1)
        sizes = np.linalg.norm(s, axis=0)
        if (sizes <= lifts).all():
            return s, lifts
        lifts = np.maximum(lifts, MECHANISM.growth * sizes)
    return None


def _work(
    question: Question, load_factor: float, node: int, s: Array, lifts: Array
) -> tuple[float, float]:
    """The least work of the mechanism at a load factor, and the sum of the sizes of its terms.

    The strictest corner is chosen at each node.
    """
    closed = ~question.open_nodes
    r = (question.r0 + load_factor * question.r1)[:, :, closed]  # (K, t + 1, n)
    dissipated = question.friction[closed] * lifts * r[:, -1]
    supplied = (s * r[:, :-1]).sum(axis=1)
    gap = (question.w0 + load_factor * question.w1)[:, node].min()
    work = (dissipated - supplied).min(axis=0).sum() + gap
    size = (np.abs(dissipated) + np.abs(supplied)).max(axis=0).sum() + abs(gap)
    return float(work), float(size)
