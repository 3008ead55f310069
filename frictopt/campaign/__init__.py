"""Campaigns: transients as trajectories, and steady states of many transients as tables."""

from .dissipation import Interrupted, dissipation_study
from .fretting import fretting_table, steady_cycle
from .guarantee import GuaranteeCheck, verify_guaranteed
from .march import march
from .separated import SeparatedLimit, separated_limit
from .starts import Start, given_slips, no_slip, overloads, random_slips, safe_slips
from .store import DamagedRows, read_store
from .trajectory import Trajectory

__all__ = [
    "DamagedRows",
    "GuaranteeCheck",
    "Interrupted",
    "SeparatedLimit",
    "Start",
    "Trajectory",
    "dissipation_study",
    "fretting_table",
    "given_slips",
    "march",
    "no_slip",
    "overloads",
    "random_slips",
    "read_store",
    "safe_slips",
    "separated_limit",
    "steady_cycle",
    "verify_guaranteed",
]
