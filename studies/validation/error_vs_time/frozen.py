"""Increments by direct calls of OSQP and Clarabel.

Quadratic programs with frozen friction bounds are solved until the bounds converge.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import block_array, block_diag, csc_matrix, eye_array, triu

import frictopt as fo
from studies.validation.error_vs_time.methods import installed

Array = np.ndarray[Any, Any]

_SWEEPS = 100


class FrozenBounds:
    """One increment as a quadratic program with frozen friction bounds.

    The program is `min 1/2 u' S u + trial' u + bound' t` over `u = [dv, w]` and t, with `w >= 0`
    and `|dv| <= t`.

    Parameters
    ----------
    system, friction
        The contact, in the plane, and one coefficient of friction.
    """

    def __init__(self, system: fo.ContactSystem, friction: float) -> None:
        n = system.nodes
        self._f = friction
        self._scale = system.stiffness_scale
        self._S = system.S / system.stiffness_scale
        one = eye_array(n)
        self._P = csc_matrix(triu(block_diag([self._S, csc_matrix((n, n))])))
        # The program has the constraints `rows x <= 0`.
        self._rows = csc_matrix(
            block_array([[None, -one, None], [one, None, -one], [-one, None, -one]])
        )

    def osqp(self, slip: Array, bonded: Array, tolerance: float) -> Array:
        """(N,) slip after the increment from a slip (N,) to bonded reactions (2N,), by OSQP.

        All programs share one factorisation and start warm.

        Raises
        ------
        ArithmeticError
            No optimum in 100,000 iterations, or bounds that do not converge.
        """
        none = np.zeros(len(self._rows.indptr) - 1)
        solver = installed("osqp").OSQP()
        options = {
            "eps_abs": tolerance,
            "eps_rel": tolerance,
            "max_iter": 100_000,
            "verbose": False,
        }
        solver.setup(self._P, none, self._rows, np.full(len(none), -np.inf), none, **options)

        def solved(cost: Array) -> Array:
            solver.update(q=cost)
            answer = solver.solve(raise_error=False)
            _accept(answer.info.status, "solved")
            return np.asarray(answer.x)

        return self._settled(slip, bonded, tolerance, solved)

    def clarabel(self, slip: Array, bonded: Array, tolerance: float) -> Array:
        """(N,) slip after the increment from a slip (N,) to bonded reactions (2N,), by Clarabel.

        Raises
        ------
        ArithmeticError
            No optimum, or bounds that do not converge.
        """
        package = installed("clarabel")
        none = np.zeros(len(self._rows.indptr) - 1)
        settings = package.DefaultSettings()
        settings.verbose = False
        settings.max_threads = 1
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance

        def solved(cost: Array) -> Array:
            answer = package.DefaultSolver(
                self._P, cost, self._rows, none, [package.NonnegativeConeT(len(none))], settings
            ).solve()
            _accept(str(answer.status), "Solved")
            return np.asarray(answer.x)

        return self._settled(slip, bonded, tolerance, solved)

    def _settled(
        self, slip: Array, bonded: Array, tolerance: float, solved: Callable[[Array], Array]
    ) -> Array:
        """The slip with which two consecutive bounds agree within the tolerance."""
        n = len(slip)
        force = float(np.abs(bonded[n:]).mean())
        trial = bonded / force + self._S[:, :n] @ slip * self._scale / force
        bound = self._f * np.maximum(trial[n:], 0.0)
        for _ in range(_SWEEPS):
            u = solved(np.concatenate([trial, bound]))[: 2 * n]
            new = self._f * np.maximum(trial[n:] + self._S[n:] @ u, 0.0)
            if np.abs(new - bound).max() <= tolerance:
                return slip + u[:n] * force / self._scale
            bound = new
        raise ArithmeticError(f"bounds do not settle in {_SWEEPS} sweeps")


def _accept(status: str, solved: str) -> None:
    """Raise ArithmeticError if the status is not `solved`."""
    if status != solved:
        raise ArithmeticError(f"no optimum ({status})")
