"""The solution of a program of states of rest: what it says, and what its multipliers prove.

The multipliers form a slip mechanism (`Mechanism`). `Solved` keeps a solution as data, from which
the printed problem and the proof of an answer follow.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy  # its parts are imported when they are used

from ...base import (
    FAR,
    FLOOR,
    RESIDUAL,
    ZERO_LOAD_FACTOR,
    Array,
    Booleans,
    Integers,
    SolveRecord,
    Table,
    kept,
    places,
    worst,
)
from ...contact import ROWS, ContactSystem, lengths
from ...errors import SolverError
from ...solve.answer import (
    answer,
    contradictions,
    error_of_contradiction,
    growths,
    interiors,
    kind_of,
)
from ...solve.arrays import EQUATION, Arrays, Rows
from ...solve.solvers import LP, LP_SOLVERS, OPTIMAL, C
from .question import Question
from .rest_program import NO_UNKNOWNS, USER, RestProgram, SlipUnknowns

# One file because the multipliers of a solution are a mechanism.


@kept
@dataclass(frozen=True, eq=False)
class Mechanism:
    """A slip mechanism: slips and lifts of the nodes at the corners, in a closed cycle.

    The multipliers of the program of a safe slip form it. Its net motion causes no stress:
    `A d + B^T l = 0` with the sums d of the slips and l of the lifts over the corners. So no
    residual slip resists it (Bjorkman & Klarbring 1987). Under a slip bound it may stress nodes
    whose slip is at the bound.

    Attributes
    ----------
    moves
        (K, t + 1, N) slips along the tangents, and lifts, all in one arbitrary unit. The lift is
        friction times the size of the slip; more if the node opens, and less if the surface shears
        off.
    friction, open
        (N,) coefficients of friction; mask of the open nodes, which follow the closed nodes without
        force (None if all are closed).
    """

    moves: Array
    friction: Array
    open: Booleans | None = None

    @classmethod
    def of(cls, question: Question, moves: Array) -> Mechanism:
        """The mechanism of multipliers (K, M) of the forces, see `Question.response`.

        Open nodes follow the closed ones. A positive multiplier of a gap is the force with which
        the open node touches.
        """
        shape = (len(moves), *question.r1.shape[1:])
        if question.compliance is None:
            return cls(moves.reshape(shape), question.friction)
        normals = moves.shape[1] - question.system.nodes
        opened = np.r_[np.zeros(normals, dtype=bool), question.open_nodes]
        press = np.where(opened, moves.clip(0.0), 0.0)
        moves = np.where(opened, 0.0, moves)
        moves = moves - (moves @ question.system.S + press) @ question.compliance
        friction = question.friction * ~question.open_nodes
        return cls(moves.reshape(shape), friction, open=question.open_nodes)

    @cached_property
    def size(self) -> Array:
        """(K, N) sizes of the slips."""
        return np.asarray(np.hypot.reduce(self.moves[:, :-1], axis=1, initial=0.0))

    @property
    def opening(self) -> Array:
        """(K, N) lifts beyond friction times slip, >= 0; 0 unless a node has little pressure."""
        return (self.moves[:, -1] - self.friction * self.size).clip(0.0)

    def parts(self, system: ContactSystem) -> Array:
        """(2, K, N) sizes of the slips and openings; for open nodes, 0 and how far they overlap."""
        along = self.size
        opening = self.opening
        if self.open is not None:
            forces = -self.moves.reshape(len(along), -1) @ system.S[:, -system.nodes :]
            touching = (forces / system.stiffness_scale).clip(0.0)
            along = np.where(self.open, 0.0, along)
            opening = np.where(self.open, touching, opening)
        return np.stack([along, opening])

    def drive(self, question: Question) -> float:
        """Work of the cyclic loads, at load factor 1, on the mechanism."""
        return -float(np.sum(self.moves.reshape(len(self.moves), -1) * question.bonded[1]))

    def table(self, system: ContactSystem, corners: Sequence[str]) -> Table:
        """A row for each motion, largest first; `corners` are the names of the K corners.

        Columns: node, contact (if several), x (x, y, z in space), corner, its loads, direction,
        share of the sum of all motions. The direction is +1 for slip along +x, -1 for slip against
        it, 0 for an opening or the touching of an open node. In space it is a unit vector (slip1,
        slip2), zero for an opening.
        """
        import pandas as pd  # imported here, because only tables need it

        sizes = self.parts(system)  # (2, K, N): slips, openings
        share = sizes / (float(sizes.sum()) or 1.0)
        # Smaller shares are within the error of the answer.
        kind, corner, node = np.nonzero(share > RESIDUAL)
        order = np.lexsort([corner, node, -share[kind, corner, node]])
        kind = kind[order]
        corner = corner[order]
        node = node[order]
        columns: dict[str, Any] = {
            **of_nodes(system, node),
            "corner": corner,
            "loads": pd.Series([corners[k] for k in corner.tolist()], dtype=str),
        }
        slips = self.moves[:, :-1]  # (K, t, N)
        sense = np.stack([slips, np.zeros_like(slips)])[kind, corner, :, node].T
        if system.tangents == 1:
            columns["direction"] = np.sign(sense[0]).astype(int)
        else:
            columns["slip1"], columns["slip2"] = sense / sizes[kind, corner, node]
        columns["share"] = share[kind, corner, node]
        return pd.DataFrame(columns)


def of_nodes(system: ContactSystem, node: Integers) -> dict[str, np.ndarray]:
    """Columns of a table of some nodes: node, contact (if several), x (x, y, z in space)."""
    columns: dict[str, np.ndarray] = {"node": node}
    if system.contact is not None and len(np.unique(system.contact)) > 1:
        columns["contact"] = system.contact[node]
    for name, values in places(system).items():
        columns[name] = values[node]
    return columns


@kept
@dataclass(frozen=True, eq=False)
class Solved:
    """A solved program: its question and goal, the values of its unknowns, and its multipliers.

    Attributes
    ----------
    goal
        Name of the problem, by which its listing is found: "shakedown", "safe_slip", "critical",
        "ordered" or "design".
    status
        "optimal"; "infeasible" if the multipliers prove that no values obey all rows; "unbounded".
    values
        The unknowns by name: load_factor, slip (N,) or (N, 2) of the closed nodes, margin, ... If
        the problem is unbounded, the load factor and the slip that grow.
    moves
        (K, M) multipliers of the equations of q and p, and of the gaps of open nodes. In the
        program of a critical node, a further instant has the multipliers of q_r and p_r.
    multipliers
        Multipliers of the rows by label, (K, N) for rows of corners.
    own
        Multipliers of the rows of the user by name.
    unknowns, problem
        The variables of the model that the user solved, and its problem if it has rows of the user.
        Both stay in memory; files do not have them.
    """

    goal: str
    question: Question
    status: str
    values: Mapping[str, Any]
    moves: Array
    multipliers: Mapping[str, Array]
    own: Mapping[str, Array] = field(default_factory=dict)
    unknowns: Any = None
    problem: Any = field(default=None)  # of cvxpy, with rows of the user; files have none

    def __getstate__(self) -> dict[str, Any]:
        """Copies have variables of their own."""
        return {**vars(self), "unknowns": None, "problem": copy.deepcopy(self.problem)}


class NotAbove(SolverError):
    """A limit is proven to be at most the value that a search wants to exceed."""


class Judged(NamedTuple):
    """A claim of a solution, with its residual."""

    said: Any
    residual: float


@dataclass(frozen=True, eq=False)
class Solution:
    """Unknowns x of a solver and multipliers y of the rows, read in the units of the user.

    The bound is evaluated from the stiffness and the loads, without the unknowns of the solver.
    """

    program: RestProgram
    x: Array
    y: Array

    def values(self, name: str) -> Array:
        """(n,) the values of a named unknown."""
        part = self.program.named[name]
        return np.asarray(self.x[part] * self.program.named_units[part])

    @property
    def value(self) -> float:
        """The value of the goal."""
        place = self.program.place
        return float(self.x[place.column]) * place.unit

    @property
    def load_factor(self) -> float:
        """The load factor, >= 0; a value within rounding of its unit counts as 0."""
        factor = float(self.values("load_factor")[0])
        return factor if factor > ZERO_LOAD_FACTOR * self.program.question.load_unit else 0.0

    @cached_property
    def _multipliers(self) -> Array:
        """(R,) multipliers of the rows in user units, for the goal in its unit."""
        return self.program.place.unit * self.y / self.program.form.stacked.units

    @cached_property
    def _work(self) -> Array:
        """(Q,) for each quantity the sum over the rows of its weight times the multiplier."""
        program = self.program
        rows = program.form.stacked
        size = program.first_own + len(program.own_units)
        moved = rows.weights * self._multipliers[rows.at]
        return np.bincount(rows.quantities, moved, size).astype(float)

    def balances_along(self, ray: Array) -> bool:
        """Whether the sum of the rows does not change along a ray, up to rounding."""
        values, sizes = self.program.quantities(ray, ray=True)
        return bool(abs(self._work @ values) <= RESIDUAL * (np.abs(self._work) @ sizes))

    @cached_property
    def moves(self) -> Array:
        """(K, M) slips and lifts of the mechanism; at open nodes the multipliers of their gaps."""
        return self._work[: self.program.first_named].reshape(self.program.start.shape)

    @cached_property
    def stresses(self) -> Array:
        """(slips, t N) work of the multipliers on unit slips; 0 for exact multipliers."""
        program = self.program
        stresses = self._work[program.first_slip : program.first_own].copy()
        by_slip = stresses.reshape(len(program.form.slips), -1)
        for number, (response, of_slip) in enumerate(
            zip(program.responses, program.slips_of, strict=True)
        ):
            by_slip[of_slip] += self.moves[program.response_of == number].sum(axis=0) @ response
        return by_slip

    @cached_property
    def balance(self) -> tuple[float, Array]:
        """The proof of the multipliers: `0 <= resistance + rates @ x` for x that obey the rows."""
        program = self.program
        moves = self.moves
        resistance = float(program.form.stacked.constants @ self._multipliers)
        resistance += float(self._work @ program.form.origin)
        named = self._work[program.first_named : program.first_slip]
        rates = np.zeros(len(self.x))
        rates[: len(named)] = program.named_units * (named + moves.ravel() @ program.effects)
        for slip, stress in zip(program.form.slips, self.stresses, strict=True):
            rates[slip.shear], rates[slip.slide] = slip.rates_of(stress)
        own = self._work[program.first_own :]
        rates[len(rates) - len(own) :] = program.own_units * own
        return resistance, rates

    @cached_property
    def bound(self) -> tuple[float, float]:
        """The bound of the goal that the multipliers prove, and the error of their balance.

        The error holds for unknowns up to the size of the solution, or up to their units.
        """
        place = self.program.place
        resistance, rates = self.balance
        errors = np.abs(rates) * np.maximum(np.abs(self.x), 1.0)
        errors[place.column] = 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            rate = np.float64(rates[place.column]) / place.unit
            return float(-resistance / rate), float(errors.sum() / abs(rate))

    @property
    def surely(self) -> tuple[float, float]:
        """The least and the largest value that the bound may have, if the solution is not checked.

        Both hold for unknowns up to a million times the sizes for which the error of `bound` holds.
        """
        bound, error = self.bound
        return bound - FAR * error, bound + FAR * error

    @property
    def gap(self) -> float:
        """Distance of the bound from the value, with its error, relative to the value.

        If the value is below a thousandth of the unit, the distance is relative to this thousandth.
        """
        bound, defect = self.bound
        size = max(abs(self.value), FLOOR * self.program.place.unit)
        return (abs(bound - self.value) + defect) / size

    def residual(self, *violations: float) -> float:
        """Largest of some violations, the gap, and the violation of the rows of the user."""
        off = [*violations, self.gap]
        if self.program.user is not None:
            off.append(self.program.violation(self.x, label=USER))
        return worst(off)

    @property
    def ruling(self) -> list[str]:
        """Names of the rows of the user that take part in the proven contradiction."""
        user = self.program.user
        return [] if user is None else list(user.of.ruling(self))

    @cached_property
    def slip_of_nodes(self) -> Array:
        """(N,) or (N, 2) slip within its bound; open nodes have their slip at the mean load."""
        return self.program.question.slip_at_mean_load(self.closed_slip())

    def closed_slip(self, number: int = 0) -> Array:
        """(N,) or (N, 2) a slip of the closed nodes within its bound, 0 at open nodes."""
        slip: SlipUnknowns = self.program.form.slips[number]
        question = slip.question
        values = slip.reference + slip.slip_of(self.x)
        needless = question.slip_bound is None and not len(self.program.own_units)
        if needless and slip.elastic.opening.any():
            values = values - _needless_slide(self, slip, values)
        values = values.reshape(question.system.slip_shape, order="F")
        if question.slip_bound is None:
            return np.asarray(values)
        return _cut_to_bound(question, values, question.slip_bound)

    @property
    def growing(self) -> dict[str, Any]:
        """The load factor and the slip of the closed nodes that grow along a direction."""
        slip = self.program.form.slips[0].slip_of(self.x)
        shape = self.program.question.system.slip_shape
        return {"load_factor": self.load_factor, "slip": slip.reshape(shape, order="F")}

    @property
    def motion(self) -> Mechanism:
        """The slip mechanism of the multipliers."""
        question = self.program.question
        return Mechanism.of(question, self.moves[: len(question.r1)])

    def solved(self, goal: str, **values: Any) -> Solved:
        """The solved program as data; `goal` names its listing; `values` are further unknowns."""
        values["slip"] = self.closed_slip()
        if "load_factor" in self.program.named:
            values["load_factor"] = self.load_factor
        solved = Solved(goal, self.program.question, OPTIMAL, values, self.moves, self.multipliers)
        user = self.program.user
        return solved if user is None else user.completed(solved, self)

    def of_rows(self, rows: Rows) -> Array:
        """Multipliers of some rows."""
        parts = self.program.form.stacked.parts
        return self._multipliers[next(part for other, part in parts if other is rows)]

    @property
    def of_user_alone(self) -> bool:
        """Whether only rows of the user have multipliers above rounding."""
        sizes = np.abs(self._multipliers)
        others = [part for rows, part in self.program.form.stacked.parts if rows.label != USER]
        least = RESIDUAL * sizes.max(initial=0.0)
        return all((sizes[part] <= least).all() for part in others)

    @property
    def largest_multiplier(self) -> float:
        """The largest multiplier of a row."""
        return float(np.abs(self._multipliers).max(initial=0.0))

    @cached_property
    def multipliers(self) -> dict[str, Array]:
        """Multipliers of the rows by label, (K, N); for a cone, the multiplier of its first row.

        Multipliers of equations have the sign that cvxpy gives to the equation `left == right`. If
        the law allows a node in space no shear force, the node has two equations, for which the
        length of their two multipliers is given.
        """
        by_label = dict[str, Array]()
        for rows, part in self.program.form.stacked.parts:
            of_heads = self._multipliers[part][np.cumsum(rows.sizes) - rows.sizes]
            if rows.kind == EQUATION:
                of_heads = -of_heads
            nodes = self.program.question.system.nodes
            if len(rows.instants) and rows.instants[0] < 0 <= rows.nodes[0]:
                of_nodes = by_label.setdefault(rows.label, np.zeros(nodes))
                np.add.at(of_nodes, rows.nodes, of_heads)
                continue
            if len(rows.instants) and rows.instants[0] < 0:
                before = by_label.get(rows.label, NO_UNKNOWNS)
                by_label[rows.label] = np.r_[before, of_heads]
                continue
            shape = len(self.program.start), nodes
            by_node = by_label.setdefault(rows.label, np.zeros(shape))
            if rows.kind == EQUATION and rows.label in ROWS:
                # A node without friction has an equation for each of its shear forces.
                of_heads = np.hypot(by_node[rows.instants, rows.nodes], of_heads)
                by_node[rows.instants, rows.nodes] = of_heads
                continue
            np.add.at(by_node, (rows.instants, rows.nodes), of_heads)
        return by_label


def solve(
    program: RestProgram,
    claimed: Callable[[Solution], C],
    sense: float = 1.0,
    *,
    no_optimum: Callable[[str], C | None] = lambda outcome: None,
    above: float = -np.inf,
) -> tuple[C, SolveRecord]:
    """The claim about the largest (sense 1) or least value of the goal, see `answer`.

    `no_optimum` makes the claim if a solver reports that there is no optimum. The error is
    `NotAbove` if multipliers prove that the goal is at most `above`, which needs no exact answer.
    """

    def read(x: Array, y: Array) -> C:
        solution = Solution(program, x, y[program.form.slides :])
        if above > -np.inf:
            _, at_most = solution.surely
            if at_most <= above:
                raise NotAbove(f"the limit is not above {above:g}")
        return claimed(solution)

    arrays = program.arrays(sense)
    solver = program.question.solver
    if kind_of(arrays) == LP and solver not in LP_SOLVERS:
        # In space the program of a single node has no cones. A requested solver of cones does not
        # apply to it.
        solver = None
    return answer(
        arrays,
        read,
        solver,
        no_optimum=no_optimum,
        above=above / program.place.unit,
    )


def contradiction(program: RestProgram) -> tuple[Solution, float] | None:
    """Multipliers that prove that no unknowns satisfy all rows, and their error; or None.

    The proof holds for unknowns up to a million times their units. If there is a direction in which
    the goal grows without end, it also holds along this direction.
    """
    arrays = program.arrays()
    ray = next((ray for ray, _ in _rays(program, arrays)), None)
    for y in contradictions(arrays):
        claim = Solution(program, np.zeros(len(arrays.cost)), y[program.form.slides :])
        if ray is not None and not claim.balances_along(ray):
            continue
        resistance, rates = claim.balance
        error = error_of_contradiction(float(np.abs(rates).sum()), -resistance)
        if error <= RESIDUAL:
            return claim, error
    return None


def growth(program: RestProgram) -> tuple[Solution, float] | None:
    """A direction in which the goal grows without end, and its error; None if not proven.

    The direction begins at values that satisfy all rows, and along it all rows hold up to the
    rounding of the stiffness.
    """
    arrays = program.arrays()
    for ray, leaving in _rays(program, arrays):
        for start in interiors(arrays):
            unsafe = program.violation(start)
            if unsafe <= RESIDUAL:
                no_multipliers = np.zeros(len(program.form.stacked.constants))
                return Solution(program, ray, no_multipliers), max(leaving, unsafe)
    return None


def _rays(program: RestProgram, arrays: Arrays) -> Iterator[tuple[Array, float]]:
    for ray in growths(arrays):
        leaving = program.violation(ray, ray=True)
        growing = -float(arrays.cost @ ray)
        if leaving <= RESIDUAL and growing > RESIDUAL * float(np.abs(arrays.cost) @ np.abs(ray)):
            yield ray, leaving


def _cut_to_bound(question: Question, slip: Array, slip_bound: Array) -> Array:
    """A slip, shortened to its bound if it exceeds the bound only by the tolerance of solvers.

    All nodes get the same factor: to change one node alone would change forces by more.
    """
    slip = np.where(slip_bound == 0, 0.0, slip.T).T
    if question.excess_over_slip_bound(slip) > RESIDUAL:
        return slip
    size = lengths(slip, slip_bound)
    shares = slip_bound / np.where(size > 0, size, np.inf)
    within = slip * shares[size > slip_bound].min(initial=1.0)
    # Rounding may leave a slip just above its bound.
    most = (slip_bound * np.ones_like(within.T)).T
    return np.asarray(np.clip(within, -most, most))


def _needless_slide(solution: Solution, slip: SlipUnknowns, values: Array) -> Array:
    """(t N,) the rigid slide in a slip, as far as the gaps do not need it to stay open.

    Interior-point solvers make this slide large. The smallest slide that leaves the gaps open is a
    problem of least distance, which nonnegative least squares solve (Lawson and Hanson 1974,
    chapter 23).
    """
    program = solution.program
    question = slip.question
    elastic = slip.elastic
    slide = np.zeros(len(values))
    quantities, _ = program.quantities(solution.x)
    forces = quantities[: program.first_named].reshape(program.start.shape)
    here = program.response_of == program.form.slips.index(slip)
    gaps = forces[here, -question.system.nodes :][:, question.open_nodes]
    slides = elastic.slides.T @ values[elastic.slips]  # (k,)
    opening = elastic.opening[question.open_nodes] / question.clearance  # (O, k) gaps by slide
    margin = solution.values("margin")[0] if "margin" in program.named else 0.0
    needed = opening @ slides - gaps.min(axis=0) / question.clearance + margin

    columns = np.vstack([opening.T, needed])
    last = np.eye(len(slides) + 1)[-1]
    *direction, share = columns @ scipy.optimize.nnls(columns, last)[0] - last
    smallest = -np.array(direction) / share if share else slides
    if (opening @ smallest >= needed - RESIDUAL).all():
        slide[elastic.slips] = elastic.slides @ (slides - smallest)
    return slide
