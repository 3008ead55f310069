"""The steady state of a transient: does it stop slipping, and if not, how much does it dissipate in a cycle for ever."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ..contact import ContactSystem, LoadCycle, referee
from ..contact.checks import Array, finite_number, flag, frozen, whole_number
from ..errors import NoContinuation, SolverError
from .exact import ExactPath
from .outcome import Outcome, SteadyState
from .stops import left_out_corners, turning_corners

__all__ = ["steady_state"]

TOLERANCE = 1e-9
"""Largest residual with which a steady state leaves the package."""

_PERIODIC = 1e-10  # change of slip over a cycle, over the slip scale, that counts as none
_REPEATS = 1e-13  # the same where the events are not: simultaneous ones may come in any order
_SAFE = 1e-10  # excess over the friction bound, over the force scale, that counts as none
_TOUCHING = 1e-8  # distance from the friction bound, over the force scale, that an extrapolation may leave
_WINDOW = 12  # cycles that an extrapolation looks back on
_LEAST = 3  # cycles with the same events before the first extrapolation


def steady_state(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    load_factor: float,
    *,
    initial_slip: Any = None,
    overload: float | None = None,
    most_cycles: int = 2000,
    simplify: bool = True,
) -> SteadyState:
    """Follow a transient exactly until its steady state is proven.

    Once the events of a cycle repeat, slip at the end of a cycle is an affine function of slip at its beginning: its fixed point is extrapolated
    from the cycles so far (reduced-rank extrapolation, Sidi 2017) and accepted only where a cycle from it goes through the same events and comes
    back to it. Shakedown is reported only of a slip that is safe at every corner, or, where nodes lift off or have no friction, of a state that
    comes back without work of friction (at most 1e-9 in units of force times slip scale, times the coefficient of friction where that is below 1).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    initial_slip
        (N,) slip left from assembly, length; None for none.
    overload
        Load factor of one cycle before all others, >= 0; None for none.
    most_cycles
        Give up after this many.
    simplify
        Leave out what the scene does not need: half of a contact that is mirror-symmetric, with its start, where the path is proven to keep the
        symmetry; and corners on the straight way between their neighbours.

    Raises
    ------
    ModelError
        Bad input.
    NoContinuation
        The path ends before, or no steady state is proven within `most_cycles`.
    SolverError
        The states do not obey the contact law to the tolerance.
    """
    whole_number("most_cycles", most_cycles, least=1)
    path = ExactPath(system, cycle, friction, load_factor, initial_slip, simplify=flag("simplify", simplify))
    stops = turning_corners(cycle) if simplify else range(len(path.corners))
    path.start()
    if overload is not None:
        corners = path.corners_at(finite_number("overload", overload, least=0.0))
        path.check_near("overload", np.array(corners))
        for number in stops:
            path.go(corners[number], f"the overload's way to corner {number}")
    run = _Run(path, stops, turning_corners(cycle))
    while run.cycles < most_cycles:
        run.cycle()
        found = run.steady()
        if found is not None:
            return found
    reason = f"none proven within most_cycles = {most_cycles} cycles (the slip changes by {run.change:.1e} slip scales a cycle)"
    if run.change <= _PERIODIC:
        hint = f"its work of friction, {run.work.sum():.1e} a cycle, is too little to tell slip from none: take a load factor further from the limit"
    else:
        hint = "allow more"
    raise NoContinuation(f"steady state: {reason}; {hint}")


class _Run:
    """The cycles of one transient so far."""

    def __init__(self, path: ExactPath, stops: Sequence[int], turns: Sequence[int]) -> None:
        self.path, self.stops, self.turns = path, stops, turns
        self.force = max(path.force, *(float(np.abs(corner).max()) for corner in path.corners))
        self.length = self.force / path.system.stiffness_scale
        self.slips: list[Array] = [path.state.u.copy()]
        self.hashes: list[int] = [0]
        self.cycles = 0
        self.first = np.nan
        self.work: Array = np.zeros(path.nodes)
        self.work_before: Array = self.work
        self.corners: list[tuple[Array, Array]] = []

    def cycle(self) -> None:
        """Follow one cycle."""
        self.work_before = self.work
        self.work, events, self.corners = self._one(self.path)
        self.first = float(self.work.sum()) if self.cycles == 1 else self.first
        self.slips = [*self.slips[-_WINDOW:], self.path.state.u.copy()]
        self.hashes = [*self.hashes[-_WINDOW:], events]

    def _one(self, path: ExactPath) -> tuple[Array, int, list[tuple[Array, Array]]]:
        """Follow one cycle: its work of friction by node, the hash of its events, and `u, r` at its corners."""
        state = path.state
        state.work[:] = 0.0  # of this cycle alone: next to the work of a far start it would drown in rounding
        state.trace[1] = 0
        corners = []
        for number in self.stops:
            path.go(path.corners[number], f"the way to corner {number}")
            corners.append((state.u.copy(), state.r.copy()))
        self.cycles += 1
        return state.work.copy(), int(state.trace[1]), corners

    def _violation(self, corners: list[tuple[Array, Array]]) -> float:
        """What the referee says of the states at the corners of a cycle."""
        path, n = self.path, self.path.nodes
        u, r, load = (np.array(rows) for rows in (*zip(*corners, strict=True), self._loads(path)))
        gap = u[:, n:] + path.state.gap
        bonded, reactions = (load[:, :n], load[:, n:]), {"q": r[:, :n], "p": r[:, n:]}
        return referee(path.system, bonded, path.friction, v=u[:, :n], w=gap, **reactions, force_scale=self.force).residual

    def _loads(self, path: ExactPath) -> list[Array]:
        """Bonded reactions (2N,) at the corners that a cycle stops at."""
        return [path.corners[number] for number in self.stops]

    @property
    def change(self) -> float:
        """Change of slip and gap over the last cycle, in slip scales."""
        return self._distance(self.slips[-1], self.slips[-2])

    def _distance(self, one: Array, other: Array) -> float:
        return float(np.abs(one - other).max() / self.length)

    def steady(self) -> SteadyState | None:
        """The steady state, if it is proven by now."""
        path = self.path
        if self._safe(path.state.u):
            return self._at_rest(path, False)
        if not self.work.any() and self.change <= _PERIODIC:
            return self._result(path, Outcome.SHAKEDOWN, self.work, self.corners, 0.0, False)
        same = next((k for k, other in enumerate(reversed(self.hashes)) if other != self.hashes[-1]), len(self.hashes))
        repeats = self.cycles > 1 and bool(np.abs(self.work - self.work_before).max() <= _PERIODIC * self.work.sum())
        if self.change <= (_PERIODIC if same >= 2 or repeats else _REPEATS) and self._conclusive(self.work):
            return self._periodic(path, self.work, self.change, self.corners, False)
        if same >= 3 and repeats and self._ratchets():
            return self._result(path, Outcome.RATCHETING, self.work, self.corners, 0.0, False)
        if same >= _LEAST + 1 and (same - _LEAST) % 2:
            return self._extrapolated(same)
        return None

    def _ratchets(self) -> bool:
        """Whether slip drifts by the same amount in every cycle, a motion that stresses nothing and leaves all gaps as they are."""
        path, n = self.path, self.path.nodes
        drift, before = self.slips[-1] - self.slips[-2], self.slips[-2] - self.slips[-3]
        size, rounding = float(np.abs(drift).max()), np.finfo(float).eps * float(np.abs(self.slips[-1]).max())
        resisted = float(np.abs(path.stress(drift)).max()) > _PERIODIC * self.force
        steady = self._distance(drift, before) * self.length <= _PERIODIC * size
        return bool(steady and size > rounding / _PERIODIC and not (resisted or drift[n:].any()))

    def _extrapolated(self, same: int) -> SteadyState | None:
        fixed = _fixed_point(np.array(self.slips[-min(same, _WINDOW + 1) :]))
        proof = self.path.moved(fixed) if self._approached(fixed) else None
        if proof is None:
            return None
        if self._safe(fixed):
            return self._at_rest(proof, True) if self._just_safe(fixed) else None
        try:
            work, events, corners = self._one(proof)
        except NoContinuation:
            return None
        back = self._distance(proof.state.u, fixed)
        if back > _PERIODIC or events != self.hashes[-1] or not self._conclusive(work):
            return None
        return self._periodic(proof, work, back, corners, True)

    def _safe(self, u: Array) -> bool:
        """Whether the slip keeps every node closed and within its bound at every corner."""
        path, n = self.path, self.path.nodes
        if np.any(u[n:] + path.state.gap > 0):
            return False
        q, p = np.split(np.array(path.corners) + path.stress(u), 2, axis=1)
        return bool(min((path.friction * p - np.abs(q)).min(), p.min()) >= -_SAFE * path.force)

    def _slips(self, work: Array) -> bool:
        """Whether a cycle's work of friction is more than its tolerance, that of a slip of 1e-9 under the largest force."""
        return bool(work.sum() > TOLERANCE * self.force * self.length * min(1.0, float(self.path.friction.max())))

    def _conclusive(self, work: Array) -> bool:
        """Whether a cycle that comes back says what becomes of the contact: it slips, or some node lifts off or moves without friction.

        Of a contact whose nodes all stay closed and rub, a small work says nothing, since it may be on its way to nothing: there the slip must be
        safe.
        """
        return self._slips(work) or bool((self.path.friction == 0).any()) or bool(self._open(self.corners).any())

    def _open(self, corners: list[tuple[Array, Array]]) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """(N,) whether each node is open at some corner at which the load turns."""
        gaps = [u[self.path.nodes :] + self.path.state.gap for number, (u, _) in zip(self.stops, corners, strict=True) if number in self.turns]
        opened: np.ndarray[Any, np.dtype[np.bool_]] = np.any(np.array(gaps) > 0, axis=0)
        return opened

    def _periodic(self, path: ExactPath, work: Array, change: float, corners: list[tuple[Array, Array]], extrapolated: bool) -> SteadyState:
        """The steady state of a cycle that comes back; where nodes lift off and land, without more work than its tolerance, it is shakedown."""
        if self._slips(work):
            return self._result(path, Outcome.CYCLIC_SLIP, work, corners, change, extrapolated)
        return self._result(path, Outcome.SHAKEDOWN, 0 * work, corners, change, extrapolated)

    def _at_rest(self, path: ExactPath, extrapolated: bool) -> SteadyState:
        """Shakedown to a safe slip, which stays the same through all corners."""
        u = path.state.u
        resting = [(u, corner + path.stress(u)) for corner in self._loads(path)]
        return self._result(path, Outcome.SHAKEDOWN, 0 * self.work, resting, self._violation(self.corners), extrapolated)

    def _approached(self, fixed: Array) -> bool:
        """Whether every one of the last cycles came closer to a state."""
        distances = [self._distance(slip, fixed) for slip in self.slips[-_LEAST - 1 :]]
        return all(later < earlier for earlier, later in pairwise(distances))

    def _just_safe(self, fixed: Array) -> bool:
        """Whether the nodes that still slip come to rest exactly at their bounds, as the limit of cycles that never stop slipping must."""
        path, n = self.path, self.path.nodes
        r = np.array(path.corners) + path.stress(fixed)
        slack = (path.friction * r[:, n:] - np.abs(r[:, :n])).min(axis=0)
        return bool(slack[self.work > 0].max() <= _TOUCHING * path.force)

    def _result(
        self, path: ExactPath, outcome: Outcome, work: Array, corners: list[tuple[Array, Array]], change: float, extrapolated: bool
    ) -> SteadyState:
        residual = max(change, self._violation(corners))
        if not residual <= TOLERANCE:
            raise SolverError(
                f"steady state: its states violate the contact law, or do not come back, by {residual:.1e} (tolerance {TOLERANCE:g}); "
                "stiffnesses, loads or the initial slip differ too much in size"
            )
        return SteadyState(
            outcome=outcome,
            dissipation=float(work.sum()),
            dissipation_per_node=frozen(work),
            slip=frozen(path.state.u[: path.nodes]),
            open=self._open(corners),
            first_cycle=self.first,
            cycles=self.cycles,
            events=int(path.state.trace[0]),
            residual=residual,
            extrapolated=extrapolated,
            unproven=path.unproven,
            left_out=path.left_out + left_out_corners(self.stops, len(path.corners)),
        )


def _fixed_point(iterates: Array) -> Array:
    """Fixed point of an affine map from some of its iterates (rows), by reduced-rank extrapolation."""
    steps = np.diff(iterates, axis=0)
    scale = np.linalg.norm(steps, axis=1, keepdims=True)
    differences = np.diff(steps, axis=0)
    weights = np.linalg.lstsq(differences.T, -steps[0], rcond=1e-12)[0] if scale.min() > 0 else np.zeros(len(differences))
    fixed: Array = iterates[0] + weights @ steps[:-1]
    return fixed
