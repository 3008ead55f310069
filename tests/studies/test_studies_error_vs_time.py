"""The study of error against run time at quick size: its clock, its calls, its fronts recomputed,
its errors against theory."""

from types import SimpleNamespace

import numpy as np
import pytest

from studies import clock
from studies.clock import timed
from studies.validation.error_vs_time.methods import Method, Question, measured, not_dominated


@pytest.fixture
def table(tables):
    return tables["error_vs_time"]


def rows(table, computation, **equal):
    chosen = table[table["computation"] == computation]
    for name, value in equal.items():
        chosen = chosen[chosen[name] == value]
    assert len(chosen)
    return chosen


def test_median_of_the_repetitions_that_two_seconds_allow(monkeypatch):
    """On a clock that runs by hand; the first run does not count, and of an even number the faster
    one in the middle does."""
    now, passes = [0.0], iter([0.1, 0.4, 0.1, 0.3, 0.2, 0.9, 0.5, 0.9, 2.7])

    def run():
        tick = next(passes)
        now[0] += tick
        return tick

    monkeypatch.setattr(clock, "time", SimpleNamespace(process_time=lambda: now[0]))
    spent = timed(run, 4)
    assert (spent.answer, spent.repetitions) == (0.1, 4) and spent.seconds == pytest.approx(0.2)
    spent = timed(run, 7)
    assert spent.repetitions == 2 and spent.seconds == pytest.approx(0.5)
    spent = timed(run, 7)
    assert spent.repetitions == 1 and spent.seconds == pytest.approx(2.7)


def test_front_is_what_no_other_row_beats():
    rng = np.random.default_rng(3)
    for _ in range(20):
        seconds, error = (
            rng.integers(1, 9, size=12) / 8,
            rng.choice([1e-3, 1e-6, 1e-9, np.inf], size=12),
        )
        front = not_dominated(seconds, error)
        for i in range(12):
            better = (
                (seconds <= seconds[i])
                & (error <= error[i])
                & ((seconds < seconds[i]) | (error < error[i]))
            )
            equal = (seconds == seconds[i]) & (error == error[i])
            assert front[equal].sum() == (0 if better.any() or np.isinf(error[i]) else 1)


def test_absent_rivals_are_left_out_and_failures_are_rows(monkeypatch):
    def fail():
        raise ArithmeticError("no optimum")

    def method(name, run, rival=""):
        return Method(name, "none", "", run, lambda answer: answer, rival=rival)

    compared = [
        method("ours", lambda: 0.0),
        method("bad", fail),
        method("void", lambda: np.nan),
        method("other", lambda: 0.1, "no_such_package"),
    ]
    made = measured(Question("c", "q", "s", 1, compared), 1)
    assert [row["method"] for row in made] == ["ours", "bad", "void"]
    assert made[0]["on_front"] and made[0]["error"] == np.finfo(float).eps
    assert [row["result"] for row in made[1:]] == [
        "ArithmeticError: no optimum",
        "ArithmeticError: the answer is not finite",
    ]
    assert all(np.isinf(row["error"]) and not row["on_front"] for row in made[1:])


def test_ours_all_answer_with_a_small_residual(table):
    ours = table[table["rival"] == ""]
    assert (ours["result"] == "answer").all()
    checked = ~ours["computation"].isin(["condensation", "onset"])
    assert ours.loc[checked, "residual"].dropna().lt(1e-9).mean() > 0.9


def test_answers_of_frictopt_are_as_accurate_as_it_says(table):
    proven = table[
        (table["rival"] == "")
        & table["computation"].isin(["lambda_2", "lambda_1", "safe slip", "increment"])
    ]
    assert proven["error"].max() < 1e-9
    assert rows(table, "onset")["error"].max() < 1e-14
    assert rows(table, "condensation", quantity="stiffness S")["error"].max() < 1e-12
    assert rows(table, "transient", method="frictopt, exact path")["error"].max() < 1e-12
    assert rows(table, "steady state", method="frictopt, proven")["error"].max() < 1e-10
    for name, error in {
        "lambda_1": 1e-8,
        "safe slip": 1e-8,
        "required friction": 2e-5,
        "least slip": 1e-7,
    }.items():
        assert rows(table, f"{name}, 3-D")["error"].max() < error
    region = rows(table, "safe region, 3-D")
    assert (region["error"] <= region["setting"].astype(float)).all() and region[
        "error"
    ].is_monotonic_decreasing
    assert rows(table, "limit after protocol, 3-D")["error"].max() < 1e-3
    ends = rows(table, "range of dissipation, 3-D")
    assert ends["error"].is_monotonic_decreasing and ends["error"].iloc[-1] < 2e-3
