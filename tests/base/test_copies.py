"""Results are pickled, copied, deep-copied and saved: nothing is lost, no array can be written, and
the copy can be solved and drawn."""

import copy
import json
import pickle
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from datetime import UTC, date, datetime
from functools import cache, partial

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from scipy.sparse.linalg import aslinearoperator

import frictopt as fo
from frictopt.base import Kept
from frictopt.base.results import Shown
from frictopt.fem import modes, recovery
from helpers.answers import ASKED, PAIR, QUESTIONS, answer
from helpers.systems import CYCLE, of_mode, stresses_of, system, unit_nodes

matplotlib.use("Agg")

NODE = unit_nodes({"P": ([0.0], [1.0]), "N": ([0.0], [1.0])})
LIFTS = fo.LoadCycle({"P": 1.0}, [{"N": -1.0}, {"N": 1.0}])
GRID = [[x, y, 0.0] for x in (0.0, 1.0) for y in (0.0, 1.0)]
SHEARS = dict(zip("QR", np.eye(12), strict=False))
PAD = fo.ContactSystem(
    np.diag(np.arange(12.0) + 4.0), GRID, {"P": np.repeat([0.0, 0.0, 1.0], 4), **SHEARS}
)
TURNS = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"R": 1.0}, {"Q": -1.0}])
HEAVY = fo.fem.Material(density=1.0)
PUNCH = fo.scenes.PunchOnHalfPlane(elements=4, growth=1.6)
SHEARED = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}])
SWAYED = fo.LoadCycle({"P": 1.0}, [{"Q": 0.1}, {"Q": -0.1}])
FLAT = system(np.eye(2), np.zeros((2, 2)), 0.0, [1.0, 2.0], 1.0, 0.0)
DATED = replace(
    LIFTS,
    times=[
        date(2020, 2, 29),
        datetime(2021, 1, 1, 12, 30, tzinfo=UTC),
        pd.Timestamp("2022-01-01 00:00:00.000000001"),
    ],
)


def backbone():
    """The curve of three amplitudes of the pair."""
    pair = of_mode(PAIR, ASKED[1], 1.0)
    return fo.joints.backbone_curve(pair, *ASKED[1:], [0.1, 0.2, 0.3], natural_frequency=1.0)


MADE = {  # name, which begins with the kind -> how it is made
    "ContactSystem": lambda: PAIR,
    "ContactSystem in space": lambda: PAD,
    "ContactModel": PUNCH.model,
    "ContactModel in space": fo.scenes.SquarePunch(elements=2, growth=2.0).model,
    "MatrixJob": lambda: fo.readers.read_calculix("tests/data/flat"),
    "BodyFields": lambda: PUNCH.model().recover({"P": 1.0}, np.zeros(5), np.zeros(5)),
    "StressMap": lambda: stresses_of(PAIR),
    "Modes": lambda: replace(PUNCH, punch_material=HEAVY, block_material=HEAVY).model().modes(2),
    "ContactProducts": lambda: fo.ContactProducts(
        PAIR.points,
        PAIR.bonded,
        pressing=aslinearoperator(PAIR.B @ np.linalg.inv(PAIR.A)),
        slipping=aslinearoperator(np.linalg.inv(PAIR.A)),
    ),
    "Start": lambda: fo.starts.Start(family="own", name="one", slip=[0.5, 0.0]),
    **{kind: partial(answer, kind) for kind in QUESTIONS},
    "ShakedownLimit with an open node": lambda: fo.shakedown_limit(NODE, LIFTS, 0.5),
    "GrossSlip": lambda: fo.gross_slip(PUNCH.condense(), SHEARED, 0.5),
    "LoadLoop": lambda: fo.march(PUNCH.condense(), SWAYED, 0.5, 1.0, cycles=1).loop("Q"),
    "BackboneCurve": backbone,
    "ForcedResponse": lambda: backbone().response([0.1], damping=0.01),
    "Report": lambda: fo.report(*ASKED, [0.5]),
    "WornIn": lambda: fo.joints.worn_in(FLAT, CYCLE, 0.5, 0.8),
    "ShakedownLimit in space": lambda: fo.shakedown_limit(PAD, TURNS, 0.5),
    "SafeSlip in space": lambda: fo.safe_slip(PAD, TURNS, 0.5, 0.3),
    "SteadyState in space": lambda: fo.steady_state(PAD, TURNS, 0.5, 3.0),
    "Trajectory in space": lambda: fo.march(PAD, TURNS, 0.5, 3.0, cycles=1, steps=2),
    "Increment in space": lambda: fo.increments.NewtonIncrement(PAD, 0.5).solve(
        np.zeros((4, 2)), PAD.reaction({"P": 1.0, "Q": 2.0})
    ),
}
OTHERS_TO_SAVE = {
    "ShakedownLimit with events": lambda: fo.shakedown_limit(NODE, LIFTS, 0.5, events=True),
    "GrossSlip with units": lambda: fo.gross_slip(
        replace(PUNCH.condense(), units="N, mm"), SHEARED, 0.5
    ),
    "ShakedownLimit with dates": lambda: fo.shakedown_limit(NODE, DATED, 0.5),
    "Onset with dates": lambda: fo.onset(NODE, DATED, 0.5),
}


@cache
def example(name):
    """The result of this name, made when a test first asks for it."""
    return (MADE | OTHERS_TO_SAVE)[name]()


def kind_of(name):
    """The class that the name of an example begins with."""
    kind = name.partition(" ")[0]
    rooms = fo, fo.fem, fo.readers, fo.results, fo.starts, fo.increments, recovery, modes
    return next(getattr(room, kind) for room in rooms if hasattr(room, kind))


WAYS = {
    "pickle": lambda one: pickle.loads(pickle.dumps(one)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


def arrays(thing, name):
    """All arrays among the public attributes of a result, by name."""
    if isinstance(thing, np.ndarray):
        yield name, thing
    elif isinstance(thing, tuple | list):
        for number, part in enumerate(thing):
            yield from arrays(part, f"{name}[{number}]")
    elif isinstance(thing, Shown):
        for attribute in [one.name for one in fields(thing) if one.name in vars(thing)]:
            if not attribute.startswith("_"):
                yield from arrays(getattr(thing, attribute), f"{name}.{attribute}")


@pytest.mark.parametrize("name", MADE)
@pytest.mark.parametrize("way", WAYS)
def test_a_copy_says_the_same_stays_read_only_and_can_be_drawn(way, name):
    result = example(name)
    again = WAYS[way](result)
    assert (
        type(again) is type(result) is kind_of(name)
        and repr(again) == repr(result)
        and type(result).__dataclass_params__.frozen
    )
    problem, same = (getattr(one, "problem", None) for one in (result, again))
    assert (same is None) == (problem is None)
    if problem is not None:
        assert (
            same is not problem
            and str(same) == str(problem)
            and (same.value, same.status) == (problem.value, problem.status)
        )
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
        assert same.solve(
            solver="HIGHS" if same.is_mixed_integer() else "CLARABEL"
        ) == pytest.approx(problem.value, rel=1e-5, abs=1e-6)
    if hasattr(result, "plot"):
        again.plot()
        plt.close("all")


def test_every_public_kind_of_result_is_among_the_examples():
    public = {
        kind for kind in vars(fo).values() if isinstance(kind, type) and issubclass(kind, Shown)
    }
    kinds = [
        recovery.BodyFields,
        modes.Modes,
        *(
            getattr(room, name)
            for room in (fo, fo.fem, fo.readers, fo.results)
            for name in room.__all__
        ),
    ]
    public |= {kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Shown)}
    made = {kind_of(name) for name in MADE}
    assert made == public | {fo.starts.Start, fo.increments.Increment}


def same(one, other):
    """That two values are equal in type and in all that is in them, but for problems; the arrays of
    the other cannot be written."""
    if is_dataclass(one):
        names = [part.name for part in fields(one) if part.name != "problem"]
        return type(one) is type(other) and all(
            same(getattr(one, name), getattr(other, name)) for name in names
        )
    if isinstance(one, np.ndarray):
        return (
            one.dtype == other.dtype
            and one.shape == other.shape
            and one.tobytes() == other.tobytes()
            and not other.flags.writeable
        )
    if isinstance(one, pd.DataFrame | pd.Series):
        of_table = not isinstance(one, pd.DataFrame) or (
            one.attrs == other.attrs and (one.dtypes == other.dtypes).all()
        )
        return (
            of_table
            and one.equals(other)
            and one.index.equals(other.index)
            and type(one.index) is type(other.index)
        )
    if isinstance(one, Mapping):
        return type(one) is type(other) and same(list(one.items()), list(other.items()))
    if isinstance(one, tuple | list):
        return type(one) is type(other) and len(one) == len(other) and all(map(same, one, other))
    return type(one) is type(other) and (one == other or one != one)


SAVED = [*(name for name in MADE if issubclass(kind_of(name), Kept)), *OTHERS_TO_SAVE]


@pytest.mark.parametrize("name", SAVED)
def test_a_saved_result_comes_back_equal_in_all_numbers_and_words(name, tmp_path):
    result = example(name)
    result.save(tmp_path / "one.npz")
    again = fo.results.load(tmp_path / "one.npz")
    assert same(result, again) and str(again) == str(result)
    if getattr(again, "problem", None) is not None:
        assert str(again.problem) == str(result.problem)
        assert again.problem.value == pytest.approx(result.problem.value, rel=1e-12)
    if hasattr(result, "to_frame"):
        assert again.to_frame().equals(result.to_frame())


def test_results_of_every_kind_can_be_saved():
    kinds = {
        kind
        for name in fo.results.__all__
        if isinstance(kind := getattr(fo.results, name), type) and issubclass(kind, Shown)
    }
    assert all(issubclass(kind, Kept) for kind in kinds)
    assert kinds <= {kind_of(name) for name in SAVED}


def test_a_contact_that_stands_in_many_places_is_written_once(tmp_path):
    found = answer("DissipationRange")
    found.save(tmp_path / "range.npz")
    again = fo.results.load(tmp_path / "range.npz")
    assert again.least_state.system is again.most_state.system is not found.least_state.system
    with np.load(tmp_path / "range.npz") as archive:
        assert (
            sum(np.array_equal(array, found.least_state.system.S) for array in archive.values())
            == 1
        )


def told(path, text, things, **arrays):
    """An archive in the form of a result, with this text of JSON."""
    np.savez(
        path,
        format="frictopt result 1",
        version=fo.__version__,
        text=np.frombuffer(json.dumps([text, things]).encode(), np.uint8),
        **arrays,
    )
    return path


def test_foreign_and_damaged_files_are_no_results(tmp_path):
    path, limit = tmp_path / "a.npz", answer("ShakedownLimit")
    limit.save(path)
    whole, rng, refused = path.read_bytes(), np.random.default_rng(3), 0
    for _ in range(100):
        damaged = bytearray(whole)
        for spot in rng.integers(len(whole), size=3):
            damaged[spot] ^= 1 << rng.integers(8)
        path.write_bytes(damaged)
        try:
            assert same(limit, fo.results.load(path))
        except fo.ModelError as error:
            assert str(path) in str(error)
            refused += 1
    assert refused > 60
    PAIR.save(tmp_path / "system.npz")
    np.savez(tmp_path / "foreign.npz", a=np.eye(2))
    np.savez(tmp_path / "objects.npz", format=np.array(["frictopt result 1", 1], dtype=object))
    (tmp_path / "text.npz").write_text("not an archive")
    for name in ("system", "foreign", "objects", "text", "none"):
        with pytest.raises(
            fo.ModelError,
            match=f"path: .*{name}.npz' is not a result .*; give a file that `save` of a result wrote",
        ):
            fo.results.load(tmp_path / f"{name}.npz")
    with pytest.raises(fo.ModelError, match="is not a contact system"):
        fo.ContactSystem.load(path)


def test_a_file_makes_no_other_classes(tmp_path):
    for things in (
        [{"Popen": [["args", "true"]]}],
        [{"ContactModel": []}],
        [{"Attempt": [["solver", "HIGHS"]]}],
        [{"Kept": []}],
    ):
        with pytest.raises(fo.ModelError, match="is not a result"):
            fo.results.load(told(tmp_path / "a.npz", {"thing": 0}, things))
    for content in ([["solver", "HIGHS"]], [["way", "HIGHS"]]):
        with pytest.raises(fo.ModelError, match="Attempt has other fields"):
            fo.results.load(told(tmp_path / "a.npz", {"thing": 0}, [{"Attempt": content}]))
    with pytest.raises(fo.ModelError, match="is not a result"):
        fo.results.load(told(tmp_path / "a.npz", {"eval": "1"}, []))


@pytest.mark.parametrize("version", ["0.1.0", None])
def test_a_result_of_another_version_is_refused_with_a_remedy(tmp_path, version):
    """Files of 0.2.0 and before have no version, no date and no seal."""
    path = tmp_path / "old.npz"
    answer("Onset").save(path)
    with np.load(path) as archive:
        arrays = {
            name: archive[name] for name in archive if name not in ("version", "date", "seal")
        }
    if version:
        arrays["version"] = version
    np.savez(path, **arrays)
    said = f"version {version or 'before 0.3.0'} of frictopt wrote it; compute the result again"
    with pytest.raises(fo.ModelError, match=said):
        fo.results.load(path)


def test_what_no_file_can_keep_is_named(tmp_path):
    steady = answer("SteadyState")
    odd = replace(
        steady,
        cycle=replace(LIFTS, times=[date(2020, 1, 1), type("Easter", (date,), {})(2020, 4, 12)]),
    )
    with pytest.raises(
        fo.ModelError,
        match=r"SteadyState.cycle.times\[1\]: a Easter cannot be kept in a file; pickle the result instead",
    ):
        odd.save(tmp_path / "a.npz")
    with pytest.raises(fo.ModelError, match=r"a\.csv' cannot be written"):
        steady.save(tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())


def test_the_loads_of_a_copy_stay_read_only():
    for again in (way(LIFTS) for way in WAYS.values()):
        assert again == LIFTS
        with pytest.raises(TypeError, match="does not support item assignment"):
            again.mean["P"] = 2.0
        with pytest.raises(TypeError, match="does not support item assignment"):
            again.corners[0]["N"] = 2.0
