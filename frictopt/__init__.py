"""frictopt decides whether a frictional contact will stop slipping.

A finite-element model of two bodies is condensed to its interface (`PunchOnHalfPlane`, `ContactModel` -> `ContactSystem`); for a load cycle
(`LoadCycle`) and a coefficient of friction, linear programs give the shakedown limit, the guaranteed limit and safe residual slips, and exact paths
give the steady state that a transient reaches.
"""

from . import reference
from .contact import ContactSystem, LoadCycle, Onset, OnsetEvent, Verdict, onset, referee
from .errors import FrictoptError, ModelError, NoContinuation, SolverError, StoreError
from .fem import Body, ContactModel, Material, PunchOnHalfPlane, Support, Traction
from .models import (
    GuaranteedLimit,
    GuaranteedModel,
    LimitKind,
    SafeSlip,
    ShakedownLimit,
    ShakedownModel,
    guaranteed_limit,
    safe_slip,
    shakedown_limit,
)
from .path import Outcome, SteadyState, steady_state
from .study import GuaranteeCheck, Trajectory, dissipation_study, march, read_store, verify_guaranteed

__version__ = "0.1.0"

__all__ = [
    "Body",
    "ContactModel",
    "ContactSystem",
    "FrictoptError",
    "GuaranteeCheck",
    "GuaranteedLimit",
    "GuaranteedModel",
    "LimitKind",
    "LoadCycle",
    "Material",
    "ModelError",
    "NoContinuation",
    "Onset",
    "OnsetEvent",
    "Outcome",
    "PunchOnHalfPlane",
    "SafeSlip",
    "ShakedownLimit",
    "ShakedownModel",
    "SolverError",
    "SteadyState",
    "StoreError",
    "Support",
    "Traction",
    "Trajectory",
    "Verdict",
    "dissipation_study",
    "guaranteed_limit",
    "march",
    "onset",
    "read_store",
    "referee",
    "reference",
    "safe_slip",
    "shakedown_limit",
    "steady_state",
    "verify_guaranteed",
]
