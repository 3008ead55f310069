"""The admissible reactions nearest to given ones in energy: a small convex program on which bounds of an increment rest."""

from dataclasses import dataclass

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from .energy_form import EnergyForm

__all__ = ["Reference", "ReferenceProblem"]

_INSIDE = 0.99  # share of the room for friction that the program uses, so that what it leaves inexact can be put right


@dataclass(frozen=True, eq=False)
class Reference:
    """Reference reactions `[q, p]`, (2N,), with their distance from admissible."""

    reaction: Array
    residual: float


class ReferenceProblem:
    """Reference reactions nearest to the trial ones in energy."""

    def __init__(self, form: EnergyForm, trial: Array, room: Array, floor: float) -> None:
        self._form, self._trial, self._room = form, trial, room
        n = form.nodes
        reaction = cp.Variable(2 * n, name="reference_reaction")
        rows = [(reaction[n:] >= floor).set_label("pressure"), (cp.abs(reaction[:n]) <= _INSIDE * room).set_label("friction")]
        if form.rigid.shape[1]:
            rows.append((form.rigid.T @ reaction == form.rigid.T @ trial).set_label("resultants"))
        energy = cp.quad_form(reaction, cp.psd_wrap(form.compliance)) / 2 - (form.compliance @ trial) @ reaction
        self.problem = cp.Problem(cp.Minimize(energy), rows)

    def refine(self) -> None:
        """Nothing: the claim is repaired already."""

    def claim(self) -> Reference:
        """The reference, put right where the solver is inexact: what is left of its distance from admissible is its residual."""
        n, rigid = self._form.nodes, self._form.rigid
        reaction = np.asarray(self.problem.variables()[0].value)
        reaction[:n] = np.clip(reaction[:n], -self._room, self._room)
        adjustable = rigid * np.r_[self._room > 0, np.ones(n, dtype=bool)][:, None]
        reaction = reaction + adjustable @ np.linalg.pinv(rigid.T @ adjustable) @ (rigid.T @ (self._trial - reaction))
        reaction[n:] = np.maximum(reaction[n:], 0.0)
        off = np.abs(rigid.T @ (self._trial - reaction)).max(initial=0.0)
        return Reference(reaction, float(max(off, (np.abs(reaction[:n]) - self._room).max())))
