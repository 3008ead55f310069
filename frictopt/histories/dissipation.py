"""Studies: the steady states of many transients as one table, for one friction or many; what a study asks may stand in a file."""

from __future__ import annotations

import os
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, closing, suppress
from functools import partial
from inspect import signature
from itertools import product
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy import stats

from ..contact import ContactSystem, LoadCycle, bar_of, checked_cycle, checked_system, friction_coefficients
from ..contact.checks import LARGEST_SEED, Array, choice, finite_array, finite_numbers, flag, frozen, listed, shown, warns_of_odd_values, whole_number
from ..contact.files import WRITERS, output
from ..errors import ModelError, SolverError, StoreError
from ..limits import ShakedownLimit, shakedown_limit
from . import starts as families
from .runs import FAILED, TYPES, Case, Row, Run, Store, execute
from .starts import Start, given_slips, no_slip

T = TypeVar("T")
_COLUMNS = (
    "friction friction_std friction_number load_factor load_ratio shakedown_limit start family seed amplitude outcome dissipation dissipation_scaled "
    "first_cycle largest_share cycles slipping open residual engine seconds error"
).split()
_TYPES = {"seed": "Int64", "friction_number": "int64", "family": "str", **TYPES}
_NEEDED = ("system", "cycle", "friction", "load_factors")
_KNOWN = (*_NEEDED, "starts", "store", "table", "picture")
_STARTS = ("no_slip", "safe_slips", "random_slips", "overloads")
_READERS = {".csv": pd.read_csv, ".xlsx": pd.read_excel, ".parquet": pd.read_parquet}


@warns_of_odd_values
def dissipation_study(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: object,
    load_factors: Iterable[float],
    starts: Sequence[Start] | ArrayLike | None = None,
    *,
    rng: int | np.random.Generator | None = None,
    shard: tuple[int, int] | None = None,
    executor: Executor | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Follow a transient to its steady state at every friction and load factor and from every start (Flicek et al. 2015, section 5).

    A run that fails is a row with its error. The executor only changes the column seconds. Ctrl-C stays a KeyboardInterrupt with an attribute
    `table`, that of the finished runs. The store is closed then and holds them too.

    Parameters
    ----------
    system, cycle, load_factors
        The contact, its load cycle, and load factors, each >= 0.
    friction
        Coefficient of friction; or a list of frictions. Each is a number, (N,) coefficients of the nodes, or a frozen distribution of `scipy.stats`,
        from which each node draws its own coefficient: `[stats.norm(0.5, 0.05)] * 20` is twenty contacts of scattered friction. A flat list of as
        many numbers as the contact has nodes is refused, because it may mean both: give `[field]`, or a column of numbers (F, 1).
    starts
        Starts, as `fo.starts` makes them (add their lists); or an array of residual slips (S, N), in space (S, N, 2), length; None: no slip. Slips
        that stress the contact more than 1e18 times as much as the loads fail.
    rng
        Seed or generator of the distributions among the frictions, which draw one after the other; a seed gives the same table again.
    shard
        (k, n): follow only the k-th of n parts of the runs, k from 1 to n, each n-th run. Parts with stores of their own need no shared file; the
        command `frictopt merge` puts the stores together. None: all runs.
    executor
        Any executor of `concurrent.futures`' interface, such as a `ProcessPoolExecutor` or a dask client's `get_executor()`; None: this process. It
        gets at most 256 tasks at a time; each ends with the run in which its first second is over. A run that it loses is a row that says so.
    store
        File that keeps each run by its content when its task ends: a study that is started again, also after it was killed, computes only the missing
        runs and those that failed. Several studies may share the file on a disk of this machine. `results.read_store` reads it.
    progress
        Show count, rate and time left, on a terminal and in a notebook.

    Returns
    -------
    DataFrame
        One row for each run, ordered by friction, load factor and start as given. Columns: friction, the number or the mean over the nodes;
        friction_std, its standard deviation over the nodes; friction_number, its place in the list; load_factor; load_ratio, over the shakedown limit
        (NaN if that is not finite); shakedown_limit, at this friction (NaN if no solver proves one); start, family, seed, see `Start`; amplitude,
        root mean square of the initial slip; outcome, the name of an `Outcome`, or "FAILED"; dissipation, work of friction per cycle in the steady
        state; dissipation_scaled, `W E* / P^2` with P the total normal force of the mean load (NaN if `E_star` is not known, and in space);
        first_cycle, work in the first cycle; largest_share, that of the node that dissipates most; cycles followed; slipping and open, numbers of
        nodes; residual; engine; seconds; error, the text for a run that failed, else empty. `attrs` holds "missing", the number of runs without a row
        in the table of an error.

    Raises
    ------
    ModelError
        Bad input, or an executor that takes no runs.
    StoreError
        The store is damaged, is not a store of frictopt, or cannot be written; `table` of the error holds the finished runs.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> starts = fo.starts.no_slip() + fo.starts.overloads([1.5])
    >>> table = fo.dissipation_study(rod, cycle, friction=0.5, load_factors=[1.0], starts=starts, progress=False)
    >>> table[["load_factor", "start", "outcome", "dissipation"]].round(6)
       load_factor            start      outcome  dissipation
    0          1.0             none  CYCLIC_SLIP          1.0
    1          1.0  overload to 1.5  CYCLIC_SLIP          1.0
    """
    fields = friction_fields(friction, checked_system(system).nodes, rng)
    checked_cycle(cycle)
    factors = finite_numbers("load_factors", load_factors, least=0.0)
    if not factors or len(set(factors)) < len(factors):
        raise ModelError(f"load_factors: {shown(factors)}; give at least one, and each once")
    begins, chosen = checked_starts(starts, system.slip_shape), slice(None) if shard is None else _checked_shard(shard)
    flag("progress", progress)
    wanted = list(product(range(len(fields)), factors, begins))[chosen]
    rows: dict[str, Row] = {}
    with ExitStack() as stack:
        kept = None if store is None else stack.enter_context(closing(Store(store)))
        cases = {number: Case(system, cycle, f := fields[number], _limit(system, cycle, f), number) for number in sorted({one[0] for one in wanted})}
        runs = [Run(cases[number], factor, start) for number, factor, start in wanted]
        keys, table = {run.key: run for run in runs}, partial(_table, system, cycle, runs, rows)
        try:
            if kept is not None:
                rows.update((row["key"], row) for row in kept.read().to_dict("records") if row["key"] in keys and row["outcome"] != FAILED)
            missing = [run for key, run in keys.items() if key not in rows]
            bar = stack.enter_context(bar_of(progress, "transients", "run", total=len(keys), initial=len(rows)))
            for found, answered in stack.enter_context(closing(execute(missing, executor))):
                rows.update((row["key"], row) for row in found)
                if kept is not None and answered:
                    kept.write(found)
                bar.update(len(found))
        except (StoreError, KeyboardInterrupt) as error:
            done = error.table = table()  # type: ignore[union-attr]  # no class of its own: the exit status stays Python's
            known = "" if kept is None else f" and in {str(kept.path)!r}, from where the same call goes on"
            error.add_note(f"dissipation_study: {done.attrs['missing']} runs are left; {len(done)} are in the attribute `table`{known}")
            raise
    return table()


def _table(system: ContactSystem, cycle: LoadCycle, runs: Sequence[Run], rows: Mapping[str, Row]) -> pd.DataFrame:
    """The runs that have a row, in their order."""
    records = []
    for run in (run for run in runs if run.key in rows):
        start, limit = run.start, np.nan if run.case.limit is None else run.case.limit.load_factor
        named = {"start": start.name, "family": start.family, "seed": start.seed, "friction_number": run.case.number, "shakedown_limit": limit}
        records.append(rows[run.key] | named)
    table = pd.DataFrame(records, columns=_COLUMNS).astype({name: _TYPES.get(name, "float64") for name in _COLUMNS})
    limits, force = table["shakedown_limit"], float(cycle.mean_reaction(system)[1].sum())
    table["load_ratio"] = table["load_factor"] / limits.where((limits > 0) & np.isfinite(limits))
    modulus = system.E_star if system.E_star and system.tangents == 1 else np.nan
    table["dissipation_scaled"] = table["dissipation"] * (modulus / force**2 if force**2 > 0 else np.nan)
    table.attrs = {"missing": len(runs) - len(records)} | ({} if system.units is None else {"units": system.units})
    return table


def _checked_shard(shard: object) -> slice:
    """Which of all runs a part of them has."""
    part = listed("shard", shard)
    if len(part) != 2:
        raise ModelError(f"shard: {shown(shard)}; give (k, n), the k-th of n parts")
    count = whole_number("shard n", part[1], least=1)
    return slice(whole_number("shard k", part[0], least=1, most=count) - 1, None, count)


def _limit(system: ContactSystem, cycle: LoadCycle, friction: Array) -> ShakedownLimit | None:
    with suppress(SolverError):
        return shakedown_limit(system, cycle, friction)
    return None


def checked_starts(starts: Sequence[Start] | ArrayLike | None, slip_shape: tuple[int, ...]) -> list[Start]:
    """Check starts for a contact: a list of `Start`, an array of slips, (S, *slip_shape), or None."""
    starts = no_slip() if starts is None else list(starts) if isinstance(starts, Iterator) else starts
    if isinstance(starts, Sequence) and not starts:
        raise ModelError("starts: empty; give at least one start")
    if not np.iterable(starts) or not any(isinstance(start, Start) for start in starts):
        return given_slips(finite_array("starts", starts, (None, *slip_shape)))
    given: list[Any] = list(starts)
    for start in given:
        if not isinstance(start, Start):
            raise ModelError(f"starts: a {type(start).__name__} among starts; make starts of slips by given_slips, and add lists up")
        slip = start.slip if start.state is None else start.state.slip
        if slip is not None and slip.shape != slip_shape:
            raise ModelError(f"starts: start {start.name!r} has a slip of shape {slip.shape}, the contact needs {slip_shape}")
    ((name, count),) = Counter(start.name for start in given).most_common(1)
    if count > 1:
        raise ModelError(f"starts: two starts are called {name!r}; give them different names or seeds")
    return given


def friction_fields(friction: Any, nodes: int, rng: object) -> list[Array]:
    """(N,) coefficients of each friction: of one, or of a list of numbers, fields and distributions; see `dissipation_study`."""
    several = np.iterable(friction) and not isinstance(friction, str | bytes | Mapping)
    items = list(friction) if several else [friction]
    if not items:
        raise ModelError("friction: empty; give at least one coefficient")
    if several and len(items) == nodes > 1 and not any(np.iterable(item) or hasattr(item, "rvs") for item in items):
        raise ModelError(f"friction: {nodes} numbers for {nodes} nodes, one friction or {nodes} of them; give [friction] or np.c_[friction]")
    generator = _generator(rng)
    values = [_drawn(item, nodes, generator) if hasattr(item, "rvs") else item for item in items]
    values = [value[0] if isinstance(value, np.ndarray) and value.shape == (1,) else value for value in values]  # rows of a column, np.c_[...]
    return [frozen(friction_coefficients(value, nodes)) for value in values]


def _generator(rng: object) -> np.random.Generator | None:
    if rng is None or isinstance(rng, np.random.Generator):
        return rng
    return np.random.default_rng(whole_number("rng", rng, least=0, most=LARGEST_SEED))


def _drawn(distribution: Any, nodes: int, generator: np.random.Generator | None) -> Array:
    if generator is None:
        raise ModelError("rng: None, and friction has a distribution; give a seed, so that the study can be repeated")
    return frozen(distribution.rvs(size=nodes, random_state=generator))


def read_plan(file: str | Path) -> tuple[dict[str, Any], dict[str, Path]]:
    """Arguments of `dissipation_study` from a file of TOML, and the files to be written: store, and table and picture where they are named.

    Names of files are relative to the folder of the file. `system`, `cycle` (the arguments of `LoadCycle`, or a `history` with those of
    `from_history`), `friction` (a number, a list, or a `distribution` of scipy.stats with its parameters, `draws` and the seed `rng`), `load_factors`
    and, if wanted, `starts` (name of a function of `fo.starts` -> its arguments), `store`, `table` and `picture`. ModelError: not such a file, or
    something in it that the study would refuse.
    """
    path = Path(file)
    try:
        plan = tomllib.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ModelError(f"{file}: {error}; give a file in TOML") from error
    unknown, missing = sorted(set(plan) - set(_KNOWN)), [name for name in _NEEDED if name not in plan]
    wrong = [f"{', '.join(names)} {verb}" for names, verb in ((unknown, "unknown"), (missing, "missing")) if names]
    if wrong:
        raise ModelError(f"{file}: {' and '.join(wrong)}; a study has {', '.join(_KNOWN)}")
    names = {name: path.parent / _told(name, plan[name], str) for name in ("system", "store", "table", "picture") if name in plan}
    files = {"store": names.get("store", path.with_suffix(".sqlite"))}
    files |= {name: output(names[name], *endings) for name, endings in (("table", WRITERS), ("picture", ())) if name in names}
    system, friction, given = ContactSystem.load(names["system"]), plan["friction"], dict(_told("cycle", plan["cycle"], dict))
    history = (read_table(path.parent / str(given.pop("history"))),) if "history" in given else ()
    cycle = _called("cycle", LoadCycle.from_history if history else LoadCycle, *history, **given)
    drawn = _distributions(**friction) if isinstance(friction, dict) else {"friction": friction}
    begins = list[Start]()
    for name, options in _told("starts", plan.get("starts", {"no_slip": {}}), dict).items():
        first = (system,) if choice("starts", name, _STARTS) == "random_slips" else ()
        begins += _called(f"starts.{name}", getattr(families, name), *first, **_told(f"starts.{name}", options, dict))
    return {"system": system, "cycle": cycle, "load_factors": plan["load_factors"], "starts": begins, **drawn}, files


def _told(name: str, value: object, kind: type[T]) -> T:
    """A part of a plan, of a kind that it needs."""
    if not isinstance(value, kind):
        raise ModelError(f"{name}: {value!r}; give {'the name of a file' if kind is str else f'a table of TOML, [{name}]'}")
    return value


def _called(what: str, function: Callable[..., T], *first: Any, **options: Any) -> T:
    """The value of a function whose options come from a file."""
    try:
        return function(*first, **options)
    except TypeError as error:  # an option that it does not have, or lacks
        parameters = signature(function).parameters.values()
        known = [one.name for one in parameters if one.kind in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY)][len(first) :]
        raise ModelError(f"{what}: {error}" + (f"; its options are {', '.join(known)}" if known else "")) from error


def _distributions(distribution: object = None, draws: object = 1, rng: object = 0, **parameters: Any) -> dict[str, Any]:
    """Frictions and seed."""
    kind = getattr(stats, distribution, None) if isinstance(distribution, str) else None
    if not isinstance(kind, stats.rv_continuous) or not isinstance(draws, int):
        raise ModelError(f"friction: distribution {distribution!r}, draws {draws!r}; give one of scipy.stats, such as 'norm', and a number")
    return {"friction": [_called("friction", kind, **parameters)] * draws, "rng": rng}


def read_table(file: str | Path) -> pd.DataFrame:
    """The table of a file of pandas; ModelError: another ending, or no table."""
    path = Path(file)
    if path.suffix not in _READERS:
        raise ModelError(f"history: {str(file)!r}; give a file that ends in {', '.join(_READERS)}")
    try:
        table = _READERS[path.suffix](path)
    except ValueError as error:
        raise ModelError(f"history: {str(file)!r} is no table ({error})") from error
    if path.suffix == ".csv" and (not isinstance(table.index, pd.RangeIndex) or all(";" in str(name) for name in table)):
        raise ModelError(
            f"history: {str(file)!r} has semicolons between its columns, or rows of more values than names; write commas between columns and points "
            "in the numbers, and name each column"
        )
    for name in table.select_dtypes(exclude=["number", "datetime"]):
        with suppress(ValueError, TypeError):  # what is no date, the load cycle refuses by its name
            table[name] = pd.to_datetime(table[name], format="ISO8601")
    return table
