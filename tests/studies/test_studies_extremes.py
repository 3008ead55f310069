"""The study of extremes at quick size: nothing wrong, and every refusal says what to do."""

import re
from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from studies.validation.extremes import study as extremes
from studies.validation.extremes.probes import Answer, Probe

ADVICE = r"hold the punch|hold the body|hold it, or|lower the friction|reduce the ratio|differ too much|choose a load factor further"


@pytest.fixture
def table(tables):
    return tables[extremes.EXTREMES.name]


def test_no_row_is_wrong_and_every_answer_has_a_small_residual(table):
    assert set(table["verdict"]) == {"right", "mesh", "unchecked", "refused"}
    answered = table[table["verdict"] != "refused"]
    assert (
        answered["residual"].between(0, 1e-9).all()
        and (answered["solver"] != "").all()
        and (answered["message"] == "").all()
    )
    right = table[table["verdict"] == "right"]
    assert right["error"].between(0, 1e-7).all() and (right["reference"] != "").all()
    assert len(right) > 0.75 * len(table)


def test_refusals_say_what_to_do(table):
    refused = table[table["verdict"] == "refused"]
    assert 5 < len(refused) < 20
    for message in refused["message"]:
        assert re.match(r"(ModelError|NoContinuation): ", message) and re.search(ADVICE, message), (
            message
        )


def probe(number, expected, tolerance=1e-7):
    return Probe(
        "e",
        "v",
        "q",
        lambda: Answer(number, 0.0, "s"),
        expected and (lambda: expected[0]),
        "r",
        tolerance,
    )


@pytest.mark.parametrize(
    ("found", "verdict"),
    [
        (probe(1.0, [1.0]), "right"),
        (probe(1.0, [1.0 + 1e-6]), "wrong"),
        (probe(np.nan, [np.nan]), "right"),
        (probe(np.inf, [np.inf]), "right"),
        (probe(np.inf, [1.0]), "wrong"),
        (probe(np.nan, [1.0]), "wrong"),
        (probe(1.0, [2.0], np.inf), "mesh"),
        (probe(1.0, None), "unchecked"),
        (probe(1.0, [None]), "unchecked"),
    ],
)
def test_verdicts(found, verdict):
    assert extremes.compared(found)["verdict"] == verdict


def test_errors_that_are_not_ours_are_not_swallowed():
    def fails():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        extremes.compared(replace(probe(1.0, [1.0]), ask=fails))

    def refuses():
        raise fo.SolverError("no answer; take another")

    row = extremes.compared(replace(probe(1.0, [1.0]), ask=refuses))
    assert row["verdict"] == "refused" and row["message"] == "SolverError: no answer; take another"
