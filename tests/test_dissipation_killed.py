"""A campaign whose processes are killed without warning, at random moments."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import psutil
import pyarrow.parquet as pq
import pytest

import campaign

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parent.parent
PATIENCE = 600  # seconds, until a process that hangs is an error


@pytest.fixture(scope="module")
def undisturbed():
    return campaign.study(workers=1)


def begun(folder, target):
    """A campaign in its own process, with at least `target` runs in its store."""
    folder.mkdir()
    command = [sys.executable, str(ROOT / "tests" / "campaign.py"), str(folder / "store"), str(folder / "table")]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    driver = psutil.Popen(command, cwd=ROOT, env=environment, stderr=subprocess.PIPE, preexec_fn=hear_interrupts)
    until(lambda: kept(folder) >= target or driver.poll() is not None)
    return driver


def hear_interrupts():
    """Undo what shells do to jobs in the background, which do not hear Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def kept(folder):
    """Number of runs in a store."""
    store = folder / "store"
    while True:
        try:
            lines = sum(journal.read_bytes().count(b"\n") for journal in store.glob(".*.journal"))
            return lines + sum(pq.read_metadata(part).num_rows for part in store.glob("[!.]*.parquet"))
        except FileNotFoundError:  # a journal was folded meanwhile
            continue


def until(done):
    end = time.monotonic() + PATIENCE
    while not done():
        assert time.monotonic() < end
        time.sleep(0.002)


def workers(driver):
    return [child for child in driver.children() if "spawn_main" in " ".join(child.cmdline())]


def same(table, undisturbed):
    pd.testing.assert_frame_equal(table.drop(columns="seconds"), undisturbed.drop(columns="seconds"), check_exact=True)


def killed_driver(folder, target, undisturbed):
    """Kill the driver: every part of its store stays and is right, its workers end, and the study started again completes the table."""
    driver = begun(folder, target)
    left, before = workers(driver), kept(folder)
    driver.kill()
    driver.communicate()
    assert not psutil.wait_procs(left, timeout=PATIENCE)[1]
    assert 0 < before <= kept(folder)
    same(campaign.study(workers=1, store=folder / "store"), undisturbed)
    return before


def killed_worker(folder, target, undisturbed, number=0):
    """Kill a worker: the driver goes on with new ones and ends with the whole table."""
    driver = begun(folder, target)
    found = workers(driver)
    if found:
        found[number % len(found)].kill()
    _, errors = driver.communicate(timeout=PATIENCE)
    assert driver.returncode == 0, errors.decode()
    same(pd.read_parquet(folder / "table"), undisturbed)
    return len(found)


def test_a_killed_driver_loses_no_finished_run(tmp_path, undisturbed):
    assert 0 < killed_driver(tmp_path / "run", random.Random(0).randint(1, len(undisturbed) - 100), undisturbed) < len(undisturbed)


def test_a_killed_worker_loses_no_run(tmp_path, undisturbed):
    assert killed_worker(tmp_path / "run", random.Random(5).randint(1, len(undisturbed) - 300), undisturbed)


def test_ctrl_c_on_the_whole_group_ends_with_a_usable_table(tmp_path, undisturbed):
    driver = begun(tmp_path / "run", 200)
    for process in (driver, *workers(driver)):
        process.send_signal(signal.SIGINT)
    _, errors = driver.communicate(timeout=PATIENCE)
    assert driver.returncode == 0 and b"Interrupted: dissipation_study: interrupted" in errors and b"Traceback" not in errors
    table = pd.read_parquet(tmp_path / "run" / "table")
    assert 200 <= len(table) == len(undisturbed) - table.attrs["missing"] < len(undisturbed)
    keys = ["load_factor", "start"]
    same(table, undisturbed.set_index(keys).loc[pd.MultiIndex.from_frame(table[keys])].reset_index()[table.columns])


@pytest.mark.parametrize("pause", [0.01, 0.02, 0.03])
def test_a_second_ctrl_c_ends_it_too(tmp_path, pause):
    """Whatever the second one interrupts, the first one's orderly end among it, no process waits for another one for ever."""
    driver = begun(tmp_path / "run", 20)
    left = workers(driver)
    for _ in range(2):
        driver.send_signal(signal.SIGINT)
        time.sleep(pause)
    driver.communicate(timeout=60)
    assert not psutil.wait_procs(left, timeout=60)[1]


def test_ctrl_c_is_not_heard_by_workers_that_still_import(tmp_path):
    driver = begun(tmp_path / "run", 0)
    until(lambda: workers(driver) or driver.poll() is not None)
    for process in (*workers(driver), driver):
        process.send_signal(signal.SIGINT)
    _, errors = driver.communicate(timeout=PATIENCE)
    assert driver.returncode == 0 and b"Interrupted: dissipation_study: interrupted" in errors and b"Traceback" not in errors


def test_workers_that_die_at_once_end_in_rows_that_say_so(tmp_path, monkeypatch):
    monkeypatch.setattr("frictopt.study.execute._set_up", campaign.end)
    table = campaign.study(workers=2, store=tmp_path / "store")
    assert (table.outcome == "FAILED").all() and table.error.str.contains("its worker died").all()
    assert not kept(tmp_path)
