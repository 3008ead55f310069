"""The classes of all results, for `isinstance` and type hints; `load` reads a saved result."""

from pathlib import Path
from typing import Any

from .base import Attempt, SolveRecord, archive
from .contact import StressMap, Verdict
from .joints.archard import WearHistory
from .joints.backbone import BackboneCurve
from .joints.end_of_wear import WornIn
from .joints.forced_response import ForcedResponse
from .joints.report import Comparison, Report
from .limits import (
    Design,
    FatigueBand,
    FatigueLimit,
    GrossSlip,
    GuaranteedLimit,
    LeastSlip,
    RequiredFriction,
    SafeRegion,
    SafeSlip,
    ShakedownLimit,
    ShakedownProbability,
)
from .study.dissipation_range import DissipationRange
from .study.protocols import FrictionAfterProtocol, LimitAfterProtocol
from .study.store import DamagedRows, OtherRows, merge_stores, read_store
from .transients import LoadLoop, Onset, OnsetEvent, SteadyState, Trajectory

__all__ = [
    "Attempt",
    "BackboneCurve",
    "Comparison",
    "DamagedRows",
    "Design",
    "DissipationRange",
    "FatigueBand",
    "FatigueLimit",
    "ForcedResponse",
    "FrictionAfterProtocol",
    "GrossSlip",
    "GuaranteedLimit",
    "LeastSlip",
    "LimitAfterProtocol",
    "LoadLoop",
    "Onset",
    "OnsetEvent",
    "OtherRows",
    "Report",
    "RequiredFriction",
    "SafeRegion",
    "SafeSlip",
    "ShakedownLimit",
    "ShakedownProbability",
    "SolveRecord",
    "SteadyState",
    "StressMap",
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


def load(path: str | Path) -> Any:
    """Read a result that its `save` wrote.

    It is of the same class, and equal in all numbers, words and tables. Its `problem` is made again
    from the numbers; designs, and results with constraints of a model, have none.

    Returns
    -------
    object
        A result of the class that was saved.

    Raises
    ------
    ModelError
        The file is missing or damaged, or holds something else.

    Examples
    --------
    >>> import tempfile
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = f"{folder}/steady.npz"
    ...     fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0).save(file)
    ...     steady = fo.results.load(file)
    >>> steady.outcome.name, round(steady.dissipation, 9), steady.system.nodes
    ('CYCLIC_SLIP', 1.0, 4)
    """
    return archive.load(path)
