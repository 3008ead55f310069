"""The states of a transient in three dimensions."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ...contact import Verdict, referee
from ...contact.checks import Array, frozen
from ...contact.parts import joined
from ...contact.record import SolveRecord
from ...contact.show import Plotted, Shown, frame
from ...contact.system import ContactSystem

__all__ = ["Trajectory3D"]


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory3D(Shown, Plotted):
    """T states of a transient in three dimensions, one after each increment.

    Attributes
    ----------
    system, friction
        The contact and its (N,) coefficients of friction.
    corners
        Number of corners of the load cycle, K.
    time
        (T,) number of corners visited: -1 at the artificial load that carries the initial slip, 0 at the mean load, k at the k-th corner, and
        linear between them.
    bonded_q, bonded_p
        (T, N, 2) and (T, N) bonded reactions of the load, force.
    slip, gap
        (T, N, 2) slip v along the tangents and (T, N) gap w, length.
    q, p
        (T, N, 2) shear forces and (T, N) normal forces, compression positive.
    status
        (T, N) over the increment that ends here: 0 sticks, 1 slips, 2 is open.
    work
        (T, N) work of friction so far, >= 0, force times length.
    step_error
        Estimated error in time of the slip at the mean load and the corners, over the slip scale: the friction circle is curved, and there is no
        exact path. It is the largest of the differences from what a half and a quarter of the increments give (inf where these have no answer), and
        of the slip that may be missed within the increments at whose ends alone the law is obeyed. Errors of contacts in a plane, whose exact path
        is known, were at most 5 times larger; it is no bound.
    engine
        "newton" or "socp".

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> node = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [1, 0, 0], "R": [0, 1, 0]})
    >>> path = fo.march(node, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), friction=0.5, load_factor=1.0, cycles=2)
    >>> path.cycle_work.sum(axis=1).round(9).tolist()
    [0.75, 1.0]
    """

    system: ContactSystem
    friction: Array
    corners: int
    time: Array
    bonded_q: Array
    bonded_p: Array
    slip: Array
    gap: Array
    q: Array
    p: Array
    status: np.ndarray[Any, np.dtype[np.int8]]
    work: Array
    step_error: float
    engine: str
    _seconds: float = field(repr=False)

    @cached_property
    def verdict(self) -> Verdict:
        """Violations of the contact law over all states, each against the one before; forces in units of the largest mean pressure of the loads."""
        loaded = self.bonded_p[self.time >= 0] if self.time[-1] >= 0 else self.bonded_p
        return referee(
            self.system,
            (self.bonded_q, self.bonded_p),
            self.friction,
            v=self.slip,
            w=self.gap,
            q=self.q,
            p=self.p,
            previous_slip=np.concatenate([self.slip[:1], self.slip[:-1]]),
            force_scale=float(np.abs(loaded).mean(axis=1).max()) or 1.0,
        )

    @property
    def record(self) -> SolveRecord:
        """How it was found."""
        return SolveRecord(self.engine, (), self.residual, (), self._seconds)

    @property
    def residual(self) -> float:
        """Largest violation of the contact law over all states."""
        return self.verdict.residual

    @cached_property
    def energy(self) -> Array:
        """(T,) elastic energy `u S u / 2` of the relative motion `u = [v1, v2, w - g0]`, force times length."""
        u = joined(self.slip, self.gap - self.system.gap)
        return frozen(((u @ self.system.S) * u).sum(axis=1) / 2)

    @cached_property
    def cycle_work(self) -> Array:
        """(cycles, N) work of friction in each whole cycle."""
        ends = np.searchsorted(self.time, np.arange(0, self.time[-1] + 0.5, self.corners) + 1e-9) - 1
        return frozen(np.diff(self.work[ends], axis=0))

    def to_frame(self) -> Any:
        """The DataFrame of all states and nodes: columns state, time, node, slip1, slip2, gap, q1, q2, p, status, work."""
        states, nodes = self.gap.shape
        state, node = np.repeat(np.arange(states), nodes), np.tile(np.arange(nodes), states)
        vectors = {f"{name}{axis + 1}": getattr(self, name)[..., axis].ravel() for name in ("slip", "q") for axis in (0, 1)}
        scalars = {name: getattr(self, name).ravel() for name in ("gap", "p", "status", "work")}
        order = ("slip1", "slip2", "gap", "q1", "q2", "p", "status", "work")
        return frame({"state": state, "time": self.time[state], "node": node, **{name: (vectors | scalars)[name] for name in order}})

    def _answer(self) -> Mapping[str, Any]:
        cycles = max(0, int(self.time[-1])) // self.corners
        size = {"states": len(self.time), "nodes": self.system.nodes, "cycles": cycles}
        return {**size, "work": float(self.work[-1].sum()), "engine": self.engine, "residual": self.residual, "step_error": self.step_error}
