"""Planted faults of `scenes`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "scenes/punch.py",
        "one side of the block is pressed while the other is pulled",
        old="Traction('block', 'right', x=1.0)",
        new="Traction('block', 'right', x=-1.0)",
        tests="punch scenes",
    ),
    Fault(
        "scenes/punch.py",
        "the top pulls",
        old="{up: -1.0}",
        new="{up: 1.0}",
        tests="models_in_space spatial_limits",
    ),
)
