"""Mirror symmetry about the middle of the interface, and absence of coupling: what lets a scene be solved with less."""

from collections.abc import Iterable

import numpy as np

from .checks import Array
from .system import ContactSystem

__all__ = ["is_mirror_symmetric", "is_uncoupled"]

_NO_COUPLING = 1e-13
_ROUNDING = 1e-10  # differences below this share of the largest entry are rounding of a condensation


def is_mirror_symmetric(system: ContactSystem, reactions: Iterable[tuple[Array, Array]], friction: Array) -> bool:
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
    """
    A, B, C = system.A, system.B, system.C
    stiffness = (A, A, 1), (B, A, -1), (C, C, 1)
    if not all(_same(matrix, sign * matrix[::-1, ::-1], float(np.abs(scale).max())) for matrix, scale, sign in stiffness):
        return False
    if not (_same(friction, friction[::-1], float(friction.max())) and _same(system.gap, system.gap[::-1], float(system.gap.max()))):
        return False
    for q, p in reactions:
        scale = float(max(np.abs(q).max(), np.abs(p).max()))
        if not (_same(q, -q[..., ::-1], scale) and _same(p, p[..., ::-1], scale)):
            return False
    return True


def is_uncoupled(system: ContactSystem, friction: Array) -> bool:
    """Whether tangential motion leaves the friction bounds alone: f B is zero up to rounding, against A."""
    coupling = float(np.abs(friction[:, None] * system.B).max())
    return coupling <= _NO_COUPLING * float(np.abs(system.A).max())


def _same(one: Array, other: Array, scale: float) -> bool:
    return bool(np.abs(one - other).max() <= _ROUNDING * scale)
