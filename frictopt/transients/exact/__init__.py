"""The exact path of a transient in the plane.

`path.py` goes from corner to corner. `kernel.py`, which `compilation.py` compiles, goes from event
to event. `rate.py` solves the rate problems that the kernel does not decide, and `derivative.py`
has the derivative of a cycle.
"""

from .derivative import ReturnMap, return_map
from .path import ExactPath

__all__ = ["ExactPath", "ReturnMap", "return_map"]
