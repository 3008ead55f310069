"""The safe slips of a contact in the plane: friction bounds are intervals, and few corners rule their ends."""

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from .mechanism import Mechanism
from .question import LimitQuestion
from .safe_set import Rows, SafeSet, ruling

_ROWS = {"no_forward_slip": ("forward", 1.0), "no_backward_slip": ("backward", -1.0), "no_opening": ("opening", 0.0)}  # with the sense of the shear


class Intervals(SafeSet):
    """The safe slips of a contact in the plane, by the rows of the corners that rule; friction and loads are parameters, the matrices are not.

    The corners of one row differ only in the coefficient of `lam >= 0`, so the largest one rules and stands for all of them::

        q0 + A v + f (p0 + B v) >= lam forward,       forward = max_k -(q1_k + f p1_k)
        f (p0 + B v) - q0 - A v >= lam backward,      backward = max_k (q1_k - f p1_k)
                       p0 + B v >= lam opening,       opening = max_k -p1_k

    Where a part of the cycle is fixed, they differ in the constant too, and few of them rule, see `ruling`: loads are constants then. The last row
    follows from the other two where there is friction, and is left out; for little or none, it stays. A given load factor stands in the loads.
    """

    def ask(self, task: LimitQuestion, load_factor: float | None = None) -> None:
        """See `SafeSet.ask`."""
        super().ask(task, load_factor)
        lam = task.load_unit if load_factor is None else load_factor
        self._ruled, self._values = {}, {"friction": task.friction, "clearance": task.mean_bound / self.unit}
        for name, (way, sense) in _ROWS.items():
            weight = task.friction if sense else 1.0
            mean, cyclic = sense * task.q0 + weight * task.p0, sense * task.q1 + weight * task.p1
            self._ruled[name] = at = ruling(-mean, -cyclic, load_factor)
            self._values[f"{way}_mean"] = np.broadcast_to(mean, cyclic.shape)[at] / self.unit[at[1]]
            self._values[way] = -cyclic[at] * lam / self.unit[at[1]]
        (forward, _), (backward, _), _ = self._ruled.values()
        idle = len(task.q1) - len(np.union1d(forward, backward))
        self.idle = f"corners: {idle} of {len(task.q1)} rule no node" if idle else ""
        for name, value in {} if task.fixed else self._values.items():
            if name not in self.parameters:
                self.parameters[name] = cp.Parameter(len(value), name=name, nonneg=name in ("friction", "clearance"))
            self.parameters[name].value = value

    def stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None = None, spare: cp.Parameter | float = 0.0) -> Rows:
        """See `SafeSet.stuck`."""
        task, rows, given = self.task, dict[str, cp.Constraint](), self._values if self.task.fixed else self.parameters
        for name, (way, sense) in _ROWS.items():
            shear, pressure, f, clearance = self.shear, self.pressure, given["friction"], given["clearance"]
            if task.fixed:
                shear, pressure, f, clearance = (part[self._ruled[name][1]] for part in (shear, pressure, f, clearance))
            bound = cp.multiply(f, pressure) if sense else pressure
            slack = bound + given[f"{way}_mean"] + (shear if sense > 0 else -shear if sense else 0.0)
            load = given[way] if load_factor is None else given[way] * load_factor
            reserve = (0.0 if margin is None else cp.multiply(clearance, margin)) - spare
            rows |= {name: slack >= load + reserve} if sense or task.opening else {}
        return rows if task.lift is None else {**rows, **self._apart(task.lift, load_factor, margin)}

    def motion(self) -> tuple[Mechanism, Array]:
        """See `SafeSet.motion`."""
        motions = np.zeros((3, *self.task.q1.shape))
        for motion, (name, at) in zip(motions, self._ruled.items(), strict=True):
            if name in self.rows:
                motion[at] = np.maximum(self.rows[name].dual_value, 0.0) / self.unit[at[1]]
        forward, backward, opening = motions
        lift = self.task.friction * (forward + backward) + opening
        return Mechanism(forward - backward, lift, self.task.friction, *self.held()), forward + backward
