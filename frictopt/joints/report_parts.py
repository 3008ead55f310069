"""The answers that a report is made of, and the numbers that follow from several of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from ..base import Array
from ..contact import ContactState, ContactSystem, LoadCycle
from ..limits import GrossSlip, GuaranteedLimit, RequiredFriction, ShakedownLimit
from ..transients import SteadyState
from .backbone import BackboneCurve

# From so many slipping nodes on, their work and share change by a few per cent with the mesh.
_MANY_NODES = 20


@dataclass(frozen=True, eq=False, repr=False)
class ReportParts:
    """The answers of a report, see `Report`. A part is None if `missing` has the reason."""

    system: ContactSystem
    cycle: LoadCycle
    friction: Array
    missing: Mapping[str, str]
    mean_state: ContactState | None = None
    gross_slip: GrossSlip | None = None
    curve: BackboneCurve | None = None
    limit: ShakedownLimit | None = None
    guaranteed: GuaranteedLimit | None = None
    required: RequiredFriction | None = None

    @property
    def steady(self) -> SteadyState | None:
        """The steady state at load factor 1, from no slip; None if there is none."""
        if self.curve is None:
            return None
        for state in self.curve.steady_states:
            if state is not None and state.load_factor == 1:
                return state
        return None

    @property
    def contacts(self) -> pd.DataFrame:
        """Contacts at load factor 1, see `SteadyState.by_contact`; empty without steady state."""
        return pd.DataFrame() if self.steady is None else self.steady.by_contact()


def mean_load_opens(parts: ReportParts) -> bool:
    """Whether the mean load leaves nodes open."""
    return parts.mean_state is not None and bool(parts.mean_state.open.any())


def many_nodes_slip(parts: ReportParts) -> bool:
    """Whether so many nodes slip that their work hardly depends on the mesh."""
    return parts.steady is not None and int(parts.steady.slipping.sum()) >= _MANY_NODES


def motion_of_load(parts: ReportParts) -> float:
    """Half the range of the motion of the load at load factor 1; not finite if it is not known."""
    if parts.curve is None:
        return np.nan
    at_load = parts.curve.load_factor == 1
    return float(parts.curve.motion[at_load].max(initial=-np.inf))
