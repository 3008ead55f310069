"""The file that keeps the runs of a study.

The tests check its contents, the data that are left alone, and the data that are refused.
"""

import os
import resource
import signal
import sqlite3
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from frictopt.study import runs
from helpers.cases import few
from helpers.foreign import Foreign
from helpers.runs import same, with_followed
from helpers.systems import CYCLE, random_system

CONTACT = random_system(np.random.default_rng(3), 3)
FACTORS = np.linspace(0.1, 2.0, 20)
DRIVER = """
import sys
import test_dissipation_store as tests
from frictopt.study.store import Store
write = Store.write
def told(*run):
    write(*run)
    print(flush=True)
    sys.stdin.readline()
Store.write = told
tests.study(store=sys.argv[1])
"""

AT_WORK = """
import signal
import sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # which a process in the background ignores
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from frictopt.study.runs import TaskSettings
import test_dissipation_store as tests
tests.runs.SETTINGS = TaskSettings(most_tasks=2)
options = {"initializer": tests.hang_at, "initargs": (sys.argv[1],)}
with ProcessPoolExecutor(2, get_context("spawn"), **options) as pool:
    try:
        tests.study(executor=pool, store=sys.argv[1])
    except KeyboardInterrupt as interrupt:
        print(len(interrupt.table), flush=True)
        sys.stdin.readline()
"""
PATH = os.environ | {
    "PYTHONPATH": os.pathsep.join(
        [
            str(Path(fo.__file__).parents[1]),
            str(Path(__file__).parents[1]),
            str(Path(__file__).parent),
        ]
    )
}


def hang_at(store):
    """Let the eighth run of each of two tasks never end, and say that it has begun."""

    def steady_state(*args, **options):
        if args[3] in (FACTORS[7], FACTORS[17]):
            Path(f"{store}.{args[3]}").touch()
            time.sleep(1e6)
        return fo.steady_state(*args, **options)

    runs.steady_state = steady_state
    runs.SETTINGS = runs.TaskSettings(seconds=1e9)


def study(**options):
    return fo.dissipation_study(CONTACT, CYCLE, 0.4, FACTORS, **options)


def continued(store, undisturbed):
    """The load factors of the runs that a store lacks; with them its study is as undisturbed."""
    table, new = with_followed(store, lambda: study(store=store))
    same(table, undisturbed)
    return new.load_factor.tolist()


@pytest.fixture(scope="module")
def undisturbed():
    return study()


@pytest.fixture
def file(tmp_path, undisturbed):
    """A store with all runs."""
    same(study(store=tmp_path / "runs.sqlite"), undisturbed)
    return tmp_path / "runs.sqlite"


def changed(file, statement, *values):
    """Change a store behind its back."""
    with sqlite3.connect(file) as connection:
        connection.execute("PRAGMA ignore_check_constraints = 1")
        connection.execute(statement, values)
    connection.close()


def test_the_file_holds_every_run_with_all_its_digits(file, undisturbed):
    """Any program that reads sqlite can read it, among them pandas."""
    table = fo.results.read_store(file)
    by_load = table.sort_values("load_factor", ignore_index=True)
    columns = [name for name in table.columns if name not in ("key", "loads", "seconds", "version")]
    pd.testing.assert_frame_equal(by_load[columns], undisturbed[columns], check_exact=True)
    assert table.key.is_unique and table.key.is_monotonic_increasing
    with sqlite3.connect(file) as connection:
        raw = pd.read_sql("SELECT * FROM runs ORDER BY load_factor", connection)
    connection.close()
    assert raw.dissipation.tolist() == undisturbed.dissipation.tolist()
    assert [path.name for path in file.parent.iterdir()] == ["runs.sqlite"]


def test_a_store_without_a_name_is_refused_and_one_at_home_is_found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    with pytest.raises(fo.StoreError, match="store: ''"):
        study(store="")
    study(store="~/runs")
    assert [path.name for path in tmp_path.iterdir()] == ["home"]
    assert len(fo.results.read_store("~/runs")) == len(FACTORS)


def text(path):
    path.write_text("text")


def table(path):
    pd.DataFrame({"key": [1]}).to_parquet(path)


def database(path):
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE runs (key text)")
    connection.close()


@pytest.mark.parametrize(
    "make",
    [text, table, database, Path.mkdir, os.mkfifo],
    ids=["text", "parquet", "sqlite", "folder", "pipe"],
)
def test_what_is_no_store_is_named_and_left_as_it_is(tmp_path, make):
    foreign = tmp_path / "foreign"
    make(foreign)
    before = foreign.stat(), foreign.read_bytes() if foreign.is_file() else None
    for use in (lambda: study(store=foreign), lambda: fo.results.read_store(foreign)):
        with pytest.raises(fo.StoreError, match=r"store: .*foreign.*give another name"):
            use()
    after = foreign.stat(), foreign.read_bytes() if foreign.is_file() else None
    assert (after[0].st_mtime_ns, after[0].st_size, after[1]) == (
        before[0].st_mtime_ns,
        before[0].st_size,
        before[1],
    )
    assert [path.name for path in tmp_path.iterdir()] == ["foreign"]


def test_files_beside_a_store_are_left_alone(tmp_path):
    for make, name in (
        (text, "runs.txt"),
        (table, "runs.parquet"),
        (table, "x.parquet"),
        (database, "other.sqlite"),
        (text, ".x.journal"),
    ):
        make(tmp_path / name)
    before = {
        path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in tmp_path.iterdir()
    }
    for _ in range(2):
        study(store=tmp_path / "runs.sqlite")
    after = {path.name: (path.read_bytes(), path.stat().st_mtime_ns) for path in tmp_path.iterdir()}
    assert after.pop("runs.sqlite") and after == before


@pytest.mark.parametrize(
    "change",
    ["ALTER TABLE runs ADD COLUMN more real", "PRAGMA user_version = 2", "PRAGMA user_version = 0"],
)
def test_a_store_of_another_version_is_refused(file, change):
    changed(file, change)
    for use in (lambda: study(store=file), lambda: fo.results.read_store(file)):
        with pytest.raises(fo.StoreError, match=r"runs\.sqlite' .* of another version of frictopt"):
            use()


def test_a_missing_store_is_not_made_by_reading(tmp_path):
    with pytest.raises(fo.StoreError, match="runs"):
        fo.results.read_store(tmp_path / "runs")
    assert not list(tmp_path.iterdir())


def test_a_folder_is_no_store(tmp_path):
    for use in (study, lambda store: fo.results.read_store(store)):
        with pytest.raises(fo.StoreError, match=r"it is a folder.*give another name"):
            use(store=tmp_path)


@pytest.mark.parametrize("path", ["/proc/runs.sqlite", "a\0b", "/dev/null", 3, b"runs"])
def test_a_store_that_cannot_be_made_is_named(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(fo.StoreError, match=r"store: .*(runs|x00|null|3)"):
        study(store=path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "change",
    [
        "dissipation = 1000 * dissipation + 1",
        "dissipation = -1.0",
        "outcome = NULL",
        "outcome = 'SHAKE'",
        "dissipation = NULL",
        "cycles = 'many'",
        "cycles = cycles + 1",
        "start = x'ff'",
        "start = CAST(x'ff' AS text)",
        "checksum = 0",
    ],
)
def test_a_row_that_was_changed_is_not_believed_and_its_run_repeated(file, undisturbed, change):
    victim = fo.results.read_store(file).query("dissipation > 0").key.iloc[0]
    changed(file, f"UPDATE runs SET {change} WHERE key = ?", victim)
    with pytest.warns(fo.results.DamagedRows, match=r"runs\.sqlite': 1 row is"):
        assert len(fo.results.read_store(file)) == len(FACTORS) - 1
    with pytest.warns(fo.results.DamagedRows):
        assert len(continued(file, undisturbed)) == 1
    assert len(fo.results.read_store(file)) == len(FACTORS)


def test_a_killed_process_loses_no_finished_run(tmp_path, undisturbed):
    """Each process continues where the last process was killed, and is killed itself after some
    more runs."""
    for done in (1, 8):
        with subprocess.Popen(
            [sys.executable, "-c", DRIVER, tmp_path / "runs"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=PATH,
        ) as driver:
            try:
                for _ in range(done):
                    assert driver.stdout.readline() == "\n"
                    print(file=driver.stdin, flush=True)
                assert driver.stdout.readline() == "\n"
            finally:
                driver.kill()
    assert len(fo.results.read_store(tmp_path / "runs")) == 2 + 9
    assert len(continued(tmp_path / "runs", undisturbed)) == len(FACTORS) - 11


def test_ctrl_c_in_a_terminal_loses_only_the_runs_at_work(tmp_path, undisturbed):
    """It comes to all processes: the rows that the two tasks have finished come with it."""
    options = {
        "stdin": subprocess.PIPE,
        "stdout": subprocess.PIPE,
        "text": True,
        "env": PATH,
        "start_new_session": True,
    }
    with subprocess.Popen([sys.executable, "-c", AT_WORK, tmp_path / "runs"], **options) as driver:
        try:
            patience = time.monotonic() + 300
            while len(list(tmp_path.glob("runs.*"))) < 2 and time.monotonic() < patience:
                time.sleep(0.1)
            os.killpg(driver.pid, signal.SIGINT)
            assert driver.stdout.readline() == "14\n"
        finally:
            os.killpg(driver.pid, signal.SIGKILL)
    assert continued(tmp_path / "runs", undisturbed) == [*FACTORS[7:10], *FACTORS[17:]]


KILLED = """
import os, sqlite3, sys
store = sqlite3.connect(sys.argv[1], isolation_level=None)
store.execute("PRAGMA cache_size = 1")
store.execute("BEGIN IMMEDIATE")
store.execute("UPDATE runs SET error = hex(randomblob(3000))")
os.kill(os.getpid(), 9)
"""


def test_a_store_whose_writer_was_killed_is_read_and_merged_and_goes_on(
    file, tmp_path, undisturbed
):
    """The killed process has written half of a change into the file."""
    for use in (
        lambda: len(fo.results.read_store(file)),
        lambda: fo.results.merge_stores(tmp_path / "into", [file]),
        lambda: len(study(store=file)),
    ):
        subprocess.run([sys.executable, "-c", KILLED, file], timeout=60)
        assert Path(f"{file}-journal").exists()
        assert use() == len(undisturbed)
        same(study(store=file), undisturbed)


def test_a_run_that_failed_is_tried_again_and_never_replaces_a_result(undisturbed, tmp_path):
    def late(future, rows):
        fo.results.merge_stores(tmp_path / "shared", tmp_path.glob("both"))  # once there is one
        if rows[0]["load_factor"] == FACTORS[-1]:
            future.set_exception(OSError("killed"))
        else:
            future.set_result(rows)

    first = study(store=tmp_path / "runs", executor=Foreign(late))
    assert (first.outcome == "FAILED").tolist() == 19 * [False] + [True]
    for name in ("first", "last"):
        fo.results.merge_stores(tmp_path / name, [tmp_path / "runs"])
    assert continued(tmp_path / "runs", undisturbed) == [FACTORS[-1]]
    for into, parts in (("first", ["runs"]), ("runs", ["last"]), ("both", ["runs", "last"])):
        merged = fo.results.merge_stores(tmp_path / into, [tmp_path / part for part in parts])
        assert merged == len(FACTORS)
        assert set(fo.results.read_store(tmp_path / into).error) == {""}
    late_one = study(store=tmp_path / "shared", executor=Foreign(late))
    assert late_one.outcome.iloc[-1] == "FAILED"
    assert set(fo.results.read_store(tmp_path / "shared").error) == {""}


def test_every_damaged_file_is_an_error_or_a_warning_but_never_another_table(
    file, tmp_path, undisturbed
):
    """Bits are flipped and ends are cut off at random places."""
    content, rng = file.read_bytes(), np.random.default_rng(0)
    harmed, errors = tmp_path / "harmed.sqlite", 0
    for number in few(range(60)):
        # The first place is in the word by which SQLite knows its files.
        place = int(rng.integers(len(content))) if number else 0
        harm = bytearray(content)
        harm[place] ^= 1 << int(rng.integers(8))
        harmed.write_bytes(content[:place] if number % 5 == 0 and place else bytes(harm))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", fo.results.DamagedRows)
                same(study(store=harmed), undisturbed)
                assert len(fo.results.read_store(harmed)) >= len(FACTORS)
        except fo.StoreError as error:
            errors += 1
            assert "harmed.sqlite" in str(error)
        for left in tmp_path.glob("harmed*"):
            left.unlink()
    assert errors


def test_a_full_disk_is_a_clear_error_and_what_is_done_is_kept(tmp_path, undisturbed):
    """The file may not grow any more after five runs."""
    store = tmp_path / "runs.sqlite"
    fo.dissipation_study(CONTACT, CYCLE, 0.4, FACTORS[:5], store=store)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, limits[1]))
    try:
        with pytest.raises(fo.StoreError, match=r"runs\.sqlite.*free disk space") as caught:
            study(store=store)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    same(caught.value.table, undisturbed.head(6))
    assert continued(store, undisturbed) == FACTORS[5:].tolist()


def test_a_store_that_goes_away_leaves_the_finished_rows_in_the_error(tmp_path, undisturbed):
    def gone(future, rows):
        if rows[0]["load_factor"] == FACTORS[3]:
            (tmp_path / "store").rename(tmp_path / "elsewhere")
        future.set_result(rows)

    with pytest.raises(fo.StoreError, match="check that the file and its folder exist") as caught:
        study(store=tmp_path / "store" / "runs", executor=Foreign(gone))
    same(caught.value.table, undisturbed)


def test_studies_that_write_at_the_same_time_keep_each_run_once(undisturbed, tmp_path):
    """Both have followed all runs before either writes."""
    turns = threading.Barrier(2, timeout=60)

    def together(future, rows):
        turns.wait()
        future.set_result(rows)

    with ThreadPoolExecutor(2) as threads:
        tables = [
            future.result()
            for future in [
                threads.submit(study, store=tmp_path / "runs", executor=Foreign(together))
                for _ in range(2)
            ]
        ]
    for made in tables:
        same(made, undisturbed)
    kept = fo.results.read_store(tmp_path / "runs")
    assert kept.key.is_unique and len(kept) == len(FACTORS)


def test_a_store_can_be_read_while_it_is_written(tmp_path):
    store, seen = tmp_path / "runs", []
    with ThreadPoolExecutor(1) as threads:
        writer = threads.submit(study, store=store)
        while not writer.done():
            with suppress(fo.StoreError):  # not made yet
                seen.append(len(fo.results.read_store(store)))
        writer.result()
    assert seen == sorted(seen) and 0 < len(set(seen)) and set(seen) <= {*range(len(FACTORS) + 1)}
