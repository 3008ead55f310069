"""The cone programs over safe residual slips: unknowns, friction circles, and the values of a solution.

A residual slip v is safe at a load factor when it keeps every node closed and stuck at every corner of the load cycle. The unknowns are the shear
forces `A v` that it causes, in units in which neither they nor their pressures are large; they fix the pressures `B v = G t`, through one dense block
for all corners. All is dimensionless, see `ScaledCones`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import cvxpy as cp
import numpy as np

from .cone_polish import ConeForm, Point, first_of, on_active_cones
from .cone_scaling import ScaledCones

__all__ = ["Circles", "ConeProblem"]


class Circles:
    """Unknowns of a residual slip v in space, and the rows that keep its reactions within the friction circles.

    No corner rules the others: each has circles of its own. `p_k >= 0` follows where there is friction; for little or none it is a row of its own.
    Where the bound `f p_k` vanishes whatever the slip, the circle is the point `q_k = 0`, the same for all corners: with shears that differ between
    them there is no limit above 0, see `SpaceQuestion.stop`. A margin opens every circle.

    Parameters
    ----------
    c
        The contact.
    given
        The load factor, dimensionless, where it is no unknown.
    """

    def __init__(self, c: ScaledCones, given: float | None) -> None:
        self._c, self._given, self._margin = c, given, False
        self.traction, self.pressure = cp.Variable((c.nodes, 2), name="traction"), cp.Variable(c.nodes, name="pressure_change")

    def stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None = None) -> dict[str, cp.Constraint]:
        """Rows by which every node is closed and stuck at every corner, with a margin in mean friction bounds; None: no margin."""
        c, lam = self._c, self._given if load_factor is None else load_factor
        self._margin = margin is not None
        rows, shear = _slip_rows(c, self.traction, self.pressure), cp.multiply(c.tangential, self.traction)
        for k in range(c.corners):
            q, p = c.q0 + lam * c.q1[k] + shear, c.p0 + lam * c.p1[k] + self.pressure
            rows |= _circle_rows(c, k, q, p, 0.0 if margin is None else c.clearance * margin, self._bare)
        return rows

    def problem(self, goal: cp.Maximize | cp.Minimize, rows: Mapping[str, cp.Constraint]) -> "ConeProblem":
        """The rows by their names, with the same program as arrays."""
        c, given, named = self._c, self._given or 0.0, [row.set_label(name) for name, row in rows.items()]
        problem = cp.Problem(goal, named)
        scalars = tuple(name for name in ("margin", "load_factor") if name in problem.var_dict)
        of = dict(zip(scalars, np.eye(len(scalars)), strict=True))
        caps = {"cap": (of.get("margin"), 1.0), "load_factor_not_negative": (-of.get("load_factor", np.zeros(1)), 0.0)}
        sense = -1.0 if isinstance(goal, cp.Minimize) else 1.0
        at = {"margin": (0.0, 1.0), "load_factor": (1.0, 0.0)}
        form = ConeForm(
            goal=sense * np.eye(len(scalars))[0],
            q_given=c.mean_q + given * c.q1,
            p_given=c.mean_p + given * c.p1,
            q_rate=np.array([at[name][0] * c.q1 for name in scalars]),
            p_rate=np.array([at[name][0] * c.p1 for name in scalars]),
            reserve=np.array([at[name][1] * c.clearance for name in scalars]),
            caps={name: (row, right) for name, (row, right) in caps.items() if name in rows and row is not None},
            bare=self._bare,
        )
        return ConeProblem(problem, c, form, scalars)

    @property
    def _bare(self) -> np.ndarray:
        return np.zeros_like(self._c.bare) if self._margin else self._c.bare


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
class ConeProblem:
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

    @cached_property
    def downward(self) -> "ConeProblem":
        """The program of the least load factor under the same rows."""
        problem = cp.Problem(cp.Minimize(self.problem.var_dict["load_factor"]), self.problem.constraints)
        return replace(self, problem=problem, form=replace(self.form, goal=-self.form.goal))

    @property
    def _places(self) -> Iterator[tuple[int, np.ndarray, np.ndarray]]:
        """Each corner, with the nodes that have a circle at it and those whose shear it keeps at zero."""
        bare = self.form.bare
        return zip(range(self.cones.corners), ~bare, first_of(bare), strict=True)

    @cached_property
    def _rows(self) -> Mapping[str, cp.Constraint]:
        return {row.label: row for row in self.problem.constraints}
