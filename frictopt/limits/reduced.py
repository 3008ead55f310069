"""A question on fewer nodes, and what its answer means for the whole contact: the half of a mirror-symmetric one, or the closed nodes of an open one.

Where contact, friction, loads and slip bound are mirror-symmetric, the mean of a safe slip and its mirror image is safe too. So a symmetric one is
looked for: v and q are odd, p is even, and the left half of the nodes with the middle one has a question of its own. The middle node cannot slip.

Where nodes stay open, the question is asked of the closed ones, see `open_nodes`, under one more row for each open node: its gap stays >= 0 at every
corner, which is affine in slip and load factor. All quantities are linear on the way from corner to corner, so no node opens or closes there: a safe
slip is a true state of rest.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..contact.checks import Array, Booleans
from ..contact.parts import joined, parted
from ..contact.tolerances import ROUNDING
from ..errors import FrictoptError
from .mechanism import Mechanism
from .open_nodes import following, without
from .question import LimitQuestion, units_of

__all__ = ["half_of", "mirrored", "on_whole", "open_under_mean", "rest_of", "rest_under_mean", "sources"]

# Of stiffness, over that of the two nodes, of friction, gap and slip, over their largest value: a half adds nothing to the error of the whole.
_ASYMMETRY = ROUNDING / 10
_ASYMMETRY_OF_LOADS = ROUNDING  # the same of reactions, which do not add up from one increment to the next


def mirrored(task: LimitQuestion) -> bool:
    """Whether the contact is in the plane, mirror-symmetric with its friction, its loads and its slip bound, and has more than one node."""
    system = task.system
    if system.tangents > 1 or system.nodes == 1 or task.lift is not None:
        return False
    A, B, C, f = system.A, system.B, system.C, task.friction
    own = np.sqrt(np.maximum(np.diag(A), np.diag(C)).clip(0.0))
    stiffness = np.outer(own, own)  # a soft node beside stiff ones has its own rounding
    pairs = [(A, np.flip(A), stiffness), (B, -np.flip(B), stiffness), (C, np.flip(C), stiffness)]
    pairs += [(part, part[::-1], part.max()) for part in (f, system.gap, f if task.most is None else task.most)]
    if not all((np.abs(one - other) <= _ASYMMETRY * scale).all() for one, other, scale in pairs):
        return False
    for q, p in ((task.q0, task.p0), (task.q1, task.p1)):
        scale = _ASYMMETRY_OF_LOADS * max(np.abs(q).max(), np.abs(p).max())
        if not max(np.abs(q + q[..., ::-1]).max(), np.abs(p - p[..., ::-1]).max()) <= scale:
            return False
    return True


def half_of(task: LimitQuestion) -> LimitQuestion:
    """The question of the half in the units of the whole, where there is one and the question may be simplified; else the question as it is."""
    if not (task.simplify and mirrored(task)):
        return task
    n = len(task.friction)
    kept, middle = (n + 1) // 2, slice(n // 2, (n + 1) // 2)  # the middle is empty where the number of nodes is even
    A, B = (M[:kept, :kept] - M[:kept, ::-1][:, :kept] for M in (task.A, task.B))
    own = task.stiffness.reshape(2, n)[:, :kept]
    A[middle], A[:, middle] = 0.0, 0.0  # nothing couples its slip to the others, and nothing drives it
    A[middle, middle] = own[0, middle]
    loads = {name: getattr(task, name)[:, :kept] for name in ("q0", "p0", "q1", "p1")}
    most = None if task.most is None else task.most[:kept]
    return replace(task, **loads, friction=task.friction[:kept], A=A, B=B, stiffness=own.ravel(), most=most, whole=task)


def rest_of(task: LimitQuestion, opened: Booleans) -> LimitQuestion | None:
    """The question of the closed nodes; None if nothing would hold the open ones, or none is closed."""
    nodes = None if opened.all() else following(task.system, opened)
    if nodes is None:
        return None
    axes = task.system.tangents + 1
    out, count, n = np.tile(opened, axes), int(opened.sum()), int((~opened).sum())
    at_zero, cyclic = joined(task.q0, task.p0), joined(task.q1, task.p1)
    w0, w1 = (parted(-load[:, out] @ nodes.give, axes)[1] for load in (at_zero, cyclic))
    q0, p0, q1, p1 = (part for load in (at_zero, cyclic) for part in parted(load[:, ~out] - load[:, out] @ nodes.follow, axes))
    friction, S = task.friction[~opened], without(task.system, nodes)
    units = units_of(friction, q0, p0, q1, p1)  # what would press the open nodes shut is no scale
    return replace(
        task,
        friction=friction,
        q0=q0,
        p0=p0,
        q1=q1,
        p1=p1,
        A=S[:-n, :-n],
        B=S[-n:, :-n],
        stiffness=task.stiffness[~out],
        most=None if task.most is None else task.most[~opened],
        whole=replace(task, open=nodes, **units),
        lift=-nodes.follow[-count:, :-n],
        w0=w0,
        w1=w1,
        **units,
    )


def sources(nodes: int) -> NDArray[np.intp]:
    """(N,) the node of the left half that each node is, or is the image of."""
    return np.minimum(np.arange(nodes), np.arange(nodes)[::-1])


def on_whole(task: LimitQuestion, slip: Array, motion: Mechanism) -> tuple[LimitQuestion, Array, Mechanism]:
    """The question of the whole contact, with slip and mechanism of its half or of its closed nodes expanded to it; those of a whole one as they are.

    Of a half, the two nodes of a pair share the motion. An image slips backward where its source slips forward. The middle node slips as far to and
    fro, which is an opening.
    """
    if task.whole is None:
        return task, slip, motion
    if (nodes := task.whole.open) is not None:
        return task.whole, task.expanded(slip), nodes.expanded(motion, task.whole.friction)
    n = len(task.whole.friction)
    source = sources(n)
    sign = np.sign(np.arange(n)[::-1] - np.arange(n)).astype(np.float64)
    share = np.where(sign == 0, 1.0, 0.5)
    hold = None if motion.hold is None else share * sign * motion.hold[source]
    expanded = Mechanism(share * sign * motion.slips[:, source], share * motion.opening[:, source], task.whole.friction, hold)
    return task.whole, task.expanded(slip), expanded


def rest_under_mean(task: LimitQuestion) -> LimitQuestion | None:
    """The question without the nodes that are open once the mean load has settled; None if none is, or no other is left."""
    opened = open_under_mean(task)
    return None if opened is None else rest_of(task, opened)


def open_under_mean(task: LimitQuestion) -> Booleans | None:
    """(N,) which nodes are open once the mean load has settled, from no slip, and at all corners of a cycle at load factor 0; None if none is."""
    from ..transients.mean import open_at_rest  # here, because a closed contact needs none

    try:
        opened = open_at_rest(task.system, task.cycle, task.friction)
    except FrictoptError:
        return None
    return opened if opened.any() else None
