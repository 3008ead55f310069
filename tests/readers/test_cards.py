"""Cards of Nastran and types of Ansys, as on the page of formats."""

import re
from pathlib import Path

import numpy as np
import pytest
from ansys.mapdl.reader import examples

import frictopt as fo
from frictopt.readers.ansys_nastran import ANSYS_SOLIDS
from frictopt.readers.bulk_data import SOLIDS
from helpers.formats_page import rows, section

PLACES = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
GRIDS = [*PLACES, *((x, y, z + 1) for x, y, z in PLACES)]  # those of one brick on the other
CARDS = dict(rows("Nastran"))
WEDGE = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)]
WEDGE_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 4), (2, 5), (3, 4), (4, 5), (5, 3)]
PYRAMID = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)]
PYRAMID_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)]


def card(*entries):
    """A card in fields of eight characters."""
    fields = "".join(f"{entry!s:>8}" for entry in entries[1:])
    lines = [fields[i : i + 64] for i in range(0, len(fields), 64)]
    return "".join(f"{entries[0] if i == 0 else '':<8}{line}\n" for i, line in enumerate(lines))


def grids(points, cp="", cd=""):
    return "".join(
        card("GRID", i, cp, *(f"{value:.3f}" for value in point), cd)
        for i, point in enumerate(points, 1)
    )


def brick(number, first):
    return card("CHEXA", number, 1, *range(first, first + 8))


def job(folder, bulk, nodes=16):
    """The job of bulk data, with a matrix that joins nothing."""
    lines = ["DMIG    KAAX           0       6       2       0"]
    for n in range(1, nodes + 1):
        for c in (1, 2, 3):
            lines += [
                f"DMIG*   KAAX            {n:16d}{c:16d}                ",
                f"*       {n:16d}{c:16d}{1.0:16.9E}",
            ]
    (folder / "k.pch").write_text("\n".join(lines) + "\n")
    (folder / "k.bdf").write_text(f"SOL 101\nCEND\nBEGIN BULK\n{bulk}ENDDATA\n")
    return fo.readers.read_nastran(folder / "k.pch", deck=folder / "k.bdf")


def test_the_page_lists_the_cards_of_the_reader():
    listed = set(re.findall(r"`\w+`", " ".join(CARDS)))
    assert listed == {f"`{name}`" for name in (*SOLIDS, "DMIG", "INCLUDE", "GRID", "GRDSET")}
    types = {
        int(kind)
        for kind in re.findall(
            r"SOLID(\d+)", " ".join(name for name, effect in rows("Ansys") if effect == "kept")
        )
    }
    assert types == {*ANSYS_SOLIDS}


def test_cards_that_are_kept(tmp_path):
    plain = job(tmp_path, grids(GRIDS) + brick(1, 1) + brick(2, 9))
    assert plain.points.tolist() == [list(map(float, point)) for point in GRIDS]
    assert plain.deck.elements[0][0] == "C3D8"
    (tmp_path / "more.bdf").write_text(brick(2, 9))
    included = job(tmp_path, grids(GRIDS) + brick(1, 1) + "INCLUDE 'more.bdf'\n")
    assert included.deck.elements[0][2].tolist() == plain.deck.elements[0][2].tolist()


WITHOUT = re.findall(
    r"`([A-Z0-9]+)`", re.search(r"All other cards have no effect,.*", section("Nastran"))[0]
)


@pytest.mark.parametrize("name", WITHOUT)
def test_cards_without_effect(tmp_path, name):
    bulk = grids(GRIDS) + brick(1, 1) + brick(2, 9)
    plain, other = job(tmp_path, bulk), job(tmp_path, card(name, 1, 1, 1, 2, 3, 4) + bulk)
    assert np.array_equal(plain.points, other.points) and other.deck.elements[0][2].shape == (2, 8)
    assert np.array_equal(plain.unknowns, other.unknowns)


@pytest.mark.parametrize(("cp", "cd"), [(5, ""), ("", 5), (5, 5)])
def test_systems_of_all_grid_points_are_refused_as_those_of_one(tmp_path, cp, cd):
    """Zero in a GRID is the basic system, whatever GRDSET says."""
    system = card("CORD2R", 5, 0, 10.0, 0.0, 0.0, 10.0, 0.0, 1.0, 10.0, 1.0, 0.0)
    default = card("GRDSET", "", cp, "", "", "", cd, "", "")
    for bulk, name in ((grids(GRIDS, cp, cd), "GRID"), (default + grids(GRIDS), "GRDSET")):
        with pytest.raises(
            fo.ModelError,
            match=f"grid point 1 has coordinates or displacements in system 5, by its {name}; write all in the basic",
        ):
            job(tmp_path, system + bulk + brick(1, 1))
    for harmless in (
        default + grids(GRIDS, 0, 0),
        card("GRDSET", "", "", "", "", "", "", 456, "") + grids(GRIDS),
    ):
        assert job(tmp_path, system + harmless + brick(1, 1)).points.tolist() == [
            list(map(float, point)) for point in GRIDS
        ]


@pytest.mark.parametrize(
    ("name", "corners", "edges"),
    [
        ("CPENTA", WEDGE, WEDGE_EDGES),
        ("CPYRAM", PYRAMID, PYRAMID_EDGES),
        ("CPYRA", PYRAMID, PYRAMID_EDGES),
    ],
    ids=["wedge", "pyramid", "pyramid of OptiStruct"],
)
def test_wedges_and_pyramids_have_faces_and_nodes_amid_their_edges_make_no_pairs(
    tmp_path, name, corners, edges
):
    for middles in ([], [np.mean([corners[a], corners[b]], axis=0) for a, b in edges]):
        points = [*corners, *middles]
        n = len(points)
        bulk = (
            grids([*points, *points])
            + card(name, 1, 1, *range(1, n + 1))
            + card(name, 2, 1, *range(n + 1, 2 * n + 1))
        )
        wedges = job(tmp_path, bulk, 2 * n)
        level = wedges.points[:n, 2]
        face = np.flatnonzero(level == 0)
        if not middles:
            assert sorted(wedges.pairs(face, face + n).tolist()) == [[i, i + n] for i in face]
        elif name == "CPENTA":
            with pytest.raises(
                fo.ModelError, match=r"does not follow its corners; name both faces in job\.with"
            ):
                wedges.pairs(face, face + n)
        else:
            with pytest.raises(fo.ModelError, match=f"an element CPYRAM{n}, whose midside nodes"):
                wedges.pairs(face, face + n)
            with pytest.raises(fo.ModelError, match="elements of type"):
                wedges.force(face, pressure=1.0)
            continue
        force = wedges.force(face, pressure=1.0)[wedges.unknowns[face, 2]]
        if middles:
            # A uniform pressure on a six-node triangle loads the nodes amid its edges alone.
            assert np.allclose(force, np.where(face < len(corners), 0.0, 0.5 / 3))
        elif name == "CPENTA":
            assert np.allclose(force, 0.5 / 3)
        else:
            assert np.allclose(force, 0.25)
        if middles:
            upper = np.flatnonzero(level == level.max())
            force = wedges.force(upper, pressure=1.0)[wedges.unknowns[upper, 2]]
            assert np.allclose(force, np.where(upper < len(corners), 0.0, -0.5 / 3))


def test_a_punch_file_without_matrices_says_how_they_are_written(tmp_path):
    (tmp_path / "seven.pch").write_text(
        "$ EXTERNAL SUPERELEMENT 7\nBEGIN SUPER        7\nGRID*                  1               0 0.0\n"
    )
    with pytest.raises(
        fo.ModelError,
        match=r"seven\.pch has no DMIG cards; write the matrix there with EXTSEOUT\(DMIGPCH\)",
    ):
        fo.readers.read_nastran(tmp_path / "seven.pch")


@pytest.mark.parametrize(("one", "other", "kind"), [(186, 95, "C3D20")])
def test_older_names_of_elements_of_ansys_are_the_same_elements(tmp_path, one, other, kind):
    """Midside nodes of the contact face are refused under both names."""
    text = Path(examples.hexarchivefile).read_text()
    for number in (one, other):
        (tmp_path / "b.cdb").write_text(
            re.sub(rf"(?m)^ET,(\s*\d+),\s*{one}", rf"ET,\1,{number}", text)
        )
        bar = fo.readers.read_ansys(examples.fullfile, deck=tmp_path / "b.cdb")
        assert {block[0] for block in bar.deck.elements} == {kind}
        levels = np.unique(bar.points[:, 2].round(9))
        faces = [np.flatnonzero(np.isclose(bar.points[:, 2], level)) for level in levels[[-1, -3]]]
        with pytest.raises(
            fo.ModelError, match="a midside node of a contact face, does not follow its corners"
        ):
            bar.pairs(*faces)


def test_elements_of_ansys_that_are_not_known_make_no_pairs(tmp_path):
    text = Path(examples.hexarchivefile).read_text()
    (tmp_path / "b.cdb").write_text(re.sub(r"(?m)^ET,(\s*\d+),\s*186", r"ET,\1,226", text))
    bar = fo.readers.read_ansys(examples.fullfile, deck=tmp_path / "b.cdb")
    end, middle = (np.flatnonzero(np.isclose(bar.points[:, 2], z)) for z in (5.0, 4.0))
    with pytest.raises(
        fo.ModelError, match="an element 226 of 20 nodes, whose midside nodes are unknown; mesh"
    ):
        bar.pairs(end, middle)
