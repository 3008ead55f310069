"""The rooms of the package, and the imports between its files.

The test of the house and the page on the architecture use them.
"""

import ast
import sys
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

PACKAGE = Path(find_spec("frictopt").origin).parent  # type: ignore[union-attr,arg-type]

_BASE = {"errors", "base"}
BELOW = {
    "errors": set(),
    "base": {"errors"},
    "plots": _BASE,
    "contact": _BASE | {"plots"},
    "reference": _BASE | {"contact"},
    "solve": _BASE,
    "fem": _BASE | {"plots", "contact"},
    "readers": _BASE | {"contact", "fem"},
    "scenes": _BASE | {"contact", "fem"},
    "transients": _BASE | {"plots", "contact", "solve"},
    "limits": _BASE | {"plots", "contact", "solve", "transients"},
    "study": _BASE | {"plots", "contact", "transients", "limits"},
    "joints": _BASE | {"plots", "contact", "transients", "limits", "study"},
    "results": _BASE | {"contact", "transients", "limits", "study", "joints"},
    "joint_files": _BASE | {"contact", "fem", "readers", "study", "joints"},
    "command": _BASE | {"contact", "fem", "readers", "study", "joint_files"},
}
"""Room -> the rooms that it may import, in their order. Each room stands below these rooms."""

IN_LIMITS = (
    "program",
    "between",
    "events",
    "moving",
    "guarantee",
    "balance",
    "printed",
    "answers",
    "search",
    "questions",
    "best_design",
    "pictures",
)
"""The rooms of `limits`, in their order: each imports only rooms that stand before it. `questions`
are the files beside the rooms."""

LIBRARIES: dict[str, set[str]] = {
    "errors": {"numpy"},
    "base": {"numpy", "pandas", "tqdm", "matplotlib", "scipy.linalg"},
    "plots": {"numpy"},
    "contact": {"numpy", "pandas"},
    "reference": {"numpy", "scipy.special"},
    "solve": {"numpy", "scipy", "cvxpy", "pandas", "highspy", "clarabel"},
    "fem": {"numpy", "scipy", "skfem", "lazy_loader"},
    "readers": {"numpy", "scipy", "skfem", "pandas", "lazy_loader"},
    "scenes": {"numpy", "skfem"},
    "transients": {"numpy", "scipy", "cvxpy", "pandas", "numba", "lazy_loader", "xarray"},
    "limits": {"numpy", "scipy", "cvxpy", "pandas", "lazy_loader"},
    "study": {"numpy", "scipy", "pandas", "threadpoolctl"},
    "joints": {"numpy", "scipy", "pandas", "lazy_loader"},
    "results": set(),
    "joint_files": {"numpy", "scipy"},
    "command": {"numpy", "pandas", "threadpoolctl"},
}
"""Room -> libraries that its files may import, except libraries of drawing."""

DRAWING = {"matplotlib", "mpl_toolkits", "pandas", "skfem", "pyvista"}
DRAWS = {"pictures", "views", "draw", "style", "along", "bodies", "face"}
"""Names of the files that may import libraries of drawing. In `base` a function asks whether
matplotlib is there."""


@cache
def files() -> dict[str, Path]:
    """Dotted name -> path of each file of the package."""
    return {_dotted(path): path for path in sorted(PACKAGE.rglob("*.py"))}


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def _dotted(path: Path) -> str:
    parts = ("frictopt", *path.relative_to(PACKAGE).with_suffix("").parts)
    return ".".join(parts).removesuffix(".__init__")


def room(name: str) -> str:
    """The room in which a file stands, by its dotted name."""
    return (name.split(".") + [""])[1]


def room_in_limits(name: str) -> str:
    """The room of `limits` in which one of its files stands, by its dotted name."""
    place = name.split(".")[2]
    return place if place in IN_LIMITS else "questions"


def imports(name: str) -> Iterator[str]:
    """Dotted names that a file imports.

    They stand at its head, inside functions, in hints of types, or in `import_module`.
    """
    path = files()[name]
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    for node in ast.walk(_tree(path)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = (
                ".".join(package.split(".")[: package.count(".") + 2 - node.level])
                if node.level
                else ""
            )
            module = ".".join(part for part in (start, node.module) if part)
            yield from (_home(module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Call) and node.args and _calls_import(node.func):
            if isinstance(node.args[0], ast.Constant):
                yield str(node.args[0].value)


def _calls_import(function: ast.expr) -> bool:
    called = function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
    return called in ("import_module", "__import__")


def _home(module: str, name: str) -> str:
    """The file that defines a name that another file imports from a module.

    A room exports names of its files.
    """
    known = files()
    if f"{module}.{name}" in known:
        return f"{module}.{name}"
    path = known.get(module)
    if path is None or path.name != "__init__.py":
        return module
    for file in (path, path.with_suffix(".pyi")):
        for node in _tree(file).body if file.exists() else []:
            if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module:
                source = f"{module}.{node.module}"
                names = {alias.asname or alias.name for alias in node.names}
                if name in names or ("*" in names and _assigns(source, name)):
                    return _home(source, name)
    return module


def _assigns(module: str, name: str) -> bool:
    """Whether a file assigns a name at its top."""
    path = files().get(module)
    statements = _tree(path).body if path else []
    return any(
        isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == name for node in statements
    )


@cache
def arrows() -> dict[str, set[str]]:
    """File -> files of the package that it imports.

    The `__init__` of the package exports all names, so it does not count.
    """
    known = files()
    found = {}
    for name in known:
        if name != "frictopt":
            ours = {other for other in imports(name) if other in known}
            found[name] = ours - {name, "frictopt"}
    return found


def foreign(name: str) -> set[str]:
    """Libraries that a file imports, except the standard library, by dotted name."""
    others = (other for other in imports(name) if not other.startswith("frictopt"))
    return {other for other in others if other.split(".")[0] not in sys.stdlib_module_names}
