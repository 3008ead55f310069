"""The load factor up to which a contact comes to rest after assembly and a protocol of loads."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    Array,
    Kept,
    Outcome,
    PerNode,
    Plotted,
    choice,
    finite_array,
    finite_number,
    frozen,
    number_of,
    progress_bar,
    shown,
    warns_of_odd_values,
    whole_number,
)
from ..base.checks import listed_parts
from ..contact import ContactSystem, LoadCycle, checked_cycle, checked_system, friction_coefficients
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import pose, shakedown_limit
from ..transients.cycles import Run
from ..transients.march import path_of
from ..transients.steady import MOST_CYCLES, reported
from .range_starts import RangeStarts
from .starts import LoadStep, assemble

REST, SLIP, UNDECIDED = "rest", "slip", "UNDECIDED"
"""Outcomes after a protocol: rest, continuing slip, or a transient without result."""


class TransientsAfter:
    """Transients of one contact, from its starts through a protocol into its load cycle.

    `start` is "assembled", "worst", or a slip. `count_one` is called for each transient.
    `no_result` is the reason why the last transient without a result has none.
    """

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        friction: PerNode,
        start: str | ArrayLike,
        steps: int | None,
        count_one: Callable[[], object],
    ) -> None:
        self.system = checked_system(system)
        self.cycle = checked_cycle(cycle)
        self.friction = np.array(friction_coefficients(friction, system))
        self.steps = steps
        self.count = 0
        self.residual = 0.0
        self.no_result = ""
        self._count_one = count_one
        kind = choice("start", start, ("assembled", "worst")) if isinstance(start, str) else ""
        self.assembled = kind == "assembled"
        if kind:
            self.starts = [np.zeros(system.slip_shape)]
        else:
            self.starts = [finite_array("start", start, system.slip_shape)]
        if kind == "worst":
            extremes = RangeStarts(pose(system, cycle, self.friction), 0.0).under_mean_load
            self.starts += extremes.values()

    def outcome_of_starts(self, load_factor: float, protocol: Sequence[LoadStep]) -> str:
        """Whether the contact comes to rest from all starts: an outcome.

        If the contact keeps slipping from a start, this start moves to the front, to be the first
        at the next load factor.
        """
        outcomes = list[str]()
        for number, start in enumerate(self.starts):
            outcomes.append(self.outcome(load_factor, protocol, start))
            if outcomes[-1] == SLIP:
                self.starts.insert(0, self.starts.pop(number))
                return SLIP
        return UNDECIDED if UNDECIDED in outcomes else REST

    def outcome(self, load_factor: float, protocol: Sequence[LoadStep], start: Array) -> str:
        """Whether the contact comes to rest from one start: an outcome."""
        path = path_of(self.system, self.cycle, self.friction, load_factor, start, steps=self.steps)
        loads = [step.reactions(self.system, load_factor) for step in protocol]
        if loads:
            path.check_near("protocol", loads)
            loads.append(path.mean)
        self.count += 1
        self._count_one()
        try:
            if self.assembled:
                assemble(path)
            else:
                path.start()
            for number, load in enumerate(loads):
                path.follow_to(load, f"segment {number} of the protocol")
            run = Run(path, MOST_CYCLES)
            state = reported(run, run.settled(), np.inf)  # without a step error
        except (NoContinuation, SolverError) as error:
            self.no_result = str(error)
            return UNDECIDED
        self.residual = max(self.residual, state.residual)
        return REST if state.outcome is Outcome.SHAKEDOWN else SLIP


def first_change(
    changed: Callable[[float], bool], grid: Array, tolerance: float
) -> tuple[float, float]:
    """The interval, at most as wide as the tolerance, in which `changed` first becomes true.

    The values of the grid are tried upwards, then a bisection narrows the interval. (last value,
    inf) if it never becomes true.
    """
    low, high = 0.0, np.inf
    for value in grid.tolist():
        if changed(value):
            high = value
            break
        low = value
    while np.isfinite(high) and high - low > tolerance:
        middle = (low + high) / 2
        if changed(middle):
            high = middle
        else:
            low = middle
    return low, high


@dataclass(frozen=True, eq=False, repr=False)
class LimitAfterProtocol(Kept, Plotted):
    """The load factor up to which a contact comes to rest after a protocol, by transients.

    Attributes
    ----------
    load_factor, upper
        `load_factor` is the largest load factor tried up to which the contact always comes to rest.
        `upper` is the least load factor tried at which it does not, or at which a transient has no
        result, see `note`; inf if it comes to rest at all load factors tried.
    shakedown_limit
        lambda_2, which no protocol exceeds while all nodes stay closed.
    starts
        (S, N), in space (S, N, 2), the starts, length. From the first of them, slip continues at
        `upper`.
    tried
        DataFrame, one row for each load factor tried: load_factor; ratio, the load factor divided
        by lambda_2; outcome, which is "rest", "slip", or "UNDECIDED" if a transient has no result.
    transients, residual
        Number of transients followed, and largest residual of their steady states, at most 1e-9.
    note
        Why the transient at `upper` has no result, for example because the protocol makes a body
        slide off; "" if it keeps slipping.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> limit = fo.limit_after_protocol(rod, cycle, friction=0.5)
    >>> round(limit.ratio, 3), limit.monotonic
    (1.0, True)
    """

    _shown_names = ("load_factor", "ratio", "upper", "monotonic", "transients", "residual")
    load_factor: float
    upper: float
    shakedown_limit: float
    starts: Array = field(repr=False)
    tried: pd.DataFrame = field(repr=False)
    transients: int
    residual: float
    note: str = ""

    @property
    def ratio(self) -> float:
        """The load factor divided by lambda_2."""
        return self.load_factor / self.shakedown_limit if self.shakedown_limit > 0 else np.nan

    @property
    def monotonic(self) -> bool:
        """Whether the contact comes to rest at no load factor tried above `upper`."""
        outcomes = self.tried.loc[self.tried["load_factor"] > self.upper, "outcome"]
        return not (outcomes == REST).any()

    def to_frame(self) -> pd.DataFrame:
        """The load factors tried, see `tried`."""
        return self.tried.copy()

    def _answer(self) -> Mapping[str, object]:
        answer = dict(super()._answer())
        if self.note:
            answer["note"] = self.note
        return answer


@warns_of_odd_values
def limit_after_protocol(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: PerNode,
    *,
    protocol: Sequence[LoadStep] = (),
    start: str | ArrayLike = "assembled",
    up_to: float | None = None,
    scan: int | ArrayLike = 25,
    tolerance: float = 1e-4,
    steps: int | None = None,
    progress: bool = True,
) -> LimitAfterProtocol:
    """Find the load factor up to which a contact comes to rest, for its assembly and a protocol.

    Transients are followed at evenly spaced load factors. A bisection narrows the interval below
    the first load factor at which slip continues. Between the load factors tried the outcome is not
    known.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle, and its coefficient of friction, one or one per node.
    protocol
        Loads between the start, which is at the mean load, and the cycle. After them, the load
        returns to the mean load.
    start
        "assembled": the mean load grows from a millionth of itself, without slip. "worst": all
        extreme slips that the contact can hold under the mean load; the first start that keeps
        slipping decides. Or a residual slip, (N,) or in space (N, 2), length.
    up_to
        Largest load factor tried; None: the shakedown limit.
    scan
        Number of load factors tried before the bisection; or these load factors as shares of
        `up_to`, rising, above 0, and up to 1, such as the guaranteed limit over the shakedown limit
        and 1.
    tolerance
        Width of the last interval of the bisection, divided by the largest load factor tried.
    steps, progress
        Number of increments from load to load (None: the exact path in the plane, 20 in space), and
        whether to show the progress after two seconds. Ctrl-C raises KeyboardInterrupt with an
        attribute `table`, the load factors tried so far.

    Returns
    -------
    LimitAfterProtocol
        The load factor, and all load factors tried.

    Raises
    ------
    ModelError
        Bad input; or no `up_to`, if the shakedown limit is not a finite number above 0.
    SolverError
        The shakedown limit is not found.

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> unload = [fo.starts.LoadStep({"P": 0.2})]
    >>> ways = {"start": "worst"}, {"start": "worst", "protocol": unload}, {"start": "assembled"}
    >>> [round(fo.limit_after_protocol(pair, cycle, friction=0.6, **way).ratio, 2) for way in ways]
    [0.54, 0.85, 1.0]
    """
    loads = listed_parts("protocol", protocol, LoadStep)
    shares = _checked_scan(scan)
    tolerance = finite_number("tolerance", tolerance, above=0.0, below=1.0)
    tried: dict[float, str] = {}  # load factor -> outcome
    no_result: dict[float, str] = {}  # load factor -> why a transient has no result

    def table() -> pd.DataFrame:
        return pd.DataFrame(sorted(tried.items()), columns=["load_factor", "outcome"])

    def slips(load_factor: float) -> bool:
        tried[load_factor] = transients.outcome_of_starts(load_factor, loads)
        if tried[load_factor] == UNDECIDED:
            no_result[load_factor] = transients.no_result
        best = _rest_so_far(tried)
        note = f"{best}; the attribute `table` has {number_of(len(tried), 'load factor')}"
        bar.keep("table", table, note, best)
        return tried[load_factor] != REST

    with progress_bar(progress, "limit after a protocol", "transient") as bar:
        transients = TransientsAfter(system, cycle, friction, start, steps, bar.update)
        limit = shakedown_limit(system, cycle, friction).load_factor
        if up_to is None and not 0 < limit < np.inf:
            raise ModelError(
                f"up_to: None, and the shakedown limit is {limit:g}; give the largest load factor "
                "to try"
            )
        largest = limit if up_to is None else finite_number("up_to", up_to, above=0.0)
        grid = largest * shares
        low, high = first_change(slips, grid, tolerance * largest)
        # Load factors above the limit may bring other starts to the front.
        starts = frozen(transients.starts)
        for factor in grid[grid > high].tolist():
            if factor not in tried:
                slips(factor)
    answer = table()
    answer.insert(1, "ratio", answer["load_factor"] / limit)
    note = ""
    if high in no_result:
        note = f"load factor {high:.4g}: no result, so rest is possible there: {no_result[high]}"
    return LimitAfterProtocol(
        low, high, limit, starts, answer, transients.count, transients.residual, note
    )


def _checked_scan(scan: ArrayLike) -> Array:
    """The shares of the largest load factor that are tried before the bisection."""
    if isinstance(scan, str) or not hasattr(scan, "__len__"):
        number = whole_number("scan", scan, least=1)
        return np.arange(1, number + 1) / number
    shares = finite_array("scan", scan, (None,))
    if not len(shares) or shares[0] <= 0 or shares[-1] > 1 or (np.diff(shares) <= 0).any():
        raise ModelError(f"scan: {shown(scan)}; give a number, or shares above 0 that rise up to 1")
    return shares


def _rest_so_far(tried: Mapping[float, str]) -> str:
    """The largest load factor below all that slip, in words. `tried`: load factor -> outcome."""
    slipping = [load_factor for load_factor, outcome in tried.items() if outcome != REST]
    upper = min(slipping, default=np.inf)
    largest = max((load_factor for load_factor in tried if load_factor < upper), default=0.0)
    return f"rest up to {largest:.4g} so far"
