"""The shakedown limit as a model that users extend by constraints and objectives of their own."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    Array,
    PerNode,
    Table,
    frame,
    listed,
    number_of,
    progress_bar,
    warns_of_odd_values,
)
from ..contact import LoadCycle, checked_cycle
from ..errors import ModelError
from . import models
from .listing import state_rows
from .question import Question, pose
from .safe_model import SafeModel, in_turn
from .shakedown import ShakedownLimit, ShakedownLimits


class ShakedownModel(SafeModel):
    """The shakedown limit of one system for any friction and loads, compiled once.

    Theory, eq. (7).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound
        Largest slip `|v|` that assembly can leave, length, one or one per node or contact, as
        friction; None for no bound.
        A rigid slide of a body counts as slip. If nothing resists it, the program chooses it.
    simplify
        Whether to omit constraints that cannot change the limit: corners inside the hull of the
        other corners, and in the plane redundant constraints.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM"; in space "CLARABEL_DIRECT", "CLARABEL",
        "INTERIOR_POINT". None tries each in this order until an answer passes the checks; for large
        contacts in space "INTERIOR_POINT" is first.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options, a negative slip bound.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> A, B, C = [[2, -1], [-1, 2]], [[0, 0.5], [-0.5, 0]], [[2, 0], [0, 2]]
    >>> system = fo.ContactSystem.from_blocks(A, B, C, [0, 1], loads)
    >>> model = fo.ShakedownModel(system, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]))
    >>> model.sweep([0.3, 0.5])["load_factor"].round(6).tolist()
    [0.313636, 0.535714]
    >>> round(model.solve(0.5, constraints=[model.slip[0] >= 0.1]).load_factor, 6)
    0.502381
    >>> pressed_more = fo.LoadCycle({"P": 2.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> round(model.solve(0.5, cycle=pressed_more).load_factor, 6)
    1.071429
    """

    _public_question = "shakedown_limit"

    @cached_property
    def f(self) -> cp.Parameter:
        """(N,) friction in `problem`: give it a value before you solve."""
        return cp.Parameter(self._question.system.nodes, nonneg=True, name="f")

    @property
    def loads(self) -> dict[str, Array]:
        """Bonded reactions in `problem` by name, `q0`, `p0`, `q1[k]` and `p1[k]`, force."""
        corners = range(len(self._question.r1))
        return {name: r for k in corners for name, r in self._question.loads(k).items() if r.size}

    @cached_property
    def problem(self) -> cp.Problem:
        """The limit with all nodes closed, a cvxpy problem in the variables of this model."""
        rows = state_rows(self._question, self._x, self.f, [*self._x.q])
        return models.shakedown(self._x, rows)

    @warns_of_odd_values
    @in_turn
    def solve(
        self,
        friction: PerNode,
        constraints: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
        *,
        cycle: LoadCycle | None = None,
        open: ArrayLike | None = None,
        events: bool = False,
        progress: bool = True,
    ) -> ShakedownLimit:
        """The limit for given friction, optionally with your own constraints and objective.

        Parameters
        ----------
        friction, open, events, progress
            See `shakedown_limit`.
        cycle
            Another load cycle with as many corners as the load cycle of the model, for other mean
            loads or amplitudes. None: the load cycle of the model.
        constraints
            cvxpy constraints on `slip`, `load_factor`, `q` and `p` of this model, in your units,
            and on your own variables. A label (`set_label`) must not be that of a row of the model,
            such as "stuck[0]". They may be linear, or use abs, max, norms and similar
            functions, which cvxpy turns into linear rows and second-order cones. Their multipliers
            contribute to the proof of the limit. `bound` and `residual` include them. The open
            nodes are the open nodes of the limit without constraints. At open nodes q and p are 0,
            and the slip is the slip under the mean load.
        objective
            Scalar to maximize over the safe slips, instead of the load factor: a concave cvxpy
            expression of the same variables and functions, such as `model.load_factor - 0.1 *
            cp.norm1(model.slip)`. See `ShakedownLimit.objective`.

        Raises
        ------
        ModelError, SolverError
            Bad friction; a load cycle with another number of corners; open nodes that the closed
            nodes do not hold; constraints or an objective that are not convex, need other cones, or
            belong to another model; an objective without a largest value; no solver gave an answer
            that passes the checks.
        """
        user = self._user(constraints, objective)
        with progress_bar(progress, "shakedown limit"):
            question = self._posed(friction) if cycle is None else self._posed_on(cycle, friction)
            limits = ShakedownLimits(self._solver, self._x)
            return self._shown(limits.of_question(question, open, events, user))

    def _posed_on(self, cycle: LoadCycle, friction: Any) -> Question:
        """The question of the model with another load cycle."""
        first = self._question
        count = len(checked_cycle(cycle).corners)
        if count != len(first.cycle.corners):
            raise ModelError(
                f"cycle: {number_of(count, 'corner')}, the model has "
                f"{len(first.cycle.corners)}; give as many, or make a model of this load cycle"
            )
        return pose(
            first.system,
            cycle,
            friction,
            simplify=first.simplify,
            slip_bound=first.slip_bound,
            question_name=self._public_question,
        )

    @warns_of_odd_values
    def sweep(
        self, frictions: Any, constraints: Sequence[cp.Constraint] = (), *, progress: bool = True
    ) -> Table:
        """The limit for many coefficients of friction (each one number or (N,)), one row each.

        Columns: friction (mean), load_factor, least, bound, residual, friction_rate, node and sense
        of the mechanism's largest share, solver. User constraints as in `solve`. Errors are as for
        `solve`; also ModelError if `frictions` is not a sequence. Ctrl-C raises KeyboardInterrupt
        with an attribute `table`, which has the limits so far.
        """
        wanted = listed("frictions", frictions)
        rows = list[dict[str, Any]]()

        total = len(wanted)
        with progress_bar(progress, "sweep", "friction", total=total) as bar:
            for friction in wanted:
                rows.append(_row(friction, self.solve(friction, constraints)))
                note = (
                    f"the limits of {len(rows)} of {total} frictions are in the attribute `table`"
                )
                bar.keep("table", partial(frame, rows), note)
                bar.update()
        return frame(rows)


def _row(friction: Any, limit: ShakedownLimit) -> dict[str, Any]:
    """The row of a friction in the table of a sweep."""
    plane = limit.system.tangents == 1
    if len(limit.mechanism):
        first = limit.mechanism.iloc[0].to_dict()
    elif plane:
        first = {"node": -1, "direction": 0}
    else:
        first = {"node": -1, "slip1": 0.0, "slip2": 0.0}
    row = {
        "friction": float(np.mean(friction)),
        "load_factor": limit.load_factor,
        "least": limit.least,
        "bound": limit.bound,
        "residual": limit.residual,
        "friction_rate": float(limit.friction_rate.sum()),
        "node": int(first["node"]),
    }
    for sense in ("direction",) if plane else ("slip1", "slip2"):
        row[sense] = first[sense]
    return row | {"solver": limit.record.solver}
