"""Progress where standard error is no terminal: lines that come also while nothing moves, and end with the computation."""

import io
import os
import re
import subprocess
import sys
import time
from contextlib import redirect_stderr
from dataclasses import dataclass

import pytest

from frictopt.contact import bar_of, progress
from studies.progress import each
from studies.tables import Table


@dataclass(frozen=True)
class Nothing:
    """No parameters."""


@pytest.fixture
def log(monkeypatch):
    """A file for standard error; lines come soon."""
    monkeypatch.setattr(progress, "_FIRST", 0.01)
    monkeypatch.setattr(progress, "_EVERY", 0.01)
    return io.StringIO()


def until(log, line):
    end = time.monotonic() + 60
    while not re.search(line, log.getvalue()):
        assert time.monotonic() < end, f"no {line!r} in {log.getvalue()[-300:]!r}"
        time.sleep(0.01)


def test_a_table_says_what_is_computed_and_how_far_it_is(log):
    def compute(_parameters):
        for number in each(range(3), "things"):
            until(log, rf"table small: {number} so far, \d\d:\d\d; things: {number} of 3, \d\d:\d\d\n")
            yield {"residual": 0.0}

    table = Table("small", "a thing", {"residual": "0"}, full=Nothing(), quick=Nothing(), compute=compute)
    with redirect_stderr(log):
        assert len(table.frame(Nothing())) == 3


def test_lines_come_while_nothing_moves_and_end_with_the_computation(log):
    with redirect_stderr(log), bar_of(True, "waiting", "step"):
        until(log, r"(waiting: 0 so far, \d\d:\d\d\n){3}")
    teller = progress._teller
    assert teller is None or not teller.join(60)
    assert progress._teller is None


def test_who_wants_no_progress_gets_none(log):
    with redirect_stderr(log), bar_of(False, "waiting", "step") as bar:
        bar.update()
        assert bar not in progress._unseen
    code = "from frictopt.contact import bar_of, progress; bar = bar_of(True, 'waiting', 'step'); print(progress._teller)"
    done = subprocess.run([sys.executable, "-c", code], env={**os.environ, "TQDM_DISABLE": "1"}, capture_output=True, text=True, check=True)
    assert done.stdout == "None\n" and not log.getvalue() + done.stderr


def test_a_log_that_nobody_reads_ends_nothing(log):
    with redirect_stderr(log), bar_of(True, "waiting", "step"):
        until(log, "waiting")
        log.close()
        time.sleep(0.05)
