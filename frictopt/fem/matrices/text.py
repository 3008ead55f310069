"""Text files of other codes: the blocks of a deck, rows of numbers, and the symmetric matrix that they make."""

import re
from collections.abc import Iterator, Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from scipy.sparse import csr_matrix

from ...contact import Array, Integers
from ...errors import ModelError
from .kinds import node_count

Block: TypeAlias = tuple[str, dict[str, str], list[str]]  # keyword and names of parameters without blanks, data lines
FLAT = "write a flat deck, all where it is (Abaqus/CAE: Model, Edit Attributes, do not use parts and assemblies in input files)"
_MAKING = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"}  # nodes and elements that the deck does not list


def blocks(path: Path) -> Iterator[Block]:
    """The blocks of a deck and of the files that it includes, in order; all in capitals, but for data lines."""
    lines = list(_lines(path))
    starts = [i for i, line in enumerate(lines) if line.startswith("*")]
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        head, first = lines[start][1:], start + 1
        while head.endswith(",") and first < end and _continues(lines[first]):
            head, first = head + lines[first], first + 1
        keyword, *rest = (part.strip() for part in head.split(","))
        pairs = [(_joined(name), value.strip().strip('"')) for name, _, value in (part.partition("=") for part in rest if part)]
        yield _joined(keyword), {name: value.upper() for name, value in pairs}, lines[first:end]


def check_listed(path: Path, keyword: str, options: Mapping[str, str], lines: Sequence[str]) -> None:
    """Check that a block gives nodes and displacements in the global directions, and all that it makes in the deck itself.

    Raises
    ------
    ModelError
        It does not.
    """
    start = f"deck {path.name}: the block *{keyword} {parameters(options)}".rstrip()
    if (keyword in ("SYSTEM", "TRANSFORM") and lines) or (keyword == "NODE" and options.get("SYSTEM", "R") != "R"):
        raise ModelError(
            f"{start} gives nodes or displacements in directions of their own; write coordinates, and the matrix, in the global directions"
        )
    moved = keyword == "INSTANCE" and re.search("[1-9]", "".join(lines))
    if moved or keyword in _MAKING or (keyword in ("NODE", "ELEMENT") and "INPUT" in options):
        raise ModelError(f"{start} makes or moves nodes or elements that are not listed; {FLAT}")


def _lines(path: Path, depth: int = 0) -> Iterator[str]:
    """The lines of a deck that are no comments, those of a file that it includes in the place of *INCLUDE: it may go on with the block before."""
    if depth > 20:
        raise ModelError(f"deck {path.name}: it includes itself; take the *INCLUDE out")
    lines = (line for line in map(str.strip, text_of(path, "deck").splitlines()) if line and not line.startswith("**"))
    for line in lines:
        if _joined(line.split(",")[0]) == "*INCLUDE":
            given = (line if "=" in line else next(lines, "")).split(",")
            files = [file.strip(' "') for name, _, file in (part.partition("=") for part in given) if _joined(name) == "INPUT"]
            yield from _lines(path.parent / (files or [""])[0], depth + 1)
        else:
            yield line


def _continues(line: str) -> bool:
    """Whether a line after a comma goes on with parameters: Abaqus continues keyword lines so, CalculiX takes a last comma for nothing."""
    return "=" in line or line.split(",")[0].strip().upper() == "GENERATE"


def _joined(words: str) -> str:
    return "".join(words.split()).upper()


def text_of(path: Path, what: str) -> str:
    """Text of a file, without a byte-order mark.

    Raises
    ------
    ModelError
        It cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8-sig", errors="replace")
    except (OSError, ValueError) as error:
        raise ModelError(f"{what}: {str(path)!r} cannot be read ({error}); give the path of a file") from error


def entries(line: str) -> list[str]:
    """The entries of a data line, empty ones too."""
    return [entry.strip().strip('"') for entry in line.split(",")]


def fields(line: str) -> list[str]:
    """The entries of a data line that are not empty."""
    return [entry for entry in entries(line) if entry]


def number(field: str) -> float:
    """The value of an entry, with an exponent of E or D."""
    return float(field.upper().replace("D", "E"))


def parameters(options: Mapping[str, str]) -> str:
    """Parameters as a deck has them."""
    return ", ".join(f"{name}={value}" if value else name for name, value in options.items())


def thickness(lines: list[str]) -> float:
    """The first entry of a section, which plane elements take as their thickness."""
    try:
        return number((fields(lines[0]) or ["1"])[0]) if lines else 1.0
    except ValueError:
        return np.nan


def members_of(lines: list[str], generate: bool) -> list[list[str]]:
    """Members of a set, numbers or names of other sets."""
    if not generate:
        return [[field] for line in lines for field in fields(line)]
    ranges = [range(first, last + 1, *step) for first, last, *step in ([int(field) for field in fields(line)] for line in lines)]
    if odd := [f"{numbers.start} to {numbers.stop - 1} by {numbers.step}" for numbers in ranges if not numbers or numbers.step < 0]:
        raise ValueError(f"it goes from {odd[0]}, which is not upwards")
    return [[str(n)] for numbers in ranges for n in numbers]


def elements_of(kind: str, lines: list[str]) -> list[list[str]]:
    """Number and nodes of each element; the number alone of one that is neither solid nor truss."""
    count = node_count(kind)
    if count is None:
        return [fields(line)[:1] for line in lines]
    flat = [field for line in lines for field in fields(line)]
    size = 1 + count
    if len(flat) % size:
        raise ValueError(f"{len(flat)} numbers, {size} an element")
    return [flat[i : i + size] for i in range(0, len(flat), size)]


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
