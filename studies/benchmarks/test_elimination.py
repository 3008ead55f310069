"""The elimination of a condensation against the same elimination by scipy and by MKL Pardiso.

scipy factorises the matrix, and Pardiso computes its Schur complement. Each call is timed by the
processor time of its one thread, the rivals by turns with frictopt.
"""

import ctypes
import time

import numpy as np
import pytest
from scipy.sparse import csr_matrix, triu
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

import frictopt as fo
from frictopt.fem.condense import fronts
from frictopt.fem.schur import eliminate
from studies.validation.error_vs_time.condensation import ORDERINGS

SCENES = {
    "plane": fo.scenes.PunchOnHalfPlane(),
    "space": fo.scenes.SquarePunch(elements=29, growth=2.2),
}


@pytest.fixture(scope="module", params=SCENES)
def glued(request):
    """Stiffness of a glued contact and the front of each unknown."""
    parts = SCENES[request.param].model()._parts
    T, front = fronts(parts.glued)
    return request.param, csr_matrix(T.T @ parts.glued.K @ T), front


def least(calls, rounds=3):
    """Least processor time of each call, by turns."""
    spent = [[] for _ in calls]
    with threadpool_limits(1):
        for _ in range(rounds):
            for call, times in zip(calls, spent, strict=True):
                start = time.process_time()
                call()
                times.append(time.process_time() - start)
    return [min(times) for times in spent]


def pardiso(K, kept):
    """Schur complement of the kept unknowns by MKL's Pardiso with the ordering of Metis."""
    call = pytest.importorskip("pypardiso").PyPardisoSolver().libmkl.pardiso
    # The argument types that pypardiso declares lack the Schur complement.
    call.argtypes = None
    upper = csr_matrix(triu(K))
    upper.sort_indices()
    k, iparm = int(kept.sum()), np.zeros(64, dtype=np.int32)
    S, starts, columns, chosen = (
        np.zeros((k, k)),
        *(part.astype(np.int32) for part in (upper.indptr, upper.indices, kept)),
    )
    # These entries choose: no defaults, Metis, rows counted from zero, a Schur complement.
    iparm[[0, 1, 34, 35]] = 1, 2, 1, 1
    handle, error = np.zeros(64, dtype=np.int64), ctypes.c_int32(0)

    def number(value):
        return ctypes.byref(ctypes.c_int32(value))

    def array(values):
        return values.ctypes.data_as(ctypes.c_void_p)

    matrix = [array(values) for values in (upper.data, starts, columns, chosen)]
    # The phases factorise a positive definite matrix, and release it.
    for phase in (12, -1):
        known = [
            array(handle),
            *map(number, (1, 1, 2, phase, K.shape[0])),
            *matrix,
            number(1),
            array(iparm),
            number(0),
        ]
        call(*known, None, array(S), ctypes.byref(error))
        assert error.value == 0
    return S


def compared(ours, rival, record_property):
    """Ratio of the times of two calls, and their results."""
    one, other = least([ours, rival])
    record_property("ratio", one / other)
    print(f"\n    ours {one:.3f} s, rival {other:.3f} s, ratio {one / other:.2f}")
    return one / other


@pytest.mark.parametrize("ordering", ORDERINGS)
def test_plane_against_one_factorisation(glued, ordering, record_property):
    scene, K, front = glued
    if scene == "plane":
        inner = K[front >= 0][:, front >= 0].tocsc()
        assert inner.shape[0] > 50_000 and (front < 0).sum() == 250
        assert (
            compared(
                lambda: eliminate(K, front),
                lambda: splu(inner, **ORDERINGS[ordering]),
                record_property,
            )
            < 1.0
        )


def test_against_pardiso(glued, record_property):
    """In space there are 43,000 unknowns, and 2,700 of them are kept."""
    _, K, front = glued
    (S, _), other = eliminate(K, front), pardiso(K, front < 0)
    assert np.abs(S - other).max() < 1e-12 * np.abs(S).max()
    assert (
        compared(lambda: eliminate(K, front), lambda: pardiso(K, front < 0), record_property) < 1.2
    )
