"""The discrete contact: system, load cycle, state, Coulomb's law with its referee, onset. What other rooms ask for by name of it stands here."""

from .coulomb import Verdict, friction_coefficients, referee
from .coulomb import lengths as lengths
from .coulomb import off_law as off_law
from .cycle import LoadCycle
from .cycle import checked_cycle as checked_cycle
from .diagnosis import unscaled_diagnosis as unscaled_diagnosis
from .onset import Onset, OnsetEvent
from .parts import joined as joined
from .parts import parted as parted
from .result import Attempt, LimitKind, Outcome, SolveRecord
from .result import Plotted as Plotted
from .result import Recorded as Recorded
from .result import Shown as Shown
from .result import Table as Table
from .result import bar_of as bar_of
from .result import components as components
from .result import frame as frame
from .result import places as places
from .state import ContactState
from .system import ContactSystem
from .system import checked_plane as checked_plane
from .system import checked_system as checked_system
from .system import reactions as reactions

__all__ = [
    "Attempt",
    "ContactState",
    "ContactSystem",
    "LimitKind",
    "LoadCycle",
    "Onset",
    "OnsetEvent",
    "Outcome",
    "SolveRecord",
    "Verdict",
    "friction_coefficients",
    "referee",
]
