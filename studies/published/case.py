"""One result of others, and the computation of the same result by frictopt."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import frictopt as fo

Array = npt.NDArray[np.float64]

# Nodes with less than this share of the largest pressure are open.
_LOADED = 1e-9
# A node sticks if its relative distance from the friction bound is larger.
_STUCK = 1e-7


@dataclass(frozen=True, eq=False)
class Case:
    """A quantity from one source at several values of a parameter.

    Parameters
    ----------
    source
        The source of the result.
    quantity, over
        The quantity, and the parameter; without a parameter it is one number.
    how
        The computation by frictopt, and the reason for a difference.
    at
        Values of the parameter.
    theirs
        The result of others at such a value.
    ours
        The result of frictopt at each value.
    residual
        Largest residual of the answers.
    curve
        Whether the result of others is cheap enough to be drawn as a curve.
    """

    source: str
    quantity: str
    over: str
    how: str
    at: Sequence[float]
    theirs: Callable[[float], float]
    ours: Sequence[float]
    residual: float
    curve: bool = True


def opposed(mean: dict[str, float], swing: dict[str, float]) -> fo.LoadCycle:
    """A cycle around a mean load between a swing and the opposite swing, the swing first."""
    return fo.LoadCycle(mean, [swing, {name: -value for name, value in swing.items()}])


def first_loading(
    system: fo.ContactSystem, cycle: fo.LoadCycle, f: float, steps: int | None = None
) -> tuple[Array, Array, float]:
    """Shear and normal forces at the first corner, and the residual.

    The corner is reached from the mean load without earlier slip.
    """
    path = fo.march(system, cycle, f, 1.0, cycles=1, steps=steps)
    at = int(np.flatnonzero(path.time == 1)[0])
    return path.q[at], path.p[at], path.residual


def stuck(q: Array, p: Array, f: float) -> npt.NDArray[np.bool_]:
    """Whether each node is loaded and below its friction bound."""
    size = np.abs(q) if q.ndim == 1 else np.linalg.norm(q, axis=1)
    return np.asarray((p > _LOADED * p.max()) & (size < f * p * (1 - _STUCK)))
