"""A friction increment by sweeps over the nodes and Newton's method."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.linalg.lapack import dpocon

from ...base import (
    RESIDUAL,
    ROUNDING,
    STALLED,
    Array,
    Booleans,
    PerNode,
    warns_of_odd_values,
)
from ...contact import (
    ContactSystem,
    checked_system,
    contact_law,
    friction_coefficients,
    joined,
    parted,
)
from ...errors import SolverError
from ..statics import check_sliding
from ..transient import HOLD, OPEN
from .increment import Increment, Posed, force_scale, sizes_of
from .newton import Law, State, newton
from .sweeps import increment, reactions

# Factors of the c and d of Newton's method, tried in this order.
_SCALES = (1.0, 10.0, 0.1, 100.0, 0.01)


Moved = tuple[Array, Array, NDArray[np.int8]]
"""Motions `u = [v, w - g0]` and reactions, (M,), and status (N,)."""


class _Nodes:
    """Nodes that move from increment to increment.

    They have a dimensionless law, the `sizes` of `sizes_of`, and the unit of their stiffness.
    """

    def __init__(self, law: Law, sizes: Array, gap: Array, unit: float) -> None:
        self.law = law
        self._sizes = sizes
        self._gap = gap
        self._unit = unit
        # Whether sweeps have failed once. From then on, open nodes are eliminated.
        self.sweeps_failed = False

    def _moved(self, u: Array, r: Array, force: float) -> Moved | None:
        """The state that follows motions u, whose reactions r include the change of the load.

        The iteration begins with the gaps before the increment. None if no state is found that
        obeys the law to rounding.
        """
        n = len(self._gap)
        length = force / self._unit
        law = self.law.per_force(force)
        begin = np.concatenate([np.zeros(len(u) - n), u[-n:] + self._gap]) / length
        state = self._swept(begin.copy(), r / force, law)
        if state.error > ROUNDING:
            self.sweeps_failed = True
            state = self._by_newton(law, reactions(law.S, r / force, -begin), state.u)
            if not state.error <= STALLED:
                return None
        gap = length * np.maximum(state.u[-n:], 0.0)
        moved = np.concatenate([u[:-n] + length * state.u[:-n], gap - self._gap])
        return moved, force * state.r, state.status

    def _by_newton(self, law: Law, trial: Array, start: Array) -> State:
        return newton(law, trial, start if np.isfinite(start).all() else np.zeros_like(start))

    def _swept(self, u: Array, r: Array, law: Law) -> State:
        """The state after sweeps from motions u and reactions r, which change in place."""
        forces = np.empty_like(r)
        status = np.empty(len(u) // len(law.augmentation), dtype=np.int8)
        error = increment(
            law.S,
            law.slopes,
            law.constants,
            law.augmentation,
            self._sizes,
            u,
            r,
            forces,
            status,
        )
        return State(u, forces, status, 0, error)


@warns_of_odd_values
class NewtonIncrement(_Nodes):
    """A friction increment by Gauss-Seidel sweeps over the nodes, then by Newton's method.

    The sweeps often reach the state to rounding; the solver of the record is then "SWEEPS".
    Otherwise Newton's method on the projected law begins where the sweeps end. If it does not
    converge, it begins again without motion, with several constants of the projection, and at last
    from states of convex programs with frozen friction bounds. If several states obey the law
    (above the critical friction), one of them is returned. Theory, eq. (4).

    Parameters
    ----------
    system
        The contact.
    friction
        Coefficient of friction, one or one per node.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [0.6, 0.8, 0]})
    >>> increment = fo.increments.NewtonIncrement(node, friction=0.5)
    >>> found = increment.solve(slip=[[0.0, 0.0]], bonded=node.reaction({"P": 1.0, "Q": 2.0}))
    >>> found.slip.round(6).tolist(), found.q.round(6).tolist()
    ([[-0.9, -1.2]], [[0.3, 0.4]])
    """

    retries = True
    """Whether `along` calls `solve` for increments whose states it does not find at once."""

    def __init__(self, system: ContactSystem, friction: PerNode) -> None:
        self.system = checked_system(system)
        self.friction = friction_coefficients(friction, system)
        self.contact_law = contact_law(system, self.friction)
        # (t + 1, N) dimensionless stiffness of each direction of each node.
        stiffness = (system.own_stiffness / system.stiffness_scale).reshape(-1, system.nodes)
        S = system.S / system.stiffness_scale
        # c and d of Newton's method (`newton.py`) are the same in all directions of a node. The
        # constants are in the units of the caller.
        augmentation = np.tile(stiffness.max(axis=0), (len(stiffness), 1))
        law = Law(S, self.contact_law.slopes, self.contact_law.constants, augmentation)
        super().__init__(law, sizes_of(S, stiffness), system.gap, system.stiffness_scale)
        # Another c and d, for tangents and normals of very different stiffness.
        tangents = np.tile(stiffness[:-1].mean(axis=0), (system.tangents, 1))
        self._of_directions = np.vstack([tangents, stiffness[-1]])
        # The nodes that remained in the last increment with an elimination.
        self._rest: _Rest | None = None
        # Nodes that landed while they were eliminated: they are never eliminated again.
        self._landed = np.zeros(system.nodes, dtype=bool)

    def solve(
        self,
        slip: ArrayLike,
        bonded: Sequence[ArrayLike],
        form: Literal["qp", "complementarity", "milp"] | None = None,
    ) -> Increment:
        """Find a state to which the slip can move under a load.

        Parameters
        ----------
        slip
            Slip before the increment, (N,) in the plane, (N, 2) in space, length.
        bonded
            `(q^w, p^w)`, bonded reactions of the load after the increment, in the shape of `slip`
            and (N,): force per depth in the plane, force in space.
        form
            The cvxpy problem of the result, whose variables hold the state, see
            `Trajectory.increment`. None: the result has no problem.

        Raises
        ------
        ModelError
            Arrays that do not fit, or a form that the contact does not have.
        NoContinuation
            Friction cannot hold the load.
        SolverError
            No answer passes the check of the contact law. A state that obeys the law may exist.
        """
        posed = Posed(self, slip, bonded)
        try:
            found = self._solved(posed)
        except SolverError:
            check_sliding(self.system, self.friction, {"the load": joined(*posed.bonded)})
            raise
        return found if form is None else _in_form(posed, found, form)

    def held(
        self, slip: Array, bonded: Sequence[Array], after: tuple[Array, Array], form: str
    ) -> Increment:
        """The increment from a slip to a known slip and gap `after`, in a form of `solve`."""
        posed = Posed(self, slip, bonded)
        u = joined(after[0] - slip, after[1]) / posed.length
        state = newton(posed.law, posed.trial, u, most=0)
        return _in_form(posed, posed.result(state, "NEWTON"), form)

    def along(self, u: Array, loads: Sequence[Array]) -> Iterator[Moved]:
        """Solve one increment after the other, for several loads (M,), from `u` (M,) on.

        Yields `u = [v, w - g0]` (M,), reactions (M,) and status (N,) after each load. Raises the
        errors of `solve`. The iteration of each increment begins with the gaps of the previous
        state, and with its reactions plus the change of the load. After sweeps have failed once,
        open nodes are eliminated as long as they stay open.
        """
        n = self.system.nodes
        for load in loads:
            r = load + self.system.S @ u
            force = force_scale(load[-n:], r)
            moved = self._without_open(u, r, force) if self.sweeps_failed else None
            if moved is None:
                moved = self._moved(u, r, force)
                if moved is None and not self.retries:
                    raise SolverError("friction increment: Newton's method finds no state at once")
                moved = moved or self._solved_by_itself(u, load)
            u = moved[0]
            yield moved

    def _without_open(self, u: Array, r: Array, force: float) -> Moved | None:
        """A state with open nodes eliminated, except those that would land in the increment.

        None if no open node is left, or if the nodes that remain have no state that obeys the law.
        """
        opened = (u[-self.system.nodes :] + self._gap > 0) & ~self._landed
        while opened.any() and not opened.all():
            if self._rest is None or (opened != self._rest.opened).any():
                try:
                    self._rest = _Rest(self.law, self._gap, self._unit, opened)
                except LinAlgError:
                    return None
            moved = self._rest.after(u, r, force)
            if moved is None:
                return None
            gap = moved[0][-len(opened) :] + self._gap
            lands = opened & (gap < -STALLED * force / self._unit)
            if not lands.any():
                off = np.abs(reactions(self.system.S, r, moved[0] - u) - moved[1]).max()
                return moved if off <= STALLED * force else None
            self._landed |= lands
            opened = opened & ~lands
        return None

    def _solved_by_itself(self, u: Array, load: Array) -> Moved:
        """The state of the increment by `solve`, as if it were the first one."""
        axes = self.system.tangents + 1
        new = self.solve(parted(u, axes)[0], parted(load, axes))
        return joined(new.slip, new.gap - self._gap), joined(new.q, new.p), new.status

    def _solved(self, posed: Posed) -> Increment:
        """The state by sweeps or, if they do not reach it, by Newton's method from all `_ways`."""
        state = self._swept(np.zeros_like(posed.trial), posed.trial.copy(), posed.law)
        if state.error <= ROUNDING:
            return posed.result(state, "SWEEPS", state.error)
        residual = np.inf
        for law, start in self._ways(posed, state.u):
            answer = posed.result(self._by_newton(law, posed.trial, start), "NEWTON")
            if answer.residual <= RESIDUAL:
                return answer
            residual = min(residual, answer.residual)
        remedy = (
            "try smaller load steps, or less friction (above the critical friction there may be no "
            "state, or several)"
        )
        if self.system.rigid_motions.size:
            remedy = (
                "the body may slide or open as a whole, or friction is above the critical value "
                f"there: {HOLD}"
            )
        raise SolverError(
            f"friction increment: Newton's method leaves a residual of {residual:.1e} "
            f"(tolerance {RESIDUAL:g}); {remedy}"
        )

    def _ways(self, posed: Posed, swept: Array) -> Iterator[tuple[Law, Array]]:
        """Laws and starts of Newton's method, in the order in which they are tried.

        The starts are the end of the sweeps, then no motion with several c and d, and then the
        states of convex programs with frozen friction bounds.
        """
        law = posed.law
        yield law, swept
        no_motion = np.zeros_like(posed.trial)
        for augmentation, scale in product((law.augmentation, self._of_directions), _SCALES):
            yield replace(law, augmentation=scale * augmentation), no_motion
        # Imported here, because cvxpy is slow to import.
        from .programs import with_frozen_bounds

        for u in with_frozen_bounds(self.system, law, posed.trial):
            yield law, u


def _in_form(posed: Posed, found: Increment, form: str) -> Increment:
    # Imported here, because cvxpy is slow to import.
    from .programs import in_form

    return in_form(posed, found, form)


class _Rest(_Nodes):
    """The nodes that remain if open nodes are eliminated.

    Open nodes have no reactions, so their motions follow from the motions of the other nodes.
    """

    def __init__(self, law: Law, gap: Array, unit: float, opened: Booleans) -> None:
        axes, remaining = len(law.augmentation), ~opened
        self.opened = opened
        # Motions of the eliminated nodes, and of the nodes that remain.
        self._out = np.flatnonzero(np.tile(opened, axes))
        self._in = np.flatnonzero(np.tile(remaining, axes))
        block = law.S[np.ix_(self._out, self._out)]
        between = law.S[np.ix_(self._out, self._in)]
        self._factor = cho_factor(block)
        if not dpocon(self._factor[0], np.abs(block).sum(axis=0).max())[0] > ROUNDING:
            raise LinAlgError("the open nodes move freely")
        # A row for each remaining motion: the motions of the open nodes due to it, times -1.
        self._carried = np.ascontiguousarray(cho_solve(self._factor, between).T)
        S = law.S[np.ix_(self._in, self._in)] - self._carried @ between
        size = np.diag(S).reshape(axes, -1)
        # A stiffness as small as rounding holds nothing.
        before = law.augmentation[:, remaining]
        size = np.where(size > ROUNDING * before, size, before)
        reduced = Law(
            S,
            law.slopes[:, remaining],
            law.constants[:, remaining],
            np.tile(size.max(axis=0), (axes, 1)),
        )
        super().__init__(reduced, sizes_of(S, size), gap[remaining], unit)

    def after(self, u: Array, r: Array, force: float) -> Moved | None:
        """The state of all nodes after motions u, whose reactions r include the change of load."""
        acting = cho_solve(self._factor, r[self._out])
        found = self._moved(u[self._in], r[self._in] - self._carried @ r[self._out], force)
        if found is None:
            return None
        moved = u.copy()
        forces = np.zeros_like(u)
        status = np.full(len(self.opened), OPEN, dtype=np.int8)
        moved[self._in], forces[self._in], status[~self.opened] = found
        change = (moved - u)[self._in]
        moved[self._out] -= reactions(self._carried, acting / self._unit, change)
        return moved, forces, status
