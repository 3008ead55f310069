"""Studies whose processes are killed, interrupted, or left behind by their parent."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from frictopt.study import runs
from helpers.foreign import Foreign
from helpers.lost import Fills, Kills, study

OTHERS = fo.starts.given_slips([[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]])
# A study of which one run never ends, in two processes of a process that the test ends.
PARENT = """
import signal
import sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # which a process in the background ignores
from frictopt.study.starts import no_slip
from helpers.lost import Holds, study
if __name__ == "__main__":
    holds = [
        Holds("holds", f"holds {k}", slip=[k + 1.0, 0.0, 0.0], file=f"{sys.argv[1]}/{k}")
        for k in range(2)
    ]
    try:
        study(no_slip() + holds, executor=2, store=sys.argv[1] + "/runs.sqlite")
    except KeyboardInterrupt as interrupt:
        print(interrupt.table.start.tolist(), flush=True)
"""
PATH = os.environ | {
    "PYTHONPATH": os.pathsep.join(
        [str(Path(fo.__file__).parents[1]), str(Path(__file__).parents[1])]
    )
}


def same(table, other):
    pd.testing.assert_frame_equal(
        table.drop(columns="seconds").reset_index(drop=True),
        other.drop(columns="seconds").reset_index(drop=True),
        check_exact=True,
    )


def test_a_study_whose_process_is_killed_has_all_results(tmp_path):
    killed = Kills("kills", "kills", file=str(tmp_path / "kills"))
    table = study([*OTHERS, killed], executor=2, store=tmp_path / "runs")
    assert (tmp_path / "kills").read_bytes() == b"x" and set(table.error) == {""}
    same(table[:3], study(OTHERS))
    assert set(fo.results.read_store(tmp_path / "runs").error) == {""}


def test_a_run_that_kills_twice_is_named_and_the_others_have_results(tmp_path):
    kills = Kills("kills", "kills", file=str(tmp_path / "kills"), times=999)
    table = study([kills, *OTHERS], executor=1, store=tmp_path / "runs")
    assert (tmp_path / "kills").read_bytes() == b"xx"
    same(table[1:], study(OTHERS))
    kept = fo.results.read_store(tmp_path / "runs").set_index("start")
    for row in (table.iloc[0], kept.loc["kills"]):
        assert row.outcome == "FAILED"
        assert "lost twice (BrokenProcessPool(" in row.error and "fewer processes" in row.error


@pytest.mark.parametrize("times", [1, 2])
def test_a_lost_task_is_halved_until_the_run_that_loses_it_is_alone(times, monkeypatch):
    """One of seven runs in one task loses its task, once or always."""
    monkeypatch.setattr(runs, "SETTINGS", runs.TaskSettings(most_tasks=1, seconds=1e9))
    starts = fo.starts.no_slip() + OTHERS + fo.starts.given_slips(np.eye(3), family="more")
    lost = []

    def lose(future, rows):
        names = [row["start"] for row in rows]
        if "given 1" in names and (times == 2 or not lost):
            lost.append(names)
            future.set_exception(OSError("killed"))
        else:
            future.set_result(rows)

    executor = Foreign(lose)
    table = study(starts, executor=executor)
    if times == 1:
        assert executor.sizes == [7, 3, 4] and set(table.error) == {""}
        return
    assert [len(names) for names in lost] == [7, 3, 2, 1, 1]
    failed = table[table.outcome == "FAILED"]
    assert failed.start.tolist() == ["given 1"] and failed.error.str.contains("killed").all()
    same(table.drop(failed.index), study([start for start in starts if start.name != "given 1"]))


@pytest.mark.parametrize("executor", [None, Foreign(Future.set_result)])
def test_a_run_that_fails_for_memory_fails_alone(executor):
    table = study([Fills("fills", "fills"), *OTHERS], executor=executor)
    assert table.error[0].startswith(("MemoryError: ", "_ArrayMemoryError: "))
    same(table[1:], study(OTHERS))


@pytest.mark.parametrize("executor", [0, -1, True, 10**7])
def test_a_number_of_processes_is_checked(executor):
    with pytest.raises(fo.ModelError, match="executor: "):
        study(OTHERS, executor=executor)


def test_processes_that_cannot_begin_are_named(tmp_path):
    """A script without a guard begins the study again in each of its processes."""
    script = tmp_path / "script.py"
    script.write_text(
        "from helpers.lost import study\n"
        "from frictopt.study.starts import no_slip\n"
        "study(no_slip(), executor=1)\n"
    )
    run = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, timeout=300, env=PATH
    )
    assert run.returncode and "ModelError: executor: 1, but its processes end" in run.stderr
    assert "below `if __name__ == '__main__':`" in run.stderr


@pytest.fixture
def parent(tmp_path):
    """A process with a study of which two of three runs never end, at work in two processes."""
    (tmp_path / "parent.py").write_text(PARENT)
    with subprocess.Popen(
        [sys.executable, tmp_path / "parent.py", tmp_path],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=PATH,
        start_new_session=True,
    ) as process:
        try:
            until(lambda: all((tmp_path / name).exists() for name in "01"))
            yield process
        finally:
            os.killpg(process.pid, signal.SIGKILL)


def until(condition, seconds=300):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def is_gone(pid):
    """Whether a process has ended; the first process of a container may leave it a zombie."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return True
    return state == "Z"


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_processes_end_with_their_parent(parent, tmp_path):
    until(lambda: len(fo.results.read_store(tmp_path / "runs.sqlite")))
    parent.kill()
    parent.wait()
    until(lambda: all(is_gone((tmp_path / name).read_text()) for name in "01"), seconds=60)
    assert fo.results.read_store(tmp_path / "runs.sqlite").start.tolist() == ["none"]


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_an_interrupt_ends_processes_at_work_and_no_traceback_is_shown(parent, tmp_path):
    os.killpg(parent.pid, signal.SIGINT)
    printed, errors = parent.communicate(timeout=300)
    assert (printed, errors, parent.returncode) == ("['none']\n", "", 0)
    until(lambda: all(is_gone((tmp_path / name).read_text()) for name in "01"), seconds=60)
