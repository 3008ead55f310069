"""The models that users extend: their unknowns, and the programs that they compile."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, wraps
from inspect import Signature, signature
from threading import RLock
from typing import Any, Self, TypeVar, cast

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..base import shown, warns_of_odd_values
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError
from ..solve.solvers import LP, SOCP, solver_order
from .answered import Answered
from .load_parameters import LoadParameters
from .models import Row, constant, defines, printed_as, unknowns, vec
from .programs import (
    Program,
    check_rows,
    check_values,
    labelled_rows,
    listed_corners,
    listed_rows,
)
from .question import Question, motion_of_open_nodes, pose, with_friction

A = TypeVar("A", bound=Answered)
F = TypeVar("F", bound=Callable[..., Any])


def in_turn(question: F) -> F:
    """Decorator: threads call a method of a model in turn, because they share its variables."""

    @wraps(question)
    def in_its_turn(self: SafeModel, *args: Any, **kwargs: Any) -> Any:
        with self._turn:
            return question(self, *args, **kwargs)

    return cast(F, in_its_turn)


class SafeModel:
    """Base of models that take constraints of the user, on unknowns in user units.

    Threads are served in turn. The unknowns hold the values of the last answer, or None if it has
    no slip. A copy is a new model with new unknowns.
    """

    # Whether the load factor is given.
    _given = False
    # Whether a program serves all load cycles with the same number of corners.
    _any_cycle = False
    # Name of the public question, which may know laws other than Coulomb's.
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
        slip_bound: ArrayLike | None = None,
        simplify: bool = True,
        solver: str | None = None,
    ) -> None:
        question = pose(
            system,
            cycle,
            1.0,
            simplify=simplify,
            slip_bound=slip_bound,
            question_name=self._public_question,
        )
        self._begin(question, solver)

    @classmethod
    def _on(cls, question: Question, solver: str | None) -> Self:
        """An internal model, on a question that is posed already."""
        self = object.__new__(cls)
        self._begin(question, solver)
        return self

    def _begin(self, question: Question, solver: str | None) -> None:
        """Make the unknowns of the model; it has no programs yet."""
        system = question.system
        plane = system.tangents == 1
        solver_order(solver, LP if plane else SOCP)
        self._question = question
        self._solver = solver
        self._turn = RLock()
        self._programs: dict[tuple[Any, ...], Any] = {}

        load_factor = cp.Parameter(nonneg=True, name="load_factor") if self._given else None
        self._x = unknowns(system.slip_shape, range(len(question.r1)), load_factor)
        self._f = cp.Parameter(system.nodes, nonneg=True, name="f")
        self.load_factor = self._x.load_factor
        self.slip = self._x.slip
        q = list(self._x.q.values())
        self.q = printed_as(cp.vstack(q) if plane else cp.stack(q, axis=0), "q")
        self.p = printed_as(cp.vstack(list(self._x.p.values())), "p")

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._question.system!r}, {self._question.cycle!r})"

    def _posed(self, friction: Any) -> Question:
        """The question of the model with a friction, with all nodes closed."""
        return with_friction(self._question, friction)

    def __init_subclass__(cls) -> None:
        warns_of_odd_values(cls)
        # Without this, the signature of the class would be that of __new__.
        with_self = signature(cls.__init__)
        _, *parameters = with_self.parameters.values()
        cls.__signature__ = with_self.replace(parameters=parameters)

    def __new__(cls, *args: Any, **options: Any) -> Self:
        """Keep the arguments, from which copies are made."""
        self = super().__new__(cls)
        self._made = partial(cls, *args, **options)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        # A copy has new unknowns.
        return self._made, ()

    @property
    def _unknowns(self) -> list[cp.Variable]:
        """The unknowns that constraints of the user may contain."""
        on_corners = [*self._x.q.values(), *self._x.p.values()]
        load_factor = [] if self._given else [self.load_factor]
        return [self.slip, *on_corners, *load_factor]

    def _program(
        self,
        question: Question,
        user_rows: Sequence[Any],
        objective: Any,
        goal: Callable[[Program], cp.Problem],
        name: str,
        unit: float,
        **listing: Any,
    ) -> Program:
        """The program of a goal, compiled once for all frictions, and perhaps for all load cycles.

        `user_rows` and `objective` are constraints and an objective of the user. `listing`: options
        of `listed_rows`.
        """
        extended = bool(user_rows) or objective is not None
        open_nodes = question.open_nodes.tobytes()
        kind = extended, bool(question.open_nodes.any())
        corners = question.fixed, *listed_corners(question)
        key = kind, name, open_nodes, corners, *map(id, user_rows), id(objective)
        if extended and question.open_nodes.any():
            # Rows of the user may contain the slip of open nodes, which depends on the mean load.
            key = *key, id(question.cycle)
        if key not in self._programs:
            loads = LoadParameters(question) if self._any_cycle else None
            listed = listed_rows(question, self._x, self._f, every=extended, loads=loads, **listing)
            listed.user_rows = labelled_rows(user_rows, self._unknowns)
            if extended and question.compliance is not None:
                listed.rows += self._rest_rows(question)
            problem = goal(listed)
            if objective is not None:
                chosen = checked_objective(objective, self._unknowns)
                problem = cp.Problem(cp.Maximize(chosen), problem.constraints)
            # Dense matrices are large, so one program of each kind is kept: with and without user
            # rows, with and without open nodes. A search of open nodes leaves the closed contact's.
            for old in [other for other in self._programs if other[0] == kind]:
                del self._programs[old]
            self._programs[key] = listed.compiled(problem, unit)
        program: Program = self._programs[key]

        # Parameters of the user may have changed since the program was compiled.
        for place, row in program.user_rows.items():
            check_values(place, row)
        if objective is not None:
            check_values("objective", objective)
        program.set_question(question, unit)
        return program

    def _rest_rows(self, question: Question, more: Any = 0) -> list[Row]:
        """Rows that set the slip of open nodes to their slip under the mean load.

        User rows may contain this slip. It is `v0 + V slip`: the slip without slip of the closed
        nodes, and the part that follows them. `more`: terms due to unknown loads.
        """
        system = question.system
        opened = np.tile(question.open_nodes, system.tangents)  # (t N,)
        v0 = question.slip_at_mean_load(np.zeros(system.slip_shape)).T.ravel()[opened]
        V = motion_of_open_nodes(
            system, question.open_nodes, question.compliance, np.flatnonzero(opened)
        )
        slip = vec(self.slip)
        v_r = cp.Variable(len(v0), name="v_r")
        chosen = constant(np.eye(len(opened))[opened], "open")
        follows = chosen @ slip == constant(v0, "v0") + v_r + more
        return [defines(v_r, constant(V, "V") @ slip), follows.set_label("open")]

    def _shown(self, answer: A) -> A:
        """An answer, after its values are put into the unknowns of the user."""
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


def checked_objective(objective: Any, known: Sequence[cp.Variable]) -> cp.Expression:
    """An objective of the user, to be maximized; ModelError for a bad one."""
    if not isinstance(objective, cp.Expression) or objective.size != 1:
        raise ModelError(
            f"objective: {shown(objective)}; give a scalar cvxpy expression of slip, load_factor, "
            "q and p, which is maximized"
        )
    check_rows("objective", cp.Variable() <= objective, {variable.id for variable in known})
    return cp.reshape(objective, (), order="C")
