"""A cylinder whose normal load varies with its shear: its limit, and the work of a cycle, against the phase between the two.

Run with `python -m studies moving_areas [--quick]`. The mean normal load is P, its amplitude P / 5,
and that of the shear the load factor times P. Pressure and shear of similar half-planes do not feel
each other, so normal loads alone open and close the nodes at the rim. In phase the contact comes to
rest up to friction times P / 5; with a phase no shear is small enough, and the work of a cycle
grows from zero. The work is over P^2 / E*, per depth.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

import frictopt as fo
from validation.moving_events import PRESS, cylinder

from .progress import each
from .tables import Row, Study, Table, markdown

_VARIES = 0.2  # amplitude of the normal load over its mean


@dataclass(frozen=True)
class Parameters:
    """What the study varies."""

    cells: int = 40
    half_length: float = 1.6
    corners: int = 16
    friction: float = 0.35
    phases: tuple[float, ...] = (0.0, 2.0, 5.0, 10.0, 20.0, 45.0, 90.0)  # degrees
    load_factors: tuple[float, ...] = tuple(
        round(float(value), 6) for value in np.linspace(0.01, 0.14, 14)
    )


FULL = Parameters()
QUICK = Parameters(cells=16, corners=8, phases=(0.0, 45.0), load_factors=(0.05, 0.1))


def out_of_phase(phase: float, corners: int) -> fo.LoadCycle:
    """Shear of one P at load factor 1, and a fixed normal load that leads it by a phase in degrees."""
    angles = 2 * np.pi * np.arange(corners) / corners
    pressed = _VARIES * PRESS * np.cos(angles + np.deg2rad(phase))
    return fo.LoadCycle(
        {"P": PRESS},
        [{"Q": PRESS * float(np.cos(angle))} for angle in angles],
        fixed=[{"P": float(part)} for part in pressed],
    )


def phases(parameters: Parameters) -> Iterator[Row]:
    """One row for each phase and load factor."""
    system = cylinder(parameters.cells, parameters.half_length)
    for phase in each(parameters.phases, "phases"):
        cycle = out_of_phase(phase, parameters.corners)
        limit = fo.shakedown_limit(system, cycle, parameters.friction)
        for load_factor in parameters.load_factors:
            steady = fo.steady_state(system, cycle, parameters.friction, load_factor)
            yield {
                "phase": phase,
                "shakedown": limit.load_factor,
                "bound_for_all": limit.bound_for_all,
                "load_factor": load_factor,
                "dissipation": steady.dissipation / PRESS**2,
                "outcome": steady.outcome.name,
                "residual": max(limit.residual, steady.residual),
            }


PHASES = Table(
    "moving_areas",
    "one phase and load factor",
    {
        "phase": "by which the normal load leads the shear, degrees",
        "shakedown": "limit, amplitude of the shear over P",
        "bound_for_all": "load factor above which no state of rest exists",
        "load_factor": "amplitude of the shear over P in the steady state",
        "dissipation": "work of friction of a steady cycle over P^2 / E*",
        "outcome": "of the transient from no slip",
    },
    full=FULL,
    quick=QUICK,
    compute=phases,
)


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """Limit of each phase, and the work at the least and the largest load factor."""
    rows = []
    for phase, group in tables[PHASES.name].groupby("phase"):
        ordered = group.sort_values("load_factor")
        first, last = ordered.iloc[0], ordered.iloc[-1]
        rows.append(
            [
                f"{phase:g}",
                f"{first['shakedown']:.6f}",
                f"{first['load_factor']:g}: {first['dissipation']:.2e}",
                f"{last['load_factor']:g}: {last['dissipation']:.2e}",
            ]
        )
    return markdown(["phase, degrees", "limit Q / P", "work at", "work at most at"], rows)


STUDY = Study(__name__, __doc__, "a coarse mesh and two phases", (PHASES,), summary)
