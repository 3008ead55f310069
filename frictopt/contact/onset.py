"""Onset of slip and separation of the bonded contact, corner by corner of a load cycle (Flicek et al. 2015, section 3)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .checks import Array
from .coulomb import friction_coefficients, lengths
from .cycle import LoadCycle, checked_cycle
from .diagnosis import unscaled_diagnosis
from .odd_values import warns_of_odd_values
from .show import Plotted, Shown, frame
from .system import ContactSystem, checked_system
from .tolerances import ROUNDING, SIMULTANEOUS

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Onset", "OnsetEvent", "onset", "reach"]


@dataclass(frozen=True, repr=False)
class OnsetEvent(Shown):
    """The first slip or the first separation as the load grows towards one corner.

    Attributes
    ----------
    corner
        Number of the corner, from 0.
    event
        "slip" or "separation".
    load_factor
        Load factor of the event; inf if it never happens, 0 if it happens under the mean load alone.
    node
        Index of the node; None if the event never happens. Of several simultaneous nodes, that with the lowest index.
    sense
        +1: the node slips along +x (q = -f p), -1: along -x (q = +f p), 0: it separates, or the event never happens. In three dimensions the
        unit vector of the slip along the two tangents.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> fo.onset(node, fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}]), friction=0.5).separation
    OnsetEvent(corner=0, event=separation, load_factor=inf, node=None, sense=0)
    """

    corner: int
    event: str
    load_factor: float
    node: int | None
    sense: int | tuple[float, float]

    def _answer(self) -> Mapping[str, object]:
        return vars(self)


@dataclass(frozen=True, repr=False)
class Onset(Shown, Plotted):
    """First slip and first separation of the bonded contact under `mean + fixed + load_factor * corner`, for each corner of a load cycle.

    Attributes
    ----------
    slips, separations
        First slip and first separation under each of the K corners.
    mean_slips, mean_opens
        Indices of the nodes at which the mean load alone, or with what is fixed at some corner, already exceeds the friction bound, or pulls. If
        there are any, the bonded contact cannot carry it, and its onset is undefined: apply the mean load by a path first.
    residual
        Largest violation of the contact law by the bonded contact at the first event under each corner, in units of the largest nodal force there.
        It exceeds rounding only if the mean load alone violates the law.
    system, cycle
        The contact and its load cycle.
    friction
        (N,) coefficients of friction.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> first = fo.onset(node, fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}, {"Q": -1.0}]), friction=0.5)
    >>> [event.load_factor for event in first.slips], first.slip.load_factor, first.mean_admissible
    ([0.25, 0.5], 0.25, True)
    """

    slips: tuple[OnsetEvent, ...]
    separations: tuple[OnsetEvent, ...]
    mean_slips: tuple[int, ...]
    mean_opens: tuple[int, ...]
    residual: float
    system: ContactSystem = field(compare=False)
    cycle: LoadCycle = field(compare=False)
    friction: Array = field(compare=False)

    @property
    def slip(self) -> OnsetEvent:
        """The first slip under any corner; of simultaneous ones that of the first corner."""
        return _earliest(self.slips)

    @property
    def separation(self) -> OnsetEvent:
        """The first separation under any corner; of simultaneous ones that of the first corner."""
        return _earliest(self.separations)

    @property
    def mean_admissible(self) -> bool:
        """Whether the mean load alone obeys the law at every node of the bonded contact."""
        return not (self.mean_slips or self.mean_opens)

    @property
    def reason(self) -> str:
        """What the mean load does to the bonded contact, and what to change if that contact cannot carry it, as a sentence."""
        text = unscaled_diagnosis(self.system, self.cycle, self.friction)
        if self.mean_admissible:
            return text
        return f"{text}; the bonded contact cannot carry the mean load: its onset is undefined (ask shakedown_limit and steady_state)"

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` of the bonded contact at the first slip towards each corner; NaN where none slips; in space q is (K, N, 2)."""
        factor = np.array([event.load_factor if event.node is not None else np.nan for event in self.slips])
        (q0, p0), (q1, p1) = self.cycle.unscaled_reactions(self.system), self.cycle.corner_reactions(self.system)
        return q0 + (factor * q1.T).T, p0 + (factor * p1.T).T

    def to_frame(self) -> "pd.DataFrame":
        """The DataFrame of all 2K events, by corner: columns corner, event, load_factor, node (NA if it never happens), sense."""
        events = [event for pair in zip(self.slips, self.separations, strict=True) for event in pair]
        return frame({name: [getattr(event, name) for event in events] for name in OnsetEvent.__match_args__}, {"node": "Int64"})

    def _answer(self) -> Mapping[str, object]:
        slips, opens = (f"{len(nodes)} of {len(self.friction)} nodes" for nodes in (self.mean_slips, self.mean_opens))
        return {"slip": self.slip, "separation": self.separation, "mean_slips": slips, "mean_opens": opens, "reason": self.reason}

    def _repr_html_(self) -> str:
        return f"{self.to_frame().to_html(index=False)}<p>{escape(self.reason)}</p>"


@warns_of_odd_values
def onset(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike) -> Onset:
    """Find the first slip and the first separation of the bonded contact as the load grows towards each corner, `lam >= 0`.

    The load at a corner is `mean + fixed + lam * corner`, see `LoadCycle`. Closed form, node by node: slip starts where `|q| = f p`, against q (in
    space the root of a quadratic), separation where `p = 0`. Theory, eq. (6).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Bad friction, no load cycle, or a load case that the system lacks.

    Examples
    --------
    >>> import frictopt as fo
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 2.0]), "Q": ([1.0, 1.0], [0.0, 0.0])}
    >>> system = fo.ContactSystem.from_blocks([[2, -1], [-1, 2]], [[0, 0], [0, 0]], [[2, 0], [0, 2]], [0, 1], bonded)
    >>> first = fo.onset(system, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), friction=0.5)
    >>> first.slip
    OnsetEvent(corner=0, event=slip, load_factor=0.5, node=0, sense=-1)
    >>> first.to_frame()
       corner       event  load_factor  node  sense
    0       0        slip          0.5     0     -1
    1       0  separation          inf  <NA>      0
    2       1        slip          0.5     0      1
    3       1  separation          inf  <NA>      0
    """
    f = friction_coefficients(friction, checked_system(system).nodes)
    unscaled, corners = checked_cycle(cycle).unscaled_reactions(system), cycle.corner_reactions(system)
    p0 = unscaled[1]
    floor = ROUNDING * float(np.abs(p0).mean())
    slips, separations, residual = [], [], 0.0
    beginnings = (np.broadcast_to(part, one.shape) for part, one in zip(unscaled, corners, strict=True))
    for corner, (q0, p0, q1, p1) in enumerate(zip(*beginnings, *corners, strict=True)):
        slips.append(_first_slip(corner, system, (q0, f * p0), (q1, f * p1), floor))
        separations.append(_first_separation(corner, system, p0, p1, floor))
        lam = min(slips[-1].load_factor, separations[-1].load_factor)
        lam = lam if np.isfinite(lam) else 0.0
        unit = max(lam, 1.0)  # the load itself may be too large for a number
        residual = max(residual, _violation(f, q0 / unit + lam / unit * q1, p0 / unit + lam / unit * p1))
    slack = (f * unscaled[1] - lengths(*unscaled)).min(axis=0)
    return Onset(tuple(slips), tuple(separations), _below(slack, floor), _below(unscaled[1].min(axis=0), floor), residual, system, cycle, f)


def _first_slip(corner: int, system: ContactSystem, mean: tuple[Array, Array], rate: tuple[Array, Array], floor: float) -> OnsetEvent:
    """First load factor at which a shear force reaches its bound; `mean` and `rate` are shear forces and bounds."""
    (q0, g0), (q1, g1) = mean, rate
    slack = g0 - lengths(q0, g0)
    if system.tangents == 1:
        both = _reach_zero(np.array([g0 + q0, g0 - q0]), np.array([g1 + q1, g1 - q1]), floor)
        load_factor, node = _least(both.min(axis=0))
        forward = node is not None and both[0, node] <= load_factor * (1 + SIMULTANEOUS)
        return OnsetEvent(corner, "slip", load_factor, node, 0 if node is None else 1 if forward else -1)
    load_factor, node = _least(np.where(slack < -floor, 0.0, np.maximum(reach(q0, g0, q1, g1), 0.0)))
    q = np.zeros(2) if node is None else q0[node] + load_factor * q1[node]
    size = float(np.linalg.norm(q))
    return OnsetEvent(corner, "slip", load_factor, node, (0.0 - float(q[0]) / size, 0.0 - float(q[1]) / size) if size > 0 else (0.0, 0.0))


def _first_separation(corner: int, system: ContactSystem, p0: Array, p1: Array, floor: float) -> OnsetEvent:
    """First load factor at which a pressure falls to zero."""
    return OnsetEvent(corner, "separation", *_least(_reach_zero(p0, p1, floor)), 0 if system.tangents == 1 else (0.0, 0.0))


def reach(q0: Array, g0: Array, q1: Array, g1: Array) -> Array:
    """Largest lam with `|q0 + lam q1| <= g0 + lam g1`, inf where there is none; such lam form an interval, because the cone is convex.

    q0, q1 are (..., 2), the bounds g0, g1 (...,). Where no lam obeys it, the one nearest to it.
    """
    a, b, c = (q1**2).sum(axis=-1) - g1**2, (q0 * q1).sum(axis=-1) - g0 * g1, g0**2 - (q0**2).sum(axis=-1)  # a lam^2 + 2 b lam <= c
    root = np.sqrt(np.maximum(b**2 + a * c, 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        last = np.where(b > 0, c / (b + root), np.where(a > 0, (root - b) / a, np.inf))  # each without cancellation
    return np.where(g1 >= np.linalg.norm(q1, axis=-1), np.inf, last)


def _reach_zero(slack: Array, rate: Array, floor: float) -> Array:
    """First zero of `slack + lam * rate`, inf where there is none; 0 where the slack is negative."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(slack < -floor, 0.0, np.where(rate < 0, np.maximum(slack, 0.0) / -rate, np.inf))


def _least(factors: Array) -> tuple[float, int | None]:
    """The least load factor and its node, of simultaneous ones the first."""
    least = float(factors.min())
    return (least, int(np.argmax(factors <= least * (1 + SIMULTANEOUS)))) if np.isfinite(least) else (np.inf, None)


def _below(slack: Array, floor: float) -> tuple[int, ...]:
    return tuple(int(i) for i in np.flatnonzero(slack < -floor))


def _earliest(events: tuple[OnsetEvent, ...]) -> OnsetEvent:
    first = min(event.load_factor for event in events)
    return next(event for event in events if event.load_factor <= first * (1 + SIMULTANEOUS))


def _violation(f: Array, q: Array, p: Array) -> float:
    """Violation of the contact law by reactions of the contact that is closed and does not slip."""
    force = float(max(np.abs(q).max(), np.abs(p).max(), (f * np.abs(p)).max())) or 1.0
    return float(max((lengths(q, p) - f * p).max(), -p.min(), 0.0)) / force
