"""One friction increment by sweeps over the nodes and Newton's method: the quick way, in the plane and in space."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.linalg.lapack import dpocon

from ...base import RESIDUAL, ROUNDING, STALLED, Array, Booleans, SolveRecord, warns_of_odd_values
from ...contact import ContactSystem, joined, parted
from ...errors import SolverError
from ..transient import OPEN
from .increment import FrictionIncrement, Increment, Posed, force_scale, sizes_of
from .newton import Law, State, newton
from .programs import FrozenBoundIncrement
from .sweeps import increment, reactions

_NEWTON = SolveRecord("NEWTON")
_REPEATS = 0.1  # motions differ by less, over the largest, from those of the cycle before
# share of the nodes left that are open, from which on these are eliminated, too: few of them cost
# more than that
_MORE = 0.05
_SCALES = (1.0, 10.0, 0.1, 100.0, 0.01)  # of the c and d of Newton's method, tried in this order

Moved = tuple[
    Array, Array, NDArray[np.int8]
]  # motions `u = [v, w - g0]` and reactions, (M,), and status


class _Nodes:
    """Nodes that move from increment to increment: dimensionless law and sizes, see `FrictionIncrement`, and the unit of their stiffness."""

    def __init__(self, law: Law, sizes: Array, gap: Array, unit: float) -> None:
        self.law, self.sizes, self._gap, self._unit = law, sizes, gap, unit
        # of increments whose state sweeps did not reach, by their load and way: motions, and
        # whether they are nearly those of the cycle before
        self._begun: dict[bytes, tuple[Array, bool]] = {}

    def _moved(self, u: Array, r: Array, force: float, way: bytes) -> Moved | None:
        """The state that follows motions u with reactions r, which the load has changed; None if no way leads to one that obeys the law to rounding.

        Newton's method begins at the gaps before, and at the motions of the cycle before once they
        repeat: where several states obey the law, those of a jump would lead to the next jump.
        """
        n, length, law = (
            len(self._gap),
            force / self._unit,
            replace(self.law, strength=self.law.strength / force),
        )
        begin = np.concatenate([np.zeros(len(u) - n), u[-n:] + self._gap]) / length
        last, repeats = self._begun.get(way, (np.full(u.shape, np.nan), False))
        state = None if way in self._begun else self._swept(begin.copy(), r / force, law)[0]
        if state is None or state.error > ROUNDING:
            start = state.u if state else last / length if repeats else begin
            state = self._by_newton(law, reactions(law.S, r / force, -begin), start)
            if not state.error <= STALLED:
                return None
            self._begun[way] = (
                length * state.u,
                bool(
                    np.abs(length * state.u - last).max()
                    <= _REPEATS * length * np.abs(state.u).max()
                ),
            )
        return (
            np.concatenate(
                [u[:-n] + length * state.u[:-n], length * np.maximum(state.u[-n:], 0.0) - self._gap]
            ),
            force * state.r,
            state.status,
        )

    def _by_newton(self, law: Law, trial: Array, start: Array) -> State:
        return newton(law, trial, start if np.isfinite(start).all() else np.zeros_like(start))

    def _swept(self, u: Array, r: Array, law: Law) -> tuple[State, Array]:
        """What sweeps make of motions u and reactions r, which they change; the reactions of the state are on the law, those beside it are exact."""
        forces, status = np.empty_like(r), np.empty(len(law.friction), dtype=np.int8)
        error = increment(
            law.S, law.friction, law.strength, law.augmentation, self.sizes, u, r, forces, status
        )
        return State(u, forces, status, 0, error), r


@warns_of_odd_values
class NewtonIncrement(FrictionIncrement, _Nodes):
    """One friction increment by Gauss-Seidel sweeps over the nodes, and by Newton's method on the projected law, which begins where they end.

    The sweeps alone often reach the state to rounding; the solver of the record is "SWEEPS" then.
    Where Newton's method does not converge, it begins without motion, other constants of the
    projection are tried, last a `FrozenBoundIncrement`. Where several states obey the law (above
    the critical friction) one of them is returned. Theory, eq. (4).

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

    def __init__(self, system: ContactSystem, friction: ArrayLike) -> None:
        FrictionIncrement.__init__(self, system, friction)
        _Nodes.__init__(self, self.law, self.sizes, system.gap, system.stiffness_scale)
        self._stands: tuple[Array, Array] = (
            np.empty(0),
            np.empty(0),
        )  # u of the last state, and S u
        self._rest: _Rest | None = None  # of the last increment in which open nodes were eliminated
        self._landed = np.zeros(
            system.nodes, dtype=bool
        )  # nodes that closed again after that: these are never eliminated again

    def along(self, u: Array, loads: Sequence[Array]) -> Iterator[Moved]:
        """States after several loads in turn, see `FrictionIncrement`; reactions and gaps go on from those before.

        Once sweeps do not reach a state, open nodes are eliminated, as long as they stay open.
        """
        n = self.system.nodes
        for load in loads:
            way = loads[0].tobytes() + load.tobytes()
            stress = self._stands[1] if u is self._stands[0] else self.system.S @ u
            r = load + stress
            force = force_scale(load[-n:], r)
            found = self._without_open(u, r, force, way) if self._begun else None
            acts = reactions(self.system.S, r, found[0] - u) if found else r
            if found is None or not np.abs(acts - found[1]).max() <= STALLED * force:
                found = self._moved(u, r, force, way) or self._solved_by_itself(u, load)
                acts = reactions(self.system.S, r, found[0] - u)
            self._stands = found[0], acts - load
            u = found[0]
            yield found

    def _without_open(self, u: Array, r: Array, force: float, way: bytes) -> Moved | None:
        """A state with nodes eliminated that are open; None where one of them closes, or the others have no state that obeys the law of all."""
        n, known = (
            self.system.nodes,
            self._rest.opened if self._rest else np.zeros(self.system.nodes, dtype=bool),
        )
        opened = u[-n:] + self._gap > 0
        self._landed |= known & ~opened
        opened &= ~self._landed
        opened = opened if (opened & ~known).sum() > _MORE * (~known).sum() else opened & known
        if not opened.any() or opened.all():
            return None
        try:
            if self._rest is None or (opened != known).any():
                self._rest = _Rest(self.law, self._gap, self._unit, opened)
        except LinAlgError:
            return None
        found = self._rest.after(u, r, force, way)
        return (
            found
            if found and (found[0][-n:] + self._gap)[opened].min() >= -STALLED * force / self._unit
            else None
        )

    def _solved_by_itself(self, u: Array, load: Array) -> Moved:
        axes = self.system.tangents + 1
        new = self.solve(parted(u, axes)[0], parted(load, axes))
        return joined(new.slip, new.gap - self._gap), joined(new.q, new.p), new.status

    def _solved(self, posed: Posed) -> Increment:
        """From where sweeps end; else from no motion, by c of nodes and of directions; last by frozen bounds."""
        state, _ = self._swept(np.zeros_like(posed.trial), posed.trial.copy(), posed.law)
        if state.error <= ROUNDING:
            return posed.result(state, SolveRecord("SWEEPS"), residual=state.error)
        found = posed.result(self._by_newton(posed.law, posed.trial, state.u), _NEWTON)
        return (
            found
            if found.record.residual <= RESIDUAL
            else self._otherwise(posed, found.record.residual)
        )

    def _otherwise(self, posed: Posed, least: float) -> Increment:
        tangent = np.tile(self.own[:-1].mean(axis=0), (len(self.own) - 1, 1))
        laws, still = (
            (posed.law, replace(posed.law, augmentation=np.vstack([tangent, self.own[-1]]))),
            np.zeros_like(posed.trial),
        )
        for law, scale in product(laws, _SCALES):
            found = posed.result(
                newton(replace(law, augmentation=scale * law.augmentation), posed.trial, still),
                _NEWTON,
            )
            if found.record.residual <= RESIDUAL:
                return found
            least = min(least, found.record.residual)
        try:
            return FrozenBoundIncrement(self.system, self.friction)._solved(posed)
        except SolverError:
            raise SolverError(
                f"friction increment: Newton's method leaves a residual of {least:.1e} (tolerance {RESIDUAL:g}), and convex programs find no state "
                f"either; {self._remedy}"
            ) from None


class _Rest(_Nodes):
    """The nodes that are left of a contact where open ones are eliminated: as long as nothing acts on these, they follow the others."""

    def __init__(self, law: Law, gap: Array, unit: float, opened: Booleans) -> None:
        left, self.opened = ~opened, opened
        self._out, self._in = (
            np.flatnonzero(np.tile(nodes, len(law.augmentation))) for nodes in (opened, left)
        )
        own, between = law.S[np.ix_(self._out, self._out)], law.S[np.ix_(self._out, self._in)]
        self._factor = cho_factor(own)
        if not dpocon(self._factor[0], np.abs(own).sum(axis=0).max())[0] > ROUNDING:
            raise LinAlgError("the open nodes move freely")
        self._carried = np.ascontiguousarray(
            cho_solve(self._factor, between).T
        )  # a row for each motion of the others
        S = law.S[np.ix_(self._in, self._in)] - self._carried @ between
        own, least = (
            np.diag(S).reshape(len(law.augmentation), -1),
            ROUNDING * law.augmentation[:, left],
        )
        own = np.where(
            own > least, own, law.augmentation[:, left]
        )  # what is rounding holds nothing
        rest = Law(
            S, law.friction[left], np.tile(own.max(axis=0), (len(own), 1)), law.strength[left]
        )
        super().__init__(rest, sizes_of(S, own), gap[left], unit)

    def after(self, u: Array, r: Array, force: float, way: bytes) -> Moved | None:
        """Motions, reactions and status of all nodes, from motions with reactions that the load has changed."""
        acting = cho_solve(self._factor, r[self._out])
        found = self._moved(u[self._in], r[self._in] - self._carried @ r[self._out], force, way)
        if found is None:
            return None
        moved, forces, status = (
            u.copy(),
            np.zeros_like(u),
            np.full(len(self.opened), OPEN, dtype=np.int8),
        )
        moved[self._in], forces[self._in], status[~self.opened] = found
        moved[self._out] -= reactions(self._carried, acting / self._unit, (moved - u)[self._in])
        return moved, forces, status
