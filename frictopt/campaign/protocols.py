"""The load factor up to which a contact comes to rest, for how it is assembled and what is done to it before."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_number, frozen, whole_number
from ..contact.show import Plotted, Shown
from ..errors import ModelError
from .treatment import REST, LoadStep, Treatment, checked_protocol

__all__ = ["LimitAfterProtocol", "limit_after_protocol"]


@dataclass(frozen=True, eq=False, repr=False)
class LimitAfterProtocol(Shown, Plotted):
    """The load factor up to which a contact comes to rest after a protocol, found by transients.

    Attributes
    ----------
    load_factor
        Largest load factor below which the contact comes to rest wherever it was tried.
    upper
        Least load factor tried at which it does not; inf if there is none up to the largest one tried.
    shakedown_limit
        lambda_2, which no protocol exceeds while all nodes stay closed.
    monotonic
        Whether it comes to rest at no load factor tried above `upper`.
    starts
        (S, N) the starts, length; slip goes on from the first one at `upper`.
    tried
        DataFrame, one row for each load factor tried: load_factor; ratio, it over lambda_2; outcome, "rest", "slip" or "UNDECIDED" where a transient
        has no result.
    transients
        Number of transients followed.
    residual
        Largest residual of their steady states. At most 1e-9.

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> worst = fo.limit_after_protocol(pair, cycle, friction=0.6, start="worst")
    >>> round(worst.ratio, 3), worst.monotonic
    (0.54, True)
    """

    load_factor: float
    upper: float
    shakedown_limit: float
    monotonic: bool
    starts: Array = field(repr=False)
    tried: pd.DataFrame = field(repr=False)
    transients: int
    residual: float

    @property
    def ratio(self) -> float:
        """The load factor over lambda_2."""
        return self.load_factor / self.shakedown_limit if self.shakedown_limit > 0 else np.nan

    def to_frame(self) -> pd.DataFrame:
        """The load factors tried, see `tried`."""
        return self.tried.copy()

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("load_factor", "ratio", "upper", "monotonic", "transients", "residual")}


def limit_after_protocol(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Any,
    *,
    protocol: Sequence[LoadStep] = (),
    start: Any = "assembled",
    most: float | None = None,
    scan: int = 25,
    tolerance: float = 1e-4,
) -> LimitAfterProtocol:
    """Find the load factor up to which a contact comes to rest, for how it is assembled and what is done to it before its load cycle.

    Transients are followed at evenly spaced load factors, and a bisection narrows the interval below the first one at which slip goes on. What
    happens between the load factors tried is not known.

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    friction
        Coefficient of friction, one or one per node.
    protocol
        Loads that are visited after the start, at the mean load, and before the cycle; the load returns to the mean load in the end.
    start
        "assembled": the mean load grows from a millionth of itself, without slip. "worst": from each extreme slip that the contact can hold under the
        mean load, of which the first that keeps slipping decides. Or an (N,) residual slip of your own, length.
    most
        Largest load factor tried; None: the shakedown limit.
    scan
        Number of load factors tried before the bisection.
    tolerance
        Width of the last interval, over the largest load factor tried.

    Raises
    ------
    ModelError
        Bad input, or a shakedown limit that is not finite and above 0, and no `most`.
    SolverError
        The shakedown limit is not found.

    Examples
    --------
    >>> import frictopt as fo
    >>> A, B = [[1.0, -0.4], [-0.4, 1.0]], [[-0.1, -0.7], [0.7, 0.1]]
    >>> bonded = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.8, 0.8], [0.4, 0.1])}
    >>> pair = fo.ContactSystem.from_blocks(A, B, [[2.0, 0.0], [0.0, 2.0]], [0.0, 1.0], bonded)
    >>> cycle = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> assembled = fo.limit_after_protocol(pair, cycle, friction=0.6)
    >>> worst = fo.limit_after_protocol(pair, cycle, friction=0.6, start="worst")
    >>> unloaded = fo.limit_after_protocol(pair, cycle, friction=0.6, start="worst", protocol=[fo.LoadStep({"P": 0.2})])
    >>> [round(found.ratio, 2) for found in (worst, unloaded, assembled)]
    [0.54, 0.85, 1.0]
    """
    steps = checked_protocol(protocol)
    treatment = Treatment(system, cycle, friction, start)
    scan, tolerance = whole_number("scan", scan, least=1), finite_number("tolerance", tolerance, above=0.0, below=1.0)
    if most is None and not 0 < treatment.limit < np.inf:
        raise ModelError(f"most: None, and the shakedown limit is {treatment.limit:g}; give the largest load factor to try")
    most = treatment.limit if most is None else finite_number("most", most, above=0.0)
    tried = {float(factor): treatment.rests(float(factor), steps) for factor in most * np.arange(1, scan + 1) / scan}
    high = next((factor for factor, outcome in tried.items() if outcome != REST), np.inf)
    low = max((factor for factor in tried if factor < high), default=0.0)
    while high - low > tolerance * most and np.isfinite(high):
        middle = (low + high) / 2
        tried[middle] = treatment.rests(middle, steps)
        low, high = (middle, high) if tried[middle] == REST else (low, middle)
    factors = sorted(tried)
    columns = {"load_factor": factors, "ratio": np.array(factors) / treatment.limit, "outcome": [tried[factor] for factor in factors]}
    return LimitAfterProtocol(
        load_factor=low,
        upper=high,
        shakedown_limit=treatment.limit,
        monotonic=not any(outcome == REST for factor, outcome in tried.items() if factor > high),
        starts=frozen(treatment.starts),
        tried=pd.DataFrame(columns),
        transients=treatment.transients,
        residual=treatment.residual,
    )
