"""Onset of slip and separation of a contact that is bonded, or settled under the mean load, corner by corner (Flicek et al. 2015, section 3)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from html import escape

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    CONDENSATION,
    RESIDUAL,
    ROUNDING,
    SIMULTANEOUS,
    Array,
    Kept,
    Plotted,
    Table,
    bar_of,
    flag,
    frame,
    warns_of_odd_values,
)
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    checked_cycle,
    checked_system,
    friction_coefficients,
    joined,
    lengths,
    most_shear,
    parted,
    reactions,
)
from ..contact.law import reach
from ..errors import FrictoptError, NoContinuation
from .statics import unscaled_diagnosis


@dataclass(frozen=True, repr=False)
class OnsetEvent(Kept):
    """The first slip or the first separation as the load grows towards one corner.

    Attributes
    ----------
    corner, loads
        Number of the corner, from 0, and its loads as `LoadCycle.corner_names` writes them.
    event, load_factor
        "slip", "separation", or "touch" of an open node; and its load factor, inf if it never
        happens, 0 if under the mean load alone.
    node
        Index of the node, of several simultaneous ones the lowest; None if the event never happens.
    sense
        +1: the node slips along +x (q = -f p), -1: along -x (q = +f p), 0: it separates or touches,
        or the event never happens. In three dimensions the unit vector of the slip along the two
        tangents.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> fo.onset(node, fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}]), friction=0.5).separation
    OnsetEvent(corner='Q = +2', event=separation, load_factor=inf, node=None, sense=0)
    """

    corner: int
    loads: str
    event: str
    load_factor: float
    node: int | None
    sense: int | tuple[float, float]

    def _answer(self) -> Mapping[str, object]:
        return {
            "corner": repr(self.loads),
            **{
                name: value for name, value in vars(self).items() if name not in ("corner", "loads")
            },
        }


@dataclass(frozen=True, repr=False)
class Onset(Kept, Plotted):
    """First slip and first separation of the bonded contact under `mean + fixed + load_factor * corner`, for each corner of a load cycle.

    Where the mean load would pull at bonded nodes, of the contact once the mean load has settled.

    Attributes
    ----------
    slips, separations, touches
        First slip and first separation under each of the K corners; and the first touch of an open
        node.
    mean_slips, mean_opens
        Indices of the nodes at which the mean load alone, or with what is fixed at some corner,
        already exceeds the friction bound, or pulls. If there are any, the bonded contact cannot
        carry it; without a `state` its onset is undefined then.
    residual
        Largest violation of the contact law at the first event under each corner, in units of the
        largest nodal force there. It exceeds rounding only if the bonded contact violates the law
        under the mean load alone.
    system, cycle
        The contact and its load cycle.
    friction
        (N,) coefficients of friction.
    state
        Where it begins: the state once the mean load has come, from no slip, where the mean load
        pulls at bonded nodes. None: at the bonded contact.

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
    touches: tuple[OnsetEvent, ...] = ()
    state: ContactState | None = field(default=None, compare=False)
    _loads: tuple[Array, ...] = field(default=(), compare=False)

    @property
    def slip(self) -> OnsetEvent:
        """The first slip under any corner; of simultaneous ones that of the first corner."""
        return _earliest(self.slips)

    @property
    def separation(self) -> OnsetEvent:
        """The first separation under any corner; of simultaneous ones that of the first corner."""
        return _earliest(self.separations)

    @property
    def touch(self) -> OnsetEvent | None:
        """The first touch of an open node under any corner; None where no node is open."""
        return _earliest(self.touches) if self.touches else None

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
        if self.state is not None:
            return f"{text}; this is the onset of the contact once the mean load has settled, with {int(self.state.open.sum())} nodes open"
        return f"{text}; the bonded contact cannot carry the mean load: its onset is undefined and given as 0 (ask shakedown_limit and steady_state)"

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the first slip towards each corner; NaN where none slips; in space q is (K, N, 2)."""
        factor = np.array(
            [event.load_factor if event.node is not None else np.nan for event in self.slips]
        )
        q0, p0, q1, p1 = self._loads
        return q0 + (factor * q1.T).T, p0 + (factor * p1.T).T

    def to_frame(self) -> Table:
        """The DataFrame of all events, by corner: columns corner and its loads, event, load_factor, node (NA if it never happens), sense."""
        kinds = self.slips, self.separations, *([self.touches] if self.touches else [])
        events = [event for corner in zip(*kinds, strict=True) for event in corner]
        return frame(
            {name: [getattr(event, name) for event in events] for name in OnsetEvent.__match_args__}
        ).astype({"node": "Int64"})

    def _answer(self) -> Mapping[str, object]:
        ruled = (
            {}
            if self.mean_admissible
            else {"mean_slips": self.mean_slips, "mean_opens": self.mean_opens}
        )
        counts = {
            name: f"{len(nodes)} of {len(self.friction)} nodes" for name, nodes in ruled.items()
        }
        touch = {} if self.touch is None else {"touch": self.touch}
        return {
            "slip": self.slip,
            "separation": self.separation,
            **touch,
            **counts,
            "reason": self.reason,
        }

    def _repr_html_(self) -> str:
        return f"{self.to_frame().to_html(index=False)}<p>{escape(self.reason)}</p>"


def onset_from(
    system: ContactSystem, cycle: LoadCycle, friction: Array, state: ContactState | None = None
) -> Onset:
    """The onset of the bonded contact, or of one in a state under the mean load; NoContinuation if nothing holds its open nodes. Friction is (N,)."""
    parts, f = _rates(system, cycle, state), friction
    (q0, p0, _), corners = parts[:3], parts[3:]
    force = float(np.abs(p0).mean())
    floor = (
        ROUNDING if state is None else RESIDUAL
    ) * force  # a settled state has nodes at their bounds
    events: tuple[list[OnsetEvent], ...] = [], [], []
    residual, still = 0.0, 0 if system.tangents == 1 else (0.0, 0.0)
    beginnings = (
        np.broadcast_to(part, one.shape) for part, one in zip(parts[:3], corners, strict=True)
    )
    for corner, (q, p, w, q1, p1, w1) in enumerate(zip(*beginnings, *corners, strict=True)):
        called = corner, cycle.corner_names[corner]
        slip = _first_slip(called, system.stretch, (q, f * p), (q1, f * p1), floor)
        if system.capped:
            has = np.flatnonzero(np.isfinite(system.shear_strength))
            bounds = system.shear_strength[has], np.zeros(len(has))
            off = _first_slip(
                called, system.stretch[has], (q[has], bounds[0]), (q1[has], bounds[1]), floor
            )
            slip = (
                slip
                if off.node is None or off.load_factor >= slip.load_factor
                else replace(off, node=int(has[off.node]))
            )
        events[0].append(slip)
        events[1].append(
            OnsetEvent(*called, "separation", *_least(_reach_zero(p, p1, floor)), still)
        )
        if state is not None and state.open.any():
            events[2].append(
                OnsetEvent(
                    *called,
                    "touch",
                    *_least(_reach_zero(w, w1, floor / system.stiffness_scale)),
                    still,
                )
            )
        lam = min(part[-1].load_factor for part in events if part)
        lam = lam if np.isfinite(lam) else 0.0
        unit = max(lam, 1.0)  # the load itself may be too large for a number
        q, p = q / unit + lam / unit * q1, p / unit + lam / unit * p1
        largest = float(max(np.abs(q).max(), np.abs(p).max(), (f * np.abs(p)).max())) or 1.0
        residual = max(
            residual,
            float(max((lengths(q, p) - most_shear(system, f, p)).max(), -p.min())) / largest,
        )
    mean_q, mean_p = cycle.unscaled_reactions(system)
    small, slack = (
        ROUNDING * float(np.abs(mean_p).mean()),
        (most_shear(system, f, mean_p) - lengths(mean_q, mean_p)).min(axis=0),
    )
    slipping, opening = (
        tuple(np.flatnonzero(least < -small).tolist()) for least in (slack, mean_p.min(axis=0))
    )
    slips, separations, touches = map(tuple, events)
    return Onset(
        slips,
        separations,
        slipping,
        opening,
        residual,
        system,
        cycle,
        f,
        touches,
        state,
        (q0, p0, *corners[:2]),
    )


def _rates(
    system: ContactSystem, cycle: LoadCycle, state: ContactState | None
) -> tuple[Array, ...]:
    """Shear forces, normal forces and gaps (K, N) at load factor 0, one row where all corners have the same, and what a load factor of 1 adds.

    Closed nodes stick, and open ones follow the load without force. Gaps of closed nodes are inf:
    they do not touch.
    """
    begin, corners = cycle.unscaled_reactions(system), cycle.corner_reactions(system)
    if state is None:
        return *begin, np.full_like(begin[1], np.inf), *corners, np.zeros_like(corners[1])
    axes, n = system.tangents + 1, system.nodes
    out, S = np.tile(state.open, axes), system.S
    loads = [reactions(system, part) for part in (cycle.unscaled, cycle.corners)]
    loads[0] = loads[0] + S @ joined(state.slip, state.gap - system.gap)
    found, still = list[Array](), np.zeros(n)
    for load, apart in zip(loads, (np.where(state.open, state.gap, np.inf), still), strict=True):
        moved = np.zeros_like(load)
        moved[:, out] = -np.linalg.lstsq(S[np.ix_(out, out)], load[:, out].T, rcond=CONDENSATION)[
            0
        ].T
        r = load + moved @ S
        if np.abs(r[:, out]).max(initial=0.0) > RESIDUAL * np.abs(load).max():
            raise NoContinuation(
                "onset: nothing holds the open nodes against the load; hold the bodies by supports, or press them"
            )
        r[:, out] = 0.0
        found += [*parted(r, axes), apart + moved[:, -n:]]
    return tuple(found)


def _first_slip(
    called: tuple[int, str],
    stretch: Array,
    mean: tuple[Array, Array],
    rate: tuple[Array, Array],
    floor: float,
) -> OnsetEvent:
    """First load factor at which a shear force reaches its bound; `mean` and `rate` are shear forces and bounds."""
    (q0, g0), (q1, g1) = mean, rate
    slack = g0 - lengths(q0, g0)
    if stretch.ndim == 1:
        both = _reach_zero(np.array([g0 + q0, g0 - q0]), np.array([g1 + q1, g1 - q1]), floor)
        load_factor, node = _least(both.min(axis=0))
        forward = node is not None and both[0, node] <= load_factor * (1 + SIMULTANEOUS)
        return OnsetEvent(
            *called, "slip", load_factor, node, 0 if node is None else 1 if forward else -1
        )
    load_factor, node = _least(
        np.where(slack < -floor, 0.0, np.maximum(reach(q0, g0, q1, g1), 0.0))
    )
    q = (
        np.zeros(2) if node is None else (q0[node] + load_factor * q1[node]) / stretch[node]
    )  # slips go back so
    size = float(np.linalg.norm(q))
    return OnsetEvent(
        *called,
        "slip",
        load_factor,
        node,
        (0.0 - float(q[0]) / size, 0.0 - float(q[1]) / size) if size > 0 else (0.0, 0.0),
    )


def _reach_zero(slack: Array, rate: Array, floor: float) -> Array:
    """First zero of `slack + lam * rate`, inf where there is none; 0 where the slack is negative."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(
            slack < -floor, 0.0, np.where(rate < 0, np.maximum(slack, 0.0) / -rate, np.inf)
        )


def _least(factors: Array) -> tuple[float, int | None]:
    """The least load factor and its node, of simultaneous ones the first."""
    least = float(factors.min())
    return (
        (least, int(np.argmax(factors <= least * (1 + SIMULTANEOUS))))
        if np.isfinite(least)
        else (np.inf, None)
    )


def _earliest(events: tuple[OnsetEvent, ...]) -> OnsetEvent:
    first = min(event.load_factor for event in events)
    return next(event for event in events if event.load_factor <= first * (1 + SIMULTANEOUS))


@warns_of_odd_values
def onset(
    system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, *, progress: bool = True
) -> Onset:
    """Find the first slip and the first separation of the bonded contact as the load grows towards each corner, `lam >= 0`.

    Where the mean load would pull at nodes of the bonded contact, it is that of the contact once
    the mean load has settled, from no slip: closed nodes stick, open ones follow. The load at a
    corner is `mean + fixed + lam * corner`, see `LoadCycle`. Closed form, node by node: slip starts
    where `|q| = f p`, or where it is the shear strength, against q (in space the root of a
    quadratic), separation where `p = 0`, touch where a gap is zero. Theory, eq. (6).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    progress
        Whether to show after two seconds that the mean load is still settling.

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
    OnsetEvent(corner='Q = +1', event=slip, load_factor=0.5, node=0, sense=-1)
    >>> first.to_frame()
       corner   loads       event  load_factor  node  sense
    0       0  Q = +1        slip          0.5     0     -1
    1       0  Q = +1  separation          inf  <NA>      0
    2       1  Q = -1        slip          0.5     0      1
    3       1  Q = -1  separation          inf  <NA>      0
    """
    f, shown = (
        np.array(friction_coefficients(friction, checked_system(system).nodes)),
        flag("progress", progress),
    )
    first = onset_from(system, checked_cycle(cycle), f)
    if not first.mean_opens:
        return first
    from .march import mean_state  # here, because a closed contact needs none

    try:
        with bar_of(shown, "onset: the mean load settles"):
            return onset_from(system, cycle, f, mean_state(system, cycle, f))
    except FrictoptError:
        return first
