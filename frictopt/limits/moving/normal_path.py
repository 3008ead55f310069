"""Pressures and gaps of an uncoupled contact along its load cycle, from the normal problem alone.

If slip changes no pressure (B = 0), pressures p and gaps w solve ``p = b + C w``, ``p >= 0``, ``w
>= 0``, ``p w = 0`` with the normal reactions b of the load, all gaps pressed shut. They are
piecewise linear along the cycle. The path goes from one *instant* to the next: a corner, or a place
at which a pressure or a gap comes to zero. Nodes that reach zero together are one event, as in
symmetric contacts. There the rates of pressures and gaps solve a small problem of the same kind,
which decides which of these nodes open.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dposv

from ...base import CONDENSATION, SIMULTANEOUS, Array, Booleans, Integers

# Numbers of the path.

# Pressures up to this share of the largest reaction count as zero, and gaps up to this share of the
# largest gap that the loads could make: the data are right to about this share.
_ZERO = CONDENSATION
# An event that is nearer to the end of its leg than this share of the leg is at the corner.
_AT_CORNER = SIMULTANEOUS
# Largest number of events on a leg, and of pivots of a problem, each times the nodes.
_STEPS = 20
# Number of pivots with all wrong nodes that may bring no improvement, before pivots with single
# nodes follow.
_PATIENCE = 10


@dataclass(frozen=True, eq=False)
class NormalPath:
    """Pressures and gaps at the M instants of a load cycle, in their order."""

    leg: Integers  # (M,) the corner at which the leg of the instant begins
    part: Array  # (M,) place on the leg, 0 at its first corner, below 1
    pressure: Array  # (M, N) force
    gap: Array  # (M, N) length

    @property
    def presses(self) -> Booleans:
        """(M, N) whether a node has pressure between an instant and the next one."""
        following = np.roll(self.pressure, -1, axis=0)
        return self.pressure + following > 0


class NoPath(Exception):
    """The normal problem has no solution, or many: nothing holds the bodies together."""


def normal_path(C: Array, corners: Array) -> NormalPath:
    """The path of pressures and gaps around the cycle of the reactions (K, N) at its corners.

    C (N, N) is the normal stiffness. NoPath if a free body lifts off.
    """
    problem = _NormalProblem(C, corners)
    instants = list[tuple[int, float, Array, Array]]()
    opened = _open_nodes(C, corners[0], problem.force, problem.length)
    for k, first in enumerate(corners):
        change = corners[(k + 1) % len(corners)] - first
        part = 0.0
        pressure, gap = problem.clean(*states(C, first, opened))
        for _ in range(_STEPS * len(first) + 1):
            instants.append((k, part, pressure, gap))
            # On this piece of the leg both are linear.
            opened, pressures, gaps = problem.following((pressure, gap), opened, first, change)
            part += _to_next_event((pressure, pressures[1]), (gap, gaps[1]))
            if part >= 1 - _AT_CORNER:
                break
            pressure, gap = problem.clean(
                pressures[0] + part * pressures[1], gaps[0] + part * gaps[1]
            )
        else:
            raise NoPath("the events of a leg do not end")
    legs, parts, all_pressures, all_gaps = zip(*instants, strict=True)
    return NormalPath(np.array(legs), np.array(parts), np.array(all_pressures), np.array(all_gaps))


def _to_next_event(*states: tuple[Array, Array]) -> float:
    """Part of a leg after which the first of some positive values is zero, by their rates."""
    nearest = np.inf
    for values, rates in states:
        falling = (values > 0) & (rates < 0)
        nearest = min(nearest, float((values[falling] / -rates[falling]).min(initial=np.inf)))
    return nearest


class _NormalProblem:
    """The normal problem of one stiffness, for reactions of one size."""

    def __init__(self, C: Array, corners: Array) -> None:
        self._C = C
        self.force, self.length = _rounding(C, corners)

    def clean(self, pressure: Array, gap: Array) -> tuple[Array, Array]:
        """Pressures and gaps, their rounding set to zero."""
        pressed = np.where(pressure > self.force, pressure, 0.0)
        return pressed, np.where(gap > self.length, gap, 0.0)

    def following(
        self, now: tuple[Array, Array], opened: Booleans, first: Array, change: Array
    ) -> tuple[Booleans, Array, Array]:
        """The open nodes from an instant on, and (2, N) pressures and gaps with these open nodes.

        `now` are pressures and gaps at the instant, `opened` are the open nodes before it. The
        reactions on the leg are `first`, plus a part of `change`.
        """
        pressure, gap = now
        touching = (pressure == 0) & (gap == 0)
        reactions = np.stack([first, change])
        force, length = _rounding(self._C, change)
        # Usually each node whose pressure or gap comes to zero opens or closes.
        opened = opened ^ touching
        pressures, gaps = states(self._C, reactions, opened)
        if (np.where(opened, gaps[1] > length, pressures[1] > force) | ~touching).all():
            return opened, pressures, gaps
        opened = self._open_by_rates(gap > 0, touching, change)
        return opened, *states(self._C, reactions, opened)

    def _open_by_rates(self, opened: Booleans, touching: Booleans, change: Array) -> Booleans:
        """The open nodes if the reactions change, of given open nodes and touching ones.

        The rates of pressures and gaps of the touching nodes solve a normal problem, too.
        """
        C = self._C[np.ix_(touching, touching)]
        rates = change[touching]
        if opened.any():
            across = self._C[np.ix_(opened, touching)]
            motions = follow(self._C[np.ix_(opened, opened)], np.c_[across, change[opened]])
            C = C - across.T @ motions[:, :-1]
            rates = rates - across.T @ motions[:, -1]
        opened[touching] = _open_nodes(C, rates, *_rounding(C, change))
        return opened


def _rounding(C: Array, reactions: Array) -> tuple[float, float]:
    """The force and the length that count as zero, for a stiffness and reactions."""
    force = _ZERO * (float(np.abs(reactions).max()) or 1.0)
    return force, force / (float(C.diagonal().max()) or 1.0)


def follow(stiffness: Array, forces: Array) -> Array:
    """Motions of open nodes, with the stiffness of these nodes, under given forces.

    NoPath if nothing holds the open nodes.
    """
    if not len(stiffness):
        return np.zeros_like(forces)
    factor, motions, failed = dposv(stiffness, forces)
    if failed:
        raise NoPath("open nodes are not held")
    pivots = factor.diagonal() ** 2
    if pivots.min() <= CONDENSATION * stiffness.diagonal().max():
        raise NoPath("open nodes are hardly held")
    return np.asarray(motions.reshape(forces.shape))


def states(C: Array, reactions: Array, opened: Booleans) -> tuple[Array, Array]:
    """Pressures and gaps (or their rates) with given open nodes, of whatever sign.

    Reactions (..., N) give pressures and gaps of the same shape.
    """
    gap = np.zeros_like(reactions)
    pressure = reactions.copy()
    if opened.any():
        rows = C[opened]
        gap[..., opened] = -follow(rows[:, opened], reactions[..., opened].T).T
        pressure += gap[..., opened] @ rows
        pressure[..., opened] = 0.0
    return pressure, gap


def _open_nodes(C: Array, reactions: Array, force: float, length: float) -> Booleans:
    """The open nodes of a normal problem, by principal pivots.

    All wrong nodes are flipped at once. If this does not converge, only the last wrong node is
    flipped (Murty's rule), which ends if C is positive definite. After `_STEPS` N steps it fails.
    """
    count = len(reactions)
    opened = np.zeros(count, dtype=bool)
    fewest = count + 1
    patience = _PATIENCE
    for _ in range(_STEPS * count):
        pressure, gap = states(C, reactions, opened)
        wrong = np.where(opened, gap < -length, pressure < -force)
        wrongs = int(wrong.sum())
        if not wrongs:
            return opened
        if wrongs < fewest:
            fewest = wrongs
            patience = _PATIENCE
        else:
            patience -= 1
        flipped = wrong
        if patience < 0 or (opened ^ wrong).all():
            flipped = np.zeros(count, dtype=bool)
            flipped[np.flatnonzero(wrong)[-1]] = True
        opened = opened ^ flipped
    raise NoPath("no pressures and gaps found")
