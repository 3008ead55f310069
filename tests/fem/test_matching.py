"""Bodies of one matrix, and matrices of the user, compared with blocks whose nodes are known."""

import numpy as np
import pytest
from scipy.sparse import block_diag

import frictopt as fo
from helpers.calculix import Block, lines
from helpers.refused import refused


def block(first, *ends, name):
    return Block(first, lines(*ends), 1000.0, 0.3, name)


@pytest.fixture
def pair_in_space():
    upper, lower = (
        block(first, (0, 2, 2), (0, 1, 1), z, name=name)
        for first, z, name in ((1, (0, 1, 1), "UP"), (101, (-1, 0, 1), "LOW"))
    )
    K = block_diag([upper.stiffness(), lower.stiffness()]).tocsr()
    labels = np.array([(n, k) for part in (upper, lower) for n in part.numbers for k in (1, 2, 3)])
    points = {
        int(n): point
        for part in (upper, lower)
        for n, point in zip(part.numbers, part.points, strict=True)
    }
    return K, labels, points


def test_a_matrix_of_points_alone_has_forces_in_space(pair_in_space):
    K, labels, points = pair_in_space
    job = fo.readers.MatrixJob(K, labels, points)
    assert np.array_equal(job.points, list(points.values()))
    assert job.unknowns.ravel().tolist() == list(range(len(labels)))
    top = np.flatnonzero(job.points[:, 2] == 1)
    force = job.force(top, nodal=[1.0, 2.0, 3.0])
    assert (force[job.unknowns[top]] == [1.0, 2.0, 3.0]).all() and force.sum() == 6.0 * len(top)
    with pytest.raises(fo.ModelError, match="no elements"):
        job.normals(top)


def test_a_generalised_coordinate_joins_what_it_couples(pair_in_space):
    """Two halves of the lower body that only a coordinate of the node 0 joins are one body. A
    rotation of a node is no displacement of it."""
    K, labels, points = pair_in_space
    n = len(labels)
    row = np.zeros(n)
    row[[0, n - 1]] = 0.1
    joined = np.block([[K.toarray(), row[:, None]], [row[None], np.eye(1)]])
    for label in ((0, 1), (-3, 2), (101, 4)):
        job = fo.readers.MatrixJob(joined, np.vstack([labels, label]), points)
        assert job.generalised.tolist() == [n]
        assert set(job.bodies) == {0}
        assert "generalised=1" in repr(job)
        assert job.unknowns.max() == n - 1
    assert set(fo.readers.MatrixJob(K, labels, points).bodies) == {0, 1}


@refused(
    ({}, "deck: no nodes"),
    ({0: (0, 0)}, "deck: node: 0; it must be a whole number of at least 1"),
    ({1: (0, 0, 0, 0)}, "node 1 has 4 coordinates"),
    ({1: (0, np.nan)}, "deck: node 1"),
    ([(0, 0)], "give the deck of another job, a mapping"),
    ({2: (0, 0)}, "node 1 of the matrix is not in it"),
)
def test_points_that_are_none_are_refused(points):
    fo.readers.MatrixJob(np.eye(2), [[1, 1], [1, 2]], points).unknowns  # noqa: B018
