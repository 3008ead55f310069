"""Limits of a load cycle as linear and cone programs, each with a proof.

A system, a load cycle and friction come in; limits with their proofs go out. A contact can shake
down at a load factor if one residual slip v keeps every node closed and stuck at all corners k::

    q_k = q0 + load_factor q1_k + A v,   p_k = p0 + load_factor p1_k + B v,   |q_k| <= f p_k

A contact with this slip stays stuck. Whether it reaches such a slip depends on the start, unless
the contact is uncoupled (B = 0). The largest such load factor is the shakedown limit. The solution
of the dual program is a slip mechanism, which proves the limit.

In this folder each public question has a file: `shakedown.py`, `guaranteed.py`, `safe_slip.py`,
`required_friction.py`, `safe_region.py`, `fatigue_band.py`, `fatigue_limit.py`,
`rest_intervals.py`, `gross_slip.py` and `probability.py`. `user_models.py` has the models that
users extend, `pictures.py` the plots. For a new limit, follow the example of `limit_of_set` in
`shakedown.py`.

The folders inside this folder, ordered so that each needs only the folders above it in the list:

- `program`: a question as arrays, their solution, and the mechanism that proves it.
- `between`: proven bounds of the limits of large contacts, without their stiffness matrix.
- `events`: nodes that open and close in each cycle, in a given order.
- `moving`: uncoupled contacts whose normal loads open and close nodes.
- `guarantee`: the critical nodes of the guaranteed limit.
- `balance`: statics of the bodies, for gross slip and for faces that slide as a whole.
- `printed`: the problems in cvxpy, as they are printed and extended.
- `answers`: what answers share, what they prove, and their reasons.
- `search`: the searches for open nodes, for orders of events, and for extreme stresses.
- `best_design`: the best preloads and profile; it also needs the files beside these folders.
"""

from typing import TYPE_CHECKING

import lazy_loader  # type: ignore[import-untyped]  # it has no types

from ..base import LimitKind
from .answers.shakedown_answer import LeastSlip
from .best_design.design import Design
from .fatigue_band import FatigueBand, fatigue_band
from .fatigue_limit import FatigueLimit, fatigue_limit
from .gross_slip import GrossSlip, gross_slip
from .guaranteed import GuaranteedLimit, guaranteed_limit
from .moving.moving_areas import areas_near, moving_areas
from .moving.normal_path import NoPath, normal_path, piece_at
from .probability import ShakedownProbability
from .program.question import Question, pose, with_open
from .required_friction import RequiredFriction, required_friction
from .rest_intervals import pieces
from .safe_region import SafeRegion, safe_region
from .safe_slip import SafeSlip, safe_slip
from .shakedown import ShakedownLimit, limit_of_any_set, limit_of_set, shakedown_limit

if TYPE_CHECKING:
    from .best_design.model import DesignModel
    from .user_models import GuaranteedModel, ShakedownModel

# The models import cvxpy, which is slow to import, and answers do not need it.
__getattr__, _, _ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "best_design.model": ["DesignModel"],
        "user_models": ["GuaranteedModel", "ShakedownModel"],
    },
)
