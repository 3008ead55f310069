"""Condensation of given matrices in three dimensions: what is left free, which pair is wrong, and pairs that are held."""

import re

import numpy as np
import pytest
from skfem import MeshHex

import frictopt as fo
from multipliers import problem

TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]


def given(cells=(3, 3), graded=1.0, turn=TURN):
    """Arguments of `condense` for a free block on one that is held below, turned in space; body 2 goes on beside body 1."""
    x, y = (np.linspace(0, 1, n + 1) ** graded for n in cells)
    good = problem(np.random.default_rng(5), [x, y], [np.r_[-0.5, x, 1.5], y], MeshHex, turn, held=False)
    one, two, points = good.pop("one"), good.pop("two"), good["points"]
    pairs = [[node, two[np.linalg.norm(points[two] - points[node], axis=1).argmin()]] for node in one]
    return good | {"pairs": np.array(pairs), "normals": np.tile(turn[:, -1], (len(one), 1))}


@pytest.mark.parametrize(("held", "free"), [(0, "move along x and y and z and turn about x and y and z"), (1, "turn about x and y and z"), (2, "")])
def test_rigid_motions_in_space(held, free):
    """Two nodes that are held leave the turn about the line through them."""
    good = given()
    nodes = np.flatnonzero(np.isin(good["unknowns"][:, 0], good["held"]))[:held]
    if not free:
        one, two = good["points"][nodes]
        axis = (two - one) / np.linalg.norm(two - one)
        axis *= np.sign(axis[np.abs(axis).argmax()])
        free = f"turn about ({', '.join(f'{value:g}' for value in axis.round(6))})"
    with pytest.raises(fo.ModelError, match=re.escape(f"can still {free}; add")):
        fo.condense(**good | {"held": good["unknowns"][nodes].ravel()})


@pytest.mark.parametrize(("cells", "graded"), [((3, 3), 1.0), ((4, 2), 2.5), ((1, 1), 1.0)])
def test_a_pair_that_is_wrong_is_named_whichever_it_is(cells, graded):
    good = given(cells, graded)
    pairs, normals, n = good["pairs"], good["normals"], len(good["pairs"])
    assert fo.condense(**good).nodes == n
    for i in range(n):
        others = np.arange(n) != i
        flip = np.where(others, 1.0, -1.0)[:, None]
        turned = np.where(others[:, None], pairs, pairs[:, ::-1])
        one, two = sorted(pairs[i].tolist())
        for change, message in (
            ({"normals": flip * normals}, f"normals: that of pair {i} at"),
            ({"pairs": turned}, f"normals: that of pair {i} at"),
            ({"pairs": pairs[others], "normals": normals[others]}, f"pairs: nodes {one} and {two} lie on each other at"),
        ):
            with pytest.raises(fo.ModelError, match=message):
                fo.condense(**good | change)
    again = np.random.default_rng(1).permutation(n)
    assert fo.condense(**good | {"pairs": pairs[again], "normals": normals[again]}).nodes == n


def test_a_pair_of_two_nodes_that_are_held_may_be_left_out():
    """On a plane of symmetry both bodies are held across it: the pair cannot slip there, but carries pressure."""
    good = given()
    side = np.flatnonzero(np.isclose(good["points"] @ TURN[:, 1], 0.0))
    pairs, held = good["pairs"], np.union1d(good["held"], good["unknowns"][side, 0])
    left = ~np.isin(pairs[:, 0], side)
    assert 0 < left.sum() < len(left)
    assert fo.condense(**good | {"held": held, "pairs": pairs[left], "normals": good["normals"][left]}).nodes == left.sum()
    assert fo.condense(**good | {"held": held}).nodes == len(left)
    still = np.union1d(held, good["unknowns"][side])
    with pytest.raises(fo.ModelError, match="follows from those of other pairs or from supports"):
        fo.condense(**good | {"held": still})
    one_side = np.union1d(good["held"], good["unknowns"][pairs[~left, 1], 0])
    assert fo.condense(**good | {"held": one_side}).nodes == len(left)
    with pytest.raises(fo.ModelError, match="lie on each other at"):
        fo.condense(**good | {"held": one_side, "pairs": pairs[left], "normals": good["normals"][left]})


@pytest.mark.parametrize(("normal", "first"), [(2, [1.0, 0.0, 0.0]), (0, [0.0, 1.0, 0.0]), (1, [1.0, 0.0, 0.0])])
def test_the_first_tangent_is_along_x_unless_the_normal_is(normal, first):
    turn = np.roll(np.eye(3), 2 - normal, axis=1)
    frames = fo.condense(**given(turn=turn)).frames
    assert np.allclose(frames[:, 0], first) and np.allclose(frames[:, 2], turn[:, -1]) and np.allclose(np.linalg.det(frames), 1.0)
