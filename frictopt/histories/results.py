"""What questions answer: the classes of all results, for `isinstance` and for type hints; and how files and stores of them are read."""

from ..contact import Attempt, SolveRecord, Verdict
from ..limits import Design, GrossSlip, GuaranteedLimit, LeastSlip, RequiredFriction, SafeRegion, SafeSlip, ShakedownLimit
from ..transients import LoadLoop, Onset, OnsetEvent, SteadyState, Trajectory
from .backbone_result import BackboneCurve
from .dissipation_range import DissipationRange
from .excursion import LeastExcursion
from .guarantee import GuaranteeCheck
from .kept import load
from .protocols import LimitAfterProtocol
from .report_result import Report
from .store import DamagedRows, merge_stores, read_store
from .wear import WearHistory
from .worn_in import WornIn

__all__ = [
    "Attempt",
    "BackboneCurve",
    "DamagedRows",
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
    "Report",
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
    "load",
    "merge_stores",
    "read_store",
]


def __dir__() -> list[str]:
    return __all__
