"""The load side of the safe-slip inequalities: which corner rules each node, and what its duals mean."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contact.checks import Array
from .interface import Interface

__all__ = ["LoadRows", "Loads", "load_rows"]

Integers = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True, eq=False)
class Loads:
    """Closed reactions of a load cycle: mean (N,) `q0, p0` and corners at load factor 1 (K, N) `q1, p1`, force per depth."""

    q0: Array
    p0: Array
    q1: Array
    p1: Array

    @property
    def corners(self) -> int:
        """Number of corners, K."""
        return len(self.q1)


@dataclass(frozen=True, eq=False)
class LoadRows:
    """Right-hand sides of `q + g >= load_factor * forward` and `g - q >= load_factor * backward`, in units of the interface.

    Each row belongs to a node and a corner. `g = f p` is the friction bound, `forward = -(q1 + f p1)`, `backward = q1 - f p1`. For a load factor
    >= 0 the corners of one node and one sense differ only in the coefficient of the load factor, so the largest one rules and the others
    are implied.

    Attributes
    ----------
    node
        (R,) position of the row's node among the interface's nodes.
    friction, q_mean, g_mean, forward, backward
        (R,) coefficients of the rows; loads divided by the node's unit and forward, backward multiplied by `load_unit`.
    forward_corner, backward_corner
        (R,) corner that each row speaks for.
    load_unit
        Load factor that the dimensionless load factor is measured in.
    """

    node: Integers
    friction: Array
    q_mean: Array
    g_mean: Array
    forward: Array
    backward: Array
    forward_corner: Integers
    backward_corner: Integers
    load_unit: float


def load_rows(interface: Interface, loads: Loads, friction: Array, every_corner: bool) -> LoadRows:
    """Rows of the kept nodes: one per node and sense for the ruling corner, or one for every corner."""
    nodes, unit = interface.nodes, interface.unit
    f, q0, p0, q1, p1 = friction[nodes], loads.q0[nodes], loads.p0[nodes], loads.q1[:, nodes], loads.p1[:, nodes]
    forward, backward = -(q1 + f * p1), q1 - f * p1
    if every_corner:
        node = np.tile(np.arange(len(nodes)), loads.corners)
        corner = np.repeat(np.arange(loads.corners), len(nodes))
        corners = corner, corner
    else:
        node = np.arange(len(nodes))
        corners = forward.argmax(axis=0), backward.argmax(axis=0)
    load_unit = _load_unit(interface, loads, friction)
    return LoadRows(
        node=node,
        friction=f[node],
        q_mean=(q0 / unit)[node],
        g_mean=(f * p0 / unit)[node],
        forward=forward[corners[0], node] / unit[node] * load_unit,
        backward=backward[corners[1], node] / unit[node] * load_unit,
        forward_corner=corners[0],
        backward_corner=corners[1],
        load_unit=load_unit,
    )


def _load_unit(interface: Interface, loads: Loads, friction: Array) -> float:
    """Load factor at which the cyclic reactions reach the size of the mean friction bound."""
    demand = float(np.abs(loads.q1).mean() + (friction * np.abs(loads.p1)).mean())
    bound = float((friction * np.abs(loads.p0)).mean()) or interface.force
    return bound / demand if demand > 0 else 1.0
