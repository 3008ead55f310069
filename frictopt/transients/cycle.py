"""One return of a transient: one load cycle, or two."""

from collections.abc import Hashable
from dataclasses import dataclass

from ..contact.checks import Array


@dataclass(frozen=True, eq=False)
class Cycle:
    """One return of a transient: one load cycle, or two, with the states at which it stopped.

    Attributes
    ----------
    before, after
        (m,) what the map of a cycle acts on, in slip scales: slip and gap on the exact path, slip in increments, where the gap follows from it.
    change
        Largest difference of the two.
    work, slid
        (N,) work of friction, and way slid by each closed node, length.
    works
        Work of friction in each load cycle.
    events
        The same in two cycles where the same nodes slip and open: the changes of status, whose order within a segment of the path does not count.
    bonded, u, r
        (T, M) loads, `[v, w - g0]` and reactions: at the corners at which the exact path stops, after each increment.
    previous
        (T, M) in increments the states before those, where friction opposes the slip since; None on the exact path, which slips between stops.
    lost
        On the exact path the error of the energy balance (work of the loads, less work of friction, less elastic energy gained), or negative work of
        friction at a node, over the largest energy in the balance.
    """

    before: Array
    after: Array
    change: float
    work: Array
    slid: Array
    works: list[float]
    events: Hashable
    bonded: Array
    u: Array
    r: Array
    previous: Array | None = None
    lost: float = 0.0
