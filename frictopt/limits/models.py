"""Every program of limits in one listing: states of rest of a contact as cvxpy expressions, in the symbols of the paper and the units of the user.

A contact rests through a load cycle if one residual slip keeps every node closed, and stuck at
every corner k of the cycle (theory, eq. (7))::

    q_r = A slip        q_k = q0 + load_factor q1_k + q_r
    p_r = B slip        p_k = p0 + load_factor p1_k + p_r

    |q_k| <= f p_k,   p_k >= 0,   and |q_k| <= c where the surface has a shear strength

Of nodes that stay open, A, B and the loads are those of the closed ones alone, and their gaps stay
`w0 + load_factor w1_k + W slip >= 0`. `rest` lists the rows without friction, `stuck` those of
friction; each question below is one goal over them. Each row has a label, an equation the name of
what it defines. Slip and q are (N,), in space (N, 2), where `|q|` is the length at each node.
Nothing here is scaled, halved or eliminated: `frictopt.solve` does that below cvxpy.
"""

import operator
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any, TypeAlias

import cvxpy as cp

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
    suffix: str = (
        ""  # of the names of all that belongs to one set of open nodes, or to one scenario
    )


def unknowns(
    shape: tuple[int, ...], corners: Iterable[int], load_factor: Any = None, suffix: str = ""
) -> Unknowns:
    """Unknowns for slips of a shape, (N,) or (N, 2), at the corners of a load cycle.

    `load_factor`: a parameter that fixes it. `suffix`: appended to all names.
    """
    if load_factor is None:
        load_factor = cp.Variable(name="load_factor")
    slip = cp.Variable(shape, name=f"slip{suffix}")
    q_r = cp.Variable(shape, name=f"q_r{suffix}")
    p_r = cp.Variable(shape[0], name=f"p_r{suffix}")
    q = {k: cp.Variable(shape, name=f"q{suffix}[{k}]") for k in corners}
    p = {k: cp.Variable(shape[0], name=f"p{suffix}[{k}]") for k in q}
    return Unknowns(load_factor, slip, q_r, p_r, q, p, suffix=suffix)


def constant(value: Any, name: str) -> cp.Constant:
    """A constant that is printed by its name."""
    return cp.Constant(value, name=name)


def printed_as(expression: cp.Expression, name: str) -> cp.Expression:
    """An expression that is printed by a name, where cvxpy would print how it makes a vector of it."""
    expression.name = partial(str, name)
    return expression


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
    """The label of a row on q, p or the gaps at a corner: `stuck[0]` for q[0], `stuck_1[0]` for q_1[0]."""
    name: str = part.name()
    return kind + name.lstrip("gapq")


def rest(contact: Any, x: Unknowns, corners: Iterable[int], more: More | None = None) -> list[Row]:
    """The rows of a state of rest without friction, at corners of a load cycle.

    `contact` has the matrices `A`, `B`, and `W` of its gaps, and `loads(k)`: name -> closed
    reactions q0, p0, q1, p1 and gaps w0, w1 at corner k. `more[k]` is what unknown loads add to q,
    p and, if given, the gaps.
    """
    of, slip, load_factor = x.suffix, vec(x.slip), x.load_factor
    x.gap, w_r = {}, cp.Variable(len(contact.W), name=f"w_r{of}")
    shear = vec(x.q_r) == constant(contact.A, f"A{of}") @ slip
    rows = [shear.set_label(x.q_r.name()), defines(x.p_r, constant(contact.B, f"B{of}") @ slip)]
    rows += [defines(w_r, constant(contact.W, f"W{of}") @ slip)] if w_r.size else []
    for k in corners:
        q0, p0, q1, p1, w0, w1 = (
            constant(value, suffixed(name, of)) for name, value in contact.loads(k).items()
        )
        parts = [
            q0 + times(load_factor, q1) + x.q_r,
            p0 + times(load_factor, p1) + x.p_r,
            w0 + times(load_factor, w1) + w_r,
        ]
        added = more[k] if more and k in more else ()
        q, p, w = *map(operator.add, parts, added), *parts[len(added) :]
        rows += [defines(x.q[k], q), defines(x.p[k], p)]
        if w_r.size:
            x.gap[k] = cp.Variable(w_r.size, name=f"gap{of}[{k}]")
            rows.append(defines(x.gap[k], w))
    return rows


def suffixed(name: str, suffix: str) -> str:
    """A name with a suffix, before the number of its corner."""
    start, bracket, number = name.partition("[")
    return start + suffix + bracket + number


def stuck(x: Unknowns, f: cp.Parameter, corners: Iterable[int], loose: Any = None) -> list[Row]:
    """Friction at corners, and no tension. `loose` is added to the right sides: it is above 0 at the one node that its own rows shall not hold."""
    rows = list[Row]()
    for k in corners:
        bound, least = cp.multiply(f, x.p[k]), 0
        if loose is not None:
            bound, least = bound + loose, -loose
        rows.append((size(x.q[k]) <= bound).set_label(label("stuck", x.q[k])))
        rows.append((x.p[k] >= least).set_label(label("pressed", x.p[k])))
    return rows + [(gap >= 0).set_label(label("apart", gap)) for gap in x.gap.values()]


def strong(q: cp.Variable, c: Any, name: str) -> list[Row]:
    """The shear strength c (N,) of the surface, at the nodes that have one: it is inf at others."""
    has = [node for node, most in enumerate(c) if most < float("inf")]
    some = printed_as(size(q)[has], f"{size(q).name()}[strong]") if len(has) < len(c) else size(q)
    return [(some <= constant(c[has], "c")).set_label(name)] if has else []


def events(x: Unknowns, touching: Mapping[int, Sequence[int]]) -> list[Row]:
    """Nodes that just touch at an event m carry nothing there."""
    rows = list[Row]()
    for m, nodes in touching.items():
        rows.append((x.q[m][nodes] == 0).set_label(f"event_q[{m}]"))
        rows.append((x.p[m][nodes] == 0).set_label(f"event_p[{m}]"))
    return rows


def ordered(load_factor: Any, way: Sequence[cp.Variable]) -> list[Row]:
    """Events follow each other on the way from the first corner, at 0, to the last, at the load factor."""
    return [
        (one <= other).set_label(f"way[{m}]")
        for m, (one, other) in enumerate(pairwise([0, *way, load_factor]))
    ]


def inside(
    x: Unknowns,
    f: cp.Parameter,
    corners: Iterable[int],
    spare: Mapping[int, cp.Expression],
    press: Mapping[int, cp.Expression],
    apart: cp.Expression,
) -> list[Row]:
    """The same with a margin: `spare` of each friction bound and `press` of each normal force, by corner, and `apart` of the gaps of open nodes."""
    rows = list[Row]()
    for k in corners:
        rows.append(
            (size(x.q[k]) + spare[k] <= cp.multiply(f, x.p[k])).set_label(label("stuck", x.q[k]))
        )
        rows.append((x.p[k] >= press[k]).set_label(label("pressed", x.p[k])))
    return rows + [(gap >= apart).set_label(label("apart", gap)) for gap in x.gap.values()]


def within(x: Unknowns, most: cp.Constant) -> list[Row]:
    """The bound on the slip."""
    return [(size(x.slip) <= most).set_label(f"slip_bound{x.suffix}")]


def shakedown(x: Unknowns, rows: Sequence[Row]) -> cp.Problem:
    """The largest load factor of a state of rest; of a design, with the rows of all scenarios, its loads being `more` in `rest`."""
    return cp.Problem(
        cp.Maximize(x.load_factor), [*rows, (x.load_factor >= 0).set_label("load_factor")]
    )


def least_load(x: Unknowns, rows: Sequence[Row]) -> cp.Problem:
    """The least one: above 0 where the mean load alone leaves none."""
    return cp.Problem(
        cp.Minimize(x.load_factor), [*rows, (x.load_factor >= 0).set_label("load_factor")]
    )


def safe_slip(margin: cp.Variable, rows: Sequence[Row]) -> cp.Problem:
    """The slip with the largest margin at a load factor; negative: none is safe. The margin is in the rows, see `inside`."""
    return cp.Problem(cp.Maximize(margin), [*rows, (margin <= 1).set_label("cap")])


def furthest(x: Unknowns, direction: cp.Parameter, rows: Sequence[Row]) -> cp.Problem:
    """The safe slip whose tractions go furthest in a direction."""
    return cp.Problem(cp.Maximize(direction @ vec(x.q_r)), list(rows))


def most_pressed(
    x: Unknowns, least: cp.Variable, force: float, corners: Iterable[int], rows: Sequence[Row]
) -> cp.Problem:
    """The slip under which the least normal force over the nodes and corners is largest, in mean forces."""
    pressed = [(x.p[k] >= force * least).set_label(f"pressed[{k}]") for k in corners]
    return cp.Problem(cp.Maximize(least), [*rows, *pressed, (least <= 1).set_label("cap")])


def least_pressure(
    x: Unknowns, node: cp.Parameter, shares: Sequence[cp.Variable], most: float, rows: Sequence[Row]
) -> cp.Problem:
    """The least normal force of a node (`node` is 1 there) over all slips and loads; the shares of the corners in the load are `more` in `rest`."""
    loads = [
        (sum(shares) <= most).set_label("load_factor"),
        *((share >= 0).set_label(share.name()) for share in shares),
    ]
    return cp.Problem(cp.Minimize(node @ x.p[0]), [*rows, *loads])


def at_node(node: cp.Parameter, values: cp.Expression) -> cp.Expression:
    """The value at the node where `node` is 1, printed by the number of the node."""
    value = node @ values
    value.name = partial(_printed_at, node, values.name())
    return value


def _printed_at(node: cp.Parameter, name: str) -> str:
    return f"{name}[{'i' if node.value is None else int(node.value.argmax())}]"


def critical(
    x: Unknowns,
    node: cp.Parameter,
    load: Sequence[cp.Expression],
    needed: Sequence[cp.Parameter],
    sense: Any,
    rows: Sequence[Row],
) -> cp.Problem:
    """The least (largest) load factor at which a safe slip leaves a node no more pressure than its cyclic loads need.

    `load` are q0 and p0 of the node, see `at_node`, and `needed` the shear c and the pressure rho
    for a load factor of 1, theory, eq. (10).
    """
    (q0, p0), (c, rho) = load, needed
    states = [
        (q0 + at_node(node, x.q_r) == times(x.load_factor, c)).set_label("critical_q"),
        (p0 + at_node(node, x.p_r) == times(x.load_factor, rho)).set_label("critical_p"),
    ]
    return cp.Problem(
        sense(x.load_factor), [*rows, *states, (x.load_factor >= 0).set_label("load_factor")]
    )


def gross_slip(
    N: Any,
    load: Mapping[str, Any],
    f: cp.Parameter,
    c: Any,
    shape: tuple[int, ...],
    sense: Any = cp.Maximize,
) -> cp.Problem:
    """The largest (least) load factor at which any forces within friction balance a load, named r0 and r1, in the rigid motions N of the bodies.

    The strength of the surface is c.
    """
    load_factor, q, p = (
        cp.Variable(name="load_factor"),
        cp.Variable(shape, name="q"),
        cp.Variable(shape[0], name="p"),
    )
    motions, (r0, r1) = (
        constant(N.T, "N.T"),
        (constant(value, name) for name, value in load.items()),
    )
    balance = motions @ printed_as(cp.hstack([vec(q), p]), "[q, p]") == motions @ (
        r0 + times(load_factor, r1)
    )
    rows = [
        balance.set_label("balance"),
        (size(q) <= cp.multiply(f, p)).set_label("stuck"),
        *strong(q, c, "strength"),
    ]
    rows += [(p >= 0).set_label("pressed")]
    return cp.Problem(sense(load_factor), [*rows, (load_factor >= 0).set_label("load_factor")])
