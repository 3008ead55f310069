"""Files: those to be written, checked before anything is computed; npz archives of plain arrays, as of a contact system; and what is printed."""

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
from .parts import joined

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
    may = threading.current_thread() is threading.main_thread()  # no other one may say what signals do
    before = signal.signal(signal.SIGTERM, signal.default_int_handler) if may else None
    try:
        try:
            yield
        finally:
            if before is not None:
                signal.signal(signal.SIGTERM, before)
            sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for Python flushes once more when it ends
        raise SystemExit(141) from None


_OTHERS = {*WRITERS, *".xls .txt .json .mat .h5 .hdf5 .npy .pkl .zip .gz".split()}  # no archive stands under the name of another format
_NAMES = ("S", "points", "gap", "frames", "contact", "width", "E_star", "compliance", "units")
_FORM = "frictopt contact system 7"


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
        raise ModelError(f"path: {str(path)!r} cannot be written ({error}); give a file that ends in .npz, in a folder that exists") from error


def unpacked(source: str | Path, form: str, made: Callable[[dict[str, Any]], T], what: str, remedy: str) -> T:
    """What is made of the arrays of an archive of that form; ModelError for any other file, and for a damaged one."""
    try:
        if not Path(source).is_file():
            raise FileNotFoundError("there is no such file")
        with zipfile.ZipFile(source) as archive:
            if damaged := archive.testzip():  # every byte against its checksum: numpy reads no more of a member than its header says
                raise ValueError(f"{damaged} is damaged")
        with np.load(source, allow_pickle=False) as archive:
            arrays = dict(archive)
        if str(arrays.pop("format", "")) != form:
            raise ValueError(f"it does not hold the arrays of {what}")
        return made(arrays)
    except Exception as error:  # readers raise many kinds of error on a damaged or foreign file
        why = " ".join(str(error).split()) or type(error).__name__
        raise ModelError(f"path: {str(source)!r} is not {what} ({why}); {remedy}") from error


def write(path: str | Path, system: Any) -> None:
    """Write a contact system: its parts (None as an empty array), load cases and bonded reactions; locked bolts, shear strength where it has any."""
    plain = {name: np.array([] if (value := getattr(system, name)) is None else value) for name in _NAMES}
    bonded = [joined(*pair) for pair in system.bonded.values()]
    more = {"locked": list(system.bolts), "bolts": list(system.bolts.values())} if system.bolts else {}
    more |= {"sized": list(system.load_size), "load_size": list(system.load_size.values())} if system.load_size else {}
    more |= {"shear_strength": system.shear_strength} if system.capped else {}
    more |= {"stretch": system.stretch} if system.orthotropic else {}
    packed(path, _FORM, cases=list(system.bonded), bonded=bonded, **more, **plain)


def read(source: str | Path) -> dict[str, Any]:
    """The arguments of a contact system, from an archive."""
    return unpacked(source, _FORM, _arguments, "a contact system", "give one of `frictopt condense` or ContactSystem.save")


def _arguments(arrays: dict[str, Any]) -> dict[str, Any]:
    bolts = {name: arrays.pop(name).tolist() for name in ("locked", "bolts") if name in arrays}
    sizes = {name: arrays.pop(name).tolist() for name in ("sized", "load_size") if name in arrays}
    laws: dict[str, Any] = {name: arrays.pop(name) for name in ("shear_strength", "stretch") if name in arrays}
    if arrays.keys() != {"cases", "bonded", *_NAMES} or len(bolts) == 1 or len(sizes) == 1:
        raise ValueError("it does not hold the arrays of a contact system")
    bonded = dict(zip(arrays.pop("cases").tolist(), arrays.pop("bonded"), strict=True))
    known = {name: None if not array.size else array if array.ndim else array.item() for name, array in arrays.items()}
    named = {"bolts": dict(zip(*bolts.values(), strict=True)) if bolts else {}, "load_size": dict(zip(*sizes.values(), strict=True)) if sizes else {}}
    return {"bonded": bonded, **named, **laws, **known}
