"""A program and all that is needed to solve it: unknowns, friction, rows, units, user rows.

`listed_rows` lists the rows of a question, `Program.compiled` compiles them with a goal. After a
solution `Program` reads the load factor, the slip and the mechanism. `labelled_rows` checks the
constraints of the user.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any
from weakref import WeakKeyDictionary

import cvxpy as cp
import numpy as np
from cvxpy.reductions.dcp2cone.dcp2cone import Dcp2Cone
from scipy.optimize import nnls
from scipy.sparse import issparse
from scipy.spatial import ConvexHull, QhullError

from ..base import CONDENSATION, RESIDUAL, ROUNDING, ZERO_LOAD_FACTOR, Array, shown
from ..contact import ContactSystem, LoadCycle, lengths
from ..errors import ModelError
from ..solve.chain import Chain
from ..solve.compiled import Change, by_inverse
from ..solve.problem import Problem, dual_of, set_no_optimum
from ..solve.unresisted import unresisted
from .answered import Mechanism
from .load_parameters import LoadParameters
from .models import More, Row, Unknowns, constant, label, rest, stuck, unknowns, within
from .question import Question

# The free slips of the open nodes that were asked last, by system.
_FREE: WeakKeyDictionary[ContactSystem, dict[bytes, tuple[Array, Array]]] = WeakKeyDictionary()


def free_slips(question: Question) -> tuple[Array, Array]:
    """Slips (t N, k) that nothing resists, and the compliance (t N, t N) of all other slips."""
    by_open_nodes = _FREE.setdefault(question.system, {})
    # The arrays of moving areas are those of the closed contact, whichever nodes never press.
    key = b"" if question.compliance is None else question.open_nodes.tobytes()
    if key not in by_open_nodes:
        stiffness = np.sqrt(question.system.own_stiffness)
        along, across = np.split(stiffness, [-question.system.nodes])
        by_open_nodes.clear()
        by_open_nodes[key] = unresisted(question.A, question.B, along, across)
    return by_open_nodes[key]


def is_held(question: Question) -> bool:
    """Whether every slip meets a resistance: supports hold the bodies along the contact."""
    return not free_slips(question)[0].size


def tractions(question: Question, dense: Sequence[Row] | None = None) -> Change:
    """Change of variables for the dense rows q_r = A v, p_r = B v, w_r = W v.

    The unknowns are the residual shear forces and the rigid slides that nothing resists.
    """
    system = question.system
    free, compliance = free_slips(question)
    if dense is None:
        dense = rest(question, unknowns(system.slip_shape, ()), ())
    slide_units = question.force / (system.own_stiffness[: len(free)] @ free**2)
    shear_units = np.tile(question.shear_unit, system.tangents)
    return by_inverse(dense[0], dense[1:], free, compliance, shear_units, slide_units)


@dataclass(eq=False)
class Program:
    """The program of a question: its rows, and once compiled with a goal the way to its answer."""

    question: Question
    x: Unknowns
    f: cp.Parameter
    corners: list[int]  # those that have rows
    rows: list[Row]  # without constraints of the user
    # The loads, if they are parameters.
    loads: LoadParameters | None = None
    user_rows: Mapping[str, Row] = field(default_factory=dict)  # by label
    chain: Chain = field(init=False)

    def compiled(
        self,
        problem: cp.Problem,
        unit: float,
        units: Mapping[cp.Variable, Any] | None = None,
        others: Sequence["Program"] = (),
    ) -> "Program":
        """Compile a goal over the rows of this program and of other programs.

        `unit` is the unit of the objective; `units` are the units of variables that the program
        itself does not have.
        """
        problem = Problem(problem.objective, [*problem.constraints, *self.user_rows.values()])
        by_slip = dict[cp.Variable, list[Program]]()
        for program in (self, *others):
            by_slip.setdefault(program.x.slip, []).append(program)
        changes = []
        for same_slip in by_slip.values():
            dense = [row for program in same_slip for row in program.dense]
            changes.append(tractions(same_slip[0].question, dense))
        all_units = {**self.units, **(units or {})}
        self.chain = Chain(problem, all_units, changes, self.question.simplify, unit)
        return self

    @property
    def dense(self) -> list[Row]:
        """The rows that give the forces and gaps of a slip."""
        return self.rows[: 3 if len(self.question.W) else 2]

    @property
    def problem(self) -> cp.Problem:
        """The cvxpy problem."""
        return self.chain.problem

    @property
    def units(self) -> dict[cp.Variable, Any]:
        """Units of the unknowns."""
        question = self.question
        x = self.x
        system = question.system
        shear = question.shear_unit
        if system.tangents > 1:
            shear = shear[:, None]
        slip = np.tile(question.shear_unit, system.tangents)
        slip = slip / system.own_stiffness[: -system.nodes]
        units: dict[cp.Variable, Any] = {
            x.slip: slip.reshape(x.slip.shape, order="F"),
            x.q_r: shear,
            x.p_r: question.node_unit,
        }
        if isinstance(x.load_factor, cp.Variable):
            units[x.load_factor] = question.load_unit
        units |= dict.fromkeys(x.q.values(), shear)
        units |= dict.fromkeys(x.p.values(), question.node_unit)
        units |= dict.fromkeys(x.gap.values(), question.clearance)
        return units

    def set_question(self, question: Question, unit: float) -> None:
        """Set friction, the units that follow from it, and the `unit` of the objective."""
        if (question.shear_unit != self.question.shear_unit).any():
            self.chain.changes = [tractions(question, self.dense)]
        self.question = question
        self.f.value = question.friction
        if self.loads is not None:
            self.loads.take(question)
        self.chain.unit = unit
        self.chain.units |= self.units

    @property
    def load_factor(self) -> float:
        """The load factor of the solution, >= 0; rounding of its unit counts as 0."""
        factor = float(self.x.load_factor.value)
        return factor if factor > ZERO_LOAD_FACTOR * self.question.load_unit else 0.0

    @property
    def slip(self) -> Array:
        """(N,) or (N, 2) slip of the solution within its bound; of open nodes, at the mean load."""
        question = self.question
        slip = np.array(self.x.slip.value)
        if question.slip_bound is not None:
            slip = _cut_to_bound(question, slip, question.slip_bound)
        elif not self.user_rows and len(question.W):
            slip -= self._needless_slide(slip)
        return question.slip_at_mean_load(slip)

    def _needless_slide(self, slip: Array) -> Array:
        """The rigid slide in a slip that only keeps gaps open, beyond what the gaps need.

        Interior-point solvers make it large. The smallest slide that leaves the gaps open is a
        problem of least distance, which is solved as one of nonnegative least squares (Lawson and
        Hanson 1974, chapter 23).
        """
        question = self.question
        free, _ = free_slips(question)
        slides = free.T @ slip.T.ravel()  # (k,)
        opening = question.W @ free  # (O, k) gaps by slide
        opening = np.where(np.abs(opening) > CONDENSATION, opening, 0.0) / question.clearance
        least_gaps = np.min([gap.value for gap in self.x.gap.values()], axis=0)
        needed = opening @ slides - least_gaps / question.clearance

        columns = np.vstack([opening.T, needed])
        last = np.eye(len(slides) + 1)[-1]
        *direction, share = columns @ nnls(columns, last)[0] - last
        smallest = -np.array(direction) / share if share else slides
        if (opening @ smallest >= needed - RESIDUAL).all():
            slide = free @ (slides - smallest)
        else:
            slide = np.zeros(len(free))
        return np.asarray(slide.reshape(slip.T.shape).T)

    @property
    def motion(self) -> Mechanism:
        """The slip mechanism, read from the multipliers.

        The multipliers of q and p at each corner are the slips and lifts of the nodes.
        """
        question = self.question
        nodes = question.system.nodes
        rows = {row.label: row for row in self.rows}
        moves = np.zeros((len(self.x.q), *question.r1.shape[1:]))  # (K, t + 1, N)
        for k in self.corners:
            moves[k, :-1] = np.reshape(rows[self.x.q[k].name()].dual_value, (nodes, -1)).T
            moves[k, -1] = rows[self.x.p[k].name()].dual_value
        if len(self.corners) and not np.isfinite(moves).all():
            moves = np.full_like(moves, np.nan)
        flat = np.zeros((len(moves), moves[0].size))
        places = np.flatnonzero(question.open_nodes) + question.system.tangents * nodes
        for k, gap in self.x.gap.items():
            flat[k, places] = np.maximum(rows[label("apart", gap)].dual_value, 0.0)
        return Mechanism.of(question, moves, flat)

    @property
    def user_violation(self) -> float:
        """Largest violation of the rows, dimensionless; 0 without constraints of the user."""
        return self.chain.violation if self.user_rows else 0.0

    def ruling(self, rows: Collection[int]) -> list[str]:
        """Names of the user's constraints among rows, by their ids."""
        return [name for name, row in self.user_rows.items() if row.id in rows]

    def blame_no_user_row(self) -> None:
        """Say in the problem that its rows contradict each other without those of the user."""
        for row in self.user_rows.values():
            for dual in row.dual_variables:
                dual.save_value(np.zeros(dual.shape))
        set_no_optimum(self.problem, cp.INFEASIBLE)

    def prices(self) -> dict[str, Array]:
        """Rate of the objective, >= 0, as each of the user's constraints gives way; user units.

        That of an equation is the rate with its right side.
        """
        # 0.0 + makes an array without axes a number.
        return {name: 0.0 + np.asarray(dual_of(row)) for name, row in self.user_rows.items()}


def _cut_to_bound(question: Question, slip: Array, slip_bound: Array) -> Array:
    """A slip that exceeds its bound by no more than the tolerance of solvers, cut to it."""
    slip[slip_bound == 0] = 0.0
    if question.excess_over_slip_bound(slip) > RESIDUAL:
        return slip
    size = lengths(slip, slip_bound)
    shorter = slip.T / np.where(size > 0, size, 1.0) * slip_bound
    return np.asarray(np.where(size > slip_bound, shorter, slip.T).T)


def listed_rows(
    question: Question,
    x: Unknowns,
    f: cp.Parameter,
    *,
    every: bool = False,
    friction: Callable[..., list[Row]] | None = None,
    more: More | None = None,
    loads: LoadParameters | None = None,
) -> Program:
    """The rows of a question, without a goal.

    They are the rows at the vertices of the hull of the corners; `every`: at all corners.
    `friction` lists other rows in the place of `models.stuck`. `more`: see `models.rest`. `loads`:
    the loads of the question as parameters.
    """
    corners = list(range(len(question.r1))) if every else listed_corners(question)
    x = replace(x)  # with gaps of its own
    rows = rest(loads or question, x, corners, more)
    if friction is None:
        rows += stuck(x, f, corners, law=question.law)
    else:
        rows += friction(x, corners)
    if question.slip_bound is not None:
        rows += within(x, constant(question.slip_bound, f"slip_bound{x.suffix}"))
    f.value = question.friction
    return Program(question, x, f, corners, rows, loads)


def listed_corners(question: Question) -> list[int]:
    """Corners whose rows imply the rows of the other corners; all corners without `simplify`."""
    if question.simplify:
        return outer_corners(question.cycle)
    return list(range(len(question.r1)))


def outer_corners(cycle: LoadCycle) -> list[int]:
    """Corners outside the convex hull of the other corners, by the amplitudes of all load cases."""
    count = len(cycle.corners)
    columns = []
    for loads in (cycle.corners, *([] if cycle.fixed is None else [cycle.fixed])):
        for case in sorted({case for load in loads for case in load}):
            columns.append([load.get(case, 0.0) for load in loads])
    return vertices_of_hull(np.array(columns).reshape(-1, count).T)


def vertices_of_hull(points: Array) -> list[int]:
    """Points (K, any number) that are no mean of the others; some others too in many directions."""
    count = len(points)
    # Coordinates in the directions in which the points differ.
    spread = np.ptp(points, axis=0)
    points = (points - points.mean(axis=0)) / np.where(spread > 0, spread, 1.0)
    _, size, directions = np.linalg.svd(points, full_matrices=False)
    differ = size > ROUNDING * max(size.max(initial=0.0), 1.0)
    along = points @ directions[differ].T
    dimension = along.shape[1]
    if dimension == 0:
        return [0]
    if dimension == 1:
        return sorted({int(along.argmin()), int(along.argmax())})
    # Hulls of corners are looked for in at most so many directions. With more, each corner has
    # rows.
    most_directions = 6
    if dimension <= most_directions and count > dimension + 1:
        # A hull that is nearly flat has no vertices that rounding leaves alone.
        with suppress(QhullError):
            return sorted(ConvexHull(along).vertices.tolist())
    return list(range(count))


# Attributes of the user's own variables that cvxpy turns into linear rows.
_LINEAR_ATTRIBUTES = {"nonneg", "nonpos", "pos", "neg", "bounds", "symmetric"}

# Names of unknowns of models, before the number of the corner.
_NAMES = {"slip", "load_factor", "q", "p", "q_r", "p_r", "margin", "preload", "profile"}

_CONES = (
    cp.constraints.Equality,
    cp.constraints.Zero,
    cp.constraints.Inequality,
    cp.constraints.NonPos,
    cp.constraints.NonNeg,
    cp.SOC,
)


def labelled_rows(constraints: Sequence[Any], known: Iterable[cp.Variable]) -> dict[str, Row]:
    """The user's constraints, checked, named by their labels if unique, else `constraints[i]`."""
    known_ids = {variable.id for variable in known}
    places = [f"constraints[{index}]" for index in range(len(constraints))]
    rows = dict[str, Row]()
    for place, row in zip(places, constraints, strict=True):
        if not isinstance(row, cp.Constraint):
            raise ModelError(
                f"{place}: {shown(row)}; give a cvxpy constraint on slip, load_factor, q and p of "
                "the model, such as model.slip <= 1e-3"
            )
        check_rows(place, row, known_ids)
        unique = row.label and row.label not in [*places, *rows]
        rows[row.label if unique else place] = row
    return rows


def check_rows(name: str, row: Row, known_ids: set[int]) -> None:
    """Refuse a constraint that multipliers of linear rows and second-order cones do not prove.

    It also refuses constraints that are not convex, or on unknowns of another model.
    """
    if not row.is_dcp(dpp=True):
        raise ModelError(
            f"{name}: not convex (an objective: not concave) by the rules of DCP, or not affine in "
            "its parameters (DPP); change it so that it is"
        )
    for variable in row.variables():
        _check_variable(name, variable, known_ids)
    check_values(name, row)
    _check_cones(name, row)


def _check_variable(name: str, variable: cp.Variable, known_ids: set[int]) -> None:
    """Refuse unknowns of another model, integers, and attributes that are no linear rows."""
    part = variable.name().split("[")[0]
    if variable.id not in known_ids and part in _NAMES:
        raise ModelError(
            f"{name}: it contains the {part} of another model; use the variables of this model"
        )
    if variable.attributes["boolean"] or variable.attributes["integer"]:
        raise ModelError(
            f"{name}: variable {variable.name()} is an integer; multipliers cannot prove such an "
            "answer: solve `problem` with it by cvxpy"
        )
    attributes = {kind for kind, value in variable.attributes.items() if value}
    if not attributes <= _LINEAR_ATTRIBUTES:
        refused = ", ".join(sorted(attributes - _LINEAR_ATTRIBUTES))
        raise ModelError(
            f"{name}: variable {variable.name()} is {refused}; give one without this attribute, "
            "and constraints in its place"
        )


def _check_cones(name: str, row: Row) -> None:
    """Refuse cones that are not linear or second-order, or that cvxpy compiles wrongly."""
    problem = cp.Problem(cp.Minimize(0), [row])
    for cone in Dcp2Cone(quad_obj=False).apply(problem)[0].constraints:
        if not isinstance(cone, _CONES):
            raise ModelError(
                f"{name}: it needs a {type(cone).__name__} cone; the multipliers of linear rows "
                "and second-order cones prove the answer: give linear constraints, or constraints "
                "on abs, max, min and norms of vectors, in space for each node: "
                "cp.norm(model.slip, 2, axis=1)"
            )
        # cvxpy fails at axis 2, and mixes up the entries at axis 1.
        if isinstance(cone, cp.SOC) and cone.axis and cone.args[1].ndim > 2:
            raise ModelError(
                f"{name}: it has norms along axis {cone.axis} of {cone.args[1].ndim} axes, which "
                "cvxpy does not compile correctly; give one constraint for each corner k: "
                "cp.norm(model.q[k], 2, axis=1) <= c"
            )


def check_values(name: str, row: Row | cp.Expression) -> None:
    """Refuse parameters without a value, and numbers that are not finite or not real."""
    for leaf in (*row.parameters(), *row.constants()):
        where = f"{name}: a constant"
        if isinstance(leaf, cp.Parameter):
            where = f"{name}: parameter {leaf.name()}"
        if leaf.value is None:
            raise ModelError(f"{where} has no value; give it one before solving")
        numbers = leaf.value.data if issparse(leaf.value) else leaf.value
        if leaf.is_complex() or not np.isfinite(numbers).all():
            raise ModelError(
                f"{where} is not finite or not real; give finite real numbers, and leave out rows "
                "that bound nothing"
            )
