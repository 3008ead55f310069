"""The least friction with which a load factor is safe."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import brentq, linprog

from ..contact import ContactSystem, LoadCycle
from ..contact.checks import Array, finite_number, frozen
from ..contact.cycle import checked_cycle
from ..contact.record import Recorded, SolveRecord
from ..contact.show import Plotted, frame
from ..contact.tolerances import NO_LEAST_PRESSURE, PROVEN_FRICTION, RESIDUAL, WIDEST_PROOF
from ..errors import SolverError
from .mechanism import Mechanism
from .safe_slip import SafeSlipModel
from .safe_slip_result import SafeSlip

__all__ = ["RequiredFriction", "required_friction"]

_LEAST_FRICTION, _MOST_FRICTION = 1e-6, 1e4  # which linear programs can tell from 0 and inf


@dataclass(frozen=True, eq=False, repr=False)
class RequiredFriction(Recorded, Plotted):
    """The least coefficient of friction with which a load factor is safe, with its proof from both sides.

    Attributes
    ----------
    friction
        Coefficient of friction with which `slip` is safe; 0 if none is needed, inf if none is enough.
    too_little
        Coefficient of friction with which no slip is safe, less than 1e-5 below `friction`, relatively; nan where none is needed.
    slip
        (N,) a residual slip that is safe with `friction`, length; NaN where none is enough.
    mechanism
        Why `too_little` is not enough (Farkas's lemma), or why no friction is: motions for which the loads do more work than friction can take up,
        while no residual slip resists them. Columns node, x, corner, direction (+1 slips along +x, -1 against it, 0 opens), share; largest first.
    reason
        Why it is so, in words.
    system, cycle, load_factor
        What was asked: the contact, its load cycle and the load factor.
    record
        How it was found. Its `residual` is the larger one of the two proofs. At most 1e-9.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> fo.required_friction(node, fo.LoadCycle({"P": 2.0}, [{"Q": -1.0}, {"Q": 3.0}]), 1.0).mechanism["direction"].tolist()
    [1, -1]
    """

    friction: float
    too_little: float
    slip: Array = field(repr=False)
    mechanism: pd.DataFrame = field(repr=False)
    reason: str
    system: ContactSystem = field(repr=False)
    cycle: LoadCycle = field(repr=False)
    load_factor: float
    record: SolveRecord

    @property
    def reactions(self) -> tuple[Array, Array]:
        """(K, N) reactions `q, p` at the corners under the slip, force per depth; NaN where no friction is enough."""
        (q0, p0), (q1, p1) = self.cycle.mean_reaction(self.system), self.cycle.corner_reactions(self.system)
        return q0 + self.load_factor * q1 + self.system.A @ self.slip, p0 + self.load_factor * p1 + self.system.B @ self.slip

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, x and the slip that is safe with the required friction."""
        return frame({"node": range(len(self.slip)), "x": self.system.x, "slip": self.slip})

    def _answer(self) -> Mapping[str, Any]:
        return {name: getattr(self, name) for name in ("friction", "too_little", "residual", "reason")}


def required_friction(system: ContactSystem, cycle: LoadCycle, load_factor: float) -> RequiredFriction:
    """Least coefficient of friction, the same at all nodes, with which some residual slip is safe at a load factor.

    A slip that is safe with friction f presses every node at every corner: `abs(q) <= f p` needs `p >= 0`, and without friction it is asked for. With
    more friction the bounds f p only grow, so the same slip stays safe. There is therefore one coefficient above which a slip is safe and below which
    none is. It is the root of the margin of `safe_slip`, which never falls as friction grows. It is finite if some slip presses every
    node at every corner (f is then at most the largest `abs(q) / p` there). If no slip does, no friction is enough. Theory, eq. (16).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    load_factor
        Load factor, >= 0.

    Raises
    ------
    ModelError
        Bad input.
    SolverError
        The two sides of the proof do not come within 1e-5 of each other, or whether any friction is enough is within rounding.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> cycle = fo.LoadCycle({"P": 2.0}, [{"Q": -1.0}, {"Q": 3.0}])  # a slip of 1 leaves a shear of 2 at both corners
    >>> required = fo.required_friction(node, cycle, 1.0)
    >>> round(required.friction, 5), required.too_little < required.friction
    (1.0, True)
    """
    started, load_factor = perf_counter(), finite_number("load_factor", load_factor, least=0.0)
    (q0, p0), (q1, p1) = checked_cycle(cycle).mean_reaction(system), cycle.corner_reactions(system)
    pressed = _best_pressed(system, q0 + load_factor * q1, p0 + load_factor * p1)

    asked = _Asked(SafeSlipModel(system, cycle), load_factor, started)
    if pressed.mechanism is not None:
        nodes = sorted(set(pressed.mechanism["node"]))
        places = ", ".join(f"{x:.4g}" for x in system.x[nodes][:4]) + ", ..." * (len(nodes) > 4)
        why = f"no friction is enough: whatever slips, the loads open one of {len(nodes)} nodes (x = {places}) at some corner; press them"
        return RequiredFriction(
            friction=np.inf,
            too_little=np.inf,
            slip=frozen(np.full(system.nodes, np.nan)),
            mechanism=pressed.mechanism,
            reason=why,
            system=system,
            cycle=cycle,
            load_factor=load_factor,
            record=asked.record((), pressed.residual),
        )
    if asked.proven(0.0, True):
        slip, none = asked.safe(0.0), np.zeros(system.nodes)
        why = "none is needed: a residual slip takes all shear off every node at every corner"
        return RequiredFriction(
            friction=0.0,
            too_little=np.nan,
            slip=slip.slip,
            mechanism=_motions(system, none, none.astype(int)),
            reason=why,
            system=system,
            cycle=cycle,
            load_factor=load_factor,
            record=asked.record((slip,), slip.residual),
        )
    most = 1.0
    while not asked.proven(most, True):
        if most >= _MOST_FRICTION:
            raise SolverError(
                f"required friction: none up to {most:g} is enough, although no node need open: the best residual slip leaves a pressure of "
                f"{pressed.least:.1e} force scales at its least pressed node; press such nodes, or leave them out"
            )
        most = min(4 * most, max(2 * most, 1.01 * pressed.friction), _MOST_FRICTION)
    least = most
    while not asked.proven(least, False):
        if least < _LEAST_FRICTION:
            raise SolverError(f"required friction: {least:.0e} is enough and 0 is not; no shear load of that size matters, take it as 0")
        least /= 4
    root, step = brentq(asked.margin, least, most, rtol=1e-12, xtol=1e-300), PROVEN_FRICTION
    while not (asked.proven(root * (1 + step), True) and asked.proven(root * (1 - step), False)):
        step *= 4
        if step > WIDEST_PROOF:
            raise SolverError(
                f"required friction: about {root:g}, but rounding leaves it open on which side of it a slip is safe; check for reactions of very "
                "different sizes"
            )
    enough, too_little = asked.safe(root * (1 + step)), asked.safe(root * (1 - step))
    return RequiredFriction(
        friction=root * (1 + step),
        too_little=root * (1 - step),
        slip=enough.slip,
        mechanism=too_little.certificate,
        reason="no residual slip is safe with less: see the mechanism",
        system=system,
        cycle=cycle,
        load_factor=load_factor,
        record=asked.record((enough, too_little), max(enough.residual, too_little.residual)),
    )


class _Asked:
    """Safe slips of one load factor, by friction; each is solved for once."""

    def __init__(self, model: SafeSlipModel, load_factor: float, started: float) -> None:
        self._model, self._load_factor, self._started = model, load_factor, started
        self._found: dict[float, SafeSlip] = {}

    def safe(self, friction: float) -> SafeSlip:
        """The slip that stays furthest inside the friction bounds."""
        if friction not in self._found:
            self._found[friction] = self._model.solve(friction, self._load_factor)
        return self._found[friction]

    def margin(self, friction: float) -> float:
        """Its margin as a force: the unit of margins is the mean friction bound."""
        try:
            return self.safe(friction).margin * friction
        except SolverError:  # within rounding of the root, or of a critical friction above which slips without end are safe: the proof decides
            return 0.0

    def proven(self, friction: float, exists: bool) -> bool:
        """Whether it is proven that a safe slip exists, or that none does."""
        try:
            return self.safe(friction).exists is exists
        except SolverError:
            return False

    def record(self, proofs: tuple[SafeSlip, ...], residual: float) -> SolveRecord:
        """How an answer with these proofs was found."""
        attempts = tuple(attempt for proof in proofs for attempt in proof.record.attempts)
        left_out = proofs[0].record.left_out if proofs else ()
        return SolveRecord(proofs[0].record.solver if proofs else "HIGHS", attempts, residual, left_out, perf_counter() - self._started)


@dataclass(frozen=True, eq=False)
class _Pressed:
    """The residual slip under which the least normal reaction, over all nodes and corners, is largest.

    Attributes
    ----------
    least
        This reaction, in force scales, at most 1.
    friction
        Coefficient of friction with which the slip is safe; inf where a node carries no pressure.
    mechanism
        Why no slip presses every node; None if one does or may.
    residual
        Error of `least`, from its multipliers.
    """

    least: float
    friction: float
    mechanism: pd.DataFrame | None
    residual: float


def _best_pressed(system: ContactSystem, q: Array, p: Array) -> _Pressed:
    """For the reactions (K, N) at the corners without slip: `max t` subject to `p_k + B v >= t force` at every node and corner."""
    n, rules, lowest = system.nodes, p.argmin(axis=0), p.min(axis=0)
    force = float(np.abs(p).mean() or np.abs(q).mean()) or 1.0
    B = system.B / system.stiffness_scale
    tight = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    bounds = [(None, None)] * n + [(None, 1.0)]
    answer = linprog(np.r_[np.zeros(n), -1.0], np.column_stack([-B, np.ones(n)]), lowest / force, bounds=bounds, options=tight)
    if answer.status != 0:
        raise SolverError(
            f"required friction: which slip presses all nodes best is not found ({answer.message}); check the sizes of B and of the loads"
        )
    v, opening = answer.x[:n], np.maximum(-answer.ineqlin.marginals, 0.0)
    pressures = p / force + B @ v
    least = float(min(pressures.min(), 1.0))
    bound = float(opening @ lowest) / force + 1.0 - float(opening.sum()) + float(np.abs(opening @ B) @ np.maximum(np.abs(v), 1.0))
    residual = abs(bound - least)
    if residual > RESIDUAL:
        raise SolverError(f"required friction: which slip presses all nodes best has a residual of {residual:.1e} (tolerance {RESIDUAL:g})")
    if least < -NO_LEAST_PRESSURE:
        return _Pressed(least, np.inf, _motions(system, opening, rules), residual)
    shears = np.abs(q + system.A @ v * (force / system.stiffness_scale)) / force
    friction = float((shears / pressures).max()) if least > NO_LEAST_PRESSURE else np.inf
    return _Pressed(least, friction, None, residual)


def _motions(system: ContactSystem, opening: Array, corners: np.ndarray) -> pd.DataFrame:
    """The table of a mechanism in which nodes only open."""
    openings = np.zeros((int(corners.max()) + 1, system.nodes))
    openings[corners, np.arange(system.nodes)] = opening
    return Mechanism(0 * openings, 0 * openings, openings, np.zeros(system.nodes)).table(system)
