"""Contacts of one and two nodes: shakedown and guaranteed limit, the friction of wedging, and loads out of phase."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from math import acos, cos, hypot, pi, radians, sin, tan

import numpy as np
import numpy.typing as npt

import frictopt as fo

from ..guaranteed import PAIR_LOADS, pair
from .case import Array, Case, opposed

# Friction of the node under loads out of phase.
_FRICTION = 0.5
# Amplitude of the normal load of this node, relative to the shear load and to the mean pressure.
_NORMAL = 0.8
# Load factor at which the work of this node is computed.
_LOAD = 1.2


@dataclass(frozen=True)
class Parameters:
    """Parameters of the cases."""

    # Frictions of the two nodes.
    frictions: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
    # Angles of the tilted bar in degrees.
    angles: tuple[float, ...] = (30.0, 45.0, 60.0, 75.0)
    # Phases in degrees.
    phases: tuple[float, ...] = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0)
    # Number of corners of the polygon that approximates an ellipse.
    points: int = 128
    bisections: int = 26


def cases(parameters: Parameters) -> Iterator[Case]:
    """All cases of nodes."""
    yield from _two_nodes(parameters)
    yield _tilted_bar(parameters)
    yield from _two_wedged(parameters)
    yield from _out_of_phase(parameters)


def _two_nodes(parameters: Parameters) -> Iterator[Case]:
    contact = pair()
    lower = [fo.guaranteed_limit(contact, PAIR_LOADS, f) for f in parameters.frictions]
    upper = [fo.shakedown_limit(contact, PAIR_LOADS, f) for f in parameters.frictions]
    source, how, over = (
        "Ahn, Bertocchi & Barber 2008",
        "their rule, two nodes of ours; rounding",
        "f",
    )
    found = (
        (
            "guaranteed limit lambda_1",
            [limit.load_factor for limit in lower],
            max(limit.residual for limit in lower),
        ),
        (
            "shakedown limit lambda_2",
            [limit.load_factor for limit in upper],
            max(limit.residual for limit in upper),
        ),
    )
    for number, (name, ours, residual) in enumerate(found):
        yield Case(
            source,
            f"{name} of two nodes",
            over,
            how,
            parameters.frictions,
            partial(_meeting, contact, number),
            ours,
            residual,
        )


def _meeting(contact: fo.ContactSystem, number: int, f: float) -> float:
    return two_node_limits(contact, PAIR_LOADS, f)[number]


def two_node_limits(
    contact: fo.ContactSystem, cycle: fo.LoadCycle, f: float
) -> tuple[float, float]:
    """Guaranteed and shakedown limit of two closed nodes, by the friction lines in the plane of their slips.

    Three of the four lines meet at a limit (Ahn, Bertocchi & Barber 2008). The slip of a node lies
    between two lines, `n . v = a + lam b`. As the load grows, the two lines approach each other.
    lambda_2 is the least load factor at which both lines of a node and the facing line of the other
    node meet in a point. lambda_1 is the least load factor at which any three lines meet. The rule
    holds if friction is so low that all four meetings have positive load factors.
    """
    q0, p0 = contact.reaction(cycle.mean)
    q1, p1 = contact.reaction(cycle.corners[1])
    forward = np.column_stack([contact.A + f * contact.B, -(q0 + f * p0), np.abs(q1 + f * p1)])
    backward = np.column_stack([contact.A - f * contact.B, f * p0 - q0, -np.abs(q1 - f * p1)])
    meetings: list[list[float]] = []
    for one, other in ((0, 1), (1, 0)):
        lines = [
            np.array([forward[one], backward[one], third])
            for third in (forward[other], backward[other])
        ]
        meetings.append(
            [
                float(-np.linalg.det(rows[:, [0, 1, 2]]) / np.linalg.det(rows[:, [0, 1, 3]]))
                for rows in lines
            ]
        )
    return min(map(min, meetings)), min(map(max, meetings))


def _tilted_bar(parameters: Parameters) -> Case:
    """A bar of stiffness k at an angle to the face on which it is pressed.

    A = k cos^2 and B = k sin cos, so A / B is the cotangent of the angle.
    """
    found = []
    for angle in parameters.angles:
        c, s = cos(radians(angle)), sin(radians(angle))
        bar = fo.ContactSystem.from_blocks(
            [[c * c]], [[s * c]], [[s * s]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
        )
        found.append(
            _first_infinite(bar, opposed({"P": 1.0}, {"Q": 1.0}), [False], parameters.bisections)
        )
    how = "bisection: the friction from which the shakedown limit is infinite"
    return Case(
        "Klarbring 1990, 1999",
        "critical friction A / B of a tilted bar",
        "angle of the bar, degrees",
        how,
        parameters.angles,
        lambda angle: 1 / tan(radians(angle)),
        found,
        0.0,
    )


def _two_wedged(parameters: Parameters) -> Iterator[Case]:
    quantity, how = (
        "friction from which two nodes may stay wedged without load",
        "the same with two nodes",
    )
    found = (
        (
            "Kim, Jang & Barber 2019",
            "both closed",
            least_wedged,
            np.array([False, False]),
            f"{how} closed; theirs: the least over directions of slip",
        ),
        (
            "Kim & Jang 2020",
            "one open",
            one_wedged,
            np.array([False, True]),
            f"{how}, one open; theirs: A / B of the other with what is open eliminated",
        ),
    )
    for source, name, theirs, apart, told in found:
        yield Case(
            source,
            f"{quantity}, {name}",
            "",
            told,
            (np.nan,),
            partial(_of_pair, theirs),
            (_first_infinite(pair(), PAIR_LOADS, apart, parameters.bisections),),
            0.0,
        )


def _of_pair(friction: Callable[[fo.ContactSystem], float], _: float) -> float:
    return friction(pair())


def one_wedged(contact: fo.ContactSystem) -> float:
    """Friction with which the first of two nodes wedges while the second node is open.

    This friction is the ratio of shear to pressure at the first node when this node slips and the
    second node is free.
    """
    # Slips come before gaps.
    kept, free = [0, 2], [1, 3]
    stiffness = np.block([[contact.A, contact.B.T], [contact.B, contact.C]])
    eliminated = np.linalg.solve(stiffness[np.ix_(free, free)], stiffness[np.ix_(free, kept)])
    sheared, pressed = (stiffness[np.ix_(kept, kept)] - stiffness[np.ix_(kept, free)] @ eliminated)[
        :, 0
    ]
    return float(abs(sheared / pressed))


def least_wedged(contact: fo.ContactSystem) -> float:
    """Least friction with which some slip of two nodes wedges.

    This friction is the largest `|A v| / (B v)` of both nodes, made as small as possible by the
    direction of the slip v. Both `B v` must be above 0.
    """

    def needed(angles: Array) -> Array:
        slip = np.array([np.cos(angles), np.sin(angles)])
        pressure = contact.B @ slip
        return np.asarray(
            np.where(
                pressure > 0,
                np.abs(contact.A @ slip) / np.where(pressure > 0, pressure, 1.0),
                np.inf,
            ).max(axis=0)
        )

    angles = np.linspace(-pi, pi, 2001)
    # Each range is a thousandth of the range before.
    for _ in range(5):
        at, step = angles[needed(angles).argmin()], angles[1] - angles[0]
        angles = np.linspace(at - step, at + step, 2001)
    return float(needed(angles).min())


def _first_infinite(
    contact: fo.ContactSystem, cycle: fo.LoadCycle, apart: npt.ArrayLike, bisections: int
) -> float:
    """The least friction with which the shakedown limit, with these nodes open, is infinite.

    A slip that wedges holds any load, if it is large enough.
    """
    low, high = 0.0, 4.0
    for _ in range(bisections):
        middle = (low + high) / 2
        low, high = (
            (low, middle)
            if np.isinf(fo.shakedown_limit(contact, cycle, middle, open_nodes=apart).load_factor)
            else (middle, high)
        )
    return (low + high) / 2


def _out_of_phase(parameters: Parameters) -> Iterator[Case]:
    loads = {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0]), "N": ([0.0], [1.0])}
    node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
    limits, steady = [], []
    for phase in parameters.phases:
        cycle = fo.LoadCycle.harmonic(
            {"Q": 1.0, "N": (_NORMAL, phase)}, mean={"P": 1.0}, points=parameters.points
        )
        limits.append(fo.shakedown_limit(node, cycle, _FRICTION))
        steady.append(fo.steady_state(node, cycle, _FRICTION, _LOAD))
    source, over = "Jang & Barber 2011", "phase of the normal load, degrees"
    how = f"one node, integrated by hand; {parameters.points} corners in place of an ellipse"
    theirs: tuple[tuple[str, Callable[[float], float], list[float], float], ...] = (
        (
            "both limits of a node",
            limit_at_phase,
            [limit.load_factor for limit in limits],
            max(limit.residual for limit in limits),
        ),
        (
            "work of friction per cycle of a node, A W / P^2",
            work_at_phase,
            [one.dissipation for one in steady],
            max(one.residual for one in steady),
        ),
    )
    for quantity, of, ours, residual in theirs:
        yield Case(
            source,
            f"{quantity}, normal load out of phase",
            over,
            how,
            parameters.phases,
            of,
            ours,
            residual,
        )


def _sizes(phase: float) -> tuple[float, float, float, float]:
    """Amplitudes and phases of `f N + Q` and of `f N - Q`, for Q = 1 with phase 0."""
    x, y = _FRICTION * _NORMAL * cos(radians(phase)), _FRICTION * _NORMAL * sin(radians(phase))
    return (
        hypot(x + 1, y),
        hypot(x - 1, y),
        float(np.arctan2(y, x + 1)),
        float(np.arctan2(y, x - 1)),
    )


def limit_at_phase(phase: float) -> float:
    """Load factor at which the two bounds of the slip meet.

    This load factor is `2 f P` divided by the sum of the amplitudes of `f N + Q` and `f N - Q`.
    """
    plus, minus, *_ = _sizes(phase)
    return 2 * _FRICTION / (plus + minus)


def work_at_phase(phase: float) -> float:
    """Work of friction per cycle of one uncoupled node, P = A = 1, at the load factor `_LOAD`.

    While the node slips forward, `v = lam R cos s - f P`, up to `v = lam R - f P`. R and s are the
    amplitude and the phase of `-(f N + Q)`. Backward slip is analogous. Each passage begins at the
    slip at which the other passage ends. The work of a passage is the integral of `f p` over the
    slip, with the pressure `P + lam N cos (s + delta)`.
    """
    f, lam = _FRICTION, _LOAD
    plus, minus, at_plus, at_minus = _sizes(phase)
    travel = lam * (plus + minus) - 2 * f
    if travel <= 0:
        return 0.0
    work = 0.0
    for size, angle in ((plus, at_plus), (minus, at_minus)):
        # Phase of N, relative to the end of the passage.
        delta = radians(phase) - angle + pi
        start = -acos(1 - travel / (lam * size))
        way = lam * size * (1 - cos(start))
        turning = (cos(delta) - cos(2 * start + delta)) / 4 - start * sin(delta) / 2
        work += f * (way + lam**2 * _NORMAL * size * turning)
    return work
