"""States that span all later ones, of those that one affine map makes from each other."""

import numpy as np

from ..contact.checks import Array
from ..contact.tolerances import AFFINE_FIT, PERIODIC

__all__ = ["slower_modes"]


def slower_modes(distances: Array) -> list[tuple[Array, Array]] | None:
    """States around a fixed point, before and after a cycle, whose weighted means are all later states; from the distances to it (rows).

    The k-th later distance is `sum of rate_i^k mode_i` with 1 > rate_1 > ... > rate_m >= 0. It is `rate_m^k` times the last distance, plus
    `rate_i^k - rate_(i + 1)^k` times the sum of the first i modes, for all i < m. The states are these sums, each times a number c_i. The later
    states are then weighted means of them, of the last state and of the fixed point, if the sum of `(rate_i^k - rate_(i + 1)^k) / c_i` is at most
    `1 - rate_m^k` for all k. This always holds with c_i = 1; smaller c_i are used where they suffice.

    Returns None if no single linear map fits all distances, or if they do not decay monotonically: a rate is complex, negative or not below 1.
    """
    left, sizes, right = np.linalg.svd(distances[:-1].T, full_matrices=False)
    kept = sizes > PERIODIC
    basis = left[:, kept]
    step = basis.T @ distances[1:].T @ right[kept].T / sizes[kept]
    off = np.abs(distances[1:].T - basis @ step @ basis.T @ distances[:-1].T).max(axis=0)
    if np.any(off > PERIODIC + AFFINE_FIT * np.abs(distances[:-1]).max(axis=1)):
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
    return list(zip(before.T, after.T, strict=True))
