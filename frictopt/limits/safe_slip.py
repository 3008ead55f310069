"""Existence of a safe residual slip at a given load factor."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import IO, Any

import cvxpy as cp
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_number, frozen
from ..solve.explain import Units, explain
from ..solve.portable import Portable
from ..solve.solvers import Attempt
from .kinds import solve_margin
from .mechanism import Mechanism
from .posed import Task, cycle_loads
from .slip_bound import slip_bounds

__all__ = ["SafeSlip", "safe_slip"]

_ROUNDING = 1e-12  # margins this little below zero are zero: those at the shakedown limit itself


@dataclass(frozen=True, eq=False)
class SafeSlip(Portable):
    """A residual slip that keeps the contact stuck, or the proof that there is none.

    Attributes
    ----------
    exists
        Whether a safe slip exists at the load factor: the margin is not negative by more than 1e-12 or its own residual.
    slip
        (N,) the slip that stays furthest inside the friction bounds, length (the least unsafe one if none is safe); within the slip bound.
    margin
        Its smallest reserve `f p - |q|` over nodes and corners, in mean friction bounds of the mean load, at most 1; negative: none is safe.
        With friction below 0.01 somewhere the reserve of p counts as well.
    margin_bound
        Upper bound of the margin from the multipliers alone; equals `margin` up to `residual`.
    residual
        Largest of: the shortfall of the slip's reserve, recomputed, and the distance of `margin_bound`. At most 1e-9.
    solver, attempts
        Who answered, and all solver runs.
    left_out
        What the scene did not need.
    problem
        The solved cvxpy problem; None in a copy.
    """

    exists: bool
    slip: Array = field(repr=False)
    margin: float
    margin_bound: float
    residual: float
    solver: str
    attempts: tuple[Attempt, ...] = field(repr=False)
    left_out: tuple[str, ...]
    problem: cp.Problem | None = field(repr=False)
    _task: Task = field(repr=False)
    _motion: Mechanism = field(repr=False)
    _units: Units = field(repr=False)

    @cached_property
    def certificate(self) -> pd.DataFrame | None:
        """Why no slip is safe (Farkas's lemma); None if one is.

        A table like `ShakedownLimit.mechanism`: slips whose friction cannot take up the work of the loads, while no residual slip does work
        on them, or with a slip bound too little.
        """
        return None if self.exists else self._motion.table(self._task.system.x)

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        explain("safe residual slip", self.problem, self.margin, self._units, self.left_out, self._motion.table(self._task.system.x), file)


def safe_slip(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    load_factor: float,
    *,
    slip_bound: Any = None,
    simplify: bool = True,
    solver: str | None = None,
) -> SafeSlip:
    """Find the residual slip with the largest reserve at every node and corner of the cycle.

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
    """
    loads = cycle_loads(system, cycle)
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    task = Task(system, cycle, loads, friction, simplify, slip_bounds(slip_bound, system.nodes))
    interface = task.interface()
    state, answer, model = solve_margin(task, interface, task.loads, load_factor, solver)
    return SafeSlip(
        exists=bool(state.margin >= -max(_ROUNDING, state.residual)),
        slip=frozen(state.slip),
        margin=state.margin,
        margin_bound=state.bound,
        residual=state.residual,
        solver=answer.solver,
        attempts=answer.attempts,
        left_out=task.left_out(task.rows(interface)),
        problem=model.problem,
        _task=task,
        _motion=state.motion,
        _units={"margin": task.mean_bound, "traction": interface.unit[interface.loaded]},
    )
