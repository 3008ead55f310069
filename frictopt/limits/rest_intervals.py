"""Load factors at which an uncoupled contact has a state of rest, if they scale normal loads, too.

If slip changes no pressure (B = 0), loads alone open and close nodes. The axis of the load factor
falls into pieces, each with one order of openings and closings (`normal_path.py`). The *rim*
consists of the nodes that are open at some time. In a piece, the equations of the rim and an
ordinary question give one interval with states of rest, or none. The loads of this question are
affine in the load factor (theory, "Normal loads that are scaled, too"). `rests` joins the
intervals; the end of the first interval is the shakedown limit.

In an ordinary question the same nodes are open at all corners. The limit of the ordinary question
is the limit of the contact whose areas move, and its answer is completed for all instants:

- The nodes that never open have the stiffness of a contact whose rim follows them. The slip that
  the equations of the rim give adds to the loads of these nodes.
- The shear forces of the rim are linear in the load factor alone. The nodes of the rim have no
  stiffness here, so their slip changes nothing.
- If the equations of the rim have no solution, the shear forces that stay unbalanced act on nodes
  without pressure. So the limit is 0, or only one load factor is safe, or no load factor is safe.

A state of rest exists at a load factor if and only if the ordinary question has a safe slip there.
For one given load factor this also holds if the load factor scales normal loads, or if fixed parts
differ between the corners: the load factor then decides which nodes open and close, and when.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from ..base import CONDENSATION, RESIDUAL, Array, Integers, LimitKind
from ..contact import ContactSystem, LoadCycle
from ..errors import SolverError
from .answers.answered import Proven
from .answers.reasons import reason_of_last_rest
from .answers.shakedown_answer import ShakedownAnswer
from .moving.moving_areas import (
    MovingAreas,
    areas_if_moving,
    areas_near,
    holds_for_all_openings,
    moving_areas,
)
from .moving.normal_path import NoPath
from .program.question import Question, pose_like, vertices_of_hull, with_open
from .program.solution import Mechanism

L = TypeVar("L", bound=ShakedownAnswer)
P = TypeVar("P", bound=Proven)


def ordinary_question(areas: MovingAreas) -> tuple[Question, Integers]:
    """The ordinary question, and for each node the instants (J, N) that serve as the J corners.

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
    # A node without rows gets no shear, and so much pressure that its reserve allows a margin of 1.
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
    question = pose_like(areas, cycle, friction, reduced)
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
    """(2, M, t, N) shear forces if the nodes that never open do not slip.

    Index 0 is the part at load factor 0, index 1 the rate with the load factor. Forces that the
    equations of the rim leave unbalanced are scaled to the size of the loads, because even if they
    are small, no state of rest has them.
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

    Nodes without pressure have no row, apart from nodes whose equations have no solution.
    """
    statuses = areas.at_instant
    rows = statuses.before & statuses.after
    rows[:, areas.rim.nodes] |= areas.unsolved.any(axis=(0, 2))
    return rows


def _decisive(areas: MovingAreas, shear: Array, rows: Array, node: int) -> Integers:
    """The instants at which a node can govern, among those at which it has a row.

    The node cannot govern at an instant if its shear force is a mean of its shear forces at other
    instants, and its pressure is at least the same mean of its pressures at these instants.
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
        # One more point, of high pressure, leaves only vertices of low pressure on the hull.
        high = points.mean(axis=0)
        high[-2] = pressure.max() + np.ptp(pressure[:, 0]) + areas.force
        points = np.vstack([points, high])
    vertices = np.array(vertices_of_hull(points))
    return np.asarray(instants[vertices[vertices < len(instants)]])


def on_all_instants(answer: P, areas: MovingAreas, instants: Integers) -> P:
    """The answer about moving areas, from the answer to their ordinary question.

    SolverError if the states under a safe slip violate the contact law at an instant by more than
    1e-9.
    """
    load_factor, slip = answer.load_factor, answer.slip
    residual = 0.0
    if answer._has_safe_slip:
        residual = areas.violation(load_factor, slip)
    if not residual <= RESIDUAL:
        raise SolverError(
            f"load factor {load_factor:g}: the states at the instants of the cycle are off by "
            f"{residual:.1e} (tolerance {RESIDUAL:g}); reactions or stiffnesses may differ too "
            "much in size"
        )
    motion = at_all_instants(answer._motion, areas, instants)
    record = replace(answer.record, residual=max(residual, answer.record.residual))
    if np.isfinite(load_factor):
        slip = areas.completed(load_factor, slip)
        areas = replace(areas, told_at=load_factor)
    return replace(answer, slip=slip, record=record, _question=areas, _motion=motion)


def at_all_instants(motion: Mechanism, areas: MovingAreas, instants: Integers) -> Mechanism:
    """The mechanism of an ordinary question, with its motions at the instants."""
    nodes = np.arange(areas.system.nodes)
    moves = np.zeros((len(areas.path.segment), *areas.r1.shape[1:]))
    for j, at in enumerate(instants):
        moves[at, :, nodes] += motion.moves[j].T
    return Mechanism(moves, areas.friction)


def moving_areas_at(question: Question, load_factor: float) -> MovingAreas | None:
    """The areas at a load factor, if loads alone open and close some nodes; else None.

    A contact without any friction has the same areas as with friction.
    """
    asked = question
    if not question.friction.any():
        asked = replace(question, friction=np.ones_like(question.friction))
    if not holds_for_all_openings(asked):
        return None
    return areas_if_moving(question, load_factor)


def safe_with_moving_areas(
    question: Question, load_factor: float, safe_slip_of: Callable[[Question, float], Any]
) -> Any:
    """The `SafeSlip`, if loads alone open and close nodes at the load factor; else None.

    The result is also None if no node has friction and no slip is safe.

    `safe_slip_of` returns the safe slip of an ordinary question. SolverError: see
    `on_all_instants`.
    """
    areas = moving_areas_at(question, load_factor)
    if areas is None:
        return None
    ordinary, instants = ordinary_question(areas)
    safe = safe_slip_of(ordinary, load_factor)
    if not safe.exists and not question.friction.any():
        # Without friction, nodes that press may slip in a state of rest.
        return None
    return on_all_instants(safe, areas, instants)


# Constants of the walk along the load factors.

# A piece is computed at this distance above its beginning, relative to the sum of the load factor
# and the load unit. A piece, or a hole between two intervals, that is shorter than this is missed.
_STEP = 1e-6
# Largest number of pieces for each node and corner: a node changes the order at few load factors.
_MOST_PIECES = 50
# Largest number of halvings of a step that has jumped over a short piece.
_HALVINGS = 8

# The limit of an ordinary question, up to a load factor.
LimitOf = Callable[[Question, float], L]


@dataclass(frozen=True, eq=False)
class Rest(Generic[L]):
    """Load factors with a state of rest, from `least` to `largest`.

    `areas` is the piece in which the load factors end; `limit` is the limit of its ordinary
    question, None if no program was needed. If the load factors end where this piece ends,
    `following` is the next piece, if any; it begins with load factors without a state of rest.
    """

    least: float
    largest: float
    slip: Array
    areas: MovingAreas
    limit: L | None
    following: MovingAreas | None = None

    @property
    def ends_with_piece(self) -> bool:
        """Whether the states of rest reach the end of their piece."""
        return self.largest >= self.areas.path.high


def pieces(question: Question, begin: float = 0.0) -> Iterator[MovingAreas]:
    """The pieces of the load factors above `begin`, until a body lifts off.

    SolverError if the pieces do not end.
    """
    nodes = question.system.nodes
    for _ in range(_MOST_PIECES * nodes * len(question.r1)):
        step = _STEP * (begin + question.load_unit)
        for _ in range(_HALVINGS):
            try:
                areas = areas_near(question, begin + step)
            except NoPath:
                return
            if areas.path.low <= begin + _STEP**2 * (begin + question.load_unit):
                break
            step /= 2
        yield areas
        if np.isinf(areas.path.high):
            return
        begin = max(areas.path.high, begin + step)
    raise SolverError(
        "the load factors at which nodes open and close in another order do not end; check for "
        "reactions of very different sizes"
    )


def rests(question: Question, limit_of: LimitOf[L], begin: float = 0.0) -> Iterator[Rest[L]]:
    """The intervals of load factors above `begin` with states of rest, in their order."""
    slip = np.zeros(question.system.slip_shape)
    current: Rest[L] | None = None
    for areas in pieces(question, begin):
        found = _rest_in(question, areas, slip, limit_of)
        if current is not None:
            if found is None or not _joins(current, found):
                yield replace(current, following=areas)
            else:
                found = replace(found, least=current.least)
        current = found
        if current is not None:
            slip = current.slip
            if not current.ends_with_piece:
                yield current
                current = None
    if current is not None:
        yield current


def _joins(current: Rest[L], following: Rest[L]) -> bool:
    """Whether the states of rest go on in the next piece."""
    hole = following.least - current.largest
    return hole <= 2 * _STEP * (current.largest + current.areas.load_unit)


def _rest_in(
    question: Question, areas: MovingAreas, slip: Array, limit_of: LimitOf[L]
) -> Rest[L] | None:
    """The load factors with a state of rest in a piece; None if there are none.

    If the slip of the last piece is safe at both ends of this piece, it is safe between them, and
    no program is needed.
    """
    low, high = areas.path.low, areas.path.high
    if not _rim_may_rest(areas):
        return None
    if np.isfinite(high) and not areas.unsolved.any():
        if max(areas.violation(end, slip) for end in (low, high)) <= RESIDUAL:
            return Rest(low, high, slip, areas, None)
    limit = limit_of(_ordinary(question, areas), np.inf)
    if limit.kind is LimitKind.NO_SAFE_SLIP:
        return None
    least = max(limit.least, low)
    largest = min(limit.load_factor, high)
    if np.isfinite(largest):
        rounding = RESIDUAL * (largest + areas.load_unit)
        largest = high if largest >= high - rounding else largest
        least = low if least <= low + rounding else least
    if not least <= largest:
        return None
    if limit.kind is LimitKind.FINITE:
        slip = limit.slip
    return Rest(least, largest, slip, areas, limit)


def _ordinary(question: Question, areas: MovingAreas) -> Question:
    """The ordinary question of a piece; if no node opens or closes, its open nodes stay open."""
    if not areas.at_instant.touching.any():
        opened = with_open(question, areas.open_nodes)
        if opened is not None:
            return opened
    return ordinary_question(areas)[0]


def _rim_may_rest(areas: MovingAreas) -> bool:
    """Whether the equations of the rim have a solution somewhere in the piece."""
    constant, rate = areas.unsolved
    if not rate.any():
        return not constant.any()
    at = -float((constant * rate).sum() / (rate * rate).sum())
    left = np.abs(constant + at * rate).max()
    size = np.abs(constant).max() + abs(at) * np.abs(rate).max()
    return bool(areas.path.low <= at <= areas.path.high and left <= np.sqrt(RESIDUAL) * size)


def limit_of_moving_areas(question: Question, limit_of: LimitOf[L]) -> L | None:
    """The limit of all states of rest, if normal loads alone open and close nodes; else None.

    See `moving_areas`. The contact is uncoupled then, and the load factor scales shear alone.
    """
    areas = moving_areas(question)
    if areas is None:
        return None
    ordinary, instants = ordinary_question(areas)
    return on_all_instants(limit_of(ordinary, np.inf), areas, instants)


def up_to_last_rest(question: Question, limit: L, limit_of: LimitOf[L]) -> L:
    """The limit at the end of the first interval of load factors with states of rest.

    `limit` has nodes that stay open or closed. It is returned unchanged if `knows_all_pieces` is
    False, if it is infinite from load factor 0 on, if neither the mean load nor a small cyclic load
    presses a node, or if there is no state of rest.
    """
    if not knows_all_pieces(question):
        return limit
    if limit.least == 0:
        if limit.load_factor == np.inf:
            return limit
        return replace(_extended(question, limit, limit_of), _ends_rests=True)
    # The limit belongs to a later interval, or no load factor has a state of rest.
    first = next(pieces(question), None)
    if first is None or first.open_nodes.all():
        return limit
    rest = next(rests(question, limit_of), None)
    if rest is None:
        return limit
    return replace(_limit_of_rest(question, rest, limit_of), _ends_rests=True)


def _extended(question: Question, limit: L, limit_of: LimitOf[L]) -> L:
    """A finite limit itself, or the end of the states of rest that go on above it."""
    end = limit.load_factor
    pressures = (question.r0 + end * question.r1)[:, -1]
    if pressures.min() > RESIDUAL * question.force:
        # No node opens near the limit.
        return limit
    following = next(pieces(question, end), None)
    if following is None:
        return replace(limit, _why=reason_of_last_rest(limit, None, lifted=True))
    if following.path.low < end - _STEP * (end + question.load_unit):
        # The order of openings and closings is the same above the limit.
        return limit
    rest = next(rests(question, limit_of, end), None)
    if rest is None or rest.least > end + 2 * _STEP * (end + question.load_unit):
        return replace(limit, _why=reason_of_last_rest(limit, following, lifted=False))
    return _limit_of_rest(question, replace(rest, least=limit.least), limit_of)


def _limit_of_rest(question: Question, rest: Rest[L], limit_of: LimitOf[L]) -> L:
    """The limit at the end of an interval with states of rest."""
    limit = rest.limit
    if limit is None or limit.load_factor > rest.largest:
        limit = limit_of(_ordinary(question, rest.areas), rest.largest)
    if rest.areas.at_instant.touching.any():
        _, instants = ordinary_question(rest.areas)
        limit = on_all_instants(limit, rest.areas, instants)
    limit = replace(limit, least=rest.least)
    lifted = rest.ends_with_piece and rest.following is None
    return replace(limit, _why=reason_of_last_rest(limit, rest.following, lifted))


def knows_all_pieces(question: Question) -> bool:
    """Whether a contact is uncoupled, and the load factor scales normal loads and all that varies.

    See `holds_for_all_openings`. The loads at load factor 0 must be the same at all corners.
    """
    if question.fixed or not question.bonded[1][:, -question.system.nodes :].any():
        return False
    return holds_for_all_openings(question)
