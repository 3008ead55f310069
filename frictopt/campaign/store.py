"""Runs of a campaign on disk: one sqlite file with one table, one row for each run; the key is a digest of the run's content.

Each row is its own transaction. So sqlite protects the file if a writer is killed, or if several write at the same time.
"""

import os
import sqlite3
import stat
import warnings
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

import pandas as pd

from ..contact.answers import Outcome
from ..errors import StoreError

__all__ = ["TYPES", "DamagedRows", "Store", "read_store"]

_COLUMNS: dict[str, type] = {
    "key": str,
    "load_factor": float,
    "start": str,
    "amplitude": float,
    "outcome": str,
    "dissipation": float,
    "first_cycle": float,
    "largest_share": float,
    "cycles": int,
    "slipping": int,
    "open": int,
    "residual": float,
    "engine": str,
    "seconds": float,
    "error": str,
}
TYPES = {name: {str: "str", float: "float64", int: "Int64"}[kind] for name, kind in _COLUMNS.items()}
"""Types of the columns in a DataFrame."""
_NAMES = ", ".join(_COLUMNS)
_SQL = {str: "text", float: "real", int: "integer"}
_NULLABLE = (
    "amplitude",
    "dissipation",
    "first_cycle",
    "largest_share",
    "cycles",
    "slipping",
    "open",
    "residual",
    "seconds",
)  # in a failed run
_NEVER_NEGATIVE = ("load_factor", "amplitude", "dissipation", "largest_share", "cycles", "slipping", "open", "residual")
_VALID = " AND ".join(  # conditions on every row
    [f"typeof({name}) = '{_SQL[kind]}'" for name, kind in _COLUMNS.items() if name not in _NULLABLE]
    + [f"typeof({name}) IN ('{_SQL[_COLUMNS[name]]}', 'null')" for name in _NULLABLE]
    + [f"coalesce({name}, 0) >= 0" for name in _NEVER_NEGATIVE]
    + [f"outcome IN {('FAILED', *Outcome.__members__)}", "(outcome = 'FAILED') = (error <> '')"]
    + [f"(outcome = 'FAILED' OR {name} IS NOT NULL)" for name in _NULLABLE]
)
_DECLARED = ", ".join(f"{name} {_SQL[kind]}" for name, kind in _COLUMNS.items())
_SCHEMA = f"CREATE TABLE runs ({_DECLARED}, checksum integer NOT NULL, PRIMARY KEY (key), CONSTRAINT valid CHECK ({_VALID})) WITHOUT ROWID"
_VERSION = 2  # of what the columns mean: a store of another version is refused
_MAGIC, _APPLICATION = b"SQLite format 3\0", b"FriO"  # first bytes of a file of sqlite, and bytes 68 to 71 of a store
_PATIENCE = 60  # seconds to wait for another writer; writing a row takes less than a millisecond
_AT_ONCE = 500  # keys in one query: sqlite allows 999


class DamagedRows(UserWarning):
    """Rows of a store are damaged. They are ignored, and a study repeats their runs."""


class Store:
    """An open store.

    Parameters
    ----------
    path
        File of the store, created if it does not exist.
    make
        Whether the file may be created and written.

    Raises
    ------
    StoreError
        The file is not a store, is damaged, or cannot be created.
    """

    def __init__(self, path: str | os.PathLike[str], *, make: bool = True) -> None:
        self.path = _checked_path(path, make)
        with _as_store_error(self.path):
            if make:
                self.path.parent.mkdir(parents=True, exist_ok=True)
            address = f"{self.path.as_uri()}?mode={'rwc' if make else 'ro'}"
            self._connection = sqlite3.connect(address, uri=True, timeout=_PATIENCE, isolation_level=None)
        try:
            with _as_store_error(self.path):
                self._open(make)
        except BaseException:
            self._connection.close()
            raise

    def _open(self, make: bool) -> None:
        ask = self._connection.execute
        self._connection.text_factory = lambda text: text.decode(errors="replace")  # the checksum finds such a row
        if make:
            ask("BEGIN IMMEDIATE")
            if not ask("SELECT * FROM sqlite_master").fetchall():
                ask(_SCHEMA)
                ask(f"PRAGMA application_id = {int.from_bytes(_APPLICATION, 'big')}")
                ask(f"PRAGMA user_version = {_VERSION}")
            ask("COMMIT")
        columns, version = ask("SELECT sql FROM sqlite_master WHERE name = 'runs'").fetchall(), ask("PRAGMA user_version").fetchone()
        if columns != [(_SCHEMA,)] or version != (_VERSION,):
            raise StoreError(
                f"store: {str(self.path)!r} is of another version of frictopt, its columns are others or mean something else; give another file"
            )
        if make:
            self._mode("WAL")  # a commit takes 0.02 ms instead of 0.7
            ask("PRAGMA synchronous = NORMAL")
        self._file = self.path.stat().st_ino

    def close(self) -> None:
        """Close the store; sqlite's extra files are removed, unless others have the store open."""
        self._mode("DELETE")
        self._connection.close()

    def _mode(self, journal: str) -> None:
        with suppress(sqlite3.Error):  # in use by others, who work in any mode
            self._connection.execute("PRAGMA busy_timeout = 0")
            self._connection.execute(f"PRAGMA journal_mode = {journal}")
        self._connection.execute(f"PRAGMA busy_timeout = {1000 * _PATIENCE}")

    def read(self, keys: Iterable[str] | None = None) -> dict[str, dict[str, Any]]:
        """Rows of these runs (None: all) that the store holds, by key; damaged rows are left out, with a warning.

        Raises
        ------
        StoreError
            The file cannot be read.
        """
        rows, damaged = {}, 0
        with _as_store_error(self.path):
            for values in self._all(keys):
                if values[-1] == _checksum(values[:-1]):
                    rows[values[0]] = {name: _from_sqlite(value, kind) for value, (name, kind) in zip(values, _COLUMNS.items(), strict=False)}
                else:
                    damaged += 1
        if damaged:
            warnings.warn(f"store: {str(self.path)!r}: {damaged} rows are damaged and do not count", DamagedRows, stacklevel=3)
        return rows

    def _all(self, keys: Iterable[str] | None) -> Iterator[tuple[Any, ...]]:
        query = f"SELECT {_NAMES}, CASE WHEN {_VALID} THEN checksum END FROM runs"
        if keys is None:
            yield from self._connection.execute(f"{query} ORDER BY key")
            return
        wanted = list(keys)
        for some in (wanted[first : first + _AT_ONCE] for first in range(0, len(wanted), _AT_ONCE)):
            yield from self._connection.execute(f"{query} WHERE key IN ({', '.join('?' * len(some))})", some)

    def write(self, row: Mapping[str, Any]) -> None:
        """Write the row of one run; it replaces a row with the same key.

        Raises
        ------
        StoreError
            The row cannot be written, or is not valid.
        """
        with _as_store_error(self.path):
            if self.path.stat().st_ino != self._file:
                raise OSError("another file is in its place")
            values = tuple(_to_sqlite(row[name], kind) for name, kind in _COLUMNS.items())
            query = f"INSERT OR REPLACE INTO runs VALUES ({', '.join('?' * len(values))}, ?)"
            self._connection.execute(query, (*values, _checksum(values)))


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
    ...     kept = fo.read_store(store)
    >>> kept[["load_factor", "outcome"]]
       load_factor      outcome
    0          1.0  CYCLIC_SLIP
    """
    with closing(Store(path, make=False)) as store:
        rows = store.read()
    return pd.DataFrame(list(rows.values()), columns=list(_COLUMNS)).astype(TYPES)


def _checked_path(path: Any, make: bool) -> Path:
    """The absolute path of a store or of a file to be created; any other file is refused before sqlite opens it, because sqlite could change it."""
    try:
        if not os.fspath(path):
            raise ValueError("no name")
        found = Path(path).expanduser().absolute()
        if "\0" in str(found):
            raise ValueError("a name with a null character, at which sqlite would cut it off")
        if not found.exists():
            if not make:
                raise FileNotFoundError("there is none")
            return found
        regular = stat.S_ISREG(found.stat().st_mode)
        head = b""
        if regular:
            with found.open("rb") as file:
                head = file.read(72)
    except (OSError, TypeError, ValueError, RuntimeError) as error:  # RuntimeError: unknown home folder
        raise StoreError(f"store: {path!r} is not a store ({error}); give the name of a store, or for a study of a file that can be made") from error
    if not regular or (head and not (head.startswith(_MAGIC) and head[68:] == _APPLICATION)):  # empty: its writer was killed before the first row
        what = "a file that is no store" if regular else "a folder" if found.is_dir() else "no file"
        raise StoreError(f"store: {str(found)!r} is {what} and has not been changed; give another name")
    return found


@contextmanager
def _as_store_error(path: Path) -> Iterator[None]:
    try:
        yield
    except (sqlite3.Error, OSError, ValueError) as error:
        if isinstance(error, StoreError):
            raise
        damaged = isinstance(error, sqlite3.DatabaseError) and not isinstance(error, sqlite3.OperationalError)
        remedy = "move it away and start again" if damaged else "make room, or see that it and its folder stay and can be written, and start again"
        raise StoreError(
            f"store: {str(path)!r} {'is damaged' if damaged else 'cannot be used'} ({error}); {remedy}; what is finished is in `table` of this error"
        ) from error


def _to_sqlite(value: Any, kind: type) -> Any:
    """The value in sqlite, which has neither NaN nor a sign of zero."""
    if value is None or value != value:
        return None
    return kind(value) + 0.0 if kind is float else kind(value)


def _from_sqlite(value: Any, kind: type) -> Any:
    return float("nan") if value is None and kind is float else value


def _checksum(values: tuple[Any, ...]) -> int:
    return zlib.crc32(repr(values).encode())
