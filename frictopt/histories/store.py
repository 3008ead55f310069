"""Runs of a study on disk: one sqlite file with one table, one row for each run; the key is a digest of the run's content.

Rows that become known together are one transaction. So sqlite protects the file if a writer is killed, or if several write at the same time.
"""

import os
import sqlite3
import warnings
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pandas as pd

from ..contact import listed
from ..errors import StoreError

TYPES = {
    "key": "str",
    "friction": "float64",
    "friction_std": "float64",
    "load_factor": "float64",
    "start": "str",
    "amplitude": "float64",
    "outcome": "str",
    "dissipation": "float64",
    "first_cycle": "float64",
    "largest_share": "float64",
    "cycles": "Int64",
    "slipping": "Int64",
    "open": "Int64",
    "residual": "float64",
    "engine": "str",
    "seconds": "float64",
    "error": "str",
}
"""Types of the columns in a DataFrame."""
FAILED = "FAILED"
"""Outcome of a run that has no result, which other versions may have."""
_SQL = {"str": "text", "float64": "real", "Int64": "integer"}
_DECLARED = ", ".join(f"{name} {_SQL[kind]}" for name, kind in TYPES.items())
_SCHEMA = f"CREATE TABLE runs ({_DECLARED}, checksum integer, PRIMARY KEY (key)) WITHOUT ROWID"
_VERSION = 4  # of what the columns mean
_APPLICATION = int.from_bytes(b"FriO", "big")  # by which sqlite tells a store from other files of its own
_PATIENCE = 60  # seconds to wait for another writer


class DamagedRows(UserWarning):
    """Rows of a store are damaged. They are ignored, and a study repeats their runs."""


class Store:
    """An open store.

    Parameters
    ----------
    path
        File of the store.
    make
        Whether the file may be made and written.

    Raises
    ------
    StoreError
        The file is not a store, is damaged, or cannot be made.
    """

    def __init__(self, path: str | os.PathLike[str], *, make: bool = True) -> None:
        try:
            self.path = Path(path).expanduser().absolute()
            if self.path.exists() and not self.path.is_file():
                raise OSError("no file")
            if not make and not self.path.exists():
                raise OSError("there is no such file")
        except (OSError, TypeError, RuntimeError) as error:  # RuntimeError: unknown home folder
            raise StoreError(f"store: {path!r} is no store ({error}); give another name") from error
        with self._errors():
            if make:
                self.path.parent.mkdir(parents=True, exist_ok=True)
            place = self.path if make else f"{self.path.as_uri()}?mode=ro"
            self._connection = sqlite3.connect(place, uri=not make, timeout=_PATIENCE, isolation_level=None)
        try:
            with self._errors():
                self._open(make)
        except BaseException:
            self.close()
            raise

    def _open(self, make: bool) -> None:
        ask = self._connection.execute
        self._connection.text_factory = lambda text: text.decode(errors="replace")  # the checksum tells such a row
        if make:
            ask("BEGIN IMMEDIATE")
            if not ask("SELECT * FROM sqlite_master").fetchall():
                ask(_SCHEMA)
                ask(f"PRAGMA application_id = {_APPLICATION}")
                ask(f"PRAGMA user_version = {_VERSION}")
            ask("COMMIT")
        if ask("PRAGMA application_id").fetchone() != (_APPLICATION,):
            raise sqlite3.NotSupportedError("it has tables of another program")
        if ask("SELECT sql FROM sqlite_master").fetchone() != (_SCHEMA,) or ask("PRAGMA user_version").fetchone() != (_VERSION,):
            raise StoreError(f"store: {str(self.path)!r} is of another version of frictopt, its columns mean something else; give another file")

    def close(self) -> None:
        """Close the store."""
        self._connection.close()

    def read(self) -> pd.DataFrame:
        """All rows, ordered by key; damaged rows are left out, with a warning.

        Raises
        ------
        StoreError
            The file cannot be read.
        """
        with self._errors():
            kept = self._connection.execute("SELECT * FROM runs ORDER BY key").fetchall()
        sound = [values for *values, checksum in kept if checksum == _checksum(values)]
        if damaged := len(kept) - len(sound):
            warnings.warn(f"store: {str(self.path)!r}: {damaged} rows are damaged and do not count", DamagedRows, stacklevel=3)
        return pd.DataFrame(sound, columns=list(TYPES)).astype(TYPES)

    def write(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Write rows, all or none, NULL for what they lack; a row replaces one with the same key, but a run that failed never replaces a result.

        Raises
        ------
        StoreError
            The rows cannot be written.
        """
        marks, changes = ", ".join("?" * (len(TYPES) + 1)), ", ".join(f"{name} = excluded.{name}" for name in (*TYPES, "checksum"))
        put = f"INSERT INTO runs VALUES ({marks}) ON CONFLICT (key) DO UPDATE SET {changes} WHERE excluded.outcome <> ? OR outcome = ?"
        with self._errors(), self._connection:
            self._connection.execute("BEGIN IMMEDIATE")
            self._connection.executemany(put, [(*(values := _values(row)), _checksum(values), FAILED, FAILED) for row in rows])

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """Errors of sqlite and of the file as a StoreError."""
        try:
            yield
        except (sqlite3.Error, OSError, ValueError) as error:
            if isinstance(error, StoreError):
                raise
            if isinstance(error, sqlite3.NotSupportedError) or getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_NOTADB:
                raise StoreError(f"store: {str(self.path)!r} is no store ({error}); give another name") from error
            damaged = isinstance(error, sqlite3.DatabaseError) and not isinstance(error, sqlite3.OperationalError)
            remedy = "move it away" if damaged else "make room, or see that it and its folder stay and can be written"
            what = f"store: {str(self.path)!r} {'is damaged' if damaged else 'cannot be used'} ({error})"
            raise StoreError(f"{what}; {remedy}, and start again; what is finished is in `table` of this error") from error


def read_store(path: str | os.PathLike[str]) -> pd.DataFrame:
    """All runs that a store holds.

    Parameters
    ----------
    path
        File that `dissipation_study` was given as `store`; a study may be writing to it.

    Returns
    -------
    DataFrame
        One row for each run, ordered by key. Columns: key, digest of the run's content (contact, cycle, friction, load factor and start); the others
        as in the table of `dissipation_study`, the start by the name that it had when the run was kept.

    Raises
    ------
    StoreError
        The file does not exist, is not a store, or is damaged.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     store = Path(folder) / "runs.sqlite"
    ...     table = fo.dissipation_study(rod, cycle, 0.5, [1.0], store=store, progress=False)
    ...     kept = fo.results.read_store(store)
    >>> kept[["load_factor", "outcome"]]
       load_factor      outcome
    0          1.0  CYCLIC_SLIP
    """
    with closing(Store(path, make=False)) as store:
        return store.read()


def merge_stores(into: str | os.PathLike[str], parts: Iterable[str | os.PathLike[str]]) -> int:
    """Write all runs of some stores into one, which may exist and keeps its own runs.

    Parameters
    ----------
    into
        File of the store that takes them.
    parts
        Files that `dissipation_study` was given as `store`, such as those of its shards.

    Returns
    -------
    int
        The number of runs that the store holds then; a run that several parts hold counts once, with a result if one has it.

    Raises
    ------
    ModelError
        `parts` is no list.
    StoreError
        A file is not a store or is damaged, or the rows cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     parts = [Path(folder) / f"part{k}.sqlite" for k in (1, 2)]
    ...     for k, part in enumerate(parts, 1):
    ...         table = fo.dissipation_study(rod, cycle, 0.5, [0.5, 1.0], store=part, shard=(k, 2), progress=False)
    ...     fo.results.merge_stores(Path(folder) / "runs.sqlite", parts)
    2
    """
    found = [row for part in listed("parts", parts) for row in read_store(part).to_dict("records")]
    with closing(Store(into)) as store:
        store.write(found)
        return len(store.read())


def _values(row: Mapping[str, Any]) -> list[Any]:
    """What sqlite keeps of a row: it has neither NaN nor a sign of zero."""
    given: dict[str, Any] = {name: row.get(name) for name in TYPES}
    return [None if pd.isna(value) else float(value) + 0.0 if TYPES[name] == "float64" else value for name, value in given.items()]


def _checksum(values: list[Any]) -> int:
    return zlib.crc32(repr(values).encode())
