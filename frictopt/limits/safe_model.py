"""What the models of safe slips have in common: the unknowns to extend them by, and the programs that they compile."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, wraps
from inspect import Signature, signature
from threading import RLock
from typing import Any, Self, TypeVar, cast

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..base import Array, shown, warns_of_odd_values
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError
from ..solve.solvers import LP, SOCP, solver_order
from .answered import Answered
from .models import Row, constant, defines, printed_as, unknowns, vec
from .programs import Program, check_rows, check_values, listed_rows, own_rows
from .question import Question, motion_of_open_nodes, pose

A = TypeVar("A", bound=Answered)
F = TypeVar("F", bound=Callable[..., Any])


def in_turn(question: F) -> F:
    """A question of a model that threads ask one after the other, for its program has parameters and variables."""

    @wraps(question)
    def asked(self: SafeModel, *args: Any, **kwargs: Any) -> Any:
        with self._turn:
            return question(self, *args, **kwargs)

    return cast(F, asked)


class SafeModel:
    """Base of models that take constraints of the user's own: what they decide on, in the user's units.

    Threads ask in turn. The unknowns hold the last answer, None where that has no slip. A copy is a
    new model, with unknowns of its own.
    """

    _given = False  # whether the load factor is
    _strong = False  # whether its questions know the shear strength of a surface
    _made: Any
    __signature__: Signature
    load_factor: Any
    """The load factor, a cvxpy variable for constraints of your own."""
    slip: cp.Variable
    """(N,) or (N, 2) residual slip, length, a cvxpy variable for constraints of your own; of open nodes the one under the mean load."""
    q: cp.Expression
    """(K, N) or (K, N, 2) shear forces at the corners of the cycle, force, for constraints of your own; 0 at open nodes."""
    p: cp.Expression
    """(K, N) normal forces at the corners, compression positive, force, for constraints of your own; 0 at open nodes."""

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        *,
        slip_bound: ArrayLike | None = None,
        simplify: bool = True,
        solver: str | None = None,
    ) -> None:
        self._asked = pose(
            system, cycle, 1.0, simplify=simplify, slip_bound=slip_bound, strong=self._strong
        )
        self._solver = solver
        self._posed = partial(
            pose,
            system,
            cycle,
            simplify=simplify,
            slip_bound=self._asked.slip_bound,
            strong=self._strong,
        )  # by its friction
        self._turn = RLock()
        solver_order(solver, LP if system.tangents == 1 else SOCP)
        given = cp.Parameter(nonneg=True, name="load_factor") if self._given else None
        self._x = unknowns(system.slip_shape, range(len(cycle.corners)), given)
        self._f = cp.Parameter(system.nodes, nonneg=True, name="f")
        self.load_factor, self.slip = self._x.load_factor, self._x.slip
        q, p = list(self._x.q.values()), list(self._x.p.values())
        self.q, self.p = (
            printed_as(cp.vstack(q) if system.tangents == 1 else cp.stack(q, axis=0), "q"),
            printed_as(cp.vstack(p), "p"),
        )
        self._programs: dict[object, Any] = {}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(map(repr, self._posed.args))})"

    def __init_subclass__(cls) -> None:
        warns_of_odd_values(cls)
        cls.__signature__ = (asked := signature(cls.__init__)).replace(
            parameters=[*asked.parameters.values()][1:]
        )  # else it is that of __new__

    def __new__(cls, *args: Any, **options: Any) -> Self:
        """Keep what it is made of, for its copies."""
        self = super().__new__(cls)
        self._made = partial(cls, *args, **options)
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return self._made, ()  # a copy has unknowns of its own

    @property
    def _unknowns(self) -> list[cp.Variable]:
        """Those that the user's constraints may be on."""
        return [self.slip, *self._x.q.values(), *self._x.p.values()] + (
            [] if self._given else [self.load_factor]
        )

    def _program(
        self,
        question: Question,
        own: Sequence[Any],
        objective: Any,
        goal: Callable[[Program], cp.Problem],
        name: str,
        unit: float,
        **listing: Any,
    ) -> Program:
        """The program of a goal, maybe with constraints and an objective of the user's own; compiled once for all frictions."""
        key = name, question.open_nodes.tobytes(), objective is None, *map(id, own), id(objective)
        if key not in self._programs:
            more = bool(own) or objective is not None
            listed = listed_rows(question, self._x, self._f, every=more, **listing)
            listed.own = own_rows(own, self._unknowns)
            if more and question.compliance is not None:
                listed.rows += self._rested(question)
            problem = goal(listed)
            if objective is not None:
                problem = cp.Problem(
                    cp.Maximize(checked_objective(objective, self._unknowns)), problem.constraints
                )
            for old in list(self._programs)[
                :-1
            ]:  # two at a time, with own rows and without: each has dense matrices
                del self._programs[old]
            self._programs[key] = listed.compiled(problem, unit)
        program: Program = self._programs[key]
        for place, part in (
            *program.own.items(),
            *[("objective", objective)] * (objective is not None),
        ):
            check_values(place, part)  # which may be others than when it was compiled
        program.ask(question, unit)
        return program

    def _rested(self, question: Question, more: Any = 0) -> list[Row]:
        """Rows by which the slip of open nodes is the one under the mean load, for the user's own rows; `more` is what unknown loads add to it."""
        t = question.system.tangents * question.system.nodes
        out = np.tile(question.open_nodes, question.system.tangents)
        still = question.slip_at_mean_load(np.zeros(question.system.slip_shape)).T.ravel()[out]
        moved, chosen, slip = (
            cp.Variable(len(still), name="v_r"),
            constant(np.eye(t)[out], "open"),
            vec(self.slip),
        )
        follows = chosen @ slip == constant(still, "v0") + moved + more
        follows_slip = motion_of_open_nodes(
            question.system, question.open_nodes, question.compliance, np.flatnonzero(out)
        )
        return [defines(moved, constant(follows_slip, "V") @ slip), follows.set_label("open")]

    def _shown(self, answer: A, **more: Array | float) -> A:
        """An answer, whose values stand in the user's unknowns from now on."""
        q, p = answer.reactions
        values = {
            self.slip: answer.slip,
            **{self._x.q[k]: q[k] for k in self._x.q},
            **{self._x.p[k]: p[k] for k in self._x.p},
        }
        for variable, value in {**values, self.load_factor: answer.load_factor}.items():
            variable.save_value(
                np.asarray(value) if np.isfinite(value).all() else None
            )  # cvxpy refuses nan
        return answer


def checked_objective(objective: Any, known: Sequence[cp.Variable]) -> cp.Expression:
    """An objective of the user's own, to be largest."""
    if not isinstance(objective, cp.Expression) or objective.size != 1:
        raise ModelError(
            f"objective: {shown(objective)}; give a scalar cvxpy expression to be largest, of slip, load_factor, q and p"
        )
    check_rows("objective", cp.Variable() <= objective, {variable.id for variable in known})
    return cp.reshape(objective, (), order="C")
