"""Every argument of every public question and part of a model, given odd values: an answer or an
error of ours that names it, soon, and nothing else.

Each call has one set of good arguments; one of them at a time is replaced. Values that mean nothing
anywhere must be refused.
"""

# One file because it is one table of everything public.

import inspect
from decimal import Decimal

import numpy as np
import pandas as pd
import pytest
from scipy.sparse import csr_matrix

import frictopt as fo
from helpers.public_names.called import CALLS, CLAIMED, CONTACT, FRICTION, TooLong, alarm
from helpers.systems import CYCLE

MAYBE = {  # what may mean something somewhere
    "None": None,
    "True": True,
    "text": "odd",
    "-1": -1,
    "0": 0,
    "10**400": 10**400,
    "Decimal": Decimal("0.3"),
    "0-d array": np.array(0.5),
    "empty list": [],
    "empty mapping": {},
    "numbers": [0.5, 0.5],
    "column": [[0.5], [0.5]],
    "Series": pd.Series([0.5, 0.5]),
    "type": int,
}
NEVER = {  # what means nothing anywhere
    "bytes": b"AB",
    "complex": 1j,
    "nan": np.nan,
    "-inf": np.float32(-np.inf),
    "timedelta64": np.timedelta64(1),
    "NA": pd.NA,
    "masked array": np.ma.masked_array([0.5, 0.5], mask=[True, False]),
    "sparse in a list": [csr_matrix(np.eye(2))],
    "ragged": [[0.5, 0.5], [0.5]],
    "nan in a list": [0.5, np.nan],
    "texts": ["1", "2"],
    "text array": np.array(["1", "2"]),
    "truths": [True, False],
    "object": object(),
    "odd mapping": {3: object()},
    "mapping of nan": {"mean": np.nan},
    "frame": pd.DataFrame({"a": ["x", None]}),
}
LABELS = {
    "argument",
    "file",
    "executor",
    # arguments that are no input of the problem: a word for messages, a stream, somebody else's object
}
MADE_BY_US = {"LimitKind", "Outcome"}  # by answers, and not by users
NAMES = {"texts", "text array"}  # what is right for the names of the contact of two nodes
# an error may speak of what stands in a file, of node sets, of load cases, or of pairs that a
# projection does not go with
OTHER_WORDS = {
    *(
        ("MatrixJob.force", "where"),
        ("MatrixJob.areas", "face"),
        ("MatrixJob.pairs", "first"),
        ("MatrixJob.pairs", "second"),
        ("condense", "projection"),
    ),
    *(
        (f"read_{code}", argument)
        for code in ("abaqus", "ansys", "nastran")
        for argument in ("path", "deck")
    ),
    *(
        ("read_nastran", "name"),
        ("read_nastran", "labels"),
        ("read_calculix", "job"),
        ("read_mesh", "path"),
        ("read_store", "path"),
    ),
    *(("merge_stores", "into"), ("merge_stores", "parts"), ("safe_region", "loads")),
}
EMPTY = {"0", "empty list", "empty mapping"}  # of which another argument may be what does not fit


def arguments(function):
    return [
        name
        for name, parameter in inspect.signature(function).parameters.items()
        if name not in LABELS and parameter.kind is not inspect.Parameter.VAR_KEYWORD
    ]


def public():
    """Names of all public functions and constructors that take an argument."""
    for room in (fo, fo.fem, fo.readers, fo.scenes):
        for name in room.__all__:
            thing = getattr(room, name)
            made = (
                inspect.isclass(thing)
                and not issubclass(thing, Exception)
                and name not in MADE_BY_US
            )
            if (inspect.isfunction(thing) or made) and arguments(thing):
                yield name


def test_everything_public_is_called():
    assert set(public()) <= set(CALLS)


@pytest.mark.usefixtures("few_starts")
@pytest.mark.parametrize("name", CALLS)
def test_an_odd_value_gives_an_answer_or_an_error_of_ours(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    function, good = CALLS[name]
    with pytest.raises(fo.FrictoptError) if good.get("path") == "none" else alarm():
        function(**good)
    taken = arguments(function)
    faults = []
    for argument in taken:
        for label, value in (MAYBE | NEVER).items():
            try:
                with alarm():
                    function(**{**good, argument: value})
            except fo.FrictoptError as error:
                named = argument in str(error) or (name, argument) in OTHER_WORDS or label in EMPTY
                if len(str(error)) > 1000 or not named:
                    faults.append(f"{argument}={label}: {str(error)[:200]}")
            except (Exception, TooLong) as error:
                faults.append(f"{argument}={label}: {type(error).__name__}: {str(error)[:100]}")
            else:
                wrong_state = (
                    name.startswith("check_contact_law")
                    and argument in CLAIMED
                    and label == "nan in a list"
                )
                meant = (argument == "contact" and label in NAMES) or (argument, label) == (
                    "open_nodes",
                    "truths",
                )
                if label in NEVER and not wrong_state and not meant:
                    faults.append(f"{argument}={label}: accepted")
    assert not faults, "\n" + "\n".join(faults)


FORGOTTEN = [
    (name, argument)
    for name, (function, _) in CALLS.items()
    for argument, parameter in inspect.signature(function).parameters.items()
    if argument in ("cycle", "friction", "load_factor", "mean")
    and parameter.default is inspect.Parameter.empty
    if function.__name__ not in ("ExactPath", "<lambda>")
]


@pytest.mark.parametrize(("name", "argument"), FORGOTTEN)
def test_a_forgotten_argument_is_told_by_name(name, argument):
    function, good = CALLS[name]
    with pytest.raises(
        fo.ModelError, match=rf"^{argument}: not given; give .*, as in \w[\w.]*\(.*{argument}.*\)$"
    ):
        function(**{other: value for other, value in good.items() if other != argument})


def test_a_class_method_tells_what_is_forgotten_and_python_itself_what_does_not_exist():
    with pytest.raises(
        fo.ModelError, match=r"^mean: not given; give .*, as in LoadCycle.vertices\(mean\)$"
    ):
        fo.LoadCycle.vertices()
    with pytest.raises(TypeError, match="loadfactor"):
        fo.steady_state(CONTACT, CYCLE, FRICTION, loadfactor=0.5)
