"""Matrices in text files: columns of numbers, and the symmetric matrix of their entries."""

from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

from ..base import Array, Integers, number_of
from ..errors import ModelError
from .deck_text import text_of


def numbers_in(path: Path, what: str, separator: str, columns: int) -> list[Any]:
    """The columns of a text file without header; lines that begin with * are comments."""
    # Imported here, because reading alone needs it.
    import pandas as pd

    text = text_of(path, what)
    try:
        table = pd.read_csv(
            StringIO(text), sep=separator, header=None, comment="*", skipinitialspace=True
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError) as error:
        problem = str(error).strip()
    else:
        numeric = all(dtype.kind in "iuf" for dtype in table.dtypes)
        if table.shape[1] != columns:
            problem = f"rows of {number_of(table.shape[1], 'column')}"
        elif not numeric or table.isna().any(axis=None):
            problem = "entries that are no numbers"
        else:
            return [table[i].to_numpy() for i in range(columns)]
    raise ModelError(
        f"{what}: {str(path)!r} does not hold rows of {columns} numbers ({problem}); "
        f"{_remedy(text, columns)}"
    )


def _remedy(text: str, columns: int) -> str:
    lines = (line for line in text.splitlines() if line.strip() and not line.startswith("*"))
    first = next(lines, "")
    if columns == 5 and len(first.replace(",", " ").split()) == 3:
        return (
            "rows of 3 are Abaqus's FORMAT=COORDINATE, which does not name their nodes: "
            "write it with FORMAT=MATRIX INPUT"
        )
    if "nan" in text:
        return (
            "the code itself wrote nan, as CalculiX does for *MPC: "
            "write such a constraint as *EQUATION"
        )
    return "give the file as the code wrote it"


def symmetric(row: Integers, column: Integers, value: Array, size: int) -> csr_matrix:
    """(size, size) matrix from its entries: all entries, or the entries of one triangle."""
    finite = np.isfinite(value)
    if not finite.all():
        raise ModelError(
            f"stiffness: entry {int(np.argmin(finite)) + 1} is not finite; "
            "let the code write the matrix again"
        )
    has_one_triangle = np.any(row < column) != np.any(row > column)
    if has_one_triangle:
        off_diagonal = row != column
        mirrored_row = np.r_[row, column[off_diagonal]]
        column = np.r_[column, row[off_diagonal]]
        row = mirrored_row
        value = np.r_[value, value[off_diagonal]]
    K = csr_matrix((value, (row, column)), shape=(size, size))
    if K.nnz != len(value):
        raise ModelError("stiffness: entries are given twice; let the code write the matrix again")
    return K
