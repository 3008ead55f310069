"""Files of a contact system: npz archives with a digest of their content, and folders of Matrix Market files from other codes."""

import hashlib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import ModelError
from .checks import Array, finite_array, shown
from .parts import joined

_NAMES = ("S", "points", "gap", "frames", "contact", "width", "E_star", "compliance", "units")
_BLOCKS = ("A", "B", "C", "x")  # of a folder
_OPTIONAL = ("gap", "width")  # files of N rows in a folder
_FORM = "frictopt contact system 6"
_MOST_NODES = 20_000  # in a folder: S then takes 13 GB, which a short damaged file could ask for


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


def is_folder(source: str | Path) -> bool:
    """Whether a name is that of a folder; otherwise it has to be that of a file."""
    try:
        path = Path(source)
        exists = path.exists()
    except (OSError, TypeError, ValueError) as error:
        raise ModelError(f"path: {shown(source)} is not the name of a file or folder ({error})") from error
    if not exists:
        raise ModelError(f"path: {str(path)!r} does not exist; give an archive of ContactSystem.save or a folder of Matrix Market files")
    return path.is_dir()


def read(source: str | Path) -> dict[str, Any]:
    """The arguments of a contact system, from an archive."""
    arrays = _read_archive(source)
    cases, bonded = arrays.pop("cases").tolist(), arrays.pop("bonded")
    modulus, units = arrays.pop("E_star"), arrays.pop("units")
    known = {name: array if array.size else None for name, array in arrays.items()}
    known |= {name: array.item() if array.size else None for name, array in (("E_star", modulus), ("units", units))}
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
            raise ValueError("it is no regular file")
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


def read_folder(source: str | Path) -> dict[str, Any]:
    """The arguments of `ContactSystem.from_blocks`, from a folder of Matrix Market files."""
    path = Path(source)
    files = {file.stem: file for file in sorted(path.glob("*.mtx"))}
    plain = {*_BLOCKS, "E_star", *_OPTIONAL}
    unknown = [name for name in files if name not in plain and not name.startswith("bonded.")]
    if unknown:
        raise ModelError(f"path: {str(path)!r} holds the unknown files {', '.join(unknown)}; remove them, or call load cases bonded.NAME")
    missing = [name for name in _BLOCKS if name not in files]
    if missing:
        raise ModelError(f"path: {str(path)!r} has no {', '.join(missing)}; it needs A, B, C and x, and one bonded.NAME for each load case")
    x = _read_matrix_market(files["x"], (None, 1))
    n = len(x)
    shapes = {"x": (n, 1), "E_star": (1, 1), **dict.fromkeys("ABC", (n, n)), **dict.fromkeys(_OPTIONAL, (n, 1))}
    found = {name: _read_matrix_market(file, shapes.get(name, (n, 2))) for name, file in files.items()}
    bonded = {name.removeprefix("bonded."): tuple(found.pop(name).T) for name in list(found) if name not in plain}
    columns = {name: values.ravel() if values.shape == (n, 1) and name not in "ABC" else values for name, values in found.items()}
    modulus = columns.pop("E_star", None)
    return {**columns, "E_star": None if modulus is None else modulus.item(), "bonded": bonded}


def _read_matrix_market(path: Path, shape: tuple[int | None, int]) -> Array:
    """Read a matrix of real numbers of that shape (None: any number of rows up to the most).

    The reader of scipy is not used, because it crashes the process on some damaged files.
    """
    try:
        if not path.is_file():
            raise OSError("it is no regular file")
        with path.open(encoding="utf-8") as file:
            head = file.readline().lower().split()
            sizes = [int(size) for size in next((line for line in file if line.strip() and not line.startswith("%")), "").split()]
            rows = shape[0] or min(sizes[0], _MOST_NODES)
            if sizes[:2] != [rows, shape[1]]:
                raise ValueError(f"size {sizes}, expected {shape[0] or f'at most {_MOST_NODES}'} x {shape[1]}")
            return finite_array("entries", _matrix(head, sizes, np.array(file.read().split(), dtype=np.float64)), shape)
    except (OSError, ValueError, IndexError, MemoryError, ModelError) as error:
        raise ModelError(f"path: {str(path)!r} is not a valid Matrix Market file ({error}); write it again") from error


def _matrix(head: list[str], sizes: list[int], numbers: Array) -> Array:
    """The matrix from the first line, the sizes and the numbers of a Matrix Market file."""
    rows, columns = sizes[:2]
    match head:
        case ["%%matrixmarket", "matrix", "array" | "coordinate" as form, "real" | "double" | "integer", "general" | "symmetric" as symmetry]:
            given = np.zeros((rows, columns))
        case _:
            raise ValueError(f"{' '.join(head)!r}: it must be array or coordinate, real or integer, general or symmetric")
    if symmetry == "symmetric" and rows != columns:
        raise ValueError("a symmetric matrix is square")
    if form == "coordinate":
        entries = numbers.reshape(sizes[2], 3)
        if not (np.isin(entries[:, 0], np.arange(1, rows + 1)) & np.isin(entries[:, 1], np.arange(1, columns + 1))).all():
            raise ValueError("an entry lies outside the matrix")
        np.add.at(given, tuple(entries[:, :2].T.astype(np.intp) - 1), entries[:, 2])
    elif symmetry == "general":
        return numbers.reshape(columns, rows).T
    else:
        given[np.triu_indices(rows)[::-1]] = numbers.reshape(rows * (rows + 1) // 2)  # the lower triangle, column by column
    if symmetry == "general":
        return given
    if np.triu(given, 1).any():
        raise ValueError("a symmetric matrix lists its lower triangle")
    return given + np.tril(given, -1).T
