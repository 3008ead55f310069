"""One model gives several threads the answers that it gives to one thread.

Copies of a model are independent of it.
"""

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor
from itertools import groupby
from threading import get_ident
from time import sleep

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few

SYSTEM = fo.scenes.PunchOnHalfPlane(elements=16).condense()
CYCLE = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
MODELS = {
    "shakedown": (fo.ShakedownModel, {}, lambda model, f: model.solve(f)),
    "guaranteed": (fo.GuaranteedModel, {}, lambda model, f: model.solve(f)),
    "design": (
        fo.DesignModel,
        {"preloads": ["P"]},
        lambda model, f: model.solve(f, [model.preload <= 1.0]),
    ),
}
FRICTIONS = (0.4, 0.6, 0.8)


def numbers(answer):
    return [getattr(answer, "margin", answer.load_factor), *answer.slip]


@pytest.mark.parametrize("name", MODELS)
def test_threads_that_ask_one_model_each_get_the_answer_to_their_friction(name):
    kind, options, ask = MODELS[name]
    right = {f: numbers(ask(kind(SYSTEM, CYCLE, **options), f)) for f in FRICTIONS}
    model = kind(SYSTEM, CYCLE, **options)
    frictions = FRICTIONS * few(8, 4)
    with ThreadPoolExecutor(4) as threads:
        answers = list(threads.map(lambda f: ask(model, f), frictions))
    for f, answer in zip(frictions, answers, strict=True):
        assert answer.friction == pytest.approx(f)
        assert numbers(answer) == pytest.approx(right[f], rel=1e-7, abs=1e-9)


class Watched(cp.Parameter):
    """A parameter that notes which thread reads it, and lets the others work meanwhile."""

    @property
    def value(self):
        self.readers.append(get_ident())
        sleep(0.002)
        return cp.Parameter.value.fget(self)

    @value.setter
    def value(self, given):
        cp.Parameter.value.fset(self, given)


@pytest.mark.parametrize("name", ["shakedown", "guaranteed"])
def test_a_thread_reads_the_rows_of_the_user_only_after_another_has_its_answer(name):
    """Both answers are put into the same rows, so that their multipliers would be mixed up."""
    kind, options, _ = MODELS[name]
    model = kind(SYSTEM, CYCLE, **options)
    most = Watched(nonneg=True)
    most.readers = []
    most.value = 1.0
    row = cp.abs(model.slip) <= most
    with ThreadPoolExecutor(2) as threads:
        list(threads.map(lambda f: model.solve(f, constraints=[row]), (0.5, 0.6)))
    turns = [thread for thread, _ in groupby(most.readers)]
    assert len(turns) == len(set(turns)) <= 2 < len(most.readers)


@pytest.mark.parametrize("name", MODELS)
def test_a_copy_of_a_model_is_asked_by_itself(name):
    kind, options, ask = MODELS[name]
    model = kind(SYSTEM, CYCLE, **options)
    for again in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model), copy.copy(model)):
        assert np.allclose(
            numbers(ask(again, 0.5)),
            numbers(ask(kind(SYSTEM, CYCLE, **options), 0.5)),
            rtol=1e-7,
            atol=1e-9,
        )
