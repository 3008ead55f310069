"""Limits of a load cycle as linear programs: shakedown, safe residual slip, guaranteed limit."""

from .guaranteed import GuaranteedModel, guaranteed_limit
from .guaranteed_result import GuaranteedLimit
from .kinds import LimitKind
from .safe_slip import SafeSlipModel, safe_slip
from .safe_slip_result import SafeSlip
from .safe_vertices import safe_vertices
from .shakedown import ShakedownModel, shakedown_limit
from .shakedown_result import ShakedownLimit

__all__ = [
    "GuaranteedLimit",
    "GuaranteedModel",
    "LimitKind",
    "SafeSlip",
    "SafeSlipModel",
    "ShakedownLimit",
    "ShakedownModel",
    "guaranteed_limit",
    "safe_slip",
    "safe_vertices",
    "shakedown_limit",
]
