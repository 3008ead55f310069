"""What the models of safe slips have in common: the expressions to extend them by, and the programs that they compile."""

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array
from ..solve.solvers import LP, SOCP, solver_order
from .circles import Circles
from .design_loads import DesignLoads
from .intervals import Intervals
from .own_rows import OwnRows, extended
from .question import LimitQuestion, pose
from .safe_set import SafeSet

__all__ = ["SafeModel", "safe_set"]


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
        """The load factor, an affine cvxpy expression for constraints of your own."""
        return self._load * self._v.load_factor

    @cached_property
    def slip(self) -> cp.Expression:
        """(N,) or (N, 2) residual slip, length, an affine cvxpy expression for constraints of your own."""
        return cp.reshape(self._v.slip, self._asked.system.slip_shape, order="F")

    @cached_property
    def q(self) -> cp.Expression:
        """(K, N) or (K, N, 2) shear forces at the corners of the cycle, force, an affine cvxpy expression for constraints of your own."""
        unit, shape = np.tile(self._v.unit, self._asked.system.tangents), self._asked.system.slip_shape
        return self._at_corners(self._asked.q0, self._asked.q1, cp.reshape(cp.multiply(unit, self._v.shear), (1, *shape), order="F"))

    @cached_property
    def p(self) -> cp.Expression:
        """(K, N) normal forces at the corners of the cycle, compression positive, force, an affine cvxpy expression for constraints of your own."""
        change = cp.multiply(self._v.unit, self._v.pressure)
        return self._at_corners(self._asked.p0, self._asked.p1, cp.reshape(change, (1, change.size), order="F"))

    def _at_corners(self, mean: Array, cyclic: Array, change: cp.Expression) -> cp.Expression:
        return cp.Constant(np.broadcast_to(mean, cyclic.shape)) + change + self.load_factor * cp.Constant(cyclic)

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
                problem, own = extended(problem, [*v.slip.variables(), v.load_factor], constraints, objective)
            if once:
                self._compiled[key] = asked, problem, own
        return v.posed(problem, own)


def _planes(task: LimitQuestion) -> bytes:
    """What tells the parts of one contact apart."""
    return b"" if task.mirrors is None else task.mirrors.planes.tobytes()


def safe_set(task: LimitQuestion, design: DesignLoads | None = None) -> SafeSet:
    """Unknowns and rows of the safe slips of a contact in the plane or in space; friction is set by `SafeSet.ask`."""
    return (Intervals if task.system.tangents == 1 else Circles)(task, design)
