"""The best preload and profile of a random contact: built in they have the limit that was promised, and no others within their bounds have more."""

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

import frictopt as fo

from .known import Known, NotAsked, Wrong, same

_EVERY = 4  # cases that are asked
_OTHERS = 3  # designs within the bounds that are asked for their limits, beside none
_SAME = 1e-7


def best_design(known: Known) -> tuple[float, bool]:
    """Of a random contact in the plane."""
    if known.case.seed % _EVERY:
        raise NotAsked
    return judged_design(*known.args, known.length, known.case.seed), True


def judged_design(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: ArrayLike, length: float, seed: int) -> float:
    """Residual of the best preload "b" and profile of a contact within random bounds, of which the depth is in some unit of length."""
    rng = np.random.default_rng([seed, 7])
    most, depth = rng.uniform(0.0, 0.3), length * 10.0 ** rng.uniform(-2, 0.5)
    model = fo.DesignModel(system, cycle, preloads=["b"], profile=True)
    design = model.solve(friction, [cp.abs(model.preload) <= most, cp.abs(model.profile) <= depth])
    again = fo.shakedown_limit(design.system, design.cycle, friction)
    same("the design built in", again.load_factor, design.load_factor, _SAME, _SAME)
    shares = np.vstack([np.zeros(1 + system.nodes), rng.uniform(-1, 1, (_OTHERS, 1 + system.nodes))])
    for amplitude, profile in zip(most * shares[:, 0], depth * shares[:, 1:], strict=True):
        mean = {**cycle.mean, "b": cycle.mean.get("b", 0.0) + amplitude, "added": 1.0}
        shaped = system.with_gap(system.gap + np.maximum(profile, 0.0)).with_interference({"added": np.maximum(-profile, 0.0)})
        other = fo.shakedown_limit(shaped, fo.LoadCycle(mean, cycle.corners), friction)
        if not other.open.any() and other.load_factor > design.load_factor * (1 + _SAME) + _SAME:
            raise Wrong(f"a design within the bounds has the limit {other.load_factor:.9g}, the best one {design.load_factor:.9g}")
    return max(design.residual, again.residual)
