"""The exact path of a transient: rate problem, events, return map and steady state."""

from .exact import ExactPath
from .outcome import Outcome, SteadyState
from .steady import steady_state

__all__ = ["ExactPath", "Outcome", "SteadyState", "steady_state"]
