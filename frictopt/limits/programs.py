"""A listing with all that its solution needs: unknowns, friction, the user's own rows, units, and what its multipliers mean."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any
from weakref import WeakKeyDictionary

import cvxpy as cp
import numpy as np
from cvxpy.reductions.dcp2cone.dcp2cone import Dcp2Cone
from scipy.optimize import nnls
from scipy.sparse import issparse
from scipy.spatial import ConvexHull

from ..base import CONDENSATION, RESIDUAL, ROUNDING, ZERO_LOAD_FACTOR, Array, shown
from ..contact import ContactSystem, LoadCycle, lengths
from ..errors import ModelError
from ..solve.chain import Chain
from ..solve.compiled import Change, by_inverse, unresisted
from ..solve.problem import Problem, dual_of, set_no_optimum
from .answered import Mechanism
from .models import More, Row, Unknowns, constant, label, rest, strong, stuck, unknowns, within
from .question import Question

_INSIDE = ROUNDING  # spread of corners along an axis, over the largest, that counts as none
_MOST_AXES = 6  # in which hulls are looked for: with more, each corner has rows
_KINDS = {
    "nonneg",
    "nonpos",
    "pos",
    "neg",
    "bounds",
    "symmetric",
}  # of variables of the user's own that cvxpy turns into linear rows
_NAMES = {
    "slip",
    "load_factor",
    "q",
    "p",
    "q_r",
    "p_r",
    "margin",
    "preload",
    "profile",
}  # of unknowns of models, before the number of the corner
_CONES = (
    cp.constraints.Equality,
    cp.constraints.Zero,
    cp.constraints.Inequality,
    cp.constraints.NonPos,
    cp.constraints.NonNeg,
    cp.SOC,
)

_FREE: WeakKeyDictionary[ContactSystem, dict[bytes, tuple[Array, Array]]] = WeakKeyDictionary()


def free_slips(question: Question) -> tuple[Array, Array]:
    """Slips (t N, k) that nothing resists, and the compliance (t N, t N) of all others; kept for the last open nodes of a system."""
    kept, key = _FREE.setdefault(question.system, {}), question.open_nodes.tobytes()
    if key not in kept:
        along, across = np.split(np.sqrt(question.system.own_stiffness), [-question.system.nodes])
        kept.clear()
        kept[key] = unresisted(question.A, question.B, along, across)
    return kept[key]


def tractions(question: Question, dense: Sequence[Row] | None = None) -> Change:
    """Tractions as unknowns of a listing's dense rows: the slips that they make by the compliance, and slides that nothing resists."""
    free, give = free_slips(question)
    dense = rest(question, unknowns(question.system.slip_shape, ()), ()) if dense is None else dense
    sizes = question.force / (question.system.own_stiffness[: len(free)] @ free**2)
    return by_inverse(
        dense[0],
        dense[1:],
        free,
        give,
        np.tile(question.shear_unit, question.system.tangents),
        sizes,
    )


@dataclass(eq=False)
class Program:
    """A question's listing, compiled."""

    question: Question
    x: Unknowns
    f: cp.Parameter  # friction
    corners: list[int]  # those that have rows
    rows: list[Row]  # but those of the user
    own: Mapping[str, Row] = field(default_factory=dict)  # those of the user, by their names
    chain: Chain = field(init=False)  # the way to its answer

    def compiled(
        self,
        problem: cp.Problem,
        unit: float,
        units: Mapping[cp.Variable, Any] | None = None,
        others: Sequence["Program"] = (),
    ) -> "Program":
        """With the problem of a goal over its rows and those of others, the `unit` of its objective, and `units` of variables besides its own."""
        problem = Problem(problem.objective, [*problem.constraints, *self.own.values()])
        by_slip = dict[cp.Variable, list[Program]]()
        for each in (self, *others):
            by_slip.setdefault(each.x.slip, []).append(each)
        changes = [
            tractions(same[0].question, [row for each in same for row in each.dense])
            for same in by_slip.values()
        ]
        self.chain = Chain(
            problem, {**self.units, **(units or {})}, changes, self.question.simplify, unit
        )
        return self

    @property
    def dense(self) -> list[Row]:
        """The rows that say what forces and gaps a slip makes."""
        return self.rows[: 3 if len(self.question.W) else 2]

    @property
    def problem(self) -> cp.Problem:
        """The cvxpy problem."""
        return self.chain.problem

    @property
    def units(self) -> dict[cp.Variable, Any]:
        """Units of the unknowns."""
        question, x, n = self.question, self.x, self.question.system.nodes
        each = (
            question.shear_unit if question.system.tangents == 1 else question.shear_unit[:, None]
        )
        slip = (
            np.tile(question.shear_unit, question.system.tangents)
            / question.system.own_stiffness[:-n]
        ).reshape(x.slip.shape, order="F")
        units: dict[cp.Variable, Any] = {x.slip: slip, x.q_r: each, x.p_r: question.node_unit}
        units |= (
            {x.load_factor: question.load_unit} if isinstance(x.load_factor, cp.Variable) else {}
        )
        units |= {q: each for q in x.q.values()} | {p: question.node_unit for p in x.p.values()}
        return units | {gap: question.clearance for gap in x.gap.values()}

    def ask(self, question: Question, unit: float) -> None:
        """Set friction, the units that follow from it, and the `unit` of the objective."""
        if (question.shear_unit != self.question.shear_unit).any():
            self.chain.changes = [tractions(question, self.dense)]
        self.question, self.f.value, self.chain.unit = question, question.friction, unit
        self.chain.units |= self.units

    @property
    def load_factor(self) -> float:
        """The load factor of the solution, >= 0; what is rounding of its unit is 0."""
        factor = float(self.x.load_factor.value)
        return factor if factor > ZERO_LOAD_FACTOR * self.question.load_unit else 0.0

    @property
    def slip(self) -> Array:
        """(N,) or (N, 2) slip of the solution, within its bound; of open nodes the one under the mean load."""
        question, slip = self.question, np.array(self.x.slip.value)
        if question.slip_bound is None and not self.own and len(question.W):
            slip -= self._slide(slip)
        if question.slip_bound is not None:
            slip[question.slip_bound == 0] = 0.0
            size = lengths(
                slip, question.slip_bound
            )  # cut to the bound that it exceeds by no more than the tolerance of solvers
            if question.excess_over_slip_bound(slip) <= RESIDUAL:
                slip = np.where(
                    size > question.slip_bound,
                    slip.T / np.where(size > 0, size, 1.0) * question.slip_bound,
                    slip.T,
                ).T
        return question.slip_at_mean_load(slip)

    def _slide(self, slip: Array) -> Array:
        """What a slip slides without need: the gaps of open nodes alone feel it, and interior points go as far as they grow."""
        (free, _), question = free_slips(self.question), self.question
        opens, found = question.W @ free, free.T @ slip.T.ravel()
        opens = np.where(np.abs(opens) > CONDENSATION, opens, 0.0) / question.clearance
        lack = (
            opens @ found
            - np.min([gap.value for gap in self.x.gap.values()], axis=0) / question.clearance
        )
        columns, last = np.vstack([opens.T, lack]), np.eye(len(found) + 1)[-1]
        *way, share = (
            columns @ nnls(columns, last)[0] - last
        )  # the problem of least distance of Lawson & Hanson
        least = -np.array(way) / share if share else found
        slide = (
            free @ (found - least)
            if (opens @ least >= lack - RESIDUAL).all()
            else np.zeros(len(free))
        )
        return np.asarray(slide.reshape(slip.T.shape).T)

    @property
    def motion(self) -> Mechanism:
        """The mechanism that the multipliers are: those of q and p at each corner are the slips and lifts of the nodes."""
        question, system, n = self.question, self.question.system, self.question.system.nodes
        moves = np.zeros((len(self.x.q), *question.r1.shape[1:]))
        rows = {row.label: row for row in self.rows}
        for k in self.corners:
            moves[k, :-1] = np.reshape(rows[self.x.q[k].name()].dual_value, (n, -1)).T
            moves[k, -1] = rows[self.x.p[k].name()].dual_value
        if len(self.corners) and not np.isfinite(moves).all():
            moves = np.full_like(moves, np.nan)
        if question.compliance is None:
            return Mechanism(moves, question.friction)
        press = np.zeros((len(moves), moves[0].size))
        at = np.flatnonzero(question.open_nodes) + system.tangents * n
        for k, gap in self.x.gap.items():
            press[k, at] = np.maximum(rows[label("apart", gap)].dual_value, 0.0)
        moves = moves - (
            (moves.reshape(len(moves), -1) @ system.S + press) @ question.compliance
        ).reshape(moves.shape)
        return Mechanism(moves, question.friction * ~question.open_nodes, open=question.open_nodes)

    @property
    def own_violation(self) -> float:
        """Largest violation of the rows, the user's among them, dimensionless; 0 where there are none of these."""
        return self.chain.violation if self.own else 0.0

    def ruling(self, rows: Collection[int]) -> list[str]:
        """Names of the user's constraints among rows, by their ids."""
        return [name for name, row in self.own.items() if row.id in rows]

    def blame_no_own_row(self) -> None:
        """Say in the problem that nothing obeys its rows without the user's; the multipliers that prove it stand in the others."""
        for row in self.own.values():
            for dual in row.dual_variables:
                dual.save_value(np.zeros(dual.shape))
        set_no_optimum(self.problem, cp.INFEASIBLE)

    def prices(self) -> dict[str, Array]:
        """Rate of the objective as each of the user's constraints gives way, in the user's units: >= 0; of an equation with its right side."""
        return {
            name: 0.0 + np.asarray(dual_of(row)) for name, row in self.own.items()
        }  # a number where it has no axes


def listed_rows(
    question: Question,
    x: Unknowns,
    f: cp.Parameter,
    *,
    every: bool = False,
    friction: Callable[..., list[Row]] | None = None,
    more: More | None = None,
) -> Program:
    """The rows of a question: at the corners that are no mean of others, unless all are asked for."""
    corners = (
        outer_corners(question.cycle)
        if question.simplify and not every
        else list(range(len(question.r1)))
    )
    x = replace(x)  # each listing has gaps of its own
    rows = rest(question, x, corners, more)
    rows += stuck(x, f, corners) if friction is None else friction(x, corners)
    rows += [
        row
        for k in corners
        for row in strong(x.q[k], question.system.shear_strength, label("strength", x.q[k]))
    ]
    rows += (
        within(x, constant(question.slip_bound, f"slip_bound{x.suffix}"))
        if question.slip_bound is not None
        else []
    )
    f.value = question.friction
    return Program(question, x, f, corners, rows)


def outer_corners(cycle: LoadCycle) -> list[int]:
    """Corners that are no mean of the others, by the amplitudes of all load cases, also those that are fixed."""
    columns = [
        [load.get(case, 0.0) for load in loads]
        for loads in (cycle.corners, *([] if cycle.fixed is None else [cycle.fixed]))
        for case in sorted({case for load in loads for case in load})
    ]
    count = len(cycle.corners)
    points = np.array(columns).reshape(-1, count).T
    points = (points - points.mean(axis=0)) / np.where(
        np.ptp(points, axis=0) > 0, np.ptp(points, axis=0), 1.0
    )
    size, ways = np.linalg.svd(points, full_matrices=False)[1:]
    along = points @ ways[size > _INSIDE * max(size.max(initial=0.0), 1.0)].T
    if along.shape[1] == 0:
        return [0]
    if along.shape[1] == 1:
        return sorted({int(along.argmin()), int(along.argmax())})
    if along.shape[1] <= _MOST_AXES and count > along.shape[1] + 1:
        return sorted(ConvexHull(along).vertices.tolist())
    return list(range(count))


def own_rows(constraints: Sequence[Any], known: Iterable[cp.Variable]) -> dict[str, Row]:
    """The user's constraints, checked, each by its label if no other one has it, or by its place."""
    mine, found = {variable.id for variable in known}, dict[str, Row]()
    places = [f"constraints[{index}]" for index in range(len(constraints))]
    for place, given in zip(places, constraints, strict=True):
        if not isinstance(given, cp.Constraint):
            raise ModelError(
                f"{place}: {shown(given)}; give a cvxpy constraint on slip, load_factor, q and p of the model, such as model.slip <= 1e-3"
            )
        check_rows(place, given, mine)
        found[place if not given.label or given.label in [*places, *found] else given.label] = given
    return found


def check_rows(name: str, row: Row, mine: set[int]) -> None:
    """Refuse a constraint that is not convex, no linear or second-order cone program, or on unknowns of another model."""
    if not row.is_dcp(dpp=True):
        raise ModelError(
            f"{name}: not convex (an objective: not concave) by the rules of DCP, or not affine in its parameters (DPP); change it so that it is"
        )
    for variable in row.variables():
        if variable.id not in mine and (part := variable.name().split("[")[0]) in _NAMES:
            raise ModelError(
                f"{name}: it is on the {part} of another model; use those of the model that solves"
            )
        if variable.attributes["boolean"] or variable.attributes["integer"]:
            raise ModelError(
                f"{name}: variable {variable.name()} is an integer; multipliers prove no such answer: solve `problem` with it by cvxpy"
            )
        if more := {kind for kind, on in variable.attributes.items() if on} - _KINDS:
            raise ModelError(
                f"{name}: variable {variable.name()} is {', '.join(sorted(more))}; give one without this attribute, and constraints in its place"
            )
    check_values(name, row)
    for cone in Dcp2Cone(quad_obj=False).apply(cp.Problem(cp.Minimize(0), [row]))[0].constraints:
        if not isinstance(cone, _CONES):
            raise ModelError(
                f"{name}: it needs a {type(cone).__name__} cone; the multipliers of linear rows and second-order cones prove the answer: "
                "give linear constraints, or such of abs, max, min and norms of vectors, in space for each node: cp.norm(model.slip, 2, axis=1)"
            )
        if (
            isinstance(cone, cp.SOC) and cone.axis and cone.args[1].ndim > 2
        ):  # cvxpy fails at axis 2, and mixes up the entries at axis 1
            raise ModelError(
                f"{name}: it has norms along axis {cone.axis} of {cone.args[1].ndim} axes, which cvxpy does not compile rightly; give them for each "
                "corner k: cp.norm(model.q[k], 2, axis=1) <= c"
            )


def check_values(name: str, row: Row | cp.Expression) -> None:
    """Refuse parameters without a value, and numbers that are not finite or not real."""
    for leaf in (*row.parameters(), *row.constants()):
        told = (
            f"{name}: parameter {leaf.name()}"
            if isinstance(leaf, cp.Parameter)
            else f"{name}: a constant"
        )
        if leaf.value is None:
            raise ModelError(f"{told} has no value; give it one before solving")
        if (
            leaf.is_complex()
            or not np.isfinite(leaf.value.data if issparse(leaf.value) else leaf.value).all()
        ):
            raise ModelError(
                f"{told} is not finite or not real; give finite real numbers, and leave out rows that bound nothing"
            )
