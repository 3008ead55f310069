"""Limits of the dovetail, the pin in a plate and the rounded punch, as functions of friction.

Run with `python -m studies scenes [--quick]`. Loads are in the units of each scene: the mean pull
of the blade, the mean pressure of the fit and the mean pressure of the punch are 1.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd

import frictopt as fo

from .progress import each
from .tables import Study, Table


@dataclass(frozen=True)
class Parameters:
    """Parameters of the study."""

    flank_elements: int = 40
    angles: tuple[float, ...] = (35.0, 45.0, 60.0)
    # Frictions relative to the cotangent of the angle.
    shares: tuple[float, ...] = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.001)
    ring_elements: int = 80
    # Number of corners of the polygon that approximates a rotating force.
    corners: int = 8
    frictions: tuple[float, ...] = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
    punch_elements: int = 40
    # Radii of the edges; inf is sharp.
    radii: tuple[float, ...] = (np.inf, 2.0, 0.5, 0.2)


FULL = Parameters()
QUICK = Parameters(
    flank_elements=4,
    shares=(0.3, 0.9, 1.001),
    ring_elements=24,
    corners=4,
    frictions=(0.2, 0.5, 0.8),
    punch_elements=8,
    radii=(np.inf, 0.5),
)


def punch(radius: float, elements: int) -> fo.scenes.PunchOnHalfPlane | fo.scenes.RoundedPunch:
    """The punch with a rounded outer fifth; an infinite radius gives sharp edges."""
    flat = fo.scenes.PunchOnHalfPlane(elements=elements, grading=1.0)
    return flat if np.isinf(radius) else fo.scenes.RoundedPunch(radius, 0.8 * flat.half_width, flat)


def limits(parameters: Parameters) -> pd.DataFrame:
    """One row per scene, load and friction coefficient."""
    return pd.DataFrame(
        [_row(*run) for run in each(list(_runs(parameters)), "limits of the scenes")]
    )


def _runs(
    parameters: Parameters,
) -> Iterator[tuple[str, str, float, fo.ContactSystem, fo.LoadCycle, float]]:
    """Scene, load, parameter, contact, load cycle and friction of each row."""
    for angle in parameters.angles:
        system = fo.scenes.Dovetail(angle=angle, elements=parameters.flank_elements).condense()
        for case in ("pull", "sway"):
            for share in parameters.shares:
                cycle = fo.LoadCycle({"pull": 1.0}, [{case: 1.0}, {case: -1.0}])
                yield "dovetail", case, angle, system, cycle, share / np.tan(np.radians(angle))
    system = fo.scenes.PinInPlate(elements=parameters.ring_elements).condense()
    fit = {"fit": 2 * np.pi / float(system.bonded["fit"][1].sum())}
    turns = 2 * np.pi * np.arange(parameters.corners) / parameters.corners
    for case, corners in {
        "to and fro": [{"Fx": 1.0}, {"Fx": -1.0}],
        "rotating": [{"Fx": float(np.cos(turn)), "Fy": float(np.sin(turn))} for turn in turns],
        "plate": [{"sigma": 1.0}, {"sigma": -1.0}],
    }.items():
        for friction in parameters.frictions:
            yield "pin", case, float("nan"), system, fo.LoadCycle(fit, corners), friction
    for radius in parameters.radii:
        system = punch(radius, parameters.punch_elements).condense()
        for friction in parameters.frictions:
            yield (
                "punch",
                "sigma",
                radius,
                system,
                fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}]),
                friction,
            )


def _row(
    scene: str,
    case: str,
    parameter: float,
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    friction: float,
) -> dict[str, object]:
    onset = fo.onset(system, cycle, friction)
    limit = fo.shakedown_limit(system, cycle, friction)
    lower = fo.guaranteed_limit(system, cycle, friction)
    return {
        "scene": scene,
        "case": case,
        "parameter": parameter,
        "nodes": system.nodes,
        "friction": friction,
        "onset": onset.slip.load_factor,
        "load_factor": limit.load_factor,
        "guaranteed": lower.load_factor,
        "residual": max(limit.residual, lower.residual),
    }


_LIMITS_COLUMNS = {
    "scene": "dovetail, pin or punch",
    "case": "load that goes to and fro, or round",
    "parameter": "angle of the flanks, degrees; radius of the punch's edges / a; NaN for the pin",
    "onset": "load factor at the first slip, once the mean load has settled where it opens nodes; 0 where it alone slips",
    "load_factor": "shakedown limit lambda_2; inf: none; NaN: no residual slip is safe",
}
LIMITS = Table(
    "scenes_limits",
    "limits of one scene under one load at one friction",
    _LIMITS_COLUMNS,
    FULL,
    QUICK,
    limits,
)

STUDY = Study("studies.scenes", __doc__, "coarse meshes, in seconds", (LIMITS,))
