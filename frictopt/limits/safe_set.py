"""The linear programs over safe residual slips, as cvxpy problems (Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987).

A residual slip v is safe at a load factor when it keeps every node closed and stuck at every corner k of the load cycle::

    |q_k| <= f p_k,  p_k >= 0,    q_k = q0 + lam q1_k + A v,    p_k = p0 + lam p1_k + B v

Written out, with the friction bound g = f p, these are the rows of `safe_rows`; those of a slip bound, if there is one, come after them. Variables
and parameters are dimensionless, see `Interface` and `LoadRows`; friction and loads are parameters, the matrices are not, so one compiled problem
serves any friction and load.
"""

from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from ..solve.polish import polish
from .ruling_corners import LoadRows
from .scaling import Interface
from .slip_bound import SlipBound

__all__ = ["SafeProblem", "margin_problem", "safe_rows", "shakedown_problem"]


@dataclass(frozen=True, eq=False)
class SafeProblem:
    """A cvxpy problem over safe slips together with the data of its rows, one of each kind for each kept node.

    `set`, `refine` and solving change the values that stand in the cvxpy problem.
    """

    problem: cp.Problem
    interface: Interface
    bound: SlipBound | None

    def set(self, rows: LoadRows, load_factor: float | None = None) -> None:
        """Set the parameters of the rows in place; a load factor moves the cyclic part to the side of the data (margin problem)."""
        factor = 1.0 if load_factor is None else load_factor / rows.load_unit
        for name, parameter in self.problem.param_dict.items():
            if name in ("forward", "backward", "opening"):
                parameter.value = factor * getattr(rows, name)
            elif hasattr(rows, name):
                parameter.value = getattr(rows, name)

    def value(self, name: str) -> np.ndarray:
        """Value of a named variable."""
        return np.asarray(self.problem.var_dict[name].value)

    @property
    def slip(self) -> Array:
        """(N,) slip of the solution, its rigid slide included, length."""
        slip = self.interface.slip @ self.value("traction")
        return np.asarray(slip + self.interface.rigid @ self.value("slide") if "slide" in self.problem.var_dict else slip)

    def dual(self, label: str) -> np.ndarray:
        """Multipliers of a named constraint, >= 0; zeros if the problem does not have it."""
        for constraint in self.problem.constraints:
            if constraint.label == label:
                return np.asarray(np.maximum(constraint.dual_value, 0.0))
        return np.zeros(len(self.interface.nodes))

    @property
    def duals(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Multipliers of the rows against forward slip, backward slip and opening."""
        return self.dual("no_forward_slip"), self.dual("no_backward_slip"), self.dual("no_opening")

    @property
    def hold(self) -> Array:
        """(n,) forces by which the slip bound holds the kept nodes, along +x positive: multipliers of its rows."""
        force = self.dual("forward_slip_bound") - self.dual("backward_slip_bound")
        return np.asarray(force if self.bound is None else force / self.bound.norm)

    def refine(self) -> None:
        """Move the solution that stands in the problem onto its vertex, see `polish`."""
        polish(self.problem)


def shakedown_problem(interface: Interface, opening: bool, bound: SlipBound | None) -> SafeProblem:
    """Largest load factor at which some residual slip is safe."""
    load_factor = cp.Variable(name="load_factor")
    rows = safe_rows(interface, opening, load_factor, bound=bound)
    problem = cp.Problem(cp.Maximize(load_factor), [*rows, (load_factor >= 0).set_label("load_factor_not_negative")])
    return SafeProblem(problem, interface, bound)


def margin_problem(interface: Interface, opening: bool, bound: SlipBound | None, free_load_factor: bool = False) -> SafeProblem:
    """Residual slip that stays furthest inside the friction bounds, at a given load factor or at whatever one is best.

    The margin is the reserve of the friction bound (and with little friction, of the pressure), counted in mean friction bounds and capped at 1;
    negative: there is no safe slip.
    """
    load_factor, margin = cp.Variable(name="load_factor"), cp.Variable(name="margin")
    clearance = cp.Parameter(len(interface.nodes), nonneg=True, name="clearance")
    rows = safe_rows(interface, opening, load_factor if free_load_factor else 1.0, cp.multiply(clearance, margin), bound)
    rows += [(margin <= 1).set_label("cap")]
    rows += [(load_factor >= 0).set_label("load_factor_not_negative")] if free_load_factor else []
    return SafeProblem(cp.Problem(cp.Maximize(margin), rows), interface, bound)


def safe_rows(
    interface: Interface,
    opening: bool,
    load_factor: cp.Expression | float,
    reserve: cp.Expression | float = 0.0,
    bound: SlipBound | None = None,
    excess: cp.Expression | float = 0.0,
) -> list[cp.Constraint]:
    """No forward and no backward slip at any node and corner, with a reserve, and slips that exceed their bound by at most `excess`.

    Where there is friction the rows against slip keep the nodes closed as well; for little or none, `opening` adds the rows that say so.
    """
    count = len(interface.nodes)
    traction = cp.Variable(interface.shear.shape[1], name="traction")
    friction = cp.Parameter(count, nonneg=True, name="friction")
    q_mean, g_mean = cp.Parameter(count, name="q_mean"), cp.Parameter(count, name="g_mean")
    forward, backward = cp.Parameter(count, name="forward"), cp.Parameter(count, name="backward")

    q = q_mean + interface.shear @ traction
    g = g_mean + cp.multiply(friction, interface.normal @ traction)
    constraints = [
        (q + g >= forward * load_factor + reserve).set_label("no_forward_slip"),
        (g - q >= backward * load_factor + reserve).set_label("no_backward_slip"),
    ]
    if opening:
        p = cp.Parameter(count, name="p_mean") + interface.normal @ traction
        constraints.append((p >= cp.Parameter(count, name="opening") * load_factor + reserve).set_label("no_opening"))
    return constraints if bound is None else [*constraints, *bound.rows(traction, excess)]
