"""The discrete contact: system, load cycle, state, Coulomb's law with its referee, onset. What other rooms ask for by name of it stands here."""

from .coulomb import Verdict, friction_coefficients, lengths, off_law, referee
from .cycle import LoadCycle, checked_cycle
from .diagnosis import unscaled_diagnosis
from .onset import Onset, OnsetEvent
from .parts import joined, parted
from .result import Attempt, LimitKind, Outcome, Plotted, Recorded, Shown, SolveRecord, Table, bar_of, components, frame, places
from .state import ContactState
from .system import ContactSystem, checked_plane, checked_system, reactions

__all__ = [
    "Attempt",
    "ContactState",
    "ContactSystem",
    "LimitKind",
    "LoadCycle",
    "Onset",
    "OnsetEvent",
    "Outcome",
    "Plotted",
    "Recorded",
    "Shown",
    "SolveRecord",
    "Table",
    "Verdict",
    "bar_of",
    "checked_cycle",
    "checked_plane",
    "checked_system",
    "components",
    "frame",
    "friction_coefficients",
    "joined",
    "lengths",
    "off_law",
    "parted",
    "places",
    "reactions",
    "referee",
    "unscaled_diagnosis",
]
