"""Names of files to be written, checked before anything is computed; npz archives of arrays."""

import os
import signal
import sys
import threading
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..errors import ModelError

T = TypeVar("T")

WRITERS = {".csv": "to_csv", ".xlsx": "to_excel", ".parquet": "to_parquet"}
"""Ending of the file of a table -> the method of pandas that writes it."""


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
    *WRITERS,
    *".xls .txt .json .mat .h5 .hdf5 .npy .pkl .zip .gz".split(),
}


def packed(path: str | Path, form: str, **arrays: Any) -> None:
    """Write an npz archive of plain arrays under exactly this name, with the name of its form."""
    try:
        if Path(path).suffix.lower() in _OTHER_FORMATS:
            raise ValueError("it is an npz archive")
        if Path(path).exists() and not Path(path).is_file():
            raise OSError("it is a folder or a device")
        with Path(path).open("wb") as file:
            np.savez(file, allow_pickle=False, format=form, **arrays)
    except (OSError, TypeError, ValueError) as error:
        raise ModelError(
            f"path: {str(path)!r} cannot be written ({error}); "
            "give a file that ends in .npz, in a folder that exists"
        ) from error


def unpacked(
    source: str | Path, form: str, made: Callable[[dict[str, Any]], T], what: str, remedy: str
) -> T:
    """Read an archive of this form, and return the value that `made` builds from its arrays.

    Any other file, and a damaged one, is a ModelError.
    """
    try:
        if not Path(source).is_file():
            raise FileNotFoundError("there is no such file")
        with zipfile.ZipFile(source) as archive:
            # Check all bytes against their checksums; numpy reads a member only as far as its
            # header says.
            damaged = archive.testzip()
            if damaged:
                raise ValueError(f"{damaged} is damaged")
        with np.load(source, allow_pickle=False) as archive:
            arrays = dict(archive)
        if str(arrays.pop("format", "")) != form:
            raise ValueError(f"it does not hold the arrays of {what}")
        return made(arrays)
    except Exception as error:  # readers raise many kinds of error on a damaged or foreign file
        why = " ".join(str(error).split()) or type(error).__name__
        raise ModelError(f"path: {str(source)!r} is not {what} ({why}); {remedy}") from error
