"""Files: those to be written, checked before anything is computed; and npz archives of plain arrays."""

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
    """A file to be written, in a folder that exists, with one of these endings (of none: any); else a ModelError."""
    file = Path(name)
    if endings and file.suffix not in endings:
        raise ModelError(f"{str(name)!r}; give a file that ends in {', '.join(endings)}")
    if not file.absolute().parent.is_dir():
        raise ModelError(f"{str(name)!r} is in no folder that exists; make it")
    return file


@contextmanager
def to_its_end() -> Iterator[None]:
    """Write what a command prints as it ends (status 141 where nobody reads it, `| head`); SIGTERM interrupts it, or workers would outlive it."""
    may = (
        threading.current_thread() is threading.main_thread()
    )  # no other one may say what signals do
    before = signal.signal(signal.SIGTERM, signal.default_int_handler) if may else None
    try:
        try:
            yield
        finally:
            if before is not None:
                signal.signal(signal.SIGTERM, before)
            sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(
            os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno()
        )  # for Python flushes once more when it ends
        raise SystemExit(141) from None


_OTHERS = {
    *WRITERS,
    *".xls .txt .json .mat .h5 .hdf5 .npy .pkl .zip .gz".split(),
}  # no archive stands under the name of another format


def packed(path: str | Path, form: str, **arrays: Any) -> None:
    """Write an npz archive of plain arrays under exactly this name, with the name of what it holds."""
    try:
        if Path(path).suffix.lower() in _OTHERS:
            raise ValueError("it is an npz archive")
        if Path(path).exists() and not Path(path).is_file():
            raise OSError("it is a folder or a device")
        with Path(path).open("wb") as file:
            np.savez(file, allow_pickle=False, format=form, **arrays)
    except (OSError, TypeError, ValueError) as error:
        raise ModelError(
            f"path: {str(path)!r} cannot be written ({error}); give a file that ends in .npz, in a folder that exists"
        ) from error


def unpacked(
    source: str | Path, form: str, made: Callable[[dict[str, Any]], T], what: str, remedy: str
) -> T:
    """What is made of the arrays of an archive of that form; ModelError for any other file, and for a damaged one."""
    try:
        if not Path(source).is_file():
            raise FileNotFoundError("there is no such file")
        with zipfile.ZipFile(source) as archive:
            if (
                damaged := archive.testzip()
                # every byte against its checksum: numpy reads no more of a member than its header says
            ):
                raise ValueError(f"{damaged} is damaged")
        with np.load(source, allow_pickle=False) as archive:
            arrays = dict(archive)
        if str(arrays.pop("format", "")) != form:
            raise ValueError(f"it does not hold the arrays of {what}")
        return made(arrays)
    except Exception as error:  # readers raise many kinds of error on a damaged or foreign file
        why = " ".join(str(error).split()) or type(error).__name__
        raise ModelError(f"path: {str(source)!r} is not {what} ({why}); {remedy}") from error
