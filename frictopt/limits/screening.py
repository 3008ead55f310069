"""Load factors below which a node cannot be on both its bounds, from one slip mechanism for each node.

Let `s+ = q + f p` and `s- = f p - q` be the slacks of a node at its ruling corners, which for safe slips are >= 0. For any multipliers with
`A d + B^T (f a) = 0`, d = y+ - y- and a = y+ + y-, the sum of `y+ s+ + y- s-` over the nodes does not depend on the slip: it is
`resistance - lam drive`. Where node j is on both its bounds its own two terms vanish, so with `a >= abs(d)` at all other nodes::

    0 <= resistance - lam drive        although a_j = -1

We look for multipliers with `a_i = abs(d_i)` at all nodes i other than j, by fixed-point iteration for all nodes j at once. Where the iteration does
not converge (large friction) the bound of node j is 0.
"""

import numpy as np

from ..contact.checks import Array
from ..contact.tolerances import SCREENING, SETTLED, SPARE
from .question import LimitQuestion
from .ruling_corners import ruling_loads
from .scaling import ScaledContact

__all__ = ["load_factor_bounds"]

_MOST = 300  # iterations
_LARGE = 1e6  # a mechanism of this size is on its way to infinity


def load_factor_bounds(scaled: ScaledContact, task: LimitQuestion) -> Array:
    """(n,) lower bounds of the load factor at which each node can sit on both its bounds; 0 where nothing is known, inf where it never can.

    Parameters
    ----------
    scaled
        Unknowns and units of the whole contact.
    task
        The question.
    """
    n = len(task.friction)
    if task.loads.fixed:  # which corner rules depends on the load factor
        return np.zeros(n)
    rows, _ = ruling_loads(scaled.unit, task)
    follow, rigid = _response(scaled, task.friction)
    total = -np.eye(n)  # columns: the mechanisms, each in units of the force of its nodes; rows: a
    unit, hold = scaled.unit[:, None], np.maximum(rows["fp_mean"], 0.0)
    for _ in range(_MOST):
        net = np.abs(_net(follow, rigid, hold, total))
        size = unit * np.abs(total / unit).max(axis=0)
        following = (1 + SPARE) * net + SETTLED * size
        np.fill_diagonal(following, -1.0)
        np.fill_diagonal(net, -1.0)
        done = (net <= total).all(axis=0) & (np.abs(following - total) <= SETTLED * size).all(axis=0)
        lost = ~(total.max(axis=0) < _LARGE)
        if (done | lost).all():
            break
        total = np.where(done | lost, total, following)
    net = _net(follow, rigid, hold, total)
    held = total * rows["fp_mean"][:, None], net * rows["q_mean"][:, None]
    driven = total * (rows["forward"] + rows["backward"])[:, None] / 2, net * (rows["forward"] - rows["backward"])[:, None] / 2
    resistance, drive = (sum(part.sum(axis=0) for part in parts) for parts in (held, driven))
    terms = sum(np.abs(part).sum(axis=0) for part in held)
    with np.errstate(divide="ignore", invalid="ignore"):
        bound = np.where(drive < 0, resistance / drive, np.inf) * (1 - SCREENING) * task.load_unit
    return np.asarray(np.where(done & (resistance < -SCREENING * terms), bound, 0.0))


def _response(scaled: ScaledContact, friction: Array) -> tuple[Array, Array | None]:
    """Matrix from a to the d that balances it, with no net slip of nodes that carry no traction, and the rigid slip (n,) that may be added to d."""
    (n, m), rows_of_shear = scaled.shear.shape, scaled.shear.toarray()
    others = np.setdiff1d(np.arange(n), scaled.loaded)
    right = np.hstack([scaled.normal.T * friction, rows_of_shear[others].T])
    solved = -np.linalg.solve(rows_of_shear[scaled.loaded].T, right)
    follow = np.zeros((n, n))
    follow[scaled.loaded] = solved[:, :n]
    if n - m != 1:
        return follow, None
    rigid = np.ones(n)
    rigid[scaled.loaded] = solved[:, n]
    return follow, rigid if np.all(rigid != 0) else None


def _net(follow: Array, rigid: Array | None, hold: Array, total: Array) -> Array:
    """Net slips d of mechanisms with total slips a; where the body may slide as a whole, it does so until friction resists least."""
    net = follow @ total
    if rigid is None:
        return np.asarray(net)
    slides = net / rigid[:, None]
    order = np.argsort(slides, axis=0)
    half = np.cumsum((hold * np.abs(rigid))[order], axis=0)
    middle = np.argmax(half >= half[-1] / 2, axis=0)
    resting = order[middle, np.arange(order.shape[1])]
    return np.asarray(net - rigid[:, None] * slides[resting, np.arange(len(resting))])
