"""Nodes that the mean load leaves open, what they mean for a limit, and the certificate that none opens."""

from contextlib import suppress

import cvxpy as cp
import numpy as np

from ..base import RESIDUAL, Array, Booleans, SolveRecord
from ..contact import ContactSystem, LoadCycle
from ..contact.diagnosis import in_contact
from ..errors import ModelError, NoContinuation, SolverError
from .models import constant, least_pressure, printed_as, times, unknowns
from .programs import listed_rows
from .question import Question, pose

TOUCHES = 1e3 * RESIDUAL  # pressure, over the mean force, up to which a closed node wants to open
_BESIDE = 1.5  # distances of the nearest node within which others are its neighbours


def open_under_mean(question: Question, friction: Array | None = None) -> list[Booleans]:
    """(N,) which nodes the mean load leaves open, from no slip; no sets where none opens, or the load settles nowhere.

    With fixed parts that differ: those that any corner leaves open at load factor 0, and those that
    all corners do. `friction` stands for that of the question.
    """
    from ..transients.march import open_at_rest  # here, because a closed contact needs none

    friction = question.friction if friction is None else friction
    found = list[Booleans]()
    for loads in question.cycle.unscaled if question.fixed else question.cycle.unscaled[:1]:
        with suppress(ModelError, NoContinuation):
            found.append(
                open_at_rest(question.system, LoadCycle(loads, question.cycle.corners), friction)
            )
    found += [np.logical_and.reduce(found)] if found else []
    return [
        np.array(opened)
        for opened in sorted({tuple(each.tolist()) for each in found}, reverse=True)
        if any(opened)
    ]


def border(system: ContactSystem, opened: Booleans, node: int, p: Array) -> str:
    """What a limit that a node beside open ones governs says of the mesh (pressure there is 0, or highest at an edge); p (K, N) at the limit."""
    apart = np.linalg.norm(system.points - system.points[node], axis=1)
    apart[node] = np.inf
    pressure = p.min(axis=0) / (1.0 if system.width is None else system.width)
    if (
        opened[node]
        or apart[opened].min(initial=np.inf) > _BESIDE * apart.min()
        or pressure[node] > pressure[~opened].mean()
    ):
        return ""
    where = f"node {node}{in_contact(system, node)} beside the open ones"
    return f"; {where} governs, where pressure falls to zero: the limit belongs to the mesh, and falls as elements shrink there"


def stays_closed(question: Question, load_factor: float) -> bool:
    """Whether each node's least normal force is proven positive (`ShakedownLimit.stays_closed`), by one convex program each, least pressed first.

    Then no slip that friction holds takes the pressure off a node, at any load of the cycle.
    The loads are means of the mean load and of the corners: `r0 + sum of shares[k] r1_k`, with
    shares that sum to the load factor at most.
    """
    asked = pose(question.system, LoadCycle(question.cycle.mean, [{}]), question.friction)
    x = unknowns(question.system.slip_shape, [0], cp.Parameter(name="none", value=0.0))
    shares = [cp.Variable(name=f"share[{k}]") for k in range(len(question.r1))]
    node, f = (
        cp.Parameter(question.system.nodes, nonneg=True, name=name) for name in ("node", "f")
    )
    q1, p1 = (
        [constant(part, f"{name}[{k}]") for k, part in enumerate(parts)]
        for name, parts in zip(("q1", "p1"), (question.q1, question.p1), strict=True)
    )
    more = [
        printed_as(sum(map(times, shares, parts), start=cp.Constant(0)), f"shares * {name}1")
        for name, parts in (("q", q1), ("p", p1))
    ]
    program = listed_rows(asked, x, f, every=True, more={0: more})
    program.compiled(
        least_pressure(x, node, shares, load_factor, program.rows),
        question.force,
        dict.fromkeys(shares, question.load_unit),
    )

    def judged() -> SolveRecord:
        return SolveRecord(residual=program.chain.proof.gap)

    for index in np.argsort(question.r0[:, -1].min(axis=0)):
        node.value = np.eye(1, question.system.nodes, index)[0]
        try:
            program.chain.solve(judged)
        except SolverError:  # without a proof nothing is claimed
            return False
        if not program.chain.proof.bound - program.chain.proof.defect > RESIDUAL * question.force:
            return False
    return True
