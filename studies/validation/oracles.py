"""Independent answers for comparison: plain linear programs and the enumeration of all node statuses.

The contact law is written again here. Nothing uses methods of the package, only the matrices, the
bonded reactions and the numbers of an answer.
"""

from collections.abc import Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import linprog

import frictopt as fo

# Corners whose rows differ by less than this share govern together.
_TIE = 1e-11
# A dimensionless load factor up to this value counts as 0, if the interval of safe load factors is
# long enough.
_NONE = 1e-7
# In a short interval, load factors that differ by less than this share of its length count as
# equal.
_SHARE = 1e-2
# Statuses of linprog: out of time, numerical trouble.
_GAVE_UP = 1, 4
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
    """A contact in another description.

    The nodes may have another order, the contact may be mirrored (sense -1), and force and length
    may have other units. `cases` gives load cases a unit (name -> unit).
    """
    order = np.arange(system.nodes) if order is None else np.asarray(order)
    unit = dict.fromkeys(system.bonded, 1.0) | (cases or {})
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
    """Arrays `slope`, `rate` and `level`: a slip v is safe if `slope v + rate lam + level >= 0`.

    For each corner there are three groups of rows: the bounds of forward and of backward slip, and
    pressure. All values have the units of `units`.
    """
    force, length = units(system, cycle)
    A = system.A * length / force
    B = system.B * length / force
    f = np.broadcast_to(friction, system.nodes)
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
    """Largest violation of the contact law by a slip, at any node and corner, in units of the force scale.

    A slip is safe at the load factor if the violation is at most 0. The rounding error of the terms
    is subtracted.
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
    """Distance of a node from the bound of forward slip at one corner, and of backward slip at another.

    The larger of the two distances is returned, in units of the force scale. The rounding error is
    subtracted as in `excess`.
    """
    slack, rounding = _slacks(system, cycle, friction, load_factor, slip)
    forward, backward = _both_bounds(system.nodes, node, corners)
    return float(max(abs(slack[row]) - rounding[row] for row in (forward, backward)))


def _slacks(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, load_factor: float, slip: Any
) -> tuple[Any, Any]:
    """Values of the rows, and their rounding errors."""
    slope, rate, level = _rows(system, cycle, friction)
    v = np.asarray(slip) / units(system, cycle)[1]
    size_of_terms = np.abs(slope) @ np.abs(v) + np.abs(rate) * load_factor + np.abs(level)
    rounding = 8 * np.finfo(float).eps * size_of_terms
    return slope @ v + rate * load_factor + level, rounding


def _both_bounds(nodes: int, node: int, corners: tuple[int, ...]) -> tuple[int, int]:
    """Rows of the bound of forward slip at the first corner, and of backward slip at the second."""
    return 3 * nodes * corners[0] + node, 3 * nodes * corners[1] + nodes + node


def largest_load_factor(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any
) -> float | None:
    """The shakedown limit by one linear program on the plain rows.

    The limit is inf or nan as in `shakedown_limit`, and None if the solver gives no answer.
    """
    slope, rate, level = _rows(system, cycle, friction)
    unit = float(np.abs(rate).max()) or 1.0
    answer = _optimum(np.column_stack([slope, rate / unit]), level, (0.0, np.inf))
    return answer / unit if answer is not None else None


def least_load_factor(system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> float | None:
    """The least safe load factor by one linear program on the plain rows.

    The result is nan if no load factor is safe, and None if the solver gives no answer.
    """
    slope, rate, level = _rows(system, cycle, friction)
    unit = float(np.abs(rate).max()) or 1.0
    answer = _optimum(np.column_stack([slope, -rate / unit]), level, (-np.inf, 0.0))
    return -answer / unit if answer is not None else None


def least_on_both_bounds(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any
) -> float | None:
    """Least load factor at which a safe slip holds some node on both its bounds.

    There is one linear program for each node whose two bounds govern at different corners. A node
    that is on both bounds at the least safe load factor counts only if it is on both at a larger
    load factor, too (a second program). There are two reasons. At the load factor 0 both bounds of
    a node without load coincide. At a least safe load factor above 0 only one slip is safe. The
    result is inf if no node is ever on both bounds, and None if the solver gives no answer.
    """
    slope, rate, level = _rows(system, cycle, friction)
    unit = float(np.abs(rate).max()) or 1.0
    # The last unknown of a program is minus the load factor, or the load factor.
    downward = np.column_stack([slope, -rate / unit])
    upward = np.column_stack([slope, rate / unit])
    minus_lowest = _optimum(downward, level, (-np.inf, 0.0))
    largest = _optimum(upward, level, (0.0, np.inf))
    if minus_lowest is None or largest is None:
        return None
    least = np.inf
    if np.isnan(minus_lowest):
        return least
    none = min(_NONE, _SHARE * (largest + minus_lowest))
    for node, corners in _to_and_fro(system.nodes, rate, np.asarray(friction)):
        equal = _both_bounds(system.nodes, node, corners)
        answer = _optimum(downward, level, (-np.inf, 0.0), equal)
        if answer is None:
            return None
        if answer > minus_lowest - none:
            highest = _optimum(upward, level, (0.0, 1.0 - minus_lowest), equal)
            if highest is None:
                return None
            if not highest > none - minus_lowest:
                continue
        if not np.isnan(answer):
            least = min(least, -answer / unit)
    return least


def on_both_bounds(
    system: fo.ContactSystem,
    cycle: fo.LoadCycle,
    friction: Any,
    load_factor: float,
    node: int,
    corners: tuple[int, ...],
) -> Any | None:
    """(N,) a slip that holds a node on both its bounds at these corners.

    The other nodes are as far from their bounds as possible. None if the program has no solution.
    """
    slope, rate, level = _rows(system, cycle, friction)
    equal = list(_both_bounds(system.nodes, node, corners))
    others = np.arange(len(slope)) % system.nodes != node
    left = -np.column_stack([slope, -others.astype(float)])
    right = level + rate * load_factor
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
    """Nodes whose bounds of forward and backward slip govern at different corners, with these corners."""
    forward, backward, _ = np.moveaxis(rate.reshape(-1, 3, nodes), 1, 0)
    tie = _TIE * np.maximum(np.abs(forward), np.abs(backward)).max(axis=0)
    governs_forward = forward <= forward.min(axis=0) + tie
    governs_backward = backward <= backward.min(axis=0) + tie
    only_forward = governs_forward & ~governs_backward
    only_backward = governs_backward & ~governs_forward
    has_both = only_forward.any(axis=0) & only_backward.any(axis=0) & (friction > 0)
    pairs = []
    for node in np.flatnonzero(has_both):
        corners = int(np.argmax(only_forward[:, node])), int(np.argmax(only_backward[:, node]))
        pairs.append((int(node), corners))
    return pairs


def largest_margin(
    system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any, load_factor: float
) -> float | None:
    """Largest margin of a safe slip at a load factor, in units of the force scale; at most 1.

    None if the solver gives no answer.
    """
    slope, rate, level = _rows(system, cycle, friction)
    rows = np.column_stack([slope, -np.ones(len(slope))])
    return _optimum(rows, level + rate * load_factor, (-np.inf, 1.0))


def _optimum(
    rows: Any, level: Any, limits: tuple[float, float], equal: Sequence[int] = ()
) -> float | None:
    """Largest last unknown z of `rows z + level >= 0`, with equality in the rows `equal`.

    The result is inf if z has no bound, nan if the rows contradict each other, and None if no
    answer is accurate.
    """
    columns = rows.shape[1]
    equal = list(equal)
    # Rows whose nodes carry small loads get larger weights.
    weights = 1 / np.clip(np.abs(level), 1e-6, 1.0)
    bounds = [(-np.inf, np.inf)] * (columns - 1) + [limits]
    statuses = []
    for weight, method in product((weights, np.ones_like(weights)), ("highs-ds", "highs-ipm")):
        left = -weight[:, None] * rows
        right = weight * level
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
            slack = weights * (rows @ answer.x + level)
            if slack.min() > -1e-9 and (np.abs(slack[equal]) < 1e-9).all():
                return float(answer.x[-1])
        statuses.append(answer.status)
    if equal:
        # Each node has such a program. A run that gives up says nothing about it.
        statuses = [status for status in statuses if status not in _GAVE_UP]
    if len(statuses) > 1 and len(set(statuses)) == 1:
        return {2: float("nan"), 3: float("inf")}.get(statuses[0])
    return None


def corner_loads(
    system: fo.ContactSystem, cycle: fo.LoadCycle, load_factor: float
) -> tuple[Any, list[Any]]:
    """Bonded reactions (2N,) of the mean load, and bonded reactions (2N,) of each corner."""
    mean = np.concatenate(system.reaction(cycle.mean))
    return mean, [
        mean + load_factor * np.concatenate(pair)
        for pair in zip(*cycle.corner_reactions(system), strict=True)
    ]


class Marched(NamedTuple):
    """A transient in increments.

    Attributes
    ----------
    slip
        (corners visited, N) slips.
    work
        (cycles,) work of friction.
    states
        Largest number of states that an increment has.
    """

    slip: Any
    work: Any
    states: int


class Stepper:
    """Increments that try all 4^N combinations of node statuses, for few nodes.

    All values have the units of `units`.

    Attributes
    ----------
    regular
        Whether the motion is unique for each combination of statuses.
    """

    def __init__(self, system: fo.ContactSystem, cycle: fo.LoadCycle, friction: Any) -> None:
        self.force, self.length = units(system, cycle)
        n = system.nodes
        self.S = system.S * self.length / self.force
        self.f = np.asarray(friction, dtype=float)
        self.gap = system.gap / self.length
        self.nodes = n
        identity = np.eye(2 * n)
        solutions = []
        statuses = []
        self.regular = True
        # A node sticks (0), slips forward (1) or backward (-1), or is open (2).
        for status in product((0, 1, -1, 2), repeat=n):
            rows = np.zeros((2 * n, 2 * n))
            sides = np.zeros((2 * n, 2 * n))
            for i, sense in enumerate(status):
                tangential = identity[i]
                normal = identity[n + i]
                if sense == 2:
                    rows[i] = self.S[i]
                    rows[n + i] = self.S[n + i]
                    sides[i] = -tangential
                    sides[n + i] = -normal
                elif sense:
                    rows[n + i] = normal
                    rows[i] = self.S[i] + sense * self.f[i] * self.S[n + i]
                    sides[i] = -tangential - sense * self.f[i] * normal
                else:
                    rows[n + i] = normal
                    rows[i] = tangential
            if np.linalg.cond(rows) > 1e9:
                self.regular = False
                continue
            statuses.append(status)
            solutions.append(np.linalg.solve(rows, sides))
        self._solutions = np.array(solutions)
        self._status = np.array(statuses)

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
        obeys = (wrong <= size).all(axis=1)
        states: list[tuple[Any, Any]] = []
        for state, forces in zip(u[obeys], r[obeys], strict=True):
            if all(np.abs(state - known).max() > 1e3 * size for known, _ in states):
                states.append((state, forces))
        return states

    def march(
        self,
        system: fo.ContactSystem,
        cycle: fo.LoadCycle,
        load_factor: float,
        start: Any,
        cycles: int,
        steps: int,
    ) -> Marched | None:
        """Follow a transient as `frictopt.march` defines it, in increments.

        None if an increment has no state.
        """
        n = self.nodes
        mean, corners = corner_loads(system, cycle, load_factor)
        slip = np.zeros(n) if start is None else np.asarray(start, dtype=float)
        r = np.r_[np.zeros(n), np.full(n, self.force)]
        before = r - system.S @ np.r_[slip, -system.gap]
        pressure = r[n:] / self.force
        most_states = 1
        slips = []
        works = []
        # Increments are shorter near the corners, where most events happen.
        shares = (1 - np.cos(np.pi * np.arange(1, steps + 1) / steps)) / 2
        for number in range(cycles * len(corners) + 1):
            target = mean if number == 0 else corners[(number - 1) % len(corners)]
            work = 0.0
            for share in shares:
                states = self.states(slip, before + share * (target - before))
                if not states:
                    return None
                most_states = max(most_states, len(states))
                u, r = states[0]
                mean_pressure = (pressure + r[n:]) / 2
                work += float((self.f * mean_pressure * np.abs(u[:n]) * (r[n:] > 0)).sum())
                slip = slip + u[:n] * self.length
                pressure = r[n:]
            slips.append(slip)
            works.append(work)
            before = target
        cyclic = np.array(works[1:]).reshape(cycles, -1).sum(axis=1)
        return Marched(np.array(slips), cyclic * self.force * self.length, most_states)
