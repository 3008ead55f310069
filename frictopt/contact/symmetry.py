"""Mirror symmetry about the middle of the interface: a symmetric half is a contact of its own, and its results are expanded to the whole."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .checks import Array, frozen
from .system import ContactSystem
from .tolerances import ASYMMETRY, ASYMMETRY_OF_LOADS

__all__ = ["Part", "halve", "is_odd", "is_symmetric_load", "whole"]


@dataclass(frozen=True, eq=False)
class Part:
    """The part of a contact that is solved for, and what its results mean for the whole contact.

    The part is the whole contact, or the left half of a mirror-symmetric one with its middle node, if there is one. In a symmetric state v and q are
    odd, w and p are even. Each node of the whole has a source, the node of the part that stands for it, with a sign for v and q.

    The reactions of the part are those of the whole at the same nodes. The middle node cannot slip in a symmetric state (its sign is 0). In the half
    its gap counts half, so that the energy of the half is half of that of the whole.

    Attributes
    ----------
    contact
        The whole contact.
    nodes
        Number of nodes of the part, h.
    source
        (N,) node of the part that stands for each node of the whole.
    sign
        (N,) +1, -1 for images, 0 for the middle node.
    left_out
        Sentences that say what was left out: the symmetric half, or nothing.
    """

    contact: ContactSystem
    nodes: int
    source: NDArray[np.intp]
    sign: Array
    left_out: tuple[str, ...] = ()

    @cached_property
    def system(self) -> ContactSystem:
        """The part, a contact of h nodes with the load cases of the whole."""
        whole, n = self.contact, self.contact.nodes
        if self.nodes == n:
            return whole
        kept, middle = self.nodes, slice(n // 2, (n + 1) // 2)  # the middle is empty where the number of nodes is even
        A, B, C = (M[:kept, :kept] + sign * M[:kept, ::-1][:, :kept] for M, sign in ((whole.A, -1), (whole.B, -1), (whole.C, 1)))
        A[middle], A[:, middle] = 0.0, 0.0  # nothing couples its slip to the others, and nothing drives it
        A[middle, middle] = whole.stiffness_scale
        gap = np.where(np.arange(kept) < n // 2, whole.gap[:kept], whole.gap[:kept] / 2)
        bonded = {name: (q[:kept], p[:kept]) for name, (q, p) in whole.bonded.items()}
        return ContactSystem.from_blocks(A, B, C, whole.x[:kept], bonded, gap)

    @cached_property
    def share(self) -> Array:
        """(N,) one over the number of nodes with the same source."""
        return np.asarray(1.0 / np.bincount(self.source)[self.source])

    def of(self, values: Array) -> Array:
        """(..., h) values of the part's nodes, from those of all nodes, (..., N)."""
        return values[..., : self.nodes]

    def odd(self, values: Array) -> Array:
        """(..., N) slips or shear forces of the whole, from those of the part, (..., h)."""
        return np.asarray(self.sign * values[..., self.source])

    def even(self, values: Array) -> Array:
        """(..., N) normal forces of the whole, from those of the part, (..., h)."""
        return np.asarray(values[..., self.source])

    def gaps(self, values: Array) -> Array:
        """(..., N) gaps of the whole, from those of the part, (..., h)."""
        return np.asarray(np.where(self.sign == 0, 2.0, 1.0) * values[..., self.source])


def whole(system: ContactSystem) -> Part:
    """The whole contact."""
    return Part(system, system.nodes, np.arange(system.nodes), np.ones(system.nodes))


def halve(system: ContactSystem, friction: Array, reactions: Iterable[tuple[Array, Array]] = (), slip_bound: Array | None = None) -> Part | None:
    """Half of a contact that is mirror-symmetric with its friction, its loads and its slip bound and has more than one node, else None.

    Parameters
    ----------
    system
        The contact.
    friction
        (N,) coefficients of friction.
    reactions
        Pairs `(q, p)`, each (N,) or (K, N), of the loads in question.
    slip_bound
        (N,) bounds of the slip; None for no bound.
    """
    n, A, B, C = system.nodes, system.A, system.B, system.C
    own = np.sqrt(np.maximum(np.diag(A), np.diag(C)).clip(0.0))
    stiffness = np.outer(own, own)  # a soft node beside stiff ones has its own rounding
    even = [friction, system.gap] if slip_bound is None else [friction, system.gap, slip_bound]
    if n == 1 or not (_same(A, np.flip(A), stiffness) and _same(B, -np.flip(B), stiffness) and _same(C, np.flip(C), stiffness)):
        return None
    if not (all(_same(part, part[::-1], float(part.max())) for part in even) and all(is_symmetric_load(q, p) for q, p in reactions)):
        return None
    kept = (n + 1) // 2
    source = np.minimum(np.arange(n), np.arange(n)[::-1])
    sign = np.sign(np.arange(n)[::-1] - np.arange(n)).astype(np.float64)
    return Part(system, kept, source, frozen(sign), (f"mirror symmetry: v is odd, {kept} of {n} nodes are in the program",))


def is_odd(slip: Array) -> bool:
    """Whether a slip, (N,), is its own mirror image, up to rounding."""
    return _same(slip, -slip[::-1], float(np.abs(slip).max()))


def is_symmetric_load(q: Array, p: Array) -> bool:
    """Whether reactions, each (N,) or (K, N), are their own mirror image, up to rounding."""
    scale = float(max(np.abs(q).max(), np.abs(p).max())) * (ASYMMETRY_OF_LOADS / ASYMMETRY)
    return _same(q, -q[..., ::-1], scale) and _same(p, p[..., ::-1], scale)


def _same(one: Array, other: Array, scale: float | Array) -> bool:
    return bool((np.abs(one - other) <= ASYMMETRY * scale).all())
