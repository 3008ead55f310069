"""Results are pickled, copied and deep-copied: nothing is lost, no array can be written, and the copy can be solved and drawn."""

import copy
import pickle
from dataclasses import fields

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest

import frictopt as fo
from answers import ANSWERS, ASKED, PAIR
from frictopt.contact.result import Portable
from frictopt.fem.modes import Modes
from frictopt.fem.recovery import BodyFields
from systems import CYCLE, system

matplotlib.use("Agg")

NODE = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "N": ([0.0], [1.0])})
LIFTS = fo.LoadCycle({"P": 1.0}, [{"N": -1.0}, {"N": 1.0}])
GRID = [[x, y, 0.0] for x in (0.0, 1.0) for y in (0.0, 1.0)]
SHEARS = dict(zip("QR", np.eye(12), strict=False))
PAD = fo.ContactSystem(np.diag(np.arange(12.0) + 4.0), GRID, {"P": np.repeat([0.0, 0.0, 1.0], 4), **SHEARS})
TURNS = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"R": 1.0}, {"Q": -1.0}])
HEAVY = fo.Material(density=1.0)
PUNCH, BLOCKS = fo.scenes.PunchOnHalfPlane(elements=4, growth=1.6).model(), fo.scenes.SquarePunch(elements=2, growth=2.0).model()
FLAT = system(np.eye(2), np.zeros((2, 2)), 0.0, [1.0, 2.0], 1.0, 0.0)
EXAMPLES = [
    PAIR,
    PAD,
    PUNCH,
    BLOCKS,
    fo.read_calculix("tests/data/flat"),
    PUNCH.recover({"P": 1.0}, np.zeros(5), np.zeros(5)),
    fo.scenes.PunchOnHalfPlane(elements=4, growth=1.6, punch_material=HEAVY, block_material=HEAVY).model().modes(2),
    fo.starts.Start(family="own", name="one", slip=[0.5, 0.0]),
    *ANSWERS,
    fo.shakedown_limit(NODE, LIFTS, 0.5),
    fo.gross_slip(PUNCH.condense(), fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}]), 0.5),
    fo.march(PUNCH.condense(), fo.LoadCycle({"P": 1.0}, [{"Q": 0.1}, {"Q": -0.1}]), 0.5, 1.0, cycles=1).loop("Q"),
    fo.damping_curve(*ASKED, [0.5, 0.8], natural_frequency=1.0),
    fo.worn_in(FLAT, CYCLE, 0.5, 0.8),
    fo.shakedown_limit(PAD, TURNS, 0.5),
    fo.safe_slip(PAD, TURNS, 0.5, 0.3),
    fo.steady_state(PAD, TURNS, 0.5, 3.0),
    fo.march(PAD, TURNS, 0.5, 3.0, cycles=1, steps=2),
    fo.increments.NewtonIncrement(PAD, 0.5).solve(np.zeros((4, 2)), PAD.reaction({"P": 1.0, "Q": 2.0})),
]
WAYS = {"pickle": lambda one: pickle.loads(pickle.dumps(one)), "copy": copy.copy, "deepcopy": copy.deepcopy}


def arrays(thing, name):
    """All arrays among the public attributes of a result, by name."""
    if isinstance(thing, np.ndarray):
        yield name, thing
    elif isinstance(thing, tuple | list):
        for number, part in enumerate(thing):
            yield from arrays(part, f"{name}[{number}]")
    elif isinstance(thing, Portable):
        for attribute in [one.name for one in fields(thing)]:
            if not attribute.startswith("_"):
                yield from arrays(getattr(thing, attribute), f"{name}.{attribute}")


@pytest.mark.parametrize("result", EXAMPLES, ids=lambda one: type(one).__name__)
@pytest.mark.parametrize("way", WAYS)
def test_a_copy_says_the_same_stays_read_only_and_can_be_drawn(way, result):
    again = WAYS[way](result)
    assert type(again) is type(result) and repr(again) == repr(result) and type(result).__dataclass_params__.frozen
    problem, same = (getattr(one, "problem", None) for one in (result, again))
    assert (same is None) == (problem is None)
    if problem is not None:
        assert same is not problem and str(same) == str(problem) and (same.value, same.status) == (problem.value, problem.status)
    mine, others = dict(arrays(result, "")), dict(arrays(again, ""))
    assert list(mine) == list(others)
    for name, values in mine.items():
        assert np.array_equal(values, others[name], equal_nan=values.dtype.kind == "f"), name
        assert not values.flags.writeable and not others[name].flags.writeable, name
    if hasattr(result, "to_frame"):
        assert again.to_frame().equals(result.to_frame())
    if hasattr(result, "explain"):
        assert again.explain() == result.explain()
    if problem is not None:
        assert same.solve(solver="HIGHS" if same.is_mixed_integer() else "CLARABEL") == pytest.approx(problem.value, rel=1e-5, abs=1e-6)
    if hasattr(result, "plot"):
        again.plot()
        plt.close("all")


def test_every_public_kind_of_result_is_among_the_examples():
    public = {kind for kind in vars(fo).values() if isinstance(kind, type) and issubclass(kind, Portable)}
    kinds = [BodyFields, Modes, *(getattr(room, name) for room in (fo, fo.results) for name in room.__all__)]
    public |= {kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Portable)}
    assert {type(result) for result in EXAMPLES} == public | {fo.starts.Start, fo.increments.Increment}


def test_the_loads_of_a_copy_stay_read_only():
    for again in (way(LIFTS) for way in WAYS.values()):
        assert again == LIFTS
        with pytest.raises(TypeError, match="does not support item assignment"):
            again.mean["P"] = 2.0
        with pytest.raises(TypeError, match="does not support item assignment"):
            again.corners[0]["N"] = 2.0
