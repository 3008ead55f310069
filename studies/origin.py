"""The origin of a table: its sources, their commit, and the machine."""

import ast
import hashlib
import os
import platform
import subprocess
import sys
from functools import cache
from importlib.util import resolve_name
from pathlib import Path

import frictopt as fo


def machine() -> str:
    """Model and number of the processors, if the system reports them."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text(encoding="utf-8").splitlines() if cpuinfo.is_file() else []
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{models[0] if models else platform.processor() or platform.machine()}, {os.cpu_count()} cores"


def commit() -> str:
    """Last commit that changed the package, and its date; empty outside of a clone."""
    log = ["git", "log", "-1", "--format=%h of %cs", "--", "."]
    folder = Path(fo.__file__).parent
    try:
        said = subprocess.run(log, cwd=folder, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return said.stdout.strip()


def source_digest(study: str) -> str:
    """Digest of the code that makes a table.

    The code is all of frictopt, the module that computes the table, and all studies that this
    module imports.
    """
    files = {
        *Path(fo.__file__).parent.rglob("*.py"),
        *(Path(str(sys.modules[name].__file__)) for name in _imported(study, set())),
    }
    return hashlib.sha256(
        "".join(_code(path.read_text(encoding="utf-8")) for path in sorted(files)).encode()
    ).hexdigest()[:12]


def _imported(name: str, found: set[str]) -> set[str]:
    """Add a module and all studies that it imports, if the module is a study."""
    module = sys.modules.get(name)
    if module is None or name in found or name.partition(".")[0] != __package__:
        return found
    found.add(name)
    for node in ast.walk(ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            start = resolve_name("." * node.level + (node.module or ""), module.__package__)
            for other in (start, *(f"{start}.{alias.name}" for alias in node.names)):
                _imported(other, found)
    return found


@cache
def _code(source: str) -> str:
    """The syntax of a source without docstrings (and other bare texts) and comments."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [
                line
                for line in node.body
                if not (isinstance(line, ast.Expr) and isinstance(line.value, ast.Constant))
            ]
    return ast.dump(tree)
