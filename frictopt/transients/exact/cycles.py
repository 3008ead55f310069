"""The cycles of a transient, and the proof of its steady state from the last cycles."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from time import perf_counter

import numpy as np

from ...contact import ContactState
from ...contact.answers import Outcome
from ...contact.checks import frozen
from ...contact.extrapolation import SLOW, distance_left, drift_text, limit_of
from ...contact.record import SolveRecord
from ...contact.tolerances import PERIODIC, REPEATED, RESIDUAL
from ...errors import NoContinuation, SolverError
from ..outcome import SteadyState
from .cycle import Cycle
from .judge import Judge
from .kernel import OPEN
from .path import ExactPath
from .stops import left_out_corners

__all__ = ["Run"]

_NEAR = 1e-3  # the affine map is also tested at this share of the distance from the extrapolated limit
_AFFINE = 1e-3  # largest deviation from an affine map, over the change, that is accepted: a new event changes it by more
_WINDOW = 12  # number of last cycles that an extrapolation uses
_LEAST = 4  # cycles with the same events before the first extrapolation, and cycles in turn that show a return after two
_MORE = 30  # cycles followed until the work repeats


class Run(Judge):
    """The cycles of one transient so far."""

    def __init__(self, path: ExactPath, turns: Sequence[int]) -> None:
        super().__init__(path, turns)
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
        state.work[:] = state.supplied[:] = state.slid[:] = 0.0  # else a small work is lost to rounding next to that of a far start
        state.trace[1] = 0
        before, corners = state.u.copy(), []
        for number in self._visited:
            path.follow_to(path.corners[number], f"the segment to corner {number}")
            corners.append((state.u.copy(), state.r.copy()))
        self.cycles += self.period
        after, work = state.u.copy(), state.work.copy()
        stress = path.stress((before + after) / 2)
        lost = abs(float(state.supplied[0] - work.sum() - stress @ (after - before)))
        scale = max(self.force * self.length, float(work.sum()), float(np.abs(stress) @ np.abs(before)))
        lost = max(lost, -float(work.min()))
        return Cycle(work, int(state.trace[1]), corners, before, after, lost / max(scale, np.finfo(float).tiny), state.slid.copy())

    def steady(self) -> SteadyState | None:
        """The steady state, or None if the cycles so far do not prove one."""
        last = self.latest
        if self._safe(last.after):
            return self._at_rest(self.path, last, False)
        if not self.last:
            return None
        change, earlier = self._change(last), self.last[-2] if len(self.last) > 1 else None
        if not last.work.any() and change <= PERIODIC:
            return self._result(self.path, Outcome.SHAKEDOWN, last, 0.0, False)
        if change <= PERIODIC and self._distance_left() <= RESIDUAL and self._conclusive(last, earlier):
            return self._periodic(self.path, last, earlier, False)
        if self._ratchets():
            off = abs(float(last.work.sum() - self.last[-2].work.sum()))
            return self._result(self.path, Outcome.RATCHETING, last, 0.0, False, off / float(last.work.sum()))
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

    def alternates(self) -> bool:
        """Whether each of the last cycles nearly undoes the one before: two change slip and gap by less than half of what one does."""
        pairs = list(pairwise(self.last[-_LEAST - 1 :]))
        return (
            self.period == 1
            and len(pairs) == _LEAST
            and all(self._change(later) > max(PERIODIC, 2 * self._distance(later.after, earlier.before)) for earlier, later in pairs)
        )

    def double(self) -> None:
        """From now on two load cycles count as one: their map has the states of period two as fixed points, and those of period one."""
        self.period, self.last, self.tried, self.pause = 2, [], 0, 0

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
        last, left = self.latest, (most_cycles - self.cycles) // self.period
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
        span = "a cycle" if self.period == 1 else "in two cycles"
        text = f"none proven within most_cycles = {most_cycles} cycles (the slip changes by {change:.1e} slip scales {span})"
        if self.path.far_start:
            return f"{text}; {self.path.cause_of_rounding}"
        if change > PERIODIC and self.tried and self._decay < SLOW:
            return f"none proven within {self.cycles} of most_cycles = {most_cycles} cycles; {drift_text(change, self._decay)}{self._ahead}"
        if change > PERIODIC:
            return f"{text}; allow more"
        beside = f"its work of friction, {last.work.sum():.1e} a cycle, is too little beside forces of {self.force:.1e} to tell slip from none"
        return f"{text}; {beside}: take a load factor further from the limit, or loads that are closer together"

    def _distance_left(self) -> float:
        """Estimated distance of slip and gap from their limit."""
        return distance_left([self._change(cycle) for cycle in self.last[-3:]], REPEATED)

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
        are weighted means of the limit, the last state and a few states between (`limit_of`), and a cycle from each of these ends where the
        affine map says.
        """
        last, unit, proof, found = self.last[-1], np.resize(self.scales.length, self.latest.after.shape), None, None
        for count in range(same, _LEAST - 1, -2):  # the first of these cycles may have another map: the same events in another order
            cycles = self.last[-count:]
            states = np.array([cycles[0].before, *(cycle.after for cycle in cycles)])
            found = limit_of(states / unit)
            proof = None if found is None else self.path.restarted_at(unit * found[0])
            if proof is not None:
                break
        if proof is None or found is None:
            return None
        limit, modes = unit * found[0], found[1]
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
        return self._periodic(proof, proving, None, True) if self._conclusive(proving, None) else None

    def _periodic(self, path: ExactPath, cycle: Cycle, earlier: Cycle | None, extrapolated: bool) -> SteadyState:
        """The steady state of a periodic cycle and of the one before it; it is shakedown if the work of friction is below the tolerance.

        Where the work does not yet repeat to 1e-9 of itself, more cycles are followed: a change that counts as none is a share of little slip.
        """
        if not self._slips(cycle, earlier):
            return self._result(path, Outcome.SHAKEDOWN, replace(cycle, work=0 * cycle.work), self._change(cycle), extrapolated)
        cycles = [cycle] if earlier is None else [earlier, cycle]
        slow = self._distance_left() / self._change(self.latest) if extrapolated else 1.0
        while not (off := self._work_error(cycles, slow)) <= RESIDUAL and len(cycles) < _MORE:
            cycles.append(self._follow(path))
        return self._result(path, Outcome.CYCLIC_SLIP, cycles[-1], self._change(cycles[-1]), extrapolated, off)

    def _at_rest(self, path: ExactPath, cycle: Cycle, extrapolated: bool) -> SteadyState:
        """Shakedown to a safe slip, which does not change at any corner."""
        u = cycle.after
        resting = [(u, corner + path.stress(u)) for corner in self._loads]
        violation = self._violation([*cycle.corners, *resting])
        return self._result(path, Outcome.SHAKEDOWN, replace(cycle, work=0 * cycle.work, corners=resting), 0.0, extrapolated, violation=violation)

    def _result(
        self,
        path: ExactPath,
        outcome: Outcome,
        cycle: Cycle,
        change: float,
        extrapolated: bool,
        work_error: float = 0.0,
        violation: float | None = None,
    ) -> SteadyState:
        self.settled = path
        violation = self._violation(cycle.corners) if violation is None else violation
        residual = max(change, violation, cycle.energy, self.energy)
        if not residual <= RESIDUAL:
            raise SolverError(
                f"steady state: its states violate the contact law or the balance of energy, or do not come back, by {residual:.1e} (tolerance "
                f"{RESIDUAL:g}); {path.cause_of_rounding}"
            )
        n, gap, load, work = path.nodes, path.system.gap, path.corners[-1], cycle.work / self.period
        return SteadyState(
            outcome=outcome,
            dissipation=float(work.sum()),
            dissipation_per_node=frozen(work),
            work_error=work_error,
            step_error=0.0,
            period=1 if outcome is Outcome.SHAKEDOWN else self._returns_after(cycle),
            system=path.system,
            cycle=path.cycle,
            friction=frozen(path.friction),
            load_factor=path.load_factor,
            slip=frozen(cycle.after[:n]),
            gap=frozen(cycle.after[n:] + gap),
            state=ContactState(cycle.after[:n], np.maximum(cycle.after[n:] + gap, 0.0), load[:n], load[n:]),
            open=self._open(cycle),
            slipping=self._slipping(cycle, change) & (outcome is not Outcome.SHAKEDOWN),
            first_cycle=self.first,
            cycles=self.cycles,
            events=int(path.state.trace[0]),
            extrapolated=extrapolated,
            unproven=int(path.state.trace[2]),
            steps=0,
            record=SolveRecord("path", (), residual, left_out_corners(self.turns, len(path.corners)), perf_counter() - path.started),
        )
