"""Questions on a part of a contact: half or a quarter of a mirror-symmetric one, or its closed nodes; and what their answers mean on the whole.

Where contact, friction, slip bound and the set of corners of the loads are mirror-symmetric, in one plane or in two, the mean of a safe slip and its
mirror images is safe too, for safe slips are a convex set. So a symmetric one is looked for: the sum of all images of a slip of the kept nodes, one
of each set of nodes that are images of each other. A node in a mirror plane is its own image: it slips along the plane alone, and its slip counts
twice.

Some nodes may stay open. The nodes O are open at every corner k, the others C closed and stuck with a constant slip v. On O no force acts, and slip
and gap there follow from the load and from v. With the reactions `r_k = r0 + lam r1_k` of the closed contact, and the compliance
`G = S_OO^-1` on O, zero elsewhere::

    u_k = [v, 0] - G (r_k + S [v, 0])

So C is a contact of its own, with the stiffness `S - S G S` and the reactions `r_k - S G r_k`, under one more row for each open node: its gap stays
>= 0 at every corner, which is affine in slip and load factor. All quantities are linear on the way from corner to corner, so no node opens or closes
there: a safe slip is a true state of rest.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import TypeAlias, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from ..contact import CONDENSATION, ROUNDING, SAME_POINT, Array, Booleans, ContactSystem, Integers, joined
from ..errors import ModelError, NoContinuation
from .answered import Mechanism
from .question import Images, LimitQuestion, units_of

M = TypeVar("M", Mechanism, None)

_ALONG = 10 * CONDENSATION  # error of tangents that lie along a mirror plane or across it, as of frames
# Of stiffness, over that of the two nodes, of friction, gap and slip, over their largest value: a part adds nothing to the error of the whole.
_ASYMMETRY = ROUNDING / 10
_ASYMMETRY_OF_LOADS = ROUNDING  # the same of reactions, which do not add up from one increment to the next


def half_of(task: LimitQuestion) -> LimitQuestion:
    """The question of the half or the quarter in the units of the whole, where there is one and the question may be simplified; else as it is."""
    every = task.whole or task
    images = images_of(every) if task.simplify else None
    if images is None:
        return task
    n, axes, (corners, places, signs) = len(task.friction), task.system.tangents + 1, images
    closed, place = np.tile(every.closed, axes), np.arange(axes * n) if task.images is None else task.images[1][0]
    gaps = (np.cumsum(~every.closed) - 1)[places[:, : len(every.closed)][:, ~every.closed]]
    places, signs = (np.cumsum(closed) - 1)[places[:, closed]], signs[:, closed]
    kept, opened = (np.unique(part.min(axis=0)) for part in (places[:, :n], gaps))
    unknowns = (kept + n * np.arange(axes)[:, None]).ravel()
    places, signs, slips = places[:, unknowns], signs[:, unknowns], len(unknowns) - len(kept)
    at = places[:, :slips].ravel(), np.tile(np.arange(slips), len(places))
    whole_slip = csr_array((signs[:, :slips].ravel(), at), shape=((axes - 1) * n, slips))  # of the part's: the sum of its images
    AB = task.AB[unknowns] @ whole_slip
    times = whole_slip[unknowns[:slips]].diagonal()  # how often a slip counts at its own node: not at all across a mirror plane
    AB[:slips][times == 0] = 0.0
    return replace(
        task,
        **{name: getattr(task, name)[..., kept] for name in ("r0", "r1", "friction", "closed")},
        AB=AB,
        stiffness=task.stiffness[unknowns],
        most=None if task.most is None else task.most[kept] / np.maximum(times.reshape(-1, len(kept)).max(axis=0), 1.0),
        lift=None if task.lift is None else task.lift[opened] @ whole_slip,
        w0=task.w0[:, opened],
        w1=task.w1[:, opened],
        whole=every,
        images=(corners, place[np.hstack([places, gaps[:, opened] + axes * n])], np.hstack([signs, np.ones_like(gaps[:, opened])])),
    )


def on_whole(task: LimitQuestion, slip: Array, motion: M) -> tuple[LimitQuestion, Array, M]:
    """The question of the whole contact, with slip and mechanism (or None) of its part expanded to it; those of a whole one as they are.

    The slip is the sum of its images; open nodes have theirs at load factor 0, corner 0. The mechanism is the mean of its images; open nodes follow
    it without force, pressed only where they would touch.
    """
    whole = task.whole
    if whole is None or task.images is None:
        return task, slip, motion
    (corners, places, signs), shape = task.images, whole.r1.shape
    every, hold = np.zeros((2, whole.AB.shape[1])), None if motion is None else motion.hold
    for place, sign in zip(places[:, : slip.size], signs[:, : slip.size], strict=True):
        every[0, place] += sign * slip.T.ravel()
        every[1, place] = 0.0 if hold is None else sign * hold.ravel() / len(corners)  # once at a node that is its own image
    slip, held = (part.reshape(-1, shape[2]) for part in every)
    slip = whole.states(0.0, slip.T)[0][0, :-1].T.reshape(whole.system.slip_shape)
    if motion is None:
        return whole, slip, motion
    friction, closed = whole.friction * whole.closed, np.tile(whole.closed, shape[1])
    press = np.zeros((shape[0], task.w1.shape[1])) if motion.press is None else motion.press
    own, mean = np.hstack([motion.moves.reshape(shape[0], -1), press]), np.zeros((shape[0], len(closed)))
    for corner, at, sign in zip(corners, places, signs, strict=True):
        mean[np.ix_(corner, at)] += sign * own / len(corners)
    moves = (mean * closed).reshape(shape)
    if len(corners) > 1:  # so it is, but for rounding
        moves[:, -1] = np.maximum(moves[:, -1], friction * np.linalg.norm(moves[:, :-1], axis=1))
    if whole.give is not None:
        moves = moves - ((moves.reshape(mean.shape) @ whole.system.S + mean * ~closed) @ whole.give).reshape(shape)
    return whole, slip, Mechanism(moves, friction, None if hold is None else held, open=None if whole.give is None else ~whole.closed)


def images_of(task: LimitQuestion) -> Images | None:
    """The images that have stiffness, gap, friction, slip bound and loads of the contact, these maybe at other corners; None if none has.

    Itself is the first; all sets of planes across each other follow.
    """
    system, n, axes = task.system, task.system.nodes, task.system.tangents + 1
    if n == 1 or task.whole is not None:
        return None
    parts = np.array([system.gap, task.closed, task.friction, task.friction if task.most is None else task.most])
    corners, places, signs, planes = [np.arange(len(task.r1))], [np.arange(axes * n)], [np.ones(axes * n)], list[Array]()
    if system not in _MIRRORS:
        _MIRRORS[system] = list(_mirror_planes(system))
    for plane, to, turn in _MIRRORS[system]:
        across = all(abs(plane @ other) <= ROUNDING for other in planes)
        if not across or (np.abs(parts[:, to[:n]] - parts) > _ASYMMETRY * parts.max(axis=1, keepdims=True)).any():
            continue
        apart = np.zeros((len(task.r1),) * 2, dtype=bool)
        for loads in (r.reshape(len(r), -1) for r in (task.r0, task.r1)):
            apart |= cdist(loads[:, to] * turn, loads, "chebyshev") > _ASYMMETRY_OF_LOADS * np.abs(loads).max()
        here, at = linear_sum_assignment(apart)  # the corner with the image of the loads of each
        if apart[here, at].any():
            continue
        planes.append(plane)
        corners += [at[corner] for corner in corners]
        signs += [turn[place] * sign for place, sign in zip(places, signs, strict=True)]
        places += [to[place] for place in places]
    return (np.array(corners), np.array(places), np.array(signs)) if planes else None


Mirror: TypeAlias = tuple[Array, Integers, Array]
_MIRRORS: WeakKeyDictionary[ContactSystem, list[Mirror]] = WeakKeyDictionary()  # found once: on large contacts this takes as long as a limit


def _mirror_planes(system: ContactSystem) -> Iterator[Mirror]:
    """Those planes that mirror the stiffness, too, see `_planes_of_nodes`."""
    S, axes = system.S, system.tangents + 1
    own, blocks = np.tile(np.sqrt(np.diag(S).reshape(axes, -1).max(axis=0).clip(0.0)), axes), np.arange(len(S)).reshape(axes, -1)
    for plane, to, turn in _planes_of_nodes(system):  # entry by entry: a soft node beside stiff ones has its own rounding
        if not any((np.abs(S[np.ix_(to[k], to)] * np.outer(turn[k], turn) - S[k]) > _ASYMMETRY * np.outer(own[k], own)).any() for k in blocks):
            yield plane, to, turn


def _planes_of_nodes(system: ContactSystem) -> Iterator[Mirror]:
    """Normals of planes that mirror nodes and frames onto nodes and frames, but for the sense of tangents; with places and signs, (M,).

    In the plane the one across the middle; in space those through the middle of the nodes, across an axis or across a tangent of the first node.
    """
    nodes, first, frames = np.arange(system.nodes), system.nodes * np.arange(system.tangents + 1)[:, None], system.frames
    if system.tangents == 1:
        yield frames[0, 0], (first + nodes[::-1]).ravel(), np.repeat([-1.0, 1.0], system.nodes)
        return
    at = system.points - system.points.mean(axis=0)
    tree = cKDTree(at)
    for normal in (*np.eye(3), *(tangent for tangent in frames[0, :2] if np.abs(tangent).max() < 1 - _ALONG)):
        mirror = np.eye(3) - 2 * np.outer(normal, normal)
        apart, image = tree.query(at @ mirror)
        turn = frames[image] @ mirror @ frames.transpose(0, 2, 1)
        sign = np.round(np.diagonal(turn, axis1=1, axis2=2))
        along = np.abs(turn - sign[:, :, None] * np.eye(3)).max() <= _ALONG and (sign[:, 2] == 1).all()
        if along and apart.max() <= SAME_POINT * np.abs(at).max() and (image[image] == nodes).all():
            yield normal, (first + image).ravel(), sign.T.ravel()


# Smallest eigenvalue of the open nodes' stiffness, over the largest, with which they leave no body free: the data have this error.
_HELD = CONDENSATION
_NOTHING_LEFT = ROUNDING / 10  # eigenvalues below this share of the largest entry of S are none once nodes are condensed out
_BESIDE = 2.0  # distances of the nearest node within which others are its neighbours


def compliance(system: ContactSystem, opened: Booleans) -> Array | None:
    """(M, M) compliance of open nodes, zero elsewhere; None if the others, or nothing where all are open, do not hold them."""
    out, S = np.tile(opened, system.tangents + 1), system.S
    values, vectors = np.linalg.eigh(S[np.ix_(out, out)])
    held = values > _HELD * max(values[-1], np.finfo(float).tiny)
    loads = [joined(*pair) for pair in system.bonded.values()]
    driven = [r[out] @ vectors[:, ~held] / (np.abs(r).max() or 1.0) for r in loads]  # a way aside that no load takes is no matter
    if max(np.abs(part).max(initial=0.0) for part in (*driven, vectors[-int(opened.sum()) :, ~held])) > _HELD:
        return None
    give = np.zeros_like(S)
    give[np.ix_(out, out)] = (vectors[:, held] / values[held]) @ vectors[:, held].T
    return give


def rest_of(task: LimitQuestion, opened: Booleans) -> LimitQuestion | None:
    """The question of the closed nodes; None if nothing would hold the open ones, or none is closed."""
    give = None if opened.all() else compliance(task.system, opened)
    if give is None:
        return None
    axes, S = task.system.tangents + 1, task.system.S
    out, n = np.tile(opened, axes), int((~opened).sum())
    gaps = np.flatnonzero(opened) + (axes - 1) * len(opened)
    follow = give[np.ix_(out, out)] @ S[np.ix_(out, ~out)]
    at_zero, cyclic = (r.reshape(len(r), -1) for r in (task.r0, task.r1))
    r0, r1 = ((load[:, ~out] - load[:, out] @ follow).reshape(len(load), axes, n) for load in (at_zero, cyclic))
    friction, left = task.friction[~opened], S[np.ix_(~out, ~out)] - S[np.ix_(~out, out)] @ follow
    left = (left + left.T) / 2
    values, vectors = eigh(left, subset_by_value=(-np.inf, _NOTHING_LEFT * np.abs(S).max()))
    left = left - (vectors * values) @ vectors.T  # what nothing resists any more is left as rounding of both signs
    units = units_of(friction, r0, r1)  # what would press the open nodes shut is no scale
    return replace(
        task,
        friction=friction,
        r0=r0,
        r1=r1,
        AB=left[:, :-n],
        stiffness=task.stiffness[~out],
        most=None if task.most is None else task.most[~opened],
        closed=task.closed[~opened],
        whole=replace(task, closed=~opened, give=give, **units),
        images=(np.arange(len(task.r1))[None], np.r_[np.flatnonzero(~out), gaps][None], np.ones((1, axes * n + len(gaps)))),
        lift=-follow[-len(gaps) :, :-n],
        w0=-at_zero @ give[:, gaps],
        w1=-cyclic @ give[:, gaps],
        **units,
    )


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
    from ..transients.march import open_at_rest  # here, because a closed contact needs none

    try:
        opened = open_at_rest(task.system, task.cycle, task.friction)
    except (ModelError, NoContinuation):
        return None
    return opened if opened.any() else None


def border(system: ContactSystem, opened: Booleans, node: int, p: Array) -> str:
    """What a limit that a node beside open ones rules says of the mesh, as the end of a reason; p (K, N) are the normal forces at the limit.

    Pressure falls to zero where closed nodes meet open ones, unless the body ends there in an edge, where pressure is highest.
    """
    apart = np.linalg.norm(system.points - system.points[node], axis=1)
    apart[node] = np.inf
    pressure = p.min(axis=0) / (1.0 if system.width is None else system.width)
    if opened[node] or apart[opened].min(initial=np.inf) > _BESIDE * apart.min() or pressure[node] > pressure[~opened].mean():
        return ""
    return (
        f"; node {node} beside the open ones rules, where pressure falls to zero: the limit belongs to the mesh, and falls as elements shrink there"
    )
