"""Steady dissipation of the paper's scene from many residual slips, around the shakedown limit.

Run with `python -m studies dissipation [--quick] [--workers 2] [--store FILE]`. There are thousands
of transients. The columns of seconds depend on the machine.
"""

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cache
from itertools import product
from multiprocessing import get_context
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo

from .paper import LOADS, force_unit, slip_unit
from .progress import each
from .tables import Row, Study, Table, described, whole_number


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # The default grading has 50,910 unknowns, 250 of them on the interface.
    elements: int = 124
    frictions: tuple[float, ...] = (0.5, 0.7)
    # Load factors relative to lambda_2.
    ratios: tuple[float, ...] = (
        0.1,
        0.2,
        0.3,
        0.4,
        0.5,
        0.6,
        0.7,
        0.8,
        0.9,
        0.95,
        0.99,
        1.01,
        1.05,
        1.1,
        1.2,
        1.3,
        1.4,
        1.6,
        1.8,
        2.0,
    )
    # Multiples of the safe slip.
    safe: tuple[float, ...] = (1.0, 0.5, -1.0, 2.0)
    # Root mean squares of random slips, in units of a (P / 2a) / E*.
    amplitudes: tuple[float, ...] = (0.02, 0.06, 0.2, 0.6, 2.0)
    # Number of random slips of each kind and amplitude.
    count: int = 10
    # Load factors of the first cycle, relative to the load factor of the run.
    overloads: tuple[float, ...] = (1.5, 2.0, 3.0)
    # Friction of the example with two steady states at one load.
    pair_friction: float = 0.7
    pair_ratio: float = 1.2


FULL = Parameters()
QUICK = Parameters(
    elements=16, ratios=(0.5, 0.9, 1.2), amplitudes=(0.06, 0.6), count=3, overloads=(2.0,)
)


@dataclass(frozen=True, eq=False)
class Case:
    """The scene at one friction, and its shakedown limit."""

    system: fo.ContactSystem
    friction: float
    limit: float


def cases_of(parameters: Parameters) -> list[Case]:
    """The scene at each friction."""
    system = fo.scenes.PunchOnHalfPlane(elements=parameters.elements).condense()
    return [
        Case(system, f, fo.shakedown_limit(system, LOADS, f).load_factor)
        for f in parameters.frictions
    ]


def starts_of(parameters: Parameters, case: Case, load_factor: float) -> list[fo.starts.Start]:
    """All starts of the runs at a load factor."""
    amplitudes = [amplitude * slip_unit(case.system) for amplitude in parameters.amplitudes]
    return (
        fo.starts.no_slip()
        + fo.starts.safe_slips(parameters.safe)
        + fo.starts.random_slips(case.system, amplitudes, parameters.count)
        + [
            fo.starts.Start("overload", f"overload x {over:g}", overload=over * load_factor)
            for over in parameters.overloads
        ]
    )


@cache
def runs_of(parameters: Parameters, workers: int = 1, store: str | None = None) -> pd.DataFrame:
    """One row for each friction, load factor and start."""
    parts = []
    with (
        nullcontext()
        if workers == 1
        else ProcessPoolExecutor(workers, get_context("spawn")) as pool
    ):
        for case, ratio in each(
            product(cases_of(parameters), parameters.ratios), "frictions and loads"
        ):
            load_factor = ratio * case.limit
            starts = starts_of(parameters, case, load_factor)
            part = fo.dissipation_study(
                case.system, LOADS, case.friction, [load_factor], starts, executor=pool, store=store
            )
            part = part.filter(described(_RUN))
            part["amplitude"] /= slip_unit(case.system)
            # The ratio is copied, because a division would round it.
            parts.append(part.assign(friction=case.friction, load_ratio=ratio))
    return pd.concat(parts, ignore_index=True)


def summary(runs: pd.DataFrame, *more: str) -> pd.DataFrame:
    """One row for each friction, load factor and further named column of the table `RUNS`.

    A row has the number of runs that shake down, and W E* / P^2 per cycle.
    """
    work = "dissipation_scaled"
    return (
        runs.assign(shaken=runs["outcome"] == "SHAKEDOWN")
        .groupby(["friction", "load_ratio", "load_factor", *more], sort=False)
        .agg(
            runs=("outcome", "size"),
            shakedown=("shaken", "mean"),
            least=(work, "min"),
            median=(work, "median"),
            most=(work, "max"),
            residual=("residual", "max"),
        )
        .reset_index()
    )


def limits_of(parameters: Parameters) -> Iterator[Row]:
    """One row for each friction."""
    for case in cases_of(parameters):
        found = fo.guaranteed_limit(case.system, LOADS, case.friction)
        yield {
            "friction": case.friction,
            "load_factor": case.limit,
            "guaranteed": found.load_factor,
            "residual": found.residual,
        }


def states_of(parameters: Parameters, **options: Any) -> pd.DataFrame:
    """One row for each event and node of the steady cycle of two runs at one load.

    The two runs have the least and the most dissipation.
    """
    runs = runs_of(parameters, **options)
    runs = runs[
        (runs["friction"] == parameters.pair_friction)
        & (runs["load_ratio"] == parameters.pair_ratio)
        & (runs["family"] != "overload")
    ]
    case = next(case for case in cases_of(parameters) if case.friction == parameters.pair_friction)
    ordered = runs.sort_values("dissipation", kind="stable")
    parts = [
        _steady_cycle(parameters, case, row).assign(state=name)
        for name, row in (("least", ordered.iloc[0]), ("most", ordered.iloc[-1]))
    ]
    return pd.concat(parts)


def _steady_cycle(parameters: Parameters, case: Case, row: "pd.Series[Any]") -> pd.DataFrame:
    """The steady cycle of one run."""
    start = next(
        start
        for start in starts_of(parameters, case, row["load_factor"])
        if start.name == row["start"]
    )
    slip = start.slip_at(case.system, LOADS, case.friction, row["load_factor"])
    path = fo.steady_state(
        case.system, LOADS, case.friction, row["load_factor"], initial_slip=slip
    ).states()
    events, nodes = path.slip.shape
    sigma = path.amplitudes[:, list(case.system.bonded).index("sigma")]
    force = force_unit(case.system)
    unit = {"slip": slip_unit(case.system), "q": force, "p": force}
    columns = {name: getattr(path, name).ravel() / unit[name] for name in unit}
    each = {
        "time": np.repeat(path.time, nodes),
        "sigma": np.repeat(sigma, nodes),
        "x": np.tile(case.system.x, events),
    }
    same = {
        name: row[name]
        for name in (
            "friction",
            "load_ratio",
            "load_factor",
            "start",
            "family",
            "amplitude",
            "dissipation_scaled",
        )
    }
    return pd.DataFrame(
        {**each, **columns, "status": path.status.ravel(), "residual": path.residual}
    ).assign(**same)


_RUN = {
    "start": "name of the start",
    "family": "'none', 'safe' (multiples of the linear program's slip), 'smooth' and 'rough' (random), 'overload' (a cycle at a higher load first)",
    "amplitude": "root mean square of the initial slip v E* / (a P / 2a)",
    "outcome": "SHAKEDOWN, CYCLIC_SLIP, RATCHETING, SLIDES_OFF or FAILED",
    "dissipation": "work of friction per steady cycle, (P / 2a) a^2",
    "dissipation_scaled": "the same over P^2 / E*, P the total force per depth",
    "cycles": "cycles followed until the steady state was proven",
    "error": "why there is no result; empty if there is one",
}
_STATE = {
    "state": "'least' or 'most': dissipation among all starts at this load",
    **{name: _RUN[name] for name in ("start", "family", "amplitude", "dissipation_scaled")},
}
_OPTIONS: dict[str, dict[str, Any]] = {
    "workers": {
        "type": whole_number(1),
        "default": 1,
        "metavar": "N",
        "help": "number of processes (default 1: no other process)",
    },
    "store": {
        "metavar": "FILE",
        "help": "file that keeps each finished run; the next start computes only the missing runs",
    },
}


def _table(name: str, about: str, columns: dict[str, str], compute: Any) -> Table[Parameters]:
    return Table(name, about, columns, full=FULL, quick=QUICK, compute=compute, options=_OPTIONS)


RUNS = _table("dissipation_runs", "one transient to its steady state", _RUN, runs_of)
LIMITS = Table(
    "dissipation_limits",
    "both limits at one friction",
    {},
    full=FULL,
    quick=QUICK,
    compute=limits_of,
)
STATES = _table(
    "dissipation_states", "one node at one event of the steady cycle", _STATE, states_of
)

STUDY = Study(
    "studies.dissipation",
    __doc__,
    "a coarse mesh and few starts, in seconds",
    (RUNS, LIMITS, STATES),
    summary=lambda tables: (
        summary(tables[RUNS.name])
        .drop(columns="load_factor")
        .to_string(index=False, float_format="{:.4g}".format)
    ),
)
