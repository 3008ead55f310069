"""The load factors at which one node sits on both its bounds while the slip is safe, as a cvxpy problem with the node as a parameter.

The slip is safe at every node, and the rows of one node are equations: with `k+` and `k-` the corners that rule its forward and its backward slip::

    min lam    s.t.   v safe at lam,   q = -f p of node i at corner k+,   q = +f p of node i at corner k-,   abs(v) <= slip bound

Where there is no such slip, a second problem proves it: the least excess of the node's rows over what equations would allow, and of the slips over
their bound, is positive. A third one finds how far up such slips go, `max lam` up to the load unit: at load factor 0 all corners coincide, and a node
that carries nothing there is on both bounds whatever the cyclic load does.
"""

from enum import Enum

import cvxpy as cp
import numpy as np

from .ruling_corners import LoadRows
from .safe_set import SafeProblem, safe_rows
from .scaling import Interface
from .slip_bound import SlipBound

__all__ = ["Aim", "apex_problem", "set_apex"]


class Aim(Enum):
    """What is looked for among the slips that hold a node on both its bounds."""

    LEAST = "least load factor"
    EXCESS = "least excess over equations and slip bound, at whatever load factor is best"
    HIGHEST = "largest load factor, at most the load unit"


def apex_problem(interface: Interface, opening: bool, bound: SlipBound | None, aim: Aim) -> SafeProblem:
    """The problem of one node at a time; `set_apex` sets its parameters."""
    load_factor, excess = cp.Variable(name="load_factor"), cp.Variable(name="excess") if aim is Aim.EXCESS else 0.0
    constraints = safe_rows(interface, opening, load_factor, bound=bound, excess=excess)
    (traction,) = (variable for variable in constraints[0].variables() if variable.name() == "traction")
    apex_rows = cp.Parameter((2, traction.size), name="apex_rows")
    apex_mean, apex_cyclic = cp.Parameter(2, name="apex_mean"), cp.Parameter(2, name="apex_cyclic")
    rows: dict[str, cp.Constraint] = {"on_both_bounds": apex_rows @ traction + apex_mean <= apex_cyclic * load_factor + excess}
    rows["load_factor_not_negative"] = load_factor >= 0
    if aim is Aim.EXCESS:
        rows["excess_not_negative"] = excess >= 0
    if aim is Aim.HIGHEST:
        rows["load_factor_at_most_1"] = load_factor <= 1
    constraints += [row.set_label(name) for name, row in rows.items()]
    goals = {Aim.LEAST: cp.Minimize(load_factor), Aim.EXCESS: cp.Minimize(excess), Aim.HIGHEST: cp.Maximize(load_factor)}
    return SafeProblem(cp.Problem(goals[aim], constraints), interface, bound)


def set_apex(model: SafeProblem, rows: LoadRows, node: int) -> None:
    """Set friction and loads by `rows`, and the node whose rows become equations."""
    model.set(rows)
    values, interface = model.problem.param_dict, model.interface
    lift, shear = rows.friction[node] * interface.normal[node], interface.shear[node]
    values["apex_rows"].value = np.vstack([lift + shear, lift - shear])
    values["apex_mean"].value = np.array([rows.g_mean[node] + rows.q_mean[node], rows.g_mean[node] - rows.q_mean[node]])
    values["apex_cyclic"].value = np.array([rows.forward[node], rows.backward[node]])
