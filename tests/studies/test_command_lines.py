"""Command lines of the studies and the figures: what cannot be done is said before anything is
computed."""

from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd
import pytest

import paper_figures.__main__ as figures
import studies.__main__ as studies
from paper_figures import style
from studies import tables
from studies.origin import machine


@dataclass(frozen=True)
class Nothing:
    """No parameters."""


def with_study(monkeypatch, compute):
    """The study `small` has one table."""
    table = tables.Table(
        "small", "nothing", {"residual": "0"}, full=Nothing(), quick=Nothing(), compute=compute
    )
    monkeypatch.setitem(
        studies.STUDIES, "small", tables.Study("studies.small", "Nothing.", "the same", (table,))
    )


@pytest.fixture
def computed(monkeypatch):
    """How often the table of the study `small` was computed."""
    calls = []

    def compute(_parameters):
        calls.append(1)
        return pd.DataFrame({"residual": [0.0]})

    with_study(monkeypatch, compute)
    return calls


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "file"
    path.write_text("text")
    return path


@pytest.mark.parametrize("name", ["{}", "a\0b", "s3://bucket/x"])
def test_a_folder_that_cannot_be_written_in_is_refused_before_anything_is_computed(
    computed, file, name, capsys
):
    with pytest.raises(SystemExit) as end:
        studies.main(["small", "--data", name.format(file)])
    assert (
        end.value.code == 2
        and "--data: " in (said := capsys.readouterr().err)
        and "is no folder to write in" in said
    )
    assert not computed


NO_NUMBERS = ["--seed=-1", "--seed=" + "9" * 5000, "--cases=0", "--cases=9999999"]


@pytest.mark.parametrize("option", NO_NUMBERS)
def test_numbers_of_random_contacts_are_checked_before_anything_is_computed(
    option, tmp_path, capsys
):
    with pytest.raises(SystemExit) as end:
        studies.main(["fuzz", "--cases", "1", "--data", str(tmp_path), option])
    name, _, value = option.partition("=")
    assert end.value.code == 2 and f"{name}: {value!r}" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def interrupted(*_args, **_options):
    raise KeyboardInterrupt


def test_ctrl_c_ends_a_study_and_the_figures_without_a_traceback(tmp_path, monkeypatch, capsys):
    with_study(monkeypatch, interrupted)
    assert studies.main(["small", "--data", str(tmp_path)]) == tables.INTERRUPTED
    monkeypatch.setattr(figures, "make", interrupted)
    assert (
        figures.main(["scene", "--data", str(tmp_path), "--output", str(tmp_path)])
        == tables.INTERRUPTED
    )
    assert capsys.readouterr().err.count("interrupted; finished tables") == 2


def test_figures_go_nowhere_but_to_a_folder(file, tmp_path, monkeypatch, capsys):
    for option in ("--output", "--data"):
        with pytest.raises(SystemExit) as end:
            figures.main(["scene", option, str(file)])
        assert end.value.code == 2 and f"{option}: " in capsys.readouterr().err
    monkeypatch.setattr(style, "output_folder", lambda _quick: Path(file))
    assert figures.main(["scene", "--data", str(tmp_path)]) == 1
    assert "is no folder to write in" in capsys.readouterr().err


def test_a_page_holds_what_is_printed_and_its_origin(computed, tmp_path, monkeypatch, capsys):
    small = studies.STUDIES["small"]
    drawn = []

    def picture(tables, folder):
        drawn.append(({name: len(table) for name, table in tables.items()}, folder))
        return folder / "small.png"

    told = replace(small, summary=lambda made: f"{len(made['small'])} row\n", picture=picture)
    monkeypatch.setitem(studies.STUDIES, "small", told)
    assert (
        studies.main(
            ["small", "--quick", "--data", str(tmp_path / "data"), f"--page={tmp_path / 'pages'}"]
        )
        == 0
    )
    printed = capsys.readouterr().out.splitlines()
    page = (tmp_path / "pages" / "small.md").read_text().split("\n\n")
    assert printed[1:] == [str(tmp_path / "data" / "small.png"), "1 row", ""] and drawn == [
        ({"small": 1}, tmp_path / "data")
    ]
    assert page[0] == "1 row" and len(page) == 2
    assert page[1].startswith("*Made by `python -m studies small --quick`, frictopt ") and page[
        1
    ].endswith(f" s on {machine()}.*\n")
    assert str(tmp_path) not in page[1] and computed == [1]
