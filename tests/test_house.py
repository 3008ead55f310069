"""The layers of the package, the size of its files, and what stands on its doors."""

import ast
import inspect
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import frictopt
from frictopt import errors
from systems import CYCLE, random_system

PACKAGE = Path(frictopt.__file__).parent
_BASE = {"errors", "contact", "reference"}
BELOW = {
    "errors": set(),
    "contact": {"errors"},
    "reference": {"errors", "contact"},
    "fem": _BASE,
    "scenes": _BASE | {"fem"},
    "solve": _BASE,
    "transients": _BASE | {"solve"},
    "limits": _BASE | {"solve", "transients"},  # where the mean load leaves nodes open
    "histories": _BASE | {"solve", "limits", "transients"},
    "plots": _BASE | {"fem", "limits", "transients", "histories", "scenes"},
}
ALLOWED = {  # libraries beyond the standard one, by layer
    "errors": set(),
    "contact": {"numpy", "pandas", "tqdm"},  # pandas where a table is asked for, tqdm where a computation is long
    "reference": {"numpy", "scipy.special"},  # the latter where a series is asked for
    "fem": {"numpy", "scipy", "skfem", "meshio", "pandas", "pyyeti", "ansys"},  # the last four where a file is read
    "scenes": {"numpy", "skfem"},
    "solve": {"numpy", "scipy", "cvxpy", "pandas", "highspy", "clarabel"},
    "limits": {"numpy", "scipy", "cvxpy", "pandas"},
    "transients": {"numpy", "scipy", "cvxpy", "pandas", "numba", "lazy_loader", "xarray"},  # the last one where a Dataset is asked for
    "histories": {"numpy", "scipy", "pandas", "threadpoolctl"},
    "plots": {"numpy", "pandas", "skfem", "matplotlib", "mpl_toolkits", "pyvista"},  # the last one where a model is viewed
}
FILES = sorted(PACKAGE.rglob("*.py"))
IDS = [str(path.relative_to(PACKAGE)) for path in FILES]


def room(path):
    return path.relative_to(PACKAGE).with_suffix("").parts[0]


def imported(path):
    """Absolute dotted names that a file imports."""
    base = ("frictopt", *path.relative_to(PACKAGE).parent.parts)
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = ".".join(base[: len(base) - node.level + 1]) if node.level else ""
            module = ".".join(part for part in (start, node.module) if part)
            yield from ([module] if node.module else [f"{module}.{alias.name}" for alias in node.names])


@pytest.mark.parametrize("path", [path for path in FILES if path.parent != PACKAGE], ids=[i for i in IDS if "/" in i])
def test_imports_point_one_way(path):
    here = room(path)
    for name in imported(path):
        first, *rest = name.split(".")
        if first == "frictopt":
            assert rest[0] == here or rest[0] in BELOW[here], f"{here} imports {name}"
        elif first not in sys.stdlib_module_names:
            assert any(name == allowed or name.startswith(allowed + ".") for allowed in ALLOWED[here]), f"{here} imports {name}"


def test_files_of_a_layer_do_not_import_each_other_in_a_circle():
    edges = {}
    for path in FILES:
        name = ".".join(("frictopt", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__")
        edges[name] = {other for other in imported(path) if other != name}
    done = set()

    def visit(name, trail):
        assert name not in trail, " -> ".join([*trail, name])
        if name not in done:
            for other in edges.get(name, ()):
                visit(other, [*trail, name])
            done.add(name)

    for name in edges:
        visit(name, [])


@pytest.mark.parametrize("path", FILES, ids=IDS)
def test_files_are_small_or_say_why_not(path):
    text = path.read_text(encoding="utf-8")
    assert text.count("\n") <= 450 or "\n# One file because" in text


def test_the_recipe_asks_for_the_versions_of_the_package():
    asked = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text())["project"]["dependencies"]
    recipe = (PACKAGE.parent / "conda" / "recipe.yaml").read_text().replace("cvxpy-base", "cvxpy")
    assert asked == [name for name in asked if f"    - {name.replace('>', ' >', 1)}\n" in recipe]


@pytest.mark.parametrize(
    ("file", "line"), [("CITATION.cff", r"version: (\S+)"), ("CHANGELOG.md", r"## (\S+) - "), ("conda/recipe.yaml", r'  version: "(.+)"')]
)
def test_the_version_is_the_same_everywhere(file, line):
    found = re.search(f"^{line}", (PACKAGE.parent / file).read_text(encoding="utf-8"), re.MULTILINE)
    assert found[1] == frictopt.__version__


def test_every_public_name_is_listed_and_described():
    assert sorted(frictopt.__all__) == frictopt.__all__ and len(frictopt.__all__) <= 64
    modules = [getattr(module, name) for module in (frictopt.scenes, frictopt.results) for name in module.__all__]
    for thing in [*(getattr(frictopt, name) for name in frictopt.__all__), *modules]:
        name = thing.__name__ if hasattr(thing, "__name__") else repr(thing)
        assert inspect.getdoc(thing), name
        for member, value in vars(thing).items() if inspect.isclass(thing) else ():
            if not member.startswith("_") and (inspect.isfunction(value) or isinstance(value, property)):
                assert inspect.getdoc(value), f"{name}.{member}"


def test_dir_shows_what_is_public():
    modules = [getattr(frictopt, name) for name in frictopt.__all__ if inspect.ismodule(getattr(frictopt, name))]
    assert len(modules) == 5
    for module in (frictopt, *modules):
        assert dir(module) == sorted(module.__all__), module.__name__


def test_all_errors_have_one_base():
    for name in errors.__all__:
        assert issubclass(getattr(errors, name), frictopt.FrictoptError | Warning)


def loaded(code):
    """Libraries that a program has imported at its end."""
    return set(
        subprocess.run([sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules)"], check=True, capture_output=True, text=True).stdout.split()
    )


SYSTEM = (
    "import numpy as np, frictopt as fo\n"
    "one = np.eye(2)\n"
    "s = fo.ContactSystem.from_blocks(one, 0.1 * one, one, [0, 1], {'P': ([0, 0], [1, 1]), 'Q': ([1, 0], [0, 0])})\n"
    "fo.reference.sliding_corner_exponent(0.5)\n"
)


def test_a_room_is_imported_when_it_is_first_used():
    heavy = {"numpy", "scipy", "cvxpy", "numba", "skfem", "pandas", "matplotlib", "distributed", "tqdm"}
    limit = "fo.shakedown_limit(s, fo.LoadCycle({'P': 1.0}, [{'Q': 1.0}, {'Q': -1.0}]), 0.5)"
    assert not heavy & loaded("import frictopt")
    assert heavy & loaded(SYSTEM + "fo.onset(s, fo.LoadCycle({'P': 1.0}, [{'Q': 1.0}]), 0.5)") == {"numpy"}
    assert heavy & loaded(SYSTEM + limit) == {"numpy", "scipy", "cvxpy", "pandas"}


def test_a_path_in_the_plane_needs_no_library_of_limits():
    joined = SYSTEM.replace("np.eye(2)", "np.eye(2) + 0.1")
    path = loaded(joined + "fo.steady_state(s, fo.LoadCycle({'P': 1.0}, [{'Q': 0.6}, {'Q': -0.6}]), 0.5, 1.0)")
    assert "numba" in path and not {"cvxpy", "pandas", "scipy.sparse", "scipy.optimize"} & path


@pytest.mark.parametrize("title", ["limit", "steady state"])
def test_the_way_of_a_question_is_the_one_that_is_told(title):
    """Files are entered for the first time in the order of the page."""
    page = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
    told = re.findall(r"`([a-z_/]+\.py)`", re.search(rf"## From a question to a {title}\n(.*?)(\n## |\Z)", page, re.DOTALL)[1])
    asked, entered = (random_system(np.random.default_rng(0), 2), CYCLE, 0.5), dict[str, None]()

    def see(frame, event, _argument):
        path = Path(frame.f_code.co_filename)
        if event == "call" and path.is_relative_to(PACKAGE):
            entered.setdefault(str(path.relative_to(PACKAGE)))

    ask = {"limit": lambda: frictopt.shakedown_limit(*asked), "steady state": lambda: frictopt.steady_state(*asked, 1.0)}[title]
    ask()  # so that nothing is imported or compiled
    sys.setprofile(see)
    try:
        ask()
    finally:
        sys.setprofile(None)
    assert {name for name in told if name not in entered} == ({"limits/lift_off.py"} if title == "limit" else {"transients/stepped.py"})
    order = [name for name in entered if name in told]
    assert order == [name for name in dict.fromkeys(told) if name in entered]


def test_help_shows_short_types():
    """Not what they are made of, as the unions of numpy."""
    things = [(name, getattr(frictopt, name)) for name in frictopt.__all__]
    things += [(f"{name}.{part}", getattr(room, part)) for name, room in things if inspect.ismodule(room) for part in room.__all__]
    things += [(f"{name}.{part}", value) for name, thing in things if inspect.isclass(thing) for part, value in vars(thing).items() if part[0] != "_"]
    asked = [(name, thing) for name, thing in things if inspect.isfunction(thing) or (inspect.isclass(thing) and "__init__" in vars(thing))]
    assert len(asked) > 150 and not [name for name, thing in asked if "numpy." in str(inspect.signature(thing))]
