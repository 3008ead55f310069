"""A study whose processes are killed without warning, or interrupted."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

import frictopt as fo
import killed_study

ROOT = Path(__file__).parent.parent
pytestmark = pytest.mark.slow
PATIENCE = 120  # seconds, until a process that hangs is an error


@pytest.fixture(scope="module")
def undisturbed():
    return killed_study.study()


@pytest.fixture
def begin(tmp_path):
    """Begin a study in a process group of its own, like the job of a shell; it is killed with the test."""
    begun = []

    def started(*pool):
        command = [sys.executable, str(ROOT / "tests" / "killed_study.py"), str(tmp_path / "store"), str(tmp_path / "table"), *pool]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")])}
        environment |= {"OPENBLAS_NUM_THREADS": "1"}  # as in the process of the tests: several threads round otherwise
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        begun.append(subprocess.Popen(command, env=environment, start_new_session=True, **pipes))
        return begun[-1]

    yield started
    for driver in begun:
        driver.kill()
        driver.communicate()


def same(table, undisturbed):
    pd.testing.assert_frame_equal(table.drop(columns="seconds"), undisturbed.drop(columns="seconds"), check_exact=True)


def test_kills_lose_no_finished_run(begin, tmp_path, undisturbed):
    """Each driver goes on where the last one was killed."""
    known = set()
    for count in (1, 100):
        driver = begin()
        known |= {driver.stdout.readline().strip() for _ in range(count)}
        driver.kill()
        driver.wait(timeout=PATIENCE)
        kept = fo.results.read_store(tmp_path / "store")
        assert kept.key.is_unique and known <= set(kept.key)
    assert len(known) < len(undisturbed)
    same(killed_study.study(store=tmp_path / "store"), undisturbed)
    assert len(fo.results.read_store(tmp_path / "store")) == len(undisturbed)


@pytest.mark.parametrize("pool", [(), ("executor",)])
def test_ctrl_c_ends_with_a_usable_table(begin, tmp_path, undisturbed, pool):
    driver = begin(*pool)
    kept = [driver.stdout.readline() for _ in range(101)]
    os.killpg(driver.pid, signal.SIGINT)  # what Ctrl-C does: every process of the group hears it
    _, errors = driver.communicate(timeout=PATIENCE)
    assert driver.returncode == -signal.SIGINT and "KeyboardInterrupt\ndissipation_study: " in errors
    table = pd.read_pickle(tmp_path / "table")
    assert len(kept) <= len(table) == len(undisturbed) - table.attrs["missing"] < len(undisturbed)
    stored = fo.results.read_store(tmp_path / "store")
    assert len(table) - 1 <= len(stored) <= len(table)  # it may have been stopped on the way to the store
    keys = ["load_factor", "start"]
    same(table, undisturbed.set_index(keys).loc[pd.MultiIndex.from_frame(table[keys])].reset_index()[table.columns])


def test_runs_of_a_pool_whose_processes_die_are_rows_that_say_so_and_are_run_again(begin, tmp_path, undisturbed):
    driver = begin("dying")
    _, errors = driver.communicate(timeout=PATIENCE)
    assert driver.returncode == 0, errors
    table = pd.read_pickle(tmp_path / "table")
    lost = table.outcome == "FAILED"
    assert lost.any() and table.error[lost].str.contains("BrokenProcessPool").all()
    assert 20 <= (~lost).sum() == len(fo.results.read_store(tmp_path / "store"))
    same(killed_study.study(store=tmp_path / "store"), undisturbed)
