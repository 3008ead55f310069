"""The mean state of a node in which its cyclic load leaves it no room: on its bound at opposed corners, or at three that surround.

The pressure rho that it needs, with the shear c, is in the theory, eq. (10): the smallest disc that
holds the discs with centres `-q1_k` and radii `-f p1_k` has the centre c and the radius `f rho`. If
a part of the cycle is fixed, each two corners that govern at some load factor have a state of their
own, affine in it.

One slip mechanism for each node j bounds the load factor at which it can be critical. For
multipliers with `A d + B^T (f a) = 0`, `a = abs(d)` at all other nodes and a_j = -1, the sum of `d
q + f a p` is that of the mean load. With h(d) the largest `-(d q1 + f abs(d) p1)` of a corner::

    resistance = sum of d q0 + f a p0   >=   lam drive,       drive = d_j c - f rho + sum of h(d)
    over the others

A fixed-point iteration looks for such multipliers; where it does not converge (large friction) the
bound of node j is 0.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import Any

import cvxpy as cp
import numpy as np

from ..base import CONDENSATION, RESIDUAL, ROUNDING, Array, Integers, SolveRecord, frozen
from ..contact import lengths
from ..errors import ModelError
from ..solve.compiled import Change
from ..solve.problem import put_back, standing
from .answered import Mechanism
from .models import Row, Unknowns, at_node, constant, critical, stuck
from .programs import Program, listed_rows, tractions
from .question import Question

_TIE = ROUNDING  # corners whose rows differ by less than this share rule together
_SUBSETS = (
    (0,),
    (0, 1),
    (0, 2),
    (0, 3),
    (0, 1, 2),
    (0, 1, 3),
    (0, 2, 3),
)  # of a new disc and three old ones that touch the smallest one
_EXCHANGES = 4  # for each disc, at most; mostly three in all do
_SETTLED = RESIDUAL  # change of a screening mechanism, over its size, that counts as none
_SCREENING = (
    CONDENSATION  # relative rounding of a screening bound, which feels the errors of the data
)
_SPARE = (
    1e3 * RESIDUAL
    # share by which a screening mechanism slips more than it must, so that it is admissible before it
    # settles
)
_MOST = 300  # iterations
_MEANS = 3  # of slides; with more the bounds hardly rise
_NEAR = (
    1e-2  # share of the largest slip that a smaller one counts as in these means, which settle then
)
_LARGE = 1e6  # a mechanism of this size is on its way to infinity


@dataclass(frozen=True, eq=False)
class CriticalState:
    """What a slip adds to the shear forces and the pressure of a node where it is critical, (t + 1,): `[A v, B v] = at_zero + lam rate`."""

    node: int
    corners: tuple[
        int, ...
    ]  # at which it is on its bound; in the plane one of forward and one of backward slip
    at_zero: Array
    rate: Array


def needed(friction: Array, q1: Array, p1: Array) -> tuple[Array, Array]:
    """(N,) or (N, 2) shear c and (N,) friction bound `f rho` that the cyclic loads of each node need, at load factor 1."""
    fp1 = friction * p1
    if q1.ndim == 3:
        return smallest_discs(-q1.transpose(1, 0, 2), -fp1.T)
    ahead, back = (-q1 - fp1).max(axis=0), (q1 - fp1).max(axis=0)
    return (ahead - back) / 2, (ahead + back) / 2


def critical_states(question: Question) -> list[list[CriticalState]]:
    """The critical states of each node: none if it has no friction or only lifts off, one for each pair of corners with fixed parts, else one."""
    f = question.friction
    if question.fixed:
        return _of_pairs(question)
    q0, p0 = question.q0[0], question.p0[0]
    q1, p1 = question.q1, question.p1
    shear, bound = needed(f, q1, p1)
    size, q = (lengths(q1, p1) + f * np.abs(p1)).max(axis=0), q1 + shear
    rules = lengths(q, p1) - f * p1 >= bound - _TIE * size
    cyclic = (bound > (-f * p1).max(axis=0) + _TIE * size) & (f > 0)

    def state(i: int) -> CriticalState:
        corners = tuple(np.flatnonzero(rules[:, i]).tolist())
        if q.ndim == 2:
            corners = (
                next(k for k in corners if q[k, i] < 0),
                next(k for k in corners if q[k, i] > 0),
            )
        return CriticalState(i, corners, -np.r_[q0[i], p0[i]], np.r_[shear[i], bound[i] / f[i]])

    return [[state(i)] if cyclic[i] else [] for i in range(len(f))]


def _of_pairs(question: Question) -> list[list[CriticalState]]:
    """The critical states in the plane where the corners differ at load factor 0."""
    f, q0, p0 = question.friction, question.q0, question.p0
    q1, p1 = question.q1, question.p1
    fp0, fp1 = f * p0, f * p1
    own = np.stack([q0, fp0, q1, fp1])
    floor, rules = _TIE * np.abs(own).max(axis=1), np.zeros((2, *fp1.shape), dtype=bool)
    for which, sense in zip(rules, (1, -1), strict=True):
        which[ruling(-(sense * q0 + fp0), -(sense * q1 + fp1))] = True
    found: list[list[CriticalState]] = []
    for i, friction in enumerate(f):
        ends = (
            product(*(np.flatnonzero(which[:, i]).tolist() for which in rules))
            if friction > 0
            else ()
        )
        pairs = [
            (k, j)
            for k, j in ends
            if k != j and (np.abs(own[:, k, i] - own[:, j, i]) > floor[:, i]).any()
        ]
        states = []
        for k, j in pairs:
            at_zero, rate = (
                _at_both_bounds(friction, q[[k, j], i], p[[k, j], i])
                for q, p in ((q0, p0), (q1, p1))
            )
            states.append(CriticalState(i, (k, j), at_zero, rate))
        found.append(states)
    return found


def _at_both_bounds(friction: float, q: Array, p: Array) -> Array:
    """(2,) shear and pressure to add to the reactions of two corners, so that the first has forward and the second backward slip."""
    (q_k, q_j), (b_k, b_j) = q, friction * p
    return -np.array([q_k + q_j + b_k - b_j, (q_k - q_j + b_k + b_j) / friction]) / 2


class NeededByNode:
    """What the loads of the node where `node` is 1 need, for the friction that stands in `f`: values of parameters that follow from these two.

    `corners` are those of its critical state, if parts of the load cycle are fixed: each pair of
    them has a state of its own.
    """

    def __init__(
        self, f: cp.Parameter, node: cp.Parameter, parts: Sequence[Array], fixed: bool
    ) -> None:
        self.f, self.node, self.fixed = f, node, fixed
        self._parts = parts  # q0, p0, q1, p1
        self.corners: tuple[int, ...] = ()

    def parameters(self, tangents: int) -> dict[str, cp.Parameter]:
        """The shear c and the pressure rho for a load factor of 1, and, with fixed parts, -c0 and -rho0 at load factor 0."""
        shape = () if tangents == 1 else (tangents,)
        found = {
            "c": cp.CallbackParam(self.shear, shape, name="c"),
            "rho": cp.CallbackParam(self.pressure, name="rho"),
        }
        if self.fixed:
            found["c0"] = cp.CallbackParam(partial(self._of_pair, 0, 0), name="c0")
            found["rho0"] = cp.CallbackParam(partial(self._of_pair, 0, 1), name="rho0")
        return found

    def shear(self) -> Any:
        """The shear for a load factor of 1."""
        if self.fixed:
            return self._of_pair(2, 0)
        return self._of_cycle()[0][0]

    def pressure(self) -> float:
        """The pressure for a load factor of 1."""
        if self.fixed:
            return self._of_pair(2, 1)
        friction = self._friction()
        return float(self._of_cycle()[1][0] / friction)

    def _friction(self) -> float:
        """The friction of the node, refused where it has none."""
        index = int(self.node.value.argmax())
        friction = float(self.f.value[index])
        if not friction > 0:
            raise ModelError(
                f"f: {friction:g} at node {index}, which without friction is never critical; give it friction, or ask guaranteed_limit"
            )
        return friction

    def _of_cycle(self) -> tuple[Array, Array]:
        index = int(self.node.value.argmax())
        q1, p1 = self._parts[2:]
        return needed(np.array([self._friction()]), q1[:, [index]], p1[:, [index]])

    def _of_pair(self, first: int, which: int) -> float:
        """The shear or the pressure of a pair of corners, of the parts from a first one on.

        At load factor 0 it has the other sign, for it stands on the left side.
        """
        index, rows = int(self.node.value.argmax()), list(self.corners)
        q, p = (part[rows, index] for part in self._parts[first : first + 2])
        value = float(_at_both_bounds(self._friction(), q, p)[which])
        return value if first else -value


def smallest_discs(centres: Array, radii: Array) -> tuple[Array, Array]:
    """Centres (n, 2) and radii (n,) of the smallest discs around n times K discs, (n, K, 2) and (n, K); radii may be negative."""
    rows = np.arange(len(radii))
    touch = np.repeat(radii.argmax(axis=1)[:, None], 3, axis=1)
    centre, radius = centres[rows, touch[:, 0]], radii.max(axis=1)
    size = np.abs(centres - centres.mean(axis=1, keepdims=True)).max(axis=(1, 2)) + np.abs(
        radii
    ).max(axis=1)
    for _ in range(_EXCHANGES * radii.shape[1]):
        reach = np.linalg.norm(centres - centre[:, None], axis=-1) + radii
        out = np.flatnonzero(reach.max(axis=1) > radius + ROUNDING * size)
        if not len(out):
            break
        four = np.column_stack([reach.argmax(axis=1), touch])[out]
        held, by = centres[out[:, None], four], radii[out[:, None], four]
        radius[out] = np.inf
        for subset in _SUBSETS:
            for found in _touching(held[:, subset], by[:, subset]):
                holds = (np.linalg.norm(held - found[:, None], axis=-1) + by).max(axis=1)
                less = holds < radius[out]  # not where there is no such disc, which is nan
                centre[out[less]], radius[out[less]] = found[less], holds[less]
                touch[out[less]] = (
                    np.resize(four[less][:, subset], (int(less.sum()), 3))
                    if len(subset) == 3
                    else four[less][:, (subset * 3)[:3]]
                )
    return centre, (np.linalg.norm(centres - centre[:, None], axis=-1) + radii).max(axis=1)


def _touching(centres: Array, radii: Array) -> list[Array]:
    """Centres (n, 2) of the discs that one, two or three discs, (n, m, 2) and (n, m), touch from within; nan where there is none."""
    first, apart, larger = (
        centres[:, 0],
        centres[:, 1:] - centres[:, :1],
        radii[:, 1:] - radii[:, :1],
    )
    right = np.stack([((apart**2).sum(axis=-1) - larger**2) / 2, larger], axis=-1)
    u, w = np.moveaxis(np.linalg.pinv(apart) @ right, 2, 0)
    a, b, c = 1 - (w**2).sum(axis=-1), (u * w).sum(axis=-1), (u**2).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        if (
            apart.shape[1] == 1
        ):  # where the larger one nearly holds the other, all digits of a are lost
            distance = np.linalg.norm(apart[:, 0], axis=-1)
            return [first + apart[:, 0] * ((distance + larger[:, 0]) / (2 * distance))[:, None]]
        root = b + np.copysign(np.sqrt(b**2 + a * c), b)
        return [first + u + w * s[:, None] for s in (root / a, -c / root)]


def load_factor_bounds(question: Question) -> Array:
    """(n,) lower bounds of the load factor at which each node can be critical; 0 where nothing is known, inf where it never can."""
    if question.fixed:  # which corner governs depends on the load factor
        return np.zeros(len(question.friction))
    n, unit = len(question.friction), question.node_unit[:, None]
    net_slips = _net_slips(question, tractions(question))
    total = -np.eye(n)  # columns: the mechanisms, each in units of the force of its nodes; rows: a
    for _ in range(_MOST):
        net = np.linalg.norm(net_slips(total), axis=0)
        size = unit * np.abs(total / unit).max(axis=0)
        following = (1 + _SPARE) * net + _SETTLED * size
        np.fill_diagonal(following, -1.0)
        np.fill_diagonal(net, -1.0)
        done = (net <= total).all(axis=0) & (np.abs(following - total) <= _SETTLED * size).all(
            axis=0
        )
        lost = ~(total.max(axis=0) < _LARGE)
        if (done | lost).all():
            break
        total = np.where(done | lost, total, following)
    d, fa, (shear, bound) = (
        net_slips(total) / unit,
        question.friction[:, None] * total / unit,
        needed(question.friction, question.q1, question.p1),
    )
    q0, p0 = question.q0[0], question.p0[0]
    q1, p1 = question.q1, question.p1
    held = np.array([_work(d, q0), fa * p0[:, None]])
    driven = _work(d, shear) + total / unit * bound[:, None]
    if len(d) > 1:
        others = np.max(
            [-_work(d, q) - fa * p[:, None] for q, p in zip(q1, p1, strict=True)], axis=0
        )
        driven = np.where(np.eye(n, dtype=bool), driven, others)
    resistance, drive, terms = (
        held.sum(axis=(0, 1)),
        driven.sum(axis=0),
        np.abs(held).sum(axis=(0, 1)),
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        least = np.where(drive < 0, resistance / drive, np.inf) * (1 - _SCREENING)
    return np.asarray(np.where(done & (resistance < -_SCREENING * terms), least, 0.0))


def _work(d: Array, q: Array) -> Array:
    """Work (n, n) of shear forces (n,) or (n, 2) on slips (t, n, n): by node and mechanism."""
    return np.asarray(np.einsum("tij,it->ij", d, q.reshape(d.shape[1], -1)))


def _net_slips(question: Question, change: Change) -> Callable[[Array], Array]:
    """The net slips (t, n, n) that balance given total slips (n, n), by means weighted by the slips before; free slides go until friction resists."""
    n, t, m = question.system.nodes, question.system.tangents, len(change.loaded)
    rows, (normal, *_) = t * n, change.blocks.values()
    rows_of_shear, to_pressure = (
        change.product[:, :m].toarray() / np.tile(question.node_unit, t)[:, None],
        normal[:, :m] / question.node_unit[:, None],
    )
    loaded = change.loaded
    others = np.setdiff1d(np.arange(rows), loaded)
    right = np.hstack([to_pressure.T * question.friction, rows_of_shear[others].T])
    follow, rigid, shape = np.zeros((rows, n)), np.zeros((rows, rows - m)), (rows // n, n, n)
    solved = -np.linalg.solve(rows_of_shear[loaded].T, right)
    follow[loaded], rigid[loaded], rigid[others] = solved[:, :n], solved[:, n:], np.eye(rows - m)
    pairs = (rigid[:, :, None] * rigid[:, None]).reshape(rows, -1)
    hold = np.tile(
        np.maximum(question.friction * question.r0[0, -1] / question.node_unit, 0.0), rows // n
    )[:, None]

    def net(total: Array) -> Array:
        slips = follow @ total
        for _ in range(_MEANS if rows > m else 0):
            size = np.linalg.norm(slips.reshape(shape), axis=0)
            weight = hold / np.tile(np.maximum(size, _NEAR * size.max() or 1.0), (shape[0], 1))
            square = (weight.T @ pairs).reshape(n, rows - m, rows - m)
            slips = (
                slips
                - rigid
                @ (
                    np.linalg.pinv(square, hermitian=True)
                    @ (rigid.T @ (weight * slips)).T[..., None]
                )[..., 0].T
            )
        return np.asarray(slips.reshape(shape))

    return net


def ruling(constant: Array, rate: Array) -> tuple[Integers, Integers]:
    """(R,) corners and nodes of the rows, (K, N), that govern `x >= constant_k + lam rate_k` at some load factor >= 0."""
    highest = constant == constant.max(axis=0)
    corner, node = np.where(highest, rate, -np.inf).argmax(axis=0), np.arange(rate.shape[1])
    rows = [(corner, node)]
    while node.size:
        gain, lead = rate[:, node] - rate[corner, node], constant[corner, node] - constant[:, node]
        meets = np.where(gain > 0, lead / np.where(gain > 0, gain, 1.0), np.inf)
        corner, further = meets.argmin(axis=0), np.isfinite(meets.min(axis=0))
        corner, node = corner[further], node[further]
        rows.append((corner, node))
    corners, nodes = (np.concatenate(part) for part in zip(*rows, strict=True))
    return corners, nodes


_COINCIDE = (
    1e3 * RESIDUAL
)  # dimensionless load factors up to this cannot be told from zero: residuals move them so far

SOLVED, NEVER, COINCIDE_ALONE, LEFT_OUT = (
    "solved",
    "never critical",
    "only at the least safe load factor",
    "left out by its bound",
)


@dataclass(frozen=True, eq=False)
class NodeClaim:
    """The least load factor at which a node is critical under a safe slip; inf where there is none, and a slip of NaN."""

    state: CriticalState
    load_factor: float
    slip: Array
    residual: float
    motion: Mechanism | None = None  # see `critical_motion`; None where another node has less
    program: Program | None = None  # that it is the answer of; None where there is no slip
    values: Mapping[cp.Variable, Array] = field(
        default_factory=dict
    )  # what then stands in its variables
    solver: str = ""
    how: str = SOLVED  # how it is known
    above: tuple[float, Array] | None = (
        # if it is the least safe load factor: a larger one, and the slip there; those between mix
        # the two
        None
    )


class CriticalSearch:
    """The problems of all nodes over the safe slips of a question, compiled once for each sense and for any friction. `records` are in order."""

    def __init__(
        self, x: Unknowns, question: Question, own: Mapping[str, Row], solver: str | None
    ) -> None:
        self._x, self._question, self._own, self._solver, self.records = (
            x,
            question,
            own,
            solver,
            list[SolveRecord](),
        )
        self._node, self._loose, self._f = (
            cp.Parameter(question.system.nodes, nonneg=True, name=name)
            for name in ("node", "loose", "f")
        )
        self._most = cp.Parameter(name="most")
        parts = question.q0, question.p0, question.q1, question.p1
        self._needed = NeededByNode(self._f, self._node, parts, question.fixed)
        self._parameters = self._needed.parameters(question.system.tangents)
        self._programs: dict[bool, Program] = {}

    def ask(self, question: Question) -> None:
        """Set the question, of another friction."""
        self._question, self.records = question, list[SolveRecord]()

    def solve(self, state: CriticalState, ends: tuple[float, float], found: float) -> NodeClaim:
        """The claim of one node that passes its checks, of a contact that is safe between two load factors; or that it is not below that `found`."""
        unit = self._question.load_unit
        claim = self._solved(state, found)
        least, step = (
            ends[0],
            _COINCIDE * min(unit, ends[1] - ends[0]),
        )  # small beside the interval of safe load factors
        beyond = least + step  # cannot be told from the least safe one
        if claim.load_factor > (beyond if least > 0 else 0.0):
            return claim
        # it counts if the node can be critical above too: the load factors at which it can are an
        # interval, for the problem is convex
        self._most.value = unit + least
        highest = self._solved(state, np.inf, highest=True)
        if highest.load_factor > max(beyond, claim.load_factor + step):
            return replace(claim, above=(highest.load_factor, frozen(highest.slip)))
        return NodeClaim(
            state, np.inf, np.full_like(claim.slip, np.nan), highest.residual, how=COINCIDE_ALONE
        )

    def restore(self, claim: NodeClaim) -> None:
        """Put an answer into its program, which may have been solved for other nodes since."""
        self._set(claim.state)
        put_back(claim.values)

    def _set(self, state: CriticalState) -> None:
        question, own = (
            self._question,
            (np.arange(self._question.system.nodes) == state.node).astype(float),
        )
        self._node.value, self._loose.value, self._f.value, self._needed.corners = (
            own,
            own * question.node_unit,
            question.friction,
            state.corners,
        )

    def _solved(self, state: CriticalState, found: float, highest: bool = False) -> NodeClaim:
        self._set(state)
        program = self._program(highest)

        def never() -> NodeClaim | None:
            none = program.chain.contradiction()
            return (
                None
                if none is None
                else NodeClaim(
                    state,
                    np.inf,
                    np.full(program.question.system.slip_shape, np.nan),
                    none.residual,
                    how=NEVER,
                )
            )

        claim, record = program.chain.solve(
            lambda: _claimed(program, state, found), self._solver, no_optimum=never
        )
        self.records.append(record)
        return replace(claim, solver=record.solver)

    def _program(self, highest: bool) -> Program:
        if highest not in self._programs:
            question, x, given = self._question, self._x, self._parameters

            def friction(x: Unknowns, corners: list[int]) -> list[Row]:
                return stuck(x, self._f, corners, None if question.fixed else self._loose)

            program = listed_rows(question, x, self._f, every=bool(self._own), friction=friction)
            program.own, rows = (
                self._own,
                program.rows
                + ([(x.load_factor <= self._most).set_label("at_most")] if highest else []),
            )
            problem = critical(
                x,
                self._node,
                self._load(),
                (given["c"], given["rho"]),
                cp.Maximize if highest else cp.Minimize,
                rows,
            )
            self._programs[highest] = program.compiled(problem, question.load_unit)
        self._programs[highest].ask(self._question, self._question.load_unit)
        return self._programs[highest]

    def _load(self) -> list[cp.Expression]:
        """What the node carries at load factor 0, by the names of the shear and of the normal forces."""
        if self._question.fixed:
            return [self._parameters["c0"], self._parameters["rho0"]]
        return [
            at_node(self._node, constant(values[0], name))
            for values, name in ((self._question.q0, "q0"), (self._question.p0, "p0"))
        ]


def _claimed(program: Program, state: CriticalState, found: float) -> NodeClaim:
    """The claim that stands in a program; if it does not pass, the claim that the node is not critical below `found`, if multipliers prove that."""
    question, slip, load_factor, proof = (
        program.question,
        program.slip,
        program.load_factor,
        program.chain.proof,
    )
    (q, p), node = question.reactions_of_slip(slip), state.node
    off = (
        float(np.abs(np.r_[q[node], p[node]] - state.at_zero - load_factor * state.rate).max())
        / question.force
    )
    residual, least = (
        np.max([question.violation(load_factor, slip), off, proof.gap, program.own_violation]),
        proof.bound - proof.defect,
    )
    if not residual <= RESIDUAL and found < least < np.inf:
        return NodeClaim(state, least, np.full_like(slip, np.nan), 0.0, how=LEFT_OUT)
    motion = critical_motion(program, state) if load_factor < found else None
    return NodeClaim(
        state,
        load_factor,
        slip,
        float(np.nan_to_num(residual, nan=np.inf)),
        motion,
        program,
        standing(program.problem),
    )


def critical_motion(program: Program, state: CriticalState) -> Mechanism:
    """The rates of a node's load factor with all reactions, as slips and lifts of either sign, from the multipliers of its solved program.

    Other nodes: the mechanism of their rows, reversed. The node itself: slips along or against
    `q_k` at its corners, which open by friction; what is across two opposed corners moves the state
    between them by its lever.
    """
    question, f, node, corners = (
        program.question,
        program.question.friction,
        state.node,
        list(state.corners),
    )
    others = program.motion
    moves = -others.moves
    y = np.concatenate(
        [
            np.ravel(row.dual_value)
            for row in program.problem.constraints
            if row.label in ("critical_q", "critical_p")
        ]
    )
    q = question.states(program.load_factor, program.slip)[1][corners, :-1, node]
    size = np.linalg.norm(q, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        ways = np.column_stack([q / size[:, None], np.full(len(corners), -f[node])])
        levers = (size.sum() - size) / ((len(corners) - 1) * size.sum())
    shares = (
        np.linalg.lstsq(ways.T, y, rcond=None)[0]
        if np.isfinite(ways).all()
        else np.full(len(corners), np.nan)
    )
    own = np.zeros_like(moves)
    own[corners, :, node] = shares[:, None] * ways + levers[:, None] * (y - shares @ ways)
    if question.compliance is not None:  # open nodes follow
        own -= (own.reshape(len(own), -1) @ question.system.S @ question.compliance).reshape(
            own.shape
        )
    return replace(others, moves=moves + own)
