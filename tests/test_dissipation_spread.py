"""Where the runs of a campaign go, and where they are kept: executors, processes and stores that do not do what they should."""

import os
import subprocess
import sys
import threading
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from frictopt.study import StoreError, execute, store
from systems import CYCLE, random_system

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
CONTACT = random_system(np.random.default_rng(3), 3)
FACTORS = np.linspace(0.1, 2.0, 20)  # more than one batch

UNGUARDED = """
import numpy as np
import frictopt as fo
from systems import CYCLE, random_system
print("script")
fo.dissipation_study(random_system(np.random.default_rng(3), 3), CYCLE, 0.4, [0.1, 0.2], workers=2)
"""


class Foreign(Executor):
    """An executor that hands out what `answer` makes of a batch's rows, and takes `most` batches."""

    def __init__(self, answer, most=9):
        self.answer, self.most = answer, most

    def submit(self, follow, contact, batch):
        self.most -= 1
        if self.most < 0:
            raise OSError("link down")
        future = Future()
        self.answer(future, follow(contact, batch))
        return future


def study(**options):
    return fo.dissipation_study(CONTACT, CYCLE, 0.4, FACTORS, **options)


@pytest.fixture(scope="module")
def undisturbed():
    return study(workers=1).drop(columns="seconds")


def shut(kind):
    executor = kind(1)
    executor.shutdown()
    return executor


class Submits:
    submit = staticmethod(lambda *_: 3)


@pytest.mark.parametrize("make", [lambda: shut(ThreadPoolExecutor), lambda: shut(ProcessPoolExecutor), lambda: ThreadPoolExecutor, Submits])
def test_an_executor_that_takes_no_runs_is_named(make):
    with pytest.raises(fo.ModelError, match=r"executor: .* takes no runs .*give one that is open"):
        study(executor=make())


def test_runs_that_an_executor_stops_taking_are_rows_that_say_so(undisturbed, tmp_path):
    table = study(executor=Foreign(Future.set_result, most=1), store=tmp_path)
    lost = table.outcome == "FAILED"
    assert lost.sum() == 4 and table.error[lost].str.contains("link down").all()
    pd.testing.assert_frame_equal(table[~lost].drop(columns="seconds"), undisturbed[~lost], check_exact=True)
    assert len(pd.read_parquet(tmp_path)) == 16


@pytest.mark.parametrize(
    "answer",
    [
        lambda future, rows: future.set_result(None),
        lambda future, rows: future.set_result(rows[:-1]),
        lambda future, rows: future.set_result([{"name": 1} for _ in rows]),
        lambda future, rows: future.set_exception(SystemExit(3)),
        lambda future, rows: future.cancel() and future.set_running_or_notify_cancel(),
    ],
)
def test_other_results_than_its_runs_are_no_results(answer, tmp_path):
    table = study(executor=Foreign(answer), store=tmp_path)
    assert len(table) == len(FACTORS) and (table.outcome == "FAILED").all() and not table.attrs["missing"]
    assert not list(tmp_path.iterdir())


def test_a_script_without_a_guard_is_told_so_and_its_workers_are_silent(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(UNGUARDED)
    paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    done = subprocess.run([sys.executable, script], env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, timeout=300)
    assert done.returncode == 1 and done.stderr.count("Traceback") == 1
    assert "ModelError: workers: 2 processes" in done.stderr and 'if __name__ == "__main__":' in done.stderr
    assert done.stdout.count("script") <= 4  # itself, two workers and a probe


def test_a_store_without_a_name_is_refused_and_one_at_home_is_found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    with pytest.raises(StoreError, match="store: ''"):
        study(workers=1, store="")
    study(workers=1, store="~/runs")
    assert [path.name for path in tmp_path.iterdir()] == ["home"] and len(pd.read_parquet(tmp_path / "home" / "runs")) == len(FACTORS)


def test_a_damaged_part_that_cannot_be_set_aside_is_named(tmp_path):
    study(workers=1, store=tmp_path)
    part = min(tmp_path.iterdir())
    part.write_text("text")
    (tmp_path / f"_damaged-{part.name}").mkdir()
    with pytest.raises(StoreError, match=f"cannot be read .*{part.name}") as caught:
        study(workers=1, store=tmp_path)
    assert caught.value.table is not None


def test_a_store_that_goes_away_leaves_the_finished_rows_in_the_error(tmp_path, monkeypatch):
    follow, followed = execute.follow, []

    def until_gone(*args):
        followed.append(args)
        if len(followed) == 4:
            for part in (tmp_path / "store").iterdir():
                part.unlink()
            (tmp_path / "store").rmdir()
        return follow(*args)

    monkeypatch.setattr(execute, "follow", until_gone)
    with pytest.raises(StoreError, match="leave the folder where it is") as caught:
        study(workers=1, store=tmp_path / "store")
    assert len(caught.value.table) == 4


def test_studies_in_threads_share_a_store(undisturbed, tmp_path, monkeypatch):
    """They write by turns, and the first one's journal is taken over by the second while both go on."""
    write, turns = store.Store.write, threading.Barrier(2, timeout=60)

    def by_turns(self, row):
        turns.wait()
        write(self, row)

    monkeypatch.setattr(store.Store, "write", by_turns)
    with ThreadPoolExecutor(2) as threads:
        tables = [future.result() for future in [threads.submit(study, workers=1, store=tmp_path) for _ in range(2)]]
    for table in tables:
        pd.testing.assert_frame_equal(table.drop(columns="seconds"), undisturbed, check_exact=True)
    kept = pd.read_parquet(tmp_path)
    assert kept["key"].nunique() == len(FACTORS) and [path.suffix for path in tmp_path.iterdir()] == [".parquet"] * 2


def test_a_journal_that_another_study_takes_over_loses_nothing(undisturbed, tmp_path, monkeypatch):
    write, others = store.Store.write, []

    def meanwhile(self, row):
        write(self, row)
        if len(others) < 3:
            others.append(store.Store(tmp_path))
            assert row["key"] in others[-1].read({row["key"]})

    monkeypatch.setattr(store.Store, "write", meanwhile)
    pd.testing.assert_frame_equal(study(workers=1, store=tmp_path).drop(columns="seconds"), undisturbed, check_exact=True)
    others[-1].fold()
    assert pd.read_parquet(tmp_path)["key"].nunique() == len(FACTORS)
