"""A question on fewer nodes, and what its answer means for all: half or a quarter of a symmetric contact, the closed nodes of an open one, or both.

Where contact, friction, slip bound and the set of corners of the loads are mirror-symmetric, in one plane or in two, the mean of a safe slip and its
mirror images is safe too, for safe slips are a convex set. So a symmetric one is looked for, and one of all nodes that are images of each other has a
question of its own, see `Mirrors`, with the circles or intervals of all corners.

Where nodes stay open, the question is asked of the closed ones, see `open_nodes`, under one more row for each open node: its gap stays >= 0 at every
corner, which is affine in slip and load factor. All quantities are linear on the way from corner to corner, so no node opens or closes there: a safe
slip is a true state of rest.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array, eye_array
from scipy.spatial.distance import cdist

from ..contact import ContactSystem
from ..contact.checks import Array, Booleans
from ..contact.parts import joined, parted
from ..contact.tolerances import ROUNDING
from ..errors import ModelError, NoContinuation
from .mechanism import Mechanism
from .mirrors import Integers, Mirrors, mirror_planes
from .open_nodes import OpenNodes, following, without
from .question import LimitQuestion, units_of

# Of stiffness, over that of the two nodes, of friction, gap and slip, over their largest value: a part adds nothing to the error of the whole.
_ASYMMETRY = ROUNDING / 10
_ASYMMETRY_OF_LOADS = ROUNDING  # the same of reactions, which do not add up from one increment to the next


def mirrors_of(task: LimitQuestion) -> Mirrors | None:
    """The mirror images that have stiffness, gap, friction, slip bound and loads of the contact, these maybe at other corners; None if none has."""
    system, n, axes = task.system, task.system.nodes, task.system.tangents + 1
    if n == 1 or task.lift is not None:
        return None
    found = Mirrors(np.zeros((0, axes)), np.arange(axes * n)[None], np.ones((1, axes * n)), np.arange(len(task.q1))[None], n)
    parts = np.array([system.gap, task.closed, task.friction, task.friction if task.most is None else task.most])
    largest = parts.max(axis=1, keepdims=True)
    for plane, place, sign in mirror_planes(system):
        alike = (np.abs(parts[:, place[:n]] - parts) <= _ASYMMETRY * largest).all() and not (np.abs(found.planes @ plane) > ROUNDING).any()
        corner = _corners_there(task, place, sign) if alike else None
        if corner is not None and _as_stiff(system, place, sign):
            found = found.and_in(plane, place, sign, corner)
    return found if len(found.planes) else None


def _corners_there(task: LimitQuestion, place: Integers, sign: Array) -> Integers | None:
    """(K,) corner with the image of the loads of each corner; None where one has none."""
    apart = np.zeros((len(task.q1),) * 2, dtype=bool)
    for loads in (joined(task.q0, task.p0), joined(task.q1, task.p1)):
        apart |= cdist(loads[:, place] * sign, loads, "chebyshev") > _ASYMMETRY_OF_LOADS * np.abs(loads).max()
    corners = linear_sum_assignment(apart)
    return None if apart[corners].any() else corners[1]


def _as_stiff(system: ContactSystem, place: Integers, sign: Array) -> bool:
    """Whether the stiffness of an image is that of the contact, entry by entry: a soft node beside stiff ones has its own rounding."""
    axes, S = system.tangents + 1, system.S
    own = np.tile(np.sqrt(np.diag(S).reshape(axes, -1).max(axis=0).clip(0.0)), axes)
    return all(
        (np.abs(S[np.ix_(place[rows], place)] * np.outer(sign[rows], sign) - S[rows]) <= _ASYMMETRY * np.outer(own[rows], own)).all()
        for rows in np.arange(len(S)).reshape(axes, -1)
    )


def half_of(task: LimitQuestion) -> LimitQuestion:
    """The question of the half or the quarter in the units of the whole, where there is one and the question may be simplified; else as it is."""
    every = task if task.lift is None or task.whole is None else task.whole
    mirrors = mirrors_of(every) if task.simplify else None
    if mirrors is None:
        return task
    lift, w0, w1 = task.lift, task.w0, task.w1
    if lift is not None:
        opened, mirrors = mirrors.among(~every.closed), mirrors.among(every.closed)
        lift, w0, w1, mirrors = mirrors.by_kept(lift[opened.kept]), w0[:, opened.kept], w1[:, opened.kept], replace(mirrors, open=opened)
    kept, A, B = mirrors.kept, mirrors.folded(task.A), mirrors.folded(task.B)
    A[mirrors.times.ravel() == 0] = 0.0  # nothing is driven across a mirror plane
    loads = {name: getattr(task, name)[:, kept] for name in ("q0", "p0", "q1", "p1")}
    most = None if task.most is None else task.most[kept] / np.maximum(mirrors.times.max(axis=0), 1.0)
    stiffness = task.stiffness.reshape(-1, len(task.friction))[:, kept].ravel()
    return replace(
        task,
        **loads,
        friction=task.friction[kept],
        A=A,
        B=B,
        lift=lift,
        w0=w0,
        w1=w1,
        stiffness=stiffness,
        most=most,
        whole=task,
        mirrors=mirrors,
    )


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


def on_all_nodes(task: LimitQuestion, nodes: OpenNodes) -> tuple[Array, Array, csr_array]:
    """Of a question on closed nodes: the slip of all where these have none, (t N,) by component, what each of theirs adds, and their places.

    Open nodes have the slip at load factor 0 and corner 0, see `LimitQuestion.expanded`.
    """
    out = np.tile(nodes.opened, task.system.tangents)
    place = eye_array(len(out), format="csr")[:, ~out]
    moved = place.toarray()
    moved[out] = -nodes.follow[: int(out.sum()), : moved.shape[1]]
    return task.expanded(np.zeros(task.q1.shape[1:])).T.ravel(), moved, place


def on_whole(task: LimitQuestion, slip: Array, motion: Mechanism) -> tuple[LimitQuestion, Array, Mechanism]:
    """The question of the whole contact, with slip and mechanism of its part expanded to it; those of a whole one as they are."""
    while task.whole is not None:
        part = task.mirrors or task.whole.open
        motion = motion if part is None else part.expanded(motion, task.whole.friction)
        task, slip = task.whole, task.expanded(slip)
    return task, slip, motion


def rest_under_mean(task: LimitQuestion) -> LimitQuestion | None:
    """The question without the nodes that are open once the mean load has settled; None if none is, or no other is left."""
    opened = open_under_mean(task)
    return None if opened is None else rest_of(task, opened)


def open_under_mean(task: LimitQuestion) -> Booleans | None:
    """(N,) which nodes are open once the mean load has settled, from no slip, and at all corners of a cycle at load factor 0; None if none is.

    None, too, where the mean load never settles.

    Raises
    ------
    SolverError
        An increment on the way to the mean load has no answer that passes the checks.
    """
    from ..transients.mean import open_at_rest  # here, because a closed contact needs none

    try:
        opened = open_at_rest(task.system, task.cycle, task.friction)
    except (ModelError, NoContinuation):
        return None
    return opened if opened.any() else None
