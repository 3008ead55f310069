"""Histories: what follows from many transients."""

from . import results, starts
from .damping import DampingCurve, damping_curve
from .dissipation import dissipation_study
from .dissipation_range import DissipationRange, dissipation_range
from .excursion import LeastExcursion, least_excursion
from .guarantee import GuaranteeCheck
from .protocols import LimitAfterProtocol, limit_after_protocol
from .store import DamagedRows, merge_stores, read_store
from .wear import wear
from .wear_history import WearHistory
from .worn_in import WornIn, worn_in

__all__ = [
    "DamagedRows",
    "DampingCurve",
    "DissipationRange",
    "GuaranteeCheck",
    "LeastExcursion",
    "LimitAfterProtocol",
    "WearHistory",
    "WornIn",
    "damping_curve",
    "dissipation_range",
    "dissipation_study",
    "least_excursion",
    "limit_after_protocol",
    "merge_stores",
    "read_store",
    "results",
    "starts",
    "wear",
    "worn_in",
]
