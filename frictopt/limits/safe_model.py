"""The models that users extend: their unknowns, and the checked rows of the user."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, wraps
from inspect import Signature, signature
from threading import RLock
from typing import Any, Self, TypeVar, cast

import cvxpy as cp
import numpy as np

from ..base import Array, PerNode, listed, warns_of_odd_values
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError
from ..solve.problem import printed_as
from ..solve.solvers import LP, SOCP, solver_order
from .answered import Answered
from .models import unknowns
from .question import Question, pose, with_friction
from .rest_program import RestProgram
from .user_checks import check_values, checked_objective, labelled_rows
from .user_rows import UserRows

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
            question_name=self._public_question,
        )
        plane = system.tangents == 1
        solver_order(solver, LP if plane else SOCP)
        self._question = question
        self._solver = solver
        self._turn = RLock()
        # The rows of the user that were compiled last.
        self._compiled: tuple[tuple[int, ...], UserRows] | None = None

        load_factor = cp.Parameter(nonneg=True, name="load_factor") if self._given else None
        self._x = unknowns(system.slip_shape, range(len(question.r1)), load_factor)
        self.load_factor = self._x.load_factor
        self.slip = self._x.slip
        q = list(self._x.q.values())
        self.q = printed_as(cp.vstack(q) if plane else cp.stack(q, axis=0), "q")
        self.p = printed_as(cp.vstack(list(self._x.p.values())), "p")
        self._complete()

    def _complete(self) -> None:
        """Check the question further, or add unknowns; a model replaces this if it needs either."""

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
        return {} if self._given else {self.load_factor: "load_factor"}

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
