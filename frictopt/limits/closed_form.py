"""Closed form of the shakedown limit where tangential motion leaves the pressures alone (B = 0)."""

import numpy as np

from ..contact import ContactSystem
from ..contact.checks import Array
from ..contact.tolerances import NO_COUPLING
from .mechanism import Mechanism
from .scaling import Loads, rigid_slides

__all__ = ["is_uncoupled", "uncoupled_limit"]


def is_uncoupled(system: ContactSystem, friction: Array) -> bool:
    """Whether tangential motion does not change the friction bounds: f B is zero up to rounding, against A of the two nodes that it joins."""
    stiffness = np.sqrt(np.diag(system.A).clip(0.0))
    return bool((np.abs(friction[:, None] * system.B) <= NO_COUPLING * np.outer(stiffness, stiffness)).all())


def uncoupled_limit(system: ContactSystem, loads: Loads, friction: Array) -> tuple[float, Array, Mechanism] | None:
    """Limit, safe slip and mechanism of an uncoupled contact, or None where this form does not hold.

    With B = 0 the shear changes `s = A v` are free, node by node: a node needs room for `s` between its ruling corners, and a contact that slides
    rigidly (a punch without supports, A 1 = 0) needs `sum s = 0` besides. Holds for mean loads that press every node.
    (Klarbring, Ciavarella & Barber 2007: here the limit also guarantees shakedown.)
    """
    if not is_uncoupled(system, friction) or loads.p0.min() < 0 or friction.min() == 0:
        return None
    nodes = system.nodes
    rigid, compliance = rigid_slides(system)
    floating = bool(rigid.size)
    if floating and (rigid.shape[1] > 1 or np.ptp(rigid) > 1e-6 / np.sqrt(nodes)):
        return None

    bound = friction * loads.p0
    forward, backward = -(loads.q1 + friction * loads.p1), loads.q1 - friction * loads.p1
    rules = forward.argmax(axis=0), backward.argmax(axis=0)
    rise, fall = forward.max(axis=0), backward.max(axis=0)
    resistance, drive = 2 * bound, rise + fall
    if floating:
        whole = np.array([(bound + loads.q0).sum(), (bound - loads.q0).sum()])
        if whole.min() < 0:
            return None
        resistance, drive = np.r_[resistance, whole], np.r_[drive, rise.sum(), fall.sum()]
    with np.errstate(divide="ignore", invalid="ignore"):
        limits = np.where(drive > 0, resistance / drive, np.inf)
    load_factor = float(limits.min())
    if not np.isfinite(load_factor):
        return None

    least, most = load_factor * rise - bound - loads.q0, bound - loads.q0 - load_factor * fall
    room = most - least
    share = 0.5 if not floating or room.sum() <= 0 else float(np.clip(-least.sum() / room.sum(), 0.0, 1.0))
    shear = least + share * room
    return load_factor, compliance @ shear, _mechanism(int(limits.argmin()), rules, forward.shape)


def _mechanism(which: int, rules: tuple[np.ndarray, np.ndarray], shape: tuple[int, int]) -> Mechanism:
    """One node slipping forth and back, or (past the last node) all nodes slipping one way at their ruling corners."""
    slips = np.zeros((3, *shape))
    nodes = np.arange(shape[1])
    if which < shape[1]:
        for direction in (0, 1):
            slips[direction, rules[direction][which], which] = 1.0
    else:
        direction = which - shape[1]
        slips[direction, rules[direction], nodes] = 1.0
    return Mechanism(slips[0], slips[1], slips[2], np.zeros(shape[1]))
