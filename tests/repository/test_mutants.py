"""The list of planted faults: each stands where it says, in all rooms, and has tests that should
find it."""

import ast
from pathlib import Path

import pytest

from helpers.planting import Fault, listed, planted
from tools import mutants
from tools.mutants import FAULTS, Failure, Fate

ROOT = Path(__file__).parents[2]

ROOMS = {
    folder.name for folder in (ROOT / "frictopt").iterdir() if (folder / "__init__.py").is_file()
}


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: f"{fault.file}: {fault.meaning}")
def test_a_fault_can_be_planted_and_has_tests(fault):
    with_fault = planted(mutants.place(fault, ROOT).read_text(), fault)
    assert with_fault is not None and ast.parse(with_fault)
    assert ast.dump(ast.parse(fault.new)) != ast.dump(ast.parse(fault.old))
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


@pytest.mark.parametrize("paragraph", ["a fault without tests\n- x\n+ y", "a fault [tests]\nx"])
def test_a_paragraph_of_a_list_that_is_no_fault_is_refused(paragraph):
    with pytest.raises(ValueError, match="this is no planted fault"):
        list(listed(f"== file.py\n\n{paragraph}"))


def test_every_room_has_faults():
    assert {mutants.room(fault) for fault in FAULTS} >= ROOMS


def of_room(name):
    return [fault for fault in FAULTS if mutants.room(fault) == name]


def test_the_table_counts_by_room_names_what_is_no_plain_kill_and_keeps_other_rooms():
    fates = {fault: Fate(killed=True) for fault in of_room("solve") + of_room("reference")}
    alive, endless, late = of_room("solve")[:3]
    fates[alive] = Fate(killed=False)
    fates[endless] = Fate(killed=True, no_end=True)
    fates[late] = Fate(killed=True, slow=True)
    before = (
        "| fem | 70 | 60 | abc of 2000-01-01 | - | - | a fault |\n"
        "| solve | 2 | 2 | abc of 2000-01-01 | - | - | - |\n"
    )
    text = mutants.page(before, fates, "def of 2001-01-01", "Made here.").splitlines()
    solve, reference = len(of_room("solve")), len(of_room("reference"))
    assert f"| reference | {reference} | {reference} | def of 2001-01-01 | - | - | - |" in text
    named = " | ".join(map(mutants.words, (late, endless, alive)))
    assert f"| solve | {solve} | {solve - 1} | def of 2001-01-01 | {named} |" in text
    # A room of which nothing was planted keeps its row, whatever its faults are today.
    assert "| fem | 70 | 60 | abc of 2000-01-01 | - | - | a fault |" in text
    killed = 60 + solve - 1 + reference
    assert f"| all | {70 + solve + reference} | {killed} | - | - | - | - |" in text
    assert text[-1] == "*Made here.*"


def test_some_faults_of_a_room_make_no_row():
    fate = {of_room("solve")[0]: Fate(killed=True)}
    assert mutants.rows_of(mutants.page("", fate, "abc of 2000-01-01", "Made here.")) == {}


TESTS_OF_A_COPY = """
from time import sleep


def test_waits():
    sleep(4)


def test_fails():
    assert False


def test_computes_without_end():
    while True:
        pass
"""


@pytest.fixture
def ground(tmp_path, monkeypatch):
    """Tests that wait, fail and compute without end, in the place of a repository."""
    tests = tmp_path / "repository" / "tests"
    tests.mkdir(parents=True)
    (tests / "test_three.py").write_text(TESTS_OF_A_COPY)
    monkeypatch.setattr(mutants, "ROOT", tmp_path / "repository")
    return mutants.Ground(tmp_path / "ground")


def test_a_test_has_no_end_if_its_processor_time_exceeds_the_limit(ground):
    # The report of the first failure imports modules, which takes a second if none is compiled.
    failures = ground.failures(["tests/test_three.py"], patience=3.0)
    assert failures == [
        Failure("tests/test_three.py::test_fails"),
        Failure("tests/test_three.py::test_computes_without_end", "no end"),
    ]
    assert str(failures[1]) == "no end of tests/test_three.py::test_computes_without_end"


def test_a_test_that_computes_nothing_has_no_end_by_the_clock(ground, monkeypatch):
    monkeypatch.setattr(mutants, "WAITING", 2.0)
    failures = ground.failures(["tests/test_three.py::test_waits"])
    assert [failure.how for failure in failures] == ["no end"]


@pytest.mark.parametrize(
    ("limit", "killer"),
    [
        (5, Failure("tests/room/test_sizes.py::test_small")),
        (500, Failure("tests/room/test_sizes.py::test_large", slow=True)),
        (5000, None),
    ],
)
def test_slow_tests_are_asked_about_what_no_other_test_finds(ground, limit, killer):
    package, tests = ground.copy / "frictopt", ground.copy / "tests" / "room"
    package.mkdir()
    tests.mkdir()
    (package / "__init__.py").touch()
    (package / "sizes.py").write_text("def size(n):\n    return n\n")
    (tests / "test_sizes.py").write_text(
        """
import pytest
from frictopt.sizes import size


@pytest.mark.slow
def test_large():
    assert size(1000) == 1000


def test_small():
    assert size(10) == 10
"""
    )
    fault = Fault("sizes.py", "sizes have a limit", "return n", f"return min(n, {limit})", "sizes")
    assert ground.failures_with(fault) == ([killer] if killer else [])


def test_python_takes_no_bytecode_of_an_earlier_fault(ground):
    """It knows bytecode by the second and the size of its source."""
    (ground.copy / "frictopt").mkdir()
    file = ground.copy / "frictopt" / "sizes.py"
    file.write_text("def size(n):\n    return n\n")
    seconds = []
    ground.failures = lambda *tests, **options: seconds.append(int(file.stat().st_mtime))
    for limit in (5, 6, 7):
        ground.failures_with(Fault("sizes.py", "a limit", "n", f"min(n, {limit})", "sizes", "size"))
    assert len(set(seconds)) == 3


class Answers:
    """In the place of a ground: these tests fail without a fault."""

    def __init__(self, *failures):
        self._failures = failures

    def failures(self, tests):
        return [failure for failure in self._failures if failure.test in tests]


def test_a_test_that_fails_without_the_fault_kills_none():
    survives, gone, dies, endless, falsely, late = FAULTS[:6]
    results = {
        survives: [],
        gone: None,
        dies: [Failure("a.py::test_a")],
        endless: [Failure("a.py::test_b", "no end")],
        falsely: [Failure("a.py::test_c")],
        late: [Failure("a.py::test_d", slow=True)],
    }
    fates = mutants.fates_of(results, Answers(Failure("a.py::test_c")))
    assert list(fates.values()) == [
        Fate(killed=False),
        Fate(killed=False),
        Fate(killed=True),
        Fate(killed=True, no_end=True),
        Fate(killed=False),
        Fate(killed=True, slow=True),
    ]
    fates = mutants.fates_of(results, Answers(Failure("a.py::test_b", "no end")))
    assert not any(fate.killed for fate in fates.values())  # not all of them could be asked


@pytest.mark.parametrize("always", [True, False])
def test_a_collection_that_crashes_without_the_fault_kills_none(always, tmp_path):
    crash = Failure(mutants.COLLECTION, "crash")
    ground = Answers()
    ground.copy = tmp_path
    ground.failures = lambda tests, *options: [crash] if options and always else []
    results = {FAULTS[0]: [crash], FAULTS[1]: [Failure("a.py::test_a")]}
    fates = mutants.fates_of(results, ground)
    assert list(fates.values()) == 2 * [Fate(killed=not always)]
