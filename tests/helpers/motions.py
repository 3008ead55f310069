"""Rigid motions, and load cycles about their middle, without functions of the package."""

import numpy as np
from scipy.linalg import eigh

import frictopt as fo


def free_motions(system):
    """(M, k) orthonormal motions without strain, by the eigenvalues of the scaled stiffness."""
    root = np.sqrt(system.own_stiffness)
    values, vectors = eigh(system.S / np.outer(root, root))
    return np.linalg.qr(vectors[:, values < 1e-12 * len(values)] / root[:, None])[0]


def about_its_middle(cycle, load_factor):
    """The loads of a cycle at a load factor as a cycle with the load factor 1.

    The middle of its corners is its mean load.
    """
    corners = cycle.at(load_factor)
    cases = {case for corner in corners for case in corner}
    middle = {
        case: sum(corner.get(case, 0.0) for corner in corners) / len(corners) for case in cases
    }
    return fo.LoadCycle(
        middle,
        [{case: corner.get(case, 0.0) - middle[case] for case in cases} for corner in corners],
    )
