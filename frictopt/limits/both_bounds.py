"""The load factors at which one node is on both its bounds while the slip is safe, as a cvxpy problem with the node as a parameter.

The slip is safe at every node, see `shakedown_problem`. The rows of one node are equations: with `k+` and `k-` the corners that rule its forward and
its backward slip::

    min lam    s.t.   v safe at lam,   q = -f p of node i at corner k+,   q = +f p of node i at corner k-,   abs(v) <= slip bound

If no such slip exists, a second problem proves it: it minimises the largest violation of the node's equations, and the minimum is positive. A third
problem finds the largest load factor of such slips, up to a load unit above the least safe one. It is needed where the least one of a node is the
least safe load factor of the contact. At 0 all corners coincide, and a node without reaction is on both bounds whatever the cyclic load is; at one
above 0 the corners press no node more than its shear needs, so that some node is on both bounds. Either may be so at that load factor alone.
"""

from dataclasses import replace
from enum import Enum

import cvxpy as cp
import numpy as np

from .program import SafeProgram

__all__ = ["Aim", "both_bounds_problem", "set_node"]


class Aim(Enum):
    """What is looked for among the slips that hold a node on both its bounds."""

    LEAST = "least load factor"
    EXCESS = "least excess over the equations, at whatever load factor is best"
    HIGHEST = "largest load factor, up to a given one"


def both_bounds_problem(safe: SafeProgram, aim: Aim) -> SafeProgram:
    """The problem of one node at a time over the safe slips of a `shakedown_problem`; `set_node` sets its parameters."""
    excess = cp.Variable(name="excess") if aim is Aim.EXCESS else 0.0
    lam, traction = safe.v.load_factor, safe.v.traction
    node_rows = cp.Parameter((2, traction.size), name="node_rows")  # (f B + A) and (f B - A) of the node
    node_mean, node_cyclic = cp.Parameter(2, name="node_mean"), cp.Parameter(2, name="node_cyclic")
    rows: dict[str, cp.Constraint] = {"on_both_bounds": node_rows @ traction + node_mean <= node_cyclic * lam + excess}
    if aim is Aim.EXCESS:
        rows["excess_not_negative"] = excess >= 0
    if aim is Aim.HIGHEST:
        rows["load_factor_at_most"] = lam <= cp.Parameter(nonneg=True, name="most_load_factor")
    goal = {Aim.LEAST: cp.Minimize(lam), Aim.EXCESS: cp.Minimize(excess), Aim.HIGHEST: cp.Maximize(lam)}[aim]
    constraints = [*safe.problem.constraints, *(row.set_label(name) for name, row in rows.items())]
    return replace(safe, problem=cp.Problem(goal, constraints))


def set_node(program: SafeProgram, node: int, corners: tuple[int, int]) -> None:
    """Set the node whose rows become equations, those of its forward slip at one corner and of its backward slip at another."""
    values, scaled, loads, sense = program.problem.param_dict, program.v.scaled, program.task.loads, np.array([1.0, -1.0])
    friction, unit = program.task.friction[node], scaled.unit[node]
    lift, shear = friction * scaled.normal[node], scaled.shear[[node]].toarray()[0]
    at = list(corners) if loads.fixed else [0, 0]
    values["node_rows"].value = np.vstack([lift + shear, lift - shear])
    values["node_mean"].value = friction * loads.p0[at, node] / unit + sense * (loads.q0[at, node] / unit)
    cyclic = sense * loads.q1[list(corners), node] + friction * loads.p1[list(corners), node]
    values["node_cyclic"].value = -cyclic * program.task.load_unit / unit
