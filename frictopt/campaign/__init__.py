"""Campaigns: steady states of many transients as tables."""

from .dissipation import dissipation_study
from .dissipation_range import DissipationRange, dissipation_range
from .excursion import LeastExcursion, least_excursion
from .guarantee import GuaranteeCheck, verify_guaranteed
from .protocols import LimitAfterProtocol, limit_after_protocol
from .separated import SeparatedLimit, separated_limit
from .starts import Start, given_slips, no_slip, overloads, random_slips, safe_slips
from .store import DamagedRows, read_store
from .treatment import LoadStep, assembled_slip

__all__ = [
    "DamagedRows",
    "DissipationRange",
    "GuaranteeCheck",
    "LeastExcursion",
    "LimitAfterProtocol",
    "LoadStep",
    "SeparatedLimit",
    "Start",
    "assembled_slip",
    "dissipation_range",
    "dissipation_study",
    "given_slips",
    "least_excursion",
    "limit_after_protocol",
    "no_slip",
    "overloads",
    "random_slips",
    "read_store",
    "safe_slips",
    "separated_limit",
    "verify_guaranteed",
]
