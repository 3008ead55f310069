"""Increments by Lemke's method (quantecon), in the stiffness form of the complementarity problem."""

from itertools import pairwise
from typing import Any

import numpy as np

import frictopt as fo
from studies.validation.error_vs_time.methods import installed

Array = np.ndarray[Any, Any]

# Largest violation of the complementarity problem of an accepted increment.
_ACCEPTED = 1e-9


class Lemke:
    """Increments by Lemke's method, from a state with all nodes closed.

    The unknowns are `z = (w, s+, s-) >= 0` with `dv = s+ - s-`.

    Parameters
    ----------
    system, friction
        The contact, and one coefficient of friction.
    force
        Force scale, force per depth.
    """

    def __init__(self, system: fo.ContactSystem, friction: float, force: float) -> None:
        self._solve = installed("quantecon").lcp_lemke
        self._S = system.S
        self._n = system.nodes
        self._f = friction
        self._force = force
        self._length = force / system.stiffness_scale
        A, B, C, f = system.A, system.B, system.C, friction
        plus = A + f * B
        minus = A - f * B
        self._M = (
            np.block([[C, B, -B], [f * C + B.T, plus, -plus], [f * C - B.T, -minus, minus]])
            / system.stiffness_scale
        )

    def increment(self, v: Array, bonded: Array) -> tuple[Array, Array]:
        """(N,) slip and pressure after the increment from the slip v to bonded reactions (2N,).

        Raises
        ------
        ArithmeticError
            The answer does not solve the problem.
        """
        n, f = self._n, self._f
        r = bonded + self._S[:, :n] @ v
        c = np.concatenate([r[n:], f * r[n:] + r[:n], f * r[n:] - r[:n]]) / self._force
        z = self._solve(self._M, c, max_iter=10**5).z
        violation = -min((self._M @ z + c).min(), z.min())
        if not violation <= _ACCEPTED:
            raise ArithmeticError(f"Lemke's method violates the problem by {violation:.1e}")
        slip = (z[n : 2 * n] - z[2 * n :]) * self._length
        pressure = r[n:] + self._S[n:, :n] @ slip + self._S[n:, n:] @ z[:n] * self._length
        return v + slip, pressure

    def cycle_work(self, start: Array, loads: list[Array], steps: int, corners: int) -> float:
        """Work of friction in the last `corners` segments of a load path through loads (2N,).

        Each segment has `steps` increments. The friction force of an increment follows from the
        mean of its two pressures. The load path begins with the slip `start` (N,).
        """
        v = start
        p = loads[0][self._n :] + self._S[self._n :, : self._n] @ start
        total = 0.0
        for number, (before, after) in enumerate(pairwise(loads)):
            for step in range(1, steps + 1):
                new, pressure = self.increment(v, before + step / steps * (after - before))
                if number >= len(loads) - 1 - corners:
                    total += float(self._f * np.abs(new - v) @ (p + pressure) / 2)
                v, p = new, pressure
        return total
