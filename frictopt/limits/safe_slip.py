"""Existence of a safe residual slip at a given load factor."""

from collections.abc import Sequence

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ..contact import RESIDUAL, Array, ContactSystem, LoadCycle, SolveRecord, finite_number, listed, warns_of_odd_values
from ..errors import ModelError, SolverError
from ..solve.solvers import NoOptimum
from . import models
from .answered import answered
from .models import Row
from .open_nodes import rest_under_mean
from .programs import Program, listed_rows
from .question import Question
from .safe_model import SafeModel, in_turn
from .safe_slip_result import SafeSlip

_MOST_CYCLIC = 1e15  # cyclic loads above so many mean normal forces have none of their digits


class SafeSlipModel(SafeModel):
    """The safe residual slips of one system under one load cycle, for any friction and load factor, also under constraints of your own.

    Theory, eq. (9).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    slip_bound, simplify, solver
        See `ShakedownModel`.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases or options, a negative slip bound.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 0.0}, {"force": 1.0}])
    >>> model = fo.SafeSlipModel(rod, cycle)
    >>> round(model.solve(0.5, load_factor=0.8).margin, 6)
    0.2
    >>> round(model.solve(0.5, load_factor=0.8, constraints=[model.slip[0] - model.slip[1] <= 0.25]).margin, 6)
    -0.1
    """

    _closing: float | Array = np.inf
    """Friction with which some slip is known to be safe at some load factor, all nodes closed; it is so with more."""

    _opening: float | Array = -np.inf
    """Friction with which none is known to be; it is so with less."""

    _left: tuple[bytes, Question | None] = b"", None
    """The question of what the mean load leaves closed, and the friction of which it was asked last."""

    _given = True
    load_factor: cp.Parameter
    """The load factor that is given, a cvxpy parameter for constraints of your own."""
    margin: cp.Variable
    """The margin, see `SafeSlip`, a cvxpy variable for constraints of your own."""

    def __init__(
        self, system: ContactSystem, cycle: LoadCycle, *, slip_bound: ArrayLike | None = None, simplify: bool = True, solver: str | None = None
    ) -> None:
        super().__init__(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver)
        self.margin = cp.Variable(name="margin")
        self._spare, self._apart = cp.Parameter(system.nodes, nonneg=True, name="mean_bound"), cp.Parameter(nonneg=True, name="clearance")

    @property
    def _unknowns(self) -> list[cp.Variable]:
        return [*super()._unknowns, self.margin]

    def _safe(self, task: Question, load_factor: float, own: Sequence[cp.Constraint] = ()) -> SafeSlip:
        """The slip with the largest margin, with given nodes open."""

        def friction(corners: list[int]) -> list[Row]:
            spare = models.called(cp.multiply(self.margin, self._spare), "margin * mean_bound")
            return models.inside(self._x, self._f, corners, spare, self.margin * self._apart, task.little)

        self._spare.value, self._apart.value, self.load_factor.value = task.mean_bound * ~task.open, task.clearance, load_factor
        program = self._program(task, own, None, lambda each: models.safe_slip(self.margin, each.rows), "safe slip", 1.0, friction=friction)
        try:
            claim, record = program.chain.solve(lambda: judged(program, self.margin, load_factor), self._solver)
        except NoOptimum:
            ruling = () if not own or not (none := program.chain.contradiction()) else program.ruling(none.ruling)
            if ruling:
                asked = f"no residual slip, safe or not, obeys this at load factor {load_factor:g}; drop or relax it"
                raise ModelError(f"{', '.join(ruling)}: {asked}") from None
            raise
        return answered(claim, record, program)

    @warns_of_odd_values
    @in_turn
    def solve(self, friction: ArrayLike, load_factor: float, constraints: Sequence[cp.Constraint] = ()) -> SafeSlip:
        """The residual slip with the largest reserve at every node and corner of the cycle, under constraints of your own.

        Parameters
        ----------
        friction
            Coefficient of friction, one or one per node.
        load_factor
            Load factor, >= 0.
        constraints
            cvxpy constraints on `slip`, `q`, `p` and `margin` of this model, see `ShakedownModel.solve`; `bound` and `residual` cover them.

        Raises
        ------
        ModelError
            Bad input; a load factor so large that the mean load is lost in rounding; constraints that no slip obeys, safe or not, or that are not
            convex, need other cones, or are on another model.
        SolverError
            No solver gave an answer that passes the checks.
        """
        safe = self.of_any_set(self._posed(friction), load_factor, listed("constraints", constraints))
        self.margin.save_value(np.array(safe.margin))
        return self._shown(safe)

    def of_any_set(self, task: Question, load_factor: float, own: Sequence[cp.Constraint] = ()) -> SafeSlip:
        """The slip with all nodes closed; where none is safe then at any load factor, that of those which the mean load leaves closed."""
        load_factor = finite_number("load_factor", load_factor, least=0.0)
        largest = load_factor / task.force * float(np.abs(task.r1).max())
        if largest > _MOST_CYCLIC:
            raise ModelError(
                f"load_factor: {load_factor:g} makes the cyclic loads {largest:.1e} times the mean normal force {task.force:.3g} of the mean load, "
                "which is lost in their rounding; give less, or check the units of the load cases"
            )

        def safe_of(task: Question) -> SafeSlip:
            return self._safe(task, load_factor, own)

        unsafe = bool((task.friction <= self._opening).all())
        try:
            safe = None if own or unsafe else safe_of(task)  # own constraints may contradict each other where all nodes are closed
        except SolverError:  # a slip that hardly anything resists, as a roll, can hide the margin, and not that none is safe
            if self._closed_somewhere(task):
                raise
            safe, unsafe = None, True
        if safe is None or not safe.exists:
            rest = self._rest(task) if unsafe or not self._closed_somewhere(task) else None
            safe = safe_of(rest) if rest else safe or safe_of(task)
        return safe

    def _rest(self, task: Question) -> Question | None:
        """See `rest_under_mean`."""
        friction = task.friction.tobytes()
        if friction != self._left[0]:
            self._left = friction, rest_under_mean(task)
        return self._left[1]

    def _closed_somewhere(self, task: Question) -> bool:
        """Whether some slip is safe with all nodes closed at some load factor; it is taken to be so where that cannot be told."""
        if (task.friction >= self._closing).all() or task.violation(0.0, np.zeros(task.system.slip_shape)) <= RESIDUAL:
            return True
        closed = exists_at_some_load(task, self._solver)
        if closed is None:
            return True
        if closed:
            self._closing = task.friction
        else:
            self._opening = task.friction
        return closed


@warns_of_odd_values
def safe_slip(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    slip_bound: ArrayLike | None = None,
    simplify: bool = True,
    solver: str | None = None,
) -> SafeSlip:
    """Find the residual slip with the largest reserve at every node and corner of the cycle.

    For constraints of your own see `SafeSlipModel`. Theory, eq. (9).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    slip_bound, simplify, solver
        See `ShakedownModel`.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        No solver gave an answer that passes the checks.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> fo.safe_slip(system, cycle, friction=0.5, load_factor=0.9).exists
    False
    """
    model = SafeSlipModel(system, cycle, slip_bound=slip_bound, simplify=simplify, solver=solver)
    return model.of_any_set(model._posed(friction), load_factor)


def judged(program: Program, margin: cp.Variable, load_factor: float) -> SafeSlip:
    """The slip that stands in a program of the margin, judged by its reserve, and by the multipliers."""
    task, value, slip, proof = program.task, float(margin.value), program.slip, program.chain.proof
    bounds, p = program.bounds(), task.states(load_factor, slip)[1][:, -1]
    pull = float(-p.min() / task.force) if value >= 0 else 0.0
    gap = (abs(proof.bound - value) + proof.defect) / max(1.0, abs(value))
    residual = np.max([gap, value - task.reserve(load_factor, slip), pull, task.beyond(slip), program.own_violation])
    record = SolveRecord(residual=float(np.nan_to_num(residual, nan=np.inf)))
    bound, rate = proof.bound + proof.defect, float(np.sum(bounds * p))
    return SafeSlip(load_factor, slip, record, task, program.motion, value, bound, rate, constraints=tuple(program.own))


def exists_at_some_load(task: Question, solver: str | None) -> bool | None:
    """Whether some slip is safe at some load factor; None where neither is proven."""
    x = models.unknowns(task.system.slip_shape, range(len(task.r1)))
    program = listed_rows(task, x, cp.Parameter(task.system.nodes, nonneg=True, name="f"))
    program = program.compiled(cp.Problem(cp.Minimize(x.load_factor), [*program.rows, x.load_factor >= 0]), task.load_unit)

    def judged() -> SolveRecord:
        return SolveRecord(residual=task.violation(program.load_factor, program.slip))

    try:
        program.chain.solve(judged, solver)
    except SolverError:
        return False if program.chain.contradiction(solver) else None
    return True
