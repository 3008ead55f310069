"""The largest or least load factor at which contact forces balance one corner of a load cycle.

Forces within friction have to do the work of the loads in all rigid motions of the bodies. If no
larger load factor has such forces, the multipliers of this balance are a rigid motion that proves
it: contact forces cannot do negative work on this motion, but a larger load would need it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cvxpy as cp
import numpy as np

from ..base import CONDENSATION, ZERO_LOAD_FACTOR, Array, SolveRecord
from ..contact import contact_law
from ..solve.chain import Chain
from ..solve.problem import Problem
from . import models
from .question import Question


@dataclass(frozen=True, eq=False)
class CornerAnswer:
    """A load factor of a corner, its bound, and the motion phi (M,) of size 1 that proves it.

    The load factor is NaN if none has forces that balance the load.
    """

    corner: int
    load_factor: float
    bound: float
    phi: Array
    record: SolveRecord
    problem: cp.Problem | None

    @property
    def residual(self) -> float:
        """The largest error of both proofs."""
        return self.record.residual


class CornerProgram:
    """The program of the load factor of one corner.

    Parameters
    ----------
    question
        System and friction.
    N
        (M, m) rigid motions.
    corner, r0, r1
        Number of the corner; its reactions (M,) at load factor 0, and those that 1 adds.
    sense
        `cp.Maximize` or `cp.Minimize`.
    """

    def __init__(
        self, question: Question, N: Array, corner: int, r0: Array, r1: Array, sense: Any
    ) -> None:
        self._question = question
        self._N = N
        self._corner = corner
        self._largest = sense is cp.Maximize

        system = question.system
        friction = question.friction
        name = f"r0[{corner}]" if question.fixed else "r0"
        driven = drives(N, r1)
        load = {name: r0, f"r1[{corner}]": r1 if driven else np.zeros_like(r1)}
        f = cp.Parameter(system.nodes, nonneg=True, name="f", value=friction)
        law = contact_law(system, friction)
        listing = models.gross_slip(N, load, f, law, system.slip_shape, sense)
        self._problem = Problem(listing.objective, listing.constraints)

        variables = {variable.name(): variable for variable in self._problem.variables()}
        self._load_factor = variables["load_factor"]
        self._unit = 1.0
        if driven and drives(N, r0):
            self._unit = _load_unit(question, N, r0, r1)
        little = (friction > 0) & (friction < 1)
        shear_unit = question.node_unit * np.where(little, friction, 1.0)
        if system.tangents > 1:
            shear_unit = shear_unit[:, None]
        units = {
            self._load_factor: self._unit,
            variables["q"]: shear_unit,
            variables["p"]: question.node_unit,
        }
        self._chain = Chain(self._problem, units, unit=self._unit, defines=False)

    def solve(self) -> CornerAnswer:
        """The answer that passes the checks; SolverError if no solver gives one."""
        answer, record = self._chain.solve(self._checked, no_optimum=self._without_optimum)
        return replace(answer, record=record)

    def _checked(self) -> CornerAnswer:
        value = float(self._load_factor.value)
        if not value > ZERO_LOAD_FACTOR * self._unit:
            value = 0.0
        proof = self._chain.proof
        residual = max(proof.gap, self._chain.violation)
        # No motion needs to prove that a load factor is at least 0.
        if value == 0 and not self._largest:
            return self._without_motion(value, proof.bound, residual)
        return self._with_motion(value, proof.bound, residual)

    def _without_optimum(self) -> CornerAnswer | None:
        contradiction = self._chain.contradiction()
        if contradiction:
            return self._with_motion(np.nan, np.nan, contradiction.residual)
        growth = self._chain.growth()
        return self._without_motion(np.inf, np.inf, growth.residual) if growth else None

    def _with_motion(self, load_factor: float, bound: float, residual: float) -> CornerAnswer:
        """The answer with the motion that the multipliers of balance are.

        Its residual counts, too, how far the motion strains the bodies, and by how much it lifts
        nodes less than friction needs.
        """
        system = self._question.system
        phi = self._N @ self._problem.constraints[0].dual_value
        size = float(np.linalg.norm(phi.reshape(-1, system.nodes), axis=0).max())
        phi = phi / (size or np.nan)

        *v, w = phi.reshape(-1, system.nodes)
        # A node that shears off its surface need not rise.
        law = contact_law(system, self._question.friction)
        lack = float((law.wedging_slope * np.linalg.norm(v, axis=0) - w).max())
        stiffest = float(np.diag(system.S).max()) or 1.0
        strain = float(np.abs(system.S @ phi).max()) / stiffest
        worst = float(np.nan_to_num(np.max([residual, lack, strain]), nan=np.inf))
        return self._answer(load_factor, bound, phi, worst)

    def _without_motion(self, load_factor: float, bound: float, residual: float) -> CornerAnswer:
        return self._answer(load_factor, bound, np.zeros(len(self._N)), residual)

    def _answer(
        self, load_factor: float, bound: float, phi: Array, residual: float
    ) -> CornerAnswer:
        record = SolveRecord(residual=residual)
        return CornerAnswer(self._corner, load_factor, bound, phi, record, self._problem)


def drives(N: Array, r: Array) -> bool:
    """Whether a load r (M,) does work in the rigid motions N, by more than rounding."""
    return bool(np.linalg.norm(N.T @ r) > CONDENSATION * np.linalg.norm(r))


def _load_unit(question: Question, N: Array, r0: Array, r1: Array) -> float:
    """Load factor at which the cyclic load is as large as the mean load can hold.

    Its work in shear counts against the friction of the mean load, its work in normal motions
    against the mean load itself.
    """
    friction = min(float(question.friction.max()), 1.0) or 1.0
    shear = len(r1) - question.system.nodes
    along = float(np.linalg.norm(N[:shear].T @ r1[:shear]))
    normal = float(np.linalg.norm(N[shear:].T @ r1[shear:]))
    return friction * float(np.linalg.norm(N.T @ r0)) / (along + friction * normal)
