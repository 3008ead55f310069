"""The contact law at all corners as cones, whose unknowns are residual shear and load factor.

A residual slip v changes the shear by q = A v, and the pressure by B v = T q with T = B A^+. Unlike
the stiffness, T does not grow as elements shrink. So a method that needs only products with T and
its transpose takes nearly the same number of steps on every mesh. A row is a cone::

    |q0 + L q1 + q| <= slope (p0 + L p1 + T q) + constant

of one node at one corner. A closed node has a row for each term of the contact law. An open node
has the row `0 <= gap`. Forces are divided by `Question.force`, gaps by `Question.clearance`, and
load factors by `Question.load_unit`.

A safe point corresponds to a slip, and multipliers of the rows to a mechanism: `judged` returns
both, with the error of each proof.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ...base import RESIDUAL, Array, Booleans, Integers, SolveRecord, worst
from ...contact import ContactProducts, ContactSystem
from ...contact.diagnosis import in_contact
from ...errors import ModelError, SolverError
from ..program.question import Question
from ..program.rest_program import elastic
from ..program.solution import Mechanism


class Point(NamedTuple):
    """A load factor, residual shear forces (t, N), and both sides of all rows (K, t + 1, R)."""

    load_factor: float
    shear: Array
    rows: Array


P = TypeVar("P", bound=tuple[Any, ...])


def towards(start: P, end: P, share: float) -> P:
    """The point at a share of the way from one point to another; all its parts change linearly."""
    return type(start)(*(a + share * (b - a) for a, b in zip(start, end, strict=True)))


@dataclass(frozen=True, eq=False)
class Cones:
    """The rows at K corners. The sides of a row are t components of its shear, and its bound.

    Attributes
    ----------
    node
        (R,) node of each row: first all closed nodes, then the closed nodes with a shear strength,
        then the open nodes.
    closed
        Which of the R rows are the first row of a closed node.
    sheared, slope
        (R,) whether a row has shear, and the rate of its bound with the pressure.
    start, rate
        (K, t + 1, R) sides of the rows without residual shear at load factor 0, and their rate with
        the load factor.
    pressing, rough
        (N, t N) the matrix T: pressures, or gaps of open nodes, due to residual shear. `rough` is
        in single precision, which halves the time of products.
    slides
        (t N, r) orthonormal slips that nothing resists. Residual shear does no work on them.
    corners
        Indices of the K corners in the cycle.
    """

    node: Integers
    closed: slice
    sheared: Booleans
    slope: Array
    start: Array
    rate: Array
    pressing: Any
    rough: Any
    slides: Array
    corners: list[int]

    def roughly(self) -> Cones:
        """These cones with products of single precision."""
        return replace(self, pressing=self.rough)

    def balanced(self, shear: Array) -> Array:
        """The part of shear forces (t, N) that slips can cause."""
        flat = shear.ravel()
        return (flat - self.slides @ (self.slides.T @ flat)).reshape(shear.shape)

    def effects(self, shear: Array) -> Array:
        """(t + 1, R) what residual shear (t, N) adds to the sides of the rows, at each corner."""
        pressure = self.pressing @ shear.ravel().astype(self.pressing.dtype)
        return np.vstack([shear[:, self.node] * self.sheared, self.slope * pressure[self.node]])

    def stress(self, moves: Array) -> Array:
        """(t, N) work of moves (K, t + 1, R) of the rows on unit residual shear.

        It is the transpose of `effects`. It is 0 if the moves are a mechanism.
        """
        total = moves.sum(axis=0)
        nodes = self.pressing.shape[0]
        lift = np.bincount(self.node, self.slope * total[-1], nodes).astype(self.pressing.dtype)
        slips = [np.bincount(self.node, self.sheared * part, nodes) for part in total[:-1]]
        by_lift = (lift @ self.pressing).reshape(len(slips), nodes)
        return self.balanced(np.array(slips) + by_lift)

    def relaxed(self) -> Array:
        """(t, N) residual shear that removes the shear at load factor 0, as if without friction."""
        first = np.zeros((self.start.shape[1] - 1, self.pressing.shape[0]))
        first[:, self.node[self.closed]] = -self.start[:, :-1, self.closed].mean(axis=0)
        return self.balanced(first)

    def at(self, load_factor: float, shear: Array) -> Point:
        """The point of a load factor and balanced residual shear."""
        rows = self.start + load_factor * self.rate + self.effects(shear)
        return Point(load_factor, shear, rows)


def without_gap(system: ContactSystem) -> str:
    """How to get an answer without a gap: a part of error messages."""
    if isinstance(system, ContactProducts):
        return "condense the bodies (`model.condense()`), and pass gap=None for the exact answer"
    return "pass gap=None for the exact answer"


def check_options(given: Mapping[str, bool], remedy: str) -> None:
    """Raise a ModelError if an option is given that cannot be combined with a gap."""
    for option, is_given in given.items():
        if is_given:
            raise ModelError(f"{option}: a gap cannot be combined with it; {remedy}")


def check_known(question: Question, remedy: str) -> None:
    """Raise a ModelError if a question has a part that the cones do not describe."""
    without = ~question.open_nodes & (question.friction == 0)
    if without.any():
        node = int(without.argmax())
        raise ModelError(
            f"friction: node {node}{in_contact(question.system, node)} has none, so that its shear "
            f"has no room; a limit with a gap needs friction at all closed nodes: {remedy}"
        )
    if question.open_nodes.any() and elastic(question).opening.any():
        raise ModelError(
            "gap: a slide that nothing resists opens and closes open nodes, which a limit with a "
            f"gap does not know; {remedy}"
        )


def cones_of(question: Question) -> Cones:
    """The cones of a question, at the corners that are vertices of the hull of all corners."""
    n, t = question.system.nodes, question.system.tangents
    corners = question.listed_corners
    parts = elastic(question)
    opened = question.open_nodes
    unit = np.where(opened, question.clearance, question.force)

    system = question.system
    if isinstance(system, ContactProducts):
        pressing, rough = system.pressing, system.rough
    else:
        pressing = np.zeros((n, t * n))
        pressing[:, parts.slips] = parts.normal * (question.force / unit)[:, None]
        rough = pressing.astype(np.float32)
    slides = np.zeros((t * n, parts.slides.shape[1]))
    slides[parts.slips] = parts.slides

    terms = [
        (np.flatnonzero(~opened & np.isfinite(term.constant)), term.slope, term.constant)
        for term in question.law.terms
    ]
    terms.append((np.flatnonzero(opened), np.ones(n), np.zeros(n)))
    of_terms = [(nodes, slope[nodes], constant[nodes]) for nodes, slope, constant in terms]
    node, slope, constant = (np.concatenate(part) for part in zip(*of_terms, strict=True))
    sheared = ~opened[node]

    def sides(forces: Array) -> Array:
        by_node = forces.reshape(-1, t + 1, n) / question.force
        by_node[:, -1] *= question.force / unit
        rows = by_node[:, :, node]
        rows[:, :-1] *= sheared
        rows[:, -1] *= slope
        return rows

    start = sides(question.start[corners])
    start[:, -1] += constant / question.force
    rate = sides(question.rate[corners] * question.load_unit)
    return Cones(
        node, slice(len(terms[0][0])), sheared, slope, start, rate, pressing, rough, slides, corners
    )


def margins(rows: Array) -> Array:
    """(K, R) distances of the sides (K, t + 1, R) of rows from their bounds; >= 0 if rows hold."""
    return np.asarray(rows[:, -1] - np.linalg.norm(rows[:, :-1], axis=1))


def raised(moves: Array) -> Array:
    """Moves (K, t + 1, R) whose lifts are at least the sizes of the slips, as a proof needs."""
    lifts = np.maximum(moves[:, -1], np.linalg.norm(moves[:, :-1], axis=1))
    return np.concatenate([moves[:, :-1], lifts[:, None]], axis=1)


def judged(
    question: Question, cones: Cones, safe: Point, moves: Array
) -> tuple[float, Array, float, Mechanism, float, float]:
    """The slip of a safe point, and the mechanism of multipliers (K, t + 1, R) of the rows.

    Both proofs are evaluated with products of full precision. The results are, in the units of the
    user: the load factor, its slip, and the largest violation of a row, relative to
    `Question.force`; then the mechanism, its bound, and the error of the bound, which arises
    because the multipliers do not balance exactly.
    """
    load_factor = safe.load_factor * question.load_unit
    unsafe = -float(margins(cones.at(safe.load_factor, safe.shear).rows).min())

    moves = raised(moves)
    drive = -float((moves * cones.rate).sum())
    return (
        load_factor,
        slip_of(question, safe.shear),
        unsafe,
        mechanism_of(question, cones, moves / drive),
        float((moves * cones.start).sum()) / drive * question.load_unit,
        work_of_stress(cones, moves, safe.shear) / drive * question.load_unit,
    )


def work_of_stress(cones: Cones, moves: Array, shear: Array) -> float:
    """The work that multipliers do because they do not balance exactly.

    Their stress does this work on residual shear of the size of `shear` (t, N), or of the unit of
    force if this is larger.
    """
    return float((np.abs(cones.stress(moves)) * np.maximum(np.abs(shear), 1.0)).sum())


def record_of(question: Question, load_factor: float, slip: Array, error: float) -> SolveRecord:
    """The record of two proofs with this error; SolverError if rounding hides one of them."""
    residual = worst([error])
    if not isinstance(question.system, ContactProducts):
        # The stiffness shows the error of products with T.
        residual = worst([error, question.violation(load_factor, slip)])
    if not residual <= RESIDUAL:
        raise SolverError(
            f"gap: rounding leaves an error of {residual:.1e} in the slip or in the mechanism "
            f"(tolerance {RESIDUAL:g}); {without_gap(question.system)}"
        )
    return SolveRecord("primal-dual hybrid gradient", residual=residual)


def slip_of(question: Question, shear: Array) -> Array:
    """(N,) or (N, 2) slip of all nodes that causes residual shear (t, N)."""
    parts = elastic(question)
    slip = np.zeros(shear.size)
    slip[parts.slips] = parts.compliance @ (question.force * shear.ravel()[parts.slips])
    return question.slip_at_mean_load(slip.reshape(question.system.slip_shape, order="F"))


def mechanism_of(question: Question, cones: Cones, moves: Array) -> Mechanism:
    """The mechanism of multipliers (K, t + 1, R) of the rows."""
    # The moves of the forces, and of the gaps of open nodes, from the moves of the rows.
    by_node = np.zeros_like(question.r1)
    unit = np.where(question.open_nodes, question.clearance, question.force)[cones.node]
    for corner, of_rows in zip(cones.corners, moves * question.load_unit / unit, strict=True):
        for axis, part in enumerate(of_rows):
            weight = cones.slope if axis == len(of_rows) - 1 else cones.sheared
            by_node[corner, axis] = np.bincount(cones.node, weight * part, by_node.shape[-1])
    return Mechanism.of(question, by_node.reshape(len(by_node), -1))
