"""The models that users extend by constraints and objectives of their own.

`SafeModel` is the base of all, with the unknowns and the checked rows of the user. `DesignModel` is
in `best_design/model.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from inspect import Signature, signature
from threading import RLock
from typing import Any, Self, TypeVar

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
from ..contact import ContactSystem, LoadCycle, checked_cycle
from ..errors import ModelError
from ..solve.problem import printed_as
from .answers.answered import Answered, Proven
from .guaranteed import GuaranteedLimit, guaranteed_limit_of, posed_guaranteed
from .printed import models
from .printed.listing import state_rows
from .printed.models import unknowns
from .printed.user_rows import UserRows, check_values, checked_objective, labelled_rows
from .program.question import Question, pose, pose_like, with_friction
from .program.rest_program import RestProgram
from .shakedown import ShakedownLimit, limit_of_question

A = TypeVar("A", bound=Answered)


class SafeModel:
    """Base of models that take constraints of the user, on unknowns in user units.

    Threads are served in turn. The unknowns hold the values of the last answer, or None if it has
    no slip. A copy is a new model with new unknowns.
    """

    # Name of the public function, which decides whether laws other than Coulomb's are allowed.
    _public_question = "this question"

    _made: Any
    __signature__: Signature
    load_factor: Any
    """The load factor, a cvxpy variable for user constraints."""
    slip: cp.Variable
    """(N,) or (N, 2) residual slip, length, a cvxpy variable for user constraints.

    Open nodes have their slip under the mean load."""
    q: cp.Expression
    """(K, N) or (K, N, 2) shear forces at the corners, force, for user constraints.

    They are 0 at open nodes."""
    p: cp.Expression
    """(K, N) normal forces at the corners, compression positive, for user constraints.

    They are 0 at open nodes."""

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        *,
        slip_bound: PerNode | None = None,
        simplify: bool = True,
        solver: str | None = None,
    ) -> None:
        question = pose(
            system,
            cycle,
            1.0,
            simplify=simplify,
            slip_bound=slip_bound,
            solver=solver,
            question_name=self._public_question,
        )
        self._question = question
        # Threads solve in turn, because they share the variables.
        self._turn = RLock()
        # The rows of the user that were compiled last.
        self._compiled: tuple[tuple[int, ...], UserRows] | None = None

        self._x = unknowns(system.slip_shape, range(len(question.r1)))
        self.load_factor = self._x.load_factor
        self.slip = self._x.slip
        self.q = printed_as(cp.stack(list(self._x.q.values()), axis=0), "q")
        self.p = printed_as(cp.stack(list(self._x.p.values()), axis=0), "p")
        self._complete()

    def _complete(self) -> None:
        """Further checks and data of a model; a subclass replaces this if it needs them."""

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._question.system!r}, {self._question.cycle!r})"

    def _posed(self, friction: Any) -> Question:
        """The question of the model with a friction, with all nodes closed."""
        return with_friction(self._question, friction)

    def __init_subclass__(cls) -> None:
        warns_of_odd_values(cls)
        # Without this, the class would have the signature of __new__.
        with_self = signature(cls.__init__)
        _, *parameters = with_self.parameters.values()
        cls.__signature__ = with_self.replace(parameters=parameters)

    def __new__(cls, *args: Any, **options: Any) -> Self:
        """Keep the arguments, from which copies are made."""
        if "friction" in options:
            raise ModelError("friction: a model has any friction; give it to `solve`")
        self = super().__new__(cls)
        self._made = partial(cls, *args, **options)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # A copy has new unknowns.
        return self._made, ()

    @property
    def _unknowns(self) -> list[cp.Variable]:
        """The unknowns that constraints of the user may contain."""
        return [self.slip, *self._x.q.values(), *self._x.p.values(), *self._named]

    @property
    def _named(self) -> dict[cp.Variable, str]:
        """The further unknowns that constraints of the user may contain, by name."""
        return {self.load_factor: "load_factor"}

    def _user(
        self,
        constraints: Any,
        objective: Any = None,
        open_slip: Callable[[RestProgram], Array] | None = None,
    ) -> UserRows | None:
        """The checked constraints and objective of the user; None if there are none."""
        given = listed("constraints", constraints)
        if not given and objective is None:
            return None
        key = *map(id, given), id(objective)
        if self._compiled is None or self._compiled[0] != key:
            rows = labelled_rows(given, self._unknowns)
            chosen = None
            if objective is not None:
                chosen = checked_objective(objective, self._unknowns)
            self._compiled = key, UserRows(rows, chosen, self._x, self._named, open_slip)
        _, user = self._compiled
        # Parameters of the user may have changed since the rows were compiled.
        for place, row in user.rows.items():
            check_values(place, row)
        if objective is not None:
            check_values("objective", objective)
        return user

    def _shown(self, answer: A) -> A:
        """An answer with the unknowns of this model, which get the values of the answer."""
        if isinstance(answer, Proven) and answer._solved is not None:
            answer = replace(answer, _solved=replace(answer._solved, unknowns=self._x))
        q, p = answer.reactions
        values: dict[cp.Variable, Any] = {self.slip: answer.slip}
        values[self.load_factor] = answer.load_factor
        for k in self._x.q:
            values[self._x.q[k]] = q[k]
            values[self._x.p[k]] = p[k]
        for variable, value in values.items():
            # cvxpy refuses nan.
            variable.save_value(np.asarray(value) if np.isfinite(value).all() else None)
        return answer


class ShakedownModel(SafeModel):
    """The shakedown limit of one system for any friction and loads, posed once.

    Theory, eq. (7).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound
        Largest slip `|v|` that assembly can leave, length, one or one per node or contact, like
        friction; None for no bound. A rigid slide of a body counts as slip. If nothing resists this
        slide, the program chooses it.
    simplify
        Whether to omit constraints that cannot change the limit: corners inside the hull of the
        other corners, and in the plane redundant constraints.
    solver
        One of "HIGHS", "CLARABEL", "HIGHS_IPM"; in space "CLARABEL_DIRECT", "CLARABEL_FINE",
        "CLARABEL", "INTERIOR_POINT". None tries each in this order until an answer passes the
        checks; for large contacts in space "INTERIOR_POINT" is first.

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
    def solve(
        self,
        friction: PerNode,
        constraints: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
        *,
        cycle: LoadCycle | None = None,
        open_nodes: ArrayLike | None = None,
        events: bool = False,
        progress: bool = True,
    ) -> ShakedownLimit:
        """The limit for given friction, optionally with your own constraints and objective.

        Parameters
        ----------
        friction, open_nodes, events, progress
            See `shakedown_limit`.
        cycle
            Another load cycle with as many corners as the load cycle of the model, for other mean
            loads or amplitudes. None: the load cycle of the model.
        constraints
            cvxpy constraints on `slip`, `load_factor`, `q` and `p` of this model, in your units,
            and on your own variables. A label (`set_label`) must differ from the labels of the rows
            of the model, such as "stuck[0]". Constraints may be linear, or use abs, max, norms and
            similar functions, which cvxpy turns into linear rows and second-order cones. Their
            multipliers contribute to the proof of the limit. `bound` and `residual` include them.
            The open nodes are the open nodes of the limit without constraints. At open nodes q and
            p are 0, and the slip is the slip under the mean load.
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
        with self._turn, progress_bar(progress, "shakedown limit"):
            user = self._user(constraints, objective)
            question = self._posed(friction) if cycle is None else self._posed_on(cycle, friction)
            return self._shown(limit_of_question(question, open_nodes, events, user))

    def _posed_on(self, cycle: LoadCycle, friction: Any) -> Question:
        """The question of the model with another load cycle."""
        first = self._question
        count = len(checked_cycle(cycle).corners)
        if count != len(first.cycle.corners):
            raise ModelError(
                f"cycle: {number_of(count, 'corner')}, the model has "
                f"{len(first.cycle.corners)}; give as many, or make a model of this load cycle"
            )
        return pose_like(first, cycle, friction, question_name=self._public_question)

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
    largest: dict[str, Any] = {"node": -1, "direction": 0}
    if limit.system.tangents > 1:
        largest = {"node": -1, "slip1": 0.0, "slip2": 0.0}
    if len(limit.mechanism):
        (largest,) = limit.mechanism[list(largest)].head(1).to_dict("records")
    return {
        "friction": float(np.mean(friction)),
        "load_factor": limit.load_factor,
        "least": limit.least,
        "bound": limit.bound,
        "residual": limit.residual,
        "friction_rate": float(limit.friction_rate.sum()),
        **largest,
        "solver": limit.record.solver,
    }


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
        As in `ShakedownModel`; in space also if the fixed parts of the load corners differ, unless
        B = 0.

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
    def solve(
        self, friction: PerNode, constraints: Sequence[cp.Constraint] = (), *, progress: bool = True
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
        with self._turn, progress_bar(progress, "guaranteed limit"):
            user = self._user(constraints)
            return self._shown(guaranteed_limit_of(self._posed(friction), user))
