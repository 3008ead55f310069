"""The load side of the safe-slip inequalities in the plane: which corner rules each node."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..contact.checks import Array
from .question import LimitQuestion

__all__ = ["ruling_loads"]


def ruling_loads(unit: Array, task: LimitQuestion) -> tuple[Mapping[str, Array], tuple[np.ndarray[Any, np.dtype[np.intp]], ...]]:
    """Coefficients of `q + g >= lam forward`, `g - q >= lam backward` and `p >= lam opening`, and the (N,) corners that rule these three rows.

    `g = f p` is the friction bound, `forward = -(q1 + f p1)`, `backward = q1 - f p1`, `opening = -p1`. For a load factor >= 0 the corners of one node
    and one kind of row differ only in the coefficient of the load factor, so the largest one rules and the others are implied. The rows of opening
    follow from the other two where there is friction.

    The coefficients, (N,) each, are friction, q_mean, p_mean, fp_mean, forward, backward, opening, and clearance, the mean friction bound: forces
    over the (N,) `unit` of the nodes, and load factors in the unit of the question.
    """
    loads, friction = task.loads, task.friction
    ruled = {"forward": -(loads.q1 + friction * loads.p1), "backward": loads.q1 - friction * loads.p1, "opening": -loads.p1}
    means = {"q_mean": loads.q0, "p_mean": loads.p0, "fp_mean": friction * loads.p0, "clearance": np.full_like(unit, task.mean_bound)}
    forces = {**means, **{name: load.max(axis=0) * task.load_unit for name, load in ruled.items()}}
    return {"friction": friction, **{name: force / unit for name, force in forces.items()}}, tuple(load.argmax(axis=0) for load in ruled.values())
