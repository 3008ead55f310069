"""Files of a contact system: npz archives with a digest of their content."""

import hashlib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ModelError
from .checks import shown
from .parts import joined

_NAMES = ("S", "points", "gap", "frames", "contact", "width", "E_star", "compliance", "units")
_FORM = "frictopt contact system 6"


def values(system: Any) -> dict[str, Any]:
    """The parts of a contact system, but for its load cases."""
    return {name: getattr(system, name) for name in _NAMES}


def write(path: str | Path, system: Any) -> None:
    """Write a contact system to an npz archive under exactly this name: its parts (None as an empty array), load cases and bonded reactions."""
    plain = {name: np.array([] if value is None else value) for name, value in values(system).items()}
    bonded = [joined(*pair) for pair in system.bonded.values()]
    arrays = {"format": np.array(_FORM), **plain, "cases": np.array(list(system.bonded)), "bonded": np.array(bonded)}
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise OSError("it is a folder or a device")
        with Path(path).open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays, digest=_digest(arrays))
    except (OSError, TypeError, ValueError) as error:
        raise ModelError(f"path: {shown(path)} cannot be written ({error}); give the name of a file in a folder that exists") from error


def read(source: str | Path) -> dict[str, Any]:
    """The arguments of a contact system, from an archive."""
    arrays = _read_archive(source)
    cases, bonded = arrays.pop("cases").tolist(), arrays.pop("bonded")
    known = {name: None if not array.size else array if array.ndim else array.item() for name, array in arrays.items()}
    return {**known, "bonded": dict(zip(cases, bonded, strict=True))}


def _digest(arrays: Mapping[str, np.ndarray]) -> np.ndarray:
    """SHA-256 of names, types, shapes and bytes."""
    digest = hashlib.sha256()
    for name, array in arrays.items():
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        digest.update(array.tobytes())
    return np.frombuffer(digest.digest(), dtype=np.uint8)


def _read_archive(source: str | Path) -> dict[str, np.ndarray]:
    """The arrays of an archive by their names: the parts of a system, its load cases, and their bonded reactions, one row each."""
    members = ("format", *_NAMES, "cases", "bonded", "digest")
    try:
        path = Path(source)
        if not path.is_file():
            raise ValueError("there is no such file")
        with zipfile.ZipFile(path) as archive:
            files = {f"{name}.npy" for name in members}
            if {info.filename for info in archive.infolist()} != files or len(archive.infolist()) != len(files):
                raise ValueError("it does not hold the arrays of a contact system")
            if any(info.compress_type != zipfile.ZIP_STORED for info in archive.infolist()):  # a stored member is not larger than its file
                raise ValueError("it is compressed")
            arrays = {name: _member(archive, name) for name in members}
        if not np.array_equal(arrays.pop("digest"), _digest(arrays)) or str(arrays.pop("format")) != _FORM:
            raise ValueError("its content has changed since it was saved")
        if len(arrays["bonded"]) != len(arrays["cases"].tolist()):
            raise ValueError("its load cases are not complete")
        return arrays
    except Exception as error:  # readers raise many kinds of error on a damaged or foreign file
        raise ModelError(f"path: {str(source)!r} is not a contact system ({shown(error)}); give a file as its save writes it") from error


def _member(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    """Read one array; its size is that of the bytes in the archive, whatever the header says."""
    with archive.open(f"{name}.npy") as file:
        np.lib.format.read_magic(file)
        shape, fortran, dtype = np.lib.format.read_array_header_1_0(file)
        return np.frombuffer(file.read(), dtype).reshape(shape, order="F" if fortran else "C")
