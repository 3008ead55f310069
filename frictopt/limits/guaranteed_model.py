"""The guaranteed limit as a model that users extend by constraints of their own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cvxpy as cp

from ..base import progress_bar, warns_of_odd_values
from .guaranteed import GuaranteedLimit, GuaranteedLimits, posed_guaranteed
from .safe_model import SafeModel, in_turn


class GuaranteedModel(SafeModel):
    """Guaranteed limit of one system under one load cycle, for any friction. Theory, eq. (10).

    Parameters
    ----------
    system, cycle, slip_bound, solver
        See `ShakedownModel`.
    simplify
        Whether to skip nodes that cannot change the answer: nodes whose lower bound is above the
        least load factor found so far, and all nodes if B = 0 (then lambda_1 = lambda_2 by a
        theorem).

    Raises
    ------
    ModelError
        As in `ShakedownModel`; also if the fixed parts of the load corners differ, in space.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> A, B, C = [[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]]
    >>> system = fo.ContactSystem.from_blocks(A, B, C, [0, 1], loads)
    >>> model = fo.GuaranteedModel(system, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]))
    >>> [round(model.solve(friction).load_factor, 6) for friction in (0.3, 0.5)]
    [0.283333, 0.45]
    >>> round(model.solve(0.5, constraints=[model.slip[1] >= 0.1]).load_factor, 6)
    0.525
    """

    def _complete(self) -> None:
        posed_guaranteed(self._question)

    @warns_of_odd_values
    @in_turn
    def solve(
        self, friction: Any, constraints: Sequence[cp.Constraint] = (), *, progress: bool = True
    ) -> GuaranteedLimit:
        """The limit for given friction, one or one per node, with or without your own constraints.

        Parameters
        ----------
        friction, constraints
            As in `ShakedownModel.solve`. Constraints apply to the witness and to the safe slips of
            lambda_2, as a slip bound does. The limit is the least load factor at which some slip
            satisfies them and makes a node critical. `residual` includes the violation of the
            constraints.
        progress
            See `guaranteed_limit`.

        Raises
        ------
        ModelError, SolverError
            Bad friction or constraints; no solver gave an answer that passes the checks.
        """
        with progress_bar(progress, "guaranteed limit"):
            limits = GuaranteedLimits(self._solver, self._x)
            return self._shown(limits.of_any_set(self._posed(friction), self._user(constraints)))
