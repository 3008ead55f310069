"""The cycles of a transient until its steady state is proven, on the exact path and in increments; what they show is told by `classify.py`."""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..base import PERIODIC, REPEATED, RESIDUAL, Array, Outcome
from ..contact import parted
from ..errors import NoContinuation, SolverError
from .classify import (
    LEAST,
    Settled,
    bend,
    classify,
    distance_left,
    extrapolate,
    fixed_point,
    without_work,
    work_error,
    work_to_come,
)
from .transient import Cycle, Transient

# largest deviation from an affine map, over the change, that is accepted: a new event changes it by
# more
_AFFINE = 1e-3
_WINDOW = 12  # number of last cycles that an extrapolation uses
# distance of a fixed point, in slip scales, from which on it is looked for: returns from further
# off tell little of it
_CLOSE = 1e-2
_GAIN = 4  # ratio of the changes in returns from one extrapolated fixed point and the next
_PATIENT, _MOST = (
    60,
    6,
    # cycles of a transient for each more extrapolation in turn until the changes fall so, for many
    # nodes turn, and how many
)
# difference of the works at fixed points from two states of a transient, over their sum, up to
# which these are one
_SAME = 3e-8
_LATER, _TOLD = (
    1e-2,
    1e-5,
    # error of a work whose last events are yet to come, over its distance (0.4 % in random contacts),
    # and the largest taken
)
_BETWEEN = (0.5, 0.1)  # shares of the way from the fixed point to the last state
_MORE = 30  # cycles followed until the work repeats
# error of a work, over itself, from which on all of it may die out: slow decay has an error of 1,
# known to some per cent
_DIES_OUT = 0.5
# a drift that changes by a smaller share of itself from cycle to cycle needs more than ten thousand
# cycles to die out
_SLOW = 1e-3


class _Fixed(NamedTuple):
    """A fixed point of increments: a return from it; and two errors of its work, over that: from the one before it, and for events yet to come."""

    cycle: Cycle
    aside: float = 0.0
    later: float = 0.0


@dataclass(eq=False)
class Run:
    """The cycles of one transient so far.

    Attributes
    ----------
    path
        The transient.
    most
        Number of cycles after which to give up.
    tell
        What to call after each return.
    period
        Load cycles in one return: 1, or 2 from where two of them come back and one does not.
    cycles
        Number of load cycles followed, including those of proofs.
    works
        Work of friction in each load cycle of the transient itself.
    last
        Its last returns. The first one starts at the mean load, not at the last corner, and is not
        among them.
    lost
        Largest error of the balance of energy in a return.
    extrapolated, slow
        Whether the transient went on from its limit; and the sum of all later changes over the last
        one, where it did.
    tried, pause
        Extrapolations that failed since the events last changed, and returns until the next one.
    fixed
        In increments the last fixed point that was found.
    """

    path: Transient
    most: int
    tell: Callable[[], object] = lambda: None
    period: int = 1
    cycles: int = 0
    works: list[float] = field(default_factory=list)
    last: list[Cycle] = field(default_factory=list)
    lost: float = 0.0
    extrapolated: bool = False
    slow: float = 1.0
    tried: int = 0
    pause: int = 0
    fixed: _Fixed | None = None

    def settled(self) -> Settled:
        """The steady state.

        Raises
        ------
        NoContinuation
            The transient ends, or no steady state is proven within the number of cycles; attributes
            say what is known by then.
        """
        while (found := self.advance()) is None:
            pass
        return found

    def advance(self) -> Settled | None:
        """One more return; the steady state, if it is proven by then.

        Raises
        ------
        NoContinuation
            As `settled` does.
        """
        first, latest = not self.works, self.follow(self.path)
        self.works, self.lost = self.works + latest.works, max(self.lost, latest.lost)
        self.last = [] if first else [*self.last[-_WINDOW:], latest]
        if found := self._shown(latest) or (self._extrapolated() if self.last else None):
            return found
        pairs, ahead = list(pairwise(self.last[-LEAST - 1 :])), ""
        undone = [
            later.change > max(PERIODIC, 2 * np.abs(later.after - earlier.before).max())
            for earlier, later in pairs
        ]
        if (
            self.period == 1 and len(undone) == LEAST and all(undone)
        ):  # two returns change less than half of what one does
            self.period, self.last, self.tried, self.pause = 2, [], 0, 0
        elif 0 < self.tried == self.pause and not self.path.steps:
            ahead = self._drifts_on()
        if ahead or self.cycles + self.period > self.most:
            raise self._given_up(latest, ahead)
        return None

    def follow(self, path: Transient | None) -> Cycle:
        """One return of a transient; NoContinuation if it ends, or there is none."""
        if path is None:
            raise NoContinuation("steady state: there is no state to follow")
        cycle = path.cycle_on(self.period)
        self.cycles += self.period
        self.tell()
        return cycle

    def _shown(self, cycle: Cycle) -> Settled | None:
        """The steady state, if the last returns prove one."""
        found = classify(self.path, cycle, self.last, self.extrapolated)
        return self._repeated() if found and found.outcome is Outcome.CYCLIC_SLIP else found

    def _repeated(self) -> Settled | None:
        """Slip that comes back, once its work repeats too; rest, if that dies out."""
        cycles = self.last[-2:]
        while (
            not (off := work_error(self.path, cycles, self.slow)) <= RESIDUAL
            and len(cycles) < _MORE
        ):
            cycles.append(
                self.follow(self.path)
            )  # a change that counts as none is a share of little slip
            if not cycles[-1].work.any():
                return without_work(self.path, cycles[-1])
        told = max(off, self.slow * self.fixed.aside, self.fixed.later) if self.fixed else off
        return (
            Settled(Outcome.CYCLIC_SLIP, self.path, cycles[-1], told, (cycles[-1],))
            if off < _DIES_OUT
            else None
        )

    def _extrapolated(self) -> Settled | None:
        """The steady state at the limit of the last returns, if the transient can be proven to go there: it then goes on from that limit."""
        try:
            proven = self._proven_fixed_point() if self.path.steps else self._proven_limit()
        except (NoContinuation, SolverError):
            proven = None
        if proven is None:
            return None
        self.slow = (
            distance_left([cycle.change for cycle in self.last[-3:]], REPEATED)
            / self.last[-1].change
        )
        self.path, cycle = proven
        self.last, self.extrapolated, self.tried, self.pause = [cycle], True, 0, 0
        return self._shown(cycle)

    def _proven_limit(self) -> tuple[Transient, Cycle] | None:
        """A transient at the limit of the last returns with the same events, if it is proven to be theirs, and its return.

        The proof has two parts. First, a return from the limit comes back to it. Second, the map of
        one return is affine for all later states: a return from each of the states of which these
        are means (`extrapolate`) ends where the affine map says.
        """
        last = self.last
        if len({cycle.events for cycle in last[-LEAST:]}) > 1 or len(last) < LEAST:
            self.tried = self.pause = 0
            return None
        if self.pause:
            self.pause -= 1
            return None
        self.tried = self.pause = self.tried + 1
        for limit, moves in extrapolate(last):
            if (proof := self.path.at(limit)) is None:
                continue
            proving = self.follow(proof)
            if proving.change > PERIODIC:
                return None
            for before, after in moves:
                off = np.abs(self.follow(self.path.at(limit + before)).after - limit - after).max()
                if off > PERIODIC + _AFFINE * np.abs(before - after).max():
                    return None
            return proof, proving
        return None

    def _proven_fixed_point(self) -> tuple[Transient, Cycle] | None:
        """A transient at a fixed point of increments, if returns contract towards it, and its return.

        The last return of the transient itself and those from states between came closer. Where
        returns keep some slips there are other fixed points nearby, so that a later state must lead
        to the same works. Events that it has yet to meet move them, less the closer it is.
        """
        self.pause = max(self.pause - 1, 0)
        if self.pause or len(self.last) < LEAST:
            return None
        last, patience, self.tried = (
            self.last[-1],
            min(1 + len(self.works) // _PATIENT, _MOST),
            self.tried + 1,
        )
        limit = fixed_point(np.array([(one.before, one.after) for one in self.last]))
        limit = np.where(
            np.abs(last.after - last.before) <= REPEATED, last.after, limit
        )  # what sticks by now stays where it is
        if np.abs(limit - last.after).max() > _CLOSE:
            return None
        self.pause = LEAST * patience
        if (found := self._iterated(limit, patience)) is None:
            return None
        proof, proving, turns = found
        between = [
            self.follow(self.path.at(proving.after + share * (last.after - proving.after)))
            for share in _BETWEEN
        ]
        closer = all(
            np.linalg.norm(one.after - proving.after) < np.linalg.norm(one.before - proving.after)
            for one in [last, *between]
        )
        none = (
            RESIDUAL * self.path.scales.mean * self.path.scales.length
        )  # the work of a slip that counts as none
        earlier, self.fixed = (
            self.fixed,
            self.fixed._replace(cycle=proving) if self.fixed else _Fixed(proving),
        )
        if earlier is None or not closer:
            return None
        apart, later = (
            np.abs(proving.work - earlier.cycle.work),
            turns * _LATER * work_to_come(self.last[-LEAST:], proving, none),
        )
        self.fixed = _Fixed(proving, float(apart.sum() / (proving.work.sum() or 1.0)), later)
        self.pause = max(LEAST * turns, (later > _TOLD) * len(self.works) // 4)
        return (
            (proof, proving)
            if (apart <= _SAME * proving.work.sum() + none).all() and later <= _TOLD
            else None
        )

    def _iterated(self, limit: Array, patience: int) -> tuple[Transient, Cycle, int] | None:
        """A transient at a fixed point near a limit, its return, and by how many times as much later events may move it.

        The map of increments is not affine where slips turn, so one extrapolation follows the
        other, by returns from the point before, which change less than a quarter as much; after
        many cycles several in turn may take that.
        """
        changes, returns, turns = [self.last[-1].change], list[Cycle](), 1
        while (proof := self.path.at(limit)) and (proving := self.follow(proof)).change > PERIODIC:
            changes.append(proving.change)
            turns = turns if proving.change < changes[-2] / _GAIN else patience
            if not min(changes[-patience:]) < min(changes[:-patience], default=np.inf) / _GAIN:
                return None
            returns = [proving, *(self.follow(proof) for _ in range(LEAST)), *returns][
                : (LEAST + 1) * patience
            ]
            limit = fixed_point(np.array([(one.before, one.after) for one in returns]))
        return (proof, proving, turns) if proof else None

    def _drifts_on(self) -> str:
        """In words, that more returns cannot help: one from where the drift leads in all cycles left has the same events and drift.

        Empty where this is not so. Asked only when an extrapolation has failed on the exact path,
        and where neither the drift nor its change of the gaps would die out in these cycles: a
        drift that changes no gap may yet be proven to be ratcheting.
        """
        last, left, turns, n = (
            self.last[-1],
            (self.most - self.cycles) // self.period,
            bend(self.last),
            self.path.nodes,
        )
        drift = last.after - last.before
        if (
            left <= 0
            or last.change <= PERIODIC
            or turns.max() >= min(_SLOW, 1 / left) * last.change
        ):
            return ""
        if not (np.abs(drift) - left * turns)[n:].max() > PERIODIC * np.abs(drift).max():
            return ""
        try:
            ahead = self.follow(self.path.at(last.after + left * drift))
        except NoContinuation:
            return ""
        if (
            ahead.events != last.events
            or not 2 * np.abs(ahead.after - ahead.before - drift).max() < last.change
        ):
            return ""
        return f"; a cycle from where the drift leads in {left} more cycles has the same events, changes gaps, and drifts by {ahead.change:.1e}"

    def _given_up(self, latest: Cycle, ahead: str) -> NoContinuation:
        """The error that says why no steady state is proven, what to change, and what is known after the latest return."""
        path, change, same = (
            self.path,
            latest.change,
            len(self.last) > 1 and self.last[-2].events == latest.events,
        )
        decay = float(bend(self.last).max()) / change if same and change > 0 else np.inf
        if path.far_start:
            hint = path.cause_of_rounding
        elif change <= PERIODIC:
            hint = (
                f"its work of friction, {latest.work.sum():.1e} a cycle, is too little beside forces of {path.largest:.1e} to tell slip from "
                "none: take a load factor further from the limit, or loads that are closer together"
            )
        elif self.tried and decay < _SLOW:
            hint = (
                f"from one cycle to the next this changes by only {decay:.1e} of itself: slow ratcheting, or a body that rolls or that nothing "
                f"guides; guide it by a Support, or follow its drift with march{ahead}"
            )
        else:
            hint = "allow more"
        span = "a cycle" if self.period == 1 else "in two cycles"
        error = NoContinuation(
            f"steady state: none proven within {self.cycles} of most_cycles = {self.most} cycles "
            f"(the slip changes by {change:.1e} slip scales {span}); {hint}"
        )
        error.slip, gap = parted(latest.u[-1], path.system.tangents + 1)
        error.gap, error.work = gap + path.system.gap, np.array(self.works)
        return error
