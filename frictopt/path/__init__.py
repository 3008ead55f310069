"""The exact path of a transient: rate problem, events, return map and steady state."""

from .exact import ExactPath
from .steady import Outcome, SteadyState, steady_state

__all__ = ["ExactPath", "Outcome", "SteadyState", "steady_state"]
