"""Rigid motions, without functions of the package."""

import numpy as np
from scipy.linalg import eigh


def free_motions(system):
    """(M, k) orthonormal motions without strain, by the eigenvalues of the scaled stiffness."""
    root = np.sqrt(system.own_stiffness)
    values, vectors = eigh(system.S / np.outer(root, root))
    return np.linalg.qr(vectors[:, values < 1e-12 * len(values)] / root[:, None])[0]
