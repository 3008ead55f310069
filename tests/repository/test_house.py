"""The layers of the package, the size of its files, and what stands on its doors."""

import ast
import inspect
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import frictopt
from frictopt import errors
from helpers import rooms, words
from helpers.systems import CYCLE, random_system

PACKAGE = Path(frictopt.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
IDS = [str(path.relative_to(PACKAGE)) for path in FILES]
MOST_LINES = 510


@pytest.mark.parametrize(
    "name", [name for name in rooms.files() if rooms.room(name) in rooms.BELOW]
)
def test_imports_point_one_way(name):
    """At the head of a file, inside functions, for hints of types, and by name."""
    here = rooms.room(name)
    allowed = {here, *rooms.BELOW[here]}
    assert {rooms.room(other) for other in rooms.arrows()[name]} <= allowed
    libraries = rooms.LIBRARIES[here] | (
        rooms.DRAWING if name.split(".")[-1] in rooms.DRAWS else set()
    )
    for library in rooms.foreign(name):
        assert any(f"{library}.".startswith(f"{known}.") for known in libraries), (
            f"{name} imports {library}"
        )


def test_every_room_has_its_place():
    """A room may import only rooms that stand before it, so there is an order of the rooms."""
    folders = {rooms.room(name) for name in rooms.files()} - {"", "__main__"}
    assert folders == set(rooms.BELOW)
    order = list(rooms.BELOW)
    for number, name in enumerate(order):
        assert rooms.BELOW[name] <= set(order[:number])


@pytest.mark.parametrize("name", [name for name in rooms.files() if "frictopt.limits." in name])
def test_imports_in_limits_point_one_way(name):
    """The floor of `limits` has rooms of its own; each file imports rooms that stand before it."""
    allowed = rooms.IN_LIMITS[: rooms.IN_LIMITS.index(rooms.room_in_limits(name)) + 1]
    inside = [other for other in rooms.arrows()[name] if other.startswith("frictopt.limits.")]
    assert {rooms.room_in_limits(other) for other in inside} <= set(allowed)


def test_files_do_not_import_each_other_in_a_circle():
    edges, done = rooms.arrows(), set()

    def visit(name, trail):
        assert name not in trail, " -> ".join([*trail, name])
        if name not in done:
            for other in edges[name]:
                visit(other, [*trail, name])
            done.add(name)

    for name in edges:
        visit(name, [])


def test_folders_beside_the_package_import_one_way():
    """The package knows none of them, studies know the package, and tests know all."""
    order = ("frictopt", "studies", "paper_figures", "docs", "tests")
    for number, folder in enumerate(order):
        later = set(order[number + 1 :])
        if folder != "tests":
            later |= {"helpers", "tools"}
        for path in (PACKAGE.parent / folder).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            heads = re.findall(r"^\s*(?:from|import) (\w+)", text, re.MULTILINE)
            assert not later & set(heads), path


def test_imports_are_seen_wherever_they_stand(tmp_path, monkeypatch):
    """By name, inside a function, and for hints of types alone."""
    text = """
from typing import TYPE_CHECKING
if TYPE_CHECKING:
    from ..limits import ShakedownLimit
def late():
    from ..joints.archard import wear
    return import_module("frictopt.study.runs"), importlib.import_module("scipy.optimize")
"""
    file = tmp_path / "late.py"
    file.write_text(text)
    known = {**rooms.files(), "frictopt.base.late": file}
    monkeypatch.setattr(rooms, "files", lambda: known)
    ours = {"frictopt.limits.shakedown", "frictopt.joints.archard", "frictopt.study.runs"}
    assert ours <= set(rooms.imports("frictopt.base.late"))
    assert rooms.foreign("frictopt.base.late") == {"scipy.optimize"}


def test_all_names_are_there_without_matplotlib():
    blocked = "import sys; sys.modules['matplotlib'] = None\n"
    assert "frictopt.limits.shakedown" in loaded(blocked + "from frictopt import *")


@pytest.mark.parametrize("path", FILES, ids=IDS)
def test_files_are_small_or_say_why_not(path):
    text = path.read_text(encoding="utf-8")
    assert text.count("\n") <= MOST_LINES or "\n# One file because" in text


def test_no_test_imports_another():
    for path in sorted(Path(__file__).parents[1].rglob("test_*.py")):
        names = re.findall(
            r"^\s*(?:from|import) (test_\w+)", path.read_text(encoding="utf-8"), re.MULTILINE
        )
        assert not set(names) - {path.stem}, (
            f"{path.name} imports {names}"
        )  # a process of its own may import the file itself


def test_few_tests_know_the_inside_of_a_room():
    """Most tests ask at the public doors, as users do, and few replace what stands inside."""
    tests = Path(__file__).parents[1]
    texts = {path: path.read_text(encoding="utf-8") for path in sorted(tests.rglob("*.py"))}
    files = [path for path in texts if path.name.startswith("test_")]
    inside = [path for path in files if re.search(r"from frictopt\.[a-z_.]+ import", texts[path])]
    assert 4 * len(inside) <= len(files), inside
    replaced = {path: text.count(".setattr" + "(") for path, text in texts.items()}
    assert sum(replaced[path] for path in files) <= 50 and sum(replaced.values()) <= 65, replaced


@pytest.mark.parametrize(
    ("file", "line"), [("CITATION.cff", r"version: (\S+)"), ("CHANGELOG.md", r"## (\S+) - ")]
)
def test_the_version_is_the_same_everywhere(file, line):
    found = re.search(f"^{line}", (PACKAGE.parent / file).read_text(encoding="utf-8"), re.MULTILINE)
    assert found[1] == frictopt.__version__


def test_every_public_name_is_listed_and_described():
    assert sorted(frictopt.__all__) == frictopt.__all__ and len(frictopt.__all__) <= 44
    modules = [
        getattr(module, name)
        for module in (
            frictopt.fem,
            frictopt.joints,
            frictopt.readers,
            frictopt.scenes,
            frictopt.results,
        )
        for name in module.__all__
    ]
    for thing in [*(getattr(frictopt, name) for name in frictopt.__all__), *modules]:
        name = thing.__name__ if hasattr(thing, "__name__") else repr(thing)
        assert inspect.getdoc(thing), name
        for member, value in vars(thing).items() if inspect.isclass(thing) else ():
            if not member.startswith("_") and (
                inspect.isfunction(value) or isinstance(value, property)
            ):
                assert inspect.getdoc(value), f"{name}.{member}"


def test_dir_shows_what_is_public():
    modules = [
        getattr(frictopt, name)
        for name in frictopt.__all__
        if inspect.ismodule(getattr(frictopt, name))
    ]
    assert len(modules) == 8
    for module in (frictopt, *modules):
        assert dir(module) == sorted(module.__all__), module.__name__


def test_all_errors_have_one_base():
    for name in errors.__all__:
        assert issubclass(getattr(errors, name), frictopt.FrictoptError | Warning)


def loaded(code):
    """Libraries that a program has imported at its end."""
    return set(
        subprocess.run(
            [sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules)"],
            check=True,
            capture_output=True,
            text=True,
        ).stdout.split()
    )


SYSTEM = (
    "import numpy as np, frictopt as fo\n"
    "one = np.eye(2)\n"
    "s = fo.ContactSystem.from_blocks(one, 0.1 * one, one, [0, 1], {'P': ([0, 0], [1, 1]), 'Q': ([1, 0], [0, 0])})\n"
    "fo.reference.sliding_corner_exponent(0.5)\n"
)


def test_a_room_is_imported_when_it_is_first_used():
    heavy = {
        "numpy",
        "scipy",
        "cvxpy",
        "numba",
        "skfem",
        "pandas",
        "matplotlib",
        "distributed",
        "tqdm",
    }
    limit = "fo.shakedown_limit(s, fo.LoadCycle({'P': 1.0}, [{'Q': 1.0}, {'Q': -1.0}]), 0.5)"
    assert not heavy & loaded("import frictopt")
    assert heavy & loaded(SYSTEM + "fo.onset(s, fo.LoadCycle({'P': 1.0}, [{'Q': 1.0}]), 0.5)") == {
        "numpy"
    }
    assert heavy & loaded(SYSTEM + limit) == {"numpy", "scipy"}


def test_a_path_in_the_plane_needs_no_library_of_limits():
    joined = SYSTEM.replace("np.eye(2)", "np.eye(2) + 0.1")
    path = loaded(
        joined + "fo.steady_state(s, fo.LoadCycle({'P': 1.0}, [{'Q': 0.6}, {'Q': -0.6}]), 0.5, 1.0)"
    )
    assert "numba" in path and not {"cvxpy", "pandas", "scipy.sparse", "scipy.optimize"} & path


@pytest.mark.parametrize("title", ["limit", "steady state"])
def test_the_way_of_a_question_is_the_one_that_is_told(title):
    """Files are entered for the first time in the order of the page."""
    page = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    told = re.findall(
        r"`([a-z_/]+\.py)`",
        re.search(rf"## From a question to a {title}\n(.*?)(\n## |\Z)", page, re.DOTALL)[1],
    )
    asked, entered = (random_system(np.random.default_rng(0), 2), CYCLE, 0.5), dict[str, None]()

    def see(frame, event, _argument):
        path = Path(frame.f_code.co_filename)
        if event == "call" and path.is_relative_to(PACKAGE):
            entered.setdefault(str(path.relative_to(PACKAGE)))

    ask = {
        "limit": lambda: frictopt.shakedown_limit(*asked),
        "steady state": lambda: frictopt.steady_state(*asked, 1.0),
    }[title]
    ask()  # so that nothing is imported or compiled
    sys.setprofile(see)
    try:
        ask()
    finally:
        sys.setprofile(None)
    assert {name for name in told if name not in entered} == (
        {
            "limits/printed/last_resort.py",
            "limits/events/lift_off.py",
            "limits/printed/listing.py",
            "limits/printed/models.py",
        }
        if title == "limit"
        else {"transients/stepped.py"}
    )
    order = [name for name in entered if name in told]
    assert order == [name for name in dict.fromkeys(told) if name in entered]


def test_help_shows_short_types():
    """Not what they are made of, as the unions of numpy."""
    things = [(name, getattr(frictopt, name)) for name in frictopt.__all__]
    things += [
        (f"{name}.{part}", getattr(room, part))
        for name, room in things
        if inspect.ismodule(room)
        for part in room.__all__
    ]
    things += [
        (f"{name}.{part}", value)
        for name, thing in things
        if inspect.isclass(thing)
        for part, value in vars(thing).items()
        if part[0] != "_"
    ]
    asked = [
        (name, thing)
        for name, thing in things
        if inspect.isfunction(thing) or (inspect.isclass(thing) and "__init__" in vars(thing))
    ]
    assert len(asked) > 150 and not [
        name for name, thing in asked if "numpy." in str(inspect.signature(thing))
    ]


def test_docstrings_begin_with_the_thing_that_they_describe():
    """Not with a word that stands for it, so that a reader knows it after the first words."""
    vague = re.compile(r"(What|The same|Those|One|Whether it|That of)\b")
    bad = []
    for path in FILES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                docstring = ast.get_docstring(node) or ""
                if vague.match(docstring):
                    bad.append(f"{path.relative_to(PACKAGE)}: {docstring.splitlines()[0]}")
    assert not bad


@pytest.mark.parametrize("page", words.pages(), ids=lambda page: str(page.relative_to(words.ROOT)))
def test_a_page_has_the_words_of_the_glossary(page):
    assert not list(words.faults(words.text_of(page)))


def test_unused_words_and_habits_are_seen_in_prose_alone():
    seen = "The one that rests; see [a page](pattern.md), `pattern` and\n\n```\npattern\n```\n"
    assert [fault.split("'")[1] for fault in words.faults(seen)] == ["rests", "The one"]
    assert words.FIRST.match("What a node does.") and not words.FIRST.match("Itself a node.")


def docstrings():
    """The docstrings of public names and of their members, with the name of each."""
    things = [(name, getattr(frictopt, name)) for name in frictopt.__all__]
    for _, module in list(things):
        if inspect.ismodule(module):
            things += [(name, getattr(module, name)) for name in module.__all__]
    for name, thing in things:
        yield name, inspect.getdoc(thing) or ""
        if inspect.isclass(thing) and thing.__module__.startswith("frictopt"):
            for member, value in vars(thing).items():
                if member[0] != "_" and (inspect.isroutine(value) or isinstance(value, property)):
                    yield f"{name}.{member}", inspect.getdoc(value) or ""


def test_public_docstrings_have_the_words_of_the_glossary():
    """They begin with a noun or a verb, not with a pronoun."""
    texts = dict(docstrings())
    assert len(texts) > 250
    assert not [name for name, text in texts.items() if words.FIRST.match(text)]
    prose = {name: text.split("\nExamples\n")[0] for name, text in texts.items()}
    assert not [
        (name, *found) for name, text in prose.items() if (found := list(words.faults(text)))
    ]
