"""Nodes that the mean load leaves open, and what they mean for a limit."""

from contextlib import suppress

import numpy as np

from ..contact import RESIDUAL, Array, Booleans, ContactSystem, LoadCycle
from ..contact.diagnosis import in_contact
from ..errors import ModelError, NoContinuation
from .question import Question

TOUCHES = 1e3 * RESIDUAL  # pressure, over the mean force, up to which a closed node wants to open
_BESIDE = 1.5  # distances of the nearest node within which others are its neighbours


def open_under_mean(task: Question) -> list[Booleans]:
    """(N,) which nodes the mean load leaves open, from no slip; no sets where none opens, or the load settles nowhere.

    With fixed parts that differ: those that any corner leaves open at load factor 0, and those that all corners do.
    """
    from ..transients.march import open_at_rest  # here, because a closed contact needs none

    found = list[Booleans]()
    for loads in task.cycle.unscaled if task.fixed else task.cycle.unscaled[:1]:
        with suppress(ModelError, NoContinuation):
            found.append(open_at_rest(task.system, LoadCycle(loads, task.cycle.corners), task.friction))
    found += [np.logical_and.reduce(found)] if found else []
    return [np.array(opened) for opened in sorted({tuple(each.tolist()) for each in found}, reverse=True) if any(opened)]


def border(system: ContactSystem, opened: Booleans, node: int, p: Array) -> str:
    """What a limit that a node beside open ones governs says of the mesh (pressure there is 0, or highest at an edge); p (K, N) at the limit."""
    apart = np.linalg.norm(system.points - system.points[node], axis=1)
    apart[node] = np.inf
    pressure = p.min(axis=0) / (1.0 if system.width is None else system.width)
    if opened[node] or apart[opened].min(initial=np.inf) > _BESIDE * apart.min() or pressure[node] > pressure[~opened].mean():
        return ""
    where = f"node {node}{in_contact(system, node)} beside the open ones"
    return f"; {where} rules, where pressure falls to zero: the limit belongs to the mesh, and falls as elements shrink there"
