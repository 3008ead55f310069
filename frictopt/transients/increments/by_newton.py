"""One friction increment by sweeps over the nodes and Newton's method: the quick way, in the plane and in space."""

from dataclasses import replace
from functools import cached_property, partial

import numpy as np

from ...contact.checks import Array
from ...contact.tolerances import RESIDUAL, ROUNDING
from ...errors import SolverError
from ..exact.kernel import sweep
from .frozen_bound import FrozenBoundIncrement
from .increment import FrictionIncrement, Increment, Posed
from .newton import by_friction, newton

__all__ = ["NewtonIncrement"]

_SWEEPS = 100  # at most; where friction is high or most nodes slip, Newton's method goes on from where they end
_SCALES = (1.0, 10.0, 0.1, 100.0, 0.01)  # of the c and d of Newton's method, tried in this order


class NewtonIncrement(FrictionIncrement):
    """One friction increment by Newton's method on the projected law, which begins where Gauss-Seidel sweeps over the nodes end.

    The sweeps alone often reach the state to rounding. Where Newton's method does not converge, it begins without motion, other constants of the
    projection are tried, then states of less friction on the way, last a `FrozenBoundIncrement`.
    Where several states obey the law (above the critical friction) one of them is returned. Theory, eq. (4).

    Parameters
    ----------
    system
        The contact, in the plane or in space.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [0.6, 0.8, 0]})
    >>> increment = fo.increments.NewtonIncrement(node, friction=0.5)
    >>> found = increment.solve(slip=[[0.0, 0.0]], bonded=node.reaction({"P": 1.0, "Q": 2.0}))
    >>> found.slip.round(6).tolist(), found.q.round(6).tolist()
    ([[-0.9, -1.2]], [[0.3, 0.4]])
    """

    @cached_property
    def _sizes(self) -> Array:
        """(t + 1, N) stiffness of each node against itself, for its tangents the largest in any direction."""
        t, n = len(self.own) - 1, self.own.shape[1]
        blocks = self.law.S.reshape(t + 1, n, t + 1, n)[:t, np.arange(n), :t, np.arange(n)]
        tangent = np.maximum(np.linalg.eigvalsh(blocks)[:, -1], self.own[:-1].max(axis=0))
        return np.vstack([np.tile(tangent, (t, 1)), self.own[-1]])

    def _solved(self, posed: Posed) -> Increment:
        """From where sweeps end; else from no motion, by c of nodes and of directions; then from the states of less friction."""
        u, r = np.zeros_like(posed.trial), posed.trial.copy()
        sweep(self.law.S, self.law.friction, self._sizes, u, r, _SWEEPS, ROUNDING)
        start = u if np.isfinite(u).all() else np.zeros_like(u)
        found = posed.result(newton(self.law, posed.trial, start, enough=ROUNDING), "NEWTON")
        return found if found.record.residual <= RESIDUAL else self._otherwise(posed, found.record.residual)

    def _otherwise(self, posed: Posed, least: float) -> Increment:
        tangent = np.tile(self.own[:-1].mean(axis=0), (len(self.own) - 1, 1))
        laws, still = (self.law, replace(self.law, own=np.vstack([tangent, self.own[-1]]))), np.zeros_like(posed.trial)
        ways = [partial(newton, replace(law, own=scale * law.own), posed.trial, still) for law in laws for scale in _SCALES]
        for way in [*ways, *(partial(by_friction, law, posed.trial) for law in laws)]:
            found = posed.result(way(), "NEWTON")
            if found.record.residual <= RESIDUAL:
                return found
            least = min(least, found.record.residual)
        try:
            return FrozenBoundIncrement(self.system, self.friction)._solved(posed)
        except SolverError:
            raise SolverError(
                f"friction increment: Newton's method leaves a residual of {least:.1e} (tolerance {RESIDUAL:g}), and convex programs find no state "
                "either; try smaller load steps, or less friction (above the critical friction there may be no state, or several)"
            ) from None
