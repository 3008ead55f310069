"""Bodies and matching faces of one matrix, and matrices of the user.

They are compared with blocks whose nodes are known.
"""

import numpy as np
import pytest
from scipy.sparse import block_diag

import frictopt as fo
from frictopt.readers.keywords import read_deck
from helpers.calculix import Block, lines
from helpers.refused import refused


def block(first, *ends, name):
    return Block(first, lines(*ends), 1000.0, 0.3, name)


def job_of(folder, blocks):
    """The job of some blocks, without any code."""
    (folder / "job.inp").write_text("".join(part.deck() for part in blocks))
    labels = [
        (n, k + 1) for part in blocks for n in part.numbers for k in range(part.points.shape[1])
    ]
    return fo.readers.MatrixJob(
        block_diag([part.stiffness() for part in blocks]), labels, read_deck(folder / "job.inp")
    )


def numbers_of(job, faces):
    return sorted([tuple(map(int, row)) for row in job.deck.numbers[face]] for face in faces)


def test_the_faces_of_a_deck_are_the_pairs_of_its_sets(flat):
    (face,) = flat.matching_faces()
    first, second = ("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")
    if face[0, 0] not in flat.nodes(first):
        first, second = second, first
    assert np.array_equal(face, flat.pairs(first, second))
    assert set(np.flatnonzero(flat.bodies == -1)) == set(flat.nodes("N_BOTTOM"))


def test_the_face_of_a_deck_in_space(cube):
    (face,) = cube.matching_faces()
    assert len(face) == 9
    assert np.array_equal(cube.points[face[:, 0]], cube.points[face[:, 1]])
    assert not cube.points[face[:, 0], 2].any()


def test_three_bodies_meet_two_by_two(tmp_path):
    """Three bodies meet two by two.

    Two punches stand side by side on a block, and a corner belongs to three faces. Body 1, the body
    that comes first, is on the left of each direction.
    """
    left = block(1, (0, 1, 2), (0, 2, 2), name="LEFT")
    right = block(51, (1, 2, 1), (0, 2, 2), name="RIGHT")
    base = Block(
        101, [np.array([-1.0, 0.0, 0.5, 1.0, 2.0, 3.0]), np.array([-1.0, 0.0])], 1000.0, 0.3, "BASE"
    )
    job = job_of(tmp_path, [left, right, base])
    assert [int((job.bodies == i).sum()) for i in range(3)] == [9, 6, 12]
    on_base = {x: 107 + i for i, x in enumerate(base.lines[0])}
    beside = [(3, 51), (6, 53), (9, 55)]
    expected = [
        beside,
        [(1, on_base[0]), (2, on_base[0.5]), (3, on_base[1])],
        [(51, on_base[1]), (52, on_base[2])],
    ]
    found = numbers_of(job, job.matching_faces())
    assert sorted(map(sorted, expected)) == sorted(map(sorted, found))
    for face in job.matching_faces():  # a normal on the left of the way points into body 1
        direction = np.diff(job.points[face[:, 0]], axis=0)[0]
        inside = (
            job.points[job.bodies == job.bodies[face[0, 0]]].mean(axis=0) - job.points[face[0, 0]]
        )
        assert direction[0] * inside[1] - direction[1] * inside[0] > 0


@pytest.mark.parametrize("first", ["bridge", "comb"])
def test_faces_apart_are_several_and_points_are_none(tmp_path, first):
    """Faces that lie apart are several faces, and single points are none.

    A bridge of one body has two feet; a block beyond it touches it at one node.
    """
    x = np.array([0.0, 1.0, 2.0, 3.0])
    bridge = Block(1, [x, np.array([0.0, 1.0])], 1000.0, 0.3, "BRIDGE")
    comb = Block(101, [x, np.array([-2.0, -1.0, 0.0])], 1000.0, 0.3, "COMB")
    lone = block(201, (3, 4, 1), (1, 2, 1), name="LONE")
    parts = [bridge, comb, lone] if first == "bridge" else [comb, bridge, lone]
    between_feet = "104, 106, 107, 111, 110\n"  # an element
    (tmp_path / "job.inp").write_text(
        "".join(part.deck() for part in parts).replace(between_feet, "")
    )
    labels = [(n, k + 1) for part in parts for n in part.numbers for k in range(2)]
    job = fo.readers.MatrixJob(
        block_diag([part.stiffness() for part in parts]), labels, read_deck(tmp_path / "job.inp")
    )
    expected = {
        "bridge": [[(1, 109), (2, 110)], [(3, 111), (4, 112)]],
        "comb": [[(110, 2), (109, 1)], [(112, 4), (111, 3)]],
    }
    assert numbers_of(job, job.matching_faces()) == expected[first]


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
    return K, labels, points, np.column_stack([upper.on(2, 0), lower.on(2, 0)])


def test_a_matrix_of_points_alone_has_faces_in_space(pair_in_space):
    K, labels, points, pairs = pair_in_space
    job = fo.readers.MatrixJob(K, labels, points)
    assert np.array_equal(job.points, list(points.values()))
    assert job.unknowns.ravel().tolist() == list(range(len(labels)))
    (face,) = job.matching_faces()
    assert np.array_equal(job.deck.numbers[face], pairs)
    top = np.flatnonzero(job.points[:, 2] == 1)
    force = job.force(top, nodal=[1.0, 2.0, 3.0])
    assert (force[job.unknowns[top]] == [1.0, 2.0, 3.0]).all() and force.sum() == 6.0 * len(top)
    with pytest.raises(fo.ModelError, match="no elements"):
        job.normals(face[:, 1])


def test_a_generalised_coordinate_joins_what_it_couples(pair_in_space):
    """A generalised coordinate joins the bodies that it couples.

    Two halves of the lower body that only a coordinate of the node 0 joins are one body. A rotation
    of a node is no displacement of it.
    """
    K, labels, points, _ = pair_in_space
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


def test_nodes_on_several_others_are_refused(pair_in_space):
    K, labels, points, pairs = pair_in_space
    points = {**points, int(pairs[1, 1]): points[int(pairs[0, 1])]}
    with pytest.raises(
        fo.ModelError,
        match=r"matching_faces: the node at \(0, 0, 0\) coincides with several nodes of one other body",
    ):
        fo.readers.MatrixJob(K, labels, points).matching_faces()
