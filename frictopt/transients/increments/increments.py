"""One friction increment in three dimensions: the problem as posed, and its answer by the engine "newton" or "socp"."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import chain
from time import perf_counter
from typing import IO, Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ...contact import friction_coefficients, referee
from ...contact.checks import Array, choice, finite_array, frozen
from ...contact.parts import joined, parted
from ...contact.record import Attempt, Recorded, SolveRecord
from ...contact.show import frame
from ...contact.system import ContactSystem, checked_system
from ...contact.tolerances import NO_FORCE, RESIDUAL, SETTLED_BOUND, SWEEP_OF_CONES
from ...errors import ModelError, SolverError
from ...solve.explain import explain
from ...solve.solvers import Kind, solve
from .free_motion import free_motions, moves_away
from .projected import OPEN, SLIP, Law3D, State3D, by_friction, newton

__all__ = ["Increment3D", "Increments3D"]

_SWEEPS = 100  # cone programs for one increment at most
_SCALES = (1.0, 10.0, 0.1, 100.0, 0.01)  # of the c and d of Newton's method, tried in this order


@dataclass(frozen=True, eq=False, repr=False)
class Increment3D(Recorded):
    """The state after one increment of load, judged by the referee.

    Attributes
    ----------
    slip
        (N, 2) slip v along the tangents, length. Nodes that stick keep their slip bit for bit.
    gap
        (N,) total gap w (initial gap included), length, >= 0.
    q, p
        (N, 2) shear forces and (N,) normal forces, compression positive.
    status
        (N,) 0 sticks, 1 slips, 2 is open.
    steps
        Steps of Newton's method, or cone programs with frozen friction bound.
    record
        How it was found. Its `residual` is the referee's, with the slip before the increment as the previous one. At most 1e-9.
    problem
        The last cone program of the engine "socp"; None for "newton", and in a copy.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [1, 0, 0]})
    >>> fo.Increments3D(node, friction=0.5).solve([[0.0, 0.0]], node.reaction({"P": 1.0, "Q": 2.0}))
    Increment3D(nodes=1, slipping=1, open=0, residual=0, solver=NEWTON)
    """

    slip: Array
    gap: Array
    q: Array
    p: Array
    status: np.ndarray[Any, np.dtype[np.int8]]
    steps: int
    record: SolveRecord
    problem: cp.Problem | None = field(repr=False)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, slip1, slip2, gap, q1, q2, p and status."""
        parts = {"slip1": self.slip[:, 0], "slip2": self.slip[:, 1], "gap": self.gap, "q1": self.q[:, 0], "q2": self.q[:, 1], "p": self.p}
        return frame({"node": range(len(self.slip)), **parts, "status": self.status})

    def _answer(self) -> Mapping[str, Any]:
        counts = {name: int((self.status == value).sum()) for name, value in (("slipping", SLIP), ("open", OPEN))}
        return {"nodes": len(self.slip), **counts, "residual": self.residual, "solver": self.record.solver}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the last cone program by its names."""
        explain("friction increment, frozen bound", self.problem, None, {}, (), None, file)


def frozen_bound_cones(law: Law3D) -> cp.Problem:
    """The increment with the friction bound g of every node given, as a convex program (Klarbring, Mikelic & Shillor 1988).

    In full, over `u = [dv, w]`::

        min 1/2 u' S u + trial' u + sum g |dv|   s.t.   w >= 0

    Its optimality conditions are the contact law with g in place of f p. The law itself is the fixed point `g = f p`.
    """
    n = len(law.friction)
    dv, w = cp.Variable((n, 2), name="slip_increment"), cp.Variable(n, name="gap")
    trial, bound = cp.Parameter(3 * n, name="trial_reaction"), cp.Parameter(n, nonneg=True, name="friction_bound")
    u = cp.hstack([cp.vec(dv, order="F"), w])
    energy = cp.quad_form(u, cp.psd_wrap(law.S)) / 2 + trial @ u
    return cp.Problem(cp.Minimize(energy + bound @ cp.norm(dv, axis=1)), [(w >= 0).set_label("no_overlap")])


class Increments3D:
    """One friction increment after another of the same contact.

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.
    engine
        "newton": Newton's method on the projected law; "socp": cone programs with frozen friction bound, compiled once, to print and read. Each sweep
        moves the bound to `f p`; when it settles, Newton's method makes the state exact.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [0.6, 0.8, 0]})
    >>> increments = fo.Increments3D(node, friction=0.5)
    >>> found = increments.solve(slip=[[0.0, 0.0]], bonded=node.reaction({"P": 1.0, "Q": 2.0}))
    >>> found.slip.round(6).tolist(), found.q.round(6).tolist()
    ([[-0.9, -1.2]], [[0.3, 0.4]])
    """

    def __init__(self, system: ContactSystem, friction: Any, *, engine: str = "newton") -> None:
        self.system, self.friction = checked_system(system), friction_coefficients(friction, system.nodes)
        self.engine = choice("engine", engine, ("newton", "socp"))
        S = frozen(system.S / system.stiffness_scale)
        own = (system.own_stiffness / system.stiffness_scale).reshape(3, -1)
        tangent = own[:2].mean(axis=0)
        self._law = Law3D(S, self.friction, np.tile(own.max(axis=0), 3))
        self._by_direction = Law3D(S, self.friction, np.concatenate([tangent, tangent, own[2]]))

    @cached_property
    def free(self) -> Array:
        """(3N, k) orthonormal motions of the nodes that S does not resist."""
        return free_motions(self._law.S, self._law.own)

    @cached_property
    def problem(self) -> cp.Problem:
        """The cone program with frozen bound."""
        return frozen_bound_cones(self._law)

    def solve(self, slip: Any, bonded: Any) -> Increment3D:
        """A state to which a slip can move under a load.

        Parameters
        ----------
        slip
            (N, 2) slip before the increment, length.
        bonded
            `(q^w, p^w)`, (N, 2) and (N,) bonded reactions of the load after it, force.

        Raises
        ------
        ModelError
            Arrays that do not fit.
        NoContinuation
            No state is found, and the loads push a motion that only friction resists.
        SolverError
            No answer that passes the referee.
        """
        try:
            q, p = bonded
        except (TypeError, ValueError) as error:
            raise ModelError(f"bonded: not a pair; give (q, p), arrays of shapes {(self.system.nodes, 2)} and {(self.system.nodes,)}") from error
        n = self.system.nodes
        return _Posed(self, finite_array("slip", slip, (n, 2)), finite_array("bonded q", q, (n, 2)), finite_array("bonded p", p, (n,))).solved()


class _Posed:
    """One increment in units of the mean normal force and of the slip that this force makes."""

    def __init__(self, owner: Increments3D, slip: Array, q: Array, p: Array) -> None:
        self._owner, self._slip, self._bonded, self._started = owner, slip, (q, p), perf_counter()
        system = owner.system
        reactions = joined(q, p) + system.S @ joined(slip, -system.gap)
        force = float(np.abs(p).mean())
        self._force = force if force > NO_FORCE * np.abs(reactions).max() else float(np.abs(reactions).mean()) or 1.0
        self._length = self._force / system.stiffness_scale
        self._trial = reactions / self._force

    def solved(self) -> Increment3D:
        try:
            return self._by_newton() if self._owner.engine == "newton" else self._by_sweeps()
        except SolverError as error:
            raise moves_away(self._owner.system, self._owner.friction, self._owner.free, self._force * self._trial, self._force) or error from None

    def _by_newton(self) -> Increment3D:
        """By Newton's method from no motion, then from the states of less friction; by c of nodes, and of directions; last by cone programs."""
        trial, least = self._trial, np.inf
        still, laws = np.zeros_like(trial), (self._owner._law, self._owner._by_direction)
        at_once = (newton(replace(law, own=scale * law.own), trial, still) for law in laws for scale in _SCALES)
        states = chain(at_once, (by_friction(law, trial) for law in laws))
        for state in states:
            found = self._judged(state, "NEWTON")
            if found.residual <= RESIDUAL:
                return found
            least = min(least, found.residual)
        try:
            return self._by_sweeps()
        except SolverError:
            raise SolverError(
                f"friction increment: Newton's method leaves a residual of {least:.1e} (tolerance {RESIDUAL:g}), and cone programs find no state "
                "either; try smaller load steps, or less friction (above the critical friction there may be no state, or several)"
            ) from None

    def _by_sweeps(self) -> Increment3D:
        law, problem, n = self._owner._law, self._owner.problem, len(self._slip)
        bound = law.friction * np.maximum(self._trial[2 * n :], 0.0)
        residual, change, attempts = np.inf, np.inf, list[Attempt]()
        for sweep in range(1, _SWEEPS + 1):
            problem.param_dict["trial_reaction"].value, problem.param_dict["friction_bound"].value = self._trial, bound
            answer = solve(_Sweep(problem), partial(self._swept, bound), kind=Kind.SOCP, tolerance=SWEEP_OF_CONES)
            attempts += answer.attempts
            u = answer.claim.u
            free = law.friction * np.maximum((self._trial + law.S @ u)[2 * n :], 0.0)
            change, bound = float(np.abs(free - bound).max()), free
            if change <= SETTLED_BOUND:
                state = newton(law, self._trial, u)
                found = self._judged(replace(state, steps=sweep), answer.solver, tuple(attempts), problem)
                if found.residual <= RESIDUAL:
                    return found
                residual = found.residual
                break
        left = "" if np.isinf(residual) else f", and the state of that bound violates the law by {residual:.1e}"
        raise SolverError(
            f"friction increment: after {sweep} cone programs with frozen bound it still changes by {change:.1e} of the mean normal force{left}; try "
            "smaller load steps or the engine 'newton' (above the critical friction there may be no state, or several)"
        )

    def _swept(self, bound: Array) -> "_SweepClaim":
        """What stands in the variables, with its largest violation of the optimality conditions of the frozen problem."""
        values, law = self._owner.problem.var_dict, self._owner._law
        dv, w = np.asarray(values["slip_increment"].value), np.maximum(np.asarray(values["gap"].value), 0.0)
        u = joined(dv, w)
        q, p = parted(self._trial + law.S @ u, 3)
        slid = np.linalg.norm(dv, axis=1)
        sense = dv / np.where(slid > 0, slid, 1.0)[:, None]
        off = np.minimum(slid, np.linalg.norm(q + bound[:, None] * sense, axis=1))
        residual = float(max((np.linalg.norm(q, axis=1) - bound).max(), off.max(), -p.min(), np.minimum(w, p).max(), 0.0))
        return _SweepClaim(u, residual if np.isfinite(residual) else np.inf)

    def _judged(self, state: State3D, solver: str, attempts: tuple[Attempt, ...] = (), problem: cp.Problem | None = None) -> Increment3D:
        """The state in the caller's units, with what the referee says of it."""
        owner = self._owner
        (dv, w), (q, p) = parted(state.u, 3), parted(self._force * state.r, 3)
        slip = np.where(dv != 0, self._slip + self._length * dv, self._slip)
        gap = self._length * np.maximum(w, 0.0)
        if not (np.isfinite(state.u).all() and np.isfinite(state.r).all()):
            residual = np.inf
        else:
            before = self._slip
            residual = referee(
                owner.system, self._bonded, owner.friction, v=slip, w=gap, q=q, p=p, previous_slip=before, force_scale=self._force
            ).residual
        status = state.status.astype(np.int8)
        status.flags.writeable = False
        record = SolveRecord(solver, attempts, residual, (), perf_counter() - self._started)
        return Increment3D(frozen(slip), frozen(gap), frozen(q), frozen(p), status, state.steps, record, problem)


@dataclass(frozen=True, eq=False)
class _SweepClaim:
    """Motions of a sweep and their largest violation."""

    u: Array
    residual: float


@dataclass
class _Sweep:
    """A cone program whose solution needs no more than its solver's accuracy."""

    problem: cp.Problem

    def refine(self) -> None:
        """Leave the solution as it is: it only guides the next sweep."""
