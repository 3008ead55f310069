"""Studies: the steady states of many transients as one table."""

import os
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, closing
from itertools import product

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..contact import ContactSystem, LoadCycle, friction_coefficients
from ..contact.checks import Array, finite_numbers, flag
from ..contact.cycle import checked_cycle
from ..contact.progress import bar_of
from ..contact.system import checked_system
from ..errors import ModelError, SolverError, StoreError
from ..limits import ShakedownLimit, shakedown_limit
from .run import Case, Row, Run, execute
from .starts import Start, checked_starts
from .store import TYPES, Store

__all__ = ["dissipation_study"]

_COLUMNS = (
    *("load_factor", "load_ratio", "start", "family", "seed", "amplitude", "outcome", "dissipation", "dissipation_scaled", "first_cycle"),
    *("largest_share", "cycles", "slipping", "open", "residual", "engine", "seconds", "error"),
)
_TYPES = {"seed": "Int64", "family": "str", **TYPES}


def dissipation_study(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factors: Iterable[float],
    starts: Sequence[Start] | ArrayLike | None = None,
    *,
    executor: Executor | None = None,
    store: str | os.PathLike[str] | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Follow a transient to its steady state from every start at every load factor (Flicek et al. 2015, section 5).

    A run that fails is a row with its error. The executor only changes the column seconds. Ctrl-C stays a KeyboardInterrupt with an attribute
    `table`, that of the finished runs. The store is closed then and holds them too.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factors
        Load factors, each >= 0.
    starts
        Starts, as `fo.starts` makes them (`no_slip`, `safe_slips`, `random_slips`, `overloads`, `given_slips`; add their lists); or an array of
        residual slips (S, N), in three dimensions (S, N, 2), length; None: no slip. Slips that stress the contact more than 1e18 times as much as
        the loads fail.
    executor
        Any executor of `concurrent.futures`' interface, such as a `ProcessPoolExecutor` or a dask client's `get_executor()`; None: runs are
        followed one by one in this process. A run that it loses is a row that says so, and is not kept in the store.
    store
        File that keeps each finished run by its content: a study that is started again computes only the missing runs. Several studies may share the
        file on a disk of this machine. `read_store` reads it.
    progress
        Show count, rate and time left, on a terminal and in a notebook.

    Returns
    -------
    DataFrame
        One row for each run, ordered by load factor and start as given. Columns: load_factor; load_ratio, over the shakedown limit (NaN if the limit
        is not finite); start, family, seed, see `Start`; amplitude, root mean square of the initial slip; outcome, the name of an `Outcome`, or
        "FAILED"; dissipation, work of friction per cycle in the steady state; dissipation_scaled, `W E* / P^2` with P the total normal force of the
        mean load (NaN if the system does not know its `E_star`, and in three dimensions); first_cycle, work in the first cycle; largest_share, that
        of the node that dissipates most; cycles followed; slipping and open, numbers of nodes; residual; engine; seconds; error, the text for a run
        that failed, else empty. `attrs` holds "shakedown_limit" and "missing", the number of runs without a row in the table of an error.

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
    f = np.array(friction_coefficients(friction, checked_system(system).nodes))
    checked_cycle(cycle)
    factors = _checked_factors(load_factors)
    begins = checked_starts(starts, system.slip_shape)
    if executor is not None and not hasattr(executor, "submit"):
        raise ModelError(f"executor: a {type(executor).__name__}; give an executor of concurrent.futures, or of dask by client.get_executor()")
    flag("progress", progress)
    rows: dict[str, Row] = {}
    with ExitStack() as stack:
        kept = None if store is None else stack.enter_context(closing(Store(store)))
        case = Case(system, cycle, f, _limit(system, cycle, f))
        digest = case.digest()
        runs = [Run.of(digest, factor, start) for factor, start in product(factors, begins)]
        keys = {run.key: run for run in runs}
        try:
            if kept is not None:
                rows.update((key, row) for key, row in kept.read().items() if key in keys)
            missing = [run for key, run in keys.items() if key not in rows]
            bar = stack.enter_context(bar_of(progress, "transients", "run", total=len(keys), initial=len(rows)))
            for row, answered in stack.enter_context(closing(execute(case, missing, executor))):
                rows[row["key"]] = row
                if kept is not None and answered:
                    kept.write(row)
                bar.update()
            return _table(case, runs, rows)
        except StoreError as error:
            error.table = _table(case, runs, rows)
            raise
        except KeyboardInterrupt as interrupt:
            table = interrupt.table = _table(case, runs, rows)  # type: ignore[attr-defined]  # no class of its own: the exit status stays Python's
            known = "" if kept is None else f" and in {str(kept.path)!r}, from where the same call goes on"
            interrupt.add_note(f"dissipation_study: {table.attrs['missing']} runs are left; {len(table)} are in the attribute `table`{known}")
            raise


def _table(case: Case, runs: Sequence[Run], rows: Mapping[str, Row]) -> pd.DataFrame:
    """The runs that have a row, in their order."""
    limit, modulus = np.nan if case.limit is None else case.limit.load_factor, case.system.E_star
    force = abs(float(case.cycle.mean_reaction(case.system)[1].sum()))
    scale = modulus / force**2 if modulus is not None and force**2 > 0 else np.nan
    records = []
    for run in (run for run in runs if run.key in rows):
        row, start = rows[run.key], run.start
        ratio = run.load_factor / limit if limit > 0 and np.isfinite(limit) else np.nan
        names = {"start": start.name, "family": start.family, "seed": start.seed}
        records.append({**row, **names, "load_ratio": ratio, "dissipation_scaled": row["dissipation"] * scale})
    table = pd.DataFrame(records, columns=list(_COLUMNS)).astype({name: _TYPES.get(name, "float64") for name in _COLUMNS})
    table.attrs = {"shakedown_limit": float(limit), "missing": len(runs) - len(records)}
    return table


def _limit(system: ContactSystem, cycle: LoadCycle, friction: Array) -> ShakedownLimit | None:
    try:
        limit: ShakedownLimit = shakedown_limit(system, cycle, friction)
    except SolverError:
        return None
    return limit


def _checked_factors(load_factors: Iterable[float]) -> list[float]:
    factors = finite_numbers("load_factors", load_factors, least=0.0)
    if not factors:
        raise ModelError("load_factors: empty; give at least one")
    if len(set(factors)) < len(factors):
        raise ModelError("load_factors: a value occurs twice; give each once")
    return factors
