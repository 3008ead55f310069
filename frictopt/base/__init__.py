"""What every room needs and no contact knows.

`checks.py` checks input and words its errors, `tolerances.py` has the numbers that several files
share, `progress.py` shows how far long work is and what an interrupt keeps, `results.py` has the
bases of results: how they are printed, plotted and pickled. `files.py` reads and writes npz
archives, `archive.py` keeps results in them, and `kinds.py` is the list in which classes register
themselves to be kept.
"""

from .checks import (
    LARGEST_SEED,
    Array,
    Booleans,
    Integers,
    check_entries,
    check_text,
    checked_cases,
    checked_contact,
    checked_loads,
    choice,
    finite_array,
    finite_number,
    finite_numbers,
    first_of,
    flag,
    for_each,
    frozen,
    listed,
    place,
    real_array,
    shown,
    warns_of_odd_values,
    whole,
    whole_array,
    whole_number,
)
from .kinds import kept
from .progress import Bar, bar_of
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
    places,
)
from .tolerances import *
