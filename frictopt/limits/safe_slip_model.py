"""Safe residual slips as a model that users extend by constraints of their own."""

from __future__ import annotations

from collections.abc import Sequence

import cvxpy as cp
import numpy as np

from ..base import PerNode, progress_bar, warns_of_odd_values
from .safe_model import SafeModel, in_turn
from .safe_slip import SafeSlip, SafeSlips, checked_load_factor


class SafeSlipModel(SafeModel):
    """Safe residual slips of one system under one load cycle, for any friction.

    Each call of `solve` has its own load factor and constraints. For parameters and errors see
    `ShakedownModel`. Theory, eq. (9).

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 0.0}, {"force": 1.0}])
    >>> model = fo.SafeSlipModel(rod, cycle)
    >>> round(model.solve(0.5, load_factor=0.8).margin, 6)
    0.2
    >>> rows = [model.slip[0] - model.slip[1] <= 0.25]
    >>> round(model.solve(0.5, load_factor=0.8, constraints=rows).margin, 6)
    -0.1
    """

    _given = True
    load_factor: cp.Parameter
    """The load factor that is given, a cvxpy parameter for user constraints."""
    margin: cp.Variable
    """The margin, see `SafeSlip`, a cvxpy variable for user constraints."""

    def _complete(self) -> None:
        self.margin = cp.Variable(name="margin")
        self._x.margin = self.margin
        self._safe_slips = SafeSlips(self._solver, self._x)

    @property
    def _named(self) -> dict[cp.Variable, str]:
        return {self.margin: "margin"}

    @warns_of_odd_values
    @in_turn
    def solve(
        self,
        friction: PerNode,
        load_factor: float,
        constraints: Sequence[cp.Constraint] = (),
        *,
        events: bool = False,
        progress: bool = True,
    ) -> SafeSlip:
        """Residual slip with the largest margin, under user constraints.

        Parameters
        ----------
        friction, load_factor, events, progress
            See `safe_slip`.
        constraints
            cvxpy constraints on `slip`, `q`, `p` and `margin` of this model, see
            `ShakedownModel.solve`. `bound` and `residual` include them.

        Raises
        ------
        ModelError, SolverError
            As `ShakedownModel.solve`; a load factor so large that rounding hides the mean load;
            constraints that no slip satisfies, safe or not.
        """
        question = self._posed(friction)
        self.load_factor.value = checked_load_factor(question, load_factor)
        user = self._user(constraints)
        with progress_bar(progress, "safe slip"):
            safe = self._safe_slips.of_question(question, load_factor, user, events)
        self.margin.save_value(np.array(safe.margin))
        return self._shown(safe)
