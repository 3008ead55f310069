"""The answers that a report is made of, and the numbers that follow from several of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from ..base import Array, Outcome
from ..contact import ContactState, ContactSystem, LoadCycle
from ..limits import (
    GrossSlip,
    GuaranteedLimit,
    RequiredFriction,
    ShakedownLimit,
    moving_areas,
    pose,
)
from ..study.protocols import FrictionAfterProtocol, LimitAfterProtocol
from ..transients import SteadyState
from .backbone import BackboneCurve
from .curve_load import load_size, with_compliance
from .safety import SAFETY_COLUMNS, VERDICT_COLUMNS


@dataclass(frozen=True, eq=False, repr=False)
class ReportParts:
    """The answers of a report, see `Report`. A part is None if `missing` has the reason."""

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    missing: Mapping[str, str]
    mean_state: ContactState | None = None
    gross_slip: GrossSlip | None = None
    steady: SteadyState | None = None
    curve: BackboneCurve | None = None
    limit: ShakedownLimit | None = None
    guaranteed: GuaranteedLimit | None = None
    required: RequiredFriction | None = None
    assembled: LimitAfterProtocol | None = None
    required_assembled: FrictionAfterProtocol | None = None
    safety: pd.DataFrame = field(default_factory=lambda: pd.DataFrame(columns=SAFETY_COLUMNS))
    verdicts: pd.DataFrame = field(default_factory=lambda: pd.DataFrame(columns=VERDICT_COLUMNS))
    scatter: str = ""
    contacts: pd.DataFrame = field(default_factory=pd.DataFrame)
    probability: pd.DataFrame = field(default_factory=pd.DataFrame)
    life: pd.DataFrame = field(default_factory=pd.DataFrame)
    title: str = ""
    notes: str = ""
    origin: str = ""
    bodies: pd.DataFrame = field(default_factory=pd.DataFrame)
    model: Any = None
    states: Mapping[tuple[str, float], SteadyState | str] = field(default_factory=dict)
    identity: Array = field(default_factory=lambda: np.zeros(0))


def mean_load_opens(parts: ReportParts) -> bool:
    """Whether the mean load leaves nodes open."""
    return parts.mean_state is not None and bool(parts.mean_state.open.any())


def areas_move(system: ContactSystem, cycle: LoadCycle, friction: Array) -> bool:
    """Whether normal loads alone open and close nodes in each cycle, as under a roller.

    Then slip changes no pressure, and limits hold for all openings and closings.
    """
    question = pose(system, cycle, friction, question_name="shakedown_limit")
    return moving_areas(question) is not None


def limits_change_with_mesh(parts: ReportParts) -> bool:
    """Whether the last closed node beside those that the mean load opens decides the limits."""
    return mean_load_opens(parts) and not areas_move(parts.system, parts.cycle, parts.friction)


def many_nodes_slip(parts: ReportParts) -> bool:
    """Whether so many nodes slip that their work hardly depends on the mesh."""
    # From so many slipping nodes on, their work and share change by a few per cent with the mesh.
    many = 20
    return parts.steady is not None and int(parts.steady.slipping.sum()) >= many


def increments_are_coarse(steady: SteadyState) -> bool:
    """Whether finer increments may change the work by more than a few per cent."""
    # Estimated relative error of the work above which increments are too coarse to be quoted.
    coarse = 0.05
    return steady.steps > 0 and steady.step_error > coarse


def motion_of_load(parts: ReportParts) -> float:
    """Half the range of the motion of the load at load factor 1; not finite if it is not known."""
    if parts.steady is None:
        return np.nan
    _, load = with_compliance(parts.system, parts.cycle, parts.friction, None)
    displacement = load.measured(parts.steady)["displacement"]
    return displacement / load_size(parts.system, parts.cycle)


def motions_of_points(parts: ReportParts) -> dict[str, float]:
    """Point -> half the range of its motion at load factor 1, along its force.

    A point is a load case of forces whose amplitude in the cycle is 0.
    """
    steady, system, cycle = parts.steady, parts.system, parts.cycle
    if steady is None or steady.outcome is Outcome.RATCHETING or system.compliance is None:
        return {}
    loads = [cycle.mean, *cycle.corners, *(cycle.fixed or ())]
    named = dict.fromkeys(case for corner in loads for case in corner)
    return {
        case: float(np.ptp(steady.displacement(case)) / 2 / system.load_size[case])
        for case in named
        if case in system.load_size and not any(corner.get(case, 0.0) for corner in loads)
    }
