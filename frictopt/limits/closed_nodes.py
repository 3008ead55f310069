"""The question of the closed nodes of a contact some of whose nodes stay open, see `open_nodes`.

Every question is asked of the contact of the closed nodes, under one more row for each open node: its gap stays >= 0 at every corner, which is affine
in slip and load factor. All quantities are linear on the way from corner to corner, so no node opens or closes there: a safe slip is a true state of
rest.
"""

from dataclasses import replace

import numpy as np

from ..contact.checks import Booleans
from ..contact.parts import joined, parted
from ..errors import FrictoptError
from .open_nodes import following, without
from .question import LimitQuestion, pose

__all__ = ["open_under_mean", "rest_of", "rest_under_mean"]


def rest_of(task: LimitQuestion, opened: Booleans) -> LimitQuestion | None:
    """The question of the closed nodes; None if nothing would hold the open ones, or none is closed."""
    nodes = None if opened.all() else following(task.system, opened)
    if nodes is None:
        return None
    system = without(task.system, nodes)
    most = None if task.most is None else task.most[~opened]
    rest = pose(system, task.cycle, task.friction[~opened], simplify=task.simplify, most=most)
    unscaled, corners = joined(task.loads.q0, task.loads.p0), joined(task.loads.q1, task.loads.p1)
    out, count = np.tile(opened, system.tangents + 1), int(opened.sum())
    gaps = [parted(-load[..., out] @ nodes.give, system.tangents + 1)[1] for load in (unscaled, corners)]
    # what would press the open nodes shut is no scale
    units = {name: getattr(rest, name) for name in ("force", "load_unit", "mean_bound", "opening")}
    return replace(
        rest,
        loads=replace(rest.loads, w0=gaps[0], w1=gaps[1]),
        started=task.started,
        whole=replace(task, open=nodes, **units),
        lift=-nodes.follow[-count:, : -system.nodes],
    )


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
