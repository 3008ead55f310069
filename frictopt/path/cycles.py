"""The cycles of a transient, and the proof of its steady state from the last cycles."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from time import perf_counter
from typing import Any

import numpy as np

from ..contact import ContactState, referee
from ..contact.answers import Outcome
from ..contact.checks import Array, frozen
from ..contact.extrapolation import SLOW, drift_text, fixed_point, slower_modes
from ..contact.record import SolveRecord
from ..contact.tolerances import LEVEL, LITTLE, PERIODIC, REPEATED, RESIDUAL, ROUNDING, SAFE
from ..errors import NoContinuation, SolverError
from .cycle import Cycle
from .kernel import OPEN
from .outcome import SteadyState
from .stops import left_out_corners
from .transient import ExactPath

__all__ = ["Run"]

_NEAR = 1e-3  # the affine map is also tested at this share of the distance from the extrapolated limit
_AFFINE = 1e-3  # largest deviation from an affine map, over the change, that is accepted: a new event changes it by more
_WINDOW = 12  # number of last cycles that an extrapolation uses
_LEAST = 4  # cycles with the same events before the first extrapolation


class Run:
    """The cycles of one transient so far. Slips are in units of the largest nodal force of the loads over the stiffness, see `scales`."""

    def __init__(self, path: ExactPath, stops: Sequence[int], turns: Sequence[int]) -> None:
        self.path, self.scales, self.stops, self.turns = path, path.scales, stops, turns
        self.force = max(path.force, *(float(np.abs(corner).max()) for corner in path.corners))
        self.length = self.force / path.system.stiffness_scale
        self.cycles, self.first = 0, np.nan
        self.latest: Cycle
        self.energy = 0.0
        self.tried = self.pause = 0  # extrapolations that failed since the events last changed, and cycles until the next one
        self.last: list[Cycle] = []
        self.settled = path  # where the steady state was proven
        self._ahead = ""  # what a look ahead along a drift shows

    def cycle(self) -> None:
        """Follow one cycle. The first one starts at the mean load, not at the last corner, so no proof uses it."""
        self.latest = self._follow(self.path)
        self.energy = max(self.energy, self.latest.energy)
        if self.cycles == 1:
            self.first = float(self.latest.work.sum())
        else:
            self.last = [*self.last[-_WINDOW:], self.latest]

    def _follow(self, path: ExactPath) -> Cycle:
        state = path.state
        state.work[:] = state.supplied[:] = 0.0  # else a small work is lost to rounding next to that of a far start
        state.trace[1] = 0
        before, corners = state.u.copy(), []
        for number in self.stops:
            path.follow_to(path.corners[number], f"the segment to corner {number}")
            corners.append((state.u.copy(), state.r.copy()))
        self.cycles += 1
        after, work = state.u.copy(), state.work.copy()
        stress = path.stress((before + after) / 2)
        lost = abs(float(state.supplied[0] - work.sum() - stress @ (after - before)))
        scale = max(self.force * self.length, float(work.sum()), float(np.abs(stress) @ np.abs(before)))
        lost = max(lost, -float(work.min()))
        return Cycle(work, int(state.trace[1]), corners, before, after, lost / max(scale, np.finfo(float).tiny))

    def _violation(self, cycle: Cycle) -> float:
        """Violation of the contact law at the corners of a cycle."""
        path, n = self.path, self.path.nodes
        u, r, load = (np.array(rows) for rows in (*zip(*cycle.corners, strict=True), self._loads))
        bonded, reactions = (load[:, :n], load[:, n:]), {"q": r[:, :n], "p": r[:, n:]}
        return referee(path.system, bonded, path.friction, v=u[:, :n], w=u[:, n:] + path.state.gap, **reactions, force_scale=self.force).residual

    @property
    def _loads(self) -> list[Array]:
        """Bonded reactions (2N,) at the corners that a cycle stops at."""
        return [self.path.corners[number] for number in self.stops]

    def _distance(self, one: Array, other: Array) -> float:
        return float((np.abs(one - other) / np.resize(self.scales.length, one.shape)).max())

    def _change(self, cycle: Cycle) -> float:
        """Change of slip and gap over a cycle."""
        return self._distance(cycle.after, cycle.before)

    def steady(self) -> SteadyState | None:
        """The steady state, or None if the cycles so far do not prove one."""
        last = self.latest
        if self._safe(last.after):
            return self._at_rest(self.path, last, False)
        if not self.last:
            return None
        change = self._change(last)
        if not last.work.any() and change <= PERIODIC:
            return self._result(self.path, Outcome.SHAKEDOWN, last, 0.0, False)
        if change <= PERIODIC and self._distance_left() <= RESIDUAL and self._conclusive(last):
            return self._periodic(self.path, last, change, False)
        if self._ratchets():
            return self._result(self.path, Outcome.RATCHETING, last, 0.0, False)
        same = next((k for k, other in enumerate(reversed(self.last)) if other.signature != last.signature), len(self.last))
        if same < _LEAST:
            self.tried = self.pause = 0
        elif self.pause:
            self.pause -= 1
        else:
            self.tried += 1
            self.pause = self.tried
            return self._extrapolated(same)
        return None

    @property
    def _decay(self) -> float:
        """Change of the drift from the last cycle but one to the last, over the drift; inf where their events differ."""
        if len(self.last) < 2 or self.last[-2].signature != self.latest.signature:
            return np.inf
        return self._distance(self.latest.after - self.latest.before, self.last[-2].after - self.last[-2].before) / self._change(self.latest)

    def drifts_on(self, most_cycles: int) -> bool:
        """Whether more cycles cannot help: the slip drifts, and a cycle from where the drift leads in all cycles left has the same events and drift.

        Asked only when an extrapolation has failed, and where neither the drift nor its change of the gaps would die out in these cycles: a drift
        that changes no gap may yet be proven to be ratcheting.
        """
        last, left = self.latest, most_cycles - self.cycles
        if not self.tried or self.pause < self.tried or left <= 0 or self._change(last) <= PERIODIC or self._decay >= min(SLOW, 1 / left):
            return False
        drift, n = last.after - last.before, self.path.nodes
        earlier = self.last[-2].after - self.last[-2].before
        if not (np.abs(drift) - left * np.abs(drift - earlier))[n:].max() > PERIODIC * np.abs(drift).max():
            return False
        u, opened = last.after + left * drift, np.flatnonzero(np.tile(self.path.state.status == OPEN, 2))
        bare = (self.path.bonded + self.path.stress(u))[opened]  # rounding of the drift, many times
        u[opened] -= np.linalg.lstsq(self.path.system.S[np.ix_(opened, opened)], bare)[0]
        far = self.path.restarted_at(u)
        try:
            ahead = None if far is None else self._follow(far)
        except NoContinuation:
            return False
        if ahead is None or ahead.signature != last.signature or not 2 * self._distance(ahead.after - ahead.before, drift) < self._change(last):
            return False
        self._ahead = (
            f"; a cycle from where the drift leads in {left} more cycles has the same events, changes gaps, and drifts by {self._change(ahead):.1e}"
        )
        return True

    def reason(self, most_cycles: int) -> str:
        """Why no steady state is proven, and what to change."""
        last, change = self.latest, self._change(self.latest)
        text = f"none proven within most_cycles = {most_cycles} cycles (the slip changes by {change:.1e} slip scales a cycle)"
        if self.path.far_start:
            return f"{text}; {self.path.cause_of_rounding}"
        if change > PERIODIC and self.tried and self._decay < SLOW:
            return f"none proven within {self.cycles} of most_cycles = {most_cycles} cycles; {drift_text(change, self._decay)}{self._ahead}"
        if change > PERIODIC:
            return f"{text}; allow more"
        beside = f"its work of friction, {last.work.sum():.1e} a cycle, is too little beside forces of {self.force:.1e} to tell slip from none"
        return f"{text}; {beside}: take a load factor further from the limit, or loads that are closer together"

    def _distance_left(self) -> float:
        """Estimated distance from the limit: the sum of all later changes, if they decay by the largest ratio of the last cycles."""
        changes = [self._change(cycle) for cycle in self.last[-3:]]
        if changes[-1] <= REPEATED:
            return changes[-1]
        factor = max((later / earlier for earlier, later in pairwise(changes)), default=1.0)
        return changes[-1] * factor / (1 - factor) if factor < 1 else np.inf

    def _ratchets(self) -> bool:
        """Whether slip drifts by the same amount in every cycle, and this drift adds no stress and changes no gap."""
        if len(self.last) < 3 or len({cycle.signature for cycle in self.last[-3:]}) > 1:
            return False
        path, n, (before, last) = self.path, self.path.nodes, self.last[-2:]
        drift = last.after - last.before
        size, rounding = self._distance(drift, 0 * drift), np.finfo(float).eps * self._distance(last.after, 0 * drift)
        resisted = bool(np.any(np.abs(path.stress(drift)) > PERIODIC * np.tile(self.scales.force, 2)))
        steady = self._distance(drift, before.after - before.before) <= PERIODIC * size
        steady = steady and bool(np.abs(last.work - before.work).max() <= PERIODIC * last.work.sum())
        opens = bool(np.any(np.abs(drift[n:]) > PERIODIC * size * self.scales.length))
        return bool(steady and size > rounding / PERIODIC and not (resisted or opens))

    def _extrapolated(self, same: int) -> SteadyState | None:
        """The steady state extrapolated from the last cycles with the same events, or None if it is not proven to be their limit.

        The proof has two parts. First, a cycle from the limit comes back to it. Second, the map of one cycle is affine for all later states: they
        are weighted means of the limit, the last state and a few states between (`slower_modes`), and a cycle from each of these ends where the
        affine map says.
        """
        last, unit, proof, modes = self.last[-1], np.resize(self.scales.length, self.latest.after.shape), None, None
        for count in range(same, _LEAST - 1, -2):  # the first of these cycles may have another map: the same events in another order
            cycles = self.last[-count:]
            states = np.array([cycles[0].before, *(cycle.after for cycle in cycles)])
            limit = fixed_point(states)
            modes = slower_modes((states - limit) / unit)
            proof = None if modes is None else self.path.restarted_at(limit)
            if proof is not None:
                break
        if proof is None or modes is None:
            return None
        shares = [(last.before - limit, last.after - limit), *((unit * before, unit * after) for before, after in modes)]
        tried = [(size * before, size * after) for before, after in shares for size in (1.0, _NEAR)][1:]  # the first one is the last cycle itself
        try:
            proving = self._follow(proof)
            if self._change(proving) > PERIODIC:
                return None
            for before, after in tried:
                probe = self.path.restarted_at(limit + before)
                if probe is None:
                    return None
                off = self._distance(self._follow(probe).after, limit + after)
                if off > PERIODIC + _AFFINE * self._distance(before, after):
                    return None
        except NoContinuation:
            return None
        if self._safe(limit):
            return self._at_rest(proof, proving, True)
        return self._periodic(proof, proving, self._change(proving), True) if self._conclusive(proving) else None

    def _safe(self, u: Array) -> bool:
        """Whether the slip keeps every node closed and within its bound at every corner."""
        path, n = self.path, self.path.nodes
        if np.any(u[n:] + path.state.gap > 0):
            return False
        q, p = np.split(np.array(path.corners) + path.stress(u), 2, axis=1)
        return bool((np.minimum(path.friction * p - np.abs(q), p) >= -SAFE * self.scales.mean).all())

    def _slips(self, cycle: Cycle) -> bool | None:
        """Whether some node slips in a periodic cycle, by its work; None where it is too little to tell.

        A slip of 1e-9 slip scales of the mean load is none, under the node's own pressure (that of the mean load, if too little). Work is more
        than rounding if it is the same in two cycles, and without doubt if it is that of such a slip in slip scales of the largest corner force.
        """
        mean, force, length = self.scales
        pressure, unit = np.max([r[self.path.nodes :] for _, r in cycle.corners], axis=0), length * np.minimum(1.0, self.path.friction)
        pressure = np.where(pressure > LITTLE * mean, pressure, mean)
        far, work = self._distance(cycle.after, 0 * cycle.after), cycle.work  # slips lose digits to their own size
        if np.any(work > max(RESIDUAL, ROUNDING * far) * np.minimum(pressure, force) * unit):
            return True
        in_doubt = work > RESIDUAL * np.minimum(pressure, mean) * (mean / force) * unit
        before = self.last[-2].work if len(self.last) > 1 and cycle is self.latest else np.full_like(work, np.inf)
        repeated = (np.abs(work - before) <= LEVEL * work) & (work > ROUNDING * np.maximum(force, far * pressure) * unit)
        return None if in_doubt.any() and not np.any(in_doubt & repeated) else bool(in_doubt.any())

    def _conclusive(self, cycle: Cycle) -> bool:
        """Whether a periodic cycle decides: it slips; or it does not, and some node lifts off or has no friction.

        If all nodes stay closed and have friction, little work may still decay to zero: shakedown needs a safe slip.
        """
        return self._slips(cycle) or (self._slips(cycle) is False and bool((self.path.friction == 0).any() or self._open(cycle).any()))

    def _open(self, cycle: Cycle) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """(N,) whether each node is open at some corner at which the load turns."""
        gaps = [u[self.path.nodes :] + self.path.state.gap for number, (u, _) in zip(self.stops, cycle.corners, strict=True) if number in self.turns]
        return np.asarray(np.any(np.array(gaps) > 0, axis=0))

    def _periodic(self, path: ExactPath, cycle: Cycle, change: float, extrapolated: bool) -> SteadyState:
        """The steady state of a periodic cycle; it is shakedown if the work of friction is below the tolerance."""
        if self._slips(cycle):
            return self._result(path, Outcome.CYCLIC_SLIP, cycle, change, extrapolated)
        return self._result(path, Outcome.SHAKEDOWN, replace(cycle, work=0 * cycle.work), change, extrapolated)

    def _at_rest(self, path: ExactPath, cycle: Cycle, extrapolated: bool) -> SteadyState:
        """Shakedown to a safe slip, which does not change at any corner."""
        u = cycle.after
        resting = [(u, corner + path.stress(u)) for corner in self._loads]
        violation = self._violation(cycle)
        return self._result(path, Outcome.SHAKEDOWN, replace(cycle, work=0 * cycle.work, corners=resting), violation, extrapolated)

    def _result(self, path: ExactPath, outcome: Outcome, cycle: Cycle, change: float, extrapolated: bool) -> SteadyState:
        self.settled = path
        residual = max(change, self._violation(cycle), cycle.energy, self.energy)
        if not residual <= RESIDUAL:
            raise SolverError(
                f"steady state: its states violate the contact law or the balance of energy, or do not come back, by {residual:.1e} (tolerance "
                f"{RESIDUAL:g}); {path.cause_of_rounding}"
            )
        n, gap, load = path.nodes, path.system.gap, path.corners[-1]
        return SteadyState(
            outcome=outcome,
            dissipation=float(cycle.work.sum()),
            dissipation_per_node=frozen(cycle.work),
            system=path.system,
            cycle=path.cycle,
            friction=frozen(path.friction),
            load_factor=path.load_factor,
            slip=frozen(cycle.after[:n]),
            gap=frozen(cycle.after[n:] + gap),
            state=ContactState(cycle.after[:n], np.maximum(cycle.after[n:] + gap, 0.0), load[:n], load[n:]),
            open=self._open(cycle),
            first_cycle=self.first,
            cycles=self.cycles,
            events=int(path.state.trace[0]),
            extrapolated=extrapolated,
            unproven=path.unproven,
            record=SolveRecord("path", (), residual, left_out_corners(self.stops, len(path.corners)), perf_counter() - path.started),
        )
