"""The list of planted faults: each stands where it says, in all rooms, and has tests that should
find it."""

import ast
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))

import mutants  # noqa: E402
from mutants import FAULTS  # noqa: E402

from helpers.planting import Fault, planted  # noqa: E402

ROOMS = {
    folder.name for folder in (ROOT / "frictopt").iterdir() if (folder / "__init__.py").is_file()
}


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: f"{fault.file}: {fault.meaning}")
def test_a_fault_can_be_planted_and_has_tests(fault):
    source = mutants.place(fault, ROOT).read_text()
    with_fault = planted(source, fault)
    assert with_fault is not None and ast.dump(ast.parse(with_fault)) != ast.dump(ast.parse(source))
    for glob, _, test in (name.partition("::") for name in fault.tests.split()):
        files = list((ROOT / "tests").glob(f"*/test_{glob}.py"))
        assert files and all(not test or f"def {test}(" in path.read_text() for path in files)


SOURCE = """
def first(x):
    return max(x,
               0) + 1


def second(x):
    y = f"{x + 1}"
    return [y, x + 1]
"""


@pytest.mark.parametrize(
    ("old", "new", "within", "line"),
    [
        ("max(x, 0)", "min(x, 0)", "", "return (min(x, 0)) + 1"),  # however it is written
        ("x + 1", "x - 1", "second", "return [y, (x - 1)]"),  # texts with braces count as a whole
        ("return max(x, 0) + 1", "if x:\n    return 1", "", "    if x:\n        return 1\n"),
    ],
)
def test_a_fault_is_found_by_its_syntax(old, new, within, line):
    assert line in planted(SOURCE, Fault("file.py", "meaning", old, new, "tests", within))


@pytest.mark.parametrize(
    ("old", "within"), [("x", ""), ("max(x, 1)", ""), ("x + 1", "first"), ("x + 1", "third")]
)
def test_a_fault_that_does_not_stand_once_is_not_planted(old, within):
    assert planted(SOURCE, Fault("file.py", "meaning", old, "0", "tests", within)) is None


def test_every_room_has_faults():
    assert {mutants.room(fault) for fault in FAULTS} >= ROOMS


def test_the_table_counts_by_room_names_what_survives_and_keeps_other_rooms():
    faults = [fault for fault in FAULTS if fault.file.startswith(("solve", "reference"))]
    solve, reference = (
        sum(fault.file.startswith(room) for fault in faults) for room in ("solve", "reference")
    )
    before = "| fem | 70 | 60 | abc of 2000-01-01 | a fault |\n| solve | 2 | 2 | abc of 2000-01-01 | - |\n"
    killed = [fault.meaning != "steps leave their cones" for fault in faults]
    text = mutants.page(before, faults, killed, "def of 2001-01-01", "Made here.").splitlines()
    assert f"| reference | {reference} | {reference} | def of 2001-01-01 | - |" in text
    assert (
        f"| solve | {solve} | {solve - 1} | def of 2001-01-01 | steps leave their cones (`solve/interior_point.py`) |"
        in text
    )
    assert (
        "| fem | 70 | 60 | abc of 2000-01-01 | a fault |" in text
    )  # not as many as there are: it waits for a run of all
    assert (
        f"| all | {70 + solve + reference} | {60 + solve - 1 + reference} | - | - |" in text
        and text[-1] == "*Made here.*"
    )


def test_a_run_of_some_faults_of_a_room_says_what_became_of_these():
    own = [fault for fault in FAULTS if mutants.room(fault) == "solve"]
    first = mutants.page(
        "", own, [False, False, *[True] * (len(own) - 2)], "abc of 2000-01-01", "Made here."
    )
    again = mutants.page(first, own[:1], [True], "def of 2001-01-01", "Made here.").splitlines()
    alive = f"{own[1].meaning} (`{own[1].file}`)"
    assert (
        f"| solve | {len(own)} | {len(own) - 1} | abc of 2000-01-01, def of 2001-01-01 | {alive} |"
        in again
    )
    assert f"| all | {len(own)} | {len(own) - 1} | - | - |" in again
