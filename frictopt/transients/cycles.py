"""The cycles of a transient until its steady state is proven.

The last cycles are enough to prove a steady state. After each cycle, `Run.advance` takes three
steps:

1. `classify.py` checks the last cycles. They prove a steady state if the contact is at rest, if its
   slip repeats, or if its slip drifts by the same amount in each cycle. Slip counts as repeated
   only once its work repeats too.
2. If the last cycles prove none, `extrapolation.py` computes the limit of the cycles. If the
   transient is proven to approach this limit, it continues from the limit, and `classify.py` checks
   the cycle that starts there.
3. If two cycles together change the state much less than one cycle does, two load cycles are one
   return from now on. If no cycles are left, or more cycles cannot help, NoContinuation is raised.

A *return* is the part of a transient that may repeat: one load cycle, or two. The `change` of a
return is the largest difference between the states at its ends, in slip scales.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from math import ceil

import numpy as np

from ..base import PERIODIC, REPEATED, RESIDUAL, Outcome
from ..contact import parted
from ..errors import NoContinuation, SolverError
from .classify import Settled, bend, classify, distance_left, without_work, work_error
from .extrapolation import AffineLimit, CurvedLimit, LimitSearch
from .transient import FollowedCycle, Transient

# The numbers of `Run`.

# Number of returns before the latest one that are kept for extrapolation.
_KEPT_RETURNS = 12
# Number of successive returns that must alternate before two cycles count as one return.
_ALTERNATING_RETURNS = 4
# Largest number of returns that are compared until the work of friction repeats.
_COMPARED_RETURNS = 30
# If the relative error of a work is at least this number, the work may decay to zero. The error of
# a slowly decaying work is 1.
_DYING_WORK = 0.5
# A drift that changes by less than this share from return to return needs more than ten thousand
# cycles to die out.
_SLOW_DECAY = 1e-3
# Number of the last returns whose changes show how many cycles are left.
_DECAYING_RETURNS = 4


@dataclass(eq=False)
class Run:
    """The cycles of one transient so far.

    Attributes
    ----------
    path
        The transient.
    most_cycles
        Number of load cycles after which the run gives up.
    report
        Function to call after each return.
    period
        Load cycles in one return, 1 or 2.
    cycles
        Number of load cycles followed, including those of proofs.
    works
        Work of friction in each load cycle of the transient itself.
    last
        The last returns. The very first return is left out, because it starts at the mean load and
        not at the last corner.
    lost
        Largest error of the balance of energy in a return.
    extrapolated
        Whether the transient has continued from an extrapolated limit.
    later_changes
        Estimated sum of all later changes, relative to the last change, when the transient
        continued from an extrapolated limit; 1 if it never did.
    search
        The search for the limit of the last returns.
    """

    path: Transient
    most_cycles: int
    report: Callable[[], object] = lambda: None
    period: int = 1
    cycles: int = 0
    works: list[float] = field(default_factory=list)
    last: list[FollowedCycle] = field(default_factory=list)
    lost: float = 0.0
    extrapolated: bool = False
    later_changes: float = 1.0
    search: LimitSearch = field(init=False)

    def __post_init__(self) -> None:
        self.search = CurvedLimit() if self.path.steps else AffineLimit()

    def settled(self) -> Settled:
        """The steady state.

        Raises
        ------
        NoContinuation
            The transient ends, or no steady state is proven within the number of cycles. The
            attributes of the error hold the partial result.
        """
        while True:
            settled = self.advance()
            if settled is not None:
                return settled

    def progress(self) -> str:
        """The change of slip per return, and about how many cycles are left at this rate.

        The number of cycles follows from the decay of the last changes. An extrapolation may end
        the run earlier.
        """
        last = self.last[-_DECAYING_RETURNS:]
        if not last:
            return ""
        change = float((np.abs(last[-1].after - last[-1].before) * self.path.unit).max())
        span = "a cycle" if self.period == 1 else "two cycles"
        units = self.path.system.units
        unit = "" if units is None else f" {units.split(', ')[1]}"
        changes = [cycle.change for cycle in last]
        if changes[-1] <= PERIODIC:
            return "slip repeats up to rounding"
        text = f"slip changes by {change:.1e}{unit} {span}"
        if len(changes) < _DECAYING_RETURNS:
            return text
        decay = (changes[-1] / changes[0]) ** (1 / (len(changes) - 1))
        if decay > 1 - _SLOW_DECAY:
            return f"{text}, as much as before: it drifts, or decays slowly"
        left = self.period * ceil(np.log(PERIODIC / changes[-1]) / np.log(decay))
        return f"{text}, {decay:.3g} times the change before: about {left} cycles left"

    def advance(self) -> Settled | None:
        """Follow one more return, and return the steady state if it is proven.

        Raises
        ------
        NoContinuation
            As `settled` does.
        """
        is_first = not self.works
        latest = self.follow(self.path)
        self.works = self.works + latest.works
        self.lost = max(self.lost, latest.lost)
        self.last = [] if is_first else [*self.last[-_KEPT_RETURNS:], latest]

        settled = self._classified(latest)
        if settled is None and self.last:
            settled = self._judged_at_limit()
        if settled is not None:
            return settled

        if self._alternates():
            self.period = 2
            self.last = []
            self.search.restart()
        if self.cycles + self.period > self.most_cycles:
            raise self._given_up(latest)
        return None

    def follow(self, path: Transient | None) -> FollowedCycle:
        """Follow one return of a transient; NoContinuation if it ends, or if it is None."""
        if path is None:
            raise NoContinuation("steady state: there is no state to follow")
        cycle = path.cycle_on(self.period)
        self.cycles += self.period
        self.report()
        return cycle

    def _classified(self, latest: FollowedCycle) -> Settled | None:
        """The steady state, if the last returns prove one."""
        settled = classify(self.path, latest, self.last, self.extrapolated)
        if settled is None or settled.outcome is not Outcome.CYCLIC_SLIP:
            return settled
        return self._repeated_work()

    def _repeated_work(self) -> Settled | None:
        """Cyclic slip if the work of friction repeats; rest if the work is zero; else None.

        The state has repeated up to the tolerance. If the slip is small, a change within the
        tolerance can be a large share of it. So more returns are followed until the error of their
        work is small enough.
        """
        cycles = self.last[-2:]
        error = work_error(self.path, cycles, self.later_changes)
        while not error <= RESIDUAL and len(cycles) < _COMPARED_RETURNS:
            cycles.append(self.follow(self.path))
            if not cycles[-1].work.any():
                return without_work(self.path, cycles[-1])
            error = work_error(self.path, cycles, self.later_changes)
        if not error < _DYING_WORK:
            return None
        error = max(error, self.search.work_error())
        return Settled(Outcome.CYCLIC_SLIP, self.path, cycles[-1], error, (cycles[-1],))

    def _judged_at_limit(self) -> Settled | None:
        """The steady state at the limit of the last returns, if the transient approaches the limit.

        The transient then continues from the limit, even if the cycle there proves nothing yet.
        """
        try:
            limit = self.search.find(self.path, self.last, self.follow, len(self.works))
        except (NoContinuation, SolverError):
            return None
        if limit is None:
            return None
        changes = [cycle.change for cycle in self.last[-3:]]
        self.extrapolated = True
        self.later_changes = distance_left(changes, REPEATED) / changes[-1]
        self.path, cycle = limit
        self.last = [cycle]
        self.search.restart()
        return self._classified(cycle)

    def _alternates(self) -> bool:
        """Whether each of the last returns undoes more than half of the return before it."""
        pairs = list(pairwise(self.last[-_ALTERNATING_RETURNS - 1 :]))
        undone = [
            later.change > max(PERIODIC, 2 * np.abs(later.after - earlier.before).max())
            for earlier, later in pairs
        ]
        return self.period == 1 and len(undone) == _ALTERNATING_RETURNS and all(undone)

    def _given_up(self, latest: FollowedCycle) -> NoContinuation:
        """The error of a run without a steady state, with the state after the latest return."""
        span = "a cycle" if self.period == 1 else "in two cycles"
        error = NoContinuation(
            f"steady state: none proven within {self.cycles} of most_cycles = {self.most_cycles} "
            f"cycles (the slip changes by {latest.change:.1e} slip scales {span}); "
            f"{self._hint(latest)}"
        )
        system = self.path.system
        error.slip, opening = parted(latest.u[-1], system.tangents + 1)
        error.gap = opening + system.gap
        error.work = np.array(self.works)
        return error

    def _hint(self, latest: FollowedCycle) -> str:
        """The reason that no steady state is proven, and a remedy."""
        if self.path.far_start:
            return self.path.cause_of_rounding
        if latest.change <= PERIODIC:
            return (
                f"its work of friction, {latest.work.sum():.1e} per cycle, is too small for forces "
                f"of {self.path.largest:.1e} to distinguish slip from shakedown: choose a load "
                "factor further from the limit, or loads of more similar size"
            )
        if self.search.attempts and len(self.last) > 1 and self.last[-2].events == latest.events:
            decay = float(bend(self.last).max()) / latest.change
            if decay < _SLOW_DECAY:
                return (
                    "from cycle to cycle, the relative difference of this change is only "
                    f"{decay:.1e}: slow ratcheting, or a body that rolls or has no guide; guide it "
                    "by a Support, or follow its drift with march"
                )
        return "allow more"
