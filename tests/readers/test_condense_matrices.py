"""Condensation of the user's matrices.

It is compared with the equations of the glued bodies with multipliers, by dense algebra. Bad input
is refused.
"""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_matrix
from skfem import MeshHex, MeshTri

import frictopt as fo
from helpers.cases import few
from helpers.components import joined
from helpers.motions import free_motions
from helpers.multipliers import by_multipliers, problem


def lines(*cells):
    return [np.linspace(-1, 1, n + 1) for n in cells]


@settings(max_examples=few(20))
@given(
    seed=st.integers(0, 10**6),
    kind=st.sampled_from([MeshTri, MeshHex]),
    held=st.booleans(),
    match=st.booleans(),
)
def test_any_numbering_direction_and_projection_against_multipliers(seed, kind, held, match):
    rng, d = np.random.default_rng(seed), kind().dim()
    cells = [(3, 3), (4, 2)][: d - 1] if match else [(3, 4), (2, 3)][: d - 1]
    upper, lower = (
        (lines(*own) for own in zip(*cells, strict=True))
        if not match
        else (lines(*(n for n, _ in cells)),) * 2
    )
    turn = np.linalg.qr(rng.normal(size=(d, d)))[0]
    turn[:, 0] *= np.linalg.det(turn)
    given_ = problem(rng, upper, lower, kind, turn, held)
    one, two, unknowns, points = (given_.pop(name) for name in ("one", "two", "unknowns", "points"))
    P = np.zeros((len(one), len(points)))
    if match:
        P[np.arange(len(one)), two] = 1.0
    else:  # along each axis from node to segment
        weights = [(points[nodes] @ turn)[:, :-1] for nodes in (one, two)]
        for k, (ends, places) in enumerate(zip(lower, weights[0].T, strict=True)):
            hats = np.array([np.interp(places, ends, row) for row in np.eye(len(ends))])
            P[:, two] = (P[:, two] if k else 1.0) * hats[
                np.abs(ends[:, None] - weights[1][:, k]).argmin(axis=0)
            ].T
    pairs = (
        {"pairs": np.column_stack([one, two])}
        if match
        else {"pairs": one, "projection": csr_matrix(P)}
    )
    system = fo.condense(**given_, **pairs, unknowns=unknowns, points=points)
    opening, n = -P, len(one)
    opening[np.arange(n), one] += 1.0
    G = np.zeros((d * n, given_["K"].shape[0]))
    for i, frame in enumerate(system.frames):
        for row, rows in zip(opening[i], unknowns, strict=True):
            G[i::n, rows] += row * frame
    S, R = by_multipliers(
        given_["K"].toarray(), np.column_stack([*given_["loads"].values()]), G, given_["held"]
    )
    assert np.allclose(system.S, S, rtol=0, atol=1e-9 * np.abs(S).max())
    gap, fit = np.random.default_rng(seed).random(n), S[:, -n:]
    system = system.with_interference({"a": 0.5, "fit": gap})
    for name, r in {"a": R[:, 0] + fit @ np.full(n, 0.5), "b": R[:, 1], "fit": fit @ gap}.items():
        assert np.allclose(
            joined(*system.bonded[name]), r, rtol=0, atol=1e-9 * max(1.0, np.abs(r).max())
        )
    assert np.allclose(system.normals, turn[:, -1]) and np.array_equal(system.points, points[one])
    assert free_motions(system).shape[1] == (0 if held else d * (d + 1) // 2)
    if d == 2:
        assert np.allclose(system.frames[:, 0], [turn[1, 1], -turn[0, 1]])
        assert np.allclose(system.width, np.array([1, 2, 2, 1]) / 3)
        assert np.allclose(system.x, np.linspace(-1, 1, 4))


def matched(**changes):
    given_ = problem(np.random.default_rng(3), lines(3), lines(3))
    pairs = np.column_stack([given_.pop("one"), given_.pop("two")])
    return {**given_, "pairs": pairs, **changes}


def test_nodes_on_springs():
    """Nodes on springs are bodies of a single node each, which cannot turn."""
    springs = {
        "unknowns": [[0, 1], [2, 3], [-1, -1], [-1, -1]],
        "points": [[0, 0], [1, 0], [0, 0], [1, 0]],
        "pairs": [[0, 2], [1, 3]],
    }
    for k in (3.0, 0.0):
        system = fo.condense(
            np.diag([2.0, k, 4.0, 5.0]), {"P": [1, 2, 3, 4]}, normals=[0, 1], **springs
        )
        assert np.allclose(system.S, np.diag([2, 4, k, 5]))
        assert np.allclose(np.r_[system.bonded["P"]], [-1, -3, -2, -4])


def test_gaps_given_and_measured():
    lifted = matched()
    lifted["points"] = lifted["points"] + np.outer(lifted["points"][:, 1] >= 0, [0.0, 0.1])
    lifted["points"][lifted["pairs"][:, 1], 1] = 0.0
    assert np.allclose(fo.condense(**lifted, gap="measured").gap, 0.1)
    assert np.allclose(fo.condense(**lifted, gap=[0, 1, 2, 3]).gap, [0, 1, 2, 3])
    with pytest.raises(
        fo.ModelError, match=r"nodes of pair 0, at \(-1, 0.1\) and \(-1, 0\), lie 0.1 apart"
    ):
        fo.condense(**lifted)
    lifted["points"][lifted["pairs"][2, 0], 1] = -0.1
    with pytest.raises(fo.ModelError, match=r"the bodies overlap by 0\.1 at pair 2"):
        fo.condense(**lifted, gap="measured")


def test_names_and_widths_are_kept():
    system = fo.condense(
        **matched(), contact=["left", "left", "right", "right"], width=[1, 2, 3, 4]
    )
    assert system.contact.tolist() == ["left", "left", "right", "right"]
    assert system.width.tolist() == [1, 2, 3, 4]
    halves = fo.condense(**matched(), contact=["left", "left", "right", "right"])
    assert np.allclose(halves.width, 1 / 3) and np.allclose(np.diff(halves.x), 2 / 3)
    assert fo.condense(**matched(), contact=["one", "two", "three", "four"]).width is None


def test_rotations_of_a_cantilever_are_eliminated():
    """It has two beam elements. Its tip rests on the ground, which feels 3 E I / l^3 across and E A
    / l along, and half of a moment over the length."""
    EI, EA, half = 2.0, 5.0, 1.5
    bend = (
        EI
        / half**3
        * np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
        * np.outer([1, half, 1, half], [1, half, 1, half])
    )
    K = np.zeros((9, 9))  # u, w and the rotation of each node
    for first in (0, 3):
        rows = first + np.array([1, 2, 4, 5])
        K[np.ix_(rows, rows)] += bend
        K[np.ix_([first, first + 3], [first, first + 3])] += (
            EA / half * np.array([[1, -1], [-1, 1]])
        )
    beam = {
        "pairs": [[2, 3]],
        "normals": [0, 1],
        "points": [[0, 0], [1.5, 0], [3, 0], [3, 0]],
        "unknowns": [[0, 1], [3, 4], [6, 7], [-1, -1]],
    }
    system = fo.condense(K, {"M": np.eye(9)[8]}, **beam, held=[0, 1, 2], generalised=[5, 8])
    assert np.allclose(system.S, np.diag([EA / 3, 3 * EI / 27]))
    assert np.allclose(np.r_[system.bonded["M"]], [0, -1.5 / 3])
    with pytest.raises(fo.ModelError, match=r"supports: the body at .* can still turn"):
        fo.condense(K, {"M": np.eye(9)[8]}, **beam, held=[0], generalised=[2, 5, 8])
    with pytest.raises(
        fo.ModelError,
        match=r"generalised: row 9 of K has 0 on the diagonal, so it may be the multiplier",
    ):
        multiplier = np.block([[K, np.eye(9)[:, 2:3]], [np.eye(9)[2:3], np.zeros((1, 1))]])
        fo.condense(multiplier, {"M": np.eye(10)[8]}, **beam, held=[0, 1], generalised=[2, 5, 8, 9])
    with pytest.raises(
        fo.ModelError, match=r"generalised: the stiffness of these rows \(4\) is singular"
    ):
        loose = np.block(
            [[K, np.zeros((9, 2))], [np.zeros((2, 9)), np.array([[1.0, -1.0], [-1.0, 1.0]])]]
        )
        fo.condense(loose, {"M": np.eye(11)[8]}, **beam, held=[0, 1, 2], generalised=[5, 8, 9, 10])


GOOD = matched()
PAIRS, ROWS, POINTS, K = (GOOD[name] for name in ("pairs", "unknowns", "points", "K"))
SKEW = K.copy().tolil()
SKEW[0, 1] += 1.0
TWICE = ROWS.copy()
TWICE[0, 0] = TWICE[1, 1]
LONE = ROWS.copy()
LONE[0, 0] = -1
UPRIGHT = np.tile([0.0, 1.0], (4, 1))
MOVED = POINTS + 1e-3 * (np.arange(len(POINTS)) == PAIRS[1, 0])[:, None]
APART = POINTS - np.outer(
    (POINTS[:, 1] < 0) | np.isin(np.arange(len(POINTS)), PAIRS[:, 1]), [0.0, 1e-3]
)
BOTTOM = GOOD["held"][np.isin(GOOD["held"], ROWS[POINTS[:, 1] == -1.0])]
BAD = {
    "K: not symmetric, K[0, 1] =": {"K": SKEW},
    "K: entries: nan": {"K": K * np.nan},
    "of K is given twice, to nodes [": {"unknowns": TWICE},
    "belongs to no node; assign it to a node, or name it in held": {"unknowns": LONE},
    "generalised: row 3 of K is given twice, to nodes [": {"generalised": [3]},
    "generalised: 48 at index 0; give integers from 0 to 47": {"generalised": [48]},
    "at index (0, 0); give integers from -2 to 47": {"unknowns": ROWS + 0.5},
    "unknowns: shape (4, 2), expected (24, 2)": {"unknowns": ROWS[:4]},
    "held: 10000 at index 0": {"held": [10000]},
    "loads['a']: acts only on rows in `held`": {
        "loads": {"a": np.isin(np.arange(K.shape[0]), GOOD["held"]) * 1.0}
    },
    "bonded: no load case": {"loads": {}},
    "pairs: none": {"pairs": np.zeros((0, 2))},
    f"pairs: the relative motion of pair 4, of node {PAIRS[2, 0]} of body 1, follows from other pairs or from supports; leave the pair": {
        "pairs": PAIRS[[0, 1, 2, 3, 2]],
        "contact": [*"aaaab"],
    },
    "pairs: the nodes of pair 3, at (1, 0) and (-1, 0), lie 2 apart": {
        "pairs": np.r_[PAIRS[:3], [[PAIRS[3, 0], PAIRS[0, 0]]]]
    },
    "normals: that of pair 3 at (1, 0) does not point from body 2 into body 1": {
        "pairs": np.r_[PAIRS[:3], PAIRS[3:, ::-1]]
    },
    f"pairs: nodes {min(PAIRS[2])} and {max(PAIRS[2])} lie on each other at (0.333333, 0), next to the contact": {
        "pairs": PAIRS[[0, 1, 3]]
    },
    f"pairs: nodes {min(PAIRS[0])} and {max(PAIRS[0])} lie on each other at (-1, 0), next to the contact": {
        "pairs": PAIRS[1:]
    },
    "pairs: from pair 0 at (1, 0) to pair 1 at (0.333333, 0) they go against the tangent, which is the normal turned by -90 degrees; reverse": {
        "pairs": PAIRS[::-1]
    },
    "from pair 0 at (-1, 0) to pair 1 at (0.333333, 0)": {
        "pairs": PAIRS[[0, 2, 3]],
        "normals": [[0, 1], [0, -1], [0, 1]],
    },
    "to pair 2 at (-0.333333, 0) they go against the tangent, which is the normal turned by -90 degrees; order": {
        "pairs": PAIRS[[0, 2, 1, 3]]
    },
    "pairs: the nodes of pair 1, at (-0.332333, 0.001) and (-0.333333, 0), lie 0.00141421 apart": {
        "points": MOVED
    },
    "normals: they turn by 90 degrees or more from pair 1 at (-0.333333, 0) to pair 2": {
        "normals": UPRIGHT * [[1], [1], [-1], [1]]
    },
    "normals: shape (3,), expected (4, 2), or (2,) for one direction": {"normals": [0.0, 1.0, 0.0]},
    "normals: zero at pair 2": {"normals": UPRIGHT * [[1], [1], [0], [1]]},
    "normals: that of pair 0 at (-1, 0) does not point from body 2 into body 1": {
        "pairs": PAIRS[:, ::-1]
    },
    "projection: shape (2, 24), type float64; give a real matrix of shape (4, 24)": {
        "pairs": PAIRS[:, 0],
        "projection": np.ones((2, 24)),
    },
    "projection: row 0 adds up to 24": {"pairs": PAIRS[:, 0], "projection": np.ones((4, 24))},
    f"of pair 0, of node {PAIRS[0, 0]} of body 1, follows from other pairs or from supports": {
        "held": np.r_[GOOD["held"], ROWS[PAIRS[0], 1]]
    },
    "can still move along x and y and turn; add a Support (or rows in `held`)": {"held": []},
    "can still turn; add a Support": {"held": ROWS[np.flatnonzero(POINTS[:, 1] == -1.0)[0]]},
    "a body can turn about its contact": {
        "held": BOTTOM,
        "pairs": PAIRS[1:2],
        "points": APART,
        "gap": [0.0],
    },
    "gap: -1 at node 0": {"gap": [-1, 0, 0, 0]},
    "contact: 'a' begins again at node 2": {"contact": ["a", "b", "a", "b"]},
    "width: 0 at node 0": {"width": [0, 1, 1, 1]},
}


@pytest.mark.parametrize("message", BAD)
def test_bad_input_is_refused_by_name_and_remedy(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        fo.condense(**{**GOOD, **BAD[message]})


TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]


def free_block(cells=(3, 3), graded=1.0, turn=TURN):
    """Arguments of `condense` for a free block on a held block, turned in space.

    Body 2 continues beside body 1.
    """
    x, y = (np.linspace(0, 1, n + 1) ** graded for n in cells)
    good = problem(
        np.random.default_rng(5), [x, y], [np.r_[-0.5, x, 1.5], y], MeshHex, turn, held=False
    )
    one = good.pop("one")
    two = good.pop("two")
    points = good["points"]
    pairs = [
        [node, two[np.linalg.norm(points[two] - points[node], axis=1).argmin()]] for node in one
    ]
    return good | {"pairs": np.array(pairs), "normals": np.tile(turn[:, -1], (len(one), 1))}


@pytest.mark.parametrize(("cells", "graded"), [((3, 3), 1.0), ((4, 2), 2.5), ((1, 1), 1.0)])
def test_a_pair_that_is_wrong_is_named_whichever_it_is(cells, graded):
    good = free_block(cells, graded)
    pairs = good["pairs"]
    normals = good["normals"]
    n = len(good["pairs"])
    assert fo.condense(**good).nodes == n
    for i in range(n):
        others = np.arange(n) != i
        flip = np.where(others, 1.0, -1.0)[:, None]
        turned = np.where(others[:, None], pairs, pairs[:, ::-1])
        one, two = sorted(pairs[i].tolist())
        for change, message in (
            ({"normals": flip * normals}, f"normals: that of pair {i} at"),
            ({"pairs": turned}, f"normals: that of pair {i} at"),
            (
                {"pairs": pairs[others], "normals": normals[others]},
                f"pairs: nodes {one} and {two} lie on each other at",
            ),
        ):
            with pytest.raises(fo.ModelError, match=message):
                fo.condense(**good | change)
    again = np.random.default_rng(1).permutation(n)
    assert fo.condense(**good | {"pairs": pairs[again], "normals": normals[again]}).nodes == n


def test_a_pair_of_two_nodes_that_are_held_may_be_left_out():
    """On a plane of symmetry both bodies are held across it. The pair cannot slip there, but
    carries pressure."""
    good = free_block()
    side = np.flatnonzero(np.isclose(good["points"] @ TURN[:, 1], 0.0))
    pairs = good["pairs"]
    held = np.union1d(good["held"], good["unknowns"][side, 0])
    left = ~np.isin(pairs[:, 0], side)
    assert 0 < left.sum() < len(left)
    assert (
        fo.condense(
            **good | {"held": held, "pairs": pairs[left], "normals": good["normals"][left]}
        ).nodes
        == left.sum()
    )
    assert fo.condense(**good | {"held": held}).nodes == len(left)
    still = np.union1d(held, good["unknowns"][side])
    with pytest.raises(fo.ModelError, match="follows from other pairs or from supports"):
        fo.condense(**good | {"held": still})
    one_side = np.union1d(good["held"], good["unknowns"][pairs[~left, 1], 0])
    assert fo.condense(**good | {"held": one_side}).nodes == len(left)
    with pytest.raises(fo.ModelError, match="lie on each other at"):
        fo.condense(
            **good | {"held": one_side, "pairs": pairs[left], "normals": good["normals"][left]}
        )


@pytest.mark.parametrize(
    ("normal", "first"), [(2, [1.0, 0.0, 0.0]), (0, [0.0, 1.0, 0.0]), (1, [1.0, 0.0, 0.0])]
)
def test_the_first_tangent_is_along_x_unless_the_normal_is(normal, first):
    turn = np.roll(np.eye(3), 2 - normal, axis=1)
    frames = fo.condense(**free_block(turn=turn)).frames
    assert np.allclose(frames[:, 0], first)
    assert np.allclose(frames[:, 2], turn[:, -1])
    assert np.allclose(np.linalg.det(frames), 1.0)
