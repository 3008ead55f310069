"""The limit of a contact some of whose nodes stay open: the largest load factor at which a state of rest is known, and a bound from above.

The bound is that of a mixed-integer program of what holds at the corners. The nodes that are open at a corner are switched by booleans. In full, with
the corners k in their order round the cycle::

    max lam   s.t.   q_k = q0_k + lam q1_k + A v_k + B^T w_k,   |q_k| <= f p_k,   0 <= p_k <= most_pressure (1 - opened_k)
                     p_k = p0_k + lam p1_k + B v_k + C w_k,     0 <= w_k <= most_gap opened_k
                     |v_k - v_k-1| <= most_slip (opened_k + opened_k-1)

A node that is closed at two corners in a row keeps its slip, one that is open at either may touch down elsewhere. This is necessary for a state of
rest in which each node opens or closes at most once on the way from corner to corner: the largest load factor is an upper bound for this class. It is
not sufficient, for a node may slip between touching down and the next corner: a transient decides.

The largest forces and motions come from the load: with F the sum of all nodal forces of the closed contact at the worst corner, pressures are at most
2 F, and gap and slip are at most what 10 F does to one node alone, over the initial gap. `touches` says whether a solution comes to one of them.
"""

import time
from contextlib import suppress
from dataclasses import dataclass

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..contact import RESIDUAL, Attempt, ContactSystem, LimitKind, LoadCycle, SolveRecord
from ..contact.checks import Array, frozen, warns_of_odd_values, whole_number
from ..errors import FrictoptError
from ..solve.explain import Explained
from ..solve.problem import Problem
from ..solve.solvers import BoundStatus, bounds
from ..transients.mean_load import unscaled_diagnosis
from .answered import Answered
from .models import called, named
from .open_nodes import border
from .question import Question, pose
from .separated_sets import best_open_set, open_set_limit
from .shakedown import ShakedownModel
from .shakedown_result import ShakedownLimit

_ONE_LIMIT = 1e3 * RESIDUAL  # relative distance of limit and bound up to which they are one: mixed-integer programs are solved to a part of it
_RANGE, _WIDER, _ROUNDS = 2.0, 4.0, 4  # load factors that the bound covers, over the limit; how much wider where a state comes to their end
_MOST_BOOLEANS = 40  # above which a bound takes more than seconds
_PRESSURE, _MOTION = 2.0, 10.0  # of the largest forces and motions, see above
_SOFT = 1e-3  # stiffness of a node alone, over the mean one, below which it counts as this
_SMALL = 1e-3  # rows are divided by the node's reactions; by this share of their mean where they are smaller
_FAR = 64.0  # load factors at which better sets are looked for, over those of the bound
_HALF = 0.5  # what is above it is a boolean of 1
_TOUCHES = 1 - 1e-6  # share of the largest force or motion from which on a solution touches it


@dataclass(frozen=True, eq=False, repr=False)
class SeparatedLimit(Answered, Explained):
    """The largest load factor at which some nodes stay open and the others closed and stuck, and what is known above it.

    Attributes
    ----------
    load_factor
        At it and down to `least` the contact rests with the nodes `open`. Inf: at every load factor from `least` on. NaN: no such state is known, see
        `reason`.
    least
        The least load factor with the same nodes open; 0 where they rest under the mean load alone. NaN without a state, or where rounding hides it.
    bound
        Upper bound, within `covers`, of the load factors with a state of rest; inf where none is known, NaN where there is no such state.
    proven
        Whether `bound` equals `load_factor` to 1e-6: then `load_factor` is the limit, within `covers`.
    covers
        What the bound holds for, in words.
    kind, reason
        What kind of answer it is, and how it is known, in words.
    slip
        (N,) or (N, 2) slip at the last corner, length; NaN without one. `state` is the whole state there, from which a transient rests.
    record
        How it was found. Its `residual` is the largest violation of the contact law at the corners. At most 1e-9.
    problem
        The mixed-integer program of the bound, as it was solved last; None where none was, or in a copy.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [-1.0]), "N": ([0.0], [1.0])})
    >>> limit = fo.separated_limit(node, fo.LoadCycle({"P": 1.0}, [{"N": -1.0}, {"N": 1.0}]), friction=0.5)
    >>> limit.load_factor, limit.open.tolist()  # pulled open, it would touch above 1
    (1.0, [True])
    """

    _said = ("load_factor", "least", "bound", "proven", "kind", "largest_slip", "residual", "reason")
    least: float
    bound: float
    proven: bool
    covers: str
    kind: LimitKind
    reason: str
    problem: cp.Problem | None

    def to_frame(self) -> pd.DataFrame:
        """The DataFrame of the nodes: columns node, its place, slip, open, and gap at the last corner."""
        return super().to_frame().assign(open=self.open, gap=np.nan if self.state is None else self.state.gap)

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        title = f"limit with separation: load factor {self.load_factor:.12g}, bound {self.bound:.12g}"
        return title, None, None, f"{self.reason}\nbound holds {self.covers}"


@warns_of_odd_values
def separated_limit(system: ContactSystem, cycle: LoadCycle, friction: ArrayLike, *, most_sets: int = 200, most_nodes: int = 2000) -> SeparatedLimit:
    """Largest load factor at which some nodes stay open and the others closed and stuck.

    It comes from a search over sets of open nodes, one program each, that starts at the answer of `shakedown_limit` and is never less. Nodes that
    rule the limit of a set, and runs of neighbours at its borders, are opened or closed as long as one of these sets is better. The best one is
    proven to rest. `bound` is the upper bound by a mixed-integer program of what holds at the corners, for the class of cycles that `covers` names:
    nodes may open and close there. The same program looks for a better set among all of them, up to 64 times the load factors that the bound covers.
    Without a bound (in space, and with many nodes) other sets may do better. Whether a contact rests above it with nodes that open and close in each
    cycle, follows from transients: `limit_after_protocol` with `start=limit.slip` and `up_to`.

    A contact whose pressure falls to zero at its edge slips there at any load in the continuum (Barber, Klarbring & Ciavarella 2008): its limit
    belongs to the mesh, and falls with it. Theory, eq. (19).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    most_sets
        Largest number of sets of open nodes to try.
    most_nodes
        Largest number of nodes in the search tree of the mixed-integer program. With more than 40 pairs of node and corner, and in space, there is no
        bound.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> punch = fo.scenes.PunchOnHalfPlane(elements=4).condense()
    >>> rounded = punch.with_gap(2.0 * punch.x**4)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    >>> limit = fo.separated_limit(rounded, cycle, friction=0.6)
    >>> limit.proven, limit.open.tolist(), limit.load_factor >= fo.shakedown_limit(rounded, cycle, friction=0.6).load_factor
    (True, [True, False, False, False, True], True)
    """
    began = time.perf_counter()
    task, most_nodes = pose(system, cycle, friction), whole_number("most_nodes", most_nodes, least=1)
    best = best_open_set(task, whole_number("most_sets", most_sets, least=1))
    bound = _bound(task, best, most_nodes)
    while (better := _better_set(task, best, bound, most_nodes)) is not None:
        best, bound = better, _bound(task, better, most_nodes)
    largest = np.nan if best is None else best.load_factor
    proven = bool(largest == np.inf or bound.value <= largest * (1 + _ONE_LIMIT) or (best is None and np.isnan(bound.value)))
    state = None if best is None else best.state
    return SeparatedLimit(
        load_factor=float(largest),
        least=np.nan if best is None else best.least,
        bound=float(bound.value),
        proven=proven,
        covers="for cycles in which closed nodes stick and each node opens or closes at most once on the way from corner to corner"
        + (f", at load factors up to {bound.up_to:.6g}" if np.isfinite(bound.up_to) else ""),
        kind=LimitKind.NO_SAFE_SLIP if best is None else best.kind,
        reason=_reason(task, best, bound, proven),
        slip=frozen(np.full(system.slip_shape, np.nan)) if state is None else state.slip,
        record=SolveRecord("HIGHS", bound.attempts, 0.0 if best is None else best.residual, (), time.perf_counter() - began),
        problem=bound.problem,
        _task=task if best is None else best._task,
    )


@dataclass(frozen=True, eq=False)
class CornerProgram:
    """The program for load factors up to a given one, its unit, and what it considers up to a largest size: moves, gaps and pressures."""

    problem: cp.Problem
    limited: tuple[tuple[cp.Expression, Array], ...]

    @property
    def touches(self) -> bool:
        """Whether a slip, gap or pressure of the solution comes to the largest one considered."""
        return any(bool((np.abs(size.value) > _TOUCHES * most).any()) for size, most in self.limited)


def corner_program(task: Question, least: float, most: float, *, open_stay: bool = False) -> CornerProgram:
    """The program for load factors from `least` to `most` > 0, maybe of nodes that stay open; forces, lengths and load factors are dimensionless."""
    system, (corners, _, n), f, S = task.system, task.r1.shape, task.friction, task.system.S / task.system.stiffness_scale
    at_zero, cyclic = task.r0.reshape(len(task.r0), -1), most * task.r1.reshape(corners, -1)
    largest = np.abs(at_zero).max(axis=0) + np.abs(cyclic).max(axis=0)
    force = float(largest.mean()) or 1.0
    length, whole = force / system.stiffness_scale, float(largest.sum()) / force
    each = np.ones((corners, 1))
    unit = each * np.maximum(np.maximum(largest[:n], largest[n:]) / force, _SMALL)
    moves = each * _MOTION * whole / np.maximum(np.diag(S), _SOFT)
    most_slip, most_gap, most_pressure = moves[:, :n], system.gap / length + moves[:, n:], _PRESSURE * whole / unit

    lam, v, w = cp.Variable(name="load_factor"), cp.Variable((corners, n), name="slip"), cp.Variable((corners, n), name="gap")
    opened = cp.Variable((corners, n), boolean=True, name="opened")
    r0, r1 = named(each * at_zero / force, "r0"), named(cyclic / force, "r1")
    r = called(r0 + cp.multiply(lam, r1) + cp.hstack([v, w]) @ named(S, "S"), "(r0 + load_factor * r1 + [slip, gap] @ S)")
    scale, friction = named(1 / unit, "scale"), named(each * f, "f")
    q, p = cp.multiply(scale, r[:, :n]), cp.multiply(scale, r[:, n:])
    before = named(np.roll(np.eye(corners), -1, axis=0).T, "before")  # row k takes corner k - 1
    either, moved = opened + before @ opened, v - before @ v
    rows = {
        "forward_bound": cp.multiply(friction, p) + q >= 0,
        "backward_bound": cp.multiply(friction, p) - q >= 0,
        "no_tension": p >= 0,
        "no_force_across_a_gap": p <= cp.multiply(named(most_pressure, "most_pressure"), 1 - opened),
        "no_overlap": w >= 0,
        "opens": w <= cp.multiply(named(most_gap, "most_gap"), opened),
        "closed_sticks_forward": moved <= cp.multiply(named(most_slip, "most_slip"), either),
        "closed_sticks_backward": -moved <= cp.multiply(named(most_slip, "most_slip"), either),
        "least": lam >= named(least / most, "least"),
        "most": lam <= 1,
    } | ({"open_stay": opened == before @ opened} if open_stay else {})
    problem = Problem(cp.Maximize(lam), [row.set_label(name) for name, row in rows.items()])
    return CornerProgram(problem, ((moved, most_slip), (w, most_gap), (p, most_pressure)))


@dataclass(frozen=True, eq=False)
class _Bound:
    """The upper bound of load factors up to `up_to` by the mixed-integer program, and why it is what it is."""

    value: float
    why: str = ""
    up_to: float = np.inf
    attempts: tuple[Attempt, ...] = ()
    problem: cp.Problem | None = None


def _bound(task: Question, best: ShakedownLimit | None, most_nodes: int) -> _Bound:
    """The bound over ever wider ranges of load factors, as long as a state comes to their end."""
    largest, booleans = 0.0 if best is None else best.load_factor, task.r1[:, -1].size
    if largest == np.inf:
        return _Bound(np.inf)
    if task.system.tangents > 1:
        return _Bound(np.inf, "no bound, for the mixed-integer program is one of straight lines, and friction circles are not")
    if booleans > _MOST_BOOLEANS:
        return _Bound(np.inf, f"no bound, for a mixed-integer program of {booleans} booleans is not tried")
    mean, cyclic = (float(np.abs(r).sum(axis=(1, 2)).max()) for r in (task.r0, task.r1))
    begin, attempts = _RANGE * (largest or (mean / cyclic if mean > 0 and cyclic > 0 else 1.0)), list[Attempt]()
    for up_to in (begin * _WIDER ** np.arange(_ROUNDS)).tolist():
        program = corner_program(task, largest * (1 - _ONE_LIMIT), up_to)
        found = bounds(program.problem, most_nodes)
        attempts.append(Attempt("HIGHS", f"load factors up to {up_to:.6g}: {found.status.value}{'; ' * bool(found.why)}{found.why}", 0.0))
        value, why = np.inf, ""
        if found.status is BoundStatus.INFEASIBLE:
            value, why = (np.nan, "") if best is None else (np.inf, "it is outside of what the bound covers")
        elif found.status is not BoundStatus.OPEN and program.touches:
            why = "a big-M bound is active, so there is no upper bound"
        elif found.bound < 1 - _ONE_LIMIT:
            value, why = max(found.bound * up_to, largest), "above it the mixed-integer program allows states that open and close in each cycle"
        elif found.status is not BoundStatus.OPTIMAL:
            why = f"no bound, for {found.why}" + "; `separated_limit(..., most_nodes=...)` gives it more" * ("nodes" in found.why)
        if why or np.isnan(value):
            break
    else:
        why = "no bound, for at the corners the mixed-integer program allows states at any load factor"
    return _Bound(value, why, up_to, tuple(attempts), program.problem)


def _better_set(task: Question, best: ShakedownLimit | None, bound: _Bound, most_nodes: int) -> ShakedownLimit | None:
    """The limit of the open nodes of the best state in which none closes, by the program, if it is above that of the best set so far.

    The load factors are those of the bound, and then far larger ones: nodes that corners lift may rest open again far above where they slip.
    """
    least = 0.0 if best is None else best.load_factor * (1 + _ONE_LIMIT)
    for up_to in () if bound.problem is None else (bound.up_to,) * (bound.value > least) + (_FAR * bound.up_to,):
        program = corner_program(task, least, up_to, open_stay=True)
        if bounds(program.problem, most_nodes).status in (BoundStatus.OPTIMAL, BoundStatus.FOUND):
            with suppress(FrictoptError):  # one without an answer that passes the checks is none of those known to rest
                found = open_set_limit(ShakedownModel(task.system, task.cycle), task, program.problem.var_dict["opened"].value[0] > _HALF)
                if found is not None and (best is None or found.load_factor > least):
                    return found
    return None


def _reason(task: Question, best: ShakedownLimit | None, bound: _Bound, proven: bool) -> str:
    if best is None:
        none = f", and the mixed-integer program finds none at load factors up to {bound.up_to:.6g}" if proven else ""
        return f"no set of open nodes is known to rest{none}: {unscaled_diagnosis(task.system, task.cycle, task.friction)}"
    start = " from some on, which rounding hides" if np.isnan(best.least) else f" from {best.least:.6g} on" if best.least > 0 else ""
    nodes = f"{int(best.open.sum())} of {task.system.nodes} nodes"
    if best.load_factor == np.inf:
        return f"the limit is infinite: the contact rests with {nodes} open at every load factor{start}"
    text = f"the contact rests with {nodes} open at all load factors up to this one{start}"
    text += border(task.system, best.open, int(best.mechanism["node"][0]), best.reactions[1]) if len(best.mechanism) else ""
    return f"{text}; {f'the mixed-integer program finds no state above it up to {bound.up_to:.6g}' if proven else bound.why}"
