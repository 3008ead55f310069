"""The discrete contact: system, load cycle, state, Coulomb's law with its referee, onset."""

from .coulomb import Verdict, friction_coefficients, referee
from .cycle import LoadCycle
from .onset import Onset, OnsetEvent
from .result import Attempt, SolveRecord
from .state import ContactState
from .system import ContactSystem

__all__ = [
    "Attempt",
    "ContactState",
    "ContactSystem",
    "LoadCycle",
    "Onset",
    "OnsetEvent",
    "SolveRecord",
    "Verdict",
    "friction_coefficients",
    "referee",
]
