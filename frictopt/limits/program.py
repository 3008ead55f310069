"""A program over safe slips, with the question that it answers and what a solution of it means."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import cvxpy as cp
import numpy as np
from scipy.optimize import nnls

from ..contact import ContactSystem
from ..contact.checks import Array
from ..contact.onset import reach
from ..contact.tolerances import RESIDUAL, ROUNDING
from ..solve.explain import Units
from ..solve.solvers import LP, SOCP
from ..solve.standard_form import polish
from .circles import Circles
from .design_loads import DesignLoads
from .mechanism import Mechanism
from .question import LimitQuestion
from .safe_set import Intervals, Rows, SafeSet

__all__ = ["SafeProgram", "SlipClaim", "kind_of", "posed", "safe_set"]

_CARRIED = ROUNDING / 10  # excess over a circle, in mean normal forces, up to which a slip carries its load factor


@dataclass(frozen=True, eq=False)
class SafeProgram:
    """A cvxpy problem over safe slips; `refine` and solving change the values that stand in it. `own` are the rows of the user's own in it."""

    task: LimitQuestion
    v: SafeSet
    problem: cp.Problem
    own: tuple[cp.Constraint, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the user's own rows, each once."""
        return tuple(dict.fromkeys(row.label for row in self.own))

    @property
    def left_out(self) -> tuple[str, ...]:
        """What it leaves out, in words."""
        task = self.task
        if task.whole is None:
            return self.v.left_out
        which = "mirror symmetry: v is odd" if task.lift is None else "nodes that are open under the mean load"
        return f"{which}, {len(task.friction)} of {task.system.nodes} nodes are in the program", *self.v.left_out

    @cached_property
    def rows(self) -> Rows:
        """Its rows by their names."""
        return {row.label: row for row in self.problem.constraints}

    @property
    def units(self) -> Units:
        """Units of its unknowns."""
        design = {} if self.v.design is None else {"design": self.v.design.unit}
        return {"load_factor": self.task.load_unit, "margin": self.task.mean_bound, "traction": self.v.scaled.traction_unit, **design}

    def refine(self) -> None:
        """Move the solution that stands in the problem onto its active rows and cones."""
        polish(self.problem)

    def cap(self, name: str) -> float:
        """Multiplier of a named scalar row."""
        return max(float(self.rows[name].dual_value), 0.0)

    @property
    def slip(self) -> Array:
        """(N,) or (N, 2) slip of the solution, within its bound."""
        slip = self.v.scaled.slip @ self.v.traction.value
        if self.v.slide is not None and self.v.slide.value is not None:
            slip = slip + self.v.scaled.rigid @ self._slide(self.v.slide)
        slip = slip.reshape(self.task.loads.q1.shape[1:], order="F")
        if self.task.most is not None:
            slip[self.task.most == 0] = 0.0
        return self.task.within_bound(slip)

    def _slide(self, slide: cp.Variable) -> Array:
        """The slide of the solution; where the gaps of open nodes alone feel it, the smallest one, for interior points go as far as gaps grow."""
        row, found = self.rows.get("stays_open"), np.asarray(slide.value)
        if row is None or self.own or self.task.most is not None:
            return found
        slide.save_value(np.zeros(len(found)))
        opens, lack = self.v.opened_by_slides, row.expr.value - RESIDUAL / 10
        columns, last = np.vstack([opens.T, lack]), np.eye(len(found) + 1)[-1]
        *way, share = columns @ nnls(columns, last)[0] - last  # the problem of least distance of Lawson & Hanson
        with np.errstate(divide="ignore", invalid="ignore"):
            least = -np.array(way) / share
        slide.save_value(least if (opens @ least >= lack - RESIDUAL / 10).all() else found)
        return np.asarray(slide.value)

    @property
    def load_factor(self) -> float:
        """The load factor of the solution, >= 0; in space moved to what its slip carries."""
        value = float(self.v.load_factor.value) * self.task.load_unit
        sense = 1 if isinstance(self.problem.objective, cp.Maximize) else -1
        return max(0.0, carried(self.task, self.slip, value, sense) if self.task.system.tangents > 1 else value)  # in this order -0 becomes 0

    @property
    def motion(self) -> tuple[Mechanism, float]:
        """The mechanism of its multipliers, and the sum of these, each times the mean friction bound."""
        motion, weight = self.v.motion(self.rows)
        pressed = 0.0 if motion.press is None else float(motion.press.sum()) * self.task.clearance
        return motion, float(weight.sum()) * self.task.mean_bound + pressed

    @property
    def violation(self) -> float:
        """Largest violation of the user's own rows."""
        return max((float(np.max(row.violation())) for row in self.own), default=0.0)

    @property
    def downward(self) -> "SafeProgram":
        """The program of the least load factor under the same rows."""
        return replace(self, problem=cp.Problem(cp.Minimize(self.v.load_factor), self.problem.constraints))


@dataclass(frozen=True, eq=False)
class SlipClaim:
    """A slip that stands in a program, and by how much it is not what was asked for."""

    slip: Array
    residual: float


def kind_of(system: ContactSystem) -> str:
    """What the programs over its safe slips are."""
    return LP if system.tangents == 1 else SOCP


def safe_set(task: LimitQuestion, design: DesignLoads | None = None) -> SafeSet:
    """Unknowns and rows of the safe slips of a contact in the plane or in space; friction is set by `SafeSet.ask`."""
    return (Intervals if task.system.tangents == 1 else Circles)(task, design)


def posed(task: LimitQuestion, listing: Callable[[SafeSet], cp.Problem], load_factor: float | None = None) -> SafeProgram:
    """A program over safe slips; `load_factor` is the given one where it is no unknown."""
    v = safe_set(task)
    v.ask(task, load_factor)
    return SafeProgram(task, v, listing(v))


def carried(task: LimitQuestion, slip: Array, load_factor: float, sense: int) -> float:
    """The load factor, lowered (or raised: sense -1) in closed form to where the slip keeps every node within its circle at every corner.

    Circles count from rounding on: where a node carries nothing, what it can carry is lost in it.
    """
    (q, p), f, q1, p1 = task.reactions(load_factor, slip), task.friction, sense * task.loads.q1, sense * task.loads.p1
    beyond = np.linalg.norm(q, axis=-1) - f * p > _CARRIED * task.force
    pulls = task.opening & (p < -_CARRIED * task.force) & (p1 < 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        back = np.where(beyond, reach(q, f * p, q1, f * p1), 0.0)
        shut = np.where(pulls, p / -p1, 0.0)
        touch = _back_to_open(task, slip, load_factor, sense)
    return load_factor + sense * float(min(np.where(np.isfinite(back), back, 0.0).min(), shut.min(), touch, 0.0))


def _back_to_open(task: LimitQuestion, slip: Array, load_factor: float, sense: int) -> float:
    """Change of the load factor, times its sense, at which open nodes that overlap only touch; 0 where none does."""
    rate = sense * task.loads.w1
    gap = task.gaps(load_factor, slip)
    closes = (gap < -_CARRIED * task.clearance) & (rate < 0)
    return float(np.where(closes, gap / np.where(closes, -rate, 1.0), 0.0).min(initial=0.0))
