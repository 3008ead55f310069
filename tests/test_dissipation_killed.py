"""A campaign whose processes are killed without warning, at random moments, or interrupted."""

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pandas as pd
import psutil
import pytest

import campaign
import frictopt as fo

ROOT = Path(__file__).parent.parent
pytestmark = pytest.mark.slow
PATIENCE = 120  # seconds, until a process that hangs is an error


@pytest.fixture(scope="module")
def undisturbed():
    return campaign.study()


class Campaign:
    """A campaign in its own process, in a group of its own like the job of a shell."""

    def __init__(self, folder):
        command = [sys.executable, str(ROOT / "tests" / "campaign.py"), str(folder / "store"), str(folder / "table")]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        self.driver = subprocess.Popen(command, env=environment, start_new_session=True, preexec_fn=hear_interrupts, **pipes)
        self.kept, self.workers = [], []

    def listen(self, done):
        """Follow what it says, until that is enough or all."""
        while not done(self) and (line := self.driver.stdout.readline()):
            word, name = line.split()
            if word == "kept":
                self.kept.append(name)
            else:
                self.workers.append(psutil.Process(int(name)))

    def interrupt(self):
        """What Ctrl-C does: every process of the group hears it."""
        os.killpg(self.driver.pid, signal.SIGINT)

    def end(self):
        """Wait for its end, and that of its workers: its exit status, and what it said of errors."""
        errors = self.driver.communicate(timeout=PATIENCE)[1]
        assert not psutil.wait_procs(self.workers, timeout=PATIENCE)[1]
        return self.driver.returncode, errors


@pytest.fixture
def begin(tmp_path):
    """Begin a campaign; it is killed with the test."""
    begun = []
    yield lambda: begun.append(Campaign(tmp_path)) or begun[-1]
    for run in begun:
        run.driver.kill()
        run.driver.communicate()


def hear_interrupts():
    """Undo what shells do to jobs in the background, which do not hear Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def same(table, undisturbed):
    pd.testing.assert_frame_equal(table.drop(columns="seconds"), undisturbed.drop(columns="seconds"), check_exact=True)


def test_kills_lose_no_finished_run(begin, tmp_path, undisturbed):
    """Of the driver, and each second time of one of its workers before, whom it replaces; each driver goes on where the last one was killed."""
    chance, known = random.Random(0), set()
    for number in range(4):
        run, first = begin(), chance.randint(5, 100)
        run.listen(lambda run, first=first: len(run.kept) >= first and len(run.workers) == 2)
        if number % 2:
            chance.choice(run.workers).kill()
            run.listen(lambda run: len(run.workers) == 3)
        run.driver.kill()
        assert run.end()[0] == -signal.SIGKILL
        known |= set(run.kept)
        kept = fo.read_store(tmp_path / "store")
        assert kept.key.is_unique and known <= set(kept.key)
    assert 4 < len(known) < len(undisturbed)
    same(campaign.study(store=tmp_path / "store"), undisturbed)
    assert len(fo.read_store(tmp_path / "store")) == len(undisturbed)


def test_killed_workers_lose_no_run(begin, tmp_path, undisturbed):
    run = begin()
    run.listen(lambda run: len(run.kept) >= 100 and len(run.workers) == 2)
    for worker in run.workers:
        worker.kill()
    run.listen(lambda run: len(run.workers) == 4)
    status, errors = run.end()
    assert status == 0 and "Traceback" not in errors
    same(pd.read_pickle(tmp_path / "table"), undisturbed)


@pytest.mark.parametrize(("workers", "runs"), [(1, 0), (2, 200)])
def test_ctrl_c_ends_with_a_usable_table(begin, tmp_path, undisturbed, workers, runs):
    """While workers still import, too."""
    run = begin()
    run.listen(lambda run: len(run.workers) >= workers and len(run.kept) >= runs)
    run.interrupt()
    status, errors = run.end()
    assert status == -signal.SIGINT and "KeyboardInterrupt\ndissipation_study: " in errors
    table = pd.read_pickle(tmp_path / "table")
    assert len(run.kept) <= len(table) == len(undisturbed) - table.attrs["missing"] < len(undisturbed)
    assert sorted(fo.read_store(tmp_path / "store").load_factor) == table.load_factor.tolist()
    keys = ["load_factor", "start"]
    same(table, undisturbed.set_index(keys).loc[pd.MultiIndex.from_frame(table[keys])].reset_index()[table.columns])


LOOP = """
import sys
import numpy as np
import frictopt as fo
rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
factors = np.linspace(0.3, 3.0, 100_000)
try:
    for loads in (factors, factors[:1]):
        print("study", flush=True)
        fo.dissipation_study(rod, cycle, 0.5, loads, store=sys.argv[1], progress=False)
except Exception:
    print("swallowed")
except KeyboardInterrupt as stop:
    print(len(stop.table), sorted(fo.read_store(sys.argv[1]).load_factor) == list(stop.table.load_factor))
    raise
"""


def test_ctrl_c_ends_the_loop_of_the_caller_with_the_table_in_the_exception_and_in_the_store(tmp_path):
    store = tmp_path / "runs.sqlite"
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    loop = subprocess.Popen([sys.executable, "-c", LOOP, str(store)], preexec_fn=hear_interrupts, **pipes)
    kept = 0
    while kept <= 20:
        assert loop.poll() is None, loop.communicate()
        with suppress(fo.StoreError):  # not yet made
            kept = len(fo.read_store(store))
    loop.send_signal(signal.SIGINT)
    said, errors = loop.communicate()
    rows, same = said.split()[1:]
    assert loop.returncode == -signal.SIGINT and int(rows) > 20 and same == "True" and said.count("study") == 1
    assert "KeyboardInterrupt\ndissipation_study: " in errors, errors


@pytest.mark.parametrize("pause", [0.0, 0.02])
def test_a_second_ctrl_c_ends_it_too(begin, pause):
    """Whatever the second one interrupts, the first one's orderly end among it, no process waits for another one for ever."""
    run = begin()
    run.listen(lambda run: len(run.kept) >= 20 and len(run.workers) == 2)
    run.interrupt()
    time.sleep(pause)
    with suppress(ProcessLookupError):  # it is quick
        run.interrupt()
    run.end()


@pytest.mark.parametrize("program", ["/bin/false", "/no/such/python"])
def test_workers_that_die_at_once_end_in_rows_that_say_so(tmp_path, monkeypatch, program):
    monkeypatch.setattr(sys, "executable", program)
    table = campaign.study(workers=2, store=tmp_path / "store")
    assert len(table) == 600 and (table.outcome == "FAILED").all() and table.error.str.contains("its worker died").all()
    assert not len(fo.read_store(tmp_path / "store"))
