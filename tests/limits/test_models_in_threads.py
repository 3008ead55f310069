"""One model that several threads ask gives each of them the answer that it gives one alone, and its
copies are asked by themselves."""

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few

SYSTEM = fo.scenes.PunchOnHalfPlane(elements=16).condense()
CYCLE = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
MODELS = {
    "shakedown": (fo.ShakedownModel, {}, lambda model, f: model.solve(f)),
    "guaranteed": (fo.GuaranteedModel, {}, lambda model, f: model.solve(f)),
    "safe slip": (fo.SafeSlipModel, {}, lambda model, f: model.solve(f, 0.3)),
    "design": (
        fo.DesignModel,
        {"preloads": ["P"]},
        lambda model, f: model.solve(f, [model.preload <= 1.0]),
    ),
}
FRICTIONS = (0.4, 0.6, 0.8)


def told(answer):
    return [getattr(answer, "margin", answer.load_factor), *answer.slip]


@pytest.mark.parametrize("name", MODELS)
def test_threads_that_ask_one_model_each_get_the_answer_to_their_friction(name):
    kind, given, ask = MODELS[name]
    right = {f: told(ask(kind(SYSTEM, CYCLE, **given), f)) for f in FRICTIONS}
    model = kind(SYSTEM, CYCLE, **given)
    asked = FRICTIONS * few(8, 4)
    with ThreadPoolExecutor(4) as threads:
        answers = list(threads.map(lambda f: ask(model, f), asked))
    for f, answer in zip(asked, answers, strict=True):
        assert answer.friction == pytest.approx(f)
        assert told(answer) == pytest.approx(right[f], rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("name", MODELS)
def test_a_copy_of_a_model_is_asked_by_itself(name):
    kind, given, ask = MODELS[name]
    model = kind(SYSTEM, CYCLE, **given)
    for again in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model), copy.copy(model)):
        assert np.allclose(
            told(ask(again, 0.5)),
            told(ask(kind(SYSTEM, CYCLE, **given), 0.5)),
            rtol=1e-7,
            atol=1e-9,
        )
