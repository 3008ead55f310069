"""The load side of the safe-slip inequalities: which corner rules each node."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contact.checks import Array
from .loads import Loads

__all__ = ["RulingLoads", "ruling_loads"]

Integers = np.ndarray[Any, np.dtype[np.intp]]


@dataclass(frozen=True, eq=False)
class RulingLoads:
    """Right-hand sides of `q + g >= load_factor * forward`, `g - q >= load_factor * backward` and `p >= load_factor * opening`.

    All in the units of the nodes, see `ScaledContact`, one row of each kind for each node. `g = f p` is the friction bound, `forward = -(q1 + f p1)`,
    `backward = q1 - f p1`, `opening = -p1`. For a load factor >= 0 the corners of one node and one kind of row differ only in the coefficient of
    the load factor, so the largest one rules and the others are implied. The rows of opening follow from the other two where there is friction.

    Attributes
    ----------
    friction, q_mean, fp_mean, p_mean, forward, backward, opening
        (n,) coefficients of the rows; loads divided by the node's unit and forward, backward, opening multiplied by `load_unit`.
    corners
        (n,) corner that rules each row, for the rows of forward, backward and opening.
    load_unit
        Load factor that the dimensionless load factor is measured in.
    clearance
        (n,) mean friction bound in the units of the nodes.
    """

    friction: Array
    q_mean: Array
    fp_mean: Array
    p_mean: Array
    forward: Array
    backward: Array
    opening: Array
    corners: tuple[Integers, Integers, Integers]
    load_unit: float
    clearance: Array


def ruling_loads(unit: Array, loads: Loads, friction: Array, load_unit: float, mean_bound: float) -> RulingLoads:
    """Rows of the nodes, one for each node and sense: those of the ruling corner; `unit` is the force unit of each."""
    forward, backward, opening = -(loads.q1 + friction * loads.p1), loads.q1 - friction * loads.p1, -loads.p1
    return RulingLoads(
        friction=friction,
        q_mean=loads.q0 / unit,
        fp_mean=friction * loads.p0 / unit,
        p_mean=loads.p0 / unit,
        forward=forward.max(axis=0) / unit * load_unit,
        backward=backward.max(axis=0) / unit * load_unit,
        opening=opening.max(axis=0) / unit * load_unit,
        corners=(forward.argmax(axis=0), backward.argmax(axis=0), opening.argmax(axis=0)),
        load_unit=load_unit,
        clearance=mean_bound / unit,
    )
