"""Names of the motions in which bodies slide off: slides, turns, pries, lifts off."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..base import Array
from ..contact import ContactSystem
from ..limits import GrossSlip
from ..limits.balance.body_motions import MOVES

SLIDES, TURNS, PRIES, LIFTS_OFF = "slides", "turns", "pries", "lifts off"
# The first of these motions names that of a joint whose contacts move in several ways.
_ORDER = (PRIES, TURNS, SLIDES, LIFTS_OFF)
_MOST_NAMES = 4  # contacts that a sentence names


def motions_of_contacts(system: ContactSystem, gross_slip: GrossSlip) -> dict[str, str]:
    """Contact -> name of its motion, for the contacts that move as bodies slide off."""
    motions = dict[str, str]()
    # Differences of normals up to this number are those of a flat face.
    flat = 1e-6
    for row in gross_slip.motion.to_dict("records"):
        name = str(row["contact"])
        nodes = np.ones(system.nodes, dtype=bool)
        if system.contact is not None:
            nodes = system.contact == name
        is_flat = np.ptp(system.normals[nodes], axis=0).max() <= flat
        motions[name] = _motion(gross_slip.phi[:, nodes], float(row["turn"]), bool(is_flat))
    return motions


def _motion(phi: Array, turn: float, is_flat: bool) -> str:
    """Name of a motion (t + 1, n) of the nodes of a contact, with its angle, NaN if not known.

    A turn tilts a face that it pries open: its lifts differ by more than its slips. A turn about
    the normal of a flat face, or of a shaft in its hub, lifts all nodes alike. The angle is 0 if
    only nodes move that lift by the same distance; if the face is flat, they differ from the nodes
    at rest.
    """
    *slips, lift = phi
    slip = float(np.linalg.norm(slips, axis=0).mean())
    tilt = float(np.ptp(lift))
    turns = is_flat or turn != 0  # also if the angle is NaN
    if tilt > slip + MOVES and turns:
        return PRIES
    if turn != 0 and not np.isnan(turn):
        return TURNS
    return SLIDES if slip > MOVES else LIFTS_OFF


def motion_of_joint(system: ContactSystem, gross_slip: GrossSlip) -> str:
    """Name of the motion of the joint; "" if it does not slide off."""
    motions = set(motions_of_contacts(system, gross_slip).values())
    return next((name for name in _ORDER if name in motions), "")


def motion_in_words(system: ContactSystem, gross_slip: GrossSlip, body: str) -> str:
    """Text such as "body blade pries at lap and slides at head, nut"; "" without a motion.

    `body` is the name of body 1, or "1".
    """
    by_motion = dict[str, list[str]]()
    for contact, motion in motions_of_contacts(system, gross_slip).items():
        by_motion.setdefault(motion, []).append(contact)
    texts = [f"{name} at {_some(by_motion[name])}" for name in _ORDER if name in by_motion]
    return f"body {body} {' and '.join(texts)}" if texts else ""


def _some(contacts: Sequence[str]) -> str:
    names = list(contacts[:_MOST_NAMES])
    if len(contacts) > _MOST_NAMES:
        names.append(f"{len(contacts) - _MOST_NAMES} more")
    return ", ".join(names)
