"""The blocks of a deck of CalculiX or Abaqus: keyword, parameters, data lines."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TypeAlias

import numpy as np

from ...errors import ModelError
from .kinds import node_count

Block: TypeAlias = tuple[str, dict[str, str], list[str]]  # keyword and names of parameters without blanks, data lines


def blocks(path: Path, depth: int = 0) -> Iterator[Block]:
    """The blocks of a deck and of the files that it includes, in order; all in capitals, but for data lines."""
    lines = [line for line in map(str.strip, text_of(path, "deck").splitlines()) if line and not line.startswith("**")]
    starts = [i for i, line in enumerate(lines) if line.startswith("*")]
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        head, first = lines[start][1:], start + 1
        while head.endswith(",") and first < end and _continues(lines[first]):
            head, first = head + lines[first], first + 1
        keyword, *rest = (part.strip() for part in head.split(","))
        pairs = [(_joined(name), value.strip().strip('"')) for name, _, value in (part.partition("=") for part in rest if part)]
        yield _joined(keyword), {name: value.upper() for name, value in pairs}, lines[first:end]
        if _joined(keyword) == "INCLUDE":
            if depth > 20:
                raise ModelError(f"deck {path.name}: it includes itself; take the *INCLUDE out")
            yield from blocks(path.parent / dict(pairs).get("INPUT", ""), depth + 1)


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


def fields(line: str) -> list[str]:
    """The entries of a data line that are not empty."""
    return [field.strip() for field in line.split(",") if field.strip()]


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
    ranges = [[int(field) for field in fields(line)] for line in lines]
    return [[str(n)] for first, last, *step in ranges for n in range(first, last + 1, *step)]


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
