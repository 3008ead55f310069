"""Onset of slip and separation, corner by corner (Flicek et al. 2015, section 3).

The onset is computed for the bonded contact. If the mean load pulls at nodes of the bonded contact,
the onset is computed for the contact after the mean load has settled. Until the first event all
forces and gaps are linear in the load factor, and each event is a root in closed form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from html import escape
from typing import NamedTuple

import numpy as np

from ..base import (
    CONDENSATION,
    RESIDUAL,
    ROUNDING,
    SIMULTANEOUS,
    Array,
    Kept,
    PerNode,
    Plotted,
    Table,
    flag,
    frame,
    number_of,
    progress_bar,
    warns_of_odd_values,
)
from ..contact import (
    ContactState,
    ContactSystem,
    LoadCycle,
    checked_cycle,
    contact_law,
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


class LinearForces(NamedTuple):
    """Shear forces, normal forces and gaps, (K, N) or (N,); in space the shear has two columns.

    The gaps of closed nodes are inf, so that only open nodes can touch.
    """

    q: Array
    p: Array
    gap: Array


def linear_forces(
    system: ContactSystem, cycle: LoadCycle, state: ContactState | None
) -> tuple[LinearForces, LinearForces]:
    """Forces at load factor 0, and what a load factor of 1 adds, with a row for each corner.

    The forces at load factor 0 have one row if they are the same for all corners.
    """
    if state is None:
        q, p = cycle.unscaled_reactions(system)
        q_rate, p_rate = cycle.corner_reactions(system)
        start = LinearForces(q, p, np.full_like(p, np.inf))
        return start, LinearForces(q_rate, p_rate, np.zeros_like(p_rate))
    stress = system.S @ joined(state.slip, state.gap - system.gap)
    gap = np.where(state.open, state.gap, np.inf)
    start = _settled(system, state, reactions(system, cycle.unscaled) + stress, gap)
    no_gap = np.zeros(system.nodes)
    return start, _settled(system, state, reactions(system, cycle.corners), no_gap)


def _settled(system: ContactSystem, state: ContactState, load: Array, gap: Array) -> LinearForces:
    """Forces under bonded reactions (K, M) if closed nodes stick and open nodes have no force."""
    S = system.S
    opened = np.tile(state.open, system.tangents + 1)
    moved = np.zeros_like(load)
    block = S[np.ix_(opened, opened)]
    moved[:, opened] = -np.linalg.lstsq(block, load[:, opened].T, rcond=CONDENSATION)[0].T
    r = load + moved @ S
    if np.abs(r[:, opened]).max(initial=0.0) > RESIDUAL * np.abs(load).max():
        raise NoContinuation(
            "onset: nothing holds the open nodes against the load; hold the bodies by supports, "
            "or press them"
        )
    r[:, opened] = 0.0
    q, p = parted(r, system.tangents + 1)
    return LinearForces(q, p, gap + moved[:, -system.nodes :])


def first_zero(slack: Array, rate: Array, floor: float) -> Array:
    """First zero of `slack + lam * rate`; inf if there is none, 0 if the slack is negative."""
    with np.errstate(divide="ignore", invalid="ignore"):
        zero = np.where(rate < 0, np.maximum(slack, 0.0) / -rate, np.inf)
    return np.where(slack < -floor, 0.0, zero)


@dataclass(frozen=True, repr=False)
class OnsetEvent(Kept):
    """The first slip or the first separation as the load grows towards one corner.

    Attributes
    ----------
    corner, loads
        Number of the corner, from 0, and its loads as `LoadCycle.corner_names` writes them.
    event, load_factor
        The event: "slip", "separation", or "touch" if an open node touches. The load factor is inf
        if the event never happens, and 0 if it happens under the mean load.
    node
        Index of the node; the lowest index if several events are simultaneous; None if the event
        never happens.
    sense
        +1: the node slips along +x (q = -f p), -1: along -x (q = +f p), 0: it separates or touches,
        or the event never happens. In space it is the unit vector of the slip along the two
        tangents.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
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
            "event": self.event,
            "load_factor": self.load_factor,
            "node": self.node,
            "sense": self.sense,
        }


@dataclass(frozen=True, repr=False)
class Onset(Kept, Plotted):
    """First slip and first separation of the bonded contact, for each corner of a load cycle.

    The load is `mean + fixed + load_factor * corner`. If the mean load pulls at bonded nodes, the
    events refer to the contact after the mean load has settled.

    Attributes
    ----------
    slips, separations, touches
        First slip, first separation and, if nodes are open, first touch of an open node, under each
        of the K corners.
    mean_slips, mean_opens
        Indices of the nodes at which the mean load, alone or with the fixed loads of some corner,
        exceeds the friction bound (`mean_slips`), and at which it pulls (`mean_opens`). If there
        are any, the bonded contact cannot carry the mean load, and the onset is undefined unless
        there is a `state`.
    residual
        Largest violation of the contact law at the first event under each corner, in units of the
        largest nodal force there. This residual exceeds rounding only if the bonded contact
        violates the law under the mean load.
    system, cycle
        The contact and its load cycle.
    friction
        (N,) coefficients of friction.
    state
        State before the load grows: if the mean load pulls at bonded nodes, the state after the
        mean load has settled, from no slip. None: the bonded contact.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
    >>> first = fo.onset(node, fo.LoadCycle({"P": 1.0}, [{"Q": 2.0}, {"Q": -1.0}]), friction=0.5)
    >>> [event.load_factor for event in first.slips], first.slip.load_factor, first.mean_admissible
    ([0.25, 0.5], 0.25, True)
    """

    _shown_names = ("slip", "separation", "touch", "reason")
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
        """First slip under any corner; of simultaneous slips, the slip under the first corner."""
        return _earliest(self.slips)

    @property
    def separation(self) -> OnsetEvent:
        """First separation under any corner; of several at once, the first corner's."""
        return _earliest(self.separations)

    @property
    def touch(self) -> OnsetEvent | None:
        """The first touch of an open node under any corner; None if no node is open."""
        return _earliest(self.touches) if self.touches else None

    @property
    def mean_admissible(self) -> bool:
        """Whether the bonded contact satisfies the law at every node under the mean load."""
        return not (self.mean_slips or self.mean_opens)

    @property
    def reason(self) -> str:
        """Diagnosis of the bonded contact under the mean load, as a sentence.

        If the bonded contact cannot carry the mean load, the sentence names a remedy.
        """
        diagnosis = unscaled_diagnosis(self.system, self.cycle, self.friction)
        if self.mean_admissible:
            return diagnosis
        if self.state is None:
            return (
                f"{diagnosis}; the bonded contact cannot carry the mean load: its onset is "
                "undefined and reported as 0 (use shakedown_limit and steady_state)"
            )
        nodes = number_of(int(self.state.open.sum()), "node")
        return (
            f"{diagnosis}; this is the onset of the contact once the mean load has settled, "
            f"with {nodes} open"
        )

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the first slip towards each corner; in space q is (K, N, 2).

        Both are NaN if no node slips towards the corner.
        """
        factor = np.array([event.load_factor for event in self.slips])
        factor[[event.node is None for event in self.slips]] = np.nan
        q, p, q_rate, p_rate = self._loads
        return q + (factor * q_rate.T).T, p + (factor * p_rate.T).T

    def to_frame(self) -> Table:
        """The DataFrame of all events, by corner.

        Columns are corner, loads, event, load_factor, node (NA if it never happens), sense, and
        deck_node (if known).
        """
        kinds = [kind for kind in (self.slips, self.separations, self.touches) if kind]
        events = [event for corner in zip(*kinds, strict=True) for event in corner]
        names = OnsetEvent.__match_args__
        columns: dict[str, object] = {n: [getattr(each, n) for each in events] for n in names}
        table = frame(columns).astype({"node": "Int64"})
        if (deck := self.system.deck_node) is not None:
            table["deck_node"] = table["node"].map(dict(enumerate(deck.tolist()))).astype("Int64")
        return table

    def _repr_html_(self) -> str:
        return f"{self.to_frame().to_html(index=False)}<p>{escape(self.reason)}</p>"


@warns_of_odd_values
def onset(
    system: ContactSystem, cycle: LoadCycle, friction: PerNode, *, progress: bool = True
) -> Onset:
    """Find the first slip and separation of the bonded contact as the load grows to each corner.

    The load is `mean + fixed + lam * corner` with `lam >= 0`, see `LoadCycle`. If the mean load
    pulls at nodes of the bonded contact, the onset refers to the contact after the mean load has
    settled, from no slip: closed nodes stick, open nodes follow the load.

    The events have closed forms, node by node. Slip starts, against q, if `|q|` reaches `f p` or
    the shear strength; in space this is the root of a quadratic equation. A closed node separates
    at `p = 0`, and an open node touches when its gap is zero. Theory, eq. (6).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    progress
        Whether to show a bar after two seconds, while the mean load settles.

    Returns
    -------
    Onset
        The load factors of the first slip and of the first separation, for each corner.

    Raises
    ------
    ModelError
        Bad friction, no load cycle, or a load case that the system lacks.

    Examples
    --------
    >>> import frictopt as fo
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 2.0]), "Q": ([1.0, 1.0], [0.0, 0.0])}
    >>> A, B, C = [[2, -1], [-1, 2]], [[0, 0], [0, 0]], [[2, 0], [0, 2]]
    >>> system = fo.ContactSystem.from_blocks(A, B, C, [0, 1], bonded)
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
    coefficients = friction_coefficients(friction, system)
    show = flag("progress", progress)
    bonded = onset_from(system, checked_cycle(cycle), coefficients)
    if not bonded.mean_opens:
        return bonded
    # Imported here, because a closed contact needs no transient.
    from .march import mean_state

    try:
        with progress_bar(show, "onset: the mean load settles"):
            state = mean_state(system, cycle, coefficients)
            return onset_from(system, cycle, coefficients, state)
    except FrictoptError:
        return bonded


@dataclass(frozen=True)
class _Approach:
    """The forces towards one corner, `start + load_factor * rate`, in a contact with friction (N,).

    A slack (force) below `-floor` violates the law already at the start.
    """

    system: ContactSystem
    friction: Array
    corner: tuple[int, str]
    start: LinearForces
    rate: LinearForces
    floor: float


def onset_from(
    system: ContactSystem, cycle: LoadCycle, friction: Array, state: ContactState | None = None
) -> Onset:
    """The onset of the bonded contact, or of a contact in a state under the mean load.

    Friction is (N,). NoContinuation if nothing holds the open nodes of the state.
    """
    starts, rates = linear_forces(system, cycle, state)
    # A settled state has nodes at their bounds, up to the residual of its transient.
    tolerance = ROUNDING if state is None else RESIDUAL
    floor = tolerance * float(np.abs(starts.p).mean())
    slips = []
    separations = []
    touches = []
    residual = 0.0
    for number, name in enumerate(cycle.corner_names):
        rate = LinearForces(*(part[number] for part in rates))
        # The start has one row if it is the same for all corners.
        start = LinearForces(*(part[number if len(part) > 1 else 0] for part in starts))
        approach = _Approach(system, friction, (number, name), start, rate, floor)
        events = [_slip(approach), _at_zero(approach, "separation", start.p, rate.p, floor)]
        if state is not None and state.open.any():
            length = floor / system.stiffness_scale
            events.append(_at_zero(approach, "touch", start.gap, rate.gap, length))
            touches.append(events[2])
        slips.append(events[0])
        separations.append(events[1])
        first = min(event.load_factor for event in events)
        residual = max(residual, _residual(approach, first if np.isfinite(first) else 0.0))

    mean_q, mean_p = cycle.unscaled_reactions(system)
    rounding = ROUNDING * float(np.abs(mean_p).mean())
    slack = (most_shear(system, friction, mean_p) - lengths(mean_q, mean_p)).min(axis=0)
    return Onset(
        slips=tuple(slips),
        separations=tuple(separations),
        touches=tuple(touches),
        mean_slips=tuple(np.flatnonzero(slack < -rounding).tolist()),
        mean_opens=tuple(np.flatnonzero(mean_p.min(axis=0) < -rounding).tolist()),
        residual=residual,
        system=system,
        cycle=cycle,
        friction=friction,
        state=state,
        _loads=(starts.q, starts.p, rates.q, rates.p),
    )


def _slip(approach: _Approach) -> OnsetEvent:
    """The first slip: the first shear force that reaches a term of the bound."""
    system = approach.system
    in_plane = system.tangents == 1
    q, p, _ = approach.start
    q_rate, p_rate, _ = approach.rate
    # In the plane a row for slip along +x, and a row for slip against +x.
    factors = np.full((2 if in_plane else 1, system.nodes), np.inf)
    for term in contact_law(system, approach.friction).terms:
        nodes = term.nodes
        bound = term.slope[nodes] * p[nodes] + term.constant[nodes]
        bound_rate = term.slope[nodes] * p_rate[nodes]
        of_term = _at_bound(q[nodes], bound, q_rate[nodes], bound_rate, approach.floor)
        factors[:, nodes] = np.minimum(factors[:, nodes], of_term)
    load_factor, node = _least(factors.min(axis=0))
    sense: int | tuple[float, float] = 0 if in_plane else (0.0, 0.0)
    if node is not None and in_plane:
        sense = 1 if factors[0, node] <= load_factor * (1 + SIMULTANEOUS) else -1
    elif node is not None:
        # Slip is opposite to the force. The division undoes the stretch of the tangents.
        force = (q[node] + load_factor * q_rate[node]) / system.stretch[node]
        size = float(np.linalg.norm(force))
        if size > 0:
            # If the component is 0.0, the difference is 0.0, while its negative would be -0.0.
            sense = 0.0 - float(force[0]) / size, 0.0 - float(force[1]) / size
    return OnsetEvent(*approach.corner, "slip", load_factor, node, sense)


def _at_bound(q: Array, bound: Array, q_rate: Array, bound_rate: Array, floor: float) -> Array:
    """Load factors (2, N), in space (N,), at which the shear forces reach their bounds.

    `bound` are the bounds at load factor 0, and `bound_rate` their change per unit of load factor.
    """
    if q.ndim == 1:
        slacks = np.array([bound + q, bound - q])
        return first_zero(slacks, np.array([bound_rate + q_rate, bound_rate - q_rate]), floor)
    exceeds = bound - lengths(q, bound) < -floor
    return np.where(exceeds, 0.0, np.maximum(reach(q, bound, q_rate, bound_rate), 0.0))


def _at_zero(
    approach: _Approach, event: str, slack: Array, rate: Array, floor: float
) -> OnsetEvent:
    """The separation or the touch: the first pressure or gap that falls to zero."""
    sense = 0 if approach.system.tangents == 1 else (0.0, 0.0)
    return OnsetEvent(*approach.corner, event, *_least(first_zero(slack, rate, floor)), sense)


def _residual(approach: _Approach, load_factor: float) -> float:
    """Largest violation of the law at a load factor, relative to the largest nodal force."""
    system = approach.system
    f = approach.friction
    # Forces are divided by a large load factor, or they might be too large for a number.
    unit = max(load_factor, 1.0)
    q = approach.start.q / unit + load_factor / unit * approach.rate.q
    p = approach.start.p / unit + load_factor / unit * approach.rate.p
    largest = float(max(np.abs(q).max(), np.abs(p).max(), (f * np.abs(p)).max())) or 1.0
    excess = (lengths(q, p) - most_shear(system, f, p)).max()
    return float(max(excess, -p.min())) / largest


def _least(factors: Array) -> tuple[float, int | None]:
    """The least load factor and the first node that has it; (inf, None) if all are inf."""
    least = float(factors.min())
    if not np.isfinite(least):
        return np.inf, None
    return least, int(np.argmax(factors <= least * (1 + SIMULTANEOUS)))


def _earliest(events: tuple[OnsetEvent, ...]) -> OnsetEvent:
    """The first event; of several at once, the event of the first corner."""
    first = min(event.load_factor for event in events)
    return next(event for event in events if event.load_factor <= first * (1 + SIMULTANEOUS))
