"""The cone programs over safe residual slips: unknowns, friction circles, and the values of a solution.

A residual slip v is safe at a load factor when it keeps every node closed and stuck at every corner of the load cycle. The unknowns are the shear
forces `A v` that it causes, in units in which neither they nor their pressures are large; they fix the pressures `B v = G t`, through one dense block
for all corners. All is dimensionless, see `ScaledCones`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cvxpy as cp
import numpy as np

from .polish import ConeForm, Point, first_of, on_active_cones
from .scaling import ScaledCones

__all__ = ["ConeProgram", "margin_cones", "shakedown_cones"]


def shakedown_cones(c: ScaledCones, sense: int = 1) -> "ConeProgram":
    """Largest load factor lam at which some residual slip v keeps every node closed and stuck at every corner k of the load cycle.

    In full, for all corners (with sense -1 the least one, `min lam`)::

        max lam   s.t.   |q_k| <= f p_k   where   q_k = q0 + lam q1_k + A v,   p_k = p0 + lam p1_k + B v

    No corner rules the others: each keeps its circles. `p_k >= 0` follows where there is friction; for little or none it is a row of its own.
    Where the bound `f p_k` vanishes whatever the slip, the circle is the point `q_k = 0`, the same for all corners: with shears that differ between
    them there is no limit above 0, see `ConeQuestion.stop`.
    """
    lam, traction, pressure = (
        cp.Variable(name="load_factor"),
        cp.Variable((c.nodes, 2), name="traction"),
        cp.Variable(c.nodes, name="pressure_change"),
    )
    rows, shear = _slip_rows(c, traction, pressure), cp.multiply(c.tangential, traction)
    for k in range(c.corners):
        q, p = c.q0 + lam * c.q1[k] + shear, c.p0 + lam * c.p1[k] + pressure
        rows |= _circle_rows(c, k, q, p, 0.0, c.bare)
    rows["load_factor_not_negative"] = lam >= 0
    caps = {"load_factor_not_negative": (-np.ones(1), 0.0)}
    form = ConeForm(np.array([float(sense)]), c.mean_q, c.mean_p, c.q1[None], c.p1[None], np.zeros((1, c.nodes)), caps, c.bare)
    return _program(c, cp.Maximize(lam) if sense > 0 else cp.Minimize(lam), rows, form, ("load_factor",))


def margin_cones(c: ScaledCones, load_factor: float | None, mean: float = 1.0) -> "ConeProgram":
    """Residual slip v that stays furthest inside the friction circles, at a given load factor lam or (None) at whatever one is best.

    In full, with the margin counted in mean friction bounds of the mean load, each `clearance` of its node::

        max margin   s.t.   f p_k - |q_k| >= clearance margin,   margin <= 1   where   q_k = q0 + lam q1_k + A v,   p_k = p0 + lam p1_k + B v

    Negative: there is no safe slip. The mean load may be left out (`mean` = 0): what is safe then is so at every load factor.
    """
    margin, traction, pressure = cp.Variable(name="margin"), cp.Variable((c.nodes, 2), name="traction"), cp.Variable(c.nodes, name="pressure_change")
    lam = cp.Variable(name="load_factor") if load_factor is None else load_factor
    none = np.zeros_like
    bare = none(c.bare)  # a negative margin opens every circle
    rows, shear = _slip_rows(c, traction, pressure), cp.multiply(c.tangential, traction)
    for k in range(c.corners):
        q, p = mean * c.q0 + lam * c.q1[k] + shear, mean * c.p0 + lam * c.p1[k] + pressure
        rows |= _circle_rows(c, k, q, p, c.clearance * margin, bare)
    rows["cap"] = margin <= 1
    given = load_factor or 0.0
    q, p = mean * c.mean_q + given * c.q1, mean * c.mean_p + given * c.p1
    if load_factor is not None:
        form = ConeForm(np.ones(1), q, p, none(c.q1)[None], none(c.p1)[None], c.clearance[None], {"cap": (np.ones(1), 1.0)}, bare)
        return _program(c, cp.Maximize(margin), rows, form, ("margin",))
    rows["load_factor_not_negative"] = lam >= 0
    reserve, caps = np.array([c.clearance, none(c.clearance)]), {"cap": (np.eye(2)[0], 1.0), "load_factor_not_negative": (-np.eye(2)[1], 0.0)}
    form = ConeForm(np.eye(2)[0], q, p, np.array([none(c.q1), c.q1]), np.array([none(c.p1), c.p1]), reserve, caps, bare)
    return _program(c, cp.Maximize(margin), rows, form, ("margin", "load_factor"))


def _slip_rows(c: ScaledCones, traction: cp.Variable, pressure: cp.Variable) -> dict[str, cp.Constraint]:
    """What slips can do: their pressures follow from their tractions, which do no work on a rigid slide."""
    of_slip = cp.vec(traction, order="F")
    rows: dict[str, cp.Constraint] = {"pressures_of_slip": c.G @ of_slip == pressure}
    return rows if not c.balance.size else rows | {"no_force_on_rigid_slides": c.balance @ of_slip == 0}


def _circle_rows(c: ScaledCones, k: int, q: Any, p: Any, reserve: Any, bare: np.ndarray) -> dict[str, cp.Constraint]:
    """The circles of corner k; where they are points, the first corner keeps the shear at zero, and with it all others."""
    bound, circles, points = cp.multiply(c.friction, p) - reserve, np.flatnonzero(~bare[k]), np.flatnonzero(first_of(bare)[k])
    rows: dict[str, cp.Constraint] = {f"friction_circle_{k}": cp.SOC(bound[circles], q[circles], axis=1)} if len(circles) else {}
    rows |= {f"no_shear_{k}": q[points] == 0} if len(points) else {}
    return rows | {f"no_opening_{k}": p >= reserve} if c.opening else rows


@dataclass(frozen=True, eq=False)
class ConeProgram:
    """A cvxpy problem over safe slips with its data as arrays; `refine` and solving change the values that stand in the cvxpy problem."""

    problem: cp.Problem
    cones: ScaledCones
    form: ConeForm
    scalars: tuple[str, ...]

    @property
    def point(self) -> Point:
        """Variables and multipliers that stand in the problem, the multipliers made admissible."""
        values, c, rows = self.problem.var_dict, self.cones, self._rows
        force, slips, opening = np.zeros(c.p1.shape), np.zeros(c.q1.shape), np.zeros(c.p1.shape)
        for k, circles, points in self._places:
            if circles.any():
                force[k, circles], slips[k, circles] = rows[f"friction_circle_{k}"].dual_value
            if points.any():
                slips[k, points] = -rows[f"no_shear_{k}"].dual_value
                force[k, points] = np.linalg.norm(slips[k, points], axis=-1)
            if c.opening:
                opening[k] = np.maximum(rows[f"no_opening_{k}"].dual_value, 0.0)
        return Point(
            x=np.array([float(values[name].value) for name in self.scalars]),
            traction=np.asarray(values["traction"].value).ravel(order="F"),
            slips=slips,
            force=force,
            opening=opening,
            caps={name: max(float(rows[name].dual_value), 0.0) for name in self.form.caps},
        )

    def refine(self) -> None:
        """Move the solution that stands in the problem onto its active cones, see `on_active_cones`."""
        point, values, rows, c = on_active_cones(self.cones, self.form, self.point), self.problem.var_dict, self._rows, self.cones
        for name, value in zip(self.scalars, point.x, strict=True):
            values[name].save_value(np.array(value))
        values["traction"].save_value(point.traction.reshape(c.nodes, 2, order="F"))
        values["pressure_change"].save_value(c.G @ point.traction)
        for k, circles, points in self._places:
            if circles.any():
                for variable, value in zip(rows[f"friction_circle_{k}"].dual_variables, (point.force[k], point.slips[k]), strict=True):
                    variable.save_value(value[circles])
            if points.any():
                rows[f"no_shear_{k}"].dual_variables[0].save_value(-point.slips[k, points])
            if c.opening:
                rows[f"no_opening_{k}"].dual_variables[0].save_value(point.opening[k])
        for name, value in point.caps.items():
            rows[name].dual_variables[0].save_value(np.array(value))

    @property
    def _places(self) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
        """Each corner, with the nodes that have a circle at it and those whose shear it keeps at zero."""
        bare = self.form.bare
        return zip(range(self.cones.corners), ~bare, first_of(bare), strict=True)

    @cached_property
    def _rows(self) -> Mapping[str, cp.Constraint]:
        return {row.label: row for row in self.problem.constraints}


def _program(
    c: ScaledCones, goal: cp.Maximize | cp.Minimize, rows: Mapping[str, cp.Constraint], form: ConeForm, scalars: tuple[str, ...]
) -> ConeProgram:
    return ConeProgram(cp.Problem(goal, [row.set_label(name) for name, row in rows.items()]), c, form, scalars)
