"""Runs of a study: their input, their rows of results, where they are followed, and the sqlite file that keeps them."""

import hashlib
import os
import sqlite3
import time
import warnings
import zlib
from collections import deque
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, Future
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from functools import cache, cached_property
from math import ceil
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from threadpoolctl import ThreadpoolController

from ..contact import Array, ContactSystem, LoadCycle, listed
from ..errors import FrictoptError, ModelError, StoreError
from ..limits import ShakedownLimit
from ..transients import steady_state
from ..transients.exact.kernel import compiled
from .starts import Start, root_mean_square

_libraries = cache(ThreadpoolController)  # of BLAS, found once
_TASKS = 256  # that an executor has at a time; each holds the arrays of its contact
_SECONDS = 1.0  # after which a task begins no other run

Row = dict[str, Any]
FAILED = "FAILED"  # outcome of a run that has no result, which other versions may have
_KINDS = dict.fromkeys("key start outcome engine error".split(), "str") | dict.fromkeys("cycles slipping open".split(), "Int64")
_NAMES = (
    "key friction friction_std load_factor start amplitude outcome dissipation first_cycle largest_share cycles slipping open residual engine "
    "seconds error"
).split()
TYPES = {name: _KINDS.get(name, "float64") for name in _NAMES}  # of the columns in a DataFrame
_SQL = {"str": "text", "float64": "real", "Int64": "integer"}
_DECLARED = ", ".join(f"{name} {_SQL[kind]}" for name, kind in TYPES.items())
_SCHEMA = f"CREATE TABLE runs ({_DECLARED}, checksum integer, PRIMARY KEY (key)) WITHOUT ROWID"
_VERSION = 4  # of what the columns mean
_PATIENCE = 60  # seconds to wait for another writer


@dataclass(frozen=True, eq=False)
class Case:
    """The input that all runs of a study at one friction share: a limit of None is one that no solver proves, `number` its place in the list."""

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    limit: ShakedownLimit | None
    number: int = 0

    @cached_property
    def digest(self) -> bytes:
        """Digest of the content."""
        reactions = *self.cycle.mean_reaction(self.system), *self.cycle.corner_reactions(self.system)
        fixed = () if self.cycle.fixed is None else self.cycle.unscaled_reactions(self.system)
        return _digest(self.system.S, self.system.gap, self.friction, *reactions, *fixed)


@dataclass(frozen=True, eq=False)
class Run:
    """One transient: its case, its load factor and its start."""

    case: Case
    load_factor: float
    start: Start

    @cached_property
    def key(self) -> str:
        """A digest of the content; a safe slip enters by its definition, because solvers may find different ones."""
        state, start = self.start.state, self.start
        arrays = () if state is None else (state.slip, state.gap, state.bonded_q, state.bonded_p, state.next_corner)
        content = _digest(*arrays, self.load_factor, start.slip, start.safe_multiple, start.overload)
        return hashlib.sha256(self.case.digest + content).hexdigest()[:40]


def _digest(*values: ArrayLike | None) -> bytes:
    parts = (b"-" if value is None else np.ascontiguousarray(value, dtype=np.float64).tobytes() for value in values)
    return hashlib.sha256(b"".join(hashlib.sha256(part).digest() for part in parts)).digest()


def execute(runs: Sequence[Run], executor: Executor | None) -> Generator[tuple[list[Row], bool]]:
    """Follow runs, here or by an executor, and yield their rows as they finish, in any order; closing the iterator cancels the others.

    Rows come with whether they are results of their runs: they are not where the executor lost the runs.
    """
    if executor is None:
        yield from ((_follow([run]), True) for run in runs)
        return
    if any(run.case.system.tangents == 1 for run in runs):
        compiled()  # once for all processes here
    waiting, tasks, done = deque(runs), dict[Future[list[Row]], list[Run]](), SimpleQueue[Future[list[Row]]]()
    try:
        while waiting or tasks:
            while waiting and len(tasks) < _TASKS:
                batch = [waiting.popleft() for _ in range(ceil(len(waiting) / (_TASKS - len(tasks))))]
                try:
                    future = executor.submit(_follow, batch)
                except Exception as error:  # also in the middle, from a pool whose processes have died
                    if len(batch) + len(waiting) == len(runs):
                        what = f"executor: {executor!r} takes no runs ({type(error).__name__}: {error})"
                        raise ModelError(f"{what}; give one that is open, of concurrent.futures or dask") from error
                    future = Future()
                    future.set_exception(error)
                tasks[future] = batch
                future.add_done_callback(done.put)
            rows: list[Row] = []
            for future in [done.get(), *(done.get() for _ in range(done.qsize()))]:  # all at once, because a store may be slower than tasks
                batch = tasks.pop(future)
                try:
                    rows += (found := future.result())
                    waiting.extend(batch[len(found) :])
                except Exception as error:
                    yield [_failed(run, f"not followed, its executor lost it ({error!r}); start the study again") for run in batch], False
            yield rows, True
    finally:
        for future in tasks:
            with suppress(NotImplementedError):  # Parsl's futures
                future.cancel()


def _follow(runs: Sequence[Run]) -> list[Row]:
    """Follow the first run, and more until the time of a task is over; one BLAS thread: no row depends on the machine, except for its seconds."""
    rows, end = [], time.perf_counter() + _SECONDS
    with _libraries().limit(limits=1):
        for run in runs:
            rows.append(_row(run))
            if time.perf_counter() >= end:
                break
    return rows


def _row(run: Run) -> Row:
    began, case, start, slip = time.perf_counter(), run.case, run.start, np.zeros(run.case.system.slip_shape)
    try:
        given = start.slip_at(case.system, case.cycle, case.friction, run.load_factor, case.limit)
        slip = slip if given is None else given
        asked, begin = (case.system, case.cycle, case.friction, run.load_factor), slip if start.state is None else None
        steady = steady_state(*asked, initial_slip=begin, initial_state=start.state, overload=start.overload, progress=False)  # the study has a bar
    except FrictoptError as error:
        return _failed(run, f"{type(error).__name__}: {error}", time.perf_counter() - began) | {"amplitude": root_mean_square(slip)}
    share = float(steady.dissipation_per_node.max() / steady.dissipation) if steady.dissipation > 0 else 0.0
    counts = {name: int(np.count_nonzero(getattr(steady, name))) for name in ("slipping", "open")}
    found = {name: getattr(steady, name) for name in ("dissipation", "first_cycle", "cycles", "residual", "engine")}
    told = {"amplitude": root_mean_square(slip), "outcome": steady.outcome.name, "largest_share": share, "error": ""}
    return _input(run) | found | counts | told | {"seconds": time.perf_counter() - began}


def _failed(run: Run, error: str, seconds: float = np.nan) -> Row:
    """The row of a run that has no result."""
    return _input(run) | {"outcome": FAILED, "engine": "path" if run.case.system.tangents == 1 else "newton", "seconds": seconds, "error": error}


def _input(run: Run) -> Row:
    f = run.case.friction
    mean, spread = (f.mean(), f.std()) if np.ptp(f) > 0 else (f[0], 0.0)  # without rounding
    numbers = {"friction": float(mean), "friction_std": float(spread), "load_factor": run.load_factor}
    return {"key": run.key, "start": run.start.name} | numbers


class DamagedRows(UserWarning):
    """Rows of a store are damaged. They are ignored, and a study repeats their runs."""


class Store:
    """An open file of sqlite, which may be made and written, or is only read: one row for each run, whose key is a digest of the run's content.

    Rows that become known together are one transaction. So sqlite protects the file if a writer is killed, or if several write at the same time.
    """

    def __init__(self, path: str | os.PathLike[str], *, make: bool = True) -> None:
        with _errors(path):
            self.path = Path(path).expanduser().absolute()
            if not self.path.is_file() and (self.path.exists() or not make):
                raise FileNotFoundError("there is no such file")
            if make:
                self.path.parent.mkdir(parents=True, exist_ok=True)
            place = self.path if make else f"{self.path.as_uri()}?mode=ro"
            self._connection = sqlite3.connect(place, uri=not make, timeout=_PATIENCE, isolation_level=None)
            self.close, ask = self._connection.close, self._connection.execute
            self._connection.text_factory = lambda text: text.decode(errors="replace")  # the checksum tells such a row
            with ExitStack() as undo:
                undo.callback(self.close)
                if make:
                    ask("BEGIN IMMEDIATE")
                    if not ask("SELECT * FROM sqlite_master").fetchall():
                        ask(_SCHEMA)
                        ask(f"PRAGMA user_version = {_VERSION}")
                    ask("COMMIT")
                if ask("SELECT sql FROM sqlite_master").fetchall() != [(_SCHEMA,)] or ask("PRAGMA user_version").fetchone() != (_VERSION,):
                    raise sqlite3.DatabaseError("it is of another program, or of another version of frictopt, and its columns mean something else")
                undo.pop_all()

    def read(self) -> pd.DataFrame:
        """All rows, ordered by key; damaged rows are left out, with a warning."""
        with _errors(self.path):
            kept = self._connection.execute("SELECT * FROM runs ORDER BY key").fetchall()
        sound = [values for *values, checksum in kept if checksum == _checksum(values)]
        if damaged := len(kept) - len(sound):
            warnings.warn(f"store: {str(self.path)!r}: {damaged} rows are damaged and do not count", DamagedRows, stacklevel=3)
        return pd.DataFrame(sound, columns=list(TYPES)).astype(TYPES)

    def write(self, rows: Iterable[Mapping[str, Any]]) -> None:
        """Write rows, all or none, NULL for what they lack; a row replaces one with the same key, but a run that failed never replaces a result."""
        marks, changes = ", ".join("?" * (len(TYPES) + 1)), ", ".join(f"{name} = excluded.{name}" for name in (*TYPES, "checksum"))
        put = f"INSERT INTO runs VALUES ({marks}) ON CONFLICT (key) DO UPDATE SET {changes} WHERE excluded.outcome <> ? OR outcome = ?"
        with _errors(self.path), self._connection:
            self._connection.execute("BEGIN IMMEDIATE")
            self._connection.executemany(put, [(*(values := _values(row)), _checksum(values), FAILED, FAILED) for row in rows])


@contextmanager
def _errors(path: object) -> Iterator[None]:
    try:
        yield
    except (sqlite3.Error, OSError, TypeError, ValueError, RuntimeError) as error:  # RuntimeError: unknown home folder
        remedy = "give another name, or make room and see that it and its folder stay and can be written"
        raise StoreError(f"store: {str(path)!r} cannot be used ({error}); {remedy}") from error


def _values(row: Mapping[str, Any]) -> list[Any]:
    """What sqlite keeps of a row: it has neither NaN nor a sign of zero."""
    given: dict[str, Any] = {name: row.get(name) for name in TYPES}
    return [None if pd.isna(value) else float(value) + 0.0 if TYPES[name] == "float64" else value for name, value in given.items()]


def _checksum(values: list[Any]) -> int:
    return zlib.crc32(repr(values).encode())


def read_store(path: str | os.PathLike[str]) -> pd.DataFrame:
    """All runs of a file that `dissipation_study` was given as `store`, also while a study writes to it.

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

    It may exist, and keeps its own runs. A run that several of them hold counts once, with a result if one has it.

    Raises
    ------
    ModelError
        `parts` is no list.
    StoreError
        A file is not a store or is damaged, or the rows cannot be written.

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
    found = [row for part in listed("parts", parts) for row in read_store(part).to_dict("records")]
    with closing(Store(into)) as store:
        store.write(found)
        return len(store.read())
