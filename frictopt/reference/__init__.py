"""Closed-form solutions of frictional contact: pure functions with citation and units, the yardstick of the numerical parts of the package.

Limits of a load that swings between two corners: bonded reactions `r0 + lam * s * r1` with `s = -1, +1`, tangential parts `q0, q1` along +x,
normal parts `p0, p1` positive in compression. A limit is finite, inf (no load factor is too large) or nan (nothing is safe, not even `lam = 0`).
"""

from .bonded_corner import CornerMode, bonded_corner
from .bounds import gross_slip_bound, patch_limit
from .single_node import single_node_limit
from .sliding_corner import sliding_corner_exponent
from .two_nodes import TwoNodeLimits, two_node_limits
from .uncoupled import bonded_onset, uncoupled_limit

__all__ = [
    "CornerMode",
    "TwoNodeLimits",
    "bonded_corner",
    "bonded_onset",
    "gross_slip_bound",
    "patch_limit",
    "single_node_limit",
    "sliding_corner_exponent",
    "two_node_limits",
    "uncoupled_limit",
]
