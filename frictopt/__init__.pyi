from . import fem as fem
from . import joints as joints
from . import readers as readers
from . import reference as reference
from . import results as results
from . import scenes as scenes
from .base import LimitKind, Outcome
from .contact import (
    ContactProducts,
    ContactState,
    ContactSystem,
    LoadCycle,
)
from .errors import FrictoptError, ModelError, ModelWarning, NoContinuation, SolverError, StoreError
from .fem.condense import condense
from .joint_files.read_joint import read_joint
from .joints.report import compare, report
from .limits import (
    DesignModel,
    GuaranteedModel,
    ShakedownModel,
    fatigue_band,
    fatigue_limit,
    gross_slip,
    guaranteed_limit,
    required_friction,
    safe_region,
    safe_slip,
    shakedown_limit,
)
from .study import starts
from .study.after_overload import after_overload
from .study.dissipation import dissipation_study, plot_study
from .study.dissipation_range import dissipation_range
from .study.protocols import friction_after_protocol, limit_after_protocol
from .transients import (
    increments,
    march,
    onset,
    steady_state,
)

__version__: str

__all__ = [
    "ContactProducts",
    "ContactState",
    "ContactSystem",
    "DesignModel",
    "FrictoptError",
    "GuaranteedModel",
    "LimitKind",
    "LoadCycle",
    "ModelError",
    "ModelWarning",
    "NoContinuation",
    "Outcome",
    "ShakedownModel",
    "SolverError",
    "StoreError",
    "after_overload",
    "compare",
    "condense",
    "dissipation_range",
    "dissipation_study",
    "fatigue_band",
    "fatigue_limit",
    "fem",
    "friction_after_protocol",
    "gross_slip",
    "guaranteed_limit",
    "increments",
    "joints",
    "limit_after_protocol",
    "march",
    "onset",
    "plot_study",
    "read_joint",
    "readers",
    "reference",
    "report",
    "required_friction",
    "results",
    "safe_region",
    "safe_slip",
    "scenes",
    "shakedown_limit",
    "starts",
    "steady_state",
]
