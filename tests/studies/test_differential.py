"""Contacts of 3 to 130 nodes asked twice, in ways that must not matter; and the questions
themselves, which must see what is wrong."""

from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from helpers.cases import few
from helpers.liars import told
from studies.validation.fuzz.differential import DIFFERENTIAL, differences
from studies.validation.fuzz.scenes import random_scene


@pytest.mark.parametrize("first", few([0, 40, 120], 1))
def test_ways_that_must_not_matter(first):
    found = [
        finding for seed in range(first, first + 20) for finding in differences(random_scene(seed))
    ]
    assert [finding for finding in found if finding.result == "wrong"] == []
    assert sum(finding.compared for finding in found) > 0.7 * len(found)


@pytest.mark.parametrize("seed", [128, 161, 168, 171, 228, 232, 901005, 103374, 200331, 204869])
def test_cases_that_were_once_wrong(seed):
    """Of the package (units of load cases; contacts that become symmetric; 103374, 200331, 204869:
    an extrapolated state beside that to which the cycles go), and of the question (168, 232:
    increments do not say when in them a node opens).
    """
    assert [
        finding for finding in differences(random_scene(seed)) if finding.result == "wrong"
    ] == []


@pytest.mark.parametrize("seed", [22, 65])
def test_punches_that_were_once_wrong(seed):
    """Their loads stop being symmetric, and are so again."""
    assert [
        finding for finding in differences(random_scene(seed, "punch")) if finding.result == "wrong"
    ] == []


def changed(**changes):
    return lambda result, call: replace(
        result, **{name: change(getattr(result, name), call) for name, change in changes.items()}
    )


LIES = {
    "limit, nothing left out": (
        "shakedown_limit",
        changed(load_factor=lambda value, call: value * (1 + 1e-6 * call)),
    ),
    "mirrored": (
        "steady_state",
        changed(
            dissipation_per_node=lambda value, call: value + 1e-3 * (np.arange(len(value)) == 0)
        ),
    ),
    "renumbered": (
        "steady_state",
        changed(slip=lambda value, call: value + 1e-2 * (np.arange(len(value)) == 0)),
    ),
    "other units": ("steady_state", changed(first_cycle=lambda value, call: value + 1e-2)),
    "work along the path": ("march", changed(work=lambda value, call: 1.001 * value)),
    "steady state, marched": (
        "steady_state",
        changed(dissipation_per_node=lambda value, call: 1.001 * value),
    ),
    "path, in increments": ("march", changed(p=lambda value, call: value * (1 + 1e-3 * call))),
}


def test_every_question_is_lied_to():
    assert list(LIES) == list(DIFFERENTIAL)


@pytest.mark.parametrize("check", LIES)
def test_the_questions_see_a_wrong_answer(check):
    name, lie = LIES[check]
    calls, wrong = count(), 0
    with told(name, lambda answer: lie(answer, next(calls))):
        for seed in range(0, 240, 8):
            wrong += any(
                finding.check == check and finding.result == "wrong"
                for finding in differences(random_scene(seed, "any"))
            )
            if wrong == 3:
                return
    raise AssertionError(f"only {wrong} of 30 are called wrong")
