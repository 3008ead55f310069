"""The sqlite file that keeps the runs of studies."""

import os
import sqlite3
import warnings
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

import pandas as pd

from ..base import listed
from ..errors import StoreError

Row = dict[str, Any]
FAILED = "FAILED"  # outcome of a run that has no result, which other versions may have
_KINDS = dict.fromkeys("key start cycle loads outcome engine error".split(), "str") | dict.fromkeys(
    "cycles slipping open".split(), "Int64"
)
_NAMES = (
    "key friction friction_std cycle loads load_factor start amplitude outcome dissipation first_cycle largest_share cycles slipping open residual "
    "engine seconds error"
).split()
TYPES = {name: _KINDS.get(name, "float64") for name in _NAMES}  # of the columns in a DataFrame
_SQL = {"str": "text", "float64": "real", "Int64": "integer"}
_DECLARED = ", ".join(f"{name} {_SQL[kind]}" for name, kind in TYPES.items())
_SCHEMA = f"CREATE TABLE runs ({_DECLARED}, checksum integer, PRIMARY KEY (key)) WITHOUT ROWID"
_VERSION = 5  # of what the columns mean
_RENAME = "give one of them another label, or another store"
_PATIENCE = 60  # seconds to wait for another writer


class DamagedRows(UserWarning):
    """Rows of a store are damaged. They are ignored, and a study repeats their runs."""


class Store:
    """An open file of sqlite, which may be made and written, or is only read: one row for each run, whose key is a digest of the run's content.

    Rows that become known together are one transaction. So sqlite protects the file if a writer is
    killed, or if several write at the same time.
    """

    def __init__(self, path: str | os.PathLike[str], *, make: bool = True) -> None:
        with _errors(path):
            self.path = Path(path).expanduser().absolute()
            if not (
                self.path.is_file() if self.path.exists() else make
            ):  # asked in this order, for another study may make it in between
                raise FileNotFoundError("there is no such file")
            if make:
                self.path.parent.mkdir(parents=True, exist_ok=True)
            place = self.path if make else f"{self.path.as_uri()}?mode=ro"
            self._connection = sqlite3.connect(
                place, uri=not make, timeout=_PATIENCE, isolation_level=None
            )
            self.close, ask = self._connection.close, self._connection.execute
            self._connection.text_factory = lambda text: text.decode(
                errors="replace"
            )  # the checksum shows such a row
            with ExitStack() as undo:
                undo.callback(self.close)
                if make:
                    ask("BEGIN IMMEDIATE")
                    if not ask("SELECT * FROM sqlite_master").fetchall():
                        ask(_SCHEMA)
                        ask(f"PRAGMA user_version = {_VERSION}")
                    ask("COMMIT")
                if ask("SELECT sql FROM sqlite_master").fetchall() != [(_SCHEMA,)] or ask(
                    "PRAGMA user_version"
                ).fetchone() != (_VERSION,):
                    raise sqlite3.DatabaseError(
                        "it is of another program, or of another version of frictopt, and its columns mean something else"
                    )
                undo.pop_all()

    def read(self) -> pd.DataFrame:
        """All rows, ordered by key; damaged rows are left out, with a warning."""
        with _errors(self.path):
            kept = self._connection.execute("SELECT * FROM runs ORDER BY key").fetchall()
        sound = [values for *values, checksum in kept if checksum == _checksum(values)]
        if damaged := len(kept) - len(sound):
            warnings.warn(
                f"store: {str(self.path)!r}: {damaged} rows are damaged and do not count",
                DamagedRows,
                stacklevel=3,
            )
        return pd.DataFrame(sound, columns=list(TYPES)).astype(TYPES)

    def check_cycles(self, loads: Mapping[str, str]) -> None:
        """Refuse labels under which the store has runs of other load cycles: `loads` has the digest of each, label -> digest."""
        with _errors(self.path):
            kept = self._connection.execute(
                "SELECT DISTINCT cycle, loads FROM runs WHERE cycle <> ''"
            ).fetchall()
        for label, digest in kept:
            if loads.get(label, digest) != digest:
                raise StoreError(
                    f"store: {str(self.path)!r} has runs of another load cycle under the label {label!r}; {_RENAME}"
                )

    def write(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Write rows, all or none, NULL for what they lack; a row replaces one with the same key, but a run that failed never replaces a result."""
        marks, changes = (
            ", ".join("?" * (len(TYPES) + 1)),
            ", ".join(f"{name} = excluded.{name}" for name in (*TYPES, "checksum")),
        )
        put = f"INSERT INTO runs VALUES ({marks}) ON CONFLICT (key) DO UPDATE SET {changes} WHERE excluded.outcome <> ? OR outcome = ?"
        with _errors(self.path), self._connection:
            self._connection.execute("BEGIN IMMEDIATE")
            self._connection.executemany(
                put,
                [(*(values := _values(row)), _checksum(values), FAILED, FAILED) for row in rows],
            )


@contextmanager
def _errors(path: object) -> Iterator[None]:
    try:
        yield
    except (
        sqlite3.Error,
        OSError,
        TypeError,
        ValueError,
        RuntimeError,
    ) as error:  # RuntimeError: unknown home folder
        remedy = (
            "give another name, or make room and see that it and its folder stay and can be written"
        )
        raise StoreError(f"store: {str(path)!r} cannot be used ({error}); {remedy}") from error


def _values(row: Mapping[str, Any]) -> list[Any]:
    """What sqlite keeps of a row: it has neither NaN nor a sign of zero."""
    given: dict[str, Any] = {name: row.get(name) for name in TYPES}
    return [
        None if pd.isna(value) else float(value) + 0.0 if TYPES[name] == "float64" else value
        for name, value in given.items()
    ]


def _checksum(values: list[Any]) -> int:
    return zlib.crc32(repr(values).encode())


def read_store(path: str | os.PathLike[str]) -> pd.DataFrame:
    """All runs of a file that `dissipation_study` was given as `store`, also while a study writes to it.

    Returns
    -------
    DataFrame
        One row for each run, ordered by key. Columns: key, digest of the run's content (contact,
        cycle, friction, load factor and start); loads, that of the loads of its cycle; the others
        as in the table of `dissipation_study`, start and cycle by the names that they had when it
        was kept.

    Raises
    ------
    StoreError
        The file does not exist, is not a store, or is damaged.

    Examples
    --------
    >>> import tempfile
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     table = fo.dissipation_study(rod, cycle, 0.5, [1.0], store=f"{folder}/runs.sqlite", progress=False)
    ...     fo.results.read_store(f"{folder}/runs.sqlite")["outcome"].tolist()
    ['CYCLIC_SLIP']
    """
    with closing(Store(path, make=False)) as store:
        return store.read()


def merge_stores(into: str | os.PathLike[str], parts: Iterable[str | os.PathLike[str]]) -> int:
    """Write all runs of the files of some stores, such as those of shards, into one; return the number of runs that it holds then.

    It may exist, and keeps its own runs. A run that several of them hold counts once, with a result
    if one has it.

    Raises
    ------
    ModelError
        `parts` is no list.
    StoreError
        A file is not a store or is damaged, two of them have different load cycles under one label,
        or the rows cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     parts = [f"{folder}/part{k}.sqlite" for k in (1, 2)]
    ...     for k, part in enumerate(parts, 1):
    ...         table = fo.dissipation_study(rod, cycle, 0.5, [0.5, 1.0], store=part, shard=(k, 2), progress=False)
    ...     fo.results.merge_stores(f"{folder}/runs.sqlite", parts)
    2
    """
    found, loads = (
        [
            (part, row)
            for part in listed("parts", parts)
            for row in read_store(part).to_dict("records")
        ],
        dict[str, str](),
    )
    for part, row in found:
        if row["cycle"] and loads.setdefault(row["cycle"], row["loads"]) != row["loads"]:
            raise StoreError(
                f"parts: {str(part)!r} has another load cycle under the label {row['cycle']!r} than one before it; {_RENAME}"
            )
    with closing(Store(into)) as store:
        store.check_cycles(loads)
        store.write(row for _, row in found)
        return len(store.read())
