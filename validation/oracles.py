"""Independent answers for comparison: plain linear programs, enumeration of all statuses, and the contact law in its own code.

Nothing here uses the package's own methods, only the matrices, the bonded reactions and the numbers
of an answer.
"""

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linprog

import frictopt as fo

_TIE = 1e-11  # corners whose rows differ by less than this share rule together
# dimensionless load factors up to this are rounding of 0, where safe ones reach further
_NONE = 1e-7
# of the length of the interval of safe load factors: what cannot be told apart where it is shorter
_SHARE = 1e-2
_GAVE_UP = 1, 4  # statuses of linprog: out of time, numerical trouble
_TIGHT = {
    "primal_feasibility_tolerance": 1e-10,
    "dual_feasibility_tolerance": 1e-10,
    "time_limit": 2.0,
}


def units(system: fo.ContactSystem, cycle: fo.LoadCycle) -> tuple[float, float]:
    """Force scale and slip scale of a contact."""
    q, p = system.reaction(cycle.mean)
    force = float(np.abs(p).mean()) or float(np.abs(q).mean()) or 1.0
    return force, force / system.stiffness_scale


def redescribed(
    system: fo.ContactSystem,
    order: Any = None,
    sense: float = 1.0,
    force: float = 1.0,
    length: float = 1.0,
    cases: Any = None,
) -> fo.ContactSystem:
    """The same contact with its nodes in another order, mirrored (sense -1), in other units, and with other unit loads (name -> unit)."""
    order, unit = (
        np.arange(system.nodes) if order is None else np.asarray(order),
        dict.fromkeys(system.bonded, 1.0) | (cases or {}),
    )
    A, B, C = (
        block[np.ix_(order, order)] * (force / length) for block in (system.A, system.B, system.C)
    )
    loads = {
        name: (sense * q[order] * (force / unit[name]), p[order] * (force / unit[name]))
        for name, (q, p) in system.bonded.items()
    }
    x = -system.x[::-1] if sense < 0 else system.x
    return fo.ContactSystem.from_blocks(
        A, sense * B, C, x * length, loads, system.gap[order] * length
    )


def _rows(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> tuple[Any, Any, Any]:
    """Safe means `slope v + rate lam + level >= 0`: all corners, both senses, and pressure; in the units of `units`."""
    force, length = units(system, cycle)
    A, B, f = (
        system.A * length / force,
        system.B * length / force,
        np.broadcast_to(friction, system.nodes),
    )
    q0, p0 = (values / force for values in cycle.mean_reaction(system))
    slopes, rates, levels = [], [], []
    for q1, p1 in zip(*cycle.corner_reactions(system), strict=True):
        slopes += [A + f[:, None] * B, f[:, None] * B - A, B]
        rates += [(q1 + f * p1) / force, (f * p1 - q1) / force, p1 / force]
        levels += [q0 + f * p0, f * p0 - q0, p0]
    return np.vstack(slopes), np.concatenate(rates), np.concatenate(levels)


def excess(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, load_factor: float, slip: Any
) -> float:
    """By how much a slip is not safe at a load factor: largest violation at any node and corner, over the force scale; at most 0 if it is safe.

    What the rounding of the terms can make of it is taken off.
    """
    slack, rounding = _slacks(system, cycle, friction, load_factor, slip)
    return float(-(slack + rounding).min())


def off_bounds(
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    friction: Any,
    load_factor: float,
    slip: Any,
    node: int,
    corners: tuple[int, ...],
) -> float:
    """How far a node is from its bound of forward slip at one corner, of backward slip at another, over the force scale; rounding as in `excess`."""
    slack, rounding = _slacks(system, cycle, friction, load_factor, slip)
    forward, backward = _both_bounds(system.nodes, node, corners)
    return float(max(abs(slack[row]) - rounding[row] for row in (forward, backward)))


def _slacks(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, load_factor: float, slip: Any
) -> tuple[Any, Any]:
    """Values of the rows, and their rounding errors."""
    slope, rate, level = _rows(system, cycle, friction)
    v = np.asarray(slip) / units(system, cycle)[1]
    rounding = (
        8
        * np.finfo(float).eps
        * (np.abs(slope) @ np.abs(v) + np.abs(rate) * load_factor + np.abs(level))
    )
    return slope @ v + rate * load_factor + level, rounding


def _both_bounds(nodes: int, node: int, corners: tuple[int, ...]) -> tuple[int, int]:
    """Rows of the bound of forward slip at the first corner, and of backward slip at the second."""
    return 3 * nodes * corners[0] + node, 3 * nodes * corners[1] + nodes + node


def largest_load_factor(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any
) -> float | None:
    """lambda_2 by one linear program on the plain rows; inf and nan as in `shakedown_limit`, None if the solver gives no answer."""
    slope, rate, level = _rows(system, cycle, friction)
    unit = float(np.abs(rate).max()) or 1.0
    answer = _optimum(np.column_stack([slope, rate / unit]), level, (0.0, np.inf))
    return answer / unit if answer is not None else None


def least_load_factor(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float | None:
    """Least load factor with a safe slip by one linear program on the plain rows; nan where there is none, None if the solver gives no answer."""
    slope, rate, level = _rows(system, cycle, friction)
    unit = float(np.abs(rate).max()) or 1.0
    answer = _optimum(np.column_stack([slope, -rate / unit]), level, (-np.inf, 0.0))
    return -answer / unit if answer is not None else None


def least_on_both_bounds(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any
) -> float | None:
    """Least load factor at which a safe slip holds some node on both its bounds, by one plain linear program per node whose bounds differ in corner.

    A node that is there at the least safe load factor counts only if it is at a larger one too (a
    second program): at 0 both bounds of a node that carries nothing coincide, and at one above 0
    the slips have no room. Inf where no node ever is; None if the solver gives no answer.
    """
    slope, rate, level = _rows(system, cycle, friction)
    unit, least = float(np.abs(rate).max()) or 1.0, np.inf
    rows = np.column_stack([slope, -rate / unit])
    lowest, most = (
        _optimum(rows, level, (-np.inf, 0.0)),
        _optimum(np.column_stack([slope, rate / unit]), level, (0.0, np.inf)),
    )
    if lowest is None or most is None or np.isnan(lowest):
        return None if lowest is None or most is None else least
    none = min(_NONE, _SHARE * (most + lowest))
    for node, corners in _to_and_fro(system.nodes, rate, np.asarray(friction)):
        equal = _both_bounds(system.nodes, node, corners)
        answer = _optimum(rows, level, (-np.inf, 0.0), equal)
        if answer is not None and answer > lowest - none:
            highest = _optimum(
                np.column_stack([slope, rate / unit]), level, (0.0, 1.0 - lowest), equal
            )
            answer = None if highest is None else answer if highest > none - lowest else np.nan
        if answer is None:
            return None
        least = least if np.isnan(answer) else min(least, -answer / unit)
    return least


def on_both_bounds(
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    friction: Any,
    load_factor: float,
    node: int,
    corners: tuple[int, ...],
) -> Any | None:
    """(N,) slip that holds a node on both its bounds at these corners, the others as far from theirs as possible; None if none is found."""
    slope, rate, level = _rows(system, cycle, friction)
    equal = list(_both_bounds(system.nodes, node, corners))
    others = np.arange(len(slope)) % system.nodes != node
    left, right = -np.column_stack([slope, -others.astype(float)]), level + rate * load_factor
    bounds = [(None, None)] * system.nodes + [(0.0, 1.0)]
    answer = linprog(
        -np.eye(system.nodes + 1)[-1],
        left,
        right,
        left[equal],
        right[equal],
        bounds,
        options=_TIGHT,
    )
    return answer.x[:-1] * units(system, cycle)[1] if answer.status == 0 else None


def _to_and_fro(nodes: int, rate: Any, friction: Any) -> list[tuple[int, tuple[int, int]]]:
    """Nodes that one corner brings to forward slip and another to backward slip, with these corners."""
    forward, backward, _ = np.moveaxis(rate.reshape(-1, 3, nodes), 1, 0)
    tie = _TIE * np.maximum(np.abs(forward), np.abs(backward)).max(axis=0)
    first, last = forward <= forward.min(axis=0) + tie, backward <= backward.min(axis=0) + tie
    alone = first & ~last, last & ~first
    found = np.flatnonzero(alone[0].any(axis=0) & alone[1].any(axis=0) & (friction > 0))
    return [
        (int(i), (int(np.argmax(alone[0][:, i])), int(np.argmax(alone[1][:, i])))) for i in found
    ]


def largest_margin(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, load_factor: float
) -> float | None:
    """Largest reserve, at most 1, of all rows of safe slip at a load factor, over the force scale; None if the solver gives no answer."""
    slope, rate, level = _rows(system, cycle, friction)
    return _optimum(
        np.column_stack([slope, -np.ones(len(slope))]), level + rate * load_factor, (-np.inf, 1.0)
    )


def _optimum(
    rows: Any, level: Any, limits: tuple[float, float], equal: Sequence[int] = ()
) -> float | None:
    """Largest last unknown z of `rows z + level >= 0`, `= 0` in some; inf or nan where there is none, None where no answer is accurate."""
    columns, equal = rows.shape[1], list(equal)
    little = 1 / np.clip(np.abs(level), 1e-6, 1.0)  # weights of rows whose nodes carry little
    bounds = [(-np.inf, np.inf)] * (columns - 1) + [limits]
    said = []
    for weight, method in product((little, np.ones_like(little)), ("highs-ds", "highs-ipm")):
        left, right = -weight[:, None] * rows, weight * level
        answer = linprog(
            -np.eye(columns)[-1],
            left,
            right,
            left[equal],
            right[equal],
            bounds,
            method=method,
            options=_TIGHT,
        )
        if answer.status == 0:
            slack = little * (rows @ answer.x + level)
            if slack.min() > -1e-9 and (np.abs(slack[equal]) < 1e-9).all():
                return float(answer.x[-1])
        said.append(answer.status)
    told = (
        [status for status in said if status not in _GAVE_UP] if equal else said
    )  # there are many nodes, and a program that stops early does not affect the others
    return (
        {2: float("nan"), 3: float("inf")}.get(told[0])
        if len(told) > 1 and len(set(told)) == 1
        else None
    )


def corner_loads(
    system: fo.ContactSystem, cycle: fo.LoadCycle, load_factor: float
) -> tuple[Any, list[Any]]:
    """(2N,) bonded reactions of the mean load, and those of the corners."""
    mean = np.concatenate(system.reaction(cycle.mean))
    return mean, [
        mean + load_factor * np.concatenate(pair)
        for pair in zip(*cycle.corner_reactions(system), strict=True)
    ]


class Marched(NamedTuple):
    """Slips (corners visited, N) and work of friction (cycles,), and the most states that any increment had."""

    slip: Any
    work: Any
    states: int


class Stepper:
    """Increments whose states are found by trying all 4^N statuses, for few nodes; in the units of `units`.

    Attributes
    ----------
    regular
        Whether no status leaves the motion open.
    """

    def __init__(self, system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> None:
        self.force, self.length = units(system, cycle)
        self.S, self.f, n = (
            system.S * self.length / self.force,
            np.asarray(friction, dtype=float),
            system.nodes,
        )
        self.gap, self.nodes = system.gap / self.length, n
        identity, solutions, statuses = np.eye(2 * n), [], []
        self.regular = True
        for status in product((0, 1, -1, 2), repeat=n):
            rows, sides = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n))
            for i, sense in enumerate(status):
                tangential, normal = identity[i], identity[n + i]
                if sense == 2:
                    rows[i], rows[n + i], sides[i], sides[n + i] = (
                        self.S[i],
                        self.S[n + i],
                        -tangential,
                        -normal,
                    )
                else:
                    rows[n + i] = normal
                    rows[i] = self.S[i] + sense * self.f[i] * self.S[n + i] if sense else tangential
                    sides[i] = -tangential - sense * self.f[i] * normal if sense else 0.0
            if np.linalg.cond(rows) > 1e9:
                self.regular = False
                continue
            statuses.append(status)
            solutions.append(np.linalg.solve(rows, sides))
        self._solutions, self._status = np.array(solutions), np.array(statuses)

    def states(self, slip: Any, bonded: Any, tolerance: float = 1e-9) -> list[tuple[Any, Any]]:
        """All states `[dv, w], [q, p]` after an increment to bonded reactions (2N,), each once."""
        n = self.nodes
        trial = bonded / self.force + self.S @ np.r_[slip / self.length, -self.gap]
        u = self._solutions @ trial
        r = trial + u @ self.S
        size = tolerance * max(1.0, float(np.abs(trial).max()))
        slides = (np.abs(self._status) == 1) & (self.f > 0)
        wrong = np.maximum.reduce(
            [
                -u[:, n:],
                -r[:, n:],
                np.abs(r[:, :n]) - self.f * r[:, n:],
                np.where(slides, -self._status * u[:, :n], 0.0),
            ]
        )
        found: list[tuple[Any, Any]] = []
        for state, forces in zip(
            u[(wrong <= size).all(axis=1)], r[(wrong <= size).all(axis=1)], strict=True
        ):
            if all(np.abs(state - other).max() > 1e3 * size for other, _ in found):
                found.append((state, forces))
        return found

    def march(
        self,
        system: fo.ContactSystem,
        cycle: fo.LoadCycle,
        load_factor: float,
        start: Any,
        cycles: int,
        steps: int,
    ) -> Marched | None:
        """Follow a transient as `frictopt.march` defines it, in increments; None where one of them has no state."""
        n = self.nodes
        mean, corners = corner_loads(system, cycle, load_factor)
        slip = np.zeros(n) if start is None else np.asarray(start, dtype=float)
        r = np.r_[np.zeros(n), np.full(n, self.force)]
        before = r - system.S @ np.r_[slip, -system.gap]
        most, slips, works, pressure = 1, [], [], r[n:] / self.force
        for number in range(cycles * len(corners) + 1):
            target = mean if number == 0 else corners[(number - 1) % len(corners)]
            work = 0.0
            for share in (
                1 - np.cos(np.pi * np.arange(1, steps + 1) / steps)
            ) / 2:  # shorter near the corners, where most events are
                states = self.states(slip, before + share * (target - before))
                if not states:
                    return None
                most = max(most, len(states))
                u, r = states[0]
                work += float((self.f * (pressure + r[n:]) / 2 * np.abs(u[:n]) * (r[n:] > 0)).sum())
                slip, pressure = slip + u[:n] * self.length, r[n:]
            slips.append(slip)
            works.append(work)
            before = target
        cyclic = np.array(works[1:]).reshape(cycles, -1).sum(axis=1)
        return Marched(np.array(slips), cyclic * self.force * self.length, most)
