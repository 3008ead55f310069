"""Libraries that read files of other codes, and what they cannot read."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import ModelError
from .checks import shown


def library(module: str = "meshio", name: str = "meshio", extra: str = "mesh") -> Any:
    """Import a module of a library; if it is missing, the error names the extra to install."""
    try:
        return import_module(module)
    except ImportError as error:
        raise ModelError(
            f"{name}: not installed; python -m pip install 'frictopt[{extra}]'"
        ) from error


def by_library(
    name: str,
    read: Callable[[str], Any],
    file: Path,
    what: str,
    remedy: str = "give the file as the code wrote it",
) -> Any:
    """Read a file with a library, and return its result."""
    if not file.is_file():
        raise ModelError(f"{what}: there is no file {str(file)!r}; give its path")
    try:
        return read(str(file))
    except ImportError as error:  # a format may need one more library
        raise ModelError(
            f"{what}: {name} needs {error.name} for {str(file)!r}; "
            f"python -m pip install {error.name}"
        ) from error
    # A damaged file makes libraries raise any kind of error; meshio even raises SystemExit.
    except (Exception, SystemExit) as error:
        problem = str(error).strip() or type(error).__name__
        raise ModelError(
            f"{what}: {name} cannot read {str(file)!r} ({problem}); {remedy}"
        ) from error


def file_path(argument: str, path: str | Path) -> Path:
    """Check the path of a file, and return it as a `Path`."""
    if not isinstance(path, str | Path) or not str(path):
        raise ModelError(f"{argument}: {shown(path)}; give the path of a file")
    return Path(path)
