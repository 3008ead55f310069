from . import exact as exact
from . import increments as increments
from .march import march
from .onset import Onset, OnsetEvent, onset
from .outcome import SteadyState
from .steady import steady_state
from .trajectory import LoadLoop, Trajectory

__all__ = [
    "LoadLoop",
    "Onset",
    "OnsetEvent",
    "SteadyState",
    "Trajectory",
    "exact",
    "increments",
    "march",
    "onset",
    "steady_state",
]
