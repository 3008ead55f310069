"""The discrete contact: system, load cycle, state, Coulomb's law with its referee. Other rooms ask for what is in it here, by name."""

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
from .coulomb import ContactState, Verdict, friction_coefficients, lengths, most_shear, off_law, referee
from .cycle import LoadCycle, checked_cycle
from .parts import checked_springs, compliances, joined, parted, runs
from .progress import Bar, bar_of
from .result import Attempt, Kept, LimitKind, Outcome, Plotted, Recorded, Shown, SolveRecord, Table, components, frame, places
from .system import ContactSystem, checked_plane, checked_round, checked_system, checked_uncapped, checked_width, reactions
from .tolerances import *
