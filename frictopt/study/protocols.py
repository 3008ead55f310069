"""The load factors and the frictions with which a contact comes to rest after its assembly.

A protocol of loads may follow the assembly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    Array,
    Bar,
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
from ..contact import ContactSystem, LoadCycle, friction_coefficients
from ..errors import ModelError, NoContinuation, SolverError
from ..limits import RequiredFriction, ShakedownLimit, pose
from ..transients.cycles import Run
from ..transients.march import path_of
from ..transients.steady import MOST_CYCLES, reported
from ..transients.transient import Transient
from .range_starts import RangeStarts
from .starts import LoadStep, assemble

REST, SLIP, UNDECIDED = "rest", "slip", "UNDECIDED"
"""Outcomes after a protocol: rest, continuing slip, or a transient without result."""


class TransientsAfter:
    """Transients of one contact, from its starts through a protocol into its load cycle.

    `start` is "assembled", "worst", or a slip. `count_one` is called for each transient.
    """

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        friction: PerNode,
        protocol: Sequence[LoadStep],
        start: str | ArrayLike,
        steps: int | None,
        count_one: Callable[[], object],
    ) -> None:
        self.system = system
        self.cycle = cycle
        self.friction = friction_coefficients(friction, system)
        self.protocol = protocol
        self.steps = steps
        self.residual = 0.0
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

    def outcome_of_starts(self, load_factor: float) -> tuple[str, str]:
        """The outcome of all starts: `REST` if the contact comes to rest from each of them.

        If the contact keeps slipping from a start, this start moves to the front, to be the first
        at the next load factor. The second text is the reason if a transient has no result.
        """
        no_result = ""
        loads = [step.reactions(self.system, load_factor) for step in self.protocol]
        for number, start in enumerate(self.starts):
            problem = self.system, self.cycle, self.friction, load_factor, start
            path = path_of(*problem, steps=self.steps)
            if loads:
                path.check_near("protocol", loads)
            self._count_one()
            try:
                rests = self._rests(path, loads)
            except (NoContinuation, SolverError) as error:
                no_result = str(error)
                continue
            if not rests:
                self.starts.insert(0, self.starts.pop(number))
                return SLIP, ""
        return UNDECIDED if no_result else REST, no_result

    def _rests(self, path: Transient, loads: Sequence[Array]) -> bool:
        """Whether the contact comes to rest on a path that has not begun, after some loads."""
        if self.assembled:
            assemble(path)
        else:
            path.start()
        for number, load in enumerate(loads):
            path.follow_to(load, f"segment {number} of the protocol")
        if loads:
            path.follow_to(path.mean, f"segment {len(loads)} of the protocol")
        run = Run(path, MOST_CYCLES)
        state = reported(run, run.settled(), np.inf)  # without a step error
        self.residual = max(self.residual, state.residual)
        return state.outcome is Outcome.SHAKEDOWN


class Search:
    """The load factors or the frictions tried, with their outcomes.

    `outcome_at` follows the transients at a value. It returns their outcome, and why one of them
    has no result. `rests_at` is the last value tried at which the contact comes to rest, before the
    first value at which it does not.
    """

    def __init__(
        self, name: str, bar: Bar, outcome_at: Callable[[float], tuple[str, str]], rests_at: float
    ) -> None:
        self.name = name
        self.tried = dict[float, tuple[str, str]]()  # value -> outcome, and why there is no result
        self.rests_at = rests_at
        self._bar = bar
        self._outcome_at = outcome_at

    def first_slip(self, grid: Array, tolerance: float) -> float:
        """The first value of a grid at which the contact does not come to rest; NaN if none.

        The grid rises or falls. A bisection narrows the interval before this value to the
        tolerance, if the other end of the interval is known.
        """
        first = next((value for value in grid.tolist() if not self._rests(value)), np.nan)
        while tolerance < abs(first - self.rests_at) < np.inf:
            middle = (first + self.rests_at) / 2
            if not self._rests(middle):
                first = middle
        return first

    def others_slip(self, grid: Array) -> bool:
        """Whether the contact does not come to rest at any later value of the grid, either."""
        rests_at = self.rests_at
        others = [self._rests(value) for value in grid.tolist() if value not in self.tried]
        self.rests_at = rests_at
        return not any(others)

    def table(self) -> pd.DataFrame:
        """The values tried so far, and their outcomes."""
        column = self.name.replace(" ", "_")
        rows = [(value, outcome) for value, (outcome, _) in sorted(self.tried.items())]
        return pd.DataFrame(rows, columns=[column, "outcome"])

    def note(self, value: float) -> str:
        """Why the contact has no result at a value; "" if it has one, or if the value is NaN."""
        _, reason = self.tried.get(value, ("", ""))
        if not reason:
            return ""
        return f"{self.name} {value:.4g}: no result, so rest is possible there: {reason}"

    def _rests(self, value: float) -> bool:
        outcome, reason = self._outcome_at(value)
        self.tried[value] = outcome, reason
        if outcome == REST:
            self.rests_at = value
        best = f"rest at {self.name} {self.rests_at:.4g} so far"
        note = f"{best}; the attribute `table` has {number_of(len(self.tried), self.name)}"
        self._bar.keep("table", self.table, note, best)
        return outcome == REST


@dataclass(frozen=True, eq=False, repr=False)
class AfterProtocol(Kept, Plotted):
    """Load factors or frictions that are tried after a protocol, with their outcomes."""

    tried: pd.DataFrame = field(repr=False)
    transients: int
    residual: float
    note: str
    monotonic: bool

    def to_frame(self) -> pd.DataFrame:
        """The values tried, see `tried`."""
        return self.tried.copy()

    def _answer(self) -> Mapping[str, object]:
        answer = dict(super()._answer())
        if self.note:
            answer["note"] = self.note
        return answer


@dataclass(frozen=True, eq=False, repr=False)
class LimitAfterProtocol(AfterProtocol):
    """The load factor up to which a contact comes to rest after a protocol, by transients.

    Attributes
    ----------
    load_factor, upper
        `load_factor` is the largest load factor tried up to which the contact always comes to rest.
        `upper` is the least load factor tried at which it does not, or at which a transient has no
        result, see `note`; inf if it comes to rest at all load factors tried.
    shakedown_limit
        lambda_2 of the given limit, which no protocol exceeds while all nodes stay closed.
    starts
        (S, N), in space (S, N, 2), the starts, length. If slip continues at `upper`, it continues
        from the first of these starts.
    tried
        DataFrame, one row for each load factor tried: load_factor; ratio, the load factor divided
        by lambda_2; outcome, which is "rest", "slip", or "UNDECIDED" if a transient has no result.
    transients, residual
        Number of transients followed, and largest residual of their steady states, at most 1e-9.
    note
        Why the transient at `upper` has no result, for example because the protocol makes a body
        slide off; "" if it keeps slipping.
    monotonic
        Whether the contact comes to rest at no load factor tried above `upper`.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> after = fo.limit_after_protocol(fo.shakedown_limit(rod, cycle, friction=0.5))
    >>> round(after.ratio, 3), after.monotonic
    (1.0, True)
    """

    _shown_names = ("load_factor", "ratio", "upper", "monotonic", "transients", "residual")
    load_factor: float
    upper: float
    shakedown_limit: float
    starts: Array = field(repr=False)

    @property
    def ratio(self) -> float:
        """The load factor divided by lambda_2."""
        return self.load_factor / self.shakedown_limit if self.shakedown_limit > 0 else np.nan


@warns_of_odd_values
def limit_after_protocol(
    limit: ShakedownLimit,
    *,
    protocol: Sequence[LoadStep] = (),
    start: str | ArrayLike = "assembled",
    up_to: float | None = None,
    scan: int | ArrayLike = 25,
    tolerance: float = 1e-4,
    steps: int | None = None,
    progress: bool = True,
) -> LimitAfterProtocol:
    """Find the load factor up to which a contact comes to rest after its assembly and a protocol.

    Transients are followed at evenly spaced load factors. A bisection narrows the interval below
    the first load factor at which slip continues. Between the load factors tried the outcome is not
    known.

    Parameters
    ----------
    limit
        Result of `shakedown_limit`, with the contact, its load cycle and its friction.
    protocol
        Loads between the start, which is at the mean load, and the cycle. After them, the load
        returns to the mean load.
    start
        "assembled": the contact begins without slip, and the mean load grows from a millionth of
        itself. "worst": all extreme slips that the contact can hold under the mean load; the first
        start that keeps slipping decides. Or a residual slip, (N,) or in space (N, 2), length.
    up_to
        Largest load factor tried; None: the load factor of `limit`.
    scan
        Number of load factors tried before the bisection; or these load factors as shares of
        `up_to`, rising, above 0, and up to 1, such as [the guaranteed limit divided by the
        shakedown limit, 1].
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

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> unload = [fo.starts.LoadStep({"P": 0.2})]
    >>> ways = {"start": "worst"}, {"start": "worst", "protocol": unload}, {"start": "assembled"}
    >>> limit = fo.shakedown_limit(pair, cycle, friction=0.6)
    >>> [round(fo.limit_after_protocol(limit, **way).ratio, 2) for way in ways]
    [0.54, 0.85, 1.0]
    """
    if not isinstance(limit, ShakedownLimit):
        raise ModelError(f"limit: {shown(limit)}; give the answer of `shakedown_limit`")
    loads = listed_parts("protocol", protocol, LoadStep)
    shares = _checked_scan(scan)
    tolerance = finite_number("tolerance", tolerance, above=0.0, below=1.0)
    asked = limit.system, limit.cycle, limit.friction
    with progress_bar(progress, "limit after a protocol", "transient") as bar:
        transients = TransientsAfter(*asked, loads, start, steps, bar.update)
        search = Search("load factor", bar, transients.outcome_of_starts, rests_at=0.0)
        if up_to is None and not 0 < limit.load_factor < np.inf:
            raise ModelError(
                f"up_to: None, and the shakedown limit is {limit.load_factor:g}; give the largest "
                "load factor to try"
            )
        largest = limit.load_factor if up_to is None else finite_number("up_to", up_to, above=0.0)
        grid = largest * shares
        first = search.first_slip(grid, tolerance * largest)
        # Load factors above the limit may bring other starts to the front.
        starts = frozen(transients.starts)
        monotonic = search.others_slip(grid)
    answer = search.table()
    answer.insert(1, "ratio", answer["load_factor"] / limit.load_factor)
    return LimitAfterProtocol(
        answer,
        bar.count,
        transients.residual,
        search.note(first),
        monotonic,
        load_factor=search.rests_at,
        upper=np.inf if np.isnan(first) else first,
        shakedown_limit=limit.load_factor,
        starts=starts,
    )


@dataclass(frozen=True, eq=False, repr=False)
class FrictionAfterProtocol(AfterProtocol):
    """The friction that a contact needs to come to rest after a protocol, by transients.

    Attributes
    ----------
    required, lower
        The contact comes to rest with the coefficient of friction `required`, and with all larger
        frictions tried; inf if it does not come to rest with the largest friction. `lower` is the
        largest friction tried with which it does not, or with which a transient has no result, see
        `note`. If the contact comes to rest with all frictions tried, `lower` is the `bound` of
        `required_friction`.
    least
        Result `required` of `required_friction`. With less friction, the contact comes to rest from
        no start while all nodes stay closed.
    load_factor
        The given load factor.
    tried
        DataFrame, one row for each friction tried: friction; outcome, see `LimitAfterProtocol`.
    transients, residual, note
        See `LimitAfterProtocol`.
    monotonic
        Whether the contact comes to rest with no friction tried below `lower`.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> required = fo.required_friction(rod, cycle, load_factor=1.0)
    >>> friction = fo.friction_after_protocol(required, scan=3)
    >>> round(friction.required, 3), friction.monotonic
    (1.0, True)
    """

    _shown_names = ("required", "lower", "least", "monotonic", "transients", "residual")
    required: float
    lower: float
    least: float
    load_factor: float


@warns_of_odd_values
def friction_after_protocol(
    required: RequiredFriction,
    *,
    protocol: Sequence[LoadStep] = (),
    start: str | ArrayLike = "assembled",
    up_to: float | None = None,
    scan: int | ArrayLike = 25,
    tolerance: float = 1e-4,
    steps: int | None = None,
    progress: bool = True,
) -> FrictionAfterProtocol:
    """Find the friction that a contact needs to come to rest after its assembly and a protocol.

    Transients are followed with evenly spaced frictions, from the largest one down to the answer of
    `required_friction`. A bisection narrows the interval above the first friction with which slip
    continues. More friction need not help: between the frictions tried the outcome is not known.

    Parameters
    ----------
    required
        Result of `required_friction`, with the contact, its load cycle and the load factor.
    protocol, start, steps, progress
        See `limit_after_protocol`. The interrupt has the frictions tried so far.
    up_to
        Largest friction tried; None: 1, or twice the required friction if this is more.
    scan
        Number of frictions tried between the required one and `up_to`; or these frictions as shares
        of the way to `up_to`, rising, above 0, and up to 1. The required friction is tried, too.
    tolerance
        Width of the last interval of the bisection, divided by `up_to`.

    Returns
    -------
    FrictionAfterProtocol
        The coefficient of friction, one for all nodes, and all frictions tried.

    Raises
    ------
    ModelError
        Bad input, or a required friction that is not below `up_to`.

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> required = fo.required_friction(pair, cycle, load_factor=0.3)
    >>> round(fo.friction_after_protocol(required).required, 2)
    0.24

    More friction also holds worse slips, so from the worst start no friction tried is enough:

    >>> worst = fo.friction_after_protocol(required, start="worst", scan=5)
    >>> worst.required, worst.monotonic
    (inf, False)
    """
    if not isinstance(required, RequiredFriction):
        raise ModelError(f"required: {shown(required)}; give the answer of `required_friction`")
    loads = listed_parts("protocol", protocol, LoadStep)
    shares = _checked_scan(scan)
    tolerance = finite_number("tolerance", tolerance, above=0.0, below=1.0)
    asked = required.system, required.cycle
    residuals = [0.0]

    def outcome_at(friction: float) -> tuple[str, str]:
        transients = TransientsAfter(*asked, friction, loads, start, steps, bar.update)
        outcome = transients.outcome_of_starts(required.load_factor)
        residuals.append(transients.residual)
        return outcome

    with progress_bar(progress, "friction after a protocol", "transient") as bar:
        search = Search("friction", bar, outcome_at, rests_at=np.inf)
        least = required.required
        largest = max(1.0, 2 * least) if up_to is None else finite_number("up_to", up_to, above=0.0)
        if not least < largest < np.inf:
            raise ModelError(
                f"up_to: {shown(up_to)}, and the required friction is {least:g}; give more friction"
            )
        grid = least + (largest - least) * np.r_[shares[::-1], 0.0]
        first = search.first_slip(grid, tolerance * largest)
        monotonic = search.others_slip(grid)
    return FrictionAfterProtocol(
        search.table(),
        bar.count,
        max(residuals),
        search.note(first),
        monotonic,
        required=search.rests_at,
        lower=required.bound if np.isnan(first) else first,
        least=least,
        load_factor=required.load_factor,
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
