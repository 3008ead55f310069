"""A change of variables by the inverse of a square block, which may be singular: its values as unknowns, and what it does not resist."""

from collections.abc import Sequence

import cvxpy as cp
import numpy as np
from scipy.linalg import cholesky, lu_factor, lu_solve, qr, svd
from scipy.linalg.lapack import dpotri
from scipy.sparse import csr_array, hstack

from ..contact import CONDENSATION, RIGID, ROUNDING, Array
from .reduced import Change

_FIRST, _ITERATIONS = 8, 4  # of an inverse iteration: vectors at first, twice as many where all are soft, and steps


def unresisted(square: Array, others: Array, along: Array, across: Array) -> tuple[Array, Array]:
    """Orthonormal vectors x (t, k) that a symmetric, positive semi-definite matrix does not resist, nor others, and its inverse on the rest (t, t).

    Each x counts in units of 1 over `along` (t,), and each of the others, (o, t), in `across` (o,), so that a soft unknown beside stiff ones is not
    taken for a free one. An x that changes one of the others is resisted, however little.
    """
    t = len(along)
    scaled, pressure = square / np.outer(along, along), others / np.outer(across, along)
    idle = ~(scaled.any(axis=0) | (np.abs(pressure).max(axis=0, initial=0.0) > RIGID))
    scaled[idle, idle] = 1.0  # what nothing feels at all is free by itself, so that the others stay exact
    factor, rng, count, stiffest = lu_factor(scaled + RIGID * np.eye(t)), np.random.default_rng(0), 0, 0.0
    while stiffest <= RIGID and count < t:  # inverse iteration of more vectors than there are soft ones, which many small eigenvalues cannot slow
        count = min(2 * count or _FIRST, t)
        soft = rng.normal(size=(t, count))
        for _ in range(_ITERATIONS):
            soft = np.linalg.qr(lu_solve(factor, soft))[0]
        values, turn = np.linalg.eigh(soft.T @ scaled @ soft)
        stiffest = values[-1]
    values, soft = values[values <= RIGID], (soft @ turn)[:, values <= RIGID]
    soft[idle] = 0.0
    held = (values > 0) & (np.abs(pressure @ soft).max(axis=0, initial=0.0) > RIGID)
    share = np.where(held, 1 / np.where(held, values, 1.0), 0.0) - 1 / (1 + values)
    root = cholesky((scaled + soft @ soft.T).T, lower=True, overwrite_a=True, check_finite=False)  # soft vectors have the stiffness 1 + value
    inverse = np.tril(dpotri(root, lower=1, overwrite_c=1)[0])
    inverse += np.tril(inverse, -1).T + (soft * share) @ soft.T
    inverse /= np.outer(along, along)
    rigid = np.hstack([np.linalg.qr(soft[:, ~held] / along[:, None])[0], np.eye(t)[:, idle]])
    inverse -= rigid @ (rigid.T @ inverse)
    return rigid, np.asarray(inverse - (inverse @ rigid) @ rigid.T)


def by_inverse(row: cp.Constraint, others: Sequence[cp.Constraint], free: Array, inverse: Array, unit: Array, sizes: Array) -> Change:
    """The change of variables of a dense equation of a square matrix, whose unknowns are its values, and what it does not resist.

    The values balance each other on `free` (t, k): those of k rows follow from the others. The first of the `others`, dense equations of the
    same unknowns, does not feel the free vectors; what the rest may feel of them is turned so that each is felt, or not at all. `unit` (t,) are the
    units of the values, `sizes` (k,) those of the free vectors.
    """
    each, count = unit[:, None], free.shape[1]
    resting = each * free
    pivots = qr(resting.T, mode="r", pivoting=True)[1] if count else np.arange(len(each))
    balancing, loaded = pivots[:count], np.sort(pivots[count:])
    basis = np.zeros((len(each), len(loaded)))  # unit values, balanced by those at as many rows as there are free vectors
    basis[loaded, np.arange(len(loaded))] = 1.0
    basis[balancing] = -np.linalg.solve(resting[balancing].T, resting[loaded].T)
    basis[np.abs(basis) <= ROUNDING] = 0.0
    values = csr_array(each * basis)
    held, turned = (values.T @ inverse).T, free * sizes
    matrices = {other: np.asarray(other.args[1].args[0].value) for other in others}
    feeling = np.vstack([np.zeros((0, len(each))), *(matrices[other] for other in others[1:])])
    if count and len(feeling):
        turned = turned @ svd(feeling @ turned)[2].T
    blocks = dict[cp.Constraint, Array]()
    for other, matrix in matrices.items():
        moved = np.zeros((len(matrix), count)) if other is others[0] else matrix @ turned
        moved[:, np.abs(moved).max(axis=0, initial=0.0) <= CONDENSATION * np.abs(turned).max(axis=0, initial=0.0)] = 0.0
        blocks[other] = np.hstack([matrix @ held, moved])
    product = csr_array(hstack([values, csr_array((len(each), count))]))
    return Change(row, np.hstack([held, turned]), product, blocks, np.ones(product.shape[1]), loaded)
