"""The range of steady dissipation found by a search, the least slip, and limits after a protocol.

Run with `python -m studies range [--quick]`. The scene is the paper's scene; loads are amplitudes
of the bulk stress over the mean pressure, sigma / (P / 2a). No start avoids the least slip. The
limits after a protocol follow assembly and overloads. The sampled starts are the starts of the
study "dissipation".
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pandas as pd

import frictopt as fo

from . import dissipation
from .paper import LOADS, slip_unit, work_unit
from .progress import each
from .tables import Row, Study, Table

# A run may exceed the range by this share, which counts as rounding.
_INSIDE = 1e-6


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    # Scene, frictions, loads and starts of the sample.
    sampled: dissipation.Parameters = dissipation.FULL
    protocol_elements: int = 124
    protocol_frictions: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
    protocol_scan: int = 25


FULL = Parameters()
QUICK = Parameters(
    sampled=dissipation.QUICK, protocol_elements=16, protocol_frictions=(0.3, 0.7), protocol_scan=10
)


@cache
def _ranges(
    parameters: Parameters,
) -> list[tuple[dissipation.Case, float, fo.results.DissipationRange]]:
    """Case, load ratio and range, for each friction and load of the sample."""
    asked = [
        (case, ratio)
        for case in dissipation.cases_of(parameters.sampled)
        for ratio in parameters.sampled.ratios
    ]
    return [
        (case, ratio, fo.dissipation_range(case.system, LOADS, case.friction, ratio * case.limit))
        for case, ratio in each(asked, "ranges")
    ]


def found_of(parameters: Parameters) -> Iterator[Row]:
    """One row for each friction and load."""
    for case, ratio, span in _ranges(parameters):
        unit = work_unit(case.system)
        yield {
            "friction": case.friction,
            "load_ratio": ratio,
            "load_factor": ratio * case.limit,
            "least": span.least / unit,
            "most": span.most / unit,
            "residual": span.residual,
        }


def against_sample(found: pd.DataFrame, runs: pd.DataFrame) -> pd.DataFrame:
    """The table `FOUND` beside the sampled runs at the same friction and load.

    The new columns are the least and the largest W E* / P^2 of the runs, their number, and the
    number of runs outside the range.
    """
    load = ["friction", "load_ratio"]
    runs = runs.loc[runs["dissipation_scaled"].notna(), [*load, "dissipation_scaled"]].merge(
        found[[*load, "least", "most"]], on=load
    )
    runs["out"] = _outside(runs["dissipation_scaled"], runs["least"], runs["most"])
    sampled = runs.groupby(load)["dissipation_scaled"].agg(
        sampled_least="min", sampled_most="max", runs="size"
    )
    return found.merge(
        sampled.assign(outside=runs.groupby(load)["out"].sum()).reset_index(), on=load
    )


def slip_of(parameters: Parameters) -> Iterator[Row]:
    """One row for each friction and load above the shakedown limit."""
    for case, ratio, span in _ranges(parameters):
        if ratio <= 1:
            continue
        least = fo.shakedown_limit(case.system, LOADS, case.friction).least_slip(ratio * case.limit)
        low, high = (_corners(state) for state in (span.least_state, span.most_state))
        yield {
            "friction": case.friction,
            "load_ratio": ratio,
            "bound": least.bound,
            "least": least.of(*low),
            "most": least.of(*high),
            "proven_total": least.total / slip_unit(case.system),
            "least_total": _total(*low) / slip_unit(case.system),
            "most_total": _total(*high) / slip_unit(case.system),
            "residual": max(least.residual, span.residual),
        }


def _corners(state: fo.results.SteadyState) -> tuple[np.ndarray, np.ndarray]:
    """(K, N) slips and gaps at the corners of an orbit."""
    states = state.states()
    at = [np.flatnonzero(states.time <= corner)[-1] for corner in range(1, len(LOADS.corners) + 1)]
    return states.slip[at], states.gap[at]


def _total(slip: np.ndarray, gap: np.ndarray) -> float:
    """Sum over the nodes of the range of slip at the corners; NaN if a node is open at a corner."""
    return float("nan") if gap.any() else float(np.ptp(slip, axis=0).sum())


def protocols_of(parameters: Parameters) -> Iterator[Row]:
    """One row for each friction and protocol."""
    system = fo.scenes.PunchOnHalfPlane(elements=parameters.protocol_elements).condense()
    for friction in parameters.protocol_frictions:
        limit = fo.shakedown_limit(system, LOADS, friction)
        for name, options in _protocols(limit):
            one = fo.limit_after_protocol(limit, scan=parameters.protocol_scan, **options)
            yield {
                "friction": friction,
                "protocol": name,
                **{
                    column: getattr(one, column)
                    for column in ("ratio", "load_factor", "monotonic", "residual")
                },
            }


def _protocols(limit: fo.results.ShakedownLimit) -> Iterator[tuple[str, dict[str, Any]]]:
    unload = [
        fo.starts.LoadStep({"P": 1.0}, {"sigma": 1.0}),
        fo.starts.LoadStep({"P": 0.3}, {"sigma": 1.0}),
        fo.starts.LoadStep({"P": 1.0}, {"sigma": 1.0}),
    ]
    yield "nothing", {"start": "worst"}
    yield (
        "overload",
        {
            "start": "worst",
            "protocol": [fo.starts.LoadStep({"P": 1.0, "sigma": 2 * limit.load_factor})],
        },
    )
    yield "unload", {"start": "worst", "protocol": [fo.starts.LoadStep({"P": 0.2})]}
    yield "unload at tension", {"start": "worst", "protocol": unload}
    yield "assembled", {"start": "assembled"}
    yield "safe", {"start": limit.slip}


def _outside(works: Any, least: Any, most: Any) -> Any:
    return (works > most * (1 + _INSIDE)) | (works < least * (1 - _INSIDE))


_SPAN = {
    "least": "least W E* / P^2 per steady cycle found",
    "most": "largest W E* / P^2 per steady cycle found",
}
_SLIP = {
    "bound": "proven least value of the weighted slip g.v over the corners: lambda - lambda_2",
    "least": "its value on the orbit with the least W found",
    "most": "its value on the orbit with the largest W found",
    "proven_total": "proven least sum over the nodes of the slip between corners, v E* / (a P / 2a)",
    "least_total": "that sum on the orbit with the least W found; NaN where nodes are open at a corner",
    "most_total": "the same on the orbit with the largest W found",
}
_PROTOCOLS = {
    "protocol": "'nothing', 'overload' (sigma to 2 lambda_2 and back), 'unload' (P to 0.2 and back), 'unload at tension' (P to 0.3 and back at "
    "sigma = +lambda), each from the worst start; 'assembled' (P grows from zero), 'safe' (the "
    "slip that is safe at lambda_2)",
    "ratio": "load factor up to which the contact comes to rest, `load_factor`, over lambda_2",
    "monotonic": "whether it comes to rest at no larger load factor that was tried",
}


FOUND = Table("range_found", "the range found at one load", _SPAN, FULL, QUICK, found_of)
SLIP = Table(
    "range_slip",
    "the least slip that is proven at one load, and that found",
    _SLIP,
    FULL,
    QUICK,
    slip_of,
)
PROTOCOLS = Table(
    "range_protocols",
    "the load up to which the contact comes to rest after one protocol",
    _PROTOCOLS,
    FULL,
    QUICK,
    protocols_of,
)


def _summary(tables: Any) -> str:
    sample = against_sample(tables[FOUND.name], tables[dissipation.RUNS.name])
    limits = tables[PROTOCOLS.name].pivot(index="friction", columns="protocol", values="ratio")
    found = f"{sample['outside'].sum()} of {sample['runs'].sum()} sampled runs outside of the range found"
    return "\n".join([found, limits.to_string(float_format="{:.4f}".format)])


STUDY = Study(
    "studies.range",
    __doc__,
    "coarse meshes and few starts, in seconds",
    (FOUND, SLIP, PROTOCOLS),
    summary=_summary,
    needs=(dissipation.RUNS,),
)
