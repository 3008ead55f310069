"""The programs over safe residual slips: unknowns and units, the rows that keep a contact stuck, and what stands in a solution.

A residual slip v is safe at a load factor when it keeps every node closed and stuck at every corner of the load cycle. In the plane few corners rule
each end of a node's friction interval, see `Intervals`; in space each corner has a circle of its own at each node, see `Circles`. The rest is the
same for both.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from copy import copy
from functools import cached_property
from typing import Any, Self, TypeAlias

import cvxpy as cp
import numpy as np
from scipy.linalg import qr, svd
from scipy.optimize import nnls
from scipy.sparse import csr_array

from ..contact import CONDENSATION, RESIDUAL, Array, Integers, lengths
from ..solve.explain import Units
from .answered import Mechanism
from .design_result import DesignLoads
from .own_rows import OwnRows
from .question import LimitQuestion, rigid_slides

Rows: TypeAlias = Mapping[str, cp.Constraint]
Ruling: TypeAlias = tuple[Integers, Integers]

_NO_PRESSURE = 1e3 * RESIDUAL  # rows are scaled by the pressure of their node unless it is below this share of the mean one: an answer has its error


class SafeSet(ABC):
    """Unknowns of a residual slip v, the rows by which it is safe, and a program over them.

    Slips of a graded mesh span decades and A may be singular (a punch that only its loads hold), so the m unknowns are dimensionless
    tractions t: `v = to_slip t`, `A v = unit * (to_shear t)`, `B v = unit * (to_pressure t)`, ordered by component. They are nodal forces over the
    unit of the node, or over the pressure that they make where that is larger.

    Parameters
    ----------
    task
        The contact, its loads and its slip bound `|v| <= most`; friction is set by `ask`.
    design
        Loads of the mean state that are unknowns too; None for none.

    Attributes
    ----------
    unit
        (N,) force unit of each node: its pressure under the mean load, or what else acts on it.
    to_slip, to_shear, to_pressure
        (t N, m) slip for unit tractions, length; (t N, m), sparse, and (N, m), dimensionless, at most 1.
    rigid
        (t N, k) slips that need no force, length; k is 0 where there are none.
    loaded, size
        (m,) row of `to_shear` that each traction acts on alone, and its entry there.
    traction, slides
        The unknowns: nodal tractions; and rigid slides, with their slips, length, and the gaps (O, k) that they open, length. Slides apart that open
        none (None): no row feels them but those that bound the slip, where rounding would let them go as far as it makes gaps of them.
    shear, pressure
        (t N,) and (N,) what slip and design add to the shear and normal forces, in the units of the nodes, affine cvxpy expressions.
    load_factor, margin
        Unknowns of the programs that have them.
    problem, rows, own
        The program, see `posed`, its rows by their names, and those of the user's own in it.
    parameters
        Those of the rows by their names, where friction and loads are parameters.
    units
        Units of the unknowns, and of an objective of the user's own.
    idle
        What corners have no rows, in words; empty where all have. Known once the rows are listed.
    """

    problem: cp.Problem
    rows: Rows
    units: Units
    idle: str
    _given: float | None

    def __init__(self, task: LimitQuestion, design: DesignLoads | None = None) -> None:
        self.task, self.design, self.rows, self.own, self.parameters = task, design, {}, OwnRows(), dict[str, cp.Parameter]()
        (sheared, swung), (held, pressed) = ((np.linalg.norm(r[:, :-1], axis=1), np.abs(r[:, -1])) for r in (task.r1, task.r0))
        pressure, acts = pressed.max(axis=0), np.maximum(held.max(axis=0), np.maximum(sheared, swung).max(axis=0))
        self.unit = np.where(pressure > _NO_PRESSURE * task.force, pressure, np.maximum(acts, _NO_PRESSURE * task.force))
        rigid, compliance = rigid_slides(task)
        each = np.tile(self.unit, task.system.tangents)[:, None]
        modes, resting = rigid.shape[1], each * rigid
        pivots = qr(resting.T, mode="r", pivoting=True)[1] if modes else np.arange(len(each))
        balancing, self.loaded = pivots[:modes], np.sort(pivots[modes:])
        basis = np.zeros((len(each), len(self.loaded)))  # unit tractions, balanced by those at as many rows as there are rigid slips
        basis[self.loaded, np.arange(len(self.loaded))] = 1.0
        basis[balancing] = -np.linalg.solve(resting[balancing].T, resting[self.loaded].T)
        forces = csr_array(each * basis)
        slip = (forces.T @ compliance).T
        normal = task.AB[len(each) :] @ slip / self.unit[:, None]
        self.size = 1 / np.maximum(np.abs(normal).max(axis=0), 1.0)
        self.to_slip, self.to_shear, self.to_pressure = slip * self.size, csr_array(basis * self.size), normal * self.size
        self.traction, self.rigid = cp.Variable(len(self.loaded), name="traction"), rigid * (task.force / (task.stiffness[: len(rigid)] @ rigid**2))
        self.slides: list[tuple[Array, Array | None, cp.Variable]] = [(self.rigid, None, cp.Variable(modes, name="slide"))] if modes else []
        if modes and task.lift is not None:
            self.slides = self._parted(task.lift)
        self.shear, self.pressure = self.to_shear @ self.traction, self.to_pressure @ self.traction
        if design is not None:
            forces = design.forces(self.unit)
            self.shear, self.pressure = self.shear + forces[: len(each)], self.pressure + forces[len(each) :]
        self.load_factor, self.margin = cp.Variable(name="load_factor"), cp.Variable(name="margin")

    @abstractmethod
    def stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None = None, spare: cp.Parameter | float = 0.0) -> Rows:
        """Rows by which every node is closed and stuck at every corner, or stays open, with a margin in mean friction bounds (None: no margin).

        A load factor of None is the given one. The rows of a node are loose by its part of `spare`, (N,), in the units of the nodes; not of a cycle
        of which a part is fixed.
        """

    @abstractmethod
    def ask(self, task: LimitQuestion, load_factor: float | None = None) -> None:
        """Set friction, loads, and the load factor where it is given."""

    def helpless(self) -> tuple[Mechanism, str] | None:
        """A motion that no slip helps against at any load factor above 0, and why; None where nothing is so plain, or programs find it."""
        return None

    @abstractmethod
    def motion(self) -> tuple[Mechanism, Array]:
        """The mechanism that the multipliers of the rows stand for, and (K, N) those of the friction bounds, in units of 1 over force.

        These are the sizes of its slips, or more: where a node without shear is on its bounds all around, they balance each other.
        """

    def program(self, goal: cp.Maximize | cp.Minimize, rows: Rows) -> cp.Problem:
        """A problem of the rows by their names, and those of the slip bound."""
        bounded = {} if self.task.most is None else self._bounded(self.task.most)
        return cp.Problem(goal, [row.set_label(name) for name, row in {**rows, **bounded}.items()])

    def posed(self, problem: cp.Problem, own: OwnRows | None = None) -> Self:
        """The same unknowns and what was asked, with a program over them."""
        posed, task, own = copy(self), self.task, own or OwnRows()
        posed.problem, posed.rows, posed.own = problem, {row.label: row for row in problem.constraints}, own
        forces = {"margin": task.mean_bound, "traction": self.unit[self.loaded % len(self.unit)] * self.size}
        designed = {} if self.design is None else {"design": self.design.unit}
        posed.units = {"load_factor": task.load_unit, "objective": own.objective_unit or task.load_unit, **forces, **designed}
        return posed

    def _parted(self, lift: Array) -> list[tuple[Array, Array | None, cp.Variable]]:
        """The slides that open gaps apart from those that do not, see the attribute."""
        turned = self.rigid @ svd(lift @ self.rigid)[2].T
        gaps = lift @ turned
        opening = np.abs(gaps).max(axis=0) > CONDENSATION * np.abs(turned).max(axis=0)
        aside, opens = np.flatnonzero(~opening), np.flatnonzero(opening)
        parts = (("slide", aside, None), ("opening_slide", opens, gaps[:, opens]))
        return [(turned[:, which], made, cp.Variable(len(which), name=name)) for name, which, made in parts if len(which)]

    @property
    def slip(self) -> cp.Expression:
        """(t N,) slip by component, length, an affine cvxpy expression."""
        return sum((part @ slide for part, _, slide in self.slides), self.to_slip @ self.traction)

    @property
    def solved_slip(self) -> Array:
        """(N,) or (N, 2) slip of the solution, within its bound."""
        slip, most = self.to_slip @ self.traction.value, self.task.most
        for part, opens, slide in self.slides:
            if slide.value is not None:
                slip = slip + part @ (np.asarray(slide.value) if opens is None else self._slid(opens, slide))
        slip = slip.reshape((-1, *self.task.system.slip_shape[1:]), order="F")
        if most is None:
            return np.asarray(slip)
        slip[most == 0] = 0.0
        if self.task.beyond(slip) > RESIDUAL:
            return np.asarray(slip)
        size = lengths(slip, most)  # cut to the bound that it exceeds by no more than the tolerance of solvers
        return np.asarray(np.where(size > most, slip.T / np.where(size > 0, size, 1.0) * most, slip.T).T)

    def _slid(self, opens: Array, slide: cp.Variable) -> Array:
        """The slide of the solution; where the gaps of open nodes alone feel it, the smallest one, for interior points go as far as gaps grow."""
        row, found = self.rows["stays_open"], np.asarray(slide.value)
        if self.own.rows or self.task.most is not None:
            return found
        slide.save_value(np.zeros(len(found)))
        opens, lack = (opens / self._room[:, None])[self._closing[1]], row.expr.value - RESIDUAL / 10
        columns, last = np.vstack([opens.T, lack]), np.eye(len(found) + 1)[-1]
        *way, share = columns @ nnls(columns, last)[0] - last  # the problem of least distance of Lawson & Hanson
        with np.errstate(divide="ignore", invalid="ignore"):
            least = -np.array(way) / share
            slide.save_value(least if (opens @ least >= lack - RESIDUAL / 10).all() else found)
        return np.asarray(slide.value)

    @property
    def solved_load_factor(self) -> float:
        """The load factor of the solution, >= 0."""
        return max(0.0, float(self.load_factor.value) * self.task.load_unit)  # in this order -0 becomes 0

    def cap(self, name: str) -> float:
        """Multiplier of a named scalar row."""
        return max(float(self.rows[name].dual_value), 0.0)

    @cached_property
    def _reach(self) -> Array:
        """(N,) slip that unit unknowns make at most, by which the rows of the slip bound are divided, length."""
        norms = np.linalg.norm(np.hstack([self.to_slip, self.rigid]), axis=1)
        return np.asarray(norms.reshape(-1, len(self.unit)).max(axis=0))

    def _bounded(self, most: Array) -> Rows:
        """Rows of the slip bound, in units of `_reach`."""
        nodes, most = len(self._reach), most / self._reach
        slip = cp.multiply(1 / np.resize(self._reach, self.slip.size), self.slip)
        if slip.size == nodes:
            return {"forward_slip_bound": slip <= most, "backward_slip_bound": slip >= -most}
        slip, free, fixed = cp.reshape(slip, (nodes, 2), order="F"), np.flatnonzero(most > 0), np.flatnonzero(most == 0)
        rows: dict[str, cp.Constraint] = {"slip_bound": cp.SOC(cp.Constant(most[free]), slip[free], axis=1)} if len(free) else {}
        return rows | {"no_slip": slip[fixed] == 0} if len(fixed) else rows

    def _apart(self, lift: Array, load_factor: cp.Variable | None, margin: cp.Variable | None) -> Rows:
        """Rows by which open nodes stay open, at the corners that rule them; gaps are divided by what unit unknowns and loads make of them."""
        task = self.task
        self._closing = corner, node = ruling(-task.w0, -task.w1, self._given)
        gaps = [(lift @ self.to_slip, self.traction), *((opens, slide) for _, opens, slide in self.slides if opens is not None)]
        of_slip = np.abs(np.hstack([by for by, _ in gaps])).max(axis=1, initial=0.0)
        room = np.max([of_slip, np.abs(task.w0).max(axis=0), task.load_unit * np.abs(task.w1).max(axis=0)], axis=0)
        self._room = np.where(room > 0, room, task.clearance)
        room = self._room[node]
        lam: Any = self._given if load_factor is None else task.load_unit * load_factor
        reserve = 0.0 if margin is None else task.clearance / room * margin
        w0 = np.broadcast_to(task.w0, task.w1.shape)
        gap = w0[corner, node] / room + lam * (task.w1[corner, node] / room) + sum((by[node] / room[:, None]) @ unknown for by, unknown in gaps)
        return {"stays_open": gap >= reserve}

    def held(self) -> tuple[Array | None, Array | None]:
        """Multipliers of the slip bound and of gaps: forces by which it holds nodes, (t, N), and that keep open nodes from touching, (K, O).

        None without a bound, or without open nodes.
        """
        most, held, press = self.task.most, None, None
        if self.task.lift is not None:
            press, (corner, node) = np.zeros(self.task.w1.shape), self._closing
            press[corner, node] = np.maximum(self.rows["stays_open"].dual_value, 0.0) / self._room[node]
        if "forward_slip_bound" in self.rows:
            forward, backward = (np.maximum(self.rows[f"{way}_slip_bound"].dual_value, 0.0) for way in ("forward", "backward"))
            held = np.asarray((forward - backward) / self._reach)[None]
        elif most is not None:
            held = np.zeros((len(most), 2))
            if "slip_bound" in self.rows:
                held[most > 0] = -self.rows["slip_bound"].dual_value[1]
            if "no_slip" in self.rows:
                held[most == 0] = self.rows["no_slip"].dual_value
            held = held.T / self._reach
        return held, press


def ruling(constant: Array, rate: Array, load_factor: float | None = None) -> Ruling:
    """(R,) corners and nodes of the rows that rule `x >= constant_k + lam rate_k` at a load factor >= 0, or (None) at some load factor >= 0.

    `constant` is (K, N), or (1, N) where the corners of a node differ only in the coefficient of the load factor: then the largest one rules. Else
    the largest row is a chain of straight lines, from corner to corner of larger rates.
    """
    every = np.arange(rate.shape[1])
    if len(constant) == 1:
        return rate.argmax(axis=0), every
    if load_factor is not None:
        return (constant + load_factor * rate).argmax(axis=0), every
    highest = constant == constant.max(axis=0)
    corner, node = np.where(highest, rate, -np.inf).argmax(axis=0), every
    rows = [(corner, node)]
    while node.size:
        gain, lead = rate[:, node] - rate[corner, node], constant[corner, node] - constant[:, node]
        meets = np.where(gain > 0, lead / np.where(gain > 0, gain, 1.0), np.inf)
        corner, further = meets.argmin(axis=0), np.isfinite(meets.min(axis=0))
        corner, node = corner[further], node[further]
        rows.append((corner, node))
    corners, nodes = (np.concatenate(part) for part in zip(*rows, strict=True))
    return corners, nodes
