"""What CalculiX reads of a deck, and what is read here, are the same."""

import numpy as np
import pytest

import frictopt as fo
from helpers.calculix import MATRIX, Block, chained, equation, lines, node_set, run

LOW = Block(1, lines((0, 1, 1), (0, 1, 1), (0, 1, 1)), 1000.0, 0.3, "LOW")
HIGH = Block(21, lines((0, 1, 1), (0, 1, 1), (1, 2, 1)), 1000.0, 0.3, "HIGH")
FOOT = node_set("FOOT", LOW.on(2, 0)) + "*BOUNDARY\nFOOT, 1, 3\n"
BASE = LOW.deck() + HIGH.deck() + FOOT


@pytest.mark.ccx
def test_sets_over_gaps_of_the_numbering_have_the_nodes_that_there_are(tmp_path):
    """The nodes of the upper block are 21 to 28; a set from 5 to 25 has those of 5 to 8 too."""
    job = fo.readers.read_calculix(
        run(
            tmp_path,
            BASE + "*NSET, NSET=SOME, GENERATE\n5, 25\n*ELSET, ELSET=ALL, GENERATE\n1, 99\n",
        )[0]
    )
    assert sorted(job.deck.numbers[job.nodes("SOME")]) == [5, 6, 7, 8, 21, 22, 23, 24, 25]
    assert sorted(job.deck.element_sets["ALL"]) == [1, 21]


@pytest.mark.ccx
@pytest.mark.parametrize("form", ["%.12e", "%.18e"])
def test_numbers_that_calculix_does_not_read_whole_are_refused(tmp_path, form):
    """A bar of 8 mm, in metres, is pulled by s: its end moves by s L / E. CalculiX takes it for a
    bar of 8 m if its numbers are too long."""
    bar = Block(1, lines((0, 0.008, 2), (0, 0.002, 1), (0, 0.002, 1)), 210e9, 0.0, "BAR")
    nodes = "".join(
        f"{n}, {', '.join(form % x for x in point)}\n"
        for n, point in zip(bar.numbers, bar.points, strict=True)
    )
    plain = bar.deck()
    deck = (
        f"*NODE, NSET=ALL\n{nodes}"
        + plain[plain.index("*ELEMENT") :]
        + node_set("FOOT", bar.on(0, 0))
        + "*BOUNDARY\nFOOT, 1, 3\n"
    )
    path, _ = run(tmp_path, deck + node_set("END", bar.on(0, 0.008)))
    if form == "%.18e":
        with pytest.raises(
            fo.ModelError,
            match=r"\*NODE has 4\.000000000000000083e-03, of which CalculiX reads 20 characters, .*such as %.12e",
        ):
            fo.readers.read_calculix(path)
        return
    job = fo.readers.read_calculix(path)
    u = np.linalg.solve(job.K.toarray(), job.force("END", traction=[1e6, 0.0, 0.0]))
    assert u[job.unknowns[job.nodes("END"), 0]] == pytest.approx(
        np.full(4, 1e6 * 0.008 / 210e9), rel=1e-9
    )


STORED = f"{MATRIX}*END STEP\n*STEP\n"


@pytest.mark.ccx
@pytest.mark.parametrize(
    ("condition", "steps"),
    [
        ("", MATRIX),
        ("", f"{STORED}*BOUNDARY\nTOP, 1, 3\n*STATIC\n"),
        ("", f"{STORED}*BOUNDARY\nTOP, 1, 3\n{MATRIX}"),
        ("*BOUNDARY\n7, 3\n", f"*BOUNDARY, OP=NEW\nFOOT, 1, 3\n{MATRIX}"),
        ("", f"*BOUNDARY, OP=NEW\nFOOT, 1, 2\n*BOUNDARY, OP=NEW\nFOOT, 3\n{MATRIX}"),
    ],
)  # fmt: skip
def test_conditions_of_other_steps_hold_nothing_in_the_step_of_the_matrix(
    tmp_path, condition, steps
):
    """Nodes of a face follow one of them along z, and no condition of another step holds them."""
    top = LOW.on(2, 1)
    rules = "".join(equation(*terms) for terms in chained(top, 3))
    deck = LOW.deck() + FOOT + node_set("TOP", top) + rules + condition
    job = fo.readers.read_calculix(run(tmp_path, deck, steps)[0])
    along_z = job.unknowns[job.nodes("TOP"), 2]
    assert (along_z >= 0).sum() == 1 and (along_z == -2).sum() == len(top) - 1
    with pytest.raises(fo.ModelError, match=r"the deck has \*EQUATION"):
        job.force("TOP", pressure=1.0)
    foot = job.nodes("FOOT")
    assert np.argwhere((job.unknowns == -1).all(axis=1)).ravel().tolist() == sorted(foot)


@pytest.mark.ccx
def test_included_files_are_those_that_calculix_reads(tmp_path):
    """A file that another one includes is beside the deck, even if a file beside that one is, too.

    The other file has a material ten times as stiff.
    """
    text = LOW.deck() + FOOT
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/all.inc").write_text("*INCLUDE, INPUT=low.inc\n")
    (tmp_path / "low.inc").write_text(text + "*NSET, NSET=RIGHT\n1\n")
    (tmp_path / "parts/low.inc").write_text(text.replace("1000.0", "1e4"))
    job = fo.readers.read_calculix(run(tmp_path, "*INCLUDE, INPUT=parts/all.inc\n")[0])
    known = fo.readers.read_calculix(run(tmp_path, text, name="known")[0])
    assert (job.K != known.K).nnz == 0 and job.deck.sets.keys() == {"ALL", "FOOT", "RIGHT"}
    # Other codes look for it beside the file that includes it.
    (tmp_path / "low.inc").unlink()
    assert fo.readers.read_calculix(tmp_path / "job").deck.sets.keys() == {"ALL", "FOOT"}


@pytest.mark.ccx
@pytest.mark.parametrize(
    "part",
    [
        "*RIGID BODY, NSET=FOOT, REF NODE=100\n",
        "*COUPLING, REF NODE=100, SURFACE=FACE, CONSTRAINT NAME=C\n*KINEMATIC\n1, 3\n",
    ],
)
def test_rotations_of_rigid_parts_are_refused_with_the_way_out(tmp_path, part):
    deck = "*NODE\n100, 0.5, 0.5, 2.\n*SURFACE, NAME=FACE\nLOW, S2\n" + part
    job, _ = run(tmp_path, LOW.deck() + FOOT.replace("*BOUNDARY\nFOOT, 1, 3\n", "") + deck)
    with pytest.raises(fo.ModelError, match=r"rotations of its \*RIGID BODY .* read_joint"):
        fo.readers.read_calculix(job)
