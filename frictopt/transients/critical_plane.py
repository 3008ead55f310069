"""Parameters of multiaxial fatigue at one point, on given planes or on the critical plane."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base import Array, worst

# The numbers of the search for the critical plane.

# Number of planes that are tried first. They are about 5 degrees apart.
_PLANES = 800
# Number of the best planes that are refined: the best plane alone may lie at a lower peak of the
# parameter.
_BEST = 20
# Size of the first steps about each of these planes, degrees.
_STEP = 5.0
# Ratio of the step in the next round to the step in the present round.
_FINER = 0.4
# Number of rounds. The last steps are 0.001 degrees.
_ROUNDS = 10
# Number of tensors that are looked at together, so that arrays of all planes stay below 100 MB.
_AT_ONCE = 1000

# Relative difference up to which shear amplitudes or principal stresses count as equal.
EQUAL = 1e-9


# Parameters that count as 0 if pressure makes them negative.
NOT_NEGATIVE = ("SWT", "Fatemi_Socie")
# Parameters whose critical plane depends on the mean stress, and is searched for.
SEARCHED = (*NOT_NEGATIVE, "Findley")
# Parameters that do not belong to a plane.
WITHOUT_PLANE = ("Crossland", "Dang_Van")
PARAMETERS = (*SEARCHED, "Matake", *WITHOUT_PLANE)
"""Names of the parameters of `parameter_on`."""


def critical_planes(
    stress: ArrayLike, strain: ArrayLike, weights: Mapping[str, float]
) -> dict[str, Array]:
    """(P,) parameters of points over M states, each on the plane on which it is largest.

    Stress and strain are (M, P, 3, 3). `weights` has a weight for each parameter, also for SWT,
    which does not use it, see `parameter_on`. The result also has `from` and `to`, the least and
    the largest normal stress on the plane of SWT.

    Examples
    --------
    >>> import numpy as np
    >>> from frictopt.transients.critical_plane import critical_planes
    >>> pull = np.diag([100.0, 0.0, 0.0])
    >>> states = [[pull], [-pull]], [[pull / 200e3], [-pull / 200e3]]
    >>> found = critical_planes(*states, dict.fromkeys(["SWT", "Findley", "Crossland"], 0.0))
    >>> [round(found[name].item(), 6) for name in ("SWT", "Findley", "Crossland", "from")]
    [0.05, 50.0, 57.735027, -100.0]
    """
    sigma = np.asarray(stress, dtype=float)
    epsilon = np.asarray(strain, dtype=float)
    values = dict[str, Array]()
    planes = dict[str, list[Array]]()
    for name, weight in weights.items():
        values[name], planes[name] = largest(name, sigma, epsilon, weight)
    normal_stress = _normal(sigma, np.array(planes["SWT"]))[..., 0]
    return values | {"from": normal_stress.min(axis=0), "to": normal_stress.max(axis=0)}


def largest(name: str, sigma: Array, epsilon: Array, weight: float) -> tuple[Array, list[Array]]:
    """(P,) largest values of a parameter over all planes, and the normals of each point's planes.

    Stress and strain are (M, P, 3, 3). The normals are those of `planes_of`. Negative values of the
    parameters in `NOT_NEGATIVE` count as 0.
    """
    least = 0.0 if name in NOT_NEGATIVE else -np.inf
    values = list[Array]()
    planes = list[Array]()
    count = max(1, _AT_ONCE // len(sigma))
    for start in range(0, sigma.shape[1], count):
        states = sigma[:, start : start + count], epsilon[:, start : start + count]
        normals = planes_of(name, *states, weight)
        on_planes, _ = parameter_on(name, *states, weight, normals)
        values.extend(on_planes.max(axis=-1, initial=least))
        planes.extend(normals)
    return np.array(values), planes


def parameter_on(
    name: str, sigma: Array, epsilon: Array, weight: float, normals: Array
) -> tuple[Array, Array]:
    """A parameter of points on planes, and its derivative by a stress added to all states.

    Stress, tension positive, and strain are (M, P, 3, 3), normals are (P, planes, 3). Values are
    (P, planes), derivatives are (P, planes, 3, 3): the added stress changes means, but no ranges.
    For a single point, the axis P may be left out. The amplitude of a vector is half the largest
    distance between two states, which is exact for loads in phase.

    - SWT: largest normal stress on the plane times the amplitude of its normal strain.
    - Findley: shear amplitude plus `weight` times the largest normal stress. Matake: the same sum,
      on the planes of the largest shear amplitude.
    - Fatemi_Socie: amplitude of the shear angle times 1 plus `weight` times the largest normal
      stress.
    - Crossland, which has no plane: amplitude of the root of J2 plus `weight` times the largest
      hydrostatic stress.
    - Dang_Van, which has no plane: Tresca's shear stress plus `weight` times the hydrostatic
      stress, at the state with the largest sum. Deviators are measured from the centre of the
      smallest ball around the deviators of all states.
    """
    squares = normals[..., :, None] * normals[..., None, :]
    tension = _normal(sigma, normals).max(axis=0)
    if name == "SWT":
        strains = _normal(epsilon, normals)
        amplitude = (strains.max(axis=0) - strains.min(axis=0)) / 2
        return amplitude * tension, amplitude[..., None, None] * squares
    if name in ("Findley", "Matake"):
        return _amplitude(_shear(sigma, normals)) + weight * tension, weight * squares
    if name == "Fatemi_Socie":
        angle = 2 * _amplitude(_shear(epsilon, normals))
        return angle * (1 + weight * tension), weight * angle[..., None, None] * squares
    hydrostatic = np.trace(sigma, axis1=-2, axis2=-1) / 3
    deviator = sigma - hydrostatic[..., None, None] * np.eye(3)
    vectors = deviator.reshape(*hydrostatic.shape, 9)
    if name == "Crossland":
        value = _amplitude(vectors) / np.sqrt(2) + weight * hydrostatic.max(axis=0)
    else:
        principal = np.linalg.eigvalsh(
            deviator - _centre(vectors).reshape(*vectors.shape[1:-1], 3, 3)
        )
        shear = (principal[..., -1] - principal[..., 0]) / 2
        value = (shear + weight * hydrostatic).max(axis=0)
    return np.asarray(value)[..., None], weight * np.eye(3)[None] / 3


def planes_of(name: str, sigma: Array, epsilon: Array, weight: float) -> Array:
    """(P, planes, 3) normals of the planes on which a parameter of points is largest.

    For Matake they are all planes with the largest shear amplitude; at points with fewer such
    planes, some are listed twice. For Crossland and Dang_Van, which have no plane, the normal is
    arbitrary.
    """
    if name in SEARCHED:
        return _critical_plane(lambda n: parameter_on(name, sigma, epsilon, weight, n)[0])
    of_points = [
        _most_sheared(stress) if name == "Matake" else np.eye(3)[:1]
        for stress in sigma.swapaxes(0, 1)
    ]
    count = max(map(len, of_points))
    return np.array([np.resize(normals, (count, 3)) for normals in of_points])


def _most_sheared(sigma: Array) -> Array:
    """(planes, 3) normals of the planes of one point with the largest shear amplitude.

    If these normals form a ring, as for tension along one axis, 72 of them are returned.
    """
    first, second = np.triu_indices(len(sigma), 1)
    sizes, axes = np.linalg.eigh(sigma[first] - sigma[second])
    shear = sizes[:, 2] - sizes[:, 0]
    normals = list[Array]()
    largest = shear.max(initial=0.0)
    for size, axis in zip(sizes, axes, strict=True):
        same = size[[0, 2]] - size[1]
        if size[2] - size[0] < largest * (1 - EQUAL):
            continue
        turns = np.array([0.0, np.pi])
        alike = np.abs(same) <= EQUAL * largest
        if alike.any():
            turns = 2 * np.pi * np.arange(72) / 72
        # If two principal values are equal, `lone` is the axis of the third.
        lone, other = (0, 2) if alike[1] else (2, 0)
        around = np.outer(np.cos(turns), axis[:, other]) + np.outer(np.sin(turns), axis[:, 1])
        normals.extend((axis[:, lone] + around) / np.sqrt(2))
    return np.array(normals)


def _centre(points: Array) -> Array:
    """(..., k) centre of the smallest ball around M points (M, ..., k), by a cone program."""
    if points.ndim > 2:
        return np.array([_centre(points[:, i]) for i in range(points.shape[1])])
    count, k = points.shape
    middle = points.mean(axis=0)
    size = np.abs(points - middle).max(initial=0.0)
    if count < 3 or size == 0:
        return np.asarray((points.max(axis=0) + points.min(axis=0)) / 2)
    # Unknowns: the centre and the radius. A cone for each point: |point - centre| <= radius.
    head = np.r_[np.zeros(k), -1.0]
    cone = np.vstack([head, np.eye(k, k + 1)])
    right = np.column_stack([np.zeros(count), (points - middle) / size]).ravel()
    # Imported here, because a path in the plane needs no solver.
    from scipy.sparse import csr_array

    from ..solve.answer import answer
    from ..solve.arrays import Arrays

    program = Arrays(
        sparse=csr_array(np.tile(cone, (count, 1))),
        block=np.zeros((0, k + 1)),
        right=right,
        cost=-head,
        zero=0,
        sizes=np.full(count, k + 1),
    )

    def claimed(x: Array, y: Array) -> Ball:
        bound, error = program.lower_bound(x, y)
        return Ball(x[:k], worst([program.violation(x), float(abs(x[k] - bound)) + error]))

    ball, _ = answer(program, claimed)
    return np.asarray(middle + size * ball.centre)


class Ball(NamedTuple):
    """The centre of a ball, with the residual of its program."""

    centre: Array
    residual: float


def furthest(values: Array) -> Array:
    """(..., k) difference of the two vectors that are furthest apart among M vectors (M, ..., k).

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
    """(M, ..., planes) normal components on planes with normals (..., planes, 3)."""
    return np.asarray(np.vecdot(normals @ tensors, normals))


def _shear(tensors: Array, normals: Array) -> Array:
    """(M, ..., planes, 3) components along the planes."""
    vectors = normals @ tensors
    return vectors - _normal(tensors, normals)[..., None] * normals


def _amplitude(vectors: Array) -> Array:
    """Half the largest distance between two of M vectors, (M, ..., k)."""
    return np.asarray(np.linalg.norm(furthest(vectors), axis=-1) / 2)


def _critical_plane(value: Callable[[Array], Array]) -> Array:
    """(P, 1, 3) normals with the largest `value`, a function of normals (..., planes, 3).

    The search begins at evenly spread points of the half-sphere. The search continues from the best
    of these points, with ever finer grids about each.
    """
    best = half_sphere(_PLANES)
    best = best[np.argsort(value(best))[..., -_BEST:]]
    grid = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)], dtype=float)
    step = _STEP
    for _ in range(_ROUNDS):
        # Two directions across each normal, and the normals of its grid (P, best, 9, 3).
        axis = np.eye(3)[np.abs(best).argmin(axis=-1)]
        along_axis = axis - best * np.vecdot(best, axis)[..., None]
        across = np.stack([np.cross(best, axis), along_axis], axis=-2)
        across /= np.linalg.norm(across, axis=-1)[..., None]
        tilted = best[..., None, :] + np.tan(np.radians(step)) * (grid @ across)
        tilted /= np.linalg.norm(tilted, axis=-1)[..., None]
        values = value(tilted.reshape(len(best), -1, 3)).reshape(tilted.shape[:-1])
        best = _with_largest(values, tilted)
        step *= _FINER
    return _with_largest(value(best), best)[:, None]


def _with_largest(values: Array, normals: Array) -> Array:
    """(..., 3) the normal with the largest of the values (..., planes)."""
    return np.take_along_axis(normals, values.argmax(axis=-1)[..., None, None], axis=-2)[..., 0, :]


def half_sphere(count: int) -> Array:
    """(count, 3) unit vectors, evenly spread along a spiral."""
    height = (np.arange(count) + 0.5) / count
    turn = np.pi * (1 + np.sqrt(5)) * np.arange(count)
    radius = np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
