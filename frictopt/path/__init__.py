"""The exact path of a transient: rate problem, events, return map and steady state."""

from ..contact.answers import Outcome
from .derivative import ReturnMap, return_map
from .outcome import SteadyState
from .steady import steady_state
from .transient import ExactPath

__all__ = ["ExactPath", "Outcome", "ReturnMap", "SteadyState", "return_map", "steady_state"]
