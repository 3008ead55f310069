"""One result of others, and what ours is read from."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import frictopt as fo

Array = npt.NDArray[np.float64]

_LOADED = 1e-9  # of the largest pressure: nodes with less are open
_STUCK = 1e-7  # relative distance from the friction bound from which on a node sticks


@dataclass(frozen=True, eq=False)
class Case:
    """A quantity of one source at some values of what varies.

    Parameters
    ----------
    source
        Whose result it is.
    quantity, over
        What is compared, and over what; without the latter it is one number.
    how
        What ours is computed with, and why it differs.
    at
        Values of what varies.
    theirs
        The result of others at such a value.
    ours
        Ours at each.
    residual
        Largest residual of the answers.
    curve
        Whether theirs costs so little that it is drawn as a curve.
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
    """A cycle between a swing and its opposite around a mean load, the swing first."""
    return fo.LoadCycle(mean, [swing, {name: -value for name, value in swing.items()}])


def first_loading(
    system: fo.ContactSystem, cycle: fo.LoadCycle, f: float, steps: int | None = None
) -> tuple[Array, Array, float]:
    """Shear and normal forces at the first corner, reached from the mean load without slip before, and the residual."""
    path = fo.march(system, cycle, f, 1.0, cycles=1, steps=steps)
    at = int(np.flatnonzero(path.time == 1)[0])
    return path.q[at], path.p[at], path.residual


def stuck(q: Array, p: Array, f: float) -> npt.NDArray[np.bool_]:
    """Which nodes are loaded and below their friction bound."""
    size = np.abs(q) if q.ndim == 1 else np.linalg.norm(q, axis=1)
    return np.asarray((p > _LOADED * p.max()) & (size < f * p * (1 - _STUCK)))
