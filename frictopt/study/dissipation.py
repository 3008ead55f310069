"""Studies: the steady states of many transients as one table."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing, nullcontext, suppress
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    LARGEST_SEED,
    Array,
    Bar,
    PerNode,
    check_text,
    choice,
    finite_array,
    finite_numbers,
    flag,
    frame,
    frozen,
    listed,
    number_of,
    progress_bar,
    real_array,
    shown,
    warns_of_odd_values,
    whole_number,
)
from ..base.checks import is_named
from ..base.results import drawn
from ..contact import ContactSystem, LoadCycle, checked_cycle, checked_system, friction_coefficients
from ..errors import ModelError, SolverError, StoreError
from ..limits import shakedown_limit
from .case import FAILED, LIMIT_COLUMNS, SHOWN, Case, Row, Run, digest, shown_row, sketch
from .runs import execute
from .starts import Start, given_slips, no_slip
from .store import Store


@warns_of_odd_values
def dissipation_study(
    system: ContactSystem,
    cycle: LoadCycle | Mapping[str, LoadCycle],
    friction: PerNode | Sequence[Any],
    load_factors: ArrayLike,
    starts: Sequence[Start] | ArrayLike | None = None,
    *,
    limits: bool = False,
    seed: int | None = None,
    shard: tuple[int, int] | None = None,
    executor: Executor | int | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Follow a transient to its steady state for each friction, load cycle, load factor and start.

    The method follows Flicek et al. 2015, section 5. A run that fails is a row with its error. If
    the bodies slide off at the loads of a run, its outcome is "SLIDES_OFF", and it counts as
    finished. The executor changes only the column seconds. Ctrl-C raises a KeyboardInterrupt whose
    attribute `table` has the finished runs. The store also holds them, and is closed.

    Parameters
    ----------
    system, load_factors
        The contact, and load factors, each >= 0.
    cycle
        The load cycle, or several as a mapping label -> load cycle, such as a load cycle for each
        preload or phase. The load cycles are then an axis of the study.
    friction
        Coefficient of friction, or a list of frictions. Each is a number, (N,) coefficients of the
        nodes, coefficients of the contacts by their names, or a frozen distribution of
        `scipy.stats`. From a distribution, the coefficient of each node is drawn independently:
        `[stats.norm(0.5, 0.05)] * 20` gives twenty contacts with scattered friction. A flat list
        with one number per node is refused, because it may mean a field or several frictions. Pass
        `[field]`, or a column of numbers (F, 1).
    starts
        A list of starts from `fo.starts` (such lists can be added), or an array of residual slips
        (S, N), in space (S, N, 2), length; None: no slip. A run fails if its slips stress the
        contact 1e18 times as much as the loads.
    limits
        Whether the table has the shakedown limit of each friction and load cycle. A limit takes
        longer than many transients. Limits are computed after all transients, and kept in the
        store.
    seed
        Seed of the distributions among the frictions, in their order. The same seed gives the same
        table.
    shard
        (k, n): follow only every n-th run, beginning with run k, where k is from 1 to n. Parts with
        separate stores need no shared file; the command `frictopt merge` puts the stores together.
        None: all runs.
    executor
        Number of processes of this machine, each with one BLAS thread; or any executor with the
        interface of `concurrent.futures`, such as a dask client's `get_executor()`; None: this
        process. An executor gets at most 256 tasks at a time. A task takes runs until one second
        has passed, and finishes the last run. Processes of this machine are replaced if they end
        early, and all of them end with this process. The runs of a lost task are divided between
        two new tasks, until the run that ends its tasks is alone. If a run is lost twice while it
        is alone, it fails, and its row says so.
    store
        File that keeps each run when its task ends; a run is identified by its content. A study
        that is started again, also after it was killed or on another machine, follows only runs
        that are missing or failed, or that another version of frictopt followed. Contacts are the
        same if their numbers differ by 1e-9 at most; random slips are the same if they have the
        same family, amplitude and seed. Several studies may share the file on a disk of this
        machine. `results.read_store` reads it.
    progress
        Whether to show count, rate and remaining time in a terminal or notebook.

    Returns
    -------
    DataFrame
        One row for each run, ordered by friction, load cycle, load factor and start as given. Its
        columns:

        - friction, friction_std: the number, or mean and standard deviation over the nodes
        - friction_number: place of the friction in its list
        - cycle: label of the load cycle, "" for a single load cycle
        - load_factor
        - load_ratio, shakedown_limit: only with `limits`, the shakedown limit of this friction and
          cycle (NaN if no solver proves one), and the load factor divided by it (NaN if it is not
          finite)
        - start, family, seed: see `Start`
        - amplitude: root mean square of the initial slip
        - outcome: the name of an `Outcome`; "SLIDES_OFF" if no forces within friction balance the
          loads, see `gross_slip`; or "FAILED"
        - dissipation: work of friction per cycle in the steady state
        - dissipation_scaled: `W E* / P^2` with P the total normal force of the mean load; NaN if
          `E_star` is not known, and in space
        - first_cycle: work in the first cycle
        - largest_share: share of the node with the largest dissipation
        - cycles: number of cycles followed
        - slipping, open: number of nodes that slip, and of nodes that open
        - residual, engine, seconds: residual, method and computing time of the run
        - error: text of the error if the run failed, or why the bodies slide off; otherwise empty

        `attrs["missing"]` is the number of runs without a row; it is above 0 only in the table of
        an error or an interrupt. `attrs["per_depth"]` states whether works are per unit depth.

    Raises
    ------
    ModelError
        Bad input, or an executor that takes no runs.
    StoreError
        The store is damaged, is not a store of frictopt, has runs of another load cycle under the
        same label, or cannot be written. After runs have begun, the attribute `table` of the error
        holds the finished runs.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> starts = fo.starts.no_slip() + fo.starts.overloads([1.5])
    >>> table = fo.dissipation_study(rod, cycle, 0.5, load_factors=[1.0], starts=starts)
    >>> table[["load_factor", "start", "outcome", "dissipation"]].round(6)
       load_factor            start      outcome  dissipation
    0          1.0             none  CYCLIC_SLIP          1.0
    1          1.0  overload to 1.5  CYCLIC_SLIP          1.0
    """
    fields = friction_fields(friction, checked_system(system), seed)
    cycles = checked_cycles(cycle)
    factors = finite_numbers("load_factors", load_factors, least=0.0)
    if not factors or len(set(factors)) < len(factors):
        raise ModelError(f"load_factors: {shown(factors)}; give at least one, and each once")
    checked = checked_starts(starts, system.slip_shape)
    with_limits = flag("limits", limits)
    if isinstance(executor, int):
        executor = whole_number("executor", executor, least=1)
    combinations = list(product(range(len(fields)), cycles, factors, checked))
    if shard is not None:
        combinations = combinations[_checked_shard(shard)]

    with nullcontext() if store is None else closing(Store(store)) as file:
        study = _Study(system, cycles, fields, combinations, file, with_limits)
        study.find_limits_of_starts(progress)
        with progress_bar(
            progress,
            "transients",
            "run",
            total=len(study.keys),
            done=len(study.rows),
            at_once=True,
            on=(KeyboardInterrupt, StoreError),
        ) as bar:
            keep = partial(study.keep, bar)
            keep([])  # so that an interrupt of the first run has the rows of the file
            execute(study.missing(), executor, keep)
        if with_limits:
            study.find_limits(progress)
    return study.table()


class _Study:
    """The runs of a study, in their order, their known rows, and their shakedown limits.

    Attributes
    ----------
    cases, runs
        (number of the friction, label of the load cycle) -> case; and the runs in their order.
    keys
        Key of a run -> a run with this key. Runs with the same content share a key.
    rows
        Key of a run -> its row, as far as known.
    limits
        Key of a case -> load factor of its shakedown limit, as far as known.
    """

    def __init__(
        self,
        system: ContactSystem,
        cycles: Mapping[str, LoadCycle],
        frictions: Sequence[Array],
        combinations: list[tuple[int, str, float, Start]],
        file: Store | None,
        with_limits: bool,
    ) -> None:
        self.units = system.units
        self.per_depth = system.per_depth
        self.file = file
        self.with_limits = with_limits
        contacts = {
            label: digest(sketch(system, cycle).tobytes())
            if file is None
            else file.contact(sketch(system, cycle))
            for label, cycle in cycles.items()
        }
        self.cases = {
            (number, label): Case(
                system, cycles[label], frictions[number], contacts[label], number, label
            )
            for number, label in dict.fromkeys(combination[:2] for combination in combinations)
        }
        self.runs = [
            Run(self.cases[number, label], factor, start)
            for number, label, factor, start in combinations
        ]
        self.keys = {run.key: run for run in self.runs}
        self.rows: dict[str, Row] = {}
        self.limits: dict[str, float] = {}
        if file is not None:
            self._read(file, set(contacts.values()))

    def _read(self, file: Store, contacts: set[str]) -> None:
        """Take the rows and limits of these contacts that the file has."""
        file.check_cycles({case.label: case.loads for case in self.cases.values()})
        for row in file.own_rows(contacts):
            if row["key"] in self.keys and row["outcome"] != FAILED:
                self.rows[row["key"]] = row
        if self.with_limits:
            self.limits = file.read_limits()

    def missing(self) -> list[Run]:
        """The runs without a row."""
        return [run for key, run in self.keys.items() if key not in self.rows]

    def keep(self, bar: Bar, rows: list[Row]) -> None:
        """Keep rows, also for an interrupt, and write them to the file."""
        self.rows |= {row["key"]: row for row in rows}
        bar.keep("table", self.table, self._note())
        if self.file is not None and rows:
            self.file.write(rows)
        bar.update(len(self.rows) - bar.count)

    def _note(self) -> str:
        """How many runs are left, for an interrupt."""
        finished = sum(run.key in self.rows for run in self.runs)
        left = number_of(len(self.runs) - finished, "run is", "runs are")
        note = f"{left} left; the attribute `table` has {finished}"
        if self.file is not None:
            note += f", and so has {str(self.file.path)!r}, from which the same call continues"
        return note

    def find_limits_of_starts(self, progress: bool) -> None:
        """Find the shakedown limits that starts of missing runs need."""
        needed = [run.case for run in self.missing() if run.start.safe_multiple is not None]
        self._find(dict.fromkeys(needed), progress)

    def find_limits(self, progress: bool) -> None:
        """Find the shakedown limits of the table that the file does not have."""
        needed = [case for case in self.cases.values() if case.key not in self.limits]
        self._find(needed, progress)

    def _find(self, cases: Collection[Case], progress: bool) -> None:
        """Find the shakedown limits of cases, and keep each of them."""
        with progress_bar(progress, "limits", "limit", total=len(cases)) as bar:
            bar.keep("table", self.table, self._note())
            for case in cases:
                with suppress(SolverError):
                    case.limit = shakedown_limit(
                        case.system, case.cycle, case.friction, progress=progress
                    )
                    self.limits[case.key] = case.limit.load_factor
                    if self.file is not None:
                        self.file.write_limits({case.key: case.limit.load_factor})
                bar.update()

    def table(self) -> pd.DataFrame:
        """The runs that have a row, with their shakedown limits if the table shall have them."""
        records = [
            shown_row(run, self.rows[run.key], self.limits.get(run.case.key))
            for run in self.runs
            if run.key in self.rows
        ]
        columns = {
            name: dtype
            for name, dtype in SHOWN.items()
            if self.with_limits or name not in LIMIT_COLUMNS
        }
        table = frame(records, self.units, list(columns)).astype(columns)
        table.attrs["missing"] = len(self.runs) - len(records)
        table.attrs["per_depth"] = self.per_depth
        return table


def _checked_shard(shard: object) -> slice:
    """The slice of all runs that belongs to a part."""
    part = listed("shard", shard)
    if len(part) != 2:
        raise ModelError(f"shard: {shown(shard)}; give (k, n), the k-th of n parts")
    count = whole_number("shard n", part[1], least=1)
    first = whole_number("shard k", part[0], least=1, most=count) - 1
    return slice(first, None, count)


def checked_cycles(cycle: object) -> dict[str, LoadCycle]:
    """The load cycles of a study by their labels; a single load cycle has the label ""."""
    if not isinstance(cycle, Mapping):
        return {"": checked_cycle(cycle)}
    if not cycle:
        raise ModelError("cycle: empty; give a LoadCycle, or label -> LoadCycle")
    for label, labelled in cycle.items():
        check_text("cycle", label, "a printable text", "label ")
        checked_cycle(labelled, f"cycle[{label!r}]")
    return dict(cycle)


def checked_starts(
    starts: Sequence[Start] | ArrayLike | None, slip_shape: tuple[int, ...]
) -> list[Start]:
    """Check the starts of a contact: a list of `Start`, slips (S, *slip_shape), or None."""
    if starts is None:
        return no_slip()
    items = listed("starts", starts)
    if not items:
        raise ModelError("starts: empty; give at least one start")
    if not any(isinstance(start, Start) for start in items):
        return given_slips(finite_array("starts", starts, (None, *slip_shape)))
    for start in items:
        _check_start(start, slip_shape)
    ((name, count),) = Counter(start.name for start in items).most_common(1)
    if count > 1:
        raise ModelError(
            f"starts: two starts are called {name!r}; give them different names or seeds"
        )
    return items


def _check_start(start: object, slip_shape: tuple[int, ...]) -> None:
    if not isinstance(start, Start):
        raise ModelError(
            f"starts: a {type(start).__name__} among starts; make starts from slips by "
            "given_slips, and join lists by +"
        )
    slip = start.slip if start.state is None else start.state.slip
    if slip is not None and slip.shape != slip_shape:
        raise ModelError(
            f"starts: start {start.name!r} has a slip of shape {slip.shape}, the contact needs "
            f"{slip_shape}"
        )


def friction_fields(friction: Any, system: ContactSystem, seed: object) -> list[Array]:
    """(N,) coefficients of a single friction, or of each in a list; see `dissipation_study`."""
    is_list = np.iterable(friction) and not (
        isinstance(friction, str | bytes) or is_named(friction)
    )
    items = list(friction) if is_list else [friction]
    nodes = system.nodes
    if not items:
        raise ModelError("friction: empty; give at least one coefficient")
    if is_list and len(items) == nodes > 1 and all(_is_number(item) for item in items):
        raise ModelError(
            f"friction: {nodes} numbers for {nodes} nodes, which may be one friction per node or "
            f"{nodes} frictions; give [friction] or np.c_[friction]"
        )
    generator = None
    if seed is not None:
        generator = np.random.default_rng(whole_number("seed", seed, least=0, most=LARGEST_SEED))
    return [_field(item, system, generator) for item in items]


def _is_number(item: object) -> bool:
    """Whether an item is neither a field nor a distribution."""
    return not np.iterable(item) and not hasattr(item, "rvs")


def _field(item: Any, system: ContactSystem, generator: Any) -> Array:
    """(N,) coefficients of one friction: a number, a field, or drawn from a distribution."""
    if hasattr(item, "rvs"):
        if generator is None:
            raise ModelError(
                "seed: None, and friction has a distribution; give a seed, so that the study can "
                "be repeated"
            )
        item = real_array("friction", item.rvs(size=system.nodes, random_state=generator))
        if (item < 0).any():
            raise ModelError(
                f"friction: a distribution draws {item.min():.6g} at node {item.argmin()}; give "
                "one that is never negative, such as scipy.stats.truncnorm or lognorm"
            )
    elif isinstance(item, np.ndarray) and item.shape == (1,):
        item = item[0]  # a row of a column of numbers, np.c_[...]
    return frozen(friction_coefficients(item, system))


_NEEDED = ("friction", "cycle", "load_factor", "family", "outcome", "dissipation", "engine")


def plot_study(
    table: pd.DataFrame,
    ax: Any = None,
    *,
    x: str | None = None,
    colour: str | None = None,
) -> Any:
    """Draw the steady dissipation of each run of a study against its load: a mark for each start.

    Columns of the table, also columns that you add, split it: `plot_study(table, x="cycle",
    colour="friction")`. Runs that shake down have no dissipation. Runs that failed or slide
    off have no mark; the title counts them.

    Parameters
    ----------
    table
        The table of `dissipation_study`, or rows of it.
    ax
        matplotlib axes to draw in; None: a new figure.
    x
        Column along the horizontal axis. None: the load factor, divided by the shakedown limit if
        the table has a finite limit for all runs; friction if all runs have one load factor.
    colour
        Column whose values have different colours. None: friction if it has several values and is
        not along the horizontal axis; otherwise the load cycle if it has several values; otherwise
        the family of the starts.

    Returns
    -------
    matplotlib.axes.Axes
        The axes of the picture.

    Raises
    ------
    ModelError
        The table, a column or `ax` is unsuitable.
    ImportError
        matplotlib is not installed.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> axes = fo.plot_study(fo.dissipation_study(rod, cycle, 0.5, load_factors=[0.3, 1.0]))
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['no slip']
    """
    if any(name not in getattr(table, "columns", ()) for name in _NEEDED):
        raise ModelError(
            f"table: give the DataFrame of dissipation_study, with the columns {', '.join(_NEEDED)}"
        )
    for name, column in (("x", x), ("colour", colour)):
        if column is not None:
            choice(name, column, list(table.columns))
    return drawn(table, __name__, ax, x=x, colour=colour)
