"""A cylinder whose normal load varies with its shear: its limit, and the work of a cycle.

Run with `python -m studies moving_areas [--quick]`. The mean normal load is P, its amplitude P / 5,
and the amplitude of the shear the load factor times P. Pressure and shear of similar half-planes
are uncoupled, so normal loads alone open and close the nodes at the rim. If shear and normal load
are in phase, the contact shakes down up to a shear of friction times P / 5. If they are out of
phase, even the smallest shear causes slip, and the work of a cycle grows from zero. The unit of the
work is P^2 / E*, per depth.

Dundurs' constant beta couples shear and pressure of two materials. `BETAS` has limits with events
and the work of a cycle above them, for pressure and shear in phase, and for a cylinder that rolls
to and fro under a static shear (`studies.validation.moving_events`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

import frictopt as fo
from studies.validation.moving_events import (
    FRICTION,
    IN_PHASE,
    PRESS,
    ROLLS,
    cylinder,
    limits_of_two_materials,
    out_of_phase,
)

from .progress import each
from .tables import Row, Study, Table, markdown


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    cells: int = 40
    half_length: float = 1.6
    corners: int = 16
    friction: float = 0.35
    # Phases in degrees.
    phases: tuple[float, ...] = (0.0, 2.0, 5.0, 10.0, 20.0, 45.0, 90.0)
    load_factors: tuple[float, ...] = tuple(
        round(float(value), 6) for value in np.linspace(0.01, 0.14, 14)
    )
    cells_of_betas: int = 20
    betas: tuple[float, ...] = (0.0, 0.02, 0.05, 0.08, 0.1, 0.12, 0.15, 0.18, 0.2)


FULL = Parameters()
QUICK = Parameters(
    cells=16,
    corners=8,
    phases=(0.0, 45.0),
    load_factors=(0.05, 0.1),
    cells_of_betas=10,
    betas=(0.0, 0.1),
)

# Cycles of two materials: half-length of the contact in half-widths, and the shear over P of a
# steady state above the limit at beta = 0.
_CYCLES = {"in_phase": (IN_PHASE, 1.6, 0.2), "rolls": (ROLLS, 1.8, 0.22)}


def phases(parameters: Parameters) -> Iterator[Row]:
    """One row for each phase and load factor."""
    system = cylinder(parameters.cells, parameters.half_length)
    for phase in each(parameters.phases, "phases"):
        cycle = out_of_phase(phase, parameters.corners, shear=1.0)
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


def betas(parameters: Parameters) -> Iterator[Row]:
    """One row for each beta and cycle."""
    cells = parameters.cells_of_betas
    for beta in each(parameters.betas, "betas"):
        limits = limits_of_two_materials([beta], cells).iloc[0]
        for name, (cycle, half_length, load_factor) in _CYCLES.items():
            system = cylinder(cells, half_length, beta)
            steady = fo.steady_state(system, cycle, FRICTION, load_factor)
            yield {
                "beta": beta,
                "cycle": name,
                "shakedown": limits[name],
                "load_factor": load_factor,
                "dissipation": steady.dissipation / PRESS**2,
                "outcome": steady.outcome.name,
                "residual": steady.residual,
            }


BETAS = Table(
    "moving_areas_betas",
    "one beta and cycle",
    {
        "beta": "Dundurs' constant",
        "cycle": "pressure and shear in phase, or a cylinder that rolls under a static shear",
        "shakedown": "limit with events, load factor; Q / P is 0.4 of it in phase",
        "load_factor": "of the steady state",
        "dissipation": "work of friction of a steady cycle over P^2 / E*",
        "outcome": "of the transient from no slip",
    },
    full=FULL,
    quick=QUICK,
    compute=betas,
)


def summary(tables: Mapping[str, pd.DataFrame]) -> str:
    """Limits of each phase, with the work at two load factors, and of each beta."""
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
    phases_table = markdown(["phase, degrees", "limit Q / P", "work at", "work at most at"], rows)
    by_beta = tables[BETAS.name].pivot(index="beta", columns="cycle", values="shakedown")
    rows = [
        [f"{beta:g}", f"{limits['in_phase']:.5f}", f"{limits['rolls']:.5f}"]
        for beta, limits in by_beta.iterrows()
    ]
    return phases_table + "\n" + markdown(["beta", "limit in phase", "limit rolling"], rows)


STUDY = Study(__name__, __doc__, "a coarse mesh, two phases, two betas", (PHASES, BETAS), summary)
