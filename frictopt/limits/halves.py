"""Mirror symmetry about the middle of a plane contact: the question of its half, and what the answer means for the whole.

Where contact, friction, loads and slip bound are mirror-symmetric, the mean of a safe slip and its mirror image is safe too. So a symmetric one is
looked for: v and q are odd, p is even, and the left half of the nodes with the middle one is a contact of its own. The middle node cannot slip. In
the half its gap counts half, so that the energy of the half is half of that of the whole.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..contact import ContactSystem
from ..contact.checks import Array
from ..contact.tolerances import ASYMMETRY, ASYMMETRY_OF_LOADS
from .loads import Loads
from .mechanism import Mechanism
from .question import LimitQuestion

__all__ = ["half_of", "mirrored", "on_whole", "sources"]


def mirrored(task: LimitQuestion) -> bool:
    """Whether the contact is in the plane, mirror-symmetric with its friction, its loads and its slip bound, and has more than one node."""
    system, loads = task.system, task.loads
    if system.tangents > 1 or system.nodes == 1 or task.lift is not None:
        return False
    A, B, C, f = system.A, system.B, system.C, task.friction
    own = np.sqrt(np.maximum(np.diag(A), np.diag(C)).clip(0.0))
    stiffness = np.outer(own, own)  # a soft node beside stiff ones has its own rounding
    pairs = [(A, np.flip(A), stiffness), (B, -np.flip(B), stiffness), (C, np.flip(C), stiffness)]
    pairs += [(part, part[::-1], part.max()) for part in (f, system.gap, f if task.most is None else task.most)]
    if not all((np.abs(one - other) <= ASYMMETRY * scale).all() for one, other, scale in pairs):
        return False
    for q, p in ((loads.q0, loads.p0), (loads.q1, loads.p1)):
        scale = ASYMMETRY_OF_LOADS * max(np.abs(q).max(), np.abs(p).max())
        if not max(np.abs(q + q[..., ::-1]).max(), np.abs(p - p[..., ::-1]).max()) <= scale:
            return False
    return True


def half_of(task: LimitQuestion, known: ContactSystem | None = None) -> LimitQuestion:
    """The question of the half in the units of the whole, where there is one and the question may be simplified; else the question as it is.

    `known` is the half of the contact where another question was asked of it before.
    """
    if not (task.simplify and mirrored(task)):
        return task
    system = known or _half(task.system)
    loads = Loads(*(part[..., : system.nodes] for part in (task.loads.q0, task.loads.p0, task.loads.q1, task.loads.p1)))
    most = None if task.most is None else task.most[: system.nodes]
    return replace(task, system=system, loads=loads, friction=task.friction[: system.nodes], most=most, whole=task)


def _half(whole: ContactSystem) -> ContactSystem:
    n = whole.nodes
    kept, middle = (n + 1) // 2, slice(n // 2, (n + 1) // 2)  # the middle is empty where the number of nodes is even
    A, B, C = (M[:kept, :kept] + sign * M[:kept, ::-1][:, :kept] for M, sign in ((whole.A, -1), (whole.B, -1), (whole.C, 1)))
    A[middle], A[:, middle] = 0.0, 0.0  # nothing couples its slip to the others, and nothing drives it
    A[middle, middle] = whole.stiffness_scale
    gap = np.where(np.arange(kept) < n // 2, whole.gap[:kept], whole.gap[:kept] / 2)
    bonded = {name: (q[:kept], p[:kept]) for name, (q, p) in whole.bonded.items()}
    return ContactSystem.from_blocks(A, B, C, whole.x[:kept], bonded, gap)


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
    n = task.whole.system.nodes
    source = sources(n)
    sign = np.sign(np.arange(n)[::-1] - np.arange(n)).astype(np.float64)
    share = np.where(sign == 0, 1.0, 0.5)
    hold = None if motion.hold is None else share * sign * motion.hold[source]
    expanded = Mechanism(share * sign * motion.slips[:, source], share * motion.opening[:, source], task.whole.friction, hold)
    return task.whole, sign * slip[source], expanded
