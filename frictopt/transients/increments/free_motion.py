"""Motions of a contact that only friction resists, and what to say where the loads push one and no state is found."""

import numpy as np
from scipy.linalg import null_space

from ...contact.checks import Array
from ...contact.system import ContactSystem
from ...contact.tolerances import NO_FORCE, RIGID, ROUNDING
from ...errors import NoContinuation

__all__ = ["free_motions", "moves_away"]

_STRAIGHT = 0.1  # share of the largest motion from which a node counts as moved, and the mean of all motions as one direction


def free_motions(S: Array, stiffness: Array) -> Array:
    """(M, k) orthonormal motions that S does not resist; `stiffness` (M,) is the size of each direction's own, > 0."""
    root = np.sqrt(stiffness)
    values, vectors = np.linalg.eigh(S / np.outer(root, root))
    return np.asarray(np.linalg.qr(vectors[:, values <= RIGID] / root[:, None])[0])


def moves_away(system: ContactSystem, friction: Array, free: Array, trial: Array, force: float) -> NoContinuation | None:
    """Name the free motion that the reactions `trial` of the closed contact, of the size of `force`, push; None where they push none."""
    n, p = system.nodes, trial[-system.nodes :]
    for basis in (free @ null_space(free[-n:]), free):  # along the contact alone, then off it, too
        push = -basis @ (basis.T @ trial)
        moved = push.reshape(-1, n)
        motions = np.einsum("in,nij->nj", moved, system.frames)
        sizes = np.linalg.norm(motions, axis=1)
        largest = float(sizes.max())
        demand = float(-push @ trial) / (largest or 1.0)
        if demand > NO_FORCE * force and moved[-1].min() >= -ROUNDING * largest:
            break
    else:
        return None
    held = float(friction * np.maximum(p, 0.0) @ np.linalg.norm(moved[:-1], axis=0)) / largest
    along = motions.sum(axis=0) / sizes.sum()
    straight, count = np.linalg.norm(along) > _STRAIGHT, int((sizes > _STRAIGHT * largest).sum())
    way = f"along ({', '.join(f'{part + 0.0:.3g}' for part in along.round(3))})" if straight else "that turns it"
    return NoContinuation(
        f"friction increment: no state is found, and only friction holds {count} of {n} nodes against a "
        f"motion {way}: the loads push with {demand:.3g}, friction f p of the closed contact holds {held:.3g}; hold the body, or press it harder"
    )
