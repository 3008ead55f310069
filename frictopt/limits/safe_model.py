"""What the models of safe slips have in common: the expressions to extend them by, and the programs that they compile."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, TypeVar

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..solve.solvers import LP, SOCP, solver_order
from .answered import Answered
from .circles import Circles
from .design_loads import DesignLoads
from .intervals import Intervals
from .own_rows import OwnRows, extended, unknown
from .question import LimitQuestion, pose
from .reduced import on_all_nodes
from .safe_set import SafeSet

A = TypeVar("A", bound=Answered)


class SafeModel:
    """Base of models that take constraints of the user's own: what they decide on, in the user's units."""

    _design: DesignLoads | None = None

    def __init__(
        self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: ArrayLike | None = None, simplify: bool = True, solver: str | None = None
    ) -> None:
        self._asked, self._solver = pose(system, cycle, 1.0, simplify=simplify, slip_bound=slip_bound), solver
        solver_order(solver, LP if system.tangents == 1 else SOCP)
        self._load = cp.Parameter(nonneg=True, name="load_unit")  # or the load factor, where it is given
        self._sets: dict[bytes, SafeSet] = {}  # by the mirror planes: of the whole contact, and of its parts
        self._compiled: dict[tuple[bytes, bool], tuple[list[object], cp.Problem | None, OwnRows | None]] = {}  # by what friction can change

    def _set(self, task: LimitQuestion) -> SafeSet:
        if task.lift is not None:
            return safe_set(task, self._design)
        key = _planes(task)
        if key not in self._sets:
            self._sets[key] = safe_set(task, self._design)
        return self._sets[key]

    @cached_property
    def _v(self) -> SafeSet:
        return self._set(self._asked)

    @cached_property
    def load_factor(self) -> cp.Expression:
        """The load factor, a cvxpy variable for constraints of your own."""
        return unknown("load_factor")

    @cached_property
    def slip(self) -> cp.Expression:
        """(N,) or (N, 2) residual slip, length, a cvxpy variable for constraints of your own; of open nodes the one under the mean load."""
        return unknown("slip", self._asked.system.slip_shape)

    @cached_property
    def q(self) -> cp.Expression:
        """(K, N) or (K, N, 2) shear forces at the corners of the cycle, force, a cvxpy variable for constraints of your own; 0 at open nodes."""
        return unknown("q", self._asked.q1.shape)

    @cached_property
    def p(self) -> cp.Expression:
        """(K, N) normal forces at the corners, compression positive, force, a cvxpy variable for constraints of your own; 0 at open nodes."""
        return unknown("p", self._asked.p1.shape)

    def _factor(self, v: SafeSet) -> cp.Expression:
        """The load factor in a program."""
        return self._load * v.load_factor

    def _meant(self, v: SafeSet) -> dict[cp.Variable, cp.Expression]:
        """What the unknowns of the user's rows are in a program, in the user's units, on all nodes."""
        task, lam, shape = v.task, self._factor(v), self._asked.system.slip_shape
        slip, shear, pressed = v.slip, cp.multiply(np.tile(v.unit, task.system.tangents), v.shear), cp.multiply(v.unit, v.pressure)
        if task.whole is not None and (nodes := task.whole.open):
            at_rest, moved, place = on_all_nodes(task, nodes)
            slip, shear, pressed = at_rest + moved @ slip, place @ shear, place[: shape[0], : pressed.size] @ pressed

        def at_corners(mean: Array, cyclic: Array, change: cp.Expression) -> cp.Expression:
            mean, cyclic = task.placed(np.broadcast_to(mean, cyclic.shape)), task.placed(cyclic)
            return cp.Constant(mean) + cp.reshape(change, (1, *cyclic.shape[1:]), order="F") + lam * cp.Constant(cyclic)

        meant = {self.slip: cp.reshape(slip, shape, order="F"), self.load_factor: lam}
        return meant | {self.q: at_corners(task.q0, task.q1, shear), self.p: at_corners(task.p0, task.p1, pressed)}

    def _shown(self, answer: A, **more: Array | float) -> A:
        """An answer, whose values stand in the user's unknowns from now on."""
        q, p = answer.reactions
        for name, value in {"slip": answer.slip, "load_factor": answer.load_factor, "q": q, "p": p, **more}.items():
            getattr(self, name).save_value(np.asarray(value))
        return answer

    def _program(
        self,
        listing: Callable[[SafeSet], cp.Problem],
        task: LimitQuestion,
        constraints: Sequence[Any] = (),
        objective: Any = None,
        load_factor: float | None = None,
    ) -> SafeSet:
        """The program of a listing, maybe with constraints and an objective of the user's own, which see the whole contact.

        That of a plane contact is compiled once for all frictions, and for the same ones of these.

        Raises
        ------
        ModelError
            What is no cvxpy constraint or expression, not convex, no linear or cone program, or on unknowns of another model.
        """
        v, asked, key = self._set(task), [*constraints, objective], (_planes(task), task.opening)
        v.ask(task, load_factor)
        self._load.value = task.load_unit if load_factor is None else load_factor
        once = task.system.tangents == 1 and task.lift is None and not task.fixed
        known, problem, own = self._compiled.get(key, ([], None, None)) if once else ([], None, None)
        if problem is None or [*map(id, known)] != [*map(id, asked)]:
            problem = listing(v)
            if constraints or objective is not None:
                problem, own = extended(problem, [*v.slip.variables(), v.load_factor], self._meant(v), constraints, objective)
            if once:
                self._compiled[key] = asked, problem, own
        return v.posed(problem, own)


def _planes(task: LimitQuestion) -> bytes:
    """What tells the parts of one contact apart."""
    return b"" if task.mirrors is None else task.mirrors.planes.tobytes()


def safe_set(task: LimitQuestion, design: DesignLoads | None = None) -> SafeSet:
    """Unknowns and rows of the safe slips of a contact in the plane or in space; friction is set by `SafeSet.ask`."""
    return (Intervals if task.system.tangents == 1 else Circles)(task, design)
