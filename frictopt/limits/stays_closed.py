"""The certificate that a contact stays closed: no slip that friction holds takes the pressure off a node, at any load of the cycle."""

import cvxpy as cp
import numpy as np

from ..contact import RESIDUAL, LoadCycle, SolveRecord
from ..errors import SolverError
from .models import called, least_pressure, named, times, unknowns
from .programs import listed_rows
from .question import Question, pose


def stays_closed(task: Question, load_factor: float) -> bool:
    """Whether each node's least normal force is proven positive (`ShakedownLimit.stays_closed`), by one convex program each, least pressed first.

    The loads are means of the mean load and of the corners: `r0 + sum of shares[k] r1_k`, with shares that sum to the load factor at most.
    """
    asked = pose(task.system, LoadCycle(task.cycle.mean, [{}]), task.friction)
    x = unknowns(task.system.slip_shape, [0], cp.Parameter(name="none", value=0.0))
    shares = [cp.Variable(name=f"share[{k}]") for k in range(len(task.r1))]
    node, f = (cp.Parameter(task.system.nodes, nonneg=True, name=name) for name in ("node", "f"))
    q1, p1 = ([named(part, f"{name}[{k}]") for k, part in enumerate(parts)] for name, parts in zip(("q1", "p1"), task.parts[2:], strict=True))
    more = [called(sum(map(times, shares, parts), start=cp.Constant(0)), f"shares * {name}1") for name, parts in (("q", q1), ("p", p1))]
    program = listed_rows(asked, x, f, every=True, more={0: more})
    program.compiled(least_pressure(x, node, shares, load_factor, program.rows), task.force, dict.fromkeys(shares, task.load_unit))

    def judged() -> SolveRecord:
        return SolveRecord(residual=program.chain.proof.gap)

    for index in np.argsort(task.r0[:, -1].min(axis=0)):
        node.value = np.eye(1, task.system.nodes, index)[0]
        try:
            program.chain.solve(judged)
        except SolverError:  # without a proof nothing is claimed
            return False
        if not program.chain.proof.bound - program.chain.proof.defect > RESIDUAL * task.force:
            return False
    return True
