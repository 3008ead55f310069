"""Decks that would fill the memory, or that are none, are refused at once and quote no other file."""

import pytest

import frictopt as fo

MESH = "*NODE\n1,0.,0.\n2,1.,0.\n3,1.,1.\n4,0.,1.\n*ELEMENT, TYPE=CPE4, ELSET=E1\n1,1,2,3,4\n"
BAD = {
    "number": (MESH.replace("\n1,0.,0.", f"\n{2**64},0.,0."), "is too large"),
    "included": ("*NODE\n*INCLUDE, INPUT=other.txt\n" + MESH, "an entry is no number"),
    "many": (MESH + "*INCLUDE, INPUT=0.inc\n", "more than 1000 INCLUDE"),
    "no deck": (MESH.encode("utf-16").decode("latin-1"), "no line begins with"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_strange_deck_is_refused(name, tmp_path):
    text, why = BAD[name]
    (tmp_path / "other.txt").write_text("root:SECRET:0:0\n")
    for number in range(8):
        (tmp_path / f"{number}.inc").write_text(f"*INCLUDE, INPUT={number + 1}.inc\n" * 12)
    (tmp_path / "8.inc").write_text("*HEADING\nline\n")
    (tmp_path / "a.inp").write_text(text, encoding="latin-1")
    with pytest.raises(fo.ModelError, match=why) as refused:
        fo.readers.read_mesh(tmp_path / "a.inp")
    assert "SECRET" not in str(refused.value)


@pytest.mark.parametrize("kind", ["NSET", "ELSET"])
def test_a_range_beyond_all_numbers_is_that_of_the_deck(kind, tmp_path):
    block = f"*{kind}, {kind}=A, GENERATE\n1, 1000000000000000, 2\n"
    (tmp_path / "a.inp").write_text(MESH + block)
    assert fo.readers.read_mesh(tmp_path / "a.inp").p.shape == (2, 4)


def test_bulk_data_that_include_many_files_are_refused(tmp_path):
    for number in range(8):
        (tmp_path / f"{number}.bdf").write_text(f"INCLUDE '{number + 1}.bdf'\n" * 12)
    (tmp_path / "8.bdf").write_text("GRID,1\n")
    with pytest.raises(fo.ModelError, match="more than 1000 INCLUDE"):
        fo.readers.read_mesh(tmp_path / "0.bdf")
