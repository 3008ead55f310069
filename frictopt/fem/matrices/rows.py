"""Rows of numbers in text files, and the symmetric matrix that they make."""

from collections.abc import Callable
from importlib import import_module
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from ...contact.checks import Array
from ...errors import ModelError
from ..ordering import Integers
from .blocks import text_of


def numbers_in(path: Path, what: str, separator: str, columns: int) -> Any:
    """The columns of a text file without header, as a list of `columns` arrays; lines that begin with * are comments.

    Raises
    ------
    ModelError
        The file is missing or empty, or its rows are not `columns` numbers.
    """
    import pandas as pd  # here, for reading is all that it serves

    text = text_of(path, what)
    try:
        table = pd.read_csv(StringIO(text), sep=separator, header=None, comment="*", skipinitialspace=True)
        found = table.shape[1]
        if found == columns and all(kind.kind in "iuf" for kind in table.dtypes) and not table.isna().any(axis=None):
            return [table[i].to_numpy() for i in range(columns)]
        problem = f"rows of {found} columns" if found != columns else "entries that are no numbers"
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError) as error:
        problem = str(error).strip()
    raise ModelError(f"{what}: {str(path)!r} does not hold rows of {columns} numbers ({problem}); {_remedy(text, columns)}")


def _remedy(text: str, columns: int) -> str:
    lines = [line for line in text.splitlines()[:100] if line.strip() and not line.startswith("*")]
    if columns == 5 and lines and len(lines[0].replace(",", " ").split()) == 3:
        return "rows of 3 are Abaqus's FORMAT=COORDINATE, which does not say which nodes they belong to: write it with FORMAT=MATRIX INPUT"
    if "nan" in text:
        return "the code itself wrote nan, as CalculiX does for *MPC: write such a constraint as *EQUATION"
    return "give the file as the code wrote it"


def symmetric(what: str, row: Integers, column: Integers, value: Array, size: int) -> csr_matrix:
    """(size, size) matrix from its entries: those of one triangle, which the other one mirrors, or all of them.

    Raises
    ------
    ModelError
        An entry given twice or not finite.
    """
    if not np.isfinite(value).all():
        raise ModelError(f"{what}: entry {int(np.argmin(np.isfinite(value))) + 1} is not finite; let the code write the matrix again")
    if np.any(row < column) != np.any(row > column):
        off = row != column
        row, column, value = np.r_[row, column[off]], np.r_[column, row[off]], np.r_[value, value[off]]
    K = csr_matrix((value, (row, column)), shape=(size, size))
    if K.nnz != len(value):
        raise ModelError(f"{what}: entries are given twice; let the code write the matrix again")
    return K


def library(module: str, name: str, extra: str) -> Any:
    """A module of a library, which is installed by its name or by an extra of ours."""
    try:
        return import_module(module)
    except ImportError as error:
        raise ModelError(f"{name}: not installed; install frictopt with its extra `{extra}`") from error


def by_library(name: str, read: Callable[[str], Any], file: Path, what: str) -> Any:
    """What a library reads from a file.

    Raises
    ------
    ModelError
        The file is missing, or the library cannot read it.
    """
    if not file.is_file():
        raise ModelError(f"{what}: there is no file {str(file)!r}; give its path")
    try:
        return read(str(file))
    except Exception as error:  # libraries let through whatever a damaged file makes
        problem = str(error).strip() or type(error).__name__
        raise ModelError(f"{what}: {name} cannot read {str(file)!r} ({problem}); give the file as the code wrote it") from error
