"""Limits of a load cycle as linear and cone programs.

In come a system, a load cycle and friction; out go limits with proofs. Every program stands in
`models.py`, in the symbols of the paper. A public question stands in the file of its name with its
answer: `shakedown.py`, `guaranteed.py`, `safe_slip.py`, `required_friction.py`, `safe_region.py`,
`design.py`, `gross_slip.py`. `question.py` poses a question, `programs.py` has what its program
needs, `safe_model.py` the models that users extend, `answered.py` what all answers share
(multipliers as a `Mechanism`), `patterns.py` and `lift_off.py` the search of open nodes,
`critical_state.py` the critical nodes of the guaranteed limit.
"""

from ..base import LimitKind
from .design import Design, DesignModel
from .gross_slip import GrossSlip, gross_slip
from .guaranteed import GuaranteedLimit, GuaranteedModel, guaranteed_limit
from .least_slip import LeastSlip
from .required_friction import RequiredFriction, required_friction
from .safe_region import SafeRegion, safe_region
from .safe_slip import SafeSlip, SafeSlipModel, safe_slip
from .safe_vertices import safe_vertices
from .shakedown import ShakedownLimit, ShakedownModel, shakedown_limit
