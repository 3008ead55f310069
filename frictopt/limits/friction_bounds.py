"""The rows that keep nodes stuck, and what their multipliers mean: friction bounds are intervals in the plane, and circles in space."""

import cvxpy as cp
import numpy as np
from scipy.optimize import nnls

from ..contact import FLOOR, NO_COUPLING, RESIDUAL, ROUNDING, Array, LoadCycle
from .answered import Mechanism
from .design_result import DesignLoads
from .question import LimitQuestion
from .safe_set import Rows, SafeSet, ruling

_ROWS = {"no_forward_slip": ("forward", 1.0), "no_backward_slip": ("backward", -1.0), "no_opening": ("opening", 0.0)}  # with the sense of the shear
_INSIDE = ROUNDING  # distance of a corner from the hull of the others, over its size, that counts as none
_EXCEEDED = ROUNDING / 10  # excess over a circle, in mean normal forces, from which on it counts


def safe_set(task: LimitQuestion, design: DesignLoads | None = None) -> SafeSet:
    """Unknowns and rows of the safe slips of a contact in the plane or in space; friction is set by `SafeSet.ask`."""
    return (Intervals if task.system.tangents == 1 else Circles)(task, design)


class Intervals(SafeSet):
    """The safe slips of a contact in the plane, by the rows of the corners that rule; friction and loads are parameters, the matrices are not.

    The corners of one row differ only in the coefficient of `lam >= 0`, so the largest one rules and stands for all of them::

        q0 + A v + f (p0 + B v) >= lam forward,       forward = max_k -(q1_k + f p1_k)
        f (p0 + B v) - q0 - A v >= lam backward,      backward = max_k (q1_k - f p1_k)
                       p0 + B v >= lam opening,       opening = max_k -p1_k

    Where a part of the cycle is fixed, they differ in the constant too, and few of them rule, see `ruling`: loads are constants then. The last row
    follows from the other two where there is friction, and is left out; for little or none, it stays. A given load factor stands in the loads.
    """

    def ask(self, task: LimitQuestion, load_factor: float | None = None) -> None:
        """See `SafeSet.ask`."""
        self.task, self._given = task, load_factor
        lam, (q0, p0), (q1, p1) = task.load_unit if load_factor is None else load_factor, task.r0.swapaxes(0, 1), task.r1.swapaxes(0, 1)
        self._ruled, self._values = {}, {"friction": task.friction, "clearance": task.mean_bound / self.unit}
        for name, (way, sense) in _ROWS.items():
            weight = task.friction if sense else 1.0
            mean, cyclic = sense * q0 + weight * p0, sense * q1 + weight * p1
            self._ruled[name] = at = ruling(-mean, -cyclic, load_factor)
            self._values[f"{way}_mean"] = np.broadcast_to(mean, cyclic.shape)[at] / self.unit[at[1]]
            self._values[way] = -cyclic[at] * lam / self.unit[at[1]]
        (forward, _), (backward, _), _ = self._ruled.values()
        idle = len(task.r1) - len(np.union1d(forward, backward))
        self.idle = f"corners: {idle} of {len(task.r1)} rule no node" if idle else ""
        for name, value in {} if task.fixed else self._values.items():
            if name not in self.parameters:
                self.parameters[name] = cp.Parameter(len(value), name=name, nonneg=name in ("friction", "clearance"))
            self.parameters[name].value = value

    def stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None = None, spare: cp.Parameter | float = 0.0) -> Rows:
        """See `SafeSet.stuck`."""
        task, rows, given = self.task, dict[str, cp.Constraint](), self._values if self.task.fixed else self.parameters
        for name, (way, sense) in _ROWS.items():
            shear, pressure, f, clearance = self.shear, self.pressure, given["friction"], given["clearance"]
            if task.fixed:
                shear, pressure, f, clearance = (part[self._ruled[name][1]] for part in (shear, pressure, f, clearance))
            bound = cp.multiply(f, pressure) if sense else pressure
            slack = bound + given[f"{way}_mean"] + (shear if sense > 0 else -shear if sense else 0.0)
            load = given[way] if load_factor is None else given[way] * load_factor
            reserve = (0.0 if margin is None else cp.multiply(clearance, margin)) - spare
            rows |= {name: slack >= load + reserve} if sense or task.opening else {}
        return rows if task.lift is None else {**rows, **self._apart(task.lift, load_factor, margin)}

    def motion(self) -> tuple[Mechanism, Array]:
        """See `SafeSet.motion`."""
        motions = np.zeros((3, *self.task.r1[:, -1].shape))
        for motion, (name, at) in zip(motions, self._ruled.items(), strict=True):
            if name in self.rows:
                motion[at] = np.maximum(self.rows[name].dual_value, 0.0) / self.unit[at[1]]
        forward, backward, opening = motions
        lift = self.task.friction * (forward + backward) + opening
        return Mechanism(np.stack([forward - backward, lift], axis=1), self.task.friction, *self.held()), forward + backward


class Circles(SafeSet):
    """The safe slips of a contact in space, by a circle for each node and each corner that is not within the hull of the others.

    `p_k >= 0` follows where there is friction; for little or none it is a row of its own. Where the bound `f p_k` vanishes whatever the slip, the
    circle is the point `q_k = 0`: where cyclic shears differ between such corners there is no limit above 0. A margin opens every
    circle. Friction and loads are constants of the rows.
    """

    def ask(self, task: LimitQuestion, load_factor: float | None = None) -> None:
        """See `SafeSet.ask`."""
        self.task, self._given = task, load_factor
        tangent, normal = np.split(np.sqrt(task.stiffness), [-len(task.friction)])
        alone = (np.abs(task.AB[len(tangent) :]) <= NO_COUPLING * np.outer(normal, tangent)).all(axis=1)
        p0, p1 = np.abs(task.r0[:, -1]), np.abs(task.r1[:, -1])
        # (K, N), or (1, N) where nothing is fixed: neither the load at load factor 0, nor any slip or design, makes a pressure at the node
        self._unpressed = alone & (p0 <= ROUNDING * task.force) & (self.design is None)
        # (K, N): the friction bound vanishes at the corner, whatever the slip, the load factor, and the design
        self._bare = (task.friction == 0) | (self._unpressed & (p1 <= ROUNDING * p1.max(initial=0.0)))

    def helpless(self) -> tuple[Mechanism, str] | None:
        """See `SafeSet.helpless`.

        A node without a bound slips to and fro between two corners whose shears differ; one that nothing presses is lifted by a corner that pulls.
        """
        task, points = self.task, self._bare
        q1, nodes, first = task.r1[:, :2], np.arange(len(task.friction)), points.argmax(axis=0)
        apart = np.linalg.norm(q1 - q1[first, :, nodes].T, axis=1) * points
        if task.fixed:  # whose shears differ at load factor 0 too may meet at another one
            apart = apart * (task.r0[:, :2] == task.r0[first, :2, nodes].T).all(axis=1)
        pull = np.maximum(-task.r1[:, 2], 0.0) * self._unpressed
        moved = np.maximum(apart, pull)
        corner, node = np.unravel_index(int(moved.argmax()), moved.shape)
        if not moved[corner, node] > ROUNDING * float(np.abs(task.r1).max()):
            return None
        moves, name = np.zeros(task.r1.shape), node if task.images is None else task.images[1][0, node]
        if pull[corner, node] > apart[corner, node]:
            moves[corner, -1, node] = 1.0
            return Mechanism(moves, task.friction), f"node {name} carries no pressure under the mean load, and the cyclic load lifts it"
        way = np.append(q1[corner, :, node] - q1[first[node], :, node], 0.0)
        moves[first[node], :, node], moves[corner, :, node] = way, -way
        moves[[first[node], corner], -1, node] = task.friction[node] * np.linalg.norm(way)
        lack = "friction" if task.friction[node] == 0 else "pressure"
        return Mechanism(moves, task.friction), f"node {name} has no {lack}, and the cyclic load shears it"

    def stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None = None, spare: cp.Parameter | float = 0.0) -> Rows:
        """See `SafeSet.stuck`."""
        task, unit = self.task, self.unit
        nodes, corners = len(task.friction), len(task.r1)
        self._kept = _outer_corners(task.cycle) if task.simplify else list(range(corners))
        idle = corners - len(self._kept)
        self.idle = f"corners: {idle} of {corners} are within the hull of the others" if idle else ""
        lam = self._given if load_factor is None else task.load_unit * load_factor
        reserve = (0.0 if margin is None else task.mean_bound / unit * margin) - spare
        pressure = cp.Variable(nodes, name="pressure_change")  # one dense block of rows serves all corners
        shear = cp.reshape(self.shear, (nodes, 2), order="F")
        rows: dict[str, cp.Constraint] = {"pressures_of_slip": self.pressure == pressure}
        points = self._bare if margin is None else np.zeros((corners, nodes), dtype=bool)
        self._pinned = points & np.isin(np.arange(corners), self._kept)[:, None]  # of a node the first such corner stands for all of the same shear
        first, other = self._pinned.argmax(axis=0), np.zeros_like(points)
        if task.fixed:
            other = np.any([(r[:, :2] != r[first, :2, np.arange(nodes)].T).any(axis=1) for r in (task.r0, task.r1)], axis=0)
        self._pinned &= (np.cumsum(self._pinned, axis=0) == 1) | other
        r0, r1 = np.broadcast_to(task.r0, task.r1.shape) / unit, task.r1 / unit
        for k in self._kept:
            q, p = r0[k, :2].T + lam * r1[k, :2].T + shear, r0[k, 2] + lam * r1[k, 2] + pressure
            circles, pinned = np.flatnonzero(~points[k]), np.flatnonzero(self._pinned[k])
            bound = cp.multiply(task.friction, p) - reserve
            rows |= {f"friction_circle_{k}": cp.SOC(bound[circles], q[circles], axis=1)} if len(circles) else {}
            rows |= {f"no_shear_{k}": q[pinned] == 0} if len(pinned) else {}
            rows |= {f"no_opening_{k}": p >= reserve} if task.opening else {}
        self._circles = ~points
        return rows if task.lift is None else {**rows, **self._apart(task.lift, load_factor, margin)}

    def motion(self) -> tuple[Mechanism, Array]:
        """See `SafeSet.motion`.

        Where the force multiplier of a circle exceeds its slip (a node that carries nothing), the node opens too.
        """
        task, unit, rows = self.task, self.unit, self.rows
        slips, (force, opening) = np.zeros((*self._circles.shape, 2)), np.zeros((2, *self._circles.shape))
        for k in self._kept:
            if f"friction_circle_{k}" in rows:
                force[k, self._circles[k]], slips[k, self._circles[k]] = rows[f"friction_circle_{k}"].dual_value
            if f"no_shear_{k}" in rows:
                slips[k, self._pinned[k]] = -rows[f"no_shear_{k}"].dual_value
            if f"no_opening_{k}" in rows:
                opening[k] = np.maximum(rows[f"no_opening_{k}"].dual_value, 0.0)
        force = np.maximum(force, np.linalg.norm(slips, axis=-1))
        moves = np.dstack([slips, task.friction * force + opening]).transpose(0, 2, 1) / unit
        return Mechanism(moves, task.friction, *self.held()), force / unit

    @property
    def solved_load_factor(self) -> float:
        """The load factor of the solution, >= 0, moved to where its slip is within all circles: solvers obey them only up to their tolerance.

        Circles are exceeded from rounding on: where a node carries nothing, what it can carry is lost in it. It moves within the tolerance alone:
        where a circle hardly feels the load, all of the load factor would go before the rounding of its slip does, which the referee allows.
        """
        task, value, slip = self.task, float(self.load_factor.value) * self.task.load_unit, self.solved_slip
        (r, r1), sense = (task.states(value, slip)[1], task.r1), 1.0 if isinstance(self.problem.objective, cp.Maximize) else -1.0
        size = np.linalg.norm(r[:, :2], axis=1)
        along = (r[:, :2] * r1[:, :2]).sum(axis=1) / np.where(size > 0, size, 1.0)
        rows = [((size - task.friction * r[:, 2]) / task.force, (along - task.friction * r1[:, 2]) / task.force)]  # excess, and what load adds to it
        if task.opening:
            rows.append((-r[:, 2] / task.force, -r1[:, 2] / task.force))
        if task.lift is not None:
            rows.append((-task.gaps(value, slip) / task.clearance, -task.w1 / task.clearance))
        excess, rise = (np.concatenate([np.ravel(part) for part in parts]) for parts in zip(*rows, strict=True))
        beyond = (excess > _EXCEEDED) & (sense * rise > 0)
        most = RESIDUAL / 2 * max(value, FLOOR * task.load_unit)
        return max(0.0, value - sense * min(most, float((excess[beyond] / np.abs(rise[beyond])).max(initial=0.0))))


def _outer_corners(cycle: LoadCycle) -> list[int]:
    """Corners that are no mean of the others, by the amplitudes of all load cases, also those that are fixed."""
    columns = [
        [load.get(case, 0.0) for load in loads]
        for loads in (cycle.corners, *([] if cycle.fixed is None else [cycle.fixed]))
        for case in sorted({case for load in loads for case in load})
    ]
    points = np.array([np.ones(len(cycle.corners)), *columns])
    points /= np.where(points.any(axis=1), np.abs(points).max(axis=1), 1.0)[:, None]
    kept = list(range(len(cycle.corners)))
    for corner in range(len(cycle.corners)):
        others = [k for k in kept if k != corner]
        if others and nnls(points[:, others], points[:, corner])[1] <= _INSIDE:
            kept = others
    return kept
