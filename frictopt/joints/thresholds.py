"""Thresholds of the user, the values compared with them, and the load that reaches a threshold."""

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
    """A value that has a threshold, its place in words, and the value to compare with it.

    The value to compare is the value plus an estimate of its error, if there is an estimate.
    """

    value: float
    where: str
    judged: float


@dataclass(frozen=True)
class Quantity:
    """A quantity of a steady state that has a threshold.

    `unit` names its unit in forces and lengths, see `units_of`. `found` returns its value and its
    place in words. Quantities `of_work` have an estimate of the error of increments.
    """

    unit: str
    found: Callable[[SteadyState], tuple[float, str]]
    needs_width: bool = False
    of_work: bool = False

    def judged(self, steady: SteadyState) -> Judged:
        """The value in a steady state; the value to compare includes its estimated error."""
        value, where = self.found(steady)
        error = steady.step_error if self.of_work and steady.steps else 0.0
        # At rest, an infinite error means that the contact may slip in finer increments.
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
    # The first of the four digits is the first digit of the size.
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
"""Name of a threshold -> its quantity. Thresholds of gross slip and face slip have none."""

# The load factor at which a quantity of the steady state reaches a threshold.

# Numbers of the search.

# Width of the last bracket divided by its upper end, in the plane and in space, where steady
# states in increments are less exact.
TOLERANCE = (1e-4, 1e-2)
# Factor by which the load factor grows until its value exceeds the threshold.
_GROWTH = 2.0
# Largest load factor tried; a threshold that is kept there counts as not reached.
LARGEST_LOAD = 16.0
# The search, and the curve of a report, end at this share of the sliding-off load. Closer to this
# load the slip needs many cycles to become steady.
BELOW_GROSS_SLIP = 0.95
# Every third trial halves the bracket, because interpolation fails at jumps.
_HALVED = 3
# The search ends below this load factor: the threshold is then exceeded at nearly no load.
_SMALLEST_LOAD = 1e-3
# Share of the tolerance by which a trial goes beyond the interpolated load factor, so that two
# trials enclose it.
_BEYOND = 0.4


def load_at_threshold(
    value_at: Callable[[float], float],
    values_known: Mapping[float, float],
    threshold: float,
    end: float,
    tolerance: float,
    smallest_load: float = _SMALLEST_LOAD,
) -> tuple[float, float]:
    """Search the least load factor up to `end` at which a value exceeds a threshold.

    `value_at` returns the value at a load factor, inf if there is no steady state. `values_known`
    are values that are known already. The result is a load factor that keeps the threshold, and a
    larger one that exceeds it, or inf if none does. Load factors grow until one exceeds the
    threshold; then interpolation and halving narrow the bracket to the tolerance.
    """
    known = {factor: value for factor, value in values_known.items() if factor <= end}
    trials = 0
    shift = -_BEYOND * tolerance
    while True:
        low, high = _bracket(known, threshold)
        if high == np.inf:
            if low >= end:
                return low, high
            trial = min(max(1.0, _GROWTH * low), end)
        else:
            if high <= smallest_load or high - low <= tolerance * high:
                return low, high
            trials += 1
            trial = (low + high) / 2
            values = known.get(low, 0.0), known[high]
            if trials % _HALVED and np.isfinite(values).all() and values[0] < values[1]:
                share = (threshold - values[0]) / (values[1] - values[0])
                guess = (low + share * (high - low)) * (1 + shift)
                if low < guess < high:
                    trial = guess
        known[trial] = value_at(trial)
        shift = abs(shift) if known[trial] <= threshold else -abs(shift)


def _bracket(known: Mapping[float, float], threshold: float) -> tuple[float, float]:
    """The two known load factors between which values begin to exceed a threshold.

    The upper load factor is the least whose value exceeds the threshold; inf if no value does. The
    lower load factor is the largest below the upper one whose value does not exceed it; 0 if there
    is none.
    """
    keep = [factor for factor, value in known.items() if value <= threshold]
    high = min(known.keys() - keep, default=np.inf)
    return max((factor for factor in keep if factor < high), default=0.0), high


def first_state_that_reaches(
    wanted: float,
    name: str,
    below: SteadyState,
    reaches: SteadyState,
    follow: Callable[[float], SteadyState],
) -> SteadyState:
    """The steady state at the least load factor found at which its `name` is at least `wanted`.

    `name` is a numeric attribute of a steady state. The value of this attribute is at most `wanted`
    in the state `below`, and at least `wanted` in the state `reaches` at a larger load factor.
    `follow` returns the state at a load factor.
    """
    states = {state.load_factor: state for state in (below, reaches)}

    def value_at(factor: float) -> float:
        states[factor] = follow(factor)
        return float(getattr(states[factor], name))

    _, above = load_at_threshold(
        value_at,
        {factor: float(getattr(state, name)) for factor, state in states.items()},
        np.nextafter(wanted, 0.0),  # a state with just this number has reached it
        reaches.load_factor,
        TOLERANCE[reaches.system.tangents - 1],
        smallest_load=0.0,  # however small the load factors are
    )
    return states[above]
