"""The nodes that the mean load leaves open, and the proof that no node opens."""

from collections.abc import Iterator
from contextlib import suppress

import cvxpy as cp
import numpy as np

from ..base import COUNTS, RESIDUAL, Array, Booleans, SolveRecord
from ..contact import LoadCycle
from ..errors import ModelError, NoContinuation, SolverError
from .models import constant, least_pressure, printed_as, times, unknowns
from .programs import Program, listed_rows
from .question import Question, pose

# A closed node tends to open if its pressure is at most this share of the mean force. An open node
# tends to close if its gap is at most this share of the clearance.
TOUCHES = COUNTS


def open_under_mean(question: Question, friction: Array | None = None) -> list[Booleans]:
    """Masks (N,) of the nodes that the mean load, applied without slip before, leaves open.

    The list is empty if no node opens, or if the contact finds no state of rest. If fixed parts
    differ, there is a mask for each corner at load factor 0, and one of the nodes that all corners
    leave open. `friction` replaces the friction of the question.
    """
    # Imported here, because a closed contact does not need it.
    from ..transients.march import open_at_rest

    if friction is None:
        friction = question.friction
    loads_at_zero = question.cycle.unscaled if question.fixed else question.cycle.unscaled[:1]
    sets = list[Booleans]()
    for loads in loads_at_zero:
        cycle = LoadCycle(loads, question.cycle.corners)
        with suppress(ModelError, NoContinuation):
            sets.append(open_at_rest(question.system, cycle, friction))
    if sets:
        sets.append(np.logical_and.reduce(sets))
    different = {tuple(opened.tolist()) for opened in sets}
    return [np.array(opened) for opened in sorted(different, reverse=True) if any(opened)]


def is_safe_at_mean_load(question: Question, slip: Array | None) -> bool:
    """Whether one of the likely slips, `slip` among them, is safe under the mean load alone."""
    return any(
        question.violation(0.0, likely) <= RESIDUAL for likely in _likely_slips(question, slip)
    )


def _likely_slips(question: Question, slip: Array | None) -> Iterator[Array]:
    """Zero, the slip given, and the slip after the mean load is applied in one step."""
    yield np.zeros(question.system.slip_shape)
    if slip is not None:
        yield slip
    # Imported here, because one of the slips above is usually safe.
    from ..transients.march import mean_state

    with suppress(ModelError, NoContinuation, SolverError):
        yield mean_state(question.system, question.cycle, question.friction, steps=1).slip


def stays_closed(question: Question, load_factor: float) -> bool:
    """Whether all nodes stay pressed under any slip that friction can hold, proven for each node.

    See `ShakedownLimit.stays_closed`. One convex program for each node minimizes its normal force
    over all slips and loads. The loads are `r0 + sum of shares[k] r1_k`: the shares are >= 0, and
    their sum is at most the load factor. Nodes with little pressure come first, because they decide
    most often.
    """
    system = question.system
    node = cp.Parameter(system.nodes, nonneg=True, name="node")
    shares = [cp.Variable(name=f"share[{k}]") for k in range(len(question.r1))]
    program = _program_of_pressure(question, node, shares, load_factor)
    chain = program.chain
    for index in np.argsort(question.r0[:, -1].min(axis=0)):
        node.value = np.eye(1, system.nodes, index)[0]
        try:
            chain.solve(lambda: SolveRecord(residual=chain.proof.gap))
        except SolverError:
            return False
        if not chain.proof.bound - chain.proof.defect > RESIDUAL * question.force:
            return False
    return True


def _program_of_pressure(
    question: Question, node: cp.Parameter, shares: list[cp.Variable], load_factor: float
) -> Program:
    """The program of the least normal force of the marked node, at unknown shares of the corners.

    `node` is 1 at the marked node, 0 elsewhere.
    """
    at_mean = pose(question.system, LoadCycle(question.cycle.mean, [{}]), question.friction)
    x = unknowns(question.system.slip_shape, [0], cp.Parameter(name="none", value=0.0))
    f = cp.Parameter(question.system.nodes, nonneg=True, name="f")
    loads = []
    for name, parts in (("q", question.q1), ("p", question.p1)):
        constants = [constant(part, f"{name}1[{k}]") for k, part in enumerate(parts)]
        total = sum(map(times, shares, constants), start=cp.Constant(0))
        loads.append(printed_as(total, f"shares * {name}1"))
    program = listed_rows(at_mean, x, f, every=True, more={0: loads})
    goal = least_pressure(x, node, shares, load_factor, program.rows)
    return program.compiled(goal, question.force, dict.fromkeys(shares, question.load_unit))
