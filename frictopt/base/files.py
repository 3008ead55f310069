"""Files: npz archives and JSON, and the libraries that read files of other codes.

The names of files to be written are checked before anything is computed.
"""

import json
import math
import os
import shutil
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from datetime import UTC, datetime
from enum import Enum
from importlib import import_module
from importlib.util import find_spec
from io import BytesIO
from itertools import chain
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from zipfile import ZipFile
from zlib import crc32

import numpy as np
from numpy.lib.format import (
    read_array_header_1_0,
    read_array_header_2_0,
    read_magic,
    write_array,
)

from ..errors import FrictoptError, ModelError
from .checks import T, is_distribution, shown

TABLES = (".csv", ".xlsx", ".parquet")
"""Endings of the file of a table."""

KINDS: dict[str, Any] = {}
"""Name -> class, for all values in a file of a result other than numbers, texts and tables."""


def kept(kind: type[T]) -> type[T]:
    """Register a class whose values are kept in files of results, by the names of its fields.

    A class may have three attributes for its files. `KEPT_FIELDS` are the fields that a file holds,
    if the other fields follow from them. `from_kept` then makes a value from a mapping of the kept
    fields. `check_kept` checks a value that was read from a file, and raises a ValueError if
    something is wrong.
    """
    KINDS[kind.__name__] = kind
    return kind


def output(name: str | Path, *endings: str) -> Path:
    """Check a file to be written: a ModelError unless its folder exists and its ending is listed.

    Without `endings` any ending will do.
    """
    file = Path(name)
    if endings and file.suffix not in endings:
        raise ModelError(f"{str(name)!r}; give a file that ends in {', '.join(endings)}")
    if not file.absolute().parent.is_dir():
        raise ModelError(f"{str(name)!r} is in a folder that does not exist; make the folder")
    return file


@contextmanager
def written(path: str | Path, ending: str) -> Iterator[Path]:
    """Give the path of a file in a temporary folder; once it is complete, it is moved to `path`.

    All files that are written beside it, such as the parts of a format of several files, are moved,
    too. If the disk is full or the process is killed, earlier files stay as they were.

    Raises
    ------
    ModelError
        The file cannot be written.
    """
    try:
        # A link stays, and the file that it leads to is replaced.
        place = Path(path).resolve()
        if place.exists() and not place.is_file():
            raise OSError("it is a folder or a device")
        with TemporaryDirectory(dir=place.parent, prefix=".frictopt-") as folder:
            yield Path(folder, place.name)
            parts = sorted(part for part in Path(folder).rglob("*") if part.is_file())
            for part in parts:
                with part.open("rb+") as file:
                    os.fsync(file.fileno())
            for part in parts:
                target = place.parent / part.relative_to(folder)
                target.parent.mkdir(parents=True, exist_ok=True)
                if target.exists():
                    shutil.copymode(target, part)
                part.replace(target)
    except FrictoptError:
        raise
    except (OSError, TypeError, ValueError) as error:
        raise ModelError(
            f"path: {str(path)!r} cannot be written ({error}); give a file that ends in {ending}, "
            "in a folder that exists, on a disk with space"
        ) from error


def write_table(path: str | Path, table: Any) -> None:
    """Write a DataFrame in the format of the ending of its file, one of `TABLES`."""
    ending = Path(path).suffix
    with written(path, ending) as file:
        if ending == ".xlsx":
            write_sheets(file, {"Sheet1": table})
        else:
            {".csv": table.to_csv, ".parquet": table.to_parquet}[ending](file, index=False)


def write_sheets(file: Path, tables: Mapping[str, Any]) -> None:
    """Write each DataFrame to a sheet of a workbook. Texts that begin with "=" stay texts.

    Raises
    ------
    ImportError
        openpyxl is not installed (extra `xlsx`).
    """
    import pandas as pd  # imported here, because only tables need it

    if find_spec("openpyxl") is None:
        raise ImportError("files in .xlsx need openpyxl: python -m pip install 'frictopt[xlsx]'")
    # The workbook is made in memory: if it could not be written to the disk, its file would stay
    # open.
    whole = BytesIO()
    with pd.ExcelWriter(whole, engine="openpyxl") as writer:
        for name, table in tables.items():
            table.to_excel(writer, sheet_name=name, index=False)
        for cell in chain.from_iterable(row for sheet in writer.book for row in sheet):
            if cell.data_type == "f":
                cell.data_type = "s"
    file.write_bytes(whole.getvalue())


@contextmanager
def to_its_end() -> Iterator[None]:
    """Flush the output of a command at its end, and treat SIGTERM as an interrupt.

    The interrupt also stops workers. If the reader has closed the pipe (`| head`), exit with status
    141.
    """
    # Only the main thread may set signal handlers.
    is_main = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGTERM, signal.default_int_handler) if is_main else None
    try:
        try:
            yield
        finally:
            if before is not None:
                signal.signal(signal.SIGTERM, before)
            sys.stdout.flush()
    except BrokenPipeError:
        # Python flushes once more when it ends, which must not fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(141) from None


# Endings of other formats, under which no archive is written.
_OTHER_FORMATS = {
    *TABLES,
    *".xls .txt .json .mat .h5 .hdf5 .npy .pkl .zip .gz".split(),
}


def written_by() -> dict[str, str]:
    """The version of frictopt that writes a file now, and the date."""
    # Imported here, because the package imports this file before it has a version.
    from .. import __version__

    return {"version": __version__, "date": datetime.now(UTC).isoformat(timespec="seconds")}


def packed(path: str | Path, form: str, **arrays: Any) -> None:
    """Write an npz archive of plain arrays under exactly this name, with the name of its form.

    The archive also holds the version of frictopt that wrote it, and the date.
    """
    with written(path, ".npz") as part:
        if part.suffix.lower() in _OTHER_FORMATS:
            raise ValueError("it is an npz archive")
        # If the disk is full, `np.savez` would leave its file open.
        with ZipFile(part, "w") as archive:

            def add(name: str, array: object) -> None:
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    write_array(member, np.asarray(array), allow_pickle=False)

            for name, array in {"format": form, **written_by(), **arrays}.items():
                add(name, array)
            add("seal", _seal(archive))


def _seal(archive: ZipFile) -> int:
    """A checksum of the names and checksums of all members before the seal."""
    members = {member.filename: member.CRC for member in archive.infolist()}
    members.pop("seal.npy", None)
    return crc32(repr(sorted(members.items())).encode())


def unpacked(
    source: str | Path,
    form: str,
    made: Callable[[dict[str, Any]], T],
    what: str,
    remedy: str,
    *,
    any_version: bool,
) -> T:
    """Read an archive of this form, and return the value that `made` builds from its arrays.

    ModelError for any other file, for a damaged file and, unless `any_version`, for a file of
    another version of frictopt.
    """
    try:
        if not Path(source).is_file():
            raise FileNotFoundError("there is no such file")
        with ZipFile(source) as archive:
            _check_members(archive)
            seal = _seal(archive)
        with np.load(source, allow_pickle=False) as archive:
            arrays = dict(archive)
        if str(arrays.pop("format", "")) != form:
            raise ValueError(f"it does not hold the arrays of {what}")
        # Files of earlier versions have no seal, version or date.
        if arrays.pop("seal", seal) != seal:
            raise ValueError("it was changed after it was written")
        version = str(arrays.pop("version", "before 0.3.0"))
        arrays.pop("date", None)
        if not any_version and version != written_by()["version"]:
            raise ValueError(f"version {version} of frictopt wrote it; compute the result again")
        return made(arrays)
    except Exception as error:  # readers raise many kinds of error on a damaged or foreign file
        why = " ".join(str(error).split()) or type(error).__name__
        raise ModelError(f"path: {str(source)!r} is not {what} ({why}); {remedy}") from error


def _check_members(archive: ZipFile) -> None:
    """Check names and sizes of all members; numpy would trust the header of an array.

    `zipfile` compares the checksums when it reads the members.

    Raises
    ------
    ValueError
        The archive is damaged, or its few bytes would fill the memory.
    """
    members = archive.infolist()
    if len({member.filename for member in members}) < len(members):
        raise ValueError("two of its members have one name")
    size = sum(member.file_size for member in members)
    # Compression makes the arrays of a contact a few times smaller, and sparse arrays tens of
    # times.
    most = 100_000_000 + 100 * sum(member.compress_size for member in members)
    if size > most:
        raise ValueError(f"it would grow to {size:.1e} bytes; save it without compression")
    for member in members:
        with archive.open(member) as file:
            header = read_array_header_1_0 if read_magic(file) == (1, 0) else read_array_header_2_0
            shape, _, kind = header(file)
            if file.tell() + prod(shape) * kind.itemsize != member.file_size:
                raise ValueError(f"{member.filename} is damaged")


# Values as strict JSON: a number that is not known (nan) is null, an infinite one is a text.


def strict_json(value: object) -> str:
    """A value as strict JSON, see `plain`."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False)


def plain(value: Any) -> Any:
    """A value in the types of JSON: nan is None, infinity is "inf", a table is a list of its rows.

    An Enum member becomes its name, and a dataclass a mapping of its public fields.
    """
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        if math.isnan(value):
            return None
        return float(value) if math.isfinite(value) else f"{value}"
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, tuple | list | range):
        return [plain(part) for part in value]
    return _plain_of_object(value)


def _plain_of_object(value: Any) -> Any:
    """A dataclass, or a value of numpy or pandas, in the types of JSON."""
    if is_dataclass(value):
        names = [field.name for field in fields(value) if not field.name.startswith("_")]
        return {name: plain(getattr(value, name)) for name in names}
    if hasattr(value, "to_dict") and hasattr(value, "columns"):
        return [plain(row) for row in value.to_dict("records")]
    if is_distribution(value):
        return {"distribution": value.dist.name, "parameters": plain(value.args), **value.kwds}
    if hasattr(value, "tolist"):  # an array, or a number of numpy
        return plain(value.tolist())
    import pandas as pd

    return None if value is pd.NA else str(value)


def sealed(content: Mapping[str, Any]) -> str:
    """A content as strict JSON with version, date and a checksum, which `unsealed` checks."""
    whole = plain({**content, **written_by()})
    return strict_json({**whole, "seal": crc32(strict_json(whole).encode())})


def unsealed(path: str | Path) -> dict[str, Any]:
    """The content of a file of JSON that `sealed` made; ModelError for a changed or other file."""
    try:
        content: dict[str, Any] = json.loads(Path(path).read_text(encoding="utf-8"))
        seal = content.pop("seal")
    except (OSError, ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise ModelError(
            f"path: {str(path)!r} is not a report with version and date ({type(error).__name__}); "
            "give a file that `save` of a report wrote"
        ) from error
    if crc32(strict_json(content).encode()) != seal:
        raise ModelError(f"path: {str(path)!r} was changed after it was written; write it anew")
    return content


def origin(path: str | Path) -> str:
    """Which version of frictopt wrote an archive, and when; earlier versions do not say."""
    with np.load(path, allow_pickle=False) as archive:
        if "version" not in archive:
            return "of an earlier version"
        return f"of version {archive['version']}, {archive['date']}"


# Files of other codes, which libraries read.


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
