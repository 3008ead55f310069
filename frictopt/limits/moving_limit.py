"""The limit of contact areas that move: an ordinary question, and its answer for all instants.

- The nodes that never open have the stiffness that the rim leaves them. The slip of the rim, which
  its equations give, adds to their loads.
- The shear forces of the rim are linear in the load factor alone. Its nodes have no stiffness here,
  so their slip changes nothing.
- If the equations of the rim have no solution, the forces that they leave act on nodes without
  pressure. So the limit is 0, or only one load factor is safe, or no load factor is safe.

A state of rest exists at a load factor if and only if the ordinary question has a safe slip there.
At a given load factor this is so, too, if it scales normal loads, and if fixed parts differ between
the corners: it then decides which nodes open and close, and when.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from ..base import CONDENSATION, RESIDUAL, Array, Integers, LimitKind, SolveRecord
from ..contact import ContactSystem, LoadCycle
from ..errors import SolverError
from .corners import vertices_of_hull
from .mechanism import Mechanism
from .moving_areas import MovingAreas, areas_at, holds_for_all_openings
from .normal_path import NoPath
from .question import Question, pose
from .shakedown_answer import ShakedownAnswer

L = TypeVar("L", bound=ShakedownAnswer)


def ordinary_question(areas: MovingAreas) -> tuple[Question, Integers]:
    """The ordinary question, and the instants (J, N) that its J corners are at each node.

    Each node has only the instants at which it can govern, which differ from node to node.
    """
    shear = _shear(areas)
    rows = _rows(areas)
    by_node = [_decisive(areas, shear, rows[:, node], node) for node in range(len(rows.T))]
    longest = max(map(len, by_node))
    repeated = [np.r_[part, np.full(longest - len(part), part[-1])] for part in by_node]
    instants = np.transpose(repeated)

    nodes = np.arange(len(by_node))
    pressure = areas.path.pressure[:, instants, nodes]  # (2, J, N)
    q = np.moveaxis(shear, 2, -1)[:, instants, nodes].swapaxes(2, 3)  # (2, J, t, N)
    # A node without rows is as if it were pressed without shear, with the reserve of a margin of 1.
    idle = ~rows.any(axis=0)
    q[..., idle] = 0.0
    pressure[0][:, idle] = max(areas.force, areas.mean_bound)
    pressure[1][:, idle] = 0.0
    friction = np.where(idle, 1.0, areas.friction)
    loads = dict[str, Array]()
    for j in range(longest):
        loads[f"fixed[{j}]"] = np.r_[q[0, j].ravel(), pressure[0, j]]
        loads[f"scaled[{j}]"] = np.r_[q[1, j].ravel(), pressure[1, j]]
    system = areas.system
    reduced = ContactSystem(
        _stiffness(areas),
        system.points,
        loads,
        frames=system.frames,
    )
    cycle = LoadCycle(
        {},
        [{f"scaled[{j}]": 1.0} for j in range(longest)],
        fixed=[{f"fixed[{j}]": 1.0} for j in range(longest)],
    )
    question = pose(reduced, cycle, friction, simplify=areas.simplify)
    # Margins have the units of the whole contact, whichever instants govern.
    mean_pressure = np.where(idle, areas.mean_bound, areas.mean_pressure)
    question = replace(question, mean_bound=areas.mean_bound, mean_pressure=mean_pressure)
    return question, instants


def _stiffness(areas: MovingAreas) -> Array:
    """(M, M) stiffness of the nodes that never open; the rim follows them."""
    inner, rim = areas.entries
    across = areas.A[np.ix_(inner, rim)]
    left = areas.A[np.ix_(inner, inner)] - across @ areas.rim_compliance @ across.T
    S = np.diag(np.r_[np.zeros(len(areas.A)), np.diag(areas.system.C)])
    S[np.ix_(inner, inner)] = (left + left.T) / 2
    return S


def _shear(areas: MovingAreas) -> Array:
    """(2, M, t, N) shear forces without slip of the nodes that never open.

    Index 0 is the part at load factor 0, index 1 the rate with the load factor. Residual forces of
    the equations of the rim are scaled to the size of the loads, because even small ones must be
    zero.
    """
    loads = areas.bonded_at_instants[:, :, :-1]
    motion = np.zeros_like(loads)
    motion[..., areas.rim.nodes] = areas.rim.motion
    moved = motion.reshape(*motion.shape[:2], -1) @ areas.A
    shear = loads + moved.reshape(loads.shape)
    off = areas.unsolved
    part = 1 if off[1].any() else 0
    if off[part].any():
        size = np.abs(loads[1]).max() if part else areas.force
        off = off * (size / np.abs(off[part]).max())
    touching = areas.at_instant.touching[:, None, areas.rim.nodes]
    shear[..., areas.rim.nodes] = np.where(touching, off, areas.rim.shear)
    # Rounding must not bound a load factor, and must not separate instants with the same shear.
    rounding = CONDENSATION * np.abs(loads).max(axis=(1, 2, 3), keepdims=True)
    shear = np.where(np.abs(shear) > rounding, shear, 0.0)
    differs = np.ptp(shear, axis=1, keepdims=True) > rounding
    return np.where(differs, shear, shear[:, :1])


def _rows(areas: MovingAreas) -> np.ndarray:
    """(M, N) nodes that have a row at an instant.

    Nodes without pressure have none, apart from those whose equations have no solution.
    """
    statuses = areas.at_instant
    rows = statuses.before & statuses.after
    rows[:, areas.rim.nodes] |= areas.unsolved.any(axis=(0, 2))
    return np.asarray(rows)


def _decisive(areas: MovingAreas, shear: Array, rows: Array, node: int) -> Integers:
    """Instants at which a node can govern, of those at which it has a row.

    It cannot at an instant whose shear force is a mean of those of others, with no less pressure.
    """
    instants = np.flatnonzero(rows)
    if not len(instants):
        return np.zeros(1, dtype=int)
    pressure = areas.path.pressure[:, instants, node].T
    forces = shear[..., node][:, instants].swapaxes(0, 1).reshape(len(instants), -1)
    points = np.c_[forces, pressure]
    if areas.alone:
        if not np.ptp(forces, axis=0).any():
            return instants[[pressure[:, 0].argmin()]]
        # The hull with a point of high pressure has the vertices of less pressure, and this point.
        high = points.mean(axis=0)
        high[-2] = pressure.max() + np.ptp(pressure[:, 0]) + areas.force
        points = np.vstack([points, high])
    vertices = np.array(vertices_of_hull(points))
    return np.asarray(instants[vertices[vertices < len(instants)]])


def on_all_instants(limit: L, areas: MovingAreas, instants: Integers) -> L:
    """The limit of moving areas, from the limit of its ordinary question.

    SolverError if the states at the instants violate the contact law by more than 1e-9.
    """
    motion = at_all_instants(limit._motion, areas, instants)
    slip = limit.slip
    record = limit.record
    if limit.kind is LimitKind.FINITE:
        record = checked_at_instants("shakedown limit", areas, limit.load_factor, slip, record)
        slip = areas.completed(limit.load_factor, slip)
    told_at = limit.load_factor if limit.kind is LimitKind.FINITE else areas.told_at
    areas = replace(areas, told_at=told_at)
    return replace(limit, slip=slip, record=record, _question=areas, _motion=motion)


def checked_at_instants(
    question_name: str, areas: MovingAreas, load_factor: float, slip: Array, record: SolveRecord
) -> SolveRecord:
    """The record of a slip, with the violation of the contact law at the instants.

    SolverError if it is more than 1e-9.
    """
    residual = areas.violation(load_factor, slip)
    if not residual <= RESIDUAL:
        raise SolverError(
            f"{question_name}: the states at the instants of the cycle are off by {residual:.1e} "
            f"(tolerance {RESIDUAL:g}); reactions or stiffnesses may differ too much in size"
        )
    return replace(record, residual=max(residual, record.residual))


def at_all_instants(motion: Mechanism, areas: MovingAreas, instants: Integers) -> Mechanism:
    """The mechanism of an ordinary question, with its motions at the instants."""
    nodes = np.arange(areas.system.nodes)
    moves = np.zeros((len(areas.path.leg), *areas.r1.shape[1:]))
    for j, at in enumerate(instants):
        moves[at, :, nodes] += motion.moves[j].T
    return Mechanism(moves, areas.friction)


def moving_areas_at(question: Question, load_factor: float) -> MovingAreas | None:
    """The areas at a load factor, if loads alone open and close some nodes; else None.

    A contact without friction at all nodes has the areas that it has with friction.
    """
    asked = question
    if not question.friction.any():
        asked = replace(question, friction=np.ones_like(question.friction))
    if not holds_for_all_openings(asked):
        return None
    try:
        areas = areas_at(question, load_factor)
    except NoPath:
        return None
    return areas if areas.at_instant.touching.any() else None


def safe_with_moving_areas(
    question: Question, load_factor: float, safe_slip_of: Callable[[Question, float], Any]
) -> Any:
    """The `SafeSlip`, if loads alone open and close nodes at the load factor; else None.

    It is also None if no node has friction, and no slip is safe.

    `safe_slip_of` is the safe slip of an ordinary question. SolverError if the states at the
    instants of a safe slip violate the contact law by more than 1e-9.
    """
    areas = moving_areas_at(question, load_factor)
    if areas is None:
        return None
    ordinary, instants = ordinary_question(areas)
    safe = safe_slip_of(ordinary, load_factor)
    if not safe.exists and not question.friction.any():
        # Without friction a state of rest need not stop the slip of nodes that press.
        return None
    motion = at_all_instants(safe._motion, areas, instants)
    record = safe.record
    if safe.exists:
        record = checked_at_instants("safe slip", areas, load_factor, safe.slip, record)
    slip = areas.completed(load_factor, safe.slip)
    return replace(safe, slip=slip, record=record, _question=areas, _motion=motion)
