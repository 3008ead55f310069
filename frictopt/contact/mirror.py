"""Mirror symmetry about the middle of the interface, and absence of coupling: what lets a scene be solved with less."""

from collections.abc import Iterable

import numpy as np

from .checks import Array
from .system import ContactSystem

__all__ = ["EXACT", "EXACT_LOAD", "MirrorHalf", "is_mirror_symmetric", "is_uncoupled", "mirror_half"]

EXACT = 1e-13
"""Asymmetry of stiffness, friction and slip, over their largest value, up to which a half stands for the whole: states add nothing to it."""

EXACT_LOAD = 1e-12
"""The same of a load, over its largest value: the rounding of a condensation, which every state feels only once."""

_NO_COUPLING = 1e-13
_ROUNDING = 1e-10  # differences below this share of the largest entry are rounding of a condensation


def is_mirror_symmetric(system: ContactSystem, reactions: Iterable[tuple[Array, Array]], friction: Array, rounding: float = _ROUNDING) -> bool:
    """Whether stiffness, gap, friction and reactions map onto themselves when node i becomes node N - 1 - i.

    In a mirror image v and q change sign, w and p do not.

    Parameters
    ----------
    system
        The contact.
    reactions
        Pairs `(q, p)`, each (N,) or (K, N), of the loads in question.
    friction
        (N,) coefficients of friction.
    rounding
        Differences below this share of the largest entry count as none.
    """
    A, B, C, gap = system.A, system.B, system.C, system.gap
    parts = (A, A, 1), (B, A, -1), (C, C, 1), (friction, friction, 1), (gap, gap, 1)
    if not all(_same(part, sign * np.flip(part), float(np.abs(scale).max()), rounding) for part, scale, sign in parts):
        return False
    for q, p in reactions:
        scale = float(max(np.abs(q).max(), np.abs(p).max()))
        if not (_same(q, -q[..., ::-1], scale, rounding) and _same(p, p[..., ::-1], scale, rounding)):
            return False
    return True


def is_uncoupled(system: ContactSystem, friction: Array) -> bool:
    """Whether tangential motion leaves the friction bounds alone: f B is zero up to rounding, against A."""
    coupling = float(np.abs(friction[:, None] * system.B).max())
    return coupling <= _NO_COUPLING * float(np.abs(system.A).max())


def _same(one: Array, other: Array, scale: float, rounding: float) -> bool:
    return bool(np.abs(one - other).max() <= rounding * scale)


class MirrorHalf:
    """Half of a mirror-symmetric contact: a contact of its own, of the nodes left of the middle and, if there is one, the middle node.

    The motions of the whole are `v = [v_h, -J v_h], w = [w_h, J w_h]`, with J the mirror image; energy and work of the half are half of those of the
    whole. A middle node has half its force in the half, its v is 0 and its q with it: nothing couples it to the others, and it cannot slip.

    Parameters
    ----------
    whole
        The contact. Parts of its stiffness, gap and load cases that are not symmetric are dropped: `is_mirror_symmetric` says whether there are any.

    Attributes
    ----------
    system
        The half, with the load cases of the whole.
    """

    def __init__(self, whole: ContactSystem) -> None:
        self._nodes, self._kept = whole.nodes, (whole.nodes + 1) // 2
        bonded = {name: self._parted(self.forces(np.concatenate(pair))) for name, pair in whole.bonded.items()}
        self.system = ContactSystem(*self._folded(whole), whole.x[: self._kept], bonded, self.even(whole.gap))

    @property
    def nodes(self) -> int:
        """Number of node pairs of the half, h."""
        return self._kept

    @property
    def _centred(self) -> bool:
        return self._nodes % 2 == 1

    def nodal(self, values: Array) -> Array:
        """(..., h) part of values of the nodes, (..., N)."""
        return values[..., : self._kept]

    def odd(self, values: Array) -> Array:
        """(h,) odd part of values of the nodes, (N,): of slips."""
        return self.nodal((values - values[::-1]) / 2)

    def even(self, values: Array) -> Array:
        """(h,) even part of values of the nodes, (N,): of gaps."""
        return self.nodal((values + values[::-1]) / 2)

    def forces(self, r: Array) -> Array:
        """(2h,) forces `[q, p]` of the half, from those of the whole, (2N,)."""
        q, p = self._parted(r)
        folded: Array = np.concatenate([self.odd(q), self.even(p)])
        if self._centred:
            folded[-1] /= 2
        return folded

    def whole_forces(self, r: Array) -> Array:
        """(..., 2N) forces of the whole, from those of the half, (..., 2h)."""
        whole = self.whole_motion(r)
        if self._centred:
            whole[..., self._nodes + self._kept - 1] *= 2
        return whole

    def whole_motion(self, u: Array) -> Array:
        """(..., 2N) motion `[v, w]` of the whole, from that of the half, (..., 2h)."""
        v, w = self._parted(u)
        return np.concatenate([v, -self._image(v), w, self._image(w)], axis=-1)

    def _image(self, values: np.ndarray) -> np.ndarray:
        return values[..., : self._nodes // 2][..., ::-1]

    @staticmethod
    def _parted(values: Array) -> tuple[Array, Array]:
        kept = values.shape[-1] // 2
        return values[..., :kept], values[..., kept:]

    def _folded(self, whole: ContactSystem) -> tuple[Array, Array, Array]:
        """Stiffness of the half for slips with `v = -J v` and gaps with `w = J w`."""
        n = self._kept
        A, B, C = (M[:n, :n] + side * M[:n, ::-1][:, :n] for M, side in ((whole.A, -1), (whole.B, -1), (whole.C, 1)))
        if self._centred:
            C[-1] /= 2
            C[:, -1] /= 2
            A[-1] = A[:, -1] = 0.0
            A[-1, -1] = whole.stiffness_scale
            B[-1] /= 2
            B[:, -1] = 0.0
        return A, B, C


def mirror_half(system: ContactSystem, friction: Array) -> MirrorHalf | None:
    """Half of the contact if stiffness, gap and friction are mirror-symmetric and it has more than one node, else None."""
    return MirrorHalf(system) if system.nodes > 1 and is_mirror_symmetric(system, (), friction, EXACT) else None
