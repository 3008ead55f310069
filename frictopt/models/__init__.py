"""Every cvxpy problem of the package, and the one place that solves them."""

from .complementarity import ComplementarityProblem, complementarity_problem
from .exact_increment import ExactIncrement
from .frozen_bound import FrozenBoundIncrement
from .guaranteed import GuaranteedLimit, GuaranteedModel, guaranteed_limit
from .increment import Increment
from .outcome import LimitKind
from .safe_slip import SafeSlip, safe_slip
from .safe_vertices import safe_vertices
from .shakedown import ShakedownLimit, ShakedownModel, shakedown_limit
from .solve import LP_SOLVERS, MILP_SOLVERS, QP_SOLVERS, TOLERANCE, Attempt

__all__ = [
    "LP_SOLVERS",
    "MILP_SOLVERS",
    "QP_SOLVERS",
    "TOLERANCE",
    "Attempt",
    "ComplementarityProblem",
    "ExactIncrement",
    "FrozenBoundIncrement",
    "GuaranteedLimit",
    "GuaranteedModel",
    "Increment",
    "LimitKind",
    "SafeSlip",
    "ShakedownLimit",
    "ShakedownModel",
    "complementarity_problem",
    "guaranteed_limit",
    "safe_slip",
    "safe_vertices",
    "shakedown_limit",
]
