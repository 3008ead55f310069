"""Closed form of the safe load factors where tangential motion leaves the pressures alone (B = 0)."""

from dataclasses import dataclass

import numpy as np

from ..contact import ContactSystem
from ..contact.checks import Array
from ..contact.tolerances import NO_COUPLING
from .loads import Loads
from .mechanism import Mechanism
from .scaling import rigid_slides

__all__ = ["UncoupledEnd", "is_uncoupled", "uncoupled_ends"]


@dataclass(frozen=True, eq=False)
class UncoupledEnd:
    """An end of the safe load factors, a slip that is safe there, and the mechanism that proves it (idle at load factor 0)."""

    load_factor: float
    slip: Array
    motion: Mechanism


def is_uncoupled(system: ContactSystem, friction: Array) -> bool:
    """Whether tangential motion does not change the friction bounds: f B is zero up to rounding, against A of the two nodes that it joins."""
    stiffness = np.sqrt(np.diag(system.A).clip(0.0).reshape(system.tangents, -1).sum(axis=0))
    return bool((np.abs(friction[:, None] * system.B) <= NO_COUPLING * np.outer(stiffness, np.tile(stiffness, system.tangents))).all())


def uncoupled_ends(system: ContactSystem, loads: Loads, friction: Array) -> tuple[UncoupledEnd, UncoupledEnd] | None:
    """The least and the largest safe load factor of an uncoupled contact, or None where this form does not hold.

    With B = 0 the shear changes `s = A v` are free, node by node: a node needs room for `s` between its ruling corners, and a contact that slides
    rigidly (a punch without supports, A 1 = 0) needs `sum s = 0` besides. Each of these needs is a row `lam drive <= resistance`. Holds where the
    largest load factor is finite and nothing of the cycle is fixed. (Klarbring, Ciavarella & Barber 2007: shakedown is guaranteed between both ends.)
    """
    if not is_uncoupled(system, friction) or friction.min() == 0 or loads.fixed:
        return None
    nodes = system.nodes
    rigid, compliance = rigid_slides(system)
    floating = bool(rigid.size)
    if floating and (rigid.shape[1] > 1 or np.ptp(rigid) > 1e-6 / np.sqrt(nodes)):
        return None

    q0, bound = loads.q0[0], friction * loads.p0[0]
    forward, backward = -(loads.q1 + friction * loads.p1), loads.q1 - friction * loads.p1
    rules = forward.argmax(axis=0), backward.argmax(axis=0)
    rise, fall = forward.max(axis=0), backward.max(axis=0)
    resistance, drive = 2 * bound, rise + fall
    if floating:
        resistance, drive = np.r_[resistance, (bound + q0).sum(), (bound - q0).sum()], np.r_[drive, rise.sum(), fall.sum()]
    with np.errstate(divide="ignore", invalid="ignore"):
        limits = resistance / drive
    above, below = np.where(drive > 0, limits, np.inf), np.where(drive < 0, limits, -np.inf)
    if not np.isfinite(above.min()) or below.max() > above.min() or (resistance[drive == 0] < 0).any():
        return None

    def end(load_factor: float, row: int) -> UncoupledEnd:
        least, most = load_factor * rise - bound - q0, bound - q0 - load_factor * fall
        room = most - least
        share = 0.5 if not floating or room.sum() <= 0 else float(np.clip(-least.sum() / room.sum(), 0.0, 1.0))
        return UncoupledEnd(load_factor, compliance @ (least + share * room), _mechanism(row, rules, forward.shape, friction))

    return end(max(float(below.max()), 0.0), int(below.argmax())), end(float(above.min()), int(above.argmin()))


def _mechanism(which: int, rules: tuple[np.ndarray, np.ndarray], shape: tuple[int, int], friction: Array) -> Mechanism:
    """One node slipping forth and back, or (past the last node) all nodes slipping one way at their ruling corners.

    A node that slips forth and back at one corner opens by friction times that.
    """
    slips, nodes = np.zeros((2, *shape)), np.arange(shape[1])
    if which < shape[1]:
        for direction in (0, 1):
            slips[direction, rules[direction][which], which] = 1.0
    else:
        direction = which - shape[1]
        slips[direction, rules[direction], nodes] = 1.0
    return Mechanism(slips[0] - slips[1], 2 * friction * slips.min(axis=0), friction)
