"""Tools for the whole package, independent of contact mechanics.

`checks.py`
    Checks of input, with their error messages.
`tolerances.py`
    The numbers that several files share.
`unresisted.py`
    Motions that a stiffness does not resist, and its inverse on all other motions.
`progress.py`
    Progress of long computations, and the partial result that an interrupt keeps.
`results.py`
    Bases of results: how they are printed, plotted and pickled.
`files.py`, `archive.py`
    npz archives and strict JSON, the results that they keep, and libraries that read other files.
`entries.py`
    Files in TOML, whose tables are the arguments of classes and functions.
"""

from .checks import (
    LARGEST_SEED,
    Array,
    Booleans,
    Integers,
    Loads,
    PerNode,
    check_entries,
    check_text,
    checked_cases,
    checked_contact,
    checked_loads,
    choice,
    distribution,
    finite_array,
    finite_number,
    finite_numbers,
    first_of,
    flag,
    for_each,
    frozen,
    is_distribution,
    listed,
    number_of,
    place,
    real_array,
    runs,
    shown,
    warns_of_odd_values,
    whole,
    whole_array,
    whole_number,
)
from .files import kept
from .progress import Bar, OutOfTime, progress_bar
from .results import (
    Attempt,
    Kept,
    LimitKind,
    Outcome,
    Plotted,
    Recorded,
    Shown,
    SolveRecord,
    Table,
    components,
    frame,
    make_read_only,
    places,
    worst,
)
from .tolerances import *
from .unresisted import free_motions, unresisted
