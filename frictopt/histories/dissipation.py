"""Studies: the steady states of many transients as one table, for one friction or many."""

import os
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, closing
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle, bar_of, checked_cycle, checked_system, friction_coefficients
from ..contact.checks import LARGEST_SEED, Array, finite_numbers, flag, frozen, listed, shown, warns_of_odd_values, whole_number
from ..errors import ModelError, SolverError, StoreError
from ..limits import ShakedownLimit, shakedown_limit
from .run import Case, Row, Run, execute
from .starts import Start, checked_starts
from .store import FAILED, TYPES, Store

_COLUMNS = (
    "friction friction_std friction_number load_factor load_ratio shakedown_limit start family seed amplitude outcome dissipation dissipation_scaled "
    "first_cycle largest_share cycles slipping open residual engine seconds error"
).split()
_TYPES = {"seed": "Int64", "friction_number": "int64", "family": "str", **TYPES}


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
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction; or a list of frictions. Each is a number, (N,) coefficients of the nodes, or a frozen distribution of `scipy.stats`,
        from which each node draws its own coefficient: `[stats.norm(0.5, 0.05)] * 20` is twenty contacts of scattered friction. A flat list of as
        many numbers as the contact has nodes is refused, because it may mean both: give `[field]`, or a column of numbers (F, 1).
    load_factors
        Load factors, each >= 0.
    starts
        Starts, as `fo.starts` makes them (`no_slip`, `safe_slips`, `random_slips`, `overloads`, `given_slips`; add their lists); or an array of
        residual slips (S, N), in three dimensions (S, N, 2), length; None: no slip. Slips that stress the contact more than 1e18 times as much as
        the loads fail.
    rng
        Seed or generator of the distributions among the frictions, which draw one after the other; a seed gives the same table again.
    shard
        (k, n): follow only the k-th of n parts of the runs, k from 1 to n, each n-th run. Parts with stores of their own need no shared file; the
        command `frictopt merge` puts the stores together. None: all runs.
    executor
        Any executor of `concurrent.futures`' interface, such as a `ProcessPoolExecutor` or a dask client's `get_executor()`; None: runs are
        followed one by one in this process. It gets at most 256 tasks at a time; each ends with the run in which its first second is over. A run that
        it loses is a row that says so, and is not kept in the store.
    store
        File that keeps each run by its content when its task ends: a study that is started again, also after it was killed, computes only the missing
        runs and those that failed, which other versions may follow. Several studies may share the file on a disk of this machine.
        `results.read_store` reads it.
    progress
        Show count, rate and time left, on a terminal and in a notebook.

    Returns
    -------
    DataFrame
        One row for each run, ordered by friction, load factor and start as given. Columns: friction, the number or the mean over the nodes;
        friction_std, its standard deviation over the nodes; friction_number, its place in the list; load_factor; load_ratio, over the shakedown limit
        (NaN if that is not finite); shakedown_limit, at this friction (NaN if no solver proves one); start, family, seed, see `Start`; amplitude,
        root mean square of the initial slip; outcome, the name of an `Outcome`, or "FAILED"; dissipation, work of friction per cycle in the steady
        state; dissipation_scaled, `W E* / P^2` with P the total normal force of the mean load (NaN if the system does not know its `E_star`, and in
        three dimensions); first_cycle, work in the first cycle; largest_share, that of the node that dissipates most; cycles followed; slipping and
        open, numbers of nodes; residual; engine; seconds; error, the text for a run that failed, else empty. `attrs` holds "missing", the number of
        runs without a row in the table of an error. With xarray installed,
        `table.set_index(["friction_number", "load_factor", "start"]).to_xarray()` is a Dataset.

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
    >>> table = fo.dissipation_study(rod, cycle, friction=0.5, load_factors=[0.4, 1.0], starts=starts, progress=False)
    >>> table[["load_factor", "start", "outcome", "dissipation"]].round(6)
       load_factor            start      outcome  dissipation
    0          0.4             none    SHAKEDOWN          0.0
    1          0.4  overload to 1.5    SHAKEDOWN          0.0
    2          1.0             none  CYCLIC_SLIP          1.0
    3          1.0  overload to 1.5  CYCLIC_SLIP          1.0
    """
    fields = friction_fields(friction, checked_system(system).nodes, rng)
    checked_cycle(cycle)
    factors = finite_numbers("load_factors", load_factors, least=0.0)
    if not factors or len(set(factors)) < len(factors):
        raise ModelError(f"load_factors: {shown(factors)}; give at least one, and each once")
    begins = checked_starts(starts, system.slip_shape)
    flag("progress", progress)
    chosen = slice(None) if shard is None else _checked_shard(shard)
    wanted = list(product(range(len(fields)), factors, begins))[chosen]
    rows: dict[str, Row] = {}
    with ExitStack() as stack:
        kept = None if store is None else stack.enter_context(closing(Store(store)))
        cases = {number: Case(system, cycle, f := fields[number], _limit(system, cycle, f), number) for number in sorted({one[0] for one in wanted})}
        runs = [Run(cases[number], factor, start) for number, factor, start in wanted]
        keys = {run.key: run for run in runs}
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
            return _table(runs, rows)
        except StoreError as error:
            error.table = _table(runs, rows)
            raise
        except KeyboardInterrupt as interrupt:
            table = interrupt.table = _table(runs, rows)  # type: ignore[attr-defined]  # no class of its own: the exit status stays Python's
            known = "" if kept is None else f" and in {str(kept.path)!r}, from where the same call goes on"
            interrupt.add_note(f"dissipation_study: {table.attrs['missing']} runs are left; {len(table)} are in the attribute `table`{known}")
            raise


def _table(runs: Sequence[Run], rows: Mapping[str, Row]) -> pd.DataFrame:
    """The runs that have a row, in their order."""
    case = runs[0].case if runs else None
    force = 0.0 if case is None else abs(float(case.cycle.mean_reaction(case.system)[1].sum()))
    modulus = None if case is None or case.system.tangents > 1 else case.system.E_star
    scale = np.nan if modulus is None or not force**2 > 0 else modulus / force**2
    records = []
    for run in (run for run in runs if run.key in rows):
        row, start, limit = rows[run.key], run.start, np.nan if run.case.limit is None else run.case.limit.load_factor
        ratio = run.load_factor / limit if limit > 0 and np.isfinite(limit) else np.nan
        names = {"start": start.name, "family": start.family, "seed": start.seed, "friction_number": run.case.number}
        found = {"load_ratio": ratio, "shakedown_limit": limit, "dissipation_scaled": row.get("dissipation", np.nan) * scale}
        records.append({**row, **names, **found})
    table = pd.DataFrame(records, columns=_COLUMNS).astype({name: _TYPES.get(name, "float64") for name in _COLUMNS})
    units = {} if case is None or case.system.units is None else {"units": case.system.units}
    table.attrs = {"missing": len(runs) - len(records), **units}
    return table


def _checked_shard(shard: object) -> slice:
    """Which of all runs a part of them has."""
    part = listed("shard", shard)
    if len(part) != 2:
        raise ModelError(f"shard: {shown(shard)}; give (k, n), the k-th of n parts")
    count = whole_number("shard n", part[1], least=1)
    return slice(whole_number("shard k", part[0], least=1, most=count) - 1, None, count)


def _limit(system: ContactSystem, cycle: LoadCycle, friction: Array) -> ShakedownLimit | None:
    try:
        return shakedown_limit(system, cycle, friction)
    except SolverError:
        return None


def friction_fields(friction: Any, nodes: int, rng: object) -> list[Array]:
    """(N,) coefficients of each friction: of one, or of a list of numbers, fields and distributions; see `dissipation_study`."""
    if isinstance(friction, Mapping):
        raise ModelError(f"friction: a {type(friction).__name__}; give a coefficient, or a list of frictions")
    several = np.iterable(friction) and not isinstance(friction, str | bytes)
    items = list(friction) if several else [friction]
    if not items:
        raise ModelError("friction: empty; give at least one coefficient")
    if several and len(items) == nodes > 1 and not any(np.iterable(item) or hasattr(item, "rvs") for item in items):
        raise ModelError(
            f"friction: {nodes} numbers for {nodes} nodes, one friction of all nodes or {nodes} frictions; give [friction] or np.c_[friction]"
        )
    if any(hasattr(item, "rvs") for item in items) and rng is None:
        raise ModelError("rng: None, and friction has a distribution; give a seed, so that the study can be repeated")
    seed = rng if rng is None or isinstance(rng, np.random.Generator) else whole_number("rng", rng, least=0, most=LARGEST_SEED)
    generator = None if seed is None else np.random.default_rng(seed)
    drawn = [item.rvs(size=nodes, random_state=generator) if hasattr(item, "rvs") else item for item in items]
    column = all(isinstance(item, np.ndarray) and item.shape == (1,) for item in drawn)  # np.c_[...]
    return [frozen(friction_coefficients(item[0] if column else item, nodes)) for item in drawn]
