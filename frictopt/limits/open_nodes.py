"""Contacts some of whose nodes stay open: the question of the closed ones, which the open ones follow.

The nodes O are open at every corner k, the others C closed and stuck with a constant slip v. On O no force acts, and slip and gap there follow from
the load and from v. With the reactions `r_k = r0 + lam r1_k` of the closed contact, and the compliance `G = S_OO^-1` on O, zero elsewhere::

    u_k = [v, 0] - G (r_k + S [v, 0])

So C is a contact of its own, with the stiffness `S - S G S` and the reactions `r_k - S G r_k`, under one more row for each open node: its gap stays
>= 0 at every corner, which is affine in slip and load factor. All quantities are linear on the way from corner to corner, so no node opens or closes
there: a safe slip is a true state of rest.
"""

from dataclasses import replace

import numpy as np

from ..contact import CONDENSATION, ROUNDING, Array, Booleans, ContactSystem, joined
from ..errors import ModelError, NoContinuation
from .question import LimitQuestion, units_of

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
    values, vectors = np.linalg.eigh((left + left.T) / 2)  # what nothing resists any more is left as rounding of both signs
    left = (vectors * np.where(values > _NOTHING_LEFT * np.abs(S).max(), values, 0.0)) @ vectors.T
    left = (left + left.T) / 2
    units = units_of(friction, r0, r1, left[:, :-n])  # what would press the open nodes shut is no scale
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
