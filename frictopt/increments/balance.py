"""Whether any reactions that friction can bear balance a load: what a body that is free to move needs before any question of elasticity."""

from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from ..solve.solvers import solve

__all__ = ["shortfall"]


@dataclass(frozen=True)
class _Claim:
    """A shortfall and how far the reactions that show it are from admissible."""

    shortfall: float
    residual: float


class _BalanceProblem:
    """Reactions `p >= 0, |q| <= f p` whose resultants on the rigid motions come nearest to those of the load."""

    def __init__(self, rigid: Array, trial: Array, friction: Array) -> None:
        self._rigid, self._trial, self._friction = rigid, trial, friction
        n = len(friction)
        reaction, off = cp.Variable(2 * n, name="reaction"), cp.Variable(nonneg=True, name="shortfall")
        q, p = reaction[:n], reaction[n:]
        rows = {
            "no_tension": p >= 0,
            "friction": cp.abs(q) <= cp.multiply(friction, p),
            "resultants": cp.abs(rigid.T @ (reaction - trial)) <= off,
        }
        self.problem = cp.Problem(cp.Minimize(off), [row.set_label(name) for name, row in rows.items()])

    def refine(self) -> None:
        """Nothing: a shortfall is compared with a margin far above any solver's tolerance."""

    def claim(self) -> _Claim:
        """Judge the reactions that stand in the variables."""
        q, p = np.split(np.asarray(self.problem.var_dict["reaction"].value), 2)
        violation = float(max((-p).max(), (np.abs(q) - self._friction * p).max()))
        return _Claim(float(np.abs(self._rigid.T @ (np.r_[q, p] - self._trial)).max()), violation)


def shortfall(rigid: Array, trial: Array, friction: Array) -> float:
    """Least resultant of a load, in the unit of `trial`, that no admissible reactions balance; 0 if some balance all of it.

    Parameters
    ----------
    rigid
        (2N, k) rigid motions `[v, w]`.
    trial
        (2N,) reactions `[q, p]` in equilibrium with the load.
    friction
        (N,) coefficients of friction.
    """
    if rigid.shape[1] == 0:
        return 0.0
    model = _BalanceProblem(rigid, trial, friction)
    return solve(model, model.claim).claim.shortfall
