"""Contacts some of whose nodes stay open: the contact of the closed ones, and how the open ones follow it.

The nodes O are open at every corner k, the others C closed and stuck with a constant slip v. On O no force acts, and slip and gap there follow from
the load and from v. With the reactions `r_k = r0 + lam r1_k` of the closed contact::

    [v_k, w_k] on O = -S_OO^-1 (r_k + S_OC [v, 0])

So C is a contact of its own, with the stiffness `S_CC - S_CO S_OO^-1 S_OC` and the reactions `r_C - S_CO S_OO^-1 r_O`.
"""

from dataclasses import dataclass

import numpy as np

from ..contact import ContactSystem
from ..contact.checks import Array, Booleans
from ..contact.parts import joined, parted
from ..contact.tolerances import CONDENSATION, ROUNDING
from .mechanism import Mechanism

# Smallest eigenvalue of the open nodes' stiffness, over the largest, with which they leave no body free: the data have this error.
_HELD = CONDENSATION
_NOTHING_LEFT = ROUNDING / 10  # eigenvalues below this share of the largest entry of S are none once nodes are condensed out
_BESIDE = 2.0  # distances of the nearest node within which others are its neighbours


@dataclass(frozen=True, eq=False)
class OpenNodes:
    """Open nodes of a contact, and how they follow the others.

    Attributes
    ----------
    opened
        (N,) which nodes are open.
    follow, give
        `S_OO^-1 S_OC` and `S_OO^-1`: minus what the open nodes do for a motion of the others, and for forces.
    """

    opened: Booleans
    follow: Array
    give: Array

    def states(self, loads: Array, slip: Array) -> tuple[Array, Array]:
        """Slips and gaps of all nodes under reactions (..., M) of the closed contact, for a slip (N,) or (N, 2), of which the closed nodes count."""
        n, axes = len(self.opened), loads.shape[-1] // len(self.opened)
        out = np.tile(self.opened, axes)
        states = np.zeros(loads.shape)
        states[...] = joined(slip, np.zeros(n))
        states[..., out] = -loads[..., out] @ self.give - states[..., ~out] @ self.follow.T
        return parted(states, axes)

    def closed_part(self, motion: Mechanism, system: ContactSystem) -> Mechanism:
        """The mechanism of the closed nodes alone: the inverse of `expanded`."""
        stress, closed = joined(motion.slips, motion.lift) @ system.S, ~self.opened
        hold = None if motion.hold is None else motion.hold[closed]
        press = -parted(stress, system.tangents + 1)[1][:, self.opened]
        return Mechanism(motion.slips[:, closed], motion.opening[:, closed], motion.friction[closed], hold, press.clip(0.0))

    def expanded(self, motion: Mechanism, friction: Array) -> Mechanism:
        """The mechanism of the closed nodes with what the open ones do: they follow without force, pressed only where they would touch."""
        corners, axes = len(motion.opening), 1 + motion.slips[0].size // motion.opening.shape[1]
        n, lift = len(self.opened), motion.lift
        out, moved, press = np.tile(self.opened, axes), np.zeros((corners, axes * n)), np.zeros((corners, len(self.give)))
        if motion.press is not None:
            press[:, -motion.press.shape[1] :] = motion.press
        moved[:, ~out] = joined(motion.slips, lift)
        moved[:, out] = -moved[:, ~out] @ self.follow.T - press @ self.give
        slips, opening = parted(moved, axes)
        opening = opening.copy()
        opening[:, ~self.opened] = motion.opening
        hold = None
        if motion.hold is not None:
            hold = np.zeros((n, *motion.hold.shape[1:]))
            hold[~self.opened] = motion.hold
        return Mechanism(slips, opening, np.where(self.opened, 0.0, friction), hold, open=self.opened)


def following(system: ContactSystem, opened: Booleans) -> OpenNodes | None:
    """How open nodes follow the others; None if these, or nothing where all are open, do not hold them."""
    out, S = np.tile(opened, system.tangents + 1), system.S
    values, vectors = np.linalg.eigh(S[np.ix_(out, out)])
    held = values > _HELD * max(values[-1], np.finfo(float).tiny)
    loads = [joined(*pair) for pair in system.bonded.values()]
    driven = [r[out] @ vectors[:, ~held] / (np.abs(r).max() or 1.0) for r in loads]  # a way aside that no load takes is no matter
    if max(np.abs(part).max(initial=0.0) for part in (*driven, vectors[-int(opened.sum()) :, ~held])) > _HELD:
        return None
    give = (vectors[:, held] / values[held]) @ vectors[:, held].T
    return OpenNodes(opened, give @ S[np.ix_(out, ~out)], give)


def without(system: ContactSystem, nodes: OpenNodes) -> Array:
    """(m, m) stiffness of the closed nodes."""
    out, S = np.tile(nodes.opened, system.tangents + 1), system.S
    kept = S[np.ix_(~out, ~out)] - S[np.ix_(~out, out)] @ nodes.follow
    values, vectors = np.linalg.eigh((kept + kept.T) / 2)  # what nothing resists any more is left as rounding of both signs
    kept = (vectors * np.where(values > _NOTHING_LEFT * np.abs(S).max(), values, 0.0)) @ vectors.T
    return np.asarray(kept + kept.T) / 2


def border(system: ContactSystem, opened: Booleans, node: int, p: Array) -> str:
    """What a limit that a node beside open ones rules says of the mesh, as the end of a reason; p (K, N) are the normal forces at the limit.

    Pressure falls to zero where closed nodes meet open ones, unless the body ends there in an edge, where pressure is highest.
    """
    apart = np.linalg.norm(system.points - system.points[node], axis=1)
    apart[node] = np.inf
    pressure = p.min(axis=0) / (1.0 if system.width is None else system.width)
    if opened[node] or apart[opened].min(initial=np.inf) > _BESIDE * apart.min() or pressure[node] > pressure[~opened].mean():
        return ""
    return (
        f"; node {node} beside the open ones rules, where pressure falls to zero: the limit belongs to the mesh, and falls as elements shrink there"
    )
