"""The linear programs over safe residual slips, as cvxpy problems (Flicek et al. 2015, section 4; Bjorkman & Klarbring 1987).

A residual slip v is safe at a load factor when it keeps every node closed and stuck at every corner k of the load cycle::

    |q_k| <= f p_k,  p_k >= 0,    q_k = q0 + lam q1_k + A v,    p_k = p0 + lam p1_k + B v

Written out, with the friction bound g = f p, these are the rows of `safe_rows`. Variables and parameters are dimensionless, see `Interface` and
`LoadRows`; friction and loads are parameters, the matrices are not, so one compiled problem serves any friction and load.
"""

from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from .interface import Interface
from .rows import LoadRows
from .vertex import on_vertex

__all__ = ["SafeProblem", "margin_problem", "shakedown_problem"]


@dataclass(frozen=True, eq=False)
class SafeProblem:
    """A cvxpy problem over safe slips together with the data of its rows; row r speaks for node `node[r]` of the interface.

    `set`, `refine` and solving change the values that stand in the cvxpy problem.
    """

    problem: cp.Problem
    interface: Interface
    node: np.ndarray

    def set(self, rows: LoadRows, load_factor: float | None = None) -> None:
        """Set the parameters in place; a load factor moves the cyclic part to the side of the data (margin problem)."""
        factor = 1.0 if load_factor is None else load_factor / rows.load_unit
        for name, parameter in self.problem.param_dict.items():
            if name in ("forward", "backward", "opening"):
                parameter.value = factor * getattr(rows, name)
            elif name != "clearance":
                parameter.value = getattr(rows, name)

    def value(self, name: str) -> np.ndarray:
        """Value of a named variable."""
        return np.asarray(self.problem.var_dict[name].value)

    def dual(self, label: str) -> np.ndarray:
        """Multipliers of a named constraint, >= 0; zeros if the problem does not have it."""
        for constraint in self.problem.constraints:
            if constraint.label == label:
                return np.asarray(np.maximum(constraint.dual_value, 0.0))
        return np.zeros(len(self.node))

    @property
    def duals(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Multipliers of the rows against forward slip, backward slip and opening."""
        return self.dual("no_forward_slip"), self.dual("no_backward_slip"), self.dual("no_opening")

    def refine(self) -> None:
        """Move the solution that stands in the problem onto its vertex, see `on_vertex`."""
        names = [name for name in ("traction", "load_factor", "margin") if name in self.problem.var_dict]
        z = np.concatenate([np.atleast_1d(self.value(name)) for name in names])
        y = np.concatenate([np.atleast_1d(constraint.dual_value) for constraint in self.problem.constraints])
        z, y = on_vertex(*self._rows(names), np.r_[np.zeros(len(z) - 1), 1.0], z, y)  # the last variable is the one that is maximised
        sizes = [self.problem.var_dict[name].size for name in names]
        for name, part in zip(names, np.split(z, np.cumsum(sizes)[:-1]), strict=True):
            self.problem.var_dict[name].save_value(part.reshape(self.problem.var_dict[name].shape))
        sizes = [constraint.size for constraint in self.problem.constraints]
        for constraint, part in zip(self.problem.constraints, np.split(y, np.cumsum(sizes)[:-1]), strict=True):
            constraint.dual_variables[0].save_value(part.reshape(constraint.shape))

    def _rows(self, names: list[str]) -> tuple[np.ndarray, np.ndarray]:
        """The constraints as `matrix @ z >= right`, z the named variables."""
        data = {name: parameter.value for name, parameter in self.problem.param_dict.items()}
        shear, normal = self.interface.shear[self.node], data["friction"][:, None] * self.interface.normal[self.node]
        cyclic = np.concatenate([data["forward"], data["backward"]])
        blocks, right = [normal + shear, normal - shear], -np.concatenate([data["g_mean"] + data["q_mean"], data["g_mean"] - data["q_mean"]])
        if "opening" in data:
            blocks.append(self.interface.normal[self.node])
            cyclic, right = np.concatenate([cyclic, data["opening"]]), np.concatenate([right, -data["p_mean"]])
        columns = [np.vstack(blocks)]
        if "load_factor" in names:
            columns.append(-cyclic[:, None])
        else:
            right = right + cyclic
        if "margin" not in names:
            return np.hstack(columns), right
        reserve = np.tile(data["clearance"], len(blocks))
        matrix = np.hstack([*columns, -reserve[:, None]])
        return np.vstack([matrix, -np.eye(matrix.shape[1])[-1]]), np.r_[right, -1.0]


def shakedown_problem(interface: Interface, node: np.ndarray, opening: bool) -> SafeProblem:
    """Largest load factor at which some residual slip is safe."""
    load_factor = cp.Variable(nonneg=True, name="load_factor")
    problem = cp.Problem(cp.Maximize(load_factor), safe_rows(interface, node, opening, load_factor, 0.0))
    return SafeProblem(problem, interface, node)


def margin_problem(interface: Interface, node: np.ndarray, opening: bool, free_load_factor: bool = False) -> SafeProblem:
    """Residual slip that stays furthest inside the friction bounds, at a given load factor or at whatever one is best.

    The margin is the reserve of the friction bound (and with little friction, of the pressure), counted in mean friction bounds and capped at 1;
    negative: there is no safe slip.
    """
    load_factor = cp.Variable(nonneg=True, name="load_factor") if free_load_factor else 1.0
    margin = cp.Variable(name="margin")
    clearance = cp.Parameter(len(node), nonneg=True, name="clearance")
    rows = safe_rows(interface, node, opening, load_factor, cp.multiply(clearance, margin))
    problem = cp.Problem(cp.Maximize(margin), [*rows, (margin <= 1).set_label("cap")])
    return SafeProblem(problem, interface, node)


def safe_rows(
    interface: Interface, node: np.ndarray, opening: bool, load_factor: cp.Expression | float, reserve: cp.Expression | float
) -> list[cp.Constraint]:
    """No forward and no backward slip at any node and corner, with a reserve; row r speaks for node `node[r]`.

    Where there is friction that keeps the nodes closed as well; for little or none, `opening` adds the rows that say so.
    """
    rows = len(node)
    traction = cp.Variable(interface.shear.shape[1], name="traction")
    friction = cp.Parameter(rows, nonneg=True, name="friction")
    q_mean, g_mean = cp.Parameter(rows, name="q_mean"), cp.Parameter(rows, name="g_mean")
    forward, backward = cp.Parameter(rows, name="forward"), cp.Parameter(rows, name="backward")

    q = q_mean + interface.shear[node] @ traction
    g = g_mean + cp.multiply(friction, interface.normal[node] @ traction)
    constraints = [
        (q + g >= forward * load_factor + reserve).set_label("no_forward_slip"),
        (g - q >= backward * load_factor + reserve).set_label("no_backward_slip"),
    ]
    if opening:
        p = cp.Parameter(rows, name="p_mean") + interface.normal[node] @ traction
        constraints.append((p >= cp.Parameter(rows, name="opening") * load_factor + reserve).set_label("no_opening"))
    return constraints
