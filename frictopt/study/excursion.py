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
    Kept,
    Plotted,
    bar_of,
    checked_loads,
    finite_number,
    frozen,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle
from ..errors import ModelError
from .protocols import REST, TransientsAfter, first_change
from .starts import LoadStep, smooth, smooth_modes

_SHARES, _NARROW = (
    np.arange(1, 21) / 20,
    1e-3,
)  # shares of an excursion that are tried, and width of the last interval
_SAMPLES = 60  # random slips in a row that an excursion has to bring to rest
_DECADES = (
    -1.0,
    1.0,
)  # powers of ten of the size of random slips, over the spread of the largest start


@dataclass(frozen=True, eq=False, repr=False)
class LeastExcursion(Kept, Plotted):
    """The least excursion tried after which the contact comes to rest from all starts tried.

    Attributes
    ----------
    share, loads
        Least share of the excursion, from 0 (it comes to rest without) to 1, and the load at which
        it turns, load case name -> amplitude; inf and None if none brings it to rest.
    start
        (N,), in space (N, 2), the start that is hardest to bring to rest, length: of the starts
        tried, the last one that needed more.
    sampled
        Number of random starts, drawn afresh and one after the other, that were brought to rest by
        it as well: with 95 % probability no more than 3 over this number of all such starts would
        keep slipping.
    tried
        DataFrame, one row for each share tried on the start that was hardest then: share; outcome,
        "rest", "slip", or "UNDECIDED" where the transient has no result, for example because the
        contact slides or opens as a whole.
    transients, residual
        Number of transients followed, and largest residual of their steady states, at most 1e-9.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> fo.least_excursion(rod, cycle, friction=0.5, load_factor=0.4, excursion={"pressure": -0.5}, start="assembled").share
    0.0
    """

    _said = ("share", "loads", "sampled", "transients", "residual")
    share: float
    loads: Mapping[str, float] | None
    start: Array = field(repr=False)
    sampled: int
    tried: pd.DataFrame = field(repr=False)
    transients: int
    residual: float

    def to_frame(self) -> pd.DataFrame:
        """The shares tried, see `tried`."""
        return self.tried.copy()


@warns_of_odd_values
def least_excursion(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: ArrayLike,
    load_factor: float,
    *,
    excursion: Mapping[str, float],
    start: str | ArrayLike = "worst",
    steps: int | None = None,
    progress: bool = True,
) -> LeastExcursion:
    """Find the least excursion from the mean load and back after which the contact comes to rest.

    The excursion goes in a straight line to the mean load plus a share of `excursion`. Twenty even
    shares are tried on the start that is hardest so far, and a bisection narrows the interval below
    the first one that brings it to rest to a thousandth. All other starts are then tried at this
    share. Where `start` is "worst", random slips that were not tried before follow. One that keeps
    slipping becomes the hardest, and the search goes on from there, until 60 random slips in a row
    come to rest. What happens at other shares is not known, nor from other starts, of which some
    may need more: see `sampled`.

    Parameters
    ----------
    system, cycle, friction, load_factor
        The contact, its load cycle, its coefficient of friction, one or one per node, and the load
        factor, >= 0.
    excursion
        Largest excursion, load case name -> change of its amplitude.
    start, steps, progress
        As in `limit_after_protocol`; `table` has the shares tried by then.

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
    >>> unloading = fo.least_excursion(pair, cycle, friction=0.6, load_factor=0.6, excursion={"P": -0.95})
    >>> unloading.share < 1, round(unloading.loads["P"], 2)
    (True, 0.23)
    >>> fo.least_excursion(pair, cycle, friction=0.6, load_factor=0.6, excursion={"P": 5.0}).share
    inf
    """
    load_factor, largest = (
        finite_number("load_factor", load_factor, least=0.0),
        checked_loads("excursion", excursion),
    )
    if not any(largest.values()):
        raise ModelError(
            "excursion: no load changes; give load case name -> change of its amplitude"
        )
    tried: list[tuple[float, str]] = []

    def turning(share: float) -> LoadStep:
        return LoadStep(
            {
                name: cycle.mean.get(name, 0.0) + share * largest.get(name, 0.0)
                for name in sorted({*cycle.mean, *largest})
            }
        )

    def outcome(share: float, start: Array) -> str:
        return transients.outcome(load_factor, [turning(share)] if share else [], start)

    def rests(share: float) -> bool:
        tried.append((share, outcome(share, hardest)))
        return tried[-1][1] == REST

    def slipping(starts: Iterable[Array]) -> Array | None:
        return next((start for start in starts if outcome(share, start) != REST), None)

    def kept(_: object) -> tuple[str, object, str] | None:
        table = pd.DataFrame(tried, columns=["share", "outcome"])
        return (
            ("table", table, f"at least {share:.4g}; the shares tried are in the attribute `table`")
            if tried
            else None
        )

    share = 0.0
    with bar_of(
        progress,
        "least excursion",
        "transient",
        best=lambda: f"at least {share:.4g} so far",
        keeps=kept,
    ) as bar:
        transients = TransientsAfter(system, cycle, friction, start, steps, bar.update)
        system.reaction(largest)
        samples = _SAMPLES if transients.worst else 0
        drawn = _drawn(
            np.random.default_rng(0),
            system,
            max(float(np.ptp(start, axis=0).max()) for start in transients.starts),
        )
        hardest = transients.starts[0]
        while np.isfinite(share):
            if (found := slipping(transients.starts)) is None:
                if (found := slipping(islice(drawn, samples))) is None:
                    break
                transients.starts.append(found)
            hardest = found
            share = first_change(rests, _SHARES, share, _NARROW)[1]
    known = bool(np.isfinite(share))
    table = pd.DataFrame(tried, columns=["share", "outcome"])
    loads = turning(share).loads if known else None
    return LeastExcursion(
        share,
        loads,
        frozen(hardest),
        samples if known else 0,
        table,
        transients.count,
        transients.residual,
    )


def _drawn(rng: np.random.Generator, system: ContactSystem, size: float) -> Iterator[Array]:
    """Random slips without end, of spreads from a tenth of a size to ten times, every second one smooth along the interface."""
    modes = smooth_modes(system)
    for number in count():
        slip = rng.normal(size=system.slip_shape) if number % 2 else smooth(rng, modes, system)
        yield (
            size
            * 10 ** rng.uniform(*_DECADES)
            * slip
            / max(np.ptp(slip, axis=0).max(), np.finfo(float).tiny)
        )
