"""Progress where standard error is a terminal, and where it is none; and what an interrupt keeps,
of every call that may take long."""

import inspect
import io
import os
import re
import subprocess
import sys
import time
from contextlib import redirect_stderr
from dataclasses import dataclass
from functools import cache

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.base import progress, progress_bar
from helpers.designs import CYCLE as TURNS
from helpers.designs import pulled
from helpers.interrupts import interrupted
from helpers.screens import Terminal, seen, soon, until
from helpers.systems import CYCLE, FIRST_PAIR, system, unit_nodes
from helpers.worn import cylinder
from studies.progress import each
from studies.tables import Table


@dataclass(frozen=True)
class Nothing:
    """No parameters."""


@pytest.fixture
def log():
    """A file for standard error; lines come soon."""
    with soon():
        yield io.StringIO()


def test_a_table_says_what_is_computed_and_how_far_it_is(log):
    def compute(_parameters):
        for number in each(range(3), "things"):
            until(
                log,
                rf"table small: {number} part{'s' * (number != 1)}, \d\d:\d\d; things: {number} of 3, \d\d:\d\d\n",
            )
            yield {"residual": 0.0}

    table = Table(
        "small", "a thing", {"residual": "0"}, full=Nothing(), quick=Nothing(), compute=compute
    )
    with redirect_stderr(log):
        assert len(table.frame(Nothing())) == 3


def test_lines_come_while_nothing_moves_and_end_with_the_computation(log):
    with redirect_stderr(log), progress_bar(True, "waiting", "step"):
        until(log, r"(waiting: 0 steps, \d\d:\d\d\n){3}")
    teller = progress._drawing
    assert teller is None or not teller.join(60)
    assert progress._drawing is None


def test_who_wants_no_progress_gets_none(log):
    with redirect_stderr(log), progress_bar(False, "waiting", "step") as bar:
        bar.update()
        assert bar not in progress._under_way
        with progress_bar(True, "within", "step") as bar:
            assert bar not in progress._under_way
    code = """
import time
from frictopt.base import progress_bar, progress
progress.PACE = progress.Pace(first=0.01)
with progress_bar(True, "waiting", "step"):
    time.sleep(0.1)
"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "TQDM_DISABLE": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert not log.getvalue() + done.stdout + done.stderr


def test_a_log_that_nobody_reads_ends_nothing(log):
    with redirect_stderr(log), progress_bar(True, "waiting", "step"):
        until(log, "waiting")
        log.close()
        time.sleep(0.05)


@pytest.mark.usefixtures("log")
def test_on_a_terminal_a_step_that_takes_long_is_shown_while_it_lasts_and_the_best_so_far():
    screen = Terminal()
    with redirect_stderr(screen), progress_bar(True, "search", "program") as bar:
        until(screen, "\rsearch: 0 programs, 00:00")
        bar.keep("limit", 0.2, "the best limit", best="at least 0.2 so far")
        until(screen, "00:00, at least 0.2 so far")
        bar.update()
        with progress_bar(True, "nodes", "node", total=4) as inner:
            inner.update(2)
            until(screen, r"nodes:  50%\|.* 2/4 ")
    assert (
        "search: 1 program, 00:00, at least 0.2 so far" in screen.getvalue().rpartition("nodes")[2]
    )


def test_an_interrupt_gets_what_was_kept_last():
    """A function makes the value only when it is needed."""
    made = []
    with pytest.raises(KeyboardInterrupt) as stopped:
        with progress_bar(False, "search", "program") as bar:
            bar.keep("table", lambda: made.append(1), "the first")
            bar.keep("table", lambda: [2, 3], "two numbers are in the attribute `table`")
            raise KeyboardInterrupt
    assert stopped.value.table == [2, 3] and not made
    assert stopped.value.__notes__ == ["search: two numbers are in the attribute `table`"]


def test_quick_answers_pay_nothing_for_progress():
    """No bar, no line, no tqdm."""
    code = """
import sys
import frictopt as fo
rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
fo.shakedown_limit(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), friction=0.5)
print("tqdm" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("False\n", "")


PAIR, WORN = system(*FIRST_PAIR), cylinder(32)
PULLED = system(
    np.eye(2), np.zeros((2, 2)), 0.0, [-1.0, 3.0], [0.0, 1.0], 0.0, C=[[2.0, 1.0], [1.0, 2.0]]
)
ROLLED = unit_nodes({"P": ([0.0], [2.0]), "Q": ([1.0], [0.0]), "R": ([0.0], [-1.0])})


def designed(**options):
    """A first design leaves a node bare, so that there is a second program."""
    contact, friction = pulled(10, 1)
    model = fo.DesignModel(contact, TURNS, preloads=["c"], profile=True)
    return model.solve(
        friction, [cp.abs(model.preload) <= 0.6, cp.abs(model.profile) <= 0.1], **options
    )


def swept(**options):
    return fo.ShakedownModel(PAIR, CYCLE).sweep([0.3, 0.5, 0.7], **options)


@cache
def guaranteed():
    return fo.guaranteed_limit(PAIR, CYCLE, 0.6, progress=False)


def worn(**options):
    return fo.joints.wear(*WORN, coefficient=1e-3, **options)


# the call; the bar that stops it, after so many of what it counts; what is kept, with what has to
# hold for it; and what a bar says in the end
CALLS = {
    "shakedown": lambda **o: fo.shakedown_limit(PULLED, CYCLE, 0.5, **o),
    "sweep": swept,
    "required friction": lambda **o: fo.required_friction(PAIR, CYCLE, 0.3, **o),
    "safe region": lambda **o: fo.safe_region(ROLLED, {"P": 1.0}, ["Q", "R"], 0.5, **o),
    "guaranteed": lambda **o: fo.guaranteed_limit(PAIR, CYCLE, 0.6, **o),
    "after an overload": lambda **o: fo.after_overload(guaranteed(), **o),
    "design": designed,
    "protocol": lambda **o: fo.limit_after_protocol(guaranteed().shakedown, scan=5, **o),
    "range": lambda **o: fo.dissipation_range(PAIR, CYCLE, 0.6, 0.5, **o),
    "wear": worn,
    "worn in": lambda **o: fo.joints.worn_in(*WORN, **o),
    "steady state": lambda **o: fo.steady_state(PAIR, CYCLE, 0.6, 0.9, **o),
}
# The bar, the number of steps after which the call is interrupted, and what a terminal shows.
SHOWN = {
    "shakedown": (
        "open nodes",
        1,
        r"open nodes: 6 programs, 00:\d\d, at least 1.75, at most 1.75 so far",
    ),
    "sweep": ("sweep", 2, "sweep: 100%"),
    "required friction": (
        "required friction",
        3,
        r"required friction: \d+ programs, 00:\d\d, between 0\.\d+ and 0\.\d+ so far",
    ),
    "safe region": ("safe region", 2, r"safe region: [2-9] rays, 00:\d\d"),
    "guaranteed": ("critical nodes", 1, "critical nodes: 100%"),
    "after an overload": ("critical nodes", 1, r"after an overload: 00:\d\d"),
    "design": ("design", 2, r"design: \d+ programs, 00:\d\d, load factor 0.5521 so far"),
    "protocol": (
        "limit after a protocol",
        3,
        r"limit after a protocol: \d+ transients, 00:\d\d, rest at load factor \d",
    ),
    "range": (
        "dissipation range",
        9,
        r"dissipation range: \d+ transients, 00:\d\d, work from 0 to 0\.04",
    ),
    "wear": ("wear", 3, r"wear: \d+ jumps, 00:\d\d, \S+ cycles, \S+ deep so far"),
    "worn in": ("steady state", 2, r"worn in: 00:\d\d"),
    "steady state": ("steady state", 2, r"steady state: \d+ cycles, 00:\d\d"),
}
# The attribute of the interrupt, and what holds of it.
KEPT = {
    "shakedown": ("limit", lambda limit: limit.kind.name == "NO_SAFE_SLIP"),
    "sweep": ("table", lambda table: table["friction"].tolist() == [0.3, 0.5]),
    "required friction": ("table", lambda table: len(table) == 2 and table["safe"].all()),
    "safe region": ("table", lambda table: table.to_numpy().round(9).tolist() == [[1.0, 0.0]]),
    "guaranteed": (
        "table",
        lambda table: (
            len(table) == 1
            and table["load_factor"].min() >= fo.guaranteed_limit(PAIR, CYCLE, 0.6).load_factor
        ),
    ),
    "after an overload": ("table", lambda table: len(table) == 1),
    "design": ("design", lambda design: round(design.load_factor, 4) == 0.1712),
    "protocol": (
        "table",
        lambda table: len(table) == 2 and set(table) == {"load_factor", "outcome"},
    ),
    "range": ("range", lambda span: span.least <= span.most and span.transients <= 9),
    "wear": ("history", lambda history: len(history.depth) == 4),
    "worn in": ("depth", lambda h: (h == fo.joints.worn_in(*WORN).depth).all()),
    "steady state": ("work", lambda work: len(work) >= 1),
}


@pytest.mark.parametrize("call", CALLS)
def test_an_interrupted_call_keeps_what_it_has_and_a_terminal_shows_it(call):
    ask, (what, most, said), (name, holds) = CALLS[call], SHOWN[call], KEPT[call]
    with interrupted(what, most) as stopped:
        ask(progress=False)
    assert holds(getattr(stopped.value, name)) and len(stopped.value.__notes__) == 1
    assert f"attribute `{name}`" in stopped.value.__notes__[0]
    assert re.search(said, shown := seen(lambda: ask(progress=True))), shown
    assert not seen(lambda: ask(progress=False))
    with pytest.raises(fo.ModelError, match="progress: 'yes'"):
        ask(progress="yes")


def test_every_question_about_a_contact_or_a_limit_has_a_switch_for_its_progress():
    lacking = []
    for name in fo.__all__:
        if inspect.isfunction(getattr(fo, name)):
            parameters = list(inspect.signature(getattr(fo, name)).parameters)
            if parameters[0] in ("system", "limit") and "progress" not in parameters:
                lacking.append(name)
    assert not lacking


@pytest.mark.parametrize("progress", [True, False])
def test_condensation_and_recovery_show_how_far_they_are(progress):
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    for what, ask in (
        ("condensation", lambda: model.condense(progress=progress)),
        ("recovery", lambda: model.recover({"P": 1.0}, slip=[0.0] * 5, progress=progress)),
    ):
        steps = rf"{what}: 00:.*elimination: 100%.*{what}: 00:"
        shown = seen(ask)
        assert re.search(steps, shown, re.DOTALL) if progress else not shown


def test_a_unit_is_counted_by_the_whole():
    """One of six is "1 of 6 parts"; without a known whole one is "1 part"."""
    for total, done, text in ((6, 1, "1 of 6 parts"), (1, 1, "1 of 1 part"), (None, 1, "1 part")):
        with progress_bar(False, "report", "part", total=total, done=done) as bar:
            assert bar._format.replace("{n_fmt}", "1").replace("{total_fmt}", str(total)) == (
                f"{{desc}}: {text}, {{elapsed}}{{postfix}}"
            )


def test_a_function_tells_the_best_so_far_when_the_bar_is_drawn(log):
    told = iter(["the first", *["the second"] * 1000])
    with redirect_stderr(log), progress_bar(True, "search", "program") as bar:
        bar.keep("work", 0, "a note", best=lambda: next(told))
        until(log, r"00:0\d, the first\n.*00:0\d, the second")


def test_a_count_that_is_a_number_of_numpy_is_told(log):
    with redirect_stderr(log), progress_bar(True, "work", "piece") as bar:
        bar.update(np.int64(2))
        until(log, r"work: 2 pieces, ")
