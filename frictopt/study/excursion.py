"""The least excursion of the load that brings a contact to rest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import count, islice

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    Array,
    Bar,
    Kept,
    PerNode,
    Plotted,
    checked_loads,
    finite_number,
    frozen,
    progress_bar,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle, checked_cycle
from ..errors import ModelError
from .protocols import REST, UNDECIDED, Noted, TransientsAfter, first_change
from .starts import LoadStep, smooth, smooth_modes

_SAMPLES = 60  # random slips in a row that an excursion has to bring to rest


@dataclass(frozen=True, eq=False, repr=False)
class LeastExcursion(Noted, Kept, Plotted):
    """The least excursion tried after which the contact comes to rest from all starts tried.

    Attributes
    ----------
    share, loads
        Least share of the excursion, from 0 (the contact comes to rest without excursion) to 1, and
        the load at which it turns, load case name -> amplitude; inf and None if no share brings the
        contact to rest.
    start
        (N,), in space (N, 2), the start that is hardest to bring to rest, length: the last start
        for which the share had to be increased.
    sampled
        Number of fresh random starts, one after the other, that the excursion also brought to rest.
        With 95 % confidence, at most the fraction 3 / `sampled` of all such starts would keep
        slipping.
    tried
        DataFrame, one row for each share tried on the hardest start so far: share; outcome, "rest",
        "slip", or "UNDECIDED" if the transient has no result, for example because the contact
        slides or opens as a whole.
    transients, residual
        Number of transients followed, and largest residual of their steady states, at most 1e-9.
    note
        Why the first of the shares without a result has none; "" if all have one.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> unloading = {"pressure": -0.5}
    >>> fo.least_excursion(rod, cycle, 0.5, 0.4, excursion=unloading, start="assembled").share
    0.0
    """

    _shown_names = ("share", "loads", "sampled", "transients", "residual")
    share: float
    loads: Mapping[str, float] | None
    start: Array = field(repr=False)
    sampled: int
    tried: pd.DataFrame = field(repr=False)
    transients: int
    residual: float
    note: str = ""

    def to_frame(self) -> pd.DataFrame:
        """The shares tried, see `tried`."""
        return self.tried.copy()


@warns_of_odd_values
def least_excursion(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    load_factor: float,
    *,
    excursion: Mapping[str, float],
    start: str | ArrayLike = "worst",
    steps: int | None = None,
    progress: bool = True,
) -> LeastExcursion:
    """Find the least excursion of the load that brings the contact to rest.

    The excursion goes in a straight line to the mean load plus a share of `excursion`. Twenty even
    shares are tried on the start that is hardest so far. A bisection narrows the interval below the
    first share that brings it to rest to a thousandth. All other starts are then tried at this
    share. If `start` is "worst", random slips that were not tried before follow. If a contact with
    such a slip keeps slipping, this slip becomes the hardest start, and the search continues, until
    60 random slips in a row come to rest. The outcome at other shares is unknown. Other starts may
    need a larger share: see `sampled`.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and its coefficient of friction, one or one per node.
    load_factor
        Load factor, >= 0.
    excursion
        Largest excursion, load case name -> change of its amplitude.
    start, steps, progress
        As in `limit_after_protocol`; after Ctrl-C, `table` has the shares tried so far.

    Returns
    -------
    LeastExcursion
        The share of the excursion, and all shares tried.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        The shakedown limit is not found.

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> unloading = fo.least_excursion(pair, cycle, 0.6, load_factor=0.6, excursion={"P": -0.95})
    >>> unloading.share < 1, round(unloading.loads["P"], 2)
    (True, 0.23)
    >>> fo.least_excursion(pair, cycle, friction=0.6, load_factor=0.6, excursion={"P": 5.0}).share
    inf
    """
    checked_cycle(cycle)
    load_factor = finite_number("load_factor", load_factor, least=0.0)
    largest = checked_loads("excursion", excursion)
    if not any(largest.values()):
        raise ModelError(
            "excursion: no load changes; give load case name -> change of its amplitude"
        )
    with progress_bar(progress, "least excursion", "transient") as bar:
        search = _ExcursionSearch(cycle, load_factor, largest, bar)
        transients = TransientsAfter(system, cycle, friction, start, steps, bar.update)
        system.reaction(largest)  # raises if it names an unknown load case
        spread = max(float(np.ptp(start, axis=0).max()) for start in transients.starts)
        samples = _SAMPLES if transients.worst else 0
        hardest = search.run(transients, _random_slips(system, spread), samples)

    share_is_known = bool(np.isfinite(search.share))
    return LeastExcursion(
        search.share,
        search.turning_point(search.share).loads if share_is_known else None,
        frozen(hardest),
        samples if share_is_known else 0,
        search.table(),
        transients.count,
        transients.residual,
        search.note,
    )


class _ExcursionSearch:
    """Search for the least share of an excursion, with the shares tried and their outcomes.

    An interrupt keeps the shares tried.
    """

    def __init__(
        self, cycle: LoadCycle, load_factor: float, largest: Mapping[str, float], bar: Bar
    ) -> None:
        self._mean = cycle.mean
        self._load_factor = load_factor
        self._largest = largest
        self._bar = bar
        self.share = 0.0
        self.note = ""
        self.tried = list[tuple[float, str]]()

    def run(
        self, transients: TransientsAfter, random_slips: Iterator[Array], samples: int
    ) -> Array:
        """Find the share for all starts and samples in a row; return the hardest start."""
        hardest = transients.starts[0]
        while np.isfinite(self.share):
            slipping = self._slipping(transients, transients.starts)
            if slipping is None:
                slipping = self._slipping(transients, islice(random_slips, samples))
                if slipping is None:
                    break
                transients.starts.append(slipping)
            hardest = slipping

            def shakes_down(share: float, start: Array = hardest) -> bool:
                outcome = self._outcome(transients, share, start)
                self.tried.append((share, outcome))
                if outcome == UNDECIDED and not self.note:
                    self.note = f"share {share:.4g}: no result: {transients.no_result}"
                self._keep()
                return outcome == REST

            _, self.share = first_change(shakes_down, np.arange(1, 21) / 20, self.share, 1e-3)
            self._keep()
        return hardest

    def _slipping(self, transients: TransientsAfter, starts: Iterable[Array]) -> Array | None:
        """The first start that does not come to rest at the current share; None if all do."""
        for start in starts:
            if self._outcome(transients, self.share, start) != REST:
                return start
        return None

    def _outcome(self, transients: TransientsAfter, share: float, start: Array) -> str:
        protocol = [self.turning_point(share)] if share else []
        return transients.outcome(self._load_factor, protocol, start)

    def turning_point(self, share: float) -> LoadStep:
        """The load at which a share of the excursion turns."""
        names = sorted({*self._mean, *self._largest})
        return LoadStep(
            {
                name: self._mean.get(name, 0.0) + share * self._largest.get(name, 0.0)
                for name in names
            }
        )

    def table(self) -> pd.DataFrame:
        """The shares tried."""
        return pd.DataFrame(self.tried, columns=["share", "outcome"])

    def _keep(self) -> None:
        """Keep the shares tried for an interrupt."""
        least = f"at least {self.share:.4g}"
        note = f"{least}; the shares tried are in the attribute `table`"
        self._bar.keep("table", self.table, note, best=f"{least} so far")


def _random_slips(system: ContactSystem, spread: float) -> Iterator[Array]:
    """Random slips without end, every second one smooth along the interface.

    Their spreads are between a tenth of the given one and ten times as large.
    """
    rng = np.random.default_rng(0)
    modes = smooth_modes(system)
    for number in count():
        if number % 2 == 0:
            slip = smooth(rng, modes, system)
        else:
            slip = rng.normal(size=system.slip_shape)
        size = spread * 10 ** rng.uniform(-1.0, 1.0)
        # A single node has no spread.
        yield size * slip / max(np.ptp(slip, axis=0).max(), np.finfo(float).tiny)
