"""The table of the faces of a joint: when each one slides in full, its utilisation, its slip."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from ..base import CONDENSATION, ROUNDING, Array, Booleans
from ..contact import ContactState, ContactSystem, LoadCycle, joined, reactions
from ..limits import GrossSlip
from ..limits.balance.body_motions import MOVES
from ..limits.balance.corner_statics import drives
from ..limits.balance.face_statics import FaceLoad, slides_in_full_at, without_lift
from ..limits.program.question import outer_corners
from ..transients import SteadyState
from ..transients.fretting import nodes_of_contacts, rows_of_corners
from ..transients.statics import motions_of_bodies
from .thresholds import place_of_node


def face_table(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Array,
    mean: ContactState,
    steady: SteadyState | None,
    gross_slip: GrossSlip | None,
) -> pd.DataFrame:
    """A row for each contact, see `Report.contacts`."""
    faces = nodes_of_contacts(system)
    table = pd.DataFrame({"contact": list(faces)})
    corners = {"slides_at": _under_mean_load(system, cycle, mean)}
    if steady is not None:
        table = steady.by_contact()
        with np.errstate(divide="ignore", invalid="ignore"):
            used = [np.abs(table[f"Q_{k}"]) / table[f"fP_{k}"] for k in range(len(cycle.corners))]
        utilisation = np.nan_to_num(used, nan=0.0).max(axis=0)
        table["utilisation"] = np.where(utilisation > ROUNDING, utilisation, 0.0)
        corners["slides_at_steady"] = _in_steady_state(corners["slides_at"], steady)
    for name, of_cycle in corners.items():
        table[name] = [
            slides_in_full_at(system, friction, face, of_cycle.values()) for face in faces.values()
        ]
    if gross_slip is not None:
        share = gross_slip.carried()
        table["carries"] = [share[face].sum() for face in faces.values()]
        # A face that moves as bodies slide off slides by then.
        moves = [np.abs(gross_slip.phi[:, face]).max() > MOVES for face in faces.values()]
        for name in corners:
            table[name] = np.fmin(table[name], np.where(moves, factor_of(gross_slip), np.inf))
    if steady is not None:
        ranges = np.asarray(steady.fretting_table()["slip_range"])
        table["where"] = [_place_of_most(system, ranges, face) for face in faces.values()]
    return table


def faces_slide_at(
    system: ContactSystem, cycle: LoadCycle, friction: Array, mean: ContactState
) -> list[float]:
    """The load factor at which each face slides in full, pressed as in the state `mean`."""
    loads = _under_mean_load(system, cycle, mean).values()
    faces = nodes_of_contacts(system).values()
    return [slides_in_full_at(system, friction, face, loads) for face in faces]


def factor_of(gross: GrossSlip) -> float:
    """The safety factor of a gross-slip load.

    It is 0 if no state of rest exists at load factor 1 or below.
    """
    if np.isnan(gross.load_factor) or gross.least > 1 + ROUNDING:
        return 0.0
    return gross.load_factor


def _under_mean_load(
    system: ContactSystem, cycle: LoadCycle, mean: ContactState
) -> dict[int, FaceLoad]:
    """The corners that matter, with the normal forces of the state under the mean load."""
    bonded = joined(mean.bonded_q, mean.bonded_p)
    p = (bonded + system.S @ joined(mean.slip, mean.gap - system.gap))[-system.nodes :]
    motions = motions_of_bodies(system)
    slides = motions @ without_lift(motions[-system.nodes :], CONDENSATION)

    def driving(loads: Mapping[str, float]) -> dict[str, float]:
        """The loads without those that slide no body, such as preloads: slip relieves them."""
        if not motions.size:
            return dict(loads)
        return {
            case: amplitude
            for case, amplitude in loads.items()
            if drives(slides, reactions(system, [{case: 1.0}])[0])
        }

    constant = reactions(system, cycle.unscaled)
    shear = reactions(system, [driving(loads) for loads in cycle.unscaled])
    cyclic = reactions(system, cycle.corners)
    # Without fixed parts all corners have the same constant load.
    last = len(constant) - 1
    return {
        k: FaceLoad(constant[min(k, last)], shear[min(k, last)], cyclic[k], p, bonded)
        for k in outer_corners(cycle)
    }


def _in_steady_state(corners: Mapping[int, FaceLoad], steady: SteadyState) -> dict[int, FaceLoad]:
    """The loads at the corners, with the normal forces of the steady state there."""
    states = steady.states()
    rows = rows_of_corners(states)
    return {
        k: corner._replace(p=states.p[rows[k]], of_state=corner.constant + corner.cyclic)
        for k, corner in corners.items()
    }


def _place_of_most(system: ContactSystem, values: Array, face: Booleans) -> str:
    """The place of the node of a face with the largest of some values (N,); "" if all are 0."""
    node = int(np.argmax(np.where(face, values, -np.inf)))
    return place_of_node(system, node) if values[node] > 0 else ""
