"""One friction increment by sweeps over the nodes and Newton's method: the quick way, in the plane and in space."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import LinAlgError, cho_factor, cho_solve
from scipy.linalg.lapack import dpocon

from ...contact import RESIDUAL, ROUNDING, STALLED, Array, ContactSystem, SolveRecord, joined, off_law, parted
from ...errors import FrictoptError, SolverError
from ..begin import OPEN
from .increment import FrictionIncrement, Increment, Posed, force_scale
from .newton import Factors, Law, State, newton
from .programs import FrozenBoundIncrement
from .sweeps import increment

_NEWTON = SolveRecord("NEWTON")
_REPEATS = 0.1  # motions differ by less, over the largest, from those of the cycle before
_MORE = 0.05  # share of the nodes left that are open, from which on these are eliminated, too: few of them cost more than that
_MEMORY = 2**28  # bytes of factors that are kept for the next cycle
_SCALES = (1.0, 10.0, 0.1, 100.0, 0.01)  # of the c and d of Newton's method, tried in this order


class NewtonIncrement(FrictionIncrement):
    """One friction increment by Gauss-Seidel sweeps over the nodes, and by Newton's method on the projected law, which begins where they end.

    The sweeps alone often reach the state to rounding; the solver of the record is "SWEEPS" then. Where Newton's method does not converge, it begins
    without motion, other constants of the projection are tried, last a `FrozenBoundIncrement`.
    Where several states obey the law (above the critical friction) one of them is returned. Theory, eq. (4).

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
        super().__init__(system, friction)
        # of increments whose state sweeps did not reach, by their load and way: motions, and whether they are nearly those of the cycle before
        self._begun: dict[bytes, tuple[Array, bool]] = {}
        self._factors: dict[bytes, Factors] = {}  # of these, within `_MEMORY`
        self._rest: _Rest | None = None  # of the last increment in which open nodes were eliminated
        self._landed = np.zeros(system.nodes, dtype=bool)  # nodes that closed again after that: these are never eliminated again

    def along(self, u: Array, loads: Sequence[Array], begin: bytes = b"") -> Iterator[tuple[Array, Array, NDArray[np.int8]]]:
        """States after several loads in turn, see `FrictionIncrement`; reactions and gaps go on from those before. `begin` tells ways apart.

        Once sweeps do not reach a state, open nodes are eliminated, as long as they stay open. Else Newton's method begins at the gaps before, and at
        the motions of the cycle before once they repeat: where several states obey the law, those of a jump would lead to the next jump.
        """
        n, gap, axes = self.system.nodes, self.system.gap, self.system.tangents + 1
        stress: Array | None = None  # S u, where it is known
        for load in loads:
            way = (begin or loads[0].tobytes()) + load.tobytes()
            if self._begun and (found := self._without_open(u, load, way)):
                u, stress = found[0], None
                yield found
                continue
            start = np.concatenate([np.zeros(len(u) - n), u[-n:] + gap])
            if way not in self._begun:
                r = load + (self.system.S @ u if stress is None else stress)
                force = force_scale(load[-n:], r)
                length = force / self.system.stiffness_scale
                state, r = self._swept(start / length, r / force, self.law_in(force))
                if state.error <= ROUNDING:
                    u = np.concatenate([u[:-n] + length * state.u[:-n], length * state.u[-n:] - gap])
                    stress = force * r - load
                    yield u, force * state.r, state.status
                    continue
                start = length * state.u
            posed = Posed(self, parted(u, axes)[0], parted(load, axes))
            last, repeats = self._begun.get(way, (np.full(u.shape, np.nan), False))
            new = self._by_newton(posed, (last if repeats else start) / posed.length, way)
            new = new if new.record.residual <= RESIDUAL else self.solve(posed.slip, posed.bonded)
            before, u = u, joined(new.slip, new.gap - gap)
            moved = np.concatenate([(u - before)[:-n], new.gap])
            self._begun[way] = moved, bool(np.abs(moved - last).max() <= _REPEATS * np.abs(moved).max())
            stress = None
            yield u, joined(new.q, new.p), new.status

    def _without_open(self, u: Array, load: Array, way: bytes) -> tuple[Array, Array, NDArray[np.int8]] | None:
        """A state with nodes eliminated that are open; None where one of them closes, or the others have no state that obeys the law of all."""
        n, known = self.system.nodes, self._rest.opened if self._rest else np.zeros(self.system.nodes, dtype=bool)
        opened = u[-n:] + self.system.gap > 0
        self._landed |= known & ~opened
        opened &= ~self._landed
        opened = opened if (opened & ~known).sum() > _MORE * (~known).sum() else opened & known
        if not opened.any() or opened.all():
            return None
        try:
            if self._rest is None or (opened != known).any():
                self._rest = _Rest(self, opened)
            after, r, status = self._rest.after(u, load, way)
        except (FrictoptError, LinAlgError):
            return None
        errors = off_law(self.system, self.friction, load, after, r, force_scale(load[-n:], r), u)
        return (after, r, status) if errors.max() <= STALLED else None

    def _solved(self, posed: Posed) -> Increment:
        """From where sweeps end; else from no motion, by c of nodes and of directions; last by frozen bounds."""
        state, _ = self._swept(np.zeros_like(posed.trial), posed.trial.copy(), posed.law)
        if state.error <= ROUNDING:
            return posed.result(state, SolveRecord("SWEEPS"), residual=state.error)
        found = self._by_newton(posed, state.u)
        return found if found.record.residual <= RESIDUAL else self._otherwise(posed, found.record.residual)

    def _by_newton(self, posed: Posed, start: Array, way: bytes = b"") -> Increment:
        start = start if np.isfinite(start).all() else np.zeros_like(start)
        state = newton(posed.law, posed.trial, start, factors=self._factors.pop(way, None))
        if way and state.factors and sum(kept.lu.nbytes for kept in (state.factors, *self._factors.values())) <= _MEMORY:
            self._factors[way] = state.factors
        return posed.result(state, _NEWTON)

    def _swept(self, u: Array, r: Array, law: Law) -> tuple[State, Array]:
        """What sweeps make of motions u and reactions r, which they change; the reactions of the state are on the law, those beside it are exact."""
        forces, status = np.empty_like(r), np.empty(self.system.nodes, dtype=np.int8)
        error = increment(law.S, law.friction, law.strength, law.own, self.sizes, u, r, forces, status)
        return State(u, forces, status, 0, error), r

    def _otherwise(self, posed: Posed, least: float) -> Increment:
        tangent = np.tile(self.own[:-1].mean(axis=0), (len(self.own) - 1, 1))
        laws, still = (posed.law, replace(posed.law, own=np.vstack([tangent, self.own[-1]]))), np.zeros_like(posed.trial)
        for law, scale in product(laws, _SCALES):
            found = posed.result(newton(replace(law, own=scale * law.own), posed.trial, still), _NEWTON)
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


class _Left(NewtonIncrement):
    """An increment of the nodes that are left: where Newton's method fails at once, the whole contact is asked. No more are eliminated."""

    def _without_open(self, u: Array, load: Array, way: bytes) -> None:
        return None

    def _otherwise(self, posed: Posed, least: float) -> Increment:
        raise SolverError(f"Newton's method leaves a residual of {least:.1e}")


class _Rest:
    """The nodes that are left of a contact where open ones are eliminated: as long as nothing acts on these, they follow the others."""

    def __init__(self, whole: NewtonIncrement, opened: NDArray[np.bool_]) -> None:
        system, left, self.opened = whole.system, ~opened, opened
        self._out, self._in = (np.flatnonzero(np.tile(nodes, system.tangents + 1)) for nodes in (opened, left))
        own, between = system.S[np.ix_(self._out, self._out)], system.S[np.ix_(self._out, self._in)]
        self._factor = cho_factor(own)
        if not dpocon(self._factor[0], np.abs(own).sum(axis=0).max())[0] > ROUNDING:
            raise LinAlgError("the open nodes move freely")
        self._carried = cho_solve(self._factor, between)
        S, none = system.S[np.ix_(self._in, self._in)] - between.T @ self._carried, {"none": np.zeros(len(self._in))}
        names = None if system.contact is None else system.contact[left]
        rest = ContactSystem(
            S, system.points[left], none, gap=system.gap[left], frames=system.frames[left], contact=names, shear_strength=system.shear_strength[left]
        )
        self._increment = _Left(rest, whole.friction[left])

    def after(self, u: Array, load: Array, way: bytes) -> tuple[Array, Array, NDArray[np.int8]]:
        """Motions, reactions and status of all nodes after a load."""
        moved, r, status = np.empty_like(u), np.zeros_like(u), np.full(len(self.opened), OPEN, dtype=np.int8)
        rest = load[self._in] - load[self._out] @ self._carried
        moved[self._in], r[self._in], status[~self.opened] = next(self._increment.along(u[self._in], [rest], way))
        moved[self._out] = -cho_solve(self._factor, load[self._out]) - self._carried @ moved[self._in]
        return moved, r, status
