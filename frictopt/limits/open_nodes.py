"""Nodes that the mean load leaves open, and what they mean for a limit."""

import numpy as np

from ..contact import Array, Booleans, ContactSystem
from ..errors import ModelError, NoContinuation
from .question import Question

_BESIDE = 1.5  # distances of the nearest node within which others are its neighbours


def open_under_mean(task: Question) -> Booleans | None:
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
