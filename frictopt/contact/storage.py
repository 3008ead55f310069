"""Files of a contact system: npz archives without pickle, and Matrix Market folders written by other codes."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ..errors import ModelError
from .checks import Array, real_array

__all__ = ["NAMES", "read", "write_npz"]

NAMES = ("A", "B", "C", "x", "gap", "E_star")
_FORMAT = "frictopt contact system 1"
_Content = tuple[dict[str, Array], float | None, dict[str, tuple[Array, Array]]]


def write_npz(path: str | Path, arrays: Mapping[str, Array], bonded: Mapping[str, tuple[Array, Array]]) -> None:
    """Write the arrays and the bonded reactions (each an (N, 2) array of columns q, p) to `path`, exactly under that name."""
    cases = {f"bonded.{name}": np.column_stack(pair) for name, pair in bonded.items()}
    try:
        with Path(path).open("wb") as file:
            np.savez(file, allow_pickle=False, format=np.array(_FORMAT), **arrays, **cases)
    except (OSError, TypeError, ValueError) as error:
        raise ModelError(f"path: {path!r} cannot be written ({error}); give the name of a file in a folder that exists") from error


def read(source: str | Path) -> _Content:
    """Read an npz archive or a folder of Matrix Market files: arrays by name, contact modulus if known, and bonded reactions by load case."""
    try:
        path = Path(source)
        exists = path.exists()
    except (OSError, TypeError, ValueError) as error:
        raise ModelError(f"path: {source!r} is not the name of a file or folder ({error})") from error
    if not exists:
        raise ModelError(f"path: {str(path)!r} does not exist; give an npz archive of ContactSystem.save or a folder of Matrix Market files")
    if path.is_dir():
        found = {file.stem: _read_matrix_market(file) for file in sorted(path.glob("*.mtx"))}
    else:
        found = _read_npz(path)
    unknown = [name for name in found if name not in NAMES and not name.startswith("bonded.")]
    if unknown:
        raise ModelError(f"path: {str(path)!r} holds {', '.join(unknown)}, which mean nothing here; load cases are called bonded.NAME")
    missing = [name for name in NAMES if name not in found and name not in ("gap", "E_star")]
    if missing:
        raise ModelError(f"path: {str(path)!r} has no {', '.join(missing)}; it needs A, B, C and x, and one bonded.NAME for each load case")
    modulus = found.pop("E_star", None)
    if modulus is not None:
        modulus = real_array(f"path: E_star of {str(path)!r}", modulus)
        if modulus.size != 1:
            raise ModelError(f"path: E_star of {str(path)!r} has shape {modulus.shape}; give one number")
    arrays = {name: found[name] for name in NAMES if name in found}
    for name in ("x", "gap"):
        if name in arrays and arrays[name].ndim == 2 and 1 in arrays[name].shape:
            arrays[name] = arrays[name].ravel()
    bonded = {}
    for name, columns in found.items():
        if name.startswith("bonded."):
            if columns.ndim != 2 or columns.shape[1] != 2:
                raise ModelError(f"path: {name} of {str(path)!r} has shape {columns.shape}; give (N, 2), the columns q and p")
            bonded[name.removeprefix("bonded.")] = (columns[:, 0], columns[:, 1])
    return arrays, None if modulus is None else float(modulus.item()), bonded


def _read_npz(path: Path) -> dict[str, Array]:
    foreign = f"path: {str(path)!r} is not a contact system; give an archive written by ContactSystem.save"
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            found = {name: archive[name] for name in archive.files}
    except (OSError, ValueError, EOFError, KeyError, TypeError, AttributeError, NotImplementedError, RuntimeError, zipfile.BadZipFile) as error:
        raise ModelError(foreign) from error
    if str(found.pop("format", "")) != _FORMAT:
        raise ModelError(foreign)
    return found


def _read_matrix_market(path: Path) -> Array:
    from scipy.io import mmread  # the one format that needs more than numpy

    try:
        matrix = mmread(path)
        return np.asarray(matrix if isinstance(matrix, np.ndarray) else matrix.toarray())
    except (OSError, ValueError, OverflowError, MemoryError) as error:
        raise ModelError(f"path: {str(path)!r} is not a Matrix Market file that fits in memory ({error}); write it anew") from error
