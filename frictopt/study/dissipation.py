"""Studies: the steady states of many transients as one table, for one friction or load cycle or many."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing, nullcontext, suppress
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    LARGEST_SEED,
    Array,
    bar_of,
    check_text,
    finite_array,
    finite_numbers,
    frozen,
    listed,
    shown,
    warns_of_odd_values,
    whole_number,
)
from ..contact import ContactSystem, LoadCycle, checked_cycle, checked_system, friction_coefficients
from ..errors import ModelError, SolverError, StoreError
from ..limits import ShakedownLimit, shakedown_limit
from .runs import Case, Run, execute
from .starts import Start, given_slips, no_slip
from .store import FAILED, TYPES, Row, Store

_COLUMNS = (
    "friction friction_std friction_number cycle load_factor load_ratio shakedown_limit start family seed amplitude outcome dissipation "
    "dissipation_scaled first_cycle largest_share cycles slipping open residual engine seconds error"
).split()
_TYPES = {"seed": "Int64", "friction_number": "int64", "family": "str", **TYPES}


@warns_of_odd_values
def dissipation_study(
    system: ContactSystem,
    cycle: LoadCycle | Mapping[str, LoadCycle],
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
    """Follow a transient to its steady state at every friction, load cycle and load factor, from every start (Flicek et al. 2015, section 5).

    A run that fails is a row with its error. The executor only changes the column seconds. Ctrl-C
    stays a KeyboardInterrupt with an attribute `table`, that of the finished runs. The store is
    closed then and holds them too.

    Parameters
    ----------
    system, load_factors
        The contact, and load factors, each >= 0.
    cycle
        Its load cycle; or several, label -> load cycle, such as one for each preload or phase: they
        are an axis of the study then.
    friction
        Coefficient of friction; or a list of frictions. Each is a number, (N,) coefficients of the
        nodes, or a frozen distribution of `scipy.stats`, from which each node draws its own
        coefficient: `[stats.norm(0.5, 0.05)] * 20` is twenty contacts of scattered friction. A flat
        list of as many numbers as the contact has nodes is refused, because it may mean both: give
        `[field]`, or a column of numbers (F, 1).
    starts
        Starts, as `fo.starts` makes them (add their lists); or an array of residual slips (S, N),
        in space (S, N, 2), length; None: no slip. Slips that stress the contact more than 1e18
        times as much as the loads fail.
    rng
        Seed or generator of the distributions among the frictions, which draw one after the other;
        a seed gives the same table again.
    shard
        (k, n): follow only the k-th of n parts of the runs, k from 1 to n, each n-th run. Parts
        with stores of their own need no shared file; the command `frictopt merge` puts the stores
        together. None: all runs.
    executor
        Any executor of `concurrent.futures`' interface, such as a `ProcessPoolExecutor` or a dask
        client's `get_executor()`; None: this process. It gets at most 256 tasks at a time; each
        ends with the run in which its first second is over. A run that it loses is a row that says
        so.
    store
        File that keeps each run by its content when its task ends: a study that is started again,
        also after it was killed, follows only the missing runs and those that failed; shakedown
        limits are computed in each call. Several studies may share the file on a disk of this
        machine. `results.read_store` reads it.
    progress
        Show count, rate and time left, on a terminal and in a notebook.

    Returns
    -------
    DataFrame
        One row for each run, ordered by friction, load cycle, load factor and start as given.
        Columns: friction, the number or the mean over the nodes; friction_std, its standard
        deviation over the nodes; friction_number, its place in the list; cycle, the label, "" of a
        single one; load_factor; load_ratio, over the shakedown limit (NaN if that is not finite);
        shakedown_limit, of this friction and cycle (NaN if no solver proves one); start, family,
        seed, see `Start`; amplitude, root mean square of the initial slip; outcome, the name of an
        `Outcome`, or "FAILED"; dissipation, work of friction per cycle in the steady state;
        dissipation_scaled, `W E* / P^2` with P the total normal force of the mean load (NaN if
        `E_star` is not known, and in space); first_cycle, work in the first cycle; largest_share,
        that of the node that dissipates most; cycles followed; slipping and open, numbers of nodes;
        residual; engine; seconds; error, the text for a run that failed, else empty. `attrs` holds
        "missing", the number of runs without a row in the table of an error.

    Raises
    ------
    ModelError
        Bad input, or an executor that takes no runs.
    StoreError
        The store is damaged, is not a store of frictopt, has runs of another load cycle under the
        same label, or cannot be written; once runs have begun, `table` of the error holds the
        finished ones.

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
    cycles = checked_cycles(cycle)
    factors = finite_numbers("load_factors", load_factors, least=0.0)
    if not factors or len(set(factors)) < len(factors):
        raise ModelError(f"load_factors: {shown(factors)}; give at least one, and each once")
    begins, chosen = (
        checked_starts(starts, system.slip_shape),
        slice(None) if shard is None else _checked_shard(shard),
    )
    wanted = list(product(range(len(fields)), cycles, factors, begins))[chosen]
    rows: dict[str, Row] = {}
    with nullcontext() if store is None else closing(Store(store)) as file:
        cases = {
            (number, label): Case(
                system,
                cycles[label],
                fields[number],
                _limit(system, cycles[label], fields[number], progress),
                number,
                label,
            )
            for number, label in dict.fromkeys(one[:2] for one in wanted)
        }
        runs = [Run(cases[number, label], factor, start) for number, label, factor, start in wanted]
        keys = {run.key: run for run in runs}
        if file is not None:
            file.check_cycles({case.label: case.loads for case in cases.values()})
            rows.update(
                (row["key"], row)
                for row in file.read().to_dict("records")
                if row["key"] in keys and row["outcome"] != FAILED
            )

        def keep(found: list[Row], answered: bool) -> None:
            rows.update((row["key"], row) for row in found)
            if file is not None and answered and found:
                file.write(found)
            bar.count = len(rows)

        def kept(_: object) -> tuple[str, object, str]:
            table = _table(system, runs, rows)
            known = (
                ""
                if file is None
                else f" and in {str(file.path)!r}, from where the same call goes on"
            )
            return (
                "table",
                table,
                f"{table.attrs['missing']} runs are left; {len(table)} are in the attribute `table`{known}",
            )

        missing, on = (
            [run for key, run in keys.items() if key not in rows],
            (KeyboardInterrupt, StoreError),
        )
        with bar_of(
            progress,
            "transients",
            "run",
            total=len(keys),
            done=len(rows),
            at_once=True,
            keeps=kept,
            on=on,
        ) as bar:
            execute(missing, executor, keep)
    return _table(system, runs, rows)


def _table(system: ContactSystem, runs: Sequence[Run], rows: Mapping[str, Row]) -> pd.DataFrame:
    """The runs that have a row, in their order."""
    records, forces = list[Row](), list[float]()
    for run in (run for run in runs if run.key in rows):
        start, limit = run.start, np.nan if run.case.limit is None else run.case.limit.load_factor
        named = {
            "start": start.name,
            "family": start.family,
            "seed": start.seed,
            "shakedown_limit": limit,
        }
        records.append(
            rows[run.key] | named | {"friction_number": run.case.number, "cycle": run.case.label}
        )
        forces.append(run.case.force)
    table = pd.DataFrame(records, columns=_COLUMNS).astype(
        {name: _TYPES.get(name, "float64") for name in _COLUMNS}
    )
    limits, force = table["shakedown_limit"], np.array(forces)
    table["load_ratio"] = table["load_factor"] / limits.where((limits > 0) & np.isfinite(limits))
    modulus = system.E_star if system.E_star and system.tangents == 1 else np.nan
    table["dissipation_scaled"] = (
        table["dissipation"] * modulus / np.where(force**2 > 0, force**2, np.nan)
    )
    table.attrs = {"missing": len(runs) - len(records)} | (
        {} if system.units is None else {"units": system.units}
    )
    return table


def _checked_shard(shard: object) -> slice:
    """Which of all runs a part of them has."""
    part = listed("shard", shard)
    if len(part) != 2:
        raise ModelError(f"shard: {shown(shard)}; give (k, n), the k-th of n parts")
    count = whole_number("shard n", part[1], least=1)
    return slice(whole_number("shard k", part[0], least=1, most=count) - 1, None, count)


def _limit(
    system: ContactSystem, cycle: LoadCycle, friction: Array, progress: bool
) -> ShakedownLimit | None:
    with suppress(SolverError):
        return shakedown_limit(system, cycle, friction, progress=progress)
    return None


def checked_cycles(cycle: object) -> dict[str, LoadCycle]:
    """The load cycles of a study by their labels, "" of a single one."""
    if not isinstance(cycle, Mapping):
        return {"": checked_cycle(cycle)}
    if not cycle:
        raise ModelError("cycle: empty; give a LoadCycle, or label -> LoadCycle")
    for label, one in cycle.items():
        check_text("cycle", label, "a printable text", "label ")
        checked_cycle(one, f"cycle[{label!r}]")
    return dict(cycle)


def checked_starts(
    starts: Sequence[Start] | ArrayLike | None, slip_shape: tuple[int, ...]
) -> list[Start]:
    """Check starts for a contact: a list of `Start`, an array of slips, (S, *slip_shape), or None."""
    starts = (
        no_slip() if starts is None else list(starts) if isinstance(starts, Iterator) else starts
    )
    if isinstance(starts, Sequence) and not starts:
        raise ModelError("starts: empty; give at least one start")
    if not np.iterable(starts) or not any(isinstance(start, Start) for start in starts):
        return given_slips(finite_array("starts", starts, (None, *slip_shape)))
    given: list[Any] = list(starts)
    for start in given:
        if not isinstance(start, Start):
            raise ModelError(
                f"starts: a {type(start).__name__} among starts; make starts of slips by given_slips, and add lists up"
            )
        slip = start.slip if start.state is None else start.state.slip
        if slip is not None and slip.shape != slip_shape:
            raise ModelError(
                f"starts: start {start.name!r} has a slip of shape {slip.shape}, the contact needs {slip_shape}"
            )
    ((name, count),) = Counter(start.name for start in given).most_common(1)
    if count > 1:
        raise ModelError(
            f"starts: two starts are called {name!r}; give them different names or seeds"
        )
    return given


def friction_fields(friction: Any, nodes: int, rng: object) -> list[Array]:
    """(N,) coefficients of each friction: of one, or of a list of numbers, fields and distributions; see `dissipation_study`."""
    several = np.iterable(friction) and not isinstance(friction, str | bytes | Mapping)
    items = list(friction) if several else [friction]
    if not items:
        raise ModelError("friction: empty; give at least one coefficient")
    if (
        several
        and len(items) == nodes > 1
        and not any(np.iterable(item) or hasattr(item, "rvs") for item in items)
    ):
        raise ModelError(
            f"friction: {nodes} numbers for {nodes} nodes, one friction or {nodes} of them; give [friction] or np.c_[friction]"
        )
    generator = (
        rng
        if isinstance(rng, np.random.Generator | None)
        else np.random.default_rng(whole_number("rng", rng, least=0, most=LARGEST_SEED))
    )
    values = [_drawn(item, nodes, generator) if hasattr(item, "rvs") else item for item in items]
    values = [
        value[0] if isinstance(value, np.ndarray) and value.shape == (1,) else value
        for value in values
    ]  # rows of a column, np.c_[...]
    return [frozen(friction_coefficients(value, nodes)) for value in values]


def _drawn(distribution: Any, nodes: int, generator: np.random.Generator | None) -> Array:
    if generator is None:
        raise ModelError(
            "rng: None, and friction has a distribution; give a seed, so that the study can be repeated"
        )
    return frozen(distribution.rvs(size=nodes, random_state=generator))
