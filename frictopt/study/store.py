"""The sqlite file that keeps the runs of studies."""

import os
import sqlite3
import warnings
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ..base import Array, listed, number_of
from ..base.files import written_by
from ..errors import StoreError
from .case import FAILED, KEY, STORED, Row, digest

_SQL_TYPES = {"str": "text", "float64": "real", "Int64": "integer"}
_DECLARED = ", ".join(f"{name} {_SQL_TYPES[dtype]}" for name, dtype in STORED.items())
_RUNS = f"CREATE TABLE runs ({_DECLARED}, checksum integer, PRIMARY KEY (key)) WITHOUT ROWID"
_LIMITS = (
    "CREATE TABLE limits (key text, load_factor real, version text, checksum integer, "
    "PRIMARY KEY (key)) WITHOUT ROWID"
)
_CONTACTS = (
    "CREATE TABLE contacts (key text, sketch blob, checksum integer, PRIMARY KEY (key)) "
    "WITHOUT ROWID"
)
_VERSION = 7  # of the meaning of the columns

# A row with the same key is replaced, unless the new run failed and the old run did not.
_WRITE = (
    f"INSERT INTO runs VALUES ({', '.join('?' * (len(STORED) + 1))}) "
    "ON CONFLICT (key) DO UPDATE SET "
    f"{', '.join(f'{name} = excluded.{name}' for name in (*STORED, 'checksum'))} "
    "WHERE excluded.outcome <> ? OR outcome = ?"
)
# Largest difference of the sketches of one contact.
SAME = 1e-9
_RENAME = "give one of them another label, or another store"


class DamagedRows(UserWarning):
    """Rows of a store are damaged. They are ignored, and a study repeats their runs."""


class OtherRows(UserWarning):
    """A store has rows of another version of frictopt, or of other contacts only."""


class Store:
    """An open file of sqlite with a row for each run, shakedown limit, and contact with its loads.

    The keys of runs and limits begin with the key of their contact. The file has a sketch of each
    contact, by which the contact is found again if its numbers differ by rounding.

    With `make` the file is created if there is none; else it must exist, and may be read-only. Rows
    that are written together are one transaction. So sqlite protects the file if a writer is
    killed, or if there are several writers at the same time.
    """

    def __init__(self, path: str | os.PathLike[str], *, make: bool = True) -> None:
        with _store_errors(path):
            self.path = Path(path).expanduser().absolute()
            if self.path.is_dir():
                raise IsADirectoryError("it is a folder")
            # Check first whether the file exists, because another study may create it after that.
            usable = self.path.is_file() if self.path.exists() else make
            if not usable:
                raise FileNotFoundError("there is no such file")
            self._connection = _connect(self.path, make)
            try:
                if make:
                    self._create_table()
                self._check_version()
            except BaseException:
                self.close()
                raise

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def _create_table(self) -> None:
        """Create the tables of runs, limits and contacts in a new file."""
        execute = self._connection.execute
        execute("BEGIN IMMEDIATE")
        if not execute("SELECT * FROM sqlite_master").fetchall():
            execute(_RUNS)
            execute(_LIMITS)
            execute(_CONTACTS)
            execute(f"PRAGMA user_version = {_VERSION}")
        execute("COMMIT")

    def _check_version(self) -> None:
        schema = self._connection.execute("SELECT sql FROM sqlite_master").fetchall()
        version = self._connection.execute("PRAGMA user_version").fetchone()
        if schema != [(_RUNS,), (_LIMITS,), (_CONTACTS,)] or version != (_VERSION,):
            raise sqlite3.DatabaseError(
                "it is the file of another program or of another version of frictopt, and its "
                "columns have another meaning"
            )

    def read(self) -> pd.DataFrame:
        """All rows, ordered by key; damaged rows are left out, with a warning."""
        return pd.DataFrame(self._sound("runs"), columns=list(STORED)).astype(STORED)

    def own_rows(self, contacts: set[str]) -> list[Row]:
        """The rows of this version of frictopt.

        Warnings name rows of other versions, and a store that has only other contacts.
        """
        table = self.read()
        version = written_by()["version"]
        others = sorted(set(table["version"]) - {version})
        if others:
            runs = number_of(int((table["version"] != version).sum()), "run is", "runs are")
            warnings.warn(
                f"store: {str(self.path)!r}: {runs} of version {', '.join(others)}, and not taken "
                f"over; this is version {version}",
                OtherRows,
                stacklevel=5,
            )
        if len(table) and not table["key"].str[:KEY].isin(contacts).any():
            warnings.warn(
                f"store: {str(self.path)!r} has runs of other contacts or load cycles only; this "
                "study adds its runs",
                OtherRows,
                stacklevel=5,
            )
        rows: list[Row] = table[table["version"] == version].to_dict("records")
        return rows

    def read_limits(self) -> dict[str, float]:
        """Key -> load factor of each shakedown limit that this version of frictopt computed.

        Damaged rows are left out, with a warning.
        """
        own = written_by()["version"]
        sound = self._sound("limits")
        return {key: _number(limit) for key, limit, version in sound if version == own}

    def _sound(self, table: str) -> list[list[Any]]:
        """The rows of a table that have the right checksum; a warning counts all other rows."""
        with _store_errors(self.path):
            stored = self._connection.execute(f"SELECT * FROM {table} ORDER BY key").fetchall()
        sound = [values for *values, checksum in stored if checksum == _checksum(values)]
        damaged = len(stored) - len(sound)
        if damaged:
            rows = number_of(
                damaged, "row is damaged and is ignored", "rows are damaged and are ignored"
            )
            warnings.warn(f"store: {str(self.path)!r}: {rows}", DamagedRows, stacklevel=4)
        return sound

    def read_contacts(self) -> dict[str, Array]:
        """Key -> sketch of each contact; damaged ones are left out, with a warning."""
        return {key: np.frombuffer(sketch) for key, sketch in self._sound("contacts")}

    def contact(self, sketch: Array) -> str:
        """The key of the known contact with the same sketch, up to 1e-9, or a new key."""
        with _store_errors(self.path), self._connection:
            # Another study must not write the same contact under another key meanwhile.
            self._connection.execute("BEGIN IMMEDIATE")
            for key, known in self.read_contacts().items():
                if known.shape == sketch.shape and np.abs(known - sketch).max() <= SAME:
                    return key
            values = [digest(sketch.tobytes()), sketch.tobytes()]
            self._insert("contacts", values)
        return str(values[0])

    def check_cycles(self, loads: Mapping[str, str]) -> None:
        """Refuse labels under which the store has runs of other load cycles.

        `loads` has the digest of the loads under each label.
        """
        with _store_errors(self.path):
            stored = self._connection.execute(
                "SELECT DISTINCT cycle, loads FROM runs WHERE cycle <> ''"
            ).fetchall()
        for label, stored_loads in stored:
            if loads.get(label, stored_loads) != stored_loads:
                raise StoreError(
                    f"store: {str(self.path)!r} has runs of another load cycle under the label "
                    f"{label!r}; {_RENAME}"
                )

    def write(self, rows: Iterable[Row]) -> None:
        """Write rows in one transaction, with NULL for missing values.

        A row replaces a row with the same key, but a failed run never replaces a result.
        """
        with _store_errors(self.path), self._connection:
            self._connection.execute("BEGIN IMMEDIATE")
            for row in rows:
                values = _values(row)
                self._connection.execute(_WRITE, [*values, _checksum(values), FAILED, FAILED])

    def write_limits(self, limits: Mapping[str, float]) -> None:
        """Write the load factors of shakedown limits by their keys, in one transaction."""
        with _store_errors(self.path), self._connection:
            self._connection.execute("BEGIN IMMEDIATE")
            for key, load_factor in limits.items():
                number = None if pd.isna(load_factor) else float(load_factor)
                self._insert("limits", [key, number, written_by()["version"]])

    def _insert(self, table: str, values: list[Any]) -> None:
        marks = ", ".join("?" * (len(values) + 1))
        self._connection.execute(
            f"INSERT OR REPLACE INTO {table} VALUES ({marks})", [*values, _checksum(values)]
        )


def _connect(path: Path, make: bool) -> sqlite3.Connection:
    """Open a file of sqlite; without `make` it must exist."""
    if make:
        path.parent.mkdir(parents=True, exist_ok=True)
    # A connection that only reads may write, too: if a writer was killed, sqlite first undoes its
    # unfinished write. If the file cannot be written, sqlite itself opens it for reading alone.
    place = path if make else f"{path.as_uri()}?mode=rw"
    # Seconds to wait for another process that is writing.
    patience = 60
    connection = sqlite3.connect(place, uri=not make, timeout=patience, isolation_level=None)
    # Damaged text must not stop the reading: the checksum shows which row is damaged.
    connection.text_factory = lambda text: text.decode(errors="replace")
    return connection


@contextmanager
def _store_errors(path: object) -> Iterator[None]:
    """Raise a StoreError for each error of the file; an unknown home folder is a RuntimeError."""
    try:
        yield
    except (sqlite3.Error, OSError, TypeError, ValueError, RuntimeError) as error:
        raise StoreError(
            f"store: {str(path)!r} cannot be used ({error}); give another name, or free disk "
            "space and check that the file and its folder exist and can be written"
        ) from error


def _values(row: Row) -> list[Any]:
    """The values of a row for sqlite, which stores neither NaN nor the sign of zero."""
    values = list[Any]()
    for name, dtype in STORED.items():
        value: Any = row.get(name)
        if pd.isna(value):
            value = None
        elif dtype == "float64":
            value = float(value) + 0.0
        values.append(value)
    return values


def _number(value: float | None) -> float:
    """A number of sqlite, which keeps NaN as NULL."""
    return float("nan") if value is None else value


def _checksum(values: list[Any]) -> int:
    return zlib.crc32(repr(values).encode())


def read_store(path: str | os.PathLike[str]) -> pd.DataFrame:
    """All runs of a `store` of `dissipation_study`, even while a study writes to it.

    Returns
    -------
    DataFrame
        One row for each run, ordered by key. Columns: key, which identifies the run's content: 20
        characters for contact and load cycle, 20 for the friction, 20 for load factor and start;
        loads, a digest of the loads of its cycle; version, the version of frictopt that computed
        it; and most columns of the table of `dissipation_study`. Start and cycle have the names of
        the study that kept the run.

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
    ...     file = f"{folder}/runs.sqlite"
    ...     table = fo.dissipation_study(rod, cycle, 0.5, [1.0], store=file, progress=False)
    ...     fo.results.read_store(file)["outcome"].tolist()
    ['CYCLIC_SLIP']
    """
    with closing(Store(path, make=False)) as store:
        return store.read()


def merge_stores(into: str | os.PathLike[str], parts: Iterable[str | os.PathLike[str]]) -> int:
    """Write all runs and limits of some stores, such as stores of shards, into one store.

    The file may exist; its runs are kept. A run that is in several stores is written once. If one
    store has its result and another its failure, the result is written.

    Returns
    -------
    int
        Number of runs of the store.

    Raises
    ------
    ModelError
        `parts` is not a list.
    StoreError
        A file is not a store or is damaged, two stores have different load cycles under one label,
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
    ...         shard = {"store": part, "shard": (k, 2), "progress": False}
    ...         table = fo.dissipation_study(rod, cycle, 0.5, [0.5, 1.0], **shard)
    ...     fo.results.merge_stores(f"{folder}/runs.sqlite", parts)
    2
    """
    rows = list[Row]()
    limits = dict[str, float]()
    loads = dict[str, str]()  # label -> digest of its loads
    read = list[tuple[pd.DataFrame, dict[str, float], dict[str, Array]]]()
    for part in listed("parts", parts):
        with closing(Store(part, make=False)) as source:
            table = source.read()
            read.append((table, source.read_limits(), source.read_contacts()))
        for label, digest_of_loads in zip(table["cycle"], table["loads"], strict=True):
            if label and loads.setdefault(label, digest_of_loads) != digest_of_loads:
                raise StoreError(
                    f"parts: {str(part)!r} has another load cycle under the label {label!r} than "
                    f"one before it; {_RENAME}"
                )
    with closing(Store(into)) as store:
        store.check_cycles(loads)
        for table, limits_of_part, contacts in read:
            # The same contact may have another key in another store.
            keys = {key: store.contact(sketch) for key, sketch in contacts.items()}

            def renamed(key: str, keys: dict[str, str] = keys) -> str:
                return keys.get(key[:KEY], key[:KEY]) + key[KEY:]

            rows += [row | {"key": renamed(row["key"])} for row in table.to_dict("records")]
            limits |= {renamed(key): limit for key, limit in limits_of_part.items()}
        store.write(rows)
        store.write_limits(limits)
        return len(store.read())
