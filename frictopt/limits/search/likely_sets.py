"""Sets of open nodes that are likely to be good: under the mean load, and next to a limit."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

import numpy as np

from ...base import COUNTS, RESIDUAL, Array, Booleans, Integers
from ...contact import LoadCycle
from ...errors import ModelError, NoContinuation, SolverError
from ...transients.statics import Statics
from ..answers.shakedown_answer import ShakedownAnswer
from ..program.question import Question

# A closed node tends to open if its pressure is at most this share of the mean force. An open node
# tends to close if its gap is at most this share of the clearance.
TOUCHES = COUNTS

# Numbers of the local searches of sets and of orders (`order_search.py`).

# The open nodes under the mean load are computed with the friction times each of these factors.
FRICTIONS = (1.0, 1.5, 0.7, 0.5, 0.35, 0.2, 0.1, 0.02)
# A node governs the limit if its motion in the mechanism is above this share of the largest motion.
_GOVERNS = 0.02
# The same share for a node that touches. Such a node is open and has no gap at some corner, or is
# closed and has no pressure at some corner. The motion of an open node is in the unit of its gap,
# and can be far smaller than the slips of closed nodes. A search of orders uses this share, too.
GOVERNS_TOUCHING = 1e-6
# Smallest relative gain of a limit that counts; a smaller one may be rounding.
GAIN = 1e-7
# Largest number of programs of one search.
PROGRAMS = 60
# Largest product of programs and unknown slips in a search of orders. A search of sets climbs
# from a second start if its product is still below this number.
WORK = 20_000
# In a closed contact of at most this many nodes, pressed nodes are opened, too. In space, if more
# nodes than this govern, they are opened or closed in groups.
_FEW = 16
_GROUP = 4


def open_under_mean(question: Question, friction: Array | None = None) -> list[Booleans]:
    """Masks (N,) of the nodes that the mean load leaves open in a contact without earlier slip.

    The list is empty if no node opens, or if no state of rest is found. If the fixed parts of the
    corners differ, there is a mask for each corner at load factor 0, and one of the nodes that all
    corners leave open. `friction` replaces the friction of the question.
    """
    # Imported here, because a closed contact does not need it.
    from ...transients.march import open_at_rest

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
    # Sets with the first nodes open come first.
    return [opened for opened in np.unique(sets, axis=0)[::-1] if opened.any()]


def is_safe_at_mean_load(question: Question, slip: Array | None) -> bool:
    """Whether one of three likely slips is safe under the mean load alone.

    These slips are zero slip, the given slip if it is not None, and the slip after the mean load is
    applied in one step.
    """
    if question.settles_closed:
        return True
    if slip is not None and question.violation(0.0, slip) <= RESIDUAL:
        return True
    # Imported here, because one of the slips above is usually safe.
    from ...transients.march import mean_state

    try:
        state = mean_state(question.system, question.cycle, question.friction, steps=1)
    except (ModelError, NoContinuation, SolverError):
        return False
    return question.violation(0.0, state.slip) <= RESIDUAL


def settled_sets(question: Question, tending: bool, safe: bool) -> Iterator[Booleans]:
    """The open nodes under the mean load with the given friction, and with more and less friction.

    If the mean load opens no node with the given friction, other frictions are tried only if
    `tending`: some closed nodes tend to open. `safe` is whether some set is known to be safe.
    """
    for share in FRICTIONS:
        try:
            opened = open_under_mean(question, share * question.friction)
        except SolverError:
            # The state under the mean load was not found, so this start is missing. If no other
            # state of rest is known, raise the error: a failed solver does not prove that none
            # exists. If a body slides off, there is no such state, and no error is raised.
            if share == 1.0 and not safe and not _slides_off(question):
                raise
            continue
        yield from opened
        if share == 1.0 and not (opened or tending):
            return


def _slides_off(question: Question) -> bool:
    """Whether the mean load slides a body off at the pressures of the closed contact."""
    statics = Statics(question.system, question.friction)
    return any(
        statics.slides_off("the mean load", forces.ravel()) is not None for forces in question.r0
    )


def next_to(limit: ShakedownAnswer) -> Iterator[Booleans]:
    """Neighbouring sets of open nodes: some nodes, mainly governing ones, are opened or closed.

    First all governing nodes change, then only the governing nodes at the border between open and
    closed nodes. In the plane all closed nodes of the border open, or all its open nodes close,
    because a mechanism may govern on one side only. Last, governing nodes change one by one, in
    space in small groups, beginning at the border.
    """
    question = limit._question
    open_nodes = question.open_nodes
    plane = question.system.tangents == 1
    moving = governing(limit)
    changes = np.roll(open_nodes, 1) != open_nodes
    border = changes | np.roll(changes, -1)
    edge = moving[border[moving]]
    inner = moving[~border[moving]]

    groups = [moving, edge]
    if plane:
        groups += [np.flatnonzero(border & (open_nodes == state)) for state in (False, True)]
    size = 1 if plane or len(moving) <= _FEW else _GROUP
    for part in (edge, inner):
        groups += [part[start : start + size] for start in range(0, len(part), size)]
    for nodes in groups:
        flipped = open_nodes.copy()
        flipped[nodes] ^= True
        yield flipped


def governing(limit: ShakedownAnswer) -> Integers:
    """Nodes that govern a limit, and that a search may open or close, largest motion first.

    In a large closed contact without gaps, only nodes that tend to open are returned: each pressed
    node would cost a program, which gained nothing in the large contacts measured.
    """
    question = limit._question
    motion = motion_of(limit)
    has_gaps = bool((question.system.gap > TOUCHES * question.clearance).any())
    large = question.system.nodes > _FEW
    if large and not (question.open_nodes.any() or has_gaps):
        governs = tends_to_open(limit)
    else:
        share = np.where(_touching(limit), GOVERNS_TOUCHING, _GOVERNS)
        governs = motion > share * motion.max()
    order = np.argsort(-motion, kind="stable")
    return np.asarray(order[governs[order]])


def tends_to_open(closed: ShakedownAnswer) -> Booleans:
    """(N,) nodes of a closed contact that govern and tend to open.

    Such a node has no pressure at some corner, or the mean load pulls it.
    """
    motion = motion_of(closed)
    unpressed = _touching(closed) & (motion > GOVERNS_TOUCHING * motion.max())
    pulled = closed._question.r0[:, -1].max(axis=0) < 0
    return np.asarray(unpressed | pulled & (motion > _GOVERNS * motion.max()))


def motion_of(limit: ShakedownAnswer) -> Array:
    """(N,) motions in the mechanism of a limit: of closed nodes, and of open nodes that touch."""
    motion: Array = limit._motion.parts(limit._question.system).sum(axis=(0, 1))
    return motion


def _touching(limit: ShakedownAnswer) -> Booleans:
    """(N,) open nodes without gap, and closed nodes without pressure, at some corner."""
    question = limit._question
    if not np.isfinite(limit.load_factor):
        return np.zeros(question.system.nodes, dtype=bool)
    bare, shut = touching(question, limit.load_factor, limit.slip)
    return np.where(question.open_nodes, shut.any(axis=0), bare.any(axis=0))


def touching(question: Question, load_factor: float, slip: Array) -> tuple[Booleans, Booleans]:
    """(K, N) masks of the nodes without pressure, and of the nodes without gap, at the corners."""
    u, r = question.states(load_factor, slip)
    return r[:, -1] <= TOUCHES * question.force, u[:, -1] <= TOUCHES * question.clearance
