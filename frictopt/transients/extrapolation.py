"""The limit of an affine map from its iterates, and states that span all later ones."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..contact.checks import Array
from ..contact.tolerances import PERIODIC, RESIDUAL, ROUNDING

_AFFINE_FIT = 1e3 * RESIDUAL  # deviation of a state from the linear map fitted to all states: the fit divides by small differences

SLOW = 1e-3
"""A drift that changes by a smaller share of itself from cycle to cycle needs more than ten thousand cycles to die out."""


def limit_of(iterates: Array) -> tuple[Array, list[tuple[Array, Array]]] | None:
    """The limit of an affine map from some of its iterates (rows), and states around it, before and after a cycle, of which all later ones are means.

    The limit is that of reduced-rank extrapolation. The k-th later distance from it is `sum of rate_i^k mode_i` with
    1 > rate_1 > ... > rate_m >= 0. It is `rate_m^k` times the last distance, plus `rate_i^k - rate_(i + 1)^k` times the sum of the first i modes, for
    all i < m. The states are these sums, each times a number c_i. The later states are then weighted means of them, of the last state and of the
    limit, if the sum of `(rate_i^k - rate_(i + 1)^k) / c_i` is at most `1 - rate_m^k` for all k. This always holds with c_i = 1; smaller c_i are used
    where they suffice.

    Returns None if no single linear map fits all distances, or if they do not decay monotonically: a rate is complex, negative or not below 1.
    """
    limit = fixed_point(iterates)
    distances = iterates - limit
    left, sizes, right = np.linalg.svd(distances[:-1].T, full_matrices=False)
    kept = sizes > PERIODIC
    basis = left[:, kept]
    step = basis.T @ distances[1:].T @ right[kept].T / sizes[kept]
    off = np.abs(distances[1:].T - basis @ step @ basis.T @ distances[:-1].T).max(axis=0)
    if np.any(off > PERIODIC + _AFFINE_FIT * np.abs(distances[:-1]).max(axis=1)):
        return None
    rates, vectors = np.linalg.eig(step)
    modes = basis @ vectors * np.linalg.solve(vectors, basis.T @ distances[-2])
    counted = np.abs(modes).max(axis=0, initial=0.0) > PERIODIC
    rates, modes = rates[counted], modes[:, counted]
    if not len(rates) or np.any(np.abs(rates.imag) > 0) or np.any(rates.real < 0) or np.any(rates.real >= 1):
        return None
    order = np.argsort(-rates.real)
    rates, modes = rates.real[order], modes.real[:, order]
    powers = rates ** np.unique(np.geomspace(1, 1e6, 200).round())[:, None]
    shares = (-np.diff(powers, axis=1) / (1 - powers[:, -1:])).max(axis=0) * (len(rates) - 1)
    shares = shares if shares.max(initial=0.0) < 1 else np.ones_like(shares)
    before, after = (shares * np.cumsum(part, axis=1)[:, :-1] for part in (modes, modes * rates))
    return limit, list(zip(before.T, after.T, strict=True))


def fixed_point(iterates: Array) -> Array:
    """The fixed point of a map from some of its iterates (rows), by reduced-rank extrapolation; the first of them where one does not move."""
    steps = np.diff(iterates, axis=0)
    if not np.linalg.norm(steps, axis=1).min() > 0:
        return np.asarray(iterates[0])
    return np.asarray(iterates[0] + np.linalg.lstsq(np.diff(steps, axis=0).T, -steps[0], rcond=ROUNDING)[0] @ steps[:-1])


def distance_left(changes: Sequence[float], rounding: float) -> float:
    """Estimated distance from the limit: the sum of all later changes, if they decay by the largest ratio of the last ones.

    A change up to `rounding` is the distance itself, whatever the ratio.
    """
    if changes[-1] <= rounding:
        return changes[-1]
    factor = max((later / earlier if earlier > 0 else np.inf for earlier, later in pairwise(changes)), default=1.0)
    return changes[-1] * factor / (1 - factor) if factor < 1 else np.inf


def drift_text(change: float, decay: float) -> str:
    """What to make of a slip that changes by `change` slip scales a cycle, where this change alters by the share `decay` from cycle to cycle."""
    return (
        f"the slip drifts by {change:.1e} slip scales a cycle, and from one cycle to the next this drift changes by only {decay:.1e} of itself: slow "
        "ratcheting, or a body that rolls or that nothing guides; guide it by a Support, or follow its drift with march"
    )
