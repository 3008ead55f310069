"""The least load factor at which one node sits on both its bounds while the slip is safe, as a cvxpy problem with the node as a parameter.

The slip is safe at every node, and the rows of one node are equations: with `k+` and `k-` the corners that rule its forward and its backward slip::

    min lam    s.t.   v safe at lam,   q = -f p of node i at corner k+,   q = +f p of node i at corner k-,   abs(v) <= slip bound

Where there is no such slip, the reach problem proves it: the least excess of the node's rows over what equations would allow, and of the slips over
their bound, is positive.
"""

from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from .interface import Interface
from .rows import LoadRows
from .safe import safe_rows
from .vertex import on_vertex

__all__ = ["ApexProblem", "SlipBound", "apex_problem"]


@dataclass(frozen=True, eq=False)
class SlipBound:
    """Rows `abs(slip traction + rigid slide) <= most`, each divided by its norm.

    Attributes
    ----------
    slip, rigid
        (N, m) and (N, k): slip for unit tractions and for unit rigid slides (which need no force; k may be 0).
    most
        (N,) largest slip.
    """

    slip: Array
    rigid: Array
    most: Array

    @property
    def rows(self) -> tuple[Array, Array, Array]:
        """The rows, scaled."""
        norm = np.linalg.norm(np.hstack([self.slip, self.rigid]), axis=1)
        return self.slip / norm[:, None], self.rigid / norm[:, None], self.most / norm


class ApexProblem:
    """The problem of one node at a time; `set`, `refine` and solving change the values that stand in the cvxpy problem.

    Attributes
    ----------
    problem
        The cvxpy problem.
    """

    def __init__(self, problem: cp.Problem, interface: Interface, node: np.ndarray, bound: SlipBound | None) -> None:
        self.problem = problem
        self._interface, self._node, self._bound = interface, node, bound

    def set(self, rows: LoadRows, ruling: LoadRows, node: int) -> None:
        """Set friction and loads by `rows`, and the node whose ruling rows become equations."""
        values, r = self.problem.param_dict, int(np.flatnonzero(ruling.node == node)[0])
        for name in values:
            if not name.startswith("apex"):
                values[name].value = getattr(rows, name)
        lift, shear = ruling.friction[r] * self._interface.normal[node], self._interface.shear[node]
        values["apex_rows"].value = np.vstack([lift + shear, lift - shear])
        values["apex_mean"].value = np.array([ruling.g_mean[r] + ruling.q_mean[r], ruling.g_mean[r] - ruling.q_mean[r]])
        values["apex_cyclic"].value = np.array([ruling.forward[r], ruling.backward[r]])

    @property
    def load_factor(self) -> float:
        """Load factor of the solution, dimensionless."""
        return float(self.problem.var_dict["load_factor"].value)

    @property
    def slip(self) -> Array:
        """(N,) slip of the solution, length."""
        values = self.problem.var_dict
        slip = self._interface.slip @ values["traction"].value
        return np.asarray(slip if self._bound is None or "slide" not in values else slip + self._bound.rigid @ values["slide"].value)

    @property
    def bounds(self) -> tuple[float, float]:
        """The objective that stands in the problem, and what its multipliers alone prove of the least objective."""
        matrix, right, objective, z, y = self._program()
        y = np.maximum(y, 0.0)
        defect = np.abs(matrix.T @ y + objective) @ np.maximum(np.abs(z), 1.0)
        return float(-objective @ z), float(right @ y - defect)

    def refine(self) -> None:
        """Move the solution that stands in the problem onto its vertex, see `on_vertex`."""
        names, constraints = self.problem.var_dict, self.problem.constraints
        matrix, right, objective, z, y = self._program()
        z, y = on_vertex(matrix, right, objective, z, y)
        for variable, part in zip(names.values(), np.split(z, np.cumsum([v.size for v in names.values()])[:-1]), strict=True):
            variable.save_value(part.reshape(variable.shape))
        for constraint, part in zip(constraints, np.split(y, np.cumsum([c.size for c in constraints])[:-1]), strict=True):
            constraint.dual_variables[0].save_value(part.reshape(constraint.shape))

    def _program(self) -> tuple[Array, Array, Array, Array, Array]:
        """`max objective @ z` subject to `matrix @ z >= right`, with the z and the multipliers that stand in the problem."""
        variables, data = self.problem.var_dict, {name: parameter.value for name, parameter in self.problem.param_dict.items()}
        width = {name: variable.size for name, variable in variables.items()}
        shear, lift = self._interface.shear[self._node], data["friction"][:, None] * self._interface.normal[self._node]
        blocks: list[tuple[dict[str, Array], Array]] = [
            ({"traction": lift + shear, "load_factor": -data["forward"]}, -(data["g_mean"] + data["q_mean"])),
            ({"traction": lift - shear, "load_factor": -data["backward"]}, -(data["g_mean"] - data["q_mean"])),
        ]
        if "opening" in data:
            blocks.append(({"traction": self._interface.normal[self._node], "load_factor": -data["opening"]}, -data["p_mean"]))
        blocks.append(({"traction": -data["apex_rows"], "load_factor": data["apex_cyclic"], "excess": np.ones(2)}, data["apex_mean"]))
        if self._bound is not None:
            slip, rigid, most = self._bound.rows
            blocks += [({"traction": side * slip, "slide": side * rigid, "excess": np.ones(len(most))}, -most) for side in (-1.0, 1.0)]
        blocks += [({name: np.ones(1)}, np.zeros(1)) for name in ("load_factor", "excess") if name in variables]
        matrix = np.vstack(
            [
                np.hstack([part.get(name, np.zeros((len(right), size))).reshape(len(right), size) for name, size in width.items()])
                for part, right in blocks
            ]
        )
        target = "excess" if "excess" in variables else "load_factor"
        objective = np.concatenate([np.full(size, -1.0 if name == target else 0.0) for name, size in width.items()])
        z = np.concatenate([np.atleast_1d(variable.value) for variable in variables.values()])
        y = np.concatenate([np.atleast_1d(constraint.dual_value) for constraint in self.problem.constraints])
        return matrix, np.concatenate([right for _, right in blocks]), objective, z, y


def apex_problem(interface: Interface, node: np.ndarray, opening: bool, bound: SlipBound | None = None, *, reach: bool = False) -> ApexProblem:
    """The least load factor at which the node is on both its bounds or, to reach them, the least excess at whatever load factor is best.

    Row r of the safe slips speaks for node `node[r]`.
    """
    load_factor = cp.Variable(name="load_factor")
    constraints = safe_rows(interface, node, opening, load_factor, 0.0)
    (traction,) = (variable for variable in constraints[0].variables() if variable.name() == "traction")
    apex_rows = cp.Parameter((2, traction.size), name="apex_rows")
    apex_mean, apex_cyclic = cp.Parameter(2, name="apex_mean"), cp.Parameter(2, name="apex_cyclic")
    excess = cp.Variable(name="excess") if reach else 0.0
    rows: dict[str, cp.Constraint] = {"on_both_bounds": apex_rows @ traction + apex_mean <= apex_cyclic * load_factor + excess}
    if bound is not None:
        slip, rigid, most = bound.rows
        slid = slip @ traction + (rigid @ cp.Variable(rigid.shape[1], name="slide") if rigid.shape[1] else 0.0)
        rows |= {"forward_slip_bound": slid <= most + excess, "backward_slip_bound": slid >= -most - excess}
    rows["load_factor_not_negative"] = load_factor >= 0
    if reach:
        rows["excess_not_negative"] = excess >= 0
    constraints += [row.set_label(name) for name, row in rows.items()]
    return ApexProblem(cp.Problem(cp.Minimize(excess if reach else load_factor), constraints), interface, node, bound)
