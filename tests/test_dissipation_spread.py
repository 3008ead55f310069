"""Where the runs of a campaign go: executors and processes that do not do what they should."""

import os
import pickle
import subprocess
import sys
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from frictopt.campaign import execute, no_slip
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
table = fo.dissipation_study(random_system(np.random.default_rng(3), 3), CYCLE, 0.4, np.linspace(0.1, 2.0, 20), workers=2)
print((table.outcome != "FAILED").sum(), "rows")
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
    table = study(executor=Foreign(Future.set_result, most=1), store=tmp_path / "runs")
    lost = table.outcome == "FAILED"
    assert lost.sum() == 4 and table.error[lost].str.contains("link down").all()
    pd.testing.assert_frame_equal(table[~lost].drop(columns="seconds"), undisturbed[~lost], check_exact=True)
    assert len(fo.read_store(tmp_path / "runs")) == 16


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
    table = study(executor=Foreign(answer), store=tmp_path / "runs")
    assert len(table) == len(FACTORS) and (table.outcome == "FAILED").all() and not table.attrs["missing"]
    assert not len(fo.read_store(tmp_path / "runs"))


def test_a_script_without_a_guard_runs_once_and_its_workers_are_silent(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(UNGUARDED)
    paths = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
    done = subprocess.run([sys.executable, script], env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stdout, done.stderr) == (0, "script\n20 rows\n", "")


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_that_is_no_result_is_raised_wherever_the_run_is_followed(workers):
    runs = [execute.Run(str(number), no_slip()[0], 1.0) for number in range(2)]
    contact = execute.CampaignContact("no contact", CYCLE, np.full(3, 0.4), np.nan, np.zeros(3))
    with pytest.raises(AttributeError, match="slip_shape"):
        list(execute.execute(contact, runs, None, workers))


def test_a_contact_that_cannot_travel_is_an_error():
    class Own(fo.ContactSystem):
        """Known here alone."""

    own = Own.from_blocks(CONTACT.A, CONTACT.B, CONTACT.C, CONTACT.x, CONTACT.bonded)
    with pytest.raises((AttributeError, pickle.PicklingError), match="Own"):
        fo.dissipation_study(own, CYCLE, 0.4, FACTORS, workers=2)
