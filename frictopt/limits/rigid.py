"""Slips that nothing resists, and the compliance and the tractions of what is left."""

import numpy as np
from scipy.linalg import cholesky, lu_factor, lu_solve, qr
from scipy.linalg.lapack import dpotri

from ..contact.checks import Array, Integers
from ..contact.tolerances import RIGID
from .question import LimitQuestion

_FIRST, _ITERATIONS = 8, 4  # of an inverse iteration: slips at first, twice as many where all are soft, and steps


def rigid_slides(task: LimitQuestion) -> tuple[Array, Array]:
    """Orthonormal slips that A does not resist, (t N, k), and the compliance (t N, t N) of forces that do no work on them, to slips free of them.

    Each slip and each pressure counts in units of its own stiffness, so that a soft node beside stiff ones is not taken for a free one. A slip that
    changes a pressure is resisted, however little, or S would not be positive semi-definite.
    """
    tangent, normal = np.split(np.sqrt(task.stiffness), [-len(task.friction)])
    t = len(tangent)
    scaled, pressure = task.AB[:t] / np.outer(tangent, tangent), task.AB[t:] / np.outer(normal, tangent)
    idle = ~(scaled.any(axis=0) | (np.abs(pressure).max(axis=0) > RIGID))
    scaled[idle, idle] = 1.0  # what nothing feels at all, such as slip across a mirror plane, is a slide by itself, so that the others stay exact
    factor, rng, count, stiffest = lu_factor(scaled + RIGID * np.eye(t)), np.random.default_rng(0), 0, 0.0
    while stiffest <= RIGID and count < t:  # inverse iteration of more slips than there are soft ones, which many small eigenvalues cannot slow
        count = min(2 * count or _FIRST, t)
        soft = rng.normal(size=(t, count))
        for _ in range(_ITERATIONS):
            soft = np.linalg.qr(lu_solve(factor, soft))[0]
        values, turn = np.linalg.eigh(soft.T @ scaled @ soft)
        stiffest = values[-1]
    values, soft = values[values <= RIGID], (soft @ turn)[:, values <= RIGID]
    held = (values > 0) & (np.abs(pressure @ soft).max(axis=0) > RIGID)
    share = np.where(held, 1 / np.where(held, values, 1.0), 0.0) - 1 / (1 + values)
    root = cholesky((scaled + soft @ soft.T).T, lower=True, overwrite_a=True, check_finite=False)  # soft slips have the stiffness 1 + value
    compliance = np.tril(dpotri(root, lower=1, overwrite_c=1)[0])
    compliance += np.tril(compliance, -1).T + (soft * share) @ soft.T
    compliance /= np.outer(tangent, tangent)
    rigid = np.hstack([np.linalg.qr(soft[:, ~held] / tangent[:, None])[0], np.eye(len(tangent))[:, idle]])
    compliance -= rigid @ (rigid.T @ compliance)
    return rigid, np.asarray(compliance - (compliance @ rigid) @ rigid.T)


def balanced(rigid: Array) -> tuple[Integers, Array]:
    """Basis of the nodal tractions that do no work on rigid slips (columns; each times its unit), and the rows that its columns load.

    Unit tractions at the loaded rows are balanced by forces at as many other rows as there are rigid slips.
    """
    count, k = rigid.shape
    if not k:
        return np.arange(count), np.eye(count)
    _, _, pivots = qr(rigid.T, pivoting=True)
    balancing, loaded = pivots[:k], np.sort(pivots[k:])
    basis = np.zeros((count, count - k))
    basis[loaded, np.arange(count - k)] = 1.0
    basis[balancing] = -np.linalg.solve(rigid[balancing].T, rigid[loaded].T)
    return loaded, basis
