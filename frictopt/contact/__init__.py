"""The discrete contact: system, load cycle, Coulomb's law with its referee, onset from the bonded state."""

from .coulomb import Verdict, friction_coefficients, referee
from .cycle import LoadCycle
from .onset import Onset, OnsetEvent, onset
from .record import Attempt, SolveRecord
from .system import ContactSystem

__all__ = ["Attempt", "ContactSystem", "LoadCycle", "Onset", "OnsetEvent", "SolveRecord", "Verdict", "friction_coefficients", "onset", "referee"]
