"""Runs of a campaign on disk, each by the key of its content: parquet parts, and a journal of the runs since the last part.

A line of a journal costs a tenth of what a part costs, so that each run can be kept as it finishes. A journal is folded into the next part, by
whoever writes it: journals that a killed study left are taken over, by their name, by the next one.
"""

import json
import os
import uuid
import warnings
from collections.abc import Container, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import FrictoptError

__all__ = ["COLUMNS", "DamagedPart", "Store", "StoreError"]

COLUMNS = pa.schema(
    [
        ("key", pa.string()),
        ("load_factor", pa.float64()),
        ("start", pa.string()),
        ("amplitude", pa.float64()),
        ("outcome", pa.string()),
        ("dissipation", pa.float64()),
        ("first_cycle", pa.float64()),
        ("largest_share", pa.float64()),
        ("cycles", pa.int64()),
        ("slipping", pa.int64()),
        ("open", pa.int64()),
        ("residual", pa.float64()),
        ("engine", pa.string()),
        ("seconds", pa.float64()),
        ("error", pa.string()),
    ]
)
"""What is kept of a run."""

_PART = 64  # runs


class StoreError(FrictoptError, OSError):
    """A run cannot be written: the disk is full, or the folder is not ours to write. What was written before is kept.

    Attributes
    ----------
    table
        The runs that are finished, those on disk and those that could not be written.
    """

    table: pd.DataFrame | None = None


class DamagedPart(UserWarning):
    """A part of a store could not be read; it was set aside, and its runs are repeated."""


class Store:
    """A folder of parts, which `pandas.read_parquet` reads as one table, and of journals, whose names begin with a dot.

    Parameters
    ----------
    folder
        Where they are; made if it does not exist.

    Raises
    ------
    StoreError
        The folder cannot be made.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        try:
            if not os.fspath(folder):
                raise ValueError("no name")
            self.folder = Path(folder).expanduser()
            self.folder.mkdir(parents=True, exist_ok=True)
        except (OSError, TypeError, ValueError, RuntimeError) as error:  # RuntimeError: a home that nobody has
            raise StoreError(f"store: {folder!r} cannot be made into a folder ({error}); give a folder that exists or can be made") from error
        self._journals = [self._new_journal()]  # the one that is written, and those taken over
        self._rows: list[dict[str, Any]] = []  # what is in them

    def read(self, keys: Container[str]) -> dict[str, dict[str, Any]]:
        """The rows of these runs that the store has, by key; damaged parts are set aside, with a warning that names them.

        Raises
        ------
        StoreError
            The folder cannot be read.
        """
        try:
            return {row["key"]: row for row in self._all_rows() if row["key"] in keys}
        except OSError as error:
            raise self._failed("read", error) from error

    def write(self, row: dict[str, Any]) -> None:
        """Keep the row of one run.

        Raises
        ------
        StoreError
            It cannot be written.
        """
        try:
            with self._journals[0].open("a", encoding="utf-8") as journal:
                journal.write(json.dumps(row) + "\n")
        except OSError as error:
            raise self._failed("written", error) from error
        self._rows.append(row)
        if len(self._rows) >= _PART:
            self.fold()

    def fold(self) -> None:
        """Write what the journals hold as a part, whole or not at all, and begin a new journal.

        Raises
        ------
        StoreError
            It cannot be written; the journals stay.
        """
        if not self._rows:
            return
        part = self.folder / f"{uuid.uuid4().hex}.parquet"
        temporary = part.with_name(f".{part.name}")
        try:
            pq.write_table(pa.Table.from_pylist(self._rows, schema=COLUMNS), temporary, write_page_checksum=True)
            temporary.replace(part)
            for journal in self._journals:
                journal.unlink(missing_ok=True)
        except OSError as error:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
            raise self._failed("written", error) from error
        self._journals, self._rows = [self._new_journal()], []

    def _new_journal(self) -> Path:
        return self.folder / f".{uuid.uuid4().hex}.journal"

    def _failed(self, what: str, error: OSError) -> StoreError:
        remedy = "make room" if self.folder.is_dir() else "leave the folder where it is"
        return StoreError(
            f"store: {str(self.folder)!r} cannot be {what} ({error}); {remedy} and start again, finished runs are kept in the folder "
            "and in `table` of this error"
        )

    def _all_rows(self) -> Iterator[dict[str, Any]]:
        for part in sorted(self.folder.glob("[!._]*.parquet")):
            try:
                with part.open("rb") as file:
                    yield from pq.ParquetFile(file, page_checksum_verification=True).read().cast(COLUMNS).to_pylist()
            except FileNotFoundError:
                continue  # set aside by another study
            except (OSError, ValueError, pa.ArrowException) as error:
                aside = part.with_name(f"_damaged-{part.name}")
                part.replace(aside)
                self._warn(part.name, f"{error}".partition("\n")[0] or type(error).__name__, f"set aside as {aside.name}")
        for journal in sorted(self.folder.glob(".*.journal")):
            yield from self._taken_over(journal)

    def _taken_over(self, journal: Path) -> Iterator[dict[str, Any]]:
        """The rows of a journal that another study left; should it go on writing, it begins a new one."""
        own = self._new_journal()
        try:
            journal.rename(own)
        except FileNotFoundError:
            return  # folded or taken by another study
        self._journals.append(own)
        for line in own.read_text(encoding="utf-8", errors="replace").splitlines(keepends=True):
            try:
                row = json.loads(line) if line.endswith("\n") else None  # else its writer was stopped within the line
                if row is not None and set(row) != set(COLUMNS.names):
                    raise ValueError("a line holds other columns")
            except (ValueError, TypeError) as error:
                self._warn(journal.name, str(error), "the line is left out")
                continue
            if row is not None:
                self._rows.append(row)
                yield row

    def _warn(self, name: str, reason: str, done: str) -> None:
        warnings.warn(f"store: {name} is damaged ({reason}); {done}, its runs are repeated", DamagedPart, stacklevel=5)
