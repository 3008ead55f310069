"""The limit of a contact with a given set of open nodes: that of its closed nodes, see `open_nodes`, or where all are open of their gaps alone."""

from dataclasses import dataclass, replace

import cvxpy as cp
import numpy as np

from ..contact.checks import Array, Booleans
from ..contact.parts import joined
from ..contact.tolerances import RESIDUAL
from ..errors import SolverError
from .open_nodes import compliance, rest_of
from .question import LimitQuestion
from .shakedown import ShakedownModel
from .shakedown_result import ShakedownLimit


@dataclass(frozen=True, eq=False)
class OpenSetLimit:
    """Largest load factor at which some slip keeps a set of nodes open and the others closed and stuck, with the states at the corners.

    Attributes
    ----------
    load_factor
        inf if there is no limit.
    least
        The least such load factor. Those between rest with the same nodes open.
    opened
        (N,) the open nodes.
    slip, gap, q, p
        (K, N) or (K, N, 2) slips, gaps and reactions at the corners, length and force; NaN without a limit.
    residual
        Largest violation of the contact law by these states, or of the program's proof. At most 1e-9.
    active
        (N,) nodes that rule: they slip, open or touch in the mechanism; largest share first.
    problem
        The solved cvxpy problem; None where a closed form answered.
    """

    load_factor: float
    least: float
    opened: Booleans
    slip: Array
    gap: Array
    q: Array
    p: Array
    residual: float
    active: tuple[int, ...]
    problem: cp.Problem | None


def open_set_limit(model: ShakedownModel, task: LimitQuestion, opened: Booleans) -> OpenSetLimit | None:
    """The limit with the nodes `opened` (N,) open and the others closed; None if no load factor has such a state, or it leaves a body free.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    if opened.all():
        return _all_open(task)
    rest = rest_of(task, opened) if opened.any() else task
    limit = None if rest is None else model.of_set(rest)
    return None if limit is None or np.isnan(limit.load_factor) else with_states(limit)


def with_states(limit: ShakedownLimit) -> OpenSetLimit:
    """A shakedown limit with the states of its open nodes."""
    reactions = limit.reactions
    slip, gap = limit._task.states(limit.load_factor, limit.slip) if np.isfinite(limit.load_factor) else reactions  # these are NaN there too
    active = tuple(dict.fromkeys(limit.mechanism["node"].tolist()))
    return OpenSetLimit(limit.load_factor, limit.least, limit.open, slip, gap.clip(0.0), *reactions, limit.residual, active, limit.problem)


def _all_open(task: LimitQuestion) -> OpenSetLimit | None:
    """The load factors at which all nodes are open: where no gap closes at any corner."""
    n, still, none = task.system.nodes, np.zeros(task.system.slip_shape), np.zeros_like(task.p1)
    give = compliance(task.system, np.ones(n, dtype=bool))
    if give is None:
        return None
    opened = replace(task, closed=np.zeros(n, dtype=bool), give=give)
    gap, rates = opened.states(0.0, still)[1], (-joined(task.q1, task.p1) @ give)[:, -n:]
    rate = rates if task.fixed else np.broadcast_to(rates.min(axis=0), rates.shape)
    least = float(np.divide(-gap, rate, out=np.where(gap < 0, np.inf, 0.0), where=rate > 0).max(initial=0.0))
    load_factor = float(np.divide(gap, -rate, out=np.full(gap.shape, np.inf), where=rate < 0).min())
    if not (least <= load_factor and np.isfinite(least)):
        return None
    at = load_factor if np.isfinite(load_factor) else least
    (slip, gap), residual = opened.states(at, still), opened.violation(at, still)
    if not residual <= RESIDUAL:
        raise SolverError(f"open set: the states at the limit violate the contact law by {residual:.1e} (tolerance {RESIDUAL:g})")
    ruling = int(gap.min(axis=0).argmin())
    return OpenSetLimit(load_factor, least, ~opened.closed, slip, gap.clip(0.0), np.zeros_like(task.q1), none, residual, (ruling,), None)
