"""The limit of a contact some of whose nodes stay open: a linear program once they are condensed out.

The nodes O are open at every corner k, the others M closed and stuck. The slip v of M is constant, on O no force acts, and slip and gap there follow
from the load and from v. In full::

    max lam   s.t.   |q_k| <= f p_k  on M,   w_k >= 0  on O
    where   q_k, p_k = r^w_M - S_MO S_OO^-1 r^w_O + (S_MM - S_MO S_OO^-1 S_OM) u_M            u_M = [v, -g0]
            [v_k, w_k - g0] = -S_OO^-1 (r^w_O + S_OM u_M)   on O                              r^w = mean + lam corner_k

This is the shakedown limit of the condensed contact under one more row for each open node: of its gaps at the corners, which differ only in the
coefficient of `lam >= 0`, the one that shrinks fastest rules. All quantities are linear on the way from corner to corner, so no node opens or closes
there: a solution is a true state of rest, and the limit a lower bound of the load factors at which some state of rest exists, for any O.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..contact import ContactSystem, LoadCycle, referee
from ..contact.checks import Array
from ..contact.tolerances import HELD, NOTHING_LEFT, RESIDUAL
from ..errors import SolverError
from .shakedown import ShakedownModel

__all__ = ["Booleans", "OpenSetLimit", "open_set_limit", "opened_by"]

Booleans = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


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
        (K, N) slips, gaps and reactions at the corners, length and force per depth; NaN without a limit.
    residual
        Largest violation of the contact law by these states, or of the program's proof. At most 1e-9.
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
    problem: cp.Problem | None


def open_set_limit(system: ContactSystem, cycle: LoadCycle, friction: Array, opened: Booleans) -> OpenSetLimit | None:
    """The limit with the nodes `opened` (N,) open and the others closed; None if no load factor has such a state, or it leaves a body free.

    Parameters
    ----------
    system, cycle, friction
        The contact, its load cycle and (N,) coefficients of friction.
    opened
        (N,) which nodes are open.

    Raises
    ------
    SolverError
        No solver gave an answer that passes the checks.
    """
    parts = _Condensed.of(system, opened)
    if parts is None:
        return None
    mean = np.concatenate(system.reaction(cycle.mean))
    cyclic = np.hstack(cycle.corner_reactions(system))
    least, rate = parts.gaps(mean), np.array([parts.gaps(corner, cyclic=True) for corner in cyclic]).min(axis=0)
    if opened.all():
        return _judged(system, cycle, friction, parts, _ends(least, rate), np.zeros(0), 0.0, None)
    model = ShakedownModel(parts.kept(), cycle)
    length = max(float(np.abs(least).max(initial=0.0)), float(np.abs(mean).mean()) / system.stiffness_scale, float(system.gap.max())) or 1.0
    shrinking = least + rate * model.load_factor + parts.lift @ model.slip
    limit = model.solve(friction[~opened], [(shrinking / length >= 0).set_label("gaps")] if opened.any() else [])
    if np.isnan(limit.load_factor):
        return None
    return _judged(system, cycle, friction, parts, (limit.least, limit.load_factor), limit.slip, limit.residual, limit.problem)


def opened_by(system: ContactSystem, loads: Mapping[str, float]) -> Booleans:
    """Nodes (N,) that a load opens where closed nodes stick without slip: none where it would free a body, the last set tried where none stays."""
    opened = np.zeros(system.nodes, dtype=bool)
    for _ in range(system.nodes):
        parts = _Condensed.of(system, opened)
        if parts is None or opened.all():
            return opened
        kept, before = parts.kept(), opened.copy()
        opened[before] = parts.gaps(np.concatenate(system.reaction(loads))) > 0
        opened[~before] = kept.reaction(loads)[1] - kept.C @ kept.gap < 0
        if (opened == before).all():
            break
    return opened


def _ends(gap: Array, rate: Array) -> tuple[float, float]:
    """The least and the largest load factor >= 0 at which `gap + load_factor rate >= 0`: NaN if there is none."""
    low = float(np.divide(-gap, rate, out=np.where(gap < 0, np.inf, 0.0), where=rate > 0).max(initial=0.0))
    high = float(np.divide(gap, -rate, out=np.full_like(gap, np.inf), where=rate < 0).min())
    return (low, high) if low <= high and np.isfinite(low) else (np.nan, np.nan)


@dataclass(frozen=True, eq=False)
class _Condensed:
    """A contact without its open nodes.

    Attributes
    ----------
    system, opened
        The whole contact, and (N,) which nodes are condensed out.
    out, keep
        Their indices in `[v, w]`, and those of the others.
    follow
        `S_OO^-1 S_OK`: minus what the open nodes do for a motion of the others.
    give
        `S_OO^-1`.
    """

    system: ContactSystem
    opened: Booleans
    out: np.ndarray
    keep: np.ndarray
    follow: Array
    give: Array

    @classmethod
    def of(cls, system: ContactSystem, opened: Booleans) -> "_Condensed | None":
        out, keep = np.flatnonzero(np.r_[opened, opened]), np.flatnonzero(~np.r_[opened, opened])
        S = system.S
        values = np.linalg.eigvalsh(S[np.ix_(out, out)])
        if len(out) and not values[0] > HELD * max(values[-1], np.finfo(float).tiny):
            return None
        give = np.asarray(np.linalg.inv(S[np.ix_(out, out)]), dtype=np.float64)
        return cls(system, opened, out, keep, give @ S[np.ix_(out, keep)], give)

    def kept(self) -> ContactSystem:
        """The contact of the closed nodes."""
        if not len(self.out):
            return self.system
        system, closed, m = self.system, ~self.opened, int((~self.opened).sum())
        S = system.S[np.ix_(self.keep, self.keep)] - system.S[np.ix_(self.keep, self.out)] @ self.follow
        values, vectors = np.linalg.eigh((S + S.T) / 2)  # what nothing resists any more is left as rounding of both signs
        S = (vectors * np.where(values > NOTHING_LEFT * np.abs(system.S).max(), values, 0.0)) @ vectors.T
        S = (S + S.T) / 2
        loads = {name: np.concatenate(pair) for name, pair in system.bonded.items()}
        bonded = {name: np.split(r[self.keep] - self.follow.T @ r[self.out], 2) for name, r in loads.items()}
        pairs = {name: (q, p) for name, (q, p) in bonded.items()}
        return ContactSystem.from_blocks(S[:m, :m], S[m:, :m], S[m:, m:], system.x[closed], pairs, system.gap[closed], E_star=system.E_star)

    @property
    def lift(self) -> Array:
        """(O, M) gaps of the open nodes for slips of the closed ones."""
        return -self.follow[int(self.opened.sum()) :, : int((~self.opened).sum())]

    def gaps(self, load: Array, cyclic: bool = False) -> Array:
        """(O,) gaps of the open nodes under bonded reactions (2N,), without slip of the closed ones; of a cyclic part only what it adds."""
        return self.motion(load, np.zeros(int((~self.opened).sum())), cyclic)[1]

    def motion(self, load: Array, slip: Array, cyclic: bool = False) -> tuple[Array, Array]:
        """(O,) slips and gaps of the open nodes under bonded reactions and slips (M,) of the closed ones."""
        gap = np.zeros_like(self.system.gap) if cyclic else self.system.gap
        u = -self.give @ load[self.out] - self.follow @ np.concatenate([slip, -gap[~self.opened]])
        v, w = np.split(u, 2)
        return v, w + gap[self.opened]


def _judged(
    system: ContactSystem,
    cycle: LoadCycle,
    friction: Array,
    parts: _Condensed,
    ends: tuple[float, float],
    slip: Array,
    residual: float,
    problem: cp.Problem | None,
) -> OpenSetLimit | None:
    """The limit with its states at the corners, judged by the referee."""
    (least, load_factor), opened, cyclic = ends, parts.opened, np.hstack(cycle.corner_reactions(system))
    if np.isnan(load_factor):
        return None
    v, w = np.full((2, len(cyclic), system.nodes), np.nan)
    if np.isinf(load_factor):
        return OpenSetLimit(load_factor, least, opened, v, w, v, w, residual, problem)
    bonded = np.concatenate(system.reaction(cycle.mean)) + load_factor * cyclic
    v[:, ~opened], w[:, ~opened] = slip, 0.0
    for corner, load in enumerate(bonded):
        v[corner, opened], w[corner, opened] = parts.motion(load, slip)
    n = system.nodes
    r = bonded + np.hstack([v, w - system.gap]) @ system.S
    r[:, np.r_[opened, opened]] = 0.0
    force = float(np.abs(bonded).max()) or 1.0
    verdict = referee(system, (bonded[:, :n], bonded[:, n:]), friction, v=v, w=w, q=r[:, :n], p=r[:, n:], force_scale=force)
    residual = max(residual, verdict.residual)
    if not residual <= RESIDUAL:
        raise SolverError(f"open set: the states at the limit violate the contact law by {residual:.1e} (tolerance {RESIDUAL:g}; {verdict})")
    return OpenSetLimit(load_factor, least, opened, v, np.maximum(w, 0.0), r[:, :n], r[:, n:], residual, problem)
