"""What the programs over safe residual slips are made of: unknowns, the rows that keep a contact stuck, and what their multipliers mean.

A residual slip v is safe at a load factor when it keeps every node closed and stuck at every corner of the load cycle. Unknowns are dimensionless
tractions, see `ScaledContact`. In the plane few corners rule each end of a node's friction interval, see `Intervals`; in space each corner has a
circle of its own at each node, see `Circles`. The rest is the same for both.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import TypeAlias

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from .design_loads import DesignLoads
from .mechanism import Mechanism
from .question import LimitQuestion
from .ruling_corners import Ruling, ruling, ruling_loads
from .scaling import scaled_contact

__all__ = ["Intervals", "Rows", "SafeSet"]

Rows: TypeAlias = Mapping[str, cp.Constraint]


class SafeSet(ABC):
    """Unknowns of a residual slip v, and the rows by which it is safe.

    Parameters
    ----------
    task
        The contact, its loads and its slip bound `|v| <= most`; friction is set by `ask`.
    design
        Loads of the mean state that are unknowns too; None for none.

    Attributes
    ----------
    scaled
        Unknowns and units.
    traction, slide
        The unknowns: nodal tractions, and rigid slides, which no row feels but those that bound the slip.
    load_factor, margin
        Unknowns of the programs that have them.
    """

    def __init__(self, task: LimitQuestion, design: DesignLoads | None = None) -> None:
        self.scaled, self._most, self.design = scaled_contact(task), task.most, design
        rigid = self.scaled.rigid.shape[1]
        self.traction, self.slide = cp.Variable(len(self.scaled.loaded), name="traction"), cp.Variable(rigid, name="slide") if rigid else None
        self.load_factor, self.margin = cp.Variable(name="load_factor"), cp.Variable(name="margin")

    def stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None = None, spare: cp.Parameter | None = None) -> Rows:
        """Rows by which every node is closed and stuck at every corner, or stays open, with a margin in mean friction bounds (None: no margin).

        A load factor of None is the given one. The rows of a node are loose by its part of `spare`, (N,), in the units of the nodes; not of a cycle
        of which a part is fixed.
        """
        return {**self._stuck(load_factor, margin, 0.0 if spare is None else spare), **self._apart(load_factor, margin)}

    @abstractmethod
    def _stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None, spare: cp.Parameter | float) -> Rows:
        """Rows of the closed nodes."""

    def ask(self, task: LimitQuestion, load_factor: float | None = None) -> None:
        """Set friction, loads, and the load factor where it is given."""
        self._task, self._given = task, np.nan if load_factor is None else load_factor

    @abstractmethod
    def motion(self, rows: Rows) -> tuple[Mechanism, Array]:
        """The mechanism that the multipliers of the rows stand for, and the (N,) sums of those of each node, in units of 1 over force."""

    @property
    @abstractmethod
    def narrows(self) -> bool:
        """Whether the cyclic load only narrows the rows, so that what is safe at any load factor is so at 0."""

    @property
    @abstractmethod
    def left_out(self) -> tuple[str, ...]:
        """What has no rows, in words."""

    def problem(self, goal: cp.Maximize | cp.Minimize, rows: Rows) -> cp.Problem:
        """The rows by their names, and those of the slip bound."""
        return cp.Problem(goal, [row.set_label(name) for name, row in {**rows, **self._bounded()}.items()])

    @property
    def slip(self) -> cp.Expression:
        """(t N,) slip by component, length, an affine cvxpy expression."""
        slip = self.scaled.slip @ self.traction
        return slip if self.slide is None else slip + self.scaled.rigid @ self.slide

    @property
    def shear(self) -> cp.Expression:
        """(t N,) what slip and design add to the shear forces, by component, in the units of the nodes, an affine cvxpy expression."""
        shear = self.scaled.shear @ self.traction
        return shear if self.design is None else shear + self.design.shear(self.scaled.unit) @ self.design.amounts

    @property
    def pressure(self) -> cp.Expression:
        """(N,) what slip and design add to the normal forces, in the units of the nodes, an affine cvxpy expression."""
        pressure = self.scaled.normal @ self.traction
        return pressure if self.design is None else pressure + self.design.pressure(self.scaled.unit) @ self.design.amounts

    @cached_property
    def _reach(self) -> Array:
        """(N,) slip that unit unknowns make at most, by which the rows of the slip bound are divided, length."""
        norms = np.linalg.norm(np.hstack([self.scaled.slip, self.scaled.rigid]), axis=1)
        return np.asarray(norms.reshape(-1, len(self.scaled.unit)).max(axis=0))

    def _bounded(self) -> Rows:
        """Rows of the slip bound, in units of `_reach`."""
        if self._most is None:
            return {}
        nodes, most = len(self._reach), self._most / self._reach
        slip = cp.multiply(1 / np.resize(self._reach, self.slip.size), self.slip)
        if slip.size == nodes:
            return {"forward_slip_bound": slip <= most, "backward_slip_bound": slip >= -most}
        slip, free, fixed = cp.reshape(slip, (nodes, 2), order="F"), np.flatnonzero(most > 0), np.flatnonzero(most == 0)
        rows: dict[str, cp.Constraint] = {"slip_bound": cp.SOC(cp.Constant(most[free]), slip[free], axis=1)} if len(free) else {}
        return rows | {"no_slip": slip[fixed] == 0} if len(fixed) else rows

    def _room(self, lift: Array) -> Array:
        """(O,) gap that the rows of open nodes are divided by, length."""
        loads, lift = self._task.loads, lift @ np.hstack([self.scaled.slip, self.scaled.rigid])
        sizes = np.abs(lift).max(axis=1, initial=0.0), np.abs(loads.w0).max(axis=0), self._task.load_unit * np.abs(loads.w1).max(axis=0)
        room = np.max(sizes, axis=0)
        return np.where(room > 0, room, self._task.clearance)

    def _apart(self, load_factor: cp.Variable | None, margin: cp.Variable | None) -> Rows:
        """Rows by which open nodes stay open, at the corners that rule them."""
        task = self._task
        if task.lift is None:
            return {}
        loads, (corner, node) = task.loads, self._closing
        room = self._room(task.lift)[node]
        lam = self._given if load_factor is None else task.load_unit * load_factor
        reserve = 0.0 if margin is None else task.clearance / room * margin
        w0 = np.broadcast_to(loads.w0, loads.w1.shape)
        gap = w0[corner, node] / room + lam * (loads.w1[corner, node] / room) + (task.lift[node] / room[:, None]) @ self.slip
        return {"stays_open": gap >= reserve}

    @property
    def opened_by_slides(self) -> Array:
        """What unit slides do to the gaps of the rows by which open nodes stay open."""
        (_, node), lift = self._closing, np.zeros((0, self.scaled.slip.shape[0])) if self._task.lift is None else self._task.lift
        return np.asarray((lift / self._room(lift)[:, None])[node] @ self.scaled.rigid)

    @property
    def _closing(self) -> Ruling:
        """Corners and open nodes of the rows by which these stay open."""
        return ruling(-self._task.loads.w0, -self._task.loads.w1, None if np.isnan(self._given) else self._given)

    def pressed(self, rows: Rows) -> Array | None:
        """(K, O) forces that keep open nodes from touching: multipliers of their rows, at the corners that rule them."""
        lift, w1 = self._task.lift, self._task.loads.w1
        if lift is None:
            return None
        press, (corner, node) = np.zeros(w1.shape), self._closing
        press[corner, node] = np.maximum(rows["stays_open"].dual_value, 0.0) / self._room(lift)[node]
        return press

    def held(self, rows: Rows) -> Array | None:
        """(N,) or (N, 2) forces by which the slip bound holds the nodes, along the tangents: multipliers of its rows."""
        if self._most is None:
            return None
        if "forward_slip_bound" in rows:
            forward, backward = (np.maximum(rows[f"{way}_slip_bound"].dual_value, 0.0) for way in ("forward", "backward"))
            return np.asarray((forward - backward) / self._reach)
        held = np.zeros((len(self._most), 2))
        if "slip_bound" in rows:
            held[self._most > 0] = -rows["slip_bound"].dual_value[1]
        if "no_slip" in rows:
            held[self._most == 0] = rows["no_slip"].dual_value
        return held / self._reach[:, None]


class Intervals(SafeSet):
    """The safe slips of a contact in the plane, by the rows of the corners that rule; friction and loads are parameters, the matrices are not.

    The corners of one row differ only in the coefficient of `lam >= 0`, so the largest one rules and stands for all of them::

        forward = max_k -(q1_k + f p1_k),   backward = max_k (q1_k - f p1_k),   opening = max_k -p1_k

    Where a part of the cycle is fixed, they differ in the constant too, and few of them rule, see `ruling`: loads are constants then. `p >= 0`
    follows from the other two where there is friction; for little or none, `no_opening` keeps its rows.

    Attributes
    ----------
    q, p, fp
        (N,) shear force q0 + A v, normal force p0 + B v and friction bound f (p0 + B v) of the nodes under the mean load, with what a design adds,
        cvxpy expressions.
    forward, backward, opening
        (N,) cyclic load at the corners that rule the rows, see `ruling_loads`.
    """

    def __init__(self, task: LimitQuestion, design: DesignLoads | None = None) -> None:
        super().__init__(task, design)
        n, pressed = len(task.friction), self.pressure
        self._set = {name: cp.Parameter(n, name=name) for name in ("q_mean", "p_mean", "fp_mean", "forward", "backward", "opening")}
        self._set |= {name: cp.Parameter(n, name=name, nonneg=True) for name in ("friction", "clearance")}
        self.q, self.p = self._set["q_mean"] + self.shear, self._set["p_mean"] + pressed
        self.fp = self._set["fp_mean"] + cp.multiply(self._set["friction"], pressed)
        self.forward, self.backward, self.opening = (self._set[name] for name in ("forward", "backward", "opening"))

    def _stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None, spare: cp.Parameter | float) -> Rows:
        """See `SafeSet.stuck`. A given load factor stands in the parameters."""
        if self._task.loads.fixed:
            return self._of_corners(load_factor, margin)
        lam, reserve = 1.0 if load_factor is None else load_factor, (0.0 if margin is None else cp.multiply(self._set["clearance"], margin)) - spare
        rows = {
            "no_forward_slip": self.q + self.fp >= self.forward * lam + reserve,
            "no_backward_slip": self.fp - self.q >= self.backward * lam + reserve,
        }
        return rows | {"no_opening": self.p >= self.opening * lam + reserve} if self._task.opening else rows

    def _of_corners(self, load_factor: cp.Variable | None, margin: cp.Variable | None) -> Rows:
        """The rows of a cycle of which a part is fixed."""
        task, unit, shear, pressed = self._task, self.scaled.unit, self.shear, self.pressure
        lam = self._given if load_factor is None else task.load_unit * load_factor
        rows: dict[str, cp.Constraint] = {}
        for (name, (sense, weight, constant, rate)), at in zip(_slacks(task).items(), self._ruling, strict=True):
            node, reserve = at[1], 0.0 if margin is None else task.mean_bound / unit[at[1]] * margin
            slack = sense * shear[node] + cp.multiply(weight[node], pressed[node]) + constant[at] / unit[node] + lam * (rate[at] / unit[node])
            rows |= {name: slack >= reserve} if task.opening or name != "no_opening" else {}
        return rows

    def ask(self, task: LimitQuestion, load_factor: float | None = None) -> None:
        """See `SafeSet.ask`."""
        super().ask(task, load_factor)
        if task.loads.fixed:
            self._ruling = tuple(ruling(-constant, -rate, load_factor) for *_, constant, rate in _slacks(task).values())
            return
        values, self._ruling = ruling_loads(self.scaled.unit, task)
        factor = 1.0 if load_factor is None else load_factor / task.load_unit
        for name, parameter in self._set.items():
            parameter.value = values[name] * (factor if name in ("forward", "backward", "opening") else 1.0)

    def motion(self, rows: Rows) -> tuple[Mechanism, Array]:
        """See `SafeSet.motion`. A node that slips to and fro at one corner opens by friction times that."""
        motions = np.zeros((3, *self._task.loads.q1.shape))
        for motion, name, (corner, node) in zip(motions, ("no_forward_slip", "no_backward_slip", "no_opening"), self._ruling, strict=True):
            if name in rows:
                motion[corner, node] = np.maximum(rows[name].dual_value, 0.0) / self.scaled.unit[node]
        forward, backward, opening = motions
        opening = opening + self._task.friction * 2 * np.minimum(forward, backward)
        return Mechanism(forward - backward, opening, self._task.friction, self.held(rows), self.pressed(rows)), motions.sum(axis=(0, 1))

    @property
    def narrows(self) -> bool:
        """See `SafeSet.narrows`."""
        names = ("forward", "backward", *(["opening"] if self._task.opening else []))
        if self._task.loads.fixed:
            return False
        return all((self._set[name].value >= 0).all() for name in names) and bool((self._task.loads.w1.min(axis=0) <= 0).all())

    @property
    def left_out(self) -> tuple[str, ...]:
        """See `SafeSet.left_out`."""
        corners = len(self._task.loads.q1)
        idle = corners - len(np.union1d(*(corner for corner, _ in self._ruling[:2])))
        return (f"corners: {idle} of {corners} rule no node",) if idle else ()


def _slacks(task: LimitQuestion) -> dict[str, tuple[float, Array, Array, Array]]:
    """Slacks `sense q + weight p` of the rows of all corners: sense, weight (N,), and the slack (K, N) at load factor 0 and its rate."""
    loads, f = task.loads, task.friction
    kinds = {"no_forward_slip": (1.0, f), "no_backward_slip": (-1.0, f), "no_opening": (0.0, np.ones_like(f))}
    return {
        name: (sense, weight, sense * loads.q0 + weight * loads.p0, sense * loads.q1 + weight * loads.p1) for name, (sense, weight) in kinds.items()
    }
