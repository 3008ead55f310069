"""Thresholds that the user gives, and the values that are compared with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..base import finite_number, place, shown
from ..base.checks import checked_cases
from ..contact import ContactSystem
from ..contact.diagnosis import in_deck
from ..errors import ModelError
from ..transients import SteadyState

GROSS_SLIP = "gross slip"
FACE_SLIP = "face slip"
SLIP_RANGE = "slip range"
SLIPPING_SHARE = "slipping share"


@dataclass(frozen=True)
class Judged:
    """A value with a threshold, its place in words, and the value to compare with the threshold.

    The value to compare is larger than the value by an estimate of its error, if there is one.
    """

    value: float
    where: str
    judged: float


@dataclass(frozen=True)
class Quantity:
    """A quantity of a steady state that has a threshold.

    `unit` names its unit in forces and lengths, see `units_of`. `found` returns its value and its
    place in words. The error of increments is estimated for quantities `of_work`.
    """

    unit: str
    found: Callable[[SteadyState], tuple[float, str]]
    needs_width: bool = False
    of_work: bool = False

    def judged(self, steady: SteadyState) -> Judged:
        """The value in a steady state; the value to compare includes its estimated error."""
        value, where = self.found(steady)
        error = steady.step_error if self.of_work and steady.steps else 0.0
        # At rest, an infinite error says that finer increments may slip.
        return Judged(value, where, np.inf if np.isinf(error) else value * (1 + error))


def checked_limits(system: ContactSystem, limits: object) -> dict[str, float]:
    """Check thresholds, name of a quantity -> number of at least 0."""
    if limits is None:
        return {}
    names = [GROSS_SLIP, FACE_SLIP, *QUANTITIES]
    thresholds = dict[str, float]()
    for name, value in checked_cases("limits", limits, "threshold").items():
        if name not in names:
            raise ModelError(f"limits: {shown(name)} is not a quantity; give some of {names}")
        threshold = finite_number(f"limits[{name!r}]", value, least=0.0)
        if name == SLIPPING_SHARE and threshold > 1:
            raise ModelError(
                f"limits[{name!r}]: {threshold:g}; it is a share of the contacts; give at most 1"
            )
        if name in QUANTITIES and QUANTITIES[name].needs_width and system.width is None:
            raise ModelError(
                f"limits[{name!r}]: the system has no width of its nodes, so it has no tractions; "
                "give the system a width, or leave this threshold out"
            )
        thresholds[name] = threshold
    return thresholds


def _at_node(steady: SteadyState, column: str) -> tuple[float, str]:
    """The largest value of a column of the fretting table, and its place."""
    values = np.asarray(steady.fretting_table()[column], dtype=float)
    node = int(np.argmax(values))
    where = place_of_node(steady.system, node)
    if steady.system.contact is not None:
        where = f"{steady.system.contact[node]}, {where}"
    return float(values[node]), where


def place_of_node(system: ContactSystem, node: int) -> str:
    """The number and the place of a node, to four digits of the size of the contact."""
    number = in_deck(system, node)
    size = float(np.ptp(system.points, axis=0).max()) or 1.0
    # The size has one digit itself.
    digits = 3 - int(np.floor(np.log10(size)))
    at = place(np.round(system.points[node], digits) + 0.0)  # adding 0 turns -0 into 0
    return f"node {node}{f' ({number})' if number else ''} at {at}"


def _contact_of_most(steady: SteadyState, column: str) -> str:
    """The contact with the largest value of a column; "" if there is one contact or no value."""
    table = steady.by_contact()
    if len(table) == 1 or not table[column].any():
        return ""
    contact = table.loc[table[column].idxmax(), "contact"]
    return f"most in {contact}"


QUANTITIES: Mapping[str, Quantity] = {
    SLIP_RANGE: Quantity("slip_range", lambda steady: _at_node(steady, "slip_range")),
    "work": Quantity(
        "work",
        lambda steady: (steady.dissipation, _contact_of_most(steady, "work")),
        of_work=True,
    ),
    "work density": Quantity(
        "work_density",
        lambda steady: _at_node(steady, "work_density"),
        needs_width=True,
        of_work=True,
    ),
    "Ruiz": Quantity("Ruiz", lambda steady: _at_node(steady, "F1"), needs_width=True),
    SLIPPING_SHARE: Quantity(
        "share", lambda steady: (steady.slipping_share, _contact_of_most(steady, "slipping"))
    ),
    "drift": Quantity("drift", lambda steady: (steady.drift, "")),
}
"""Name of a threshold -> its quantity. `gross slip` is the least safety factor against it."""
