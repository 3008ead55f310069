"""Programs of `frictopt.limits` as cvxpy problems, in the symbols of the paper and user units.

A contact shakes down from some start if one residual slip keeps every node closed and stuck at all
corners k of the load cycle. If the contact is uncoupled, it then shakes down from every start. The
conditions are (theory, eq. (7))::

    q_r = A slip        q_k = q0 + load_factor q1_k + q_r
    p_r = B slip        p_k = p0 + load_factor p1_k + p_r

    |q_k| <= f p_k,   p_k >= 0,   and further terms of the contact law, such as |q_k| <= c

If some nodes stay open, A, B and the loads are condensed to the closed nodes, and the gaps of the
open nodes stay `w0 + load_factor w1_k + W slip >= 0`. `rest` lists the equations of the forces and
gaps, `stuck` the rows of the contact law. Each question below has one goal under these rows, apart
from `gross_slip`, which has no slip. Each row has a label; for an equation that defines an unknown,
it is the name of the unknown. Slip and q are (N,), in space (N, 2), where `|q|` is the length at
each node. There is no scaling, symmetry or elimination here, because people read these problems.
The table in `program/assembled.py` shows which arrays solve these problems, and which programs have
no printed problem.
"""

import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar, TypeAlias

import cvxpy as cp

from ...solve.problem import Problem, printed_as


def plane_shakedown(A: Any, B: Any, q0: Any, p0: Any, q1: Any, p1: Any, f: Any) -> Problem:
    """The shakedown limit of a plane contact with all nodes closed, as one function of arrays.

    See theory, eq. (7). A and B are (N, N), q0, p0 and f (N,), q1 and p1 (K, N). The functions
    below list the same rows for all contacts.
    """
    A, B, q0, p0 = map(constant, (A, B, q0, p0), ("A", "B", "q0", "p0"))
    f = cp.Parameter(len(f), nonneg=True, name="f", value=f)
    load_factor = cp.Variable(name="load_factor")
    slip, q_r, p_r = (cp.Variable(f.shape, name=name) for name in ("slip", "q_r", "p_r"))
    rows = {"q_r": q_r == A @ slip, "p_r": p_r == B @ slip}
    for k in range(len(q1)):
        q, p = (cp.Variable(f.shape, name=f"{name}[{k}]") for name in "qp")
        rows[f"q[{k}]"] = q == q0 + times(load_factor, constant(q1[k], f"q1[{k}]")) + q_r
        rows[f"p[{k}]"] = p == p0 + times(load_factor, constant(p1[k], f"p1[{k}]")) + p_r
        rows[f"stuck[{k}]"] = cp.abs(q) <= cp.multiply(f, p)
        rows[f"pressed[{k}]"] = p >= 0
    rows["load_factor"] = load_factor >= 0
    return Problem(cp.Maximize(load_factor), [row.set_label(name) for name, row in rows.items()])


Row: TypeAlias = cp.Constraint
More: TypeAlias = Mapping[int, Sequence[cp.Expression]]


@dataclass(eq=False)
class Unknowns:
    """The unknowns of a state of rest. By corner k: q[k], p[k] and gap[k]."""

    load_factor: Any
    slip: cp.Variable
    q_r: cp.Variable
    p_r: cp.Variable
    q: dict[int, cp.Variable]
    p: dict[int, cp.Variable]
    gap: dict[int, cp.Variable] = field(default_factory=dict)
    # Appended to all names of one set of open nodes, or of one scenario.
    suffix: str = ""

    stays_in_memory: ClassVar[bool] = True  # files of results leave it out


def friction(values: Any, suffix: str = "") -> cp.Parameter:
    """The friction of the nodes, a parameter."""
    return cp.Parameter(len(values), nonneg=True, name=f"f{suffix}", value=values)


def unknowns(
    shape: tuple[int, ...], corners: Iterable[int], load_factor: Any = None, suffix: str = ""
) -> Unknowns:
    """Unknowns for slips of a shape, (N,) or (N, 2), at the corners of a load cycle.

    `load_factor`: a parameter or constant that fixes it, or the variable of another scenario; None:
    a new variable. `suffix`: appended to the names of all other unknowns.
    """
    if load_factor is None:
        load_factor = cp.Variable(name="load_factor")
    slip = cp.Variable(shape, name=f"slip{suffix}")
    q_r = cp.Variable(shape, name=f"q_r{suffix}")
    p_r = cp.Variable(shape[0], name=f"p_r{suffix}")
    q = {k: cp.Variable(shape, name=f"q{suffix}[{k}]") for k in corners}
    p = {k: cp.Variable(shape[0], name=f"p{suffix}[{k}]") for k in q}
    return Unknowns(load_factor, slip, q_r, p_r, q, p, suffix=suffix)


class Uncopied:
    """A matrix that a cvxpy constant does not copy, because cvxpy copies only arrays."""

    def __init__(self, matrix: Any) -> None:
        self._matrix = matrix

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Any:
        return self._matrix


def constant(value: Any, name: str) -> cp.Constant:
    """A constant that is printed by its name.

    A matrix is not copied, because matrices of a contact are large, and never change.
    """
    return cp.Constant(Uncopied(value) if getattr(value, "ndim", 0) == 2 else value, name=name)


def vec(x: cp.Variable) -> cp.Expression:
    """A vector, ordered by component as A and B are."""
    return x if x.ndim == 1 else printed_as(cp.vec(x, order="F"), x.name())


def size(q: cp.Variable) -> cp.Expression:
    """`|q|` at each node."""
    return cp.abs(q) if q.ndim == 1 else printed_as(cp.norm(q, 2, axis=1), f"norm({q.name()})")


def times(factor: Any, load: Any) -> cp.Expression:
    """A load times a factor."""
    return printed_as(cp.multiply(factor, load), f"{factor.name()} * {load.name()}")


def defines(part: cp.Variable, expression: cp.Expression) -> Row:
    """An equation for an unknown, labelled by its name."""
    return (part == expression).set_label(part.name())


def label(kind: str, part: cp.Variable) -> str:
    """The label of a row on q, p or the gaps at a corner: `stuck[0]`, `stuck_1[0]` for q_1[0]."""
    name: str = part.name()
    return kind + name.lstrip("gapq")


def rest(contact: Any, x: Unknowns, corners: Iterable[int], more: More | None) -> list[Row]:
    """The equations of the forces and gaps of a state of rest, at corners of a load cycle.

    `contact` has the matrices `A`, `B`, and `W` of its gaps, and `loads(k)`: name -> reactions q0,
    p0, q1, p1 and gaps w0, w1 at corner k. `more[k]`: terms that unknown loads add to q, p (and the
    gaps) at corner k. The variables of the gaps are put into `x.gap`.
    """
    slip = vec(x.slip)
    w_r = cp.Variable(len(contact.W), name=f"w_r{x.suffix}")
    shear = vec(x.q_r) == constant(contact.A, f"A{x.suffix}") @ slip
    pressure = constant(contact.B, f"B{x.suffix}") @ slip
    rows = [shear.set_label(x.q_r.name()), defines(x.p_r, pressure)]
    if w_r.size:
        rows.append(defines(w_r, constant(contact.W, f"W{x.suffix}") @ slip))
    x.gap = {}
    for k in corners:
        q, p, *w = _loaded(contact.loads(k), x, w_r, more[k] if more else ())
        rows += [defines(x.q[k], q), defines(x.p[k], p)]
        if w_r.size:
            x.gap[k] = cp.Variable(w_r.size, name=f"gap{x.suffix}[{k}]")
            rows.append(defines(x.gap[k], *w))
    return rows


def _loaded(
    loads: Mapping[str, Any], x: Unknowns, w_r: cp.Variable, more: Sequence[cp.Expression]
) -> list[cp.Expression]:
    """Shear forces, normal forces and any gaps under the loads of a corner, with unknown terms."""
    q0, p0, q1, p1, w0, w1 = (
        constant(value, suffixed(name, x.suffix)) for name, value in loads.items()
    )
    parts = [
        q0 + times(x.load_factor, q1) + x.q_r,
        p0 + times(x.load_factor, p1) + x.p_r,
    ]
    if w_r.size:
        parts.append(w0 + times(x.load_factor, w1) + w_r)
    return [*map(operator.add, parts, more), *parts[len(more) :]]


def suffixed(name: str, suffix: str) -> str:
    """A name with a suffix, before the number of its corner."""
    start, bracket, number = name.partition("[")
    return start + suffix + bracket + number


def stuck(x: Unknowns, f: Any, corners: Iterable[int], law: Any) -> list[Row]:
    """Rows of a contact law at the corners: abs(q) <= f p, its other terms, p >= 0, and gaps >= 0.

    `law` has the terms, see `contact/law.py`. The first one is f p, and Coulomb's law has no other.
    """
    rows = list[Row]()
    for k in corners:
        row = size(x.q[k]) <= cp.multiply(f, x.p[k])
        rows.append(row.set_label(label("stuck", x.q[k])))
        rows.append((x.p[k] >= 0).set_label(label("pressed", x.p[k])))
    rows += [(gap >= 0).set_label(label("apart", gap)) for gap in x.gap.values()]
    for k in corners:
        for term in law.terms[1:]:
            rows.append(within_term(x.q[k], x.p[k], term, label(term.row, x.q[k])))
    return rows


def within_term(q: cp.Variable, p: cp.Variable, term: Any, name: str) -> Row:
    """The row abs(q) <= slope p + constant of a further term of a law, at the nodes that have it.

    The row of a shear strength is abs(q) <= c.
    """
    nodes = term.nodes
    sizes = size(q)
    pressures = p
    if len(nodes) < len(term.constant):
        sizes = printed_as(sizes[nodes], f"{size(q).name()}[{term.which}]")
        pressures = printed_as(p[nodes], f"{p.name()}[{term.which}]")
    bound = constant(term.constant[nodes], term.symbol)
    if term.slope.any():
        bound = cp.multiply(term.slope[nodes], pressures) + bound
    return (sizes <= bound).set_label(name)


def events(x: Unknowns, touching: Mapping[int, Sequence[int]]) -> list[Row]:
    """Rows q = p = 0 of the nodes that open or close at event m."""
    rows = list[Row]()
    for m, nodes in touching.items():
        rows.append((x.q[m][nodes] == 0).set_label(f"event_q[{m}]"))
        rows.append((x.p[m][nodes] == 0).set_label(f"event_p[{m}]"))
    return rows


def ordered(segments: Iterable[tuple[Sequence[cp.Variable], Any]]) -> list[Row]:
    """Rows that keep the events of each segment in their order, from 0 to the end of the segment.

    `segments` has the unknown places of the events of each segment, and the place of its end: the
    load factor if only scaled loads vary on the segment, otherwise 1.
    """
    rows = list[Row]()
    for way, end in segments:
        for earlier, later in pairwise([0, *way, end]):
            rows.append((earlier <= later).set_label(f"way[{len(rows)}]"))
    return rows


def inside(
    x: Unknowns,
    f: cp.Parameter,
    corners: Iterable[int],
    spare: Mapping[int, cp.Expression],
    press: Mapping[int, cp.Expression],
    apart: cp.Expression,
) -> list[Row]:
    """Friction rows with a margin: abs(q) + spare <= f p, p >= press, and gaps >= apart."""
    rows = list[Row]()
    for k in corners:
        reserve = size(x.q[k]) + spare[k] <= cp.multiply(f, x.p[k])
        rows.append(reserve.set_label(label("stuck", x.q[k])))
        rows.append((x.p[k] >= press[k]).set_label(label("pressed", x.p[k])))
    return rows + [(gap >= apart).set_label(label("apart", gap)) for gap in x.gap.values()]


def within(x: Unknowns, slip_bound: cp.Constant, closed: cp.Constant | None = None) -> list[Row]:
    """The bound on the slip of the closed nodes. `closed`: 1 at closed nodes, 0 at open nodes."""
    slip = x.slip if closed is None else times(closed, x.slip)
    return [(size(slip) <= slip_bound).set_label(f"slip_bound{x.suffix}")]


def shakedown(x: Unknowns, rows: Sequence[Row]) -> Problem:
    """The largest load factor of a state of rest.

    For a design, `rows` are the rows of all scenarios, and the loads of the design are `more` in
    `rest`.
    """
    return Problem(cp.Maximize(x.load_factor), [*rows, not_negative(x.load_factor)])


def not_negative(load_factor: cp.Variable) -> Row:
    """The load factor is at least 0."""
    return (load_factor >= 0).set_label("load_factor")


def safe_slip(margin: cp.Variable, rows: Sequence[Row]) -> Problem:
    """The slip with the largest margin at a load factor, see `inside`.

    If the margin is below 0, no slip is safe.
    """
    return Problem(cp.Maximize(margin), [*rows, (margin <= 1).set_label("cap")])


def critical(
    x: Unknowns,
    node: int,
    load: Sequence[cp.Expression],
    needed: Sequence[cp.Expression],
    rows: Sequence[Row],
) -> Problem:
    """The least load factor at which a safe slip makes a node critical.

    At the node q0 + q_r = load_factor c and p0 + p_r = load_factor rho (theory, eq. (10)). `load`
    are q0 and p0 at the node; `needed` are the shear c and the pressure rho that its cyclic loads
    need at a load factor of 1.
    """
    (q0, p0), (c, rho) = load, needed
    q_r, p_r = (printed_as(part[node], f"{part.name()}[{node}]") for part in (x.q_r, x.p_r))
    states = [
        (q0 + q_r == times(x.load_factor, c)).set_label("critical_q"),
        (p0 + p_r == times(x.load_factor, rho)).set_label("critical_p"),
    ]
    return Problem(cp.Minimize(x.load_factor), [*rows, *states, not_negative(x.load_factor)])


def gross_slip(
    N: Any,
    load: Mapping[str, Any],
    f: cp.Parameter,
    law: Any,
    shape: tuple[int, ...],
) -> Problem:
    """The largest load factor at which some contact forces balance a load.

    The forces obey p >= 0 and the terms of the contact law. They balance the load, named r0 and r1,
    on all rigid motions N of the bodies.
    """
    load_factor = cp.Variable(name="load_factor")
    q = cp.Variable(shape, name="q")
    p = cp.Variable(shape[0], name="p")
    motions = constant(N.T, "N.T")
    r0, r1 = (constant(value, name) for name, value in load.items())
    forces = printed_as(cp.hstack([vec(q), p]), "[q, p]")
    rows = [
        (motions @ forces == motions @ (r0 + times(load_factor, r1))).set_label("balance"),
        (size(q) <= cp.multiply(f, p)).set_label("stuck"),
        *(within_term(q, p, term, term.row) for term in law.terms[1:]),
        (p >= 0).set_label("pressed"),
        not_negative(load_factor),
    ]
    return Problem(cp.Maximize(load_factor), rows)
