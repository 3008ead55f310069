"""Campaigns: the steady states of many transients as one table."""

import os
from collections.abc import Container, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, closing, suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle, friction_coefficients
from ..contact.checks import Array, finite_numbers, flag, whole_number
from ..contact.cycle import checked_cycle
from ..contact.progress import bar_of
from ..contact.system import checked_system
from ..errors import ModelError, SolverError, StoreError
from ..limits import shakedown_limit
from .execute import execute
from .run import CampaignContact, Run, one_thread, run_key
from .starts import Start, checked_starts
from .store import TYPES, Store

__all__ = ["dissipation_study"]

_MOST_WORKERS = 1000  # more is taken for a typing error
_COLUMNS = (
    *("load_factor", "load_ratio", "start", "family", "seed", "amplitude", "outcome", "dissipation", "dissipation_scaled", "first_cycle"),
    *("largest_share", "cycles", "slipping", "open", "residual", "engine", "seconds", "error"),
)
_TYPES = {"seed": "Int64", "family": "str", **TYPES}


def dissipation_study(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    load_factors: Iterable[float],
    initial_slips: Any = None,
    *,
    executor: Executor | None = None,
    workers: int = 1,
    store: str | os.PathLike[str] | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Follow a transient to its steady state from every start at every load factor (Flicek et al. 2015, section 5).

    A run that fails is a row with its error. The number of processes only changes the column seconds. Ctrl-C stays a KeyboardInterrupt; as
    soon as there are runs it has an attribute `table`, that of the finished ones. The store is closed then and holds them too.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factors
        Load factors, each >= 0.
    initial_slips
        Starts, as `no_slip`, `safe_slips`, `random_slips`, `overloads` and `given_slips` make them (add their lists); or an
        array (starts, N), in three dimensions (starts, N, 2), of residual slips, length; None: no slip. Slips that stress the contact more than 1e18
        times as much as the loads fail.
    executor
        Any executor of `concurrent.futures`' interface (such as a dask client's `get_executor()`), instead of workers.
    workers
        Number of processes, up to 1,000; 1: this process only. Processes take a few seconds to start.
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
    >>> starts = fo.no_slip() + fo.overloads([1.5])
    >>> table = fo.dissipation_study(rod, cycle, friction=0.5, load_factors=[0.4, 1.0], initial_slips=starts, progress=False)
    >>> table[["load_factor", "start", "outcome", "dissipation"]].round(6)
       load_factor           start      outcome  dissipation
    0          0.4            none    SHAKEDOWN          0.0
    1          0.4  overload x 1.5    SHAKEDOWN          0.0
    2          1.0            none  CYCLIC_SLIP          1.0
    3          1.0  overload x 1.5  CYCLIC_SLIP          1.0
    """
    f = np.array(friction_coefficients(friction, checked_system(system).nodes))
    checked_cycle(cycle)
    factors = _checked_factors(load_factors)
    starts = checked_starts(initial_slips, system.slip_shape)
    if executor is not None and not hasattr(executor, "submit"):
        raise ModelError(f"executor: a {type(executor).__name__}; give an executor of concurrent.futures, or of dask by client.get_executor()")
    if whole_number("workers", workers, least=1, most=_MOST_WORKERS) > 1 and executor is not None:
        raise ModelError(f"workers: {workers!r} and an executor; the executor has its own workers, so give one of the two")
    flag("progress", progress)
    rows: dict[str, dict[str, Any]] = {}
    latest: dict[str, dict[str, Any]] = {}
    with ExitStack() as stack:
        kept = None if store is None else stack.enter_context(closing(Store(store)))
        stack.enter_context(one_thread())
        campaign = _Campaign(_contact(system, cycle, f), factors, starts)
        try:
            if kept is not None:
                rows.update(kept.read(set(campaign.keys)))
            with bar_of(progress, "transients", "run", total=len(set(campaign.keys)), initial=len(rows)) as bar:
                with closing(execute(campaign.contact, campaign.missing(rows), executor, workers)) as finished:
                    for row, answered in finished:
                        latest = {row["key"]: row}
                        if kept is not None and answered:
                            kept.write(row)
                        rows |= latest
                        bar.update()
            return campaign.table(rows)
        except StoreError as error:
            error.table = campaign.table(rows | latest)
            raise
        except KeyboardInterrupt as interrupt:
            with suppress(StoreError):
                rows |= {} if kept is None else kept.read(set(campaign.keys))
            table = interrupt.table = campaign.table(rows)  # type: ignore[attr-defined]  # no class of its own: the exit status stays Python's
            known = "" if kept is None else f" and in {str(kept.path)!r}, from where the same call goes on"
            interrupt.add_note(f"dissipation_study: {table.attrs['missing']} runs are left; {len(table)} are in the attribute `table`{known}")
            raise


@dataclass(frozen=True, eq=False)
class _Campaign:
    """Load factors times starts on one contact."""

    contact: CampaignContact
    factors: Sequence[float]
    starts: Sequence[Start]

    @cached_property
    def keys(self) -> list[str]:
        """Keys of all runs, by load factor and start."""
        contact = self.contact.key()
        return [run_key(contact, factor, start) for factor, start in product(self.factors, self.starts)]

    def missing(self, done: Container[str]) -> list[Run]:
        """The runs that are not done, each once."""
        pairs = {key: pair for key, pair in zip(self.keys, product(self.factors, self.starts), strict=True) if key not in done}
        return [Run(key, start, factor) for key, (factor, start) in pairs.items()]

    def table(self, rows: Mapping[str, Mapping[str, Any]]) -> pd.DataFrame:
        """The runs that have a row, in their order."""
        system, limit = self.contact.system, self.contact.limit
        force = abs(float(self.contact.cycle.mean_reaction(system)[1].sum()))
        modulus = system.E_star
        scale = modulus / force**2 if modulus is not None and force**2 > 0 else np.nan
        records = []
        for key, (factor, start) in zip(self.keys, product(self.factors, self.starts), strict=True):
            if key in rows:
                own = {"load_ratio": factor / limit if limit > 0 and np.isfinite(limit) else np.nan, "start": start.name, "family": start.family}
                scaled = {"seed": start.seed, "dissipation_scaled": rows[key]["dissipation"] * scale}
                records.append({**rows[key], **own, **scaled})
        table = pd.DataFrame(records, columns=list(_COLUMNS)).astype({name: _TYPES.get(name, "float64") for name in _COLUMNS})
        table.attrs = {"shakedown_limit": float(limit), "missing": len(self.keys) - len(records)}
        return table


def _contact(system: Any, cycle: LoadCycle, friction: Array) -> CampaignContact:
    """The contact with its shakedown limit, if a solver proves one."""
    try:
        limit = shakedown_limit(system, cycle, friction)
    except SolverError:
        return CampaignContact(system, cycle, friction, np.nan, np.full(system.slip_shape, np.nan))
    return CampaignContact(system, cycle, friction, limit.load_factor, limit.slip)


def _checked_factors(load_factors: Any) -> list[float]:
    factors = finite_numbers("load_factors", load_factors, least=0.0)
    if not factors:
        raise ModelError("load_factors: empty; give at least one")
    if len(set(factors)) < len(factors):
        raise ModelError("load_factors: a value occurs twice; give each once")
    return factors
