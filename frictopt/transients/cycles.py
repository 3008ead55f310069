"""The cycles of a transient, and what the last ones prove of its steady state: on the exact path and in increments."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from ..contact import PERIODIC, REPEATED, RESIDUAL, Outcome, parted
from ..errors import NoContinuation, SolverError
from .begin import Cycle, Transient
from .judge import at_rest, distance_left, fixed_point, limit_of, slips, work_error, work_to_come

_NEAR = 100 * PERIODIC  # the affine map is also tested where it moves by so little: other events may begin that near to the extrapolated limit
_AFFINE = 1e-3  # largest deviation from an affine map, over the change, that is accepted: a new event changes it by more
_WINDOW = 12  # number of last cycles that an extrapolation uses
_LEAST = 4  # cycles with the same events before the first extrapolation, and cycles in turn that show a return after two
_CLOSE = 1e-2  # distance of a fixed point, in slip scales, from which on it is looked for: returns from further off tell little of it
_GAIN = 4  # ratio of the changes in returns from one extrapolated fixed point and the next
_PATIENT, _MOST = 60, 6  # cycles of a transient for each more extrapolation in turn until the changes fall so, for many nodes turn, and how many
_SAME = 3e-8  # difference of the works at fixed points from two states of a transient, over their sum, up to which these are one
_LATER, _TOLD = 1e-2, 1e-5  # error of a work whose last events are yet to come, over its distance (0.4 % in random contacts), and the largest taken
_BETWEEN = (0.5, 0.1)  # shares of the way from the fixed point to the last state
_MORE = 30  # cycles followed until the work repeats
_DIES_OUT = 0.5  # error of a work, over itself, from which on all of it may die out: slow decay has an error of 1, known to some per cent
_SLOW = 1e-3  # a drift that changes by a smaller share of itself from cycle to cycle needs more than ten thousand cycles to die out


@dataclass(frozen=True, eq=False)
class Settled:
    """A steady state: its outcome, the transient on it, its cycle, the relative error of its work, and the cycles by whose states it is judged."""

    outcome: Outcome
    path: Transient
    cycle: Cycle
    work_error: float
    judged: tuple[Cycle, ...]


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
        Its last returns. The first one starts at the mean load, not at the last corner, and is not among them.
    lost
        Largest error of the balance of energy in a return.
    tried, pause
        Extrapolations that failed since the events last changed, and returns until the next one.
    fixed
        In increments a return from the last fixed point that was found.
    aside, slow, later
        Difference of the works of the last two fixed points, over that of a return: later states of the transient may lead to others. And the sum of
        all later changes over the last one, where the transient went on from its limit. And the error of its work for events that it had yet to meet.
    extrapolated
        Whether it did.
    """

    path: Transient
    most: int
    tell: Callable[[], object] = lambda: None
    period: int = 1
    cycles: int = 0
    works: list[float] = field(default_factory=list)
    last: list[Cycle] = field(default_factory=list)
    lost: float = 0.0
    tried: int = 0
    pause: int = 0
    fixed: Cycle | None = None
    aside: float = 0.0
    later: float = 0.0
    slow: float = 1.0
    extrapolated: bool = False

    def settled(self) -> Settled:
        """The steady state.

        Raises
        ------
        NoContinuation
            The transient ends, or no steady state is proven within the number of cycles; attributes say what is known by then.
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
        found = self.shown(latest)
        if found is None and self.last:
            try:
                proven = self.proven_fixed_point() if self.path.steps else self.proven_limit()
            except (NoContinuation, SolverError):
                proven = None
            if proven is not None:
                self.slow = distance_left([cycle.change for cycle in self.last[-3:]], REPEATED) / latest.change
                self.path, self.last, self.extrapolated, self.tried, self.pause = proven[0], [proven[1]], True, 0, 0
                found = self.shown(proven[1])
        if found is not None:
            return found
        pairs, ahead = list(pairwise(self.last[-_LEAST - 1 :])), ""
        undone = [later.change > max(PERIODIC, 2 * np.abs(later.after - earlier.before).max()) for earlier, later in pairs]
        if self.period == 1 and len(undone) == _LEAST and all(undone):  # two returns change less than half of what one does
            self.period, self.last, self.tried, self.pause = 2, [], 0, 0
        elif 0 < self.tried == self.pause and not self.path.steps:
            ahead = self.drifts_on()
        if ahead or self.cycles + self.period > self.most:
            raise self.given_up(latest, ahead)
        return None

    def follow(self, path: Transient | None) -> Cycle:
        """One return of a transient; NoContinuation if it ends, or there is none."""
        if path is None:
            raise NoContinuation("steady state: there is no state to follow")
        cycle = path.cycle_on(self.period)
        self.cycles += self.period
        self.tell()
        return cycle

    def shown(self, cycle: Cycle) -> Settled | None:
        """The steady state, if the last returns prove one."""
        path, last = self.path, self.last
        if (resting := at_rest(path, cycle)) is not None:
            return Settled(Outcome.SHAKEDOWN, path, resting, 0.0, (cycle, resting))
        if not last:
            return None
        if cycle.change <= PERIODIC:
            slides = slips(path, cycle, last[-2] if len(last) > 1 else None)
            far = max(1.0, float(np.abs(cycle.after).max())) if path.steps else 1.0  # increments have rounding of the size of their slips
            left = 0.0 if self.extrapolated or not cycle.work.any() else distance_left([one.change for one in last[-3:]], REPEATED * far)
            if left <= RESIDUAL and slides is not None:
                cycles = last[-2:]
                while slides and not (off := work_error(path, cycles, self.slow)) <= RESIDUAL and len(cycles) < _MORE:
                    cycles.append(self.follow(path))  # a change that counts as none is a share of little slip
                    slides = bool(cycles[-1].work.any())
                end = cycles[-1]
                if not slides:
                    return Settled(Outcome.SHAKEDOWN, path, replace(end, work=0 * end.work), 0.0, (end,))
                if off < _DIES_OUT:
                    return Settled(Outcome.CYCLIC_SLIP, path, end, max(off, self.slow * self.aside, self.later), (end,))
        drifts = self.ratchets()
        return None if drifts is None else Settled(Outcome.RATCHETING, path, replace(cycle, change=0.0), drifts, (cycle,))

    def ratchets(self) -> float | None:
        """The relative change of the work, if the slip drifts by the same amount in every return, and the drift adds no stress and changes no gap."""
        if len(self.last) < 3 or len({cycle.events for cycle in self.last[-3:]}) > 1:
            return None
        path, (before, last) = self.path, self.last[-2:]
        n, rounding = path.nodes, np.finfo(float).eps * float(np.abs(last.after).max())
        stress, opening = np.abs(last.r[-1] - before.r[-1]).reshape(-1, n), np.abs(last.u[-1] - before.u[-1])[-n:]
        steady = np.abs((last.after - last.before) - (before.after - before.before)).max() <= PERIODIC * last.change
        steady = steady and np.abs(last.work - before.work).max() <= PERIODIC * last.work.sum()
        held = (stress > PERIODIC * path.scales.force).any() or (opening > PERIODIC * last.change * path.scales.length).any()
        if not steady or held or last.change <= rounding / PERIODIC:
            return None
        return abs(float(last.work.sum() - before.work.sum())) / (float(last.work.sum()) or 1.0)

    def proven_limit(self) -> tuple[Transient, Cycle] | None:
        """A transient at the limit of the last returns with the same events, if it is proven to be theirs, and its return.

        The proof has two parts. First, a return from the limit comes back to it. Second, the map of one return is affine for all later states: they
        are weighted means of the limit, the last state and a few states between (`limit_of`), and a return from each of these ends where the affine
        map says.
        """
        last, path = self.last, self.path
        same = next((k for k, other in enumerate(reversed(last)) if other.events != last[-1].events), len(last))
        if same < _LEAST or self.pause:
            self.tried, self.pause = (0, 0) if same < _LEAST else (self.tried, self.pause - 1)
            return None
        self.tried = self.pause = self.tried + 1
        for count in range(same, _LEAST - 1, -2):  # the first of these may have another map: the same events in another order
            found = limit_of(np.array([last[-count].before, *(cycle.after for cycle in last[-count:])]))
            proof = None if found is None else path.at(found[0])
            if found is not None and proof is not None:
                break
        else:
            return None
        limit, modes = found
        shares = []
        for before, after in ((last[-1].before - limit, last[-1].after - limit), *modes):
            near = _NEAR / max(_NEAR, np.abs(before - after).max())
            shares.append((near * before, near * after))
        shares += modes
        proving = self.follow(proof)
        if proving.change > PERIODIC:
            return None
        for before, after in shares:
            off = np.abs(self.follow(path.at(limit + before)).after - limit - after).max()
            if off > PERIODIC + _AFFINE * np.abs(before - after).max():
                return None
        return proof, proving

    def proven_fixed_point(self) -> tuple[Transient, Cycle] | None:
        """A transient at a fixed point of increments, if returns contract towards it, and its return.

        Their map is not affine where slips turn, so one extrapolation follows the other, by returns from the point before, which change less than
        a quarter as much; after many cycles several in turn may take that, and the error for later events is told so many times as large. In the end
        a return comes back, while the last one of the transient itself and those from between came closer. Where returns keep some slips there are
        other fixed points nearby, so that a later state must lead to the same works. Events that it has yet to meet move them, less the closer it is.
        """
        self.pause = max(self.pause - 1, 0)
        if self.pause or len(self.last) < _LEAST:
            return None
        last, patience, self.tried = self.last[-1], min(1 + len(self.works) // _PATIENT, _MOST), self.tried + 1
        limit = fixed_point(np.array([(one.before, one.after) for one in self.last]))
        limit = np.where(np.abs(last.after - last.before) <= REPEATED, last.after, limit)  # what sticks by now stays where it is
        if np.abs(limit - last.after).max() > _CLOSE:
            return None
        self.pause, changes, returns, turns = _LEAST * patience, [last.change], list[Cycle](), 1
        while (proving := self.follow(proof := self.path.at(limit))).change > PERIODIC:
            changes.append(proving.change)
            turns = turns if proving.change < changes[-2] / _GAIN else patience
            if not min(changes[-patience:]) < min(changes[:-patience], default=np.inf) / _GAIN:
                return None
            returns = [proving, *(self.follow(proof) for _ in range(_LEAST)), *returns][: (_LEAST + 1) * patience]
            limit = fixed_point(np.array([(one.before, one.after) for one in returns]))
        limit = proving.after
        between = [self.follow(self.path.at(limit + share * (last.after - limit))) for share in _BETWEEN]
        closer = all(np.linalg.norm(one.after - limit) < np.linalg.norm(one.before - limit) for one in [last, *between])
        earlier, self.fixed = self.fixed, proving
        none = RESIDUAL * self.path.scales.mean * self.path.scales.length  # the work of a slip that counts as none
        if earlier is None or not closer or proof is None:
            return None
        apart = np.abs(proving.work - earlier.work)
        self.aside = float(apart.sum() / (proving.work.sum() or 1.0))
        self.later = turns * _LATER * work_to_come(self.last[-_LEAST:], proving, none)
        self.pause = max(_LEAST * turns, (self.later > _TOLD) * len(self.works) // 4)
        return (proof, proving) if (apart <= _SAME * proving.work.sum() + none).all() and self.later <= _TOLD else None

    def drifts_on(self) -> str:
        """In words, that more returns cannot help: one from where the drift leads in all cycles left has the same events and drift.

        Empty where this is not so. Asked only when an extrapolation has failed on the exact path, and where neither the drift nor its change of the
        gaps would die out in these cycles: a drift that changes no gap may yet be proven to be ratcheting.
        """
        (before, last), left, n = self.last[-2:], (self.most - self.cycles) // self.period, self.path.nodes
        drift, bend = last.after - last.before, np.abs((last.after - last.before) - (before.after - before.before))
        if left <= 0 or last.change <= PERIODIC or bend.max() >= min(_SLOW, 1 / left) * last.change:
            return ""
        if not (np.abs(drift) - left * bend)[n:].max() > PERIODIC * np.abs(drift).max():
            return ""
        try:
            ahead = self.follow(self.path.at(last.after + left * drift))
        except NoContinuation:
            return ""
        if ahead.events != last.events or not 2 * np.abs(ahead.after - ahead.before - drift).max() < last.change:
            return ""
        return f"; a cycle from where the drift leads in {left} more cycles has the same events, changes gaps, and drifts by {ahead.change:.1e}"

    def given_up(self, latest: Cycle, ahead: str) -> NoContinuation:
        """The error that says why no steady state is proven, what to change, and what is known after the latest return."""
        path, change, decay = self.path, latest.change, np.inf
        if len(self.last) > 1 and self.last[-2].events == latest.events and change > 0:
            before = self.last[-2]
            decay = float(np.abs((latest.after - latest.before) - (before.after - before.before)).max()) / change
        span = "a cycle" if self.period == 1 else "in two cycles"
        text = f"none proven within most_cycles = {self.most} cycles (the slip changes by {change:.1e} slip scales {span})"
        if path.far_start:
            text = f"{text}; {path.cause_of_rounding}"
        elif change > PERIODIC and self.tried and decay < _SLOW:
            text = (
                f"none proven within {self.cycles} of most_cycles = {self.most} cycles; the slip drifts by {change:.1e} slip scales a cycle, and "
                f"from one cycle to the next this drift changes by only {decay:.1e} of itself: slow ratcheting, or a body that rolls or that nothing "
                f"guides; guide it by a Support, or follow its drift with march{ahead}"
            )
        elif change > PERIODIC:
            text = f"{text}; allow more"
        else:
            text = (
                f"{text}; its work of friction, {latest.work.sum():.1e} a cycle, is too little beside forces of {path.largest:.1e} to tell slip from "
                "none: take a load factor further from the limit, or loads that are closer together"
            )
        error = NoContinuation(f"steady state: {text}")
        error.slip, gap = parted(latest.u[-1], path.system.tangents + 1)
        error.gap, error.work = gap + path.system.gap, np.array(self.works)
        return error
