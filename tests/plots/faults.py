"""Planted faults of `plots`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "plots/style.py",
        "spare panels stay among those whose labels are in a line",
        old="for spare in grid.flat[panels:]:\n    spare.remove()",
        new="figure.align_ylabels()\nfor spare in grid.flat[panels:]:\n    spare.remove()",
        tests="plots_of_states",
    ),
    Fault(
        "plots/style.py",
        "a notebook shows its first picture only",
        old="plt.draw_if_interactive()",
        new="()",
        tests="notebook",
    ),
    Fault(
        "plots/style.py",
        "a name is markup",
        old="str(name).replace('$', r'\\$')",
        new="str(name)",
        tests="plots_names",
    ),
)
