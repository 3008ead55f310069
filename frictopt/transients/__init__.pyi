from . import exact as exact
from . import increments as increments
from .march import march
from .outcome import SteadyState
from .steady import steady_state
from .trajectory import Trajectory

__all__ = ["SteadyState", "Trajectory", "exact", "increments", "march", "steady_state"]
