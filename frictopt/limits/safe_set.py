"""What the linear programs over safe residual slips are made of: unknowns, expressions, parameters, and the values of a solution.

A residual slip v is safe at a load factor when it keeps every node closed and stuck at every corner of the load cycle. Unknowns and parameters are
dimensionless, see `ScaledContact` and `RulingLoads`; friction and loads are parameters, the matrices are not, so one compiled problem serves any
friction and load.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from ..solve.polish import polish
from .ruling_corners import RulingLoads
from .scaling import ScaledContact
from .slip_bound import SlipBound

__all__ = ["SafeProblem", "SafeSymbols"]


class SafeSymbols:
    """Unknowns of a residual slip v in the plane, what stands in the rows of its programs, and the rows of the corners that rule.

    The corners of one row differ only in the coefficient of `lam >= 0`, so the largest one rules and stands for all of them::

        forward = max_k -(q1_k + f p1_k),   backward = max_k (q1_k - f p1_k),   opening = max_k -p1_k

    `p >= 0` follows from the other two where there is friction; for little or none, `opening` keeps its rows. The bound is `abs(v) <= slip_bound`.

    Parameters
    ----------
    contact, rows_of_opening, bound
        The contact, whether the rows of opening are needed, and a bound on the slip.

    Attributes
    ----------
    traction, slide
        The unknowns: nodal tractions, and rigid slides, which no row feels but those that bound the slip.
    q, p, fp
        (n,) shear force q0 + A v, normal force p0 + B v and friction bound f (p0 + B v) of the nodes under the mean load.
    forward, backward, opening
        (n,) cyclic load at the corners that rule the rows, see `RulingLoads`.
    """

    def __init__(self, contact: ScaledContact, rows_of_opening: bool, bound: SlipBound | None) -> None:
        n, m = contact.shear.shape
        self._contact, self._opens, self._bound = contact, rows_of_opening, bound
        self.traction, self.slide = cp.Variable(m, name="traction"), cp.Variable(contact.rigid.shape[1], name="slide") if contact.rigid.size else None
        q0, p0, fp0 = (cp.Parameter(n, name=name) for name in ("q_mean", "p_mean", "fp_mean"))
        friction = cp.Parameter(n, nonneg=True, name="friction")
        self.q, self.p = q0 + contact.shear @ self.traction, p0 + contact.normal @ self.traction
        self.fp = fp0 + cp.multiply(friction, contact.normal @ self.traction)
        self.forward, self.backward, self.opening = (cp.Parameter(n, name=name) for name in ("forward", "backward", "opening"))

    def stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None = None) -> dict[str, cp.Constraint]:
        """Rows by which every node is closed and stuck at every corner, with a margin in mean friction bounds; None: no margin.

        A load factor of None is a given one: it then stands in the parameters.
        """
        lam, reserve = 1.0 if load_factor is None else load_factor, 0.0
        if margin is not None:
            reserve = cp.multiply(cp.Parameter(self.q.size, nonneg=True, name="clearance"), margin)
        return {
            "no_forward_slip": self.q + self.fp >= self.forward * lam + reserve,
            "no_backward_slip": self.fp - self.q >= self.backward * lam + reserve,
            "no_opening": self.p >= self.opening * lam + reserve,
        }

    def problem(self, goal: cp.Minimize | cp.Maximize, rows: Mapping[str, cp.Constraint]) -> "SafeProblem":
        """The rows by their names and those of a slip bound; without the rows `no_opening` where friction implies them."""
        kept = [row.set_label(name) for name, row in rows.items() if self._opens or name != "no_opening"]
        kept += [] if self._bound is None else self._bound.rows(self.traction, self.slide)
        return SafeProblem(cp.Problem(goal, kept), self._contact, self._bound, self)


@dataclass(frozen=True, eq=False)
class SafeProblem:
    """A cvxpy problem over safe slips together with the data of its rows, one of each kind for each node of its part of the contact.

    `set`, `refine` and solving change the values that stand in the cvxpy problem. `own` are the rows of the user's own among its constraints.
    """

    problem: cp.Problem
    scaled: ScaledContact
    bound: SlipBound | None
    symbols: SafeSymbols
    own: tuple[cp.Constraint, ...] = ()

    def set(self, rows: RulingLoads, load_factor: float | None = None) -> None:
        """Set the parameters of the rows in place; a load factor moves the cyclic part to the side of the data (margin problem)."""
        factor = 1.0 if load_factor is None else load_factor / rows.load_unit
        for name, parameter in self.problem.param_dict.items():
            if name in ("forward", "backward", "opening"):
                parameter.value = factor * getattr(rows, name)
            elif hasattr(rows, name):
                parameter.value = getattr(rows, name)

    @cached_property
    def downward(self) -> "SafeProblem":
        """The program of the least load factor under the same rows."""
        return replace(self, problem=cp.Problem(cp.Minimize(self.problem.var_dict["load_factor"]), self.problem.constraints))

    def violation(self) -> float:
        """Largest violation of the user's own rows."""
        return max((float(np.max(row.violation())) for row in self.own), default=0.0)

    def values(self) -> dict[cp.Variable, Array]:
        """What stands in the variables."""
        return {variable: variable.value for variable in self.problem.variables()}

    def value(self, name: str) -> np.ndarray:
        """Value of a named variable."""
        return np.asarray(self.problem.var_dict[name].value)

    @property
    def slip(self) -> Array:
        """(N,) slip of the whole contact in the solution, its rigid slide included, length."""
        slip = self.scaled.slip @ self.value("traction")
        return self.scaled.part.odd(slip + self.scaled.rigid @ self.value("slide") if "slide" in self.problem.var_dict else slip)

    def dual(self, label: str) -> np.ndarray:
        """Multipliers of a named constraint, >= 0; zeros if the problem does not have it."""
        for constraint in self.problem.constraints:
            if constraint.label == label:
                return np.asarray(np.maximum(constraint.dual_value, 0.0))
        return np.zeros(len(self.scaled.unit))

    @property
    def duals(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Multipliers of the rows against forward slip, backward slip and opening."""
        return self.dual("no_forward_slip"), self.dual("no_backward_slip"), self.dual("no_opening")

    @property
    def hold(self) -> Array:
        """(n,) forces by which the slip bound holds the nodes of the part, along +x positive: multipliers of its rows."""
        force = self.dual("forward_slip_bound") - self.dual("backward_slip_bound")
        return np.asarray(force if self.bound is None else force / self.bound.norm)

    def refine(self) -> None:
        """Move the solution that stands in the problem onto its vertex, see `polish`."""
        polish(self.problem)
