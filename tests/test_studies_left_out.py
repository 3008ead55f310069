"""The study of what is left out, at quick size: the answers are the same, and each scene leaves out what it should. Times are not tested."""

import pytest

from studies.validation import left_out

pytestmark = pytest.mark.slow


STUDY = left_out.STUDY


@pytest.fixture
def table(tables):
    return tables["left_out"].set_index(["scene", "computation"])


def test_the_answers_are_the_same(table):
    assert len(table) == 12 and table["difference"].max() < 1e-9 and table["residual"].max() < 1e-9
    assert (table["saved"] > 0).all()


def test_the_report_has_a_line_for_each_scene_and_a_cell_for_each_computation(table):
    rows = table.reset_index()
    lines = [line for line in left_out.STUDY.summary({"left_out": rows}).splitlines() if line.startswith("|")]
    assert [line.split("|")[1].split(",")[0].strip() for line in lines[2:]] == list(dict.fromkeys(rows["scene"]))
    assert sum(line.count("→") + line.count("nothing left out") for line in lines[2:]) == len(rows)
    assert sum(line.count("nothing left out") for line in lines[2:]) == (rows["left_out"] == "").sum() > 0


@pytest.mark.parametrize(
    ("scene", "computation", "words"),
    [
        ("paper", "shakedown limit", ["mirror"]),
        ("with shear", "shakedown limit", []),
        ("uncoupled", "shakedown limit", ["linear program"]),
        ("sampled", "safe slip", ["mirror", "14 of 16 rule no node"]),
        ("ellipse", "shakedown limit", ["mirror", "corners"]),
    ],
)
def test_each_scene_leaves_out_what_it_should(table, scene, computation, words):
    text = table.loc[(scene, computation), "left_out"]
    assert all(word in text for word in words) and bool(text) == bool(words)
    assert ("mirror" in text) == ("mirror" in words)
