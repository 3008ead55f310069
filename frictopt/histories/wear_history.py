"""What a contact goes through while it wears."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import pandas as pd

from ..contact import Array, ContactState, ContactSystem, Plotted, Recorded, SolveRecord, frozen
from ..transients import SteadyState

WORN_IN = 1e-3
"""Work of friction per cycle, over its largest, from which on a contact counts as worn in."""


class Worn(Recorded, Plotted):
    """Base of results that have a worn contact in a steady state."""

    steady: SteadyState

    @property
    def system(self) -> ContactSystem:
        """The contact as it is worn in the end."""
        return self.steady.system

    @property
    def state(self) -> ContactState:
        """Its state at the last corner of the steady cycle, from which wear or another transient may go on."""
        return self.steady.state


@dataclass(frozen=True, eq=False, repr=False)
class WearHistory(Worn):
    """A contact while it wears: its steady states before the first jump of cycles and after each one.

    Theory, eq. (29).

    Attributes
    ----------
    steady
        The last steady state. Its contact is worn, and takes every other question. Its `step_error` is inf in space where an error ended the history.
    depth
        (J + 1, N) depth worn off at each node since the beginning, of both bodies together, length.
    pressure
        (J + 1, N) normal force over width at the last corner of the steady cycle.
    reason
        Why the history ends, in words.
    record
        How it was found. Its `residual` is the largest of all steady states.

    Examples
    --------
    >>> import frictopt as fo
    >>> arrays = fo.reference.half_plane_contact(nodes=32, half_length=1.0, E_star=1e5, R=100.0)  # a cylinder; N and mm
    >>> cylinder = fo.ContactSystem.from_blocks(**arrays, width=[2 / 32] * 32)
    >>> cycle = fo.LoadCycle({"P": 400.0}, [{"Q": 1.0}, {"Q": -1.0}])
    >>> history = fo.wear(cylinder, cycle, friction=0.5, load_factor=100.0, coefficient=1e-8, cycles=1e5)
    >>> history.reason, f"{history.volume:.2e}"
    ('100000 cycles are over', '3.14e-05')
    >>> history.to_frame()[["slipping", "stick_width", "outcome"]].tail(1)
        slipping  stick_width      outcome
    10         8          1.0  CYCLIC_SLIP
    """

    steady: SteadyState = field(repr=False)
    depth: Array
    pressure: Array
    reason: str
    record: SolveRecord
    _table: pd.DataFrame

    @property
    def cycles(self) -> Array:
        """(J + 1,) number of load cycles before the first jump, 0, and after each one; jumps do not end at whole cycles."""
        return frozen(self._table["cycles"])

    @property
    def volume(self) -> float:
        """Volume worn off in the end (per depth in the plane)."""
        return float(self._table["volume"].iloc[-1])

    @property
    def worn_in(self) -> bool:
        """Whether the contact is worn in: it slips no more, or its work of friction per cycle is a thousandth of the largest."""
        return bool(self._table["work"].iloc[-1] <= WORN_IN * self._table["work"].max())

    def to_frame(self) -> pd.DataFrame:
        """One row for the unworn contact and one after each jump.

        Columns: cycles; work, of friction per cycle; largest_depth and volume worn off so far; slipping, number of nodes that slip; stick_width,
        length (area in space) of those that neither slip nor open; outcome, the name of an `Outcome`.
        """
        return self._table.copy()

    def _answer(self) -> Mapping[str, object]:
        numbers = {name: float(self._table[name].iloc[-1]) for name in ("cycles", "work", "largest_depth", "volume")}
        return {"jumps": len(self._table) - 1, **numbers, "reason": self.reason}
