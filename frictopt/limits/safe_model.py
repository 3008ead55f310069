"""What the models of safe slips have in common: the expressions to extend them by, and the programs that they compile."""

from collections.abc import Callable, Sequence
from functools import partial, wraps
from threading import RLock
from typing import Any, TypeVar, cast

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..contact import Array, ContactSystem, LoadCycle, parted
from ..solve.solvers import LP, SOCP, solver_order
from .answered import Answered
from .design_result import DesignLoads
from .friction_bounds import safe_set
from .own_rows import OF_A_MODEL, OwnRows, extended
from .parts import on_whole
from .question import LimitQuestion, pose
from .safe_set import SafeSet

A = TypeVar("A", bound=Answered)
F = TypeVar("F", bound=Callable[..., Any])


class Turn:
    """A lock of all threads that ask a model; a copy with programs of its own has a lock of its own."""

    def __init__(self) -> None:
        self.lock = RLock()

    def __reduce__(self) -> tuple[type["Turn"], tuple[()]]:
        return Turn, ()


def in_turn(question: F) -> F:
    """A question of a model that threads ask one after the other, for its program has parameters and variables."""

    @wraps(question)
    def asked(self: "SafeModel", *args: Any, **kwargs: Any) -> Any:
        with self._turn.lock:
            return question(self, *args, **kwargs)

    return cast(F, asked)


class SafeModel:
    """Base of models that take constraints of the user's own: what they decide on, in the user's units."""

    _design: DesignLoads | None = None
    _given = False  # whether the load factor is
    load_factor: cp.Expression
    """The load factor, a cvxpy variable for constraints of your own."""
    slip: cp.Variable
    """(N,) or (N, 2) residual slip, length, a cvxpy variable for constraints of your own; of open nodes the one under the mean load."""
    q: cp.Variable
    """(K, N) or (K, N, 2) shear forces at the corners of the cycle, force, a cvxpy variable for constraints of your own; 0 at open nodes."""
    p: cp.Variable
    """(K, N) normal forces at the corners, compression positive, force, a cvxpy variable for constraints of your own; 0 at open nodes."""

    def __init__(
        self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: ArrayLike | None = None, simplify: bool = True, solver: str | None = None
    ) -> None:
        self._asked, self._solver = pose(system, cycle, 1.0, simplify=simplify, slip_bound=slip_bound), solver
        self._posed = partial(pose, system, cycle, simplify=simplify, slip_bound=self._asked.most)  # by its friction
        self._turn = Turn()
        solver_order(solver, LP if system.tangents == 1 else SOCP)
        self._load = cp.Parameter(nonneg=True, name="load_unit")  # or the load factor, where it is given
        corners, slips = (len(cycle.corners),), system.slip_shape
        shapes = {"load_factor": (), "slip": slips, "q": corners + slips, "p": corners + slips[:1]}
        self.load_factor, self.slip, self.q, self.p = (cp.Variable(shape, name=OF_A_MODEL + name) for name, shape in shapes.items())
        if self._given:
            self.load_factor = self._load
        self._sets: dict[bytes, SafeSet] = {}  # by the mirror planes: of the whole contact, and of its parts
        self._compiled: dict[tuple[bytes, bool], tuple[list[object], cp.Problem | None, OwnRows | None]] = {}  # by what friction can change

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(map(repr, self._posed.args))})"

    def _meant(self, v: SafeSet) -> dict[cp.Variable, cp.Expression]:
        """What the unknowns of the user's rows are in a program, in the user's units, on all nodes."""
        task, lam, shape = v.task, self._load if self._given else self._load * v.load_factor, self._asked.system.slip_shape
        slip, shear, pressed = v.slip, cp.multiply(np.tile(v.unit, task.system.tangents), v.shear), cp.multiply(v.unit, v.pressure)
        whole = task.whole or task
        if whole.give is not None:
            out = np.tile(~whole.closed, task.system.tangents)
            place = np.eye(len(out))[:, ~out]
            moved = place - whole.give[: len(out)] @ (task.system.S[:, : len(out)] @ place)
            slip, shear, pressed = (
                on_whole(task, np.zeros(task.r1[0, :-1].T.shape), None)[1].T.ravel() + moved @ slip,
                place @ shear,
                place[: shape[0], : pressed.size] @ pressed,
            )

        every = np.zeros((2, *whole.r1.shape))
        every[..., whole.closed] = np.broadcast_to(task.r0, task.r1.shape), task.r1
        meant = {self.slip: cp.reshape(slip, shape, order="F"), self.load_factor: lam}
        loads = parted(every.reshape(2, len(task.r1), -1), task.system.tangents + 1)
        for unknown, change, (mean, cyclic) in zip((self.q, self.p), (shear, pressed), loads, strict=True):
            meant[unknown] = cp.Constant(mean) + cp.reshape(change, (1, *cyclic.shape[1:]), order="F") + lam * cp.Constant(cyclic)
        return meant

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
        part = b"" if task.images is None else np.stack(task.images[1:]).tobytes()  # tells the parts of one contact apart
        v = safe_set(task, self._design) if task.lift is not None or part not in self._sets else self._sets[part]
        if task.lift is None:
            self._sets[part] = v
        v.ask(task, load_factor)
        self._load.value = task.load_unit if load_factor is None else load_factor
        asked, key, once = [*constraints, objective], (part, task.opening), task.system.tangents == 1 and task.lift is None and not task.fixed
        known, problem, own = self._compiled.get(key, ([], None, None)) if once else ([], None, None)
        if problem is None or [*map(id, known)] != [*map(id, asked)]:
            problem = listing(v)
            if constraints or objective is not None:
                problem, own = extended(problem, [*v.slip.variables(), v.load_factor], self._meant(v), constraints, objective)
            if once:
                self._compiled[key] = asked, problem, own
        return v.posed(problem, own)
