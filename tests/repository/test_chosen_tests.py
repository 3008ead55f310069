"""Which tests run: the list of slow tests, the random cases, and tests without their library."""

import re
import subprocess
import sys
from pathlib import Path

from helpers import cases
from tools.slow_tests import LIST, ROOT, slow_tests


def test_the_list_of_slow_tests_names_tests_that_exist():
    gone = []
    for line in LIST.read_text(encoding="utf-8").splitlines():
        file, _, test = line.partition("[")[0].partition("::")
        name = test.split(".")[-1]
        text = (ROOT / file).read_text(encoding="utf-8") if (ROOT / file).exists() else ""
        gone += [] if re.search(rf"^ *(def|class) {name}\b", text, re.MULTILINE) else [line]
    assert not gone, "take these lines out of tests/slow.txt, or write it anew"


def test_the_dearest_tests_of_a_room_are_slow_except_those_that_alone_find_a_fault():
    costs = {f"tests/solve/test_a.py::test_{n}": 1.0 + n for n in range(8)}
    costs |= {f"tests/fem/test_b.py::test_{n}": 0.001 * n for n in range(8)}
    shared = ["tests/studies/test_c.py::test_0", "tests/studies/test_c.py::test_1"]
    costs |= dict.fromkeys(shared, 0.0)
    last, next_to_last = (f"tests/solve/test_a.py::test_{n}" for n in (7, 6))
    # Tests of the room fem are cheap, so none of them is slow.
    assert slow_tests(costs, shared, []) == sorted([last, next_to_last, *shared])
    assert slow_tests(costs, shared, [[last]]) == sorted([next_to_last, *shared])
    assert slow_tests(costs, shared, [[last, next_to_last]]) == sorted([last, *shared])
    assert slow_tests(costs, shared, [[last, "tests/solve/test_a.py::test_0"]]) == sorted(
        [last, next_to_last, *shared]
    )


def test_a_seed_draws_other_cases_and_as_many(monkeypatch):
    monkeypatch.setattr(cases, "ALL_CASES", False)
    monkeypatch.setattr(cases, "SEED", None)
    assert cases.few(range(100, 130)) == range(100, 110)
    monkeypatch.setattr(cases, "SEED", "1234")
    drawn = cases.few(range(100, 130))
    assert len(set(drawn)) == 10 and drawn == sorted(drawn) == cases.few(range(100, 130))
    assert drawn != list(range(100, 110)) and set(drawn) < set(range(100, 130))
    assert cases.few(30) == 10


NEEDS_MESHIO = '''
import pytest
import frictopt as fo


def test_by_a_reader(tmp_path):
    (tmp_path / "mesh.vtu").touch()
    with pytest.raises(fo.ModelError, match="cannot read"):
        fo.readers.read_mesh(tmp_path / "mesh.vtu")


def test_itself():
    import meshio


@pytest.fixture
def made():
    import meshio


def test_by_a_fixture(made):
    pass


def test_without():
    pass


def test_that_fails():
    import meshioo


def example():
    """
    >>> import meshio
    """
'''


def test_tests_of_a_library_that_is_not_installed_are_skipped(tmp_path):
    (tmp_path / "test_needs.py").write_text(NEEDS_MESHIO)
    (tmp_path / "test_head.py").write_text("import meshio\n\n\ndef test_any():\n    pass\n")
    tests = Path(__file__).parents[1]
    code = (
        f"import sys; sys.modules['meshio'] = None; sys.path.insert(0, {str(tests)!r})\n"
        "import pytest; from helpers import absent\n"
        "pytest.main(['-q', '-rfEs', '--doctest-modules', '-p', 'no:cacheprovider'], [absent])\n"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    ).stdout
    assert (
        "1 failed, 1 passed, 6 skipped" in said and "FAILED test_needs.py::test_that_fails" in said
    )
    assert said.count("meshio is not installed") > 1, said
