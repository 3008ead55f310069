"""The load factors at which one node is critical while the slip is safe at all others, as a cvxpy problem with the node as a parameter.

A node is critical where a safe slip leaves it no more pressure than it needs, see `critical_states`: in the plane it is on both its bounds, in space
on its friction circle at opposed corners, or at three that surround. With its rho and c::

    min lam    s.t.   p0 + B v = lam rho  and  q0 + A v = lam c  at node i,   v safe at lam at all other nodes,   |v| <= slip bound

Its own rows hold by construction, and are loose: without them the program has an interior. (Where a part of the cycle is fixed they need not hold,
and stay.) If no such slip exists, a second problem proves it: it
minimises the largest violation of the node's equations, and the minimum is positive. A third problem finds the largest load factor of such slips, up
to a load unit above the least safe one. It is needed where the least one of a node is the least safe load factor of the contact. At 0 all corners
coincide, and a node without reaction is critical whatever the cyclic load is; at one above 0 the corners press no node more than its shear needs, so
that some node is critical. Either may be so at that load factor alone.
"""

from dataclasses import replace
from enum import Enum

import cvxpy as cp
import numpy as np

from .critical_state import CriticalState
from .program import SafeProgram

__all__ = ["Aim", "critical_problem", "set_node"]


class Aim(Enum):
    """What is looked for among the slips with which a node is critical."""

    LEAST = "least load factor"
    EXCESS = "least excess over the equations, at whatever load factor is best"
    HIGHEST = "largest load factor, up to a given one"


def critical_problem(safe: SafeProgram, aim: Aim) -> SafeProgram:
    """The problem of one node at a time over the safe slips of a `shakedown_problem`; `set_node` sets its parameters."""
    lam, traction, task = safe.v.load_factor, safe.v.traction, safe.task
    axes = task.system.tangents + 1
    change = cp.Parameter((axes, traction.size), name="node_rows") @ traction  # [A v, B v] of the node
    off = change - cp.Parameter(axes, name="node_at_zero") - cp.Parameter(axes, name="node_rate") * lam
    excess = cp.Variable(name="excess")
    rows: dict[str, cp.Constraint] = {"critical": off == 0}
    if aim is Aim.EXCESS:
        rows = {"critical": off <= excess, "critical_from_below": off >= -excess}
    if aim is Aim.HIGHEST:
        rows["load_factor_at_most"] = lam <= cp.Parameter(nonneg=True, name="most_load_factor")
    stuck = {} if task.loads.fixed else safe.v.stuck(lam, spare=cp.Parameter(len(task.friction), name="spare", nonneg=True))
    others = [row for row in safe.problem.constraints if row.label not in stuck or any(row is own for own in safe.own)]
    goal = {Aim.LEAST: cp.Minimize(lam), Aim.EXCESS: cp.Minimize(excess), Aim.HIGHEST: cp.Maximize(lam)}[aim]
    return replace(safe, problem=cp.Problem(goal, [*others, *(row.set_label(name) for name, row in {**stuck, **rows}.items())]))


def set_node(program: SafeProgram, state: CriticalState) -> None:
    """Set the node that is critical."""
    task, scaled, n = program.task, program.v.scaled, len(program.task.friction)
    unit, values = scaled.unit[state.node], program.problem.param_dict
    values["node_rows"].value = np.vstack([scaled.shear[state.node :: n].toarray(), scaled.normal[state.node]])
    values["node_at_zero"].value, values["node_rate"].value = state.at_zero / unit, state.rate * task.load_unit / unit
    if "spare" in values:
        values["spare"].value = (np.arange(n) == state.node).astype(float)
