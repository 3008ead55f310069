"""An answer as text, as JSON, as a table and as a picture."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
from collections.abc import Callable, Iterable, Mapping
from enum import Enum, IntEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..base.files import TABLES, plain, strict_json, write_table, written

if TYPE_CHECKING:  # commands import what they need, so that `frictopt --help` is quick
    from ..base import Table


class ExitCode(IntEnum):
    """Exit codes of a command. 0 is an answer."""

    BAD_INPUT = 2
    NO_ANSWER = 3
    BAD_FILE = 4
    # The exit code that shells have after SIGINT.
    INTERRUPTED = 130


# Largest number of rows of a table that are printed.
_ROWS = 8
# Attributes of an interrupt that hold what is known so far, see `Bar.keep`.
_PARTIAL = ("report", "curve", "limit", "table", "work")


def add_outputs(command: argparse.ArgumentParser, picture: bool, save: bool = True) -> None:
    """Add the options for the forms of an answer."""
    command.add_argument(
        "--json",
        action="store_true",
        help="print the answer as JSON, with null for nan and 'inf' for infinity",
    )
    tables = ", ".join(TABLES)
    command.add_argument("--table", metavar="FILE", help=f"write the table: {tables}")
    if picture:
        command.add_argument("--picture", metavar="FILE", help="draw the picture: png, pdf, svg")
    if save:
        results = "write the answer for frictopt.results.load: npz"
        command.add_argument("--save", metavar="FILE", help=results)


def give(
    options: argparse.Namespace,
    answer: Any,
    tables: Mapping[str, Table],
    request: Mapping[str, object],
    printed: Iterable[str],
) -> int:
    """Print an answer with some of its tables, write its files, and return the exit code.

    Files are written even if nobody reads the text, and the text is printed even if a file cannot
    be written. The first table goes to a file, with additional columns for the numbers of the
    answer.
    """
    numbers = numbers_of(answer)
    try:
        _write_files(options, answer, next(iter(tables.values()), None), numbers)
    finally:
        if options.json:
            parts = {"question": request, "answer": numbers, "tables": tables}
            print_json(options, parts)
        else:
            print(answer)
            for name in printed:
                print_table(tables[name], bool(options.table))
    return ExitCode.NO_ANSWER if is_missing(answer) else 0


def print_json(options: argparse.Namespace, parts: Mapping[str, object]) -> None:
    """Print the parts of an answer as JSON, with the version and the warnings."""
    print(strict_json({"frictopt": __version__, **parts, "warnings": options.warnings}))


def _write_files(
    options: argparse.Namespace, answer: Any, table: Table | None, numbers: Mapping[str, object]
) -> None:
    """Write the files that the options name."""
    if options.table and table is not None:
        write_table(options.table, with_numbers(table, numbers))
    for name in ("save", "page"):
        if getattr(options, name, None):
            answer.save(getattr(options, name))
    if getattr(options, "picture", None):
        write_picture(options.picture, answer.plot)


def numbers_of(answer: Any) -> dict[str, object]:
    """The numbers and words of an answer: what it prints, and its other plain fields."""
    numbers = dict[str, object](answer._answer())
    for field in dataclasses.fields(answer):
        if not field.name.startswith("_") and field.name not in numbers:
            value = getattr(answer, field.name)
            if _is_plain(value):
                numbers[field.name] = value
    return numbers


def _is_plain(value: object) -> bool:
    """Whether a value is a number, a word or loads."""
    if isinstance(value, Mapping):
        return all(_is_plain(part) for part in value.values())
    if isinstance(value, bool | int | float | str | Enum):
        return True
    # Numbers of numpy have a shape without axes.
    return hasattr(value, "dtype") and getattr(value, "shape", None) == ()


def is_missing(answer: Any) -> bool:
    """Whether the main number of an answer, which it prints first, is nan."""
    main = next(iter(answer._answer().values()), None)
    return isinstance(main, float) and math.isnan(main)


def with_numbers(table: Table, numbers: Mapping[str, object]) -> Table:
    """A table with the numbers of its answer, in columns that begin with "answer_"."""
    import pandas as pd

    columns = dict[str, object]()
    for name, value in numbers.items():
        if isinstance(value, Enum):
            columns[f"answer_{name}"] = value.name
        elif _is_plain(value):
            is_loads = isinstance(value, Mapping)
            columns[f"answer_{name}"] = json.dumps(plain(value)) if is_loads else value
    # A table without rows gets one row for the numbers of the answer.
    if not len(table):
        return pd.DataFrame([columns])
    repeated = pd.DataFrame([columns] * len(table), index=table.index)
    return pd.concat([table, repeated], axis=1)


def print_table(table: Table, has_file: bool) -> None:
    """Print the first rows of a table."""
    if not len(table):
        return
    print(table.head(_ROWS).to_string(index=False, float_format="{:.5g}".format))
    if len(table) > _ROWS and not has_file:
        print(f"... {len(table)} rows in all; --table FILE writes them")


def write_picture(file: Path, plot: Callable[[], Any]) -> None:
    """Draw a picture and write it to a file."""
    axes = plot()
    with written(file, ".png, .pdf or .svg") as part:
        getattr(axes, "flat", [axes])[0].figure.savefig(part, bbox_inches="tight")


def partial_answer(interrupt: KeyboardInterrupt, with_json: bool) -> list[str]:
    """Print what an interrupt keeps, and return sentences on it."""
    if hasattr(interrupt, "printed_text"):
        return [interrupt.printed_text]
    known = next((name for name in _PARTIAL if hasattr(interrupt, name)), None)
    if known is None:
        return []
    value = getattr(interrupt, known)
    if with_json:
        content = numbers_of(value) if hasattr(value, "_answer") else value
        print(strict_json({"interrupted": True, known: content}))
    else:
        print(value)
    return [f"{known}: the part that is known is printed"]
