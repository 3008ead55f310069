"""Variants of a joint in one table, compared with their reports."""

import json

import numpy as np
import pytest

import frictopt as fo
from helpers.command import main
from helpers.systems import BLOCK, PUSHED_AND_PULLED


@pytest.fixture(scope="module")
def variants():
    return {
        name: fo.report(BLOCK, PUSHED_AND_PULLED, friction, [1.0])
        for name, friction in (("today", 0.5), ("rough", 0.8), ("again", 0.5))
    }


def test_values_differences_and_the_best_are_those_of_the_reports(variants):
    """Jenkins' element: the limit is the friction, and the work 4 f (1 - f) / 3."""
    table = fo.compare(variants).table.set_index("number")
    for name, report in variants.items():
        assert table[name].tolist() == report.numbers["value"].tolist()
    assert table.loc["shakedown limit", "rough - today"] == pytest.approx(0.3)
    work = 4 / 3 * (0.8 * 0.2 - 0.5 * 0.5)
    assert table.loc["work per cycle", "rough - today"] == pytest.approx(work)
    for name in ("shakedown limit", "work per cycle", "largest slip range"):
        assert table.loc[name, "best"] == "rough"
    assert table.loc["required friction", "best"] == ""
    assert (table["again - today"].drop("gross-slip load") == 0).all()
    assert table.loc["work per cycle", "unit"] == "N mm per depth"


def test_files_have_the_same_table_and_one_picture(variants, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, report in variants.items():
        report.save(f"{name}.json")
    files = fo.compare({name: f"{name}.json" for name in variants})
    assert files.table.equals(fo.compare(variants).table)
    axes = files.plot()
    drawn = np.asarray(axes.lines[1].get_xdata(), dtype=float)
    row = files.table["number"].tolist().index("shakedown limit")
    assert drawn[row] == pytest.approx(0.8 / 0.5)
    assert main(["compare", "today.json", "rough.json", "--picture", "variants.png"]) == 0
    assert "rough - today" in capsys.readouterr().out
    assert (tmp_path / "variants.png").stat().st_size > 1e4
    assert main(["compare", "today.json", "none.json"]) == 4
    assert main(["compare", "today.json"]) == 2
    capsys.readouterr()
    assert main(["compare", "today.json", "rough.json", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["tables"]["numbers"]
    assert [row["number"] for row in rows] == files.table["number"].tolist()


def test_reports_in_other_units_are_refused(variants):
    bare = fo.report(
        fo.ContactSystem(BLOCK.S, BLOCK.points, BLOCK.bonded), PUSHED_AND_PULLED, 0.5, pages=1
    )
    with pytest.raises(fo.ModelError, match=r"reports: \['today', 'bare'\]; .* same units"):
        fo.compare({"today": variants["today"], "bare": bare})
    with pytest.raises(fo.ModelError, match=r"reports: \['today'\]; give two"):
        fo.compare({"today": variants["today"]})
    with pytest.raises(fo.ModelError, match=r"reports\['M12'\]: 12"):
        fo.compare({"today": variants["today"], "M12": 12})
