"""Decks determine the displacements that a matrix lacks, in every form that a deck may use.

No code is run: forces on such displacements are compared with results by hand.
"""

import numpy as np
import pytest
from scipy.sparse import identity

import frictopt as fo
from helpers.refused import refused

SQUARE = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n*ELEMENT, TYPE=CPE4, ELSET=E\n1, 1, 2, 3, 4\n*NSET, NSET=TOP\n3, 4\n"


def job(folder, deck, labels, K=None):
    """A job of these labels, of the unit matrix by default."""
    (folder / "job.inp").write_text(deck)
    (folder / "job.dof").write_text("".join(f"{label}\n" for label in labels))
    K = identity(len(labels)).toarray() if K is None else K
    (folder / "job.sti").write_text(
        "".join(
            f"{i + 1} {j + 1} {float(K[i, j])!r}\n" for i in range(len(K)) for j in range(i + 1)
        )
    )
    return fo.readers.read_calculix(folder / "job")


def on(found, forces):
    """Label -> force that is not zero."""
    return {
        f"{node}.{direction}": force
        for (node, direction), force in zip(found.labels, forces, strict=True)
        if force
    }


@pytest.mark.parametrize(
    ("text", "labels", "moved"),
    [
        ("*BOUNDARY\nTOP, 2\n", ["2.2"], {}),
        ("*BOUNDARY\nTOP, 2, , 0.\n", ["2.2"], {}),
        ("*BOUNDARY\nTOP, YSYMM\n", ["2.2"], {}),
        ("*BOUNDARY\nTOP, ENCASTRE\n", ["2.2"], {}),
        ("*BOUNDARY, OP=NEW\nTOP, 1, 6\n", ["2.2"], {}),
    ],
)
def test_forces_go_where_the_deck_says(tmp_path, text, labels, moved):
    found = job(tmp_path, SQUARE + text, labels)
    assert on(found, found.force("TOP", nodal=[0.0, 1.0])) == moved


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "node 3, direction 2, .*\\(give the deck of the same job\\)"),
        ("*EQUATION\n2\n3, 2, 1., 2, 2, -1.\n", "the deck has \\*EQUATION"),
        ("*TIE, NAME=T\nA, B\n*MPC\nPLANE, 1, 2, 3\n", "the deck has \\*TIE, \\*MPC"),
        ("*DISTRIBUTING COUPLING, ELSET=M\n1, 1.\n", "the deck has \\*DISTRIBUTINGCOUPLING"),
        ("*BOUNDARY\nLOST, 1, 2\n", "a block \\*BOUNDARY that cannot be read here: 'LOST'"),
    ],
)
def test_forces_of_which_the_deck_says_nothing_are_refused(tmp_path, text, message):
    found = job(tmp_path, SQUARE + text, ["1.1", "2.2"])
    with pytest.raises(fo.ModelError, match=message):
        found.force("TOP", nodal=[0.0, 1.0])
    # A node that follows no other node can be loaded.
    assert on(found, found.force([1], nodal=[0.0, 1.0])) == {"2.2": 1.0}


def test_rows_say_what_is_held_and_what_follows(tmp_path):
    found = job(
        tmp_path,
        SQUARE + "*BOUNDARY\n1, 1, 2\n*EQUATION\n2\n3, 2, 1., 4, 2, -1.\n",
        ["2.1", "2.2", "3.1", "4.1", "4.2"],
    )
    assert found.unknowns.tolist() == [[-1, -1], [0, 1], [2, -2], [3, 4]]


def test_keyword_lines_go_on_after_a_comma(tmp_path):
    plain = job(tmp_path, SQUARE + "*NSET, NSET=ALL, GENERATE\n1, 4\n", ["1.1", "2.2"]).deck
    text = SQUARE.replace(
        "*ELEMENT, TYPE=CPE4, ELSET=E", "  * Element,\n  TYPE = CPE4,\n  ELSET=E,"
    ).replace("*NSET, NSET=TOP", "*NSET, NSET=TOP,")
    deck = job(
        tmp_path, "\ufeff" + text + "*NSET, NSET=ALL,\nGENERATE\n1, 4\n", ["1.1", "2.2"]
    ).deck
    assert deck.numbers.tolist() == [1, 2, 3, 4]
    assert deck.elements[0][0] == "CPE4"
    assert list(deck.element_sets) == ["E"]
    for name in ("TOP", "ALL"):
        assert deck.nodes(name).tolist() == plain.nodes(name).tolist()


def test_matrices_of_abaqus_are_per_unit_depth_too(tmp_path):
    (tmp_path / "a.inp").write_text(
        SQUARE + "*SOLID SECTION, ELSET=E, MATERIAL=M\n4.,\n*BOUNDARY\n1, PINNED\n"
    )
    (tmp_path / "a.mtx").write_text("2,1, 2,1, 8.\n2,1, 3,1, -4.\n3,1, 3,1, 8.\n1,1, 1,1, 1.e36\n")
    found = fo.readers.read_abaqus(tmp_path / "a.mtx", deck=tmp_path / "a.inp")
    assert found.K.toarray().tolist() == [[2.0, -1.0], [-1.0, 2.0]]
    assert found.unknowns.tolist() == [[-1, -1], [0, -2], [1, -2], [-2, -2]]
    assert fo.readers.read_abaqus(tmp_path / "a.mtx").K.max() == 8.0


@pytest.mark.parametrize(
    "text",
    [
        "*NODAL THICKNESS\nTOP, 2.\n",
        "*SOLID SECTION, ELSET=E, MATERIAL=M\n<t>\n",
        "*SOLID SECTION, ELSET=E, MATERIAL=M\n0.\n",
    ],
)
def test_thicknesses_that_vary_are_refused(tmp_path, text):
    with pytest.raises(fo.ModelError, match="sections of thickness"):
        job(tmp_path, SQUARE + text, ["1.1", "2.2"])


def test_trusses_and_springs_have_no_faces(tmp_path):
    deck = (
        SQUARE
        + "*ELEMENT, TYPE=T3D2, ELSET=BAR\n7, 3, 4\n*SOLID SECTION, ELSET=BAR, MATERIAL=M\n0.1\n*ELEMENT, TYPE=SPRINGA, ELSET=S\n8, 1, 3\n"
    )
    found = job(tmp_path, deck, ["3.2", "4.2"])
    assert on(found, found.force([2, 3], pressure=1.0)) == pytest.approx({"3.2": -0.5, "4.2": -0.5})


@refused(
    ({}, "force: no load; give one of"),
    ({"traction": [0.0, 1.0], "total": [0.0, 1.0]}, "force: traction and total; give one of"),
)
def test_a_force_is_said_in_one_way(load, tmp_path):
    job(tmp_path, SQUARE, ["3.2", "4.2"]).force("TOP", **load)


def test_a_node_that_follows_is_no_node_of_a_contact():
    K, points = np.eye(2), [[0.0, 0.0], [0.0, 0.0]]
    with pytest.raises(fo.ModelError, match=r"pairs: node 1 at \(0, 0\) follows other nodes"):
        fo.condense(K, {"P": [0.0, -1.0]}, [[0, 1]], [0.0, 1.0], [[0, 1], [-1, -2]], points)
