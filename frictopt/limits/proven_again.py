"""Answers that were read from a file are proven again, from the numbers of the file alone.

The contact law evaluates the slip, which bounds a limit from below. The slip mechanism bounds it
from above. Both need no solver.
"""

from __future__ import annotations

import numpy as np

from ..base import RESIDUAL, ROUNDING, Array
from .critical_state import critical_states
from .mechanism import Mechanism
from .question import Question
from .solved import Solved

# Another processor may round the residual of an answer to the other side of its tolerance.
_SLIP = 10 * RESIDUAL
# Relative to the terms of a mechanism, whose multipliers balance up to the tolerance of solvers.
_BALANCE = 1e-6


def check_slip(question: Question, load_factor: float, slip: Array) -> None:
    """Check that a slip is safe at a load factor; ValueError if it is not."""
    shape = question.system.slip_shape
    if slip.shape != shape:
        raise ValueError(f"its slip has the shape {slip.shape}, its contact needs {shape}")
    off = question.violation(load_factor, slip)
    # Margins are relative to friction bounds, which exceed the forces if friction is large.
    largest = max(1.0, question.mean_bound / question.force)
    if not off <= _SLIP * largest + _rounding(question, load_factor, slip):
        raise ValueError(
            f"its slip violates the contact law by {off:.1e} at the load factor {load_factor:g}"
        )


def _rounding(question: Question, load_factor: float, slip: Array) -> float:
    """Rounding of the forces, over the force unit; large friction may hold slips of any size."""
    _, r = question.instants(load_factor, slip)
    return ROUNDING * float(np.abs(r).max()) / question.force


def reserve_of(question: Question, load_factor: float, slip: Array) -> float:
    """The smallest reserve of a slip over nodes and corners, in the unit of the margin."""
    u, r = question.instants(load_factor, slip)
    sticks, opened = question.statuses
    q = np.linalg.norm(r[:, :-1], axis=1)
    p = r[:, -1]
    reserves = np.minimum(
        (question.friction * p - q) / question.mean_bound, p / question.mean_pressure
    )
    of_gaps = np.min(u[:, -1], where=opened, initial=np.inf) / question.clearance
    return float(np.min(reserves, where=sticks, initial=of_gaps))


def check_critical(question: Question, node: int, load_factor: float, slip: Array) -> None:
    """Check that a slip makes a node critical at a load factor; ValueError if it does not."""
    states = critical_states(question)[node]
    off = min((each.distance(question, load_factor, slip) for each in states), default=np.inf)
    if not off <= _SLIP + _rounding(question, load_factor, slip):
        raise ValueError(f"its slip leaves node {node} {off:.1e} away from its critical state")


def check_margin(
    question: Question, load_factor: float, slip: Array, margin: float, bound: float
) -> None:
    """Check that a slip has its margin, and that no slip has more; ValueError if not."""
    tolerance = _SLIP * max(1.0, abs(margin))
    # Nodes that open and close have no reserve at their events.
    if type(question) is Question:
        reserve = reserve_of(question, load_factor, slip)
        if not margin <= reserve + tolerance + _rounding(question, load_factor, slip):
            raise ValueError(f"its margin is {margin:g}, and the reserve of its slip {reserve:g}")
    if not abs(bound - margin) <= tolerance:
        raise ValueError(f"its margin is {margin:g}, and the bound of it {bound:g}")


def check_bound(question: Question, motion: Mechanism, load_factor: float, bound: float) -> None:
    """Check that a mechanism proves the bound of a limit; ValueError if it does not."""
    if not motion.moves.any() and not question.system.B.any():
        return  # Just above it, the loads of this uncoupled contact open and close nodes.
    proven = bound_of(question, motion)
    for name, value in (("load factor", load_factor), ("bound", bound)):
        if not abs(proven - value) <= _BALANCE * max(abs(value), question.load_unit):
            raise ValueError(f"its {name} is {value:g}, and its mechanism proves {proven:g}")


def check_growth(question: Question, solved: Solved) -> None:
    """Check that a slip may grow with the load without end; ValueError if it leaves the law."""
    rate = solved.values["load_factor"]
    # Beyond it, all forces that do not grow are below the residual.
    far = question.load_unit / RESIDUAL
    off = np.inf
    if rate > 0:
        slip = question.slip_at_mean_load(far / rate * solved.values["slip"])
        off = RESIDUAL * question.violation(far, slip)
    if not off <= _SLIP:
        raise ValueError(f"its slip grows with the load and leaves the contact law by {off:.1e}")


def check_contradiction(question: Question, motion: Mechanism) -> None:
    """Check that a mechanism proves that no slip is safe; ValueError if it does not."""
    if not bound_of(question, motion) < 0:
        raise ValueError("it has no safe slip, and its mechanism does not prove this")


def bound_of(question: Question, motion: Mechanism) -> float:
    """The load factor above which a mechanism proves that no slip is safe; nan if it proves none.

    If no load factor is safe, it is below 0.

    In a safe state the forces do no negative work on the mechanism: at a closed node friction times
    the pressure is at least the shear force, and the lift at least friction times the slip. Open
    nodes follow without force, and touch. The residual slip does no work, so that the work is that
    of the loads.
    """
    system = question.system
    normals = len(system.S) - system.nodes
    moves = motion.moves.reshape(len(motion.moves), -1)
    forces = moves @ system.S
    scale = _BALANCE * float((np.abs(moves) @ np.abs(system.S)).max(initial=0.0))
    opened = question.open_nodes
    of_opened = np.tile(opened, system.tangents)
    sheared = np.where(opened, 0.0, question.friction * motion.size - moves[:, normals:])
    sheared = sheared.clip(0.0)
    if not system.capped and (sheared > _BALANCE * np.abs(moves).max()).any():
        return np.nan
    unbalanced = (
        np.abs(forces.sum(axis=0)[:normals][~of_opened]).max(initial=0.0),
        np.abs(forces[:, :normals][:, of_opened]).max(initial=0.0),
        forces[:, normals:][:, opened].max(initial=0.0),
    )
    if max(unbalanced) > scale:
        return np.nan
    resistance = float((moves * question.at_instants(0.0)).sum()) + _work_of_shearing(
        question, sheared
    )
    drive = motion.drive(question)
    if drive > 0:
        return resistance / drive
    # Rounding may hide whether loads, which do no work on it, do negative work.
    return -np.inf if RESIDUAL * resistance < question.load_unit * drive else np.nan


def _work_of_shearing(question: Question, sheared: Array) -> float:
    """Work of the slips at which the surface shears off, whose lift is less by `sheared`."""
    if not question.system.capped:
        return 0.0
    slopes = np.where(question.friction > 0, question.friction, 1.0)
    strength = np.where(sheared.any(axis=0), question.system.shear_strength, 0.0)
    return float((sheared / slopes * strength).sum())
