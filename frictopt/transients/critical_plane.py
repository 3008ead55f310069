"""Parameters of multiaxial fatigue at one point, on the plane on which each is largest."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..base import Array


@dataclass(frozen=True)
class PlaneSettings:
    """The numbers of the search for the critical plane."""

    # Number of planes that are tried first. They are about 5 degrees apart.
    planes: int = 800
    # Number of the best planes that are refined: the single best one may be at a lower peak.
    best: int = 20
    # Size of the first steps about each of them, degrees.
    step: float = 5.0
    # Ratio of the step in the next round to the step in the present round.
    finer: float = 0.4
    # Number of rounds. The last steps are 0.001 degrees.
    rounds: int = 10


SETTINGS = PlaneSettings()


def critical_planes(
    stress: ArrayLike, strain: ArrayLike, *, findley: float, crossland: float, fatemi_socie: float
) -> dict[str, float]:
    """Parameters of one point over M states, each on the plane on which it is largest.

    Stress, tension positive, and strain are (M, 3, 3). Amplitudes of vectors are half the largest
    distance of two states, which is exact for loads in phase. Weights are those of
    `SteadyState.fretting_table`.

    - SWT: largest tensile stress on the plane times the amplitude of its normal strain; `from` and
      `to` are the least and largest normal stress on that plane.
    - Findley: shear amplitude plus `findley` times the largest normal stress.
    - Fatemi_Socie: amplitude of the shear angle times 1 plus `fatemi_socie` times the largest
      normal stress, or 0 if pressure makes that negative.
    - Crossland, which has no plane: amplitude of the root of J2 plus `crossland` times the largest
      hydrostatic stress.

    Examples
    --------
    >>> import numpy as np
    >>> from frictopt.transients.critical_plane import critical_planes
    >>> pull = np.diag([100.0, 0.0, 0.0])
    >>> states = [pull, -pull], [pull / 200e3, -pull / 200e3]
    >>> found = critical_planes(*states, findley=0.0, crossland=0.0, fatemi_socie=0.0)
    >>> [round(found[name], 6) for name in ("SWT", "Findley", "Crossland", "from")]
    [0.05, 50.0, 57.735027, -100.0]
    """
    sigma = np.asarray(stress, dtype=float)
    epsilon = np.asarray(strain, dtype=float)
    hydrostatic = np.trace(sigma, axis1=1, axis2=2) / 3
    deviator = sigma - hydrostatic[:, None, None] * np.eye(3)

    def swt(normals: Array) -> Array:
        tension = np.maximum(_normal(sigma, normals).max(axis=0), 0.0)
        strains = _normal(epsilon, normals)
        return np.asarray(tension * (strains.max(axis=0) - strains.min(axis=0)) / 2)

    def shear(normals: Array) -> Array:
        tension = _normal(sigma, normals).max(axis=0)
        return np.asarray(_amplitude(_shear(sigma, normals)) + findley * tension)

    def angle(normals: Array) -> Array:
        tension = _normal(sigma, normals).max(axis=0)
        factor = (1 + fatemi_socie * tension).clip(0.0)
        return np.asarray(2 * _amplitude(_shear(epsilon, normals)) * factor)

    plane = _critical_plane(swt)
    normal_stress = _normal(sigma, plane)
    j2_amplitude = _amplitude(deviator.reshape(len(sigma), 9)) / np.sqrt(2)
    return {
        "SWT": float(swt(plane)[0]),
        "Findley": float(shear(_critical_plane(shear))[0]),
        "Fatemi_Socie": float(angle(_critical_plane(angle))[0]),
        "Crossland": float(j2_amplitude + crossland * hydrostatic.max()),
        "from": float(normal_stress.min()),
        "to": float(normal_stress.max()),
    }


def furthest(values: Array) -> Array:
    """(..., k) difference of the two vectors that are furthest apart, of M vectors (M, ..., k).

    Vectors with NaN do not count. The difference is 0 if no vectors are left.
    """
    if values.shape[-1] == 1:
        span = np.fmax.reduce(values, axis=0) - np.fmin.reduce(values, axis=0)
        return np.asarray(np.nan_to_num(span))
    longest: Array = np.zeros(values.shape[1:])
    for apart in range(1, len(values)):
        change = values[apart:] - values[:-apart]
        size = np.nan_to_num(np.linalg.norm(change, axis=-1), nan=0.0)[..., None]
        best = np.take_along_axis(change, size.argmax(axis=0)[None], axis=0)[0]
        is_longer = size.max(axis=0) > np.linalg.norm(longest, axis=-1, keepdims=True)
        longest = np.where(is_longer, best, longest)
    return longest


def _normal(tensors: Array, normals: Array) -> Array:
    """(M, planes) normal components on planes with normals (planes, 3)."""
    return np.asarray(np.einsum("pi,mij,pj->mp", normals, tensors, normals))


def _shear(tensors: Array, normals: Array) -> Array:
    """(M, planes, 3) components along the planes."""
    vectors = np.einsum("mij,pj->mpi", tensors, normals)
    return np.asarray(vectors - _normal(tensors, normals)[..., None] * normals)


def _amplitude(vectors: Array) -> Array:
    """Half the largest distance of two of M vectors, (M, ..., k)."""
    return np.asarray(np.linalg.norm(furthest(vectors), axis=-1) / 2)


def _critical_plane(value: Callable[[Array], Array]) -> Array:
    """(1, 3) normal of the plane with the largest value, a function of normals (planes, 3).

    The search begins at evenly spread points of the half-sphere. It continues from the best of
    them, with ever finer grids about each.
    """
    best = _half_sphere(SETTINGS.planes)
    best = best[np.argsort(value(best))[-SETTINGS.best :]]
    grid = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)], dtype=float)
    step = SETTINGS.step
    for _ in range(SETTINGS.rounds):
        # Two directions across each normal (best, 2, 3), and the normals of its grid (best, 9, 3).
        first = np.cross(best, np.eye(3)[np.abs(best).argmin(axis=1)])
        first /= np.linalg.norm(first, axis=1)[:, None]
        across = np.stack([first, np.cross(best, first)], axis=1)
        tilted = best[:, None] + np.tan(np.radians(step)) * (grid @ across)
        tilted /= np.linalg.norm(tilted, axis=2)[..., None]
        values = value(tilted.reshape(-1, 3)).reshape(len(best), -1)
        best = tilted[np.arange(len(best)), values.argmax(axis=1)]
        step *= SETTINGS.finer
    return best[[int(np.argmax(value(best)))]]


def _half_sphere(count: int) -> Array:
    """(count, 3) unit vectors, evenly spread along a spiral."""
    height = (np.arange(count) + 0.5) / count
    turn = np.pi * (1 + np.sqrt(5)) * np.arange(count)
    radius = np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
