"""Tables of the studies: when a stored one is used again, and what is left where one cannot be
written."""

import os
import pickle
import sys
from dataclasses import dataclass, replace
from types import ModuleType

import pandas as pd
import pytest

import frictopt as fo
from studies.__main__ import STUDIES
from studies.tables import Table


@dataclass(frozen=True)
class Count:
    """Parameters of a table that costs nothing."""

    rows: int = 3


@pytest.fixture
def counted():
    """A table, and the list of the parameters that it was computed with."""
    calls = []

    def compute(parameters):
        calls.append(parameters)
        return pd.DataFrame({"square": [row**2 for row in range(parameters.rows)]})

    return Table(
        "squares", "a square", {"square": "number"}, full=Count(), quick=Count(2), compute=compute
    ), calls


@pytest.mark.parametrize("name", STUDIES)
def test_tables_travel_to_other_processes_with_their_options(name):
    for table in STUDIES[name].tables:
        assert pickle.loads(pickle.dumps(table)).parameters(quick=True) == table.quick


def test_stored_table_is_used_again(counted, tmp_path):
    table, calls = counted
    made = table.load(Count(), tmp_path)
    again = table.load(Count(), tmp_path)
    assert len(calls) == 1
    pd.testing.assert_frame_equal(made, again)
    assert made.attrs == again.attrs


def test_other_parameters_or_version_ask_for_a_new_table(counted, tmp_path, monkeypatch):
    table, calls = counted
    table.load(Count(), tmp_path)
    assert len(table.load(Count(5), tmp_path)) == 5
    monkeypatch.setattr(fo, "__version__", "0.0.0")
    assert table.load(Count(5), tmp_path).attrs["versions"]["frictopt"].startswith("0.0.0+")
    assert calls == [Count(), Count(5), Count(5)]


PACKAGE = '"""What it is."""\n\n\ndef one():\n    """One."""\n    return 1  # a number\n'
STUDY = '"""A study."""\n\nfrom . import shared\n\nLIMIT = 1\n"""Its limit."""\n'
SHARED = "VALUE = 1\n"


@pytest.fixture
def sources(counted, tmp_path, monkeypatch):
    """A table of a study in a package of one file each, which shares a file with other studies, and
    these four files."""
    files = {}
    for name, text in (
        ("frictopt", PACKAGE),
        ("studies.study", STUDY),
        ("studies.shared", SHARED),
        ("studies.other", STUDY),
    ):
        files[name] = tmp_path / name / "__init__.py"
        files[name].parent.mkdir()
        files[name].write_text(text)
        module = ModuleType(name)
        module.__file__, module.__package__ = str(files[name]), name.partition(".")[0]
        if name != "frictopt":
            monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(fo, "__file__", str(files["frictopt"]))
    table, calls = counted
    table.compute.__module__ = "studies.study"
    table.load(Count(), tmp_path)
    return table, calls, files


@pytest.mark.parametrize(
    ("name", "old", "new", "stale"),
    [
        ("frictopt", "What it is", "What it was", False),
        ("frictopt", '    """One."""\n', "", False),
        ("frictopt", "a number", "a figure", False),
        ("frictopt", "return 1", "return 2", True),
        ("studies.study", "A study", "The study", False),
        ("studies.study", "Its limit", "The limit", False),
        ("studies.study", "LIMIT = 1", "LIMIT = 2", True),
        ("studies.shared", "VALUE = 1", "VALUE = 2", True),
        ("studies.other", "LIMIT = 1", "LIMIT = 2", False),
    ],
)
def test_code_makes_a_table_stale_and_words_do_not(sources, tmp_path, name, old, new, stale):
    table, calls, files = sources
    text = files[name].read_text()
    assert text.count(old) == 1
    files[name].write_text(text.replace(old, new))
    table.load(Count(), tmp_path)
    assert len(calls) == 1 + stale


def test_other_columns_or_a_spoilt_file_ask_for_a_new_table(counted, tmp_path):
    table, calls = counted
    table.load(Count(), tmp_path)
    assert replace(table, columns={"square": "another meaning"}).stored(Count(), tmp_path) is None
    table.path(tmp_path).write_bytes(b"half a table")
    assert table.stored(Count(), tmp_path) is None
    assert len(table.load(Count(), tmp_path)) == 3 and len(calls) == 2


def test_interrupted_write_leaves_the_old_table(counted, tmp_path, monkeypatch):
    table, _ = counted
    table.make(Count(), tmp_path)

    def fail(source, target):
        assert len(pd.read_parquet(source)) == 5, (
            "the new table is complete before it takes the old one's place"
        )
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        table.make(Count(5), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["squares.parquet"]
    assert len(pd.read_parquet(table.path(tmp_path))) == 3


@pytest.mark.parametrize(
    "name",
    "all_sets fatigue_band forced_response guaranteed increments joint left_out lift_off limits range separation spatial validity vanishing".split(),
)
def test_every_row_of_a_study_was_checked(quick, name):
    for table in quick(STUDIES[name].tables).values():
        assert table["residual"].between(0, 1e-9).all()


@pytest.mark.parametrize(
    ("columns", "error"),
    [
        ({"square": "", "cube": ""}, r"\['cube'\] are not computed"),
        ({}, r"computed ones \['square'\] not described"),
    ],
)
def test_columns_must_be_described_and_computed(counted, tmp_path, columns, error):
    table, _ = counted
    with pytest.raises(ValueError, match=f"squares: .*{error}"):
        replace(table, columns=columns).make(Count(), tmp_path)
    assert not list(tmp_path.iterdir())
