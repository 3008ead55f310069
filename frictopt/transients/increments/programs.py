"""One friction increment as cvxpy programs: convex ones with the friction bound frozen in turn, or one with booleans. Unknowns: `u = [dv, w]`.

With the bound g of every node given, the increment minimises (Klarbring, Mikelic & Shillor 1988: friction with a given bound)::

    1/2 u' S u + trial' u + sum g |dv|    over  u = [dv, w],  w >= 0

because its optimality conditions are the contact law with g in place of f p. The law itself is the fixed point `g = f p`. In the plane it is a
quadratic program; in space the lengths |dv| make cones.

In the mixed-integer program each node sticks, slips along or against +x, or is open: the law itself, with the reactions `[q, p] = trial + S u` and
one boolean for each status but sticking. It is for plane contacts: the friction circle of space has no two sides.
"""

from dataclasses import replace
from functools import cached_property

import cvxpy as cp
import numpy as np
from numpy.typing import ArrayLike

from ...contact import RESIDUAL, Array, Attempt, ContactSystem, SolveRecord, checked_plane, finite_number, joined
from ...errors import NoContinuation, SolverError
from ...solve.solvers import NoOptimum, solve
from ..begin import OPEN
from .increment import FrictionIncrement, Increment, Posed
from .newton import newton

_SETTLED_BOUND = 1e4 * RESIDUAL  # change of the frozen bound up to which more sweeps find nothing else
_SWEEPS = 100  # programs for one increment at most
_BOOLEANS = {"forward": 1, "backward": -1, "opened": OPEN}
_TOUCHES = 0.999  # share of the largest motion or pressure from which on a state touches it


class FrozenBoundIncrement(FrictionIncrement):
    """One friction increment by convex programs with frozen friction bound, compiled once.

    After each sweep a few steps of Newton's method make the state that the program ends with exact, with the bound free; if the referee accepts it,
    it is the answer. Otherwise the bound moves to `f p` and the program is solved again. This need not converge where friction and coupling are
    strong. The `problem` of a result is the program of the last sweep, with the bound of that sweep.

    It takes no constraints of your own: they would act as forces that the contact law does not have. Theory, eq. (11).

    Parameters
    ----------
    system
        The contact, in the plane or in space.
    friction
        Coefficient of friction, one or one per node.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
    >>> load = system.reaction({"P": 1.0, "Q": 1.0})
    >>> fo.increments.FrozenBoundIncrement(system, friction=0.5).solve([0.0, 0.0], load).slip.round(6).tolist()
    [-0.326531, -0.122449]
    """

    _title = "friction increment, frozen bound"

    @cached_property
    def problem(self) -> cp.Problem:
        """The program."""
        t, n = len(self.law.own) - 1, len(self.friction)
        dv, w = cp.Variable(n if t == 1 else (n, t), name="slip_increment"), cp.Variable(n, name="gap")
        trial, bound = cp.Parameter((t + 1) * n, name="trial_reaction"), cp.Parameter(n, nonneg=True, name="friction_bound")

        u = cp.hstack([cp.vec(dv, order="F"), w])
        energy = cp.quad_form(u, cp.psd_wrap(self.law.S)) / 2 + trial @ u
        dissipation = bound @ (cp.abs(dv) if t == 1 else cp.norm(dv, axis=1))
        return cp.Problem(cp.Minimize(energy + dissipation), [(w >= 0).set_label("no_overlap")])

    def _solved(self, posed: Posed) -> Increment:
        law, n, values, attempts = self.law, len(self.friction), self.problem.param_dict, list[Attempt]()
        bound = law.friction * np.maximum(posed.trial[-n:], 0.0)
        for sweep in range(1, _SWEEPS + 1):
            values["trial_reaction"].value, values["friction_bound"].value = posed.trial, bound
            try:
                found, record = solve(self.problem, lambda: posed.claim(self._motions(), self.problem), tolerance=np.inf)  # it guides the next one
            except SolverError as error:
                raise SolverError(
                    f"friction increment: no state of rest is found with the friction bound frozen at {bound.sum():.3g} mean normal forces in sum "
                    f"(where slip would raise the pressure enough to hold it, another increment may find the state); {self._remedy}"
                ) from error
            attempts += record.attempts
            if found.residual <= RESIDUAL:
                return replace(found, steps=sweep, record=replace(found.record, solver=record.solver, attempts=tuple(attempts)))
            step = law.friction * np.maximum((posed.trial + law.S @ self._motions())[-n:], 0.0) - bound
            if np.abs(step).max() <= _SETTLED_BOUND:
                break
            bound = bound + step
        raise SolverError(
            f"friction increment: did not converge in {sweep} sweeps with frozen bound; the bound still changes by {np.abs(step).max():.1e} of the "
            f"mean normal force, most at node {int(np.abs(step).argmax())}, and the residual is {found.residual:.1e}; {self._remedy}, or another "
            "increment"
        )

    def _motions(self) -> Array:
        """The motions that stand in the variables."""
        values = self.problem.var_dict
        return joined(np.asarray(values["slip_increment"].value), np.maximum(np.asarray(values["gap"].value), 0.0))


class ExactIncrement(FrictionIncrement):
    """One friction increment by the contact law itself as a mixed-integer program, compiled once.

    The program decides the status of every node. A few steps of Newton's method make the state exact, and the referee judges it. The objective counts
    the nodes whose status differs from that of a `NewtonIncrement`: it only says where to look first. Without it contacts of 40 nodes take minutes.
    The effort can grow exponentially with the number of nodes where the guess is wrong.

    Where several states obey the law (above the critical friction) one of them is returned. The program takes no constraints of your own.
    Theory, eq. (4).

    Parameters
    ----------
    system
        The contact, in the plane.
    friction
        Coefficient of friction, one or one per node.
    reach
        Largest motion and pressure that the program considers, over those of the trial state or, where it obeys the law, of the Newton state;
        above 1. Far larger values blur the booleans, which solvers keep to a tolerance.

    Raises
    ------
    ModelError
        Bad input.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, -1], [-1, 2]],
    ...     B=[[0, 0.5], [-0.5, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"P": ([0, 0], [1, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
    >>> load = system.reaction({"P": 1.0, "Q": 1.0})
    >>> fo.increments.ExactIncrement(system, friction=0.5).solve([0.0, 0.0], load).slip.round(6).tolist()
    [-0.326531, -0.122449]
    """

    _title = "friction increment, mixed-integer"

    def __init__(self, system: ContactSystem, friction: ArrayLike, *, reach: float = 1e3) -> None:
        self._reach = finite_number("reach", reach, above=1.0)
        super().__init__(checked_plane(system, "choose NewtonIncrement or FrozenBoundIncrement"), friction)

    @cached_property
    def problem(self) -> cp.Problem:
        """The mixed-integer program."""
        n, f = len(self.friction), self.friction
        dv, w = cp.Variable(n, name="slip_increment"), cp.Variable(n, name="gap")
        forward, backward, opened = (cp.Variable(n, boolean=True, name=name) for name in _BOOLEANS)
        trial, expected = cp.Parameter(2 * n, name="trial_reaction"), cp.Parameter((3, n), name="expected_status")
        largest = cp.Parameter(nonneg=True, name="largest")  # motion and pressure; with it 2 f largest bounds f p + q and f p - q

        r = trial + self.law.S @ cp.hstack([dv, w])
        q, bound, p = r[:n], cp.multiply(f, r[n:]), r[n:]
        rows = {
            "one_status": forward + backward + opened <= 1,
            "slips_forward": dv <= largest * (forward + opened),
            "slips_backward": -dv <= largest * (backward + opened),
            "no_overlap": w >= 0,
            "opens": w <= largest * opened,
            "no_tension": p >= 0,
            "no_force_across_a_gap": p <= largest * (1 - opened),
            "forward_bound": bound + q >= 0,
            "on_forward_bound": bound + q <= largest * cp.multiply(2 * f, 1 - forward),
            "backward_bound": bound - q >= 0,
            "on_backward_bound": bound - q <= largest * cp.multiply(2 * f, 1 - backward),
        }
        unexpected = cp.sum(cp.multiply(1 - 2 * expected, cp.vstack([forward, backward, opened])))  # but for a constant, how many booleans differ
        return cp.Problem(cp.Minimize(unexpected), [row.set_label(name) for name, row in rows.items()])

    def _solved(self, posed: Posed) -> Increment:
        guess = newton(self.law, posed.trial, np.zeros_like(posed.trial))
        known = posed.result(guess, SolveRecord("NEWTON")).residual <= RESIDUAL
        largest = self._reach * max(1.0, float(np.abs(np.r_[posed.trial, guess.u, guess.r] if known else posed.trial).max()))
        values = self.problem.param_dict
        values["trial_reaction"].value, values["largest"].value = posed.trial, largest
        values["expected_status"].value = np.array([guess.status == status for status in _BOOLEANS.values()], dtype=np.float64)
        within = f"slip increments and gaps up to {largest * posed.length:.3g} and pressures up to {largest * posed.force:.3g}"
        try:
            found, record = solve(self.problem, lambda: posed.claim(self._motions(), self.problem))
        except NoOptimum as error:
            if known:  # it disproves what the solvers say
                raise SolverError(
                    f"mixed-integer increment: the solvers find no state with {within}, but Newton's method does; give a smaller reach than "
                    f"{self._reach:g}"
                ) from error
            raise NoContinuation(
                f"friction increment: no state obeys the law under this load with {within}; larger ones were not looked for (reach {self._reach:g}). "
                "Reduce friction below the critical value, take another load, or give a larger reach"
            ) from error
        moved = max(np.abs(found.slip - posed.slip).max(), found.gap.max()) / posed.length
        if max(moved, found.p.max() / posed.force) >= _TOUCHES * largest:
            raise SolverError(f"mixed-integer increment: the state that was found touches {within}; give a larger reach than {self._reach:g}")
        return replace(found, record=replace(found.record, solver=record.solver, attempts=record.attempts))

    def _motions(self) -> Array:
        """The motions that stand in the variables, those that their booleans forbid at zero."""
        values = {name: variable.value for name, variable in self.problem.var_dict.items()}
        forward, backward, opened = (values[name] > 0.5 for name in _BOOLEANS)
        motions: Array = np.r_[np.where(forward | backward | opened, values["slip_increment"], 0.0), np.where(opened, values["gap"], 0.0)]
        return motions
