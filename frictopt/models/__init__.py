"""Every cvxpy problem of the package, and the one place that solves them."""

from .safe_slip import SafeSlip, safe_slip
from .shakedown import ShakedownLimit, ShakedownModel, shakedown_limit
from .solve import LP_SOLVERS, TOLERANCE, Attempt

__all__ = ["LP_SOLVERS", "TOLERANCE", "Attempt", "SafeSlip", "ShakedownLimit", "ShakedownModel", "safe_slip", "shakedown_limit"]
