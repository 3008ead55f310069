"""The load side of the safe-slip inequalities: which corner rules each node, and what its duals mean."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contact.checks import Array
from .interface import Interface, Loads

__all__ = ["LoadRows", "load_factor_unit", "load_rows"]

Integers = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True, eq=False)
class LoadRows:
    """Right-hand sides of `q + g >= load_factor * forward`, `g - q >= load_factor * backward` and `p >= load_factor * opening`.

    All in units of the interface. Each row belongs to a node and a corner. `g = f p` is the friction bound, `forward = -(q1 + f p1)`,
    `backward = q1 - f p1`, `opening = -p1`. For a load factor >= 0 the corners of one node and one kind of row differ only in the coefficient of
    the load factor, so the largest one rules and the others are implied. The rows of opening follow from the other two where there is friction.

    Attributes
    ----------
    node
        (R,) position of the row's node among the interface's nodes.
    friction, q_mean, g_mean, p_mean, forward, backward, opening
        (R,) coefficients of the rows; loads divided by the node's unit and forward, backward, opening multiplied by `load_unit`.
    corners
        (R,) corner that each row speaks for, for rows of forward, backward and opening.
    load_unit
        Load factor that the dimensionless load factor is measured in.
    """

    node: Integers
    friction: Array
    q_mean: Array
    g_mean: Array
    p_mean: Array
    forward: Array
    backward: Array
    opening: Array
    corners: tuple[Integers, Integers, Integers]
    load_unit: float


def load_rows(interface: Interface, loads: Loads, friction: Array, every_corner: bool) -> LoadRows:
    """Rows of the kept nodes: one per node and sense for the ruling corner, or one for every corner."""
    nodes, unit = interface.nodes, interface.unit
    f, q0, p0, q1, p1 = friction[nodes], loads.q0[nodes], loads.p0[nodes], loads.q1[:, nodes], loads.p1[:, nodes]
    forward, backward, opening = -(q1 + f * p1), q1 - f * p1, -p1
    if every_corner:
        node = np.tile(np.arange(len(nodes)), loads.corners)
        corner = np.repeat(np.arange(loads.corners), len(nodes))
        corners = corner, corner, corner
    else:
        node = np.arange(len(nodes))
        corners = forward.argmax(axis=0), backward.argmax(axis=0), opening.argmax(axis=0)
    load_unit = load_factor_unit(loads, friction, interface.force)
    return LoadRows(
        node=node,
        friction=f[node],
        q_mean=(q0 / unit)[node],
        g_mean=(f * p0 / unit)[node],
        p_mean=(p0 / unit)[node],
        forward=forward[corners[0], node] / unit[node] * load_unit,
        backward=backward[corners[1], node] / unit[node] * load_unit,
        opening=opening[corners[2], node] / unit[node] * load_unit,
        corners=corners,
        load_unit=load_unit,
    )


def load_factor_unit(loads: Loads, friction: Array, force: float) -> float:
    """Load factor at which the cyclic reactions reach the size of the mean friction bound (of the force scale where there is none)."""
    demand = float(np.abs(loads.q1).mean() + (friction * np.abs(loads.p1)).mean() + np.abs(loads.p1[:, friction == 0]).sum() / len(friction))
    bound = float((friction * np.abs(loads.p0)).mean()) or force
    return bound / demand if demand > 0 else 1.0
