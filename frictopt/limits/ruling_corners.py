"""The load side of the safe-slip inequalities in the plane: which corner rules each node."""

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..contact.checks import Array
from .question import LimitQuestion

__all__ = ["Ruling", "ruling", "ruling_loads"]

Integers: TypeAlias = NDArray[np.intp]
Ruling: TypeAlias = tuple[Integers, Integers]


def ruling(constant: Array, rate: Array, load_factor: float | None = None) -> Ruling:
    """(R,) corners and nodes of the rows that rule `x >= constant_k + lam rate_k` at a load factor >= 0, or (None) at some load factor >= 0.

    `constant` is (K, N), or (1, N) where the corners of a node differ only in the coefficient of the load factor: then the largest one rules. Else
    the largest row is a chain of straight lines, from corner to corner of larger rates.
    """
    every = np.arange(rate.shape[1])
    if len(constant) == 1:
        return rate.argmax(axis=0), every
    if load_factor is not None:
        return (constant + load_factor * rate).argmax(axis=0), every
    highest = constant == constant.max(axis=0)
    corner, node = np.where(highest, rate, -np.inf).argmax(axis=0), every
    rows = [(corner, node)]
    while node.size:
        gain, lead = rate[:, node] - rate[corner, node], constant[corner, node] - constant[:, node]
        meets = np.where(gain > 0, lead / np.where(gain > 0, gain, 1.0), np.inf)
        corner, further = meets.argmin(axis=0), np.isfinite(meets.min(axis=0))
        corner, node = corner[further], node[further]
        rows.append((corner, node))
    corners, nodes = (np.concatenate(part) for part in zip(*rows, strict=True))
    return corners, nodes


def ruling_loads(unit: Array, task: LimitQuestion) -> tuple[Mapping[str, Array], tuple[Ruling, ...]]:
    """Coefficients of `q + g >= lam forward`, `g - q >= lam backward` and `p >= lam opening`, and what rules these three rows, see `ruling`.

    `g = f p` is the friction bound, `forward = -(q1 + f p1)`, `backward = q1 - f p1`, `opening = -p1`. For a load factor >= 0 the corners of one node
    and one kind of row differ only in the coefficient of the load factor, so the largest one rules and the others are implied. The rows of opening
    follow from the other two where there is friction.

    The coefficients, (N,) each, are friction, q_mean, p_mean, fp_mean, forward, backward, opening, and clearance, the mean friction bound: forces
    over the (N,) `unit` of the nodes, and load factors in the unit of the question. Of a cycle of which nothing is fixed.
    """
    loads, friction = task.loads, task.friction
    ruled = {"forward": -(loads.q1 + friction * loads.p1), "backward": loads.q1 - friction * loads.p1, "opening": -loads.p1}
    (q0,), (p0,) = loads.q0, loads.p0
    means = {"q_mean": q0, "p_mean": p0, "fp_mean": friction * p0, "clearance": np.full_like(unit, task.mean_bound)}
    forces = {**means, **{name: load.max(axis=0) * task.load_unit for name, load in ruled.items()}}
    return {"friction": friction, **{name: force / unit for name, force in forces.items()}}, tuple(ruling(loads.p0, load) for load in ruled.values())
