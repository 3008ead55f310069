"""Limits of a load cycle as linear and cone programs, each with a proof.

In come a system, a load cycle and friction; out go limits with their proofs. A contact shakes down
at a load factor if one residual slip v keeps every node closed and stuck at all corners k::

    q_k = q0 + load_factor q1_k + A v,   p_k = p0 + load_factor p1_k + B v,   |q_k| <= f p_k

The largest such load factor is the shakedown limit. Its dual is a slip mechanism, which proves it.

- `question.py`: a question as data: all its arrays, and the check of its answers; `units.py`: the
  units of its unknowns.
- `rest_program.py`: the arrays of a program of states of rest; `elastic.py`: its unknowns;
  `law_rows.py`: the rows of the contact law; `assembled.py`: the program of each question;
  `solution.py`: its solution, and what the multipliers prove; `solved.py`: a solved program as
  data; `mechanism.py`: the slip mechanism; `corners.py`: the corners that matter.
- `models.py`: all printed problems, as cvxpy expressions in the symbols of the paper; `listing.py`,
  `ordered_listing.py`, `design_listing.py`: the printed problem of an answer,
  with its values (`filled.py`). No answer needs them.
- `user_rows.py`: rows and objectives of users as rows of the arrays; `user_checks.py`: which of
  them are accepted.
- `safe_model.py`: the models that users extend by constraints of their own.
- `shakedown.py`, `guaranteed.py`, `safe_slip.py`, `required_friction.py`, `safe_region.py`,
  `design.py`, `gross_slip.py`: a public question each, with its answer; `shakedown_model.py`,
  `guaranteed_model.py`, `safe_slip_model.py` and `design_model.py` are their models, and
  `safe_by_friction.py` keeps the safe slips that the least friction needs. The model for a new
  limit is `ShakedownLimits` in `shakedown.py`.
- `answered.py`: what all answers share; `sentences.py`: the sentences of their reasons;
  `reasons.py`: those that fit a limit; `shakedown_answer.py`: what a limit proves about other
  states; `proven_again.py`: answers of files are checked;
  `last_resort.py`: plain cvxpy solves the printed problem if no answer of the arrays passes.
- `set_search.py`: the search of open nodes; `likely_sets.py`, `open_nodes.py`: sets that it tries;
  `loose_nodes.py` bounds many sets at once, `quick_bound.py` one set without a program.
  `lift_off.py`, `ordered.py`, `load_path.py`: nodes that open and close in each cycle, the program
  of their order, and where they can; `order_search.py`, `settled_order.py`: the search of their
  order.
- `moving_areas.py`: uncoupled contacts whose normal loads open and close nodes, with the path of
  pressures in `normal_path.py`, the shear of the nodes that come and go in `rim.py`, and the limit
  of all states of rest in `moving_limit.py`. If normal loads are scaled, too: the path as a
  function of the load factor in `path_pieces.py`, and all load factors with a state of rest in
  `rest_intervals.py`.
- `critical_state.py`, `critical_bounds.py`, `critical_search.py`: the critical nodes of the
  guaranteed limit.
- `best_pressed.py`, `least_slip.py`, `furthest.py`, `region_rays.py`, `design_program.py`,
  `design_search.py`: parts of the questions of these names.
- `corner_statics.py`, `body_motions.py`, `self_stress.py`: parts of gross slip.
- `pictures.py`: plots of the answers.
"""

from typing import TYPE_CHECKING

import lazy_loader  # type: ignore[import-untyped]  # it has no types

from ..base import LimitKind
from .design import Design
from .gross_slip import GrossSlip, gross_slip
from .guaranteed import GuaranteedLimit, guaranteed_limit
from .least_slip import LeastSlip
from .moving_areas import areas_near, moving_areas
from .normal_path import NoPath, normal_path
from .path_pieces import piece_at
from .question import Question, pose, with_open
from .required_friction import RequiredFriction, required_friction
from .rest_intervals import pieces
from .safe_region import SafeRegion, safe_region
from .safe_slip import SafeSlip, safe_slip
from .shakedown import ShakedownLimit, ShakedownLimits, shakedown_limit

if TYPE_CHECKING:
    from .design_model import DesignModel
    from .guaranteed_model import GuaranteedModel
    from .safe_slip_model import SafeSlipModel
    from .shakedown_model import ShakedownModel

# The models import cvxpy, which is slow to import, and answers do not need it.
__getattr__, _, _ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "design_model": ["DesignModel"],
        "guaranteed_model": ["GuaranteedModel"],
        "safe_slip_model": ["SafeSlipModel"],
        "shakedown_model": ["ShakedownModel"],
    },
)
