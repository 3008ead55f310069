"""Onset of slip and separation of the bonded contact under a monotonic load (Flicek et al. 2015, section 3)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .checks import Array, checked_loads
from .coulomb import friction_coefficients
from .system import ContactSystem, checked_system

__all__ = ["Onset", "OnsetEvent", "onset"]

_TIE = 1e-9  # events this close (relative) count as simultaneous; the node of lowest index is named
_ROUNDING = 1e-12  # violations of the mean load below this share of the mean normal force are rounding


@dataclass(frozen=True)
class OnsetEvent:
    """The first event of its kind.

    Attributes
    ----------
    load_factor
        Load factor at which it happens, inf if it never does, 0 if the mean load alone already brings it about.
    node
        Index of the node, None if it never happens; of simultaneous nodes the one of lowest index.
    sense
        +1: the node slips along +x (q = -f p), -1: along -x (q = +f p), 0: it separates, or never does anything.
    """

    load_factor: float
    node: int | None
    sense: int


@dataclass(frozen=True, eq=False)
class Onset:
    """What the bonded contact does first under `mean + load_factor * direction`.

    Attributes
    ----------
    slip, separation
        First slip and first separation.
    mean_slips, mean_opens
        Indices of the nodes at which the mean load alone already exceeds the friction bound, or pulls. Where there are any, the bonded contact
        cannot carry the mean load and its onset says nothing about loads above it: apply the mean load by a path first.
    """

    slip: OnsetEvent
    separation: OnsetEvent
    mean_slips: tuple[int, ...]
    mean_opens: tuple[int, ...]

    @property
    def mean_admissible(self) -> bool:
        """Whether the mean load alone obeys the law at every node of the bonded contact."""
        return not (self.mean_slips or self.mean_opens)


def onset(system: ContactSystem, mean: Mapping[str, float], direction: Mapping[str, float], friction: Any) -> Onset:
    """Find the first slip and the first separation of the bonded contact as the load grows along `mean + lam * direction`, `lam >= 0`.

    Closed form, node by node: forward slip starts where `q + f p = 0`, backward slip where `f p - q = 0`, separation where `p = 0`.

    Parameters
    ----------
    system
        The contact.
    mean, direction
        Load case name -> amplitude.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Unknown load case, amplitudes not finite, bad friction.
    """
    f = friction_coefficients(friction, checked_system(system).nodes)
    q0, p0 = system.closed_reaction(checked_loads("mean", mean))
    q1, p1 = system.reaction(checked_loads("direction", direction))
    floor = _ROUNDING * float(np.abs(p0).mean())
    slacks = np.array([q0 + f * p0, f * p0 - q0, p0])
    rates = np.array([q1 + f * p1, f * p1 - q1, p1])
    return Onset(
        slip=_first(slacks[:2], rates[:2], floor, senses=(+1, -1)),
        separation=_first(slacks[2:], rates[2:], floor, senses=(0,)),
        mean_slips=_below(slacks[:2].min(axis=0), floor),
        mean_opens=_below(slacks[2], floor),
    )


def _first(slack: Array, rate: Array, floor: float, senses: tuple[int, ...]) -> OnsetEvent:
    """First zero of `slack + lam * rate`, rows by sense, columns by node."""
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(slack < -floor, 0.0, np.where(rate < 0, np.maximum(slack, 0.0) / -rate, np.inf))
    first = float(factor.min())
    if not np.isfinite(first):
        return OnsetEvent(np.inf, None, 0)
    tied = factor <= first * (1 + _TIE)
    node = int(np.argmax(tied.any(axis=0)))
    return OnsetEvent(first, node, senses[int(np.argmax(tied[:, node]))])


def _below(slack: Array, floor: float) -> tuple[int, ...]:
    return tuple(int(i) for i in np.flatnonzero(slack < -floor))
