"""The exact path of a transient in the plane: one compiled kernel, rate problem, events, return map."""

from .derivative import ReturnMap, return_map
from .path import ExactPath

__all__ = ["ExactPath", "ReturnMap", "return_map"]
