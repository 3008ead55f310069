"""The compliance of open nodes, which follow the closed ones without force."""

import numpy as np

from ..contact import CONDENSATION, Array, Booleans, ContactSystem, joined

# Smallest eigenvalue of the open nodes' stiffness, over the largest, with which they leave no body free: the data have this error.
_HELD = CONDENSATION


def compliance(system: ContactSystem, opened: Booleans) -> Array | None:
    """(M, M) compliance of open nodes, zero elsewhere; None if the others, or nothing where all are open, do not hold them."""
    out, S = np.tile(opened, system.tangents + 1), system.S
    values, vectors = np.linalg.eigh(S[np.ix_(out, out)])
    held = values > _HELD * max(values[-1], np.finfo(float).tiny)
    loads = [joined(*pair) for pair in system.bonded.values()]
    driven = [r[out] @ vectors[:, ~held] / (np.abs(r).max() or 1.0) for r in loads]  # a way aside that no load takes is no matter
    if max(np.abs(part).max(initial=0.0) for part in (*driven, vectors[-int(opened.sum()) :, ~held])) > _HELD:
        return None
    give = np.zeros_like(S)
    give[np.ix_(out, out)] = (vectors[:, held] / values[held]) @ vectors[:, held].T
    return give
