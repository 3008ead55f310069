"""Transients and campaigns of them, as tables."""

from .march import march
from .trajectory import Trajectory

__all__ = ["Trajectory", "march"]
