"""Planted faults of `studies`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "validation/lower_bound.py",
        "sign of the derived bounds",
        old="-ends",
        new="ends",
        tests="guaranteed_lower",
    ),
)
