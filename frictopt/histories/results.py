"""What questions answer: the classes of all results, for `isinstance` and for type hints; and how a store of them is read."""

from ..contact import Attempt, SolveRecord, Verdict
from ..limits import Design, GrossSlip, GuaranteedLimit, LeastSlip, RequiredFriction, SafeRegion, SafeSlip, ShakedownLimit
from ..transients import LoadLoop, Onset, OnsetEvent, SteadyState, Trajectory
from .damping import DampingCurve
from .dissipation_range import DissipationRange
from .excursion import LeastExcursion
from .guarantee import GuaranteeCheck
from .protocols import LimitAfterProtocol
from .store import DamagedRows, merge_stores, read_store
from .wear import WearHistory
from .worn_in import WornIn

__all__ = [
    "Attempt",
    "DamagedRows",
    "DampingCurve",
    "Design",
    "DissipationRange",
    "GrossSlip",
    "GuaranteeCheck",
    "GuaranteedLimit",
    "LeastExcursion",
    "LeastSlip",
    "LimitAfterProtocol",
    "LoadLoop",
    "Onset",
    "OnsetEvent",
    "RequiredFriction",
    "SafeRegion",
    "SafeSlip",
    "ShakedownLimit",
    "SolveRecord",
    "SteadyState",
    "Trajectory",
    "Verdict",
    "WearHistory",
    "WornIn",
    "merge_stores",
    "read_store",
]
