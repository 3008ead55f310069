"""Half of a mirror-symmetric contact, followed in place of the whole for as long as the path is proven to keep the symmetry."""

from collections.abc import Callable

import numpy as np
from numba import njit

from ..contact.checks import Array
from ..contact.mirror import EXACT, EXACT_LOAD, MirrorHalf
from .active import OPEN, new_active_set
from .proof import clear_proof, new_proof
from .segment import DONE, FULL, Record, follow, new_record
from .settle import State, refresh, turn

__all__ = ["Halved"]


class Halved:
    """The half that is followed, with its working memory.

    Parameters
    ----------
    half
        Half of the contact.
    friction
        (N,) symmetric coefficients of friction of the whole.
    force
        Scale of the nodal forces.
    rows
        Events that its record holds, 0 for none.
    """

    def __init__(self, half: MirrorHalf, friction: Array, force: float, rows: int) -> None:
        self.half, self._friction, self._force = half, half.nodal(friction).copy(), force
        self._gap = half.system.gap.copy()
        self._S = np.ascontiguousarray(half.system.S)
        self._active, self._proof, self.record = new_active_set(half.nodes), new_proof(half.nodes, 2), new_record(rows, half.nodes)

    def fits(self, state: State, drive: Array, bonded: Array) -> bool:
        """Whether the whole, and its load all the way to `bonded`, are mirror-symmetric: a load that nothing has slipped under yet leaves no slip."""
        opened = state.status == OPEN
        loaded = _is_symmetric(drive, EXACT_LOAD) and _is_symmetric(bonded, EXACT_LOAD)
        return bool(loaded and _is_symmetric(state.u, EXACT) and (opened == opened[::-1]).all())

    def go(self, state: State, drive: Array, bonded: Array, settled: bool, keep: Callable[[Record, MirrorHalf], None]) -> tuple[bool, float]:
        """Follow the half while the bonded reactions of the whole change by `drive`; the state of the whole is changed in place.

        Returns whether it came to the end, to `bonded`, and how far.
        """
        half, S, f, n = self.half, self._S, self._friction, self.half.nodes
        u, r, own_drive, own_bonded = np.empty((4, 2 * n))
        _fold(state.u, 1.0, u)
        for whole, own in ((state.r, r), (drive, own_drive), (bonded, own_bonded)):
            _fold(whole, 0.5, own)
        own_state = State(u, r, self._gap, state.status[:n].copy(), state.work[:n].copy(), state.trace)
        turn(S, f, own_state, self._active)
        clear_proof(self._proof)
        code, time = FULL, 0.0
        while code == FULL:
            code, time = follow(S, half.other, f, own_drive, own_state, self._active, self._proof, self._force, time, settled, self.record)
            settled = True
            keep(self.record, half)
        if code == DONE:
            refresh(S, f, own_bonded, own_state, self._active)
        _unfold(u, 1.0, state.u)
        _unfold(r, 2.0, state.r)
        state.status[:], state.work[:] = half.whole_status(own_state.status), half.whole_even(own_state.work)
        return code == DONE, time


@njit(cache=True)
def _is_symmetric(values, rounding):
    nodes = len(values) // 2
    least = rounding * np.abs(values).max()
    for i in range((nodes + 1) // 2):
        j = nodes - 1 - i
        if abs(values[i] + values[j]) > least or abs(values[nodes + i] - values[nodes + j]) > least:
            return False
    return True


@njit(cache=True)
def _fold(whole, share, half):
    """Odd part of the first half of `whole`, (2N,), and even part of the second; of the latter only a share at a middle node."""
    nodes, kept = len(whole) // 2, len(half) // 2
    for i in range(kept):
        j = nodes - 1 - i
        half[i] = (whole[i] - whole[j]) / 2
        half[kept + i] = (whole[nodes + i] + whole[nodes + j]) / 2
    if nodes % 2 == 1:
        half[-1] *= share


@njit(cache=True)
def _unfold(half, factor, whole):
    nodes, kept = len(whole) // 2, len(half) // 2
    for i in range(kept):
        j = nodes - 1 - i
        whole[j], whole[nodes + j] = -half[i], half[kept + i]
        whole[i], whole[nodes + i] = half[i], half[kept + i]
    if nodes % 2 == 1:
        whole[nodes + kept - 1] *= factor
