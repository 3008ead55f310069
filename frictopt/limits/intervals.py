"""The safe slips of a contact in the plane: friction bounds are intervals, and few corners rule their ends."""

import cvxpy as cp
import numpy as np

from ..contact.checks import Array
from .design_loads import DesignLoads
from .mechanism import Mechanism
from .question import LimitQuestion
from .safe_set import Rows, SafeSet, ruling


class Intervals(SafeSet):
    """The safe slips of a contact in the plane, by the rows of the corners that rule; friction and loads are parameters, the matrices are not.

    The corners of one row differ only in the coefficient of `lam >= 0`, so the largest one rules and stands for all of them::

        forward = max_k -(q1_k + f p1_k),   backward = max_k (q1_k - f p1_k),   opening = max_k -p1_k

    Where a part of the cycle is fixed, they differ in the constant too, and few of them rule, see `ruling`: loads are constants then. `p >= 0`
    follows from the other two where there is friction; for little or none, `no_opening` keeps its rows.

    Attributes
    ----------
    q, p, fp
        (N,) shear force q0 + A v, normal force p0 + B v and friction bound f (p0 + B v) of the nodes under the mean load, with what a design adds,
        cvxpy expressions.
    forward, backward, opening
        (N,) cyclic load at the corners that rule the rows, in the units of the nodes.
    """

    def __init__(self, task: LimitQuestion, design: DesignLoads | None = None) -> None:
        super().__init__(task, design)
        n, pressed = len(task.friction), self.pressure
        self._set = {name: cp.Parameter(n, name=name) for name in ("q_mean", "p_mean", "fp_mean", "forward", "backward", "opening")}
        self._set |= {name: cp.Parameter(n, name=name, nonneg=True) for name in ("friction", "clearance")}
        self.q, self.p = self._set["q_mean"] + self.shear, self._set["p_mean"] + pressed
        self.fp = self._set["fp_mean"] + cp.multiply(self._set["friction"], pressed)
        self.forward, self.backward, self.opening = (self._set[name] for name in ("forward", "backward", "opening"))

    def stuck(self, load_factor: cp.Variable | None, margin: cp.Variable | None = None, spare: cp.Parameter | float = 0.0) -> Rows:
        """See `SafeSet.stuck`. A given load factor stands in the parameters."""
        task = self.task
        apart = self._apart(load_factor, margin)
        if task.fixed:
            return {**self._of_corners(load_factor, margin), **apart}
        lam, reserve = 1.0 if load_factor is None else load_factor, (0.0 if margin is None else cp.multiply(self._set["clearance"], margin)) - spare
        rows = {
            "no_forward_slip": self.q + self.fp >= self.forward * lam + reserve,
            "no_backward_slip": self.fp - self.q >= self.backward * lam + reserve,
        }
        opening = {"no_opening": self.p >= self.opening * lam + reserve} if task.opening else {}
        return {**rows, **opening, **apart}

    def _of_corners(self, load_factor: cp.Variable | None, margin: cp.Variable | None) -> Rows:
        """The rows of a cycle of which a part is fixed."""
        task, unit, shear, pressed = self.task, self.unit, self.shear, self.pressure
        lam = self._given if load_factor is None else task.load_unit * load_factor
        rows: dict[str, cp.Constraint] = {}
        for (name, (sense, weight, constant, rate)), at in zip(_slacks(task).items(), self._ruling, strict=True):
            node, reserve = at[1], 0.0 if margin is None else task.mean_bound / unit[at[1]] * margin
            slack = sense * shear[node] + cp.multiply(weight[node], pressed[node]) + constant[at] / unit[node] + lam * (rate[at] / unit[node])
            rows |= {name: slack >= reserve} if task.opening or name != "no_opening" else {}
        return rows

    def ask(self, task: LimitQuestion, load_factor: float | None = None) -> None:
        """See `SafeSet.ask`."""
        super().ask(task, load_factor)
        if task.fixed:
            self._ruling = tuple(ruling(-constant, -rate, load_factor) for *_, constant, rate in _slacks(task).values())
            return
        (q0,), (p0,), f = task.q0, task.p0, task.friction
        ruled = {"forward": -(task.q1 + f * task.p1), "backward": task.q1 - f * task.p1, "opening": -task.p1}
        self._ruling = tuple(ruling(task.p0, load) for load in ruled.values())
        forces = {"q_mean": q0, "p_mean": p0, "fp_mean": f * p0, "clearance": np.full_like(p0, task.mean_bound)}
        forces |= {name: load.max(axis=0) * (task.load_unit if load_factor is None else load_factor) for name, load in ruled.items()}
        self._set["friction"].value = f
        for name, force in forces.items():
            self._set[name].value = force / self.unit

    def motion(self) -> tuple[Mechanism, float]:
        """See `SafeSet.motion`."""
        task, motions = self.task, np.zeros((3, *self.task.q1.shape))
        for motion, name, (corner, node) in zip(motions, ("no_forward_slip", "no_backward_slip", "no_opening"), self._ruling, strict=True):
            if name in self.rows:
                motion[corner, node] = np.maximum(self.rows[name].dual_value, 0.0) / self.unit[node]
        forward, backward, opening = motions
        lift = task.friction * (forward + backward) + opening
        return Mechanism(forward - backward, lift, task.friction, self.held, self.pressed), float(motions.sum())

    @property
    def narrows(self) -> bool:
        """See `SafeSet.narrows`."""
        names = ("forward", "backward", *(["opening"] if self.task.opening else []))
        if self.task.fixed:
            return False
        return all((self._set[name].value >= 0).all() for name in names) and bool((self.task.w1.min(axis=0) <= 0).all())

    @property
    def idle(self) -> str:
        """See `SafeSet.idle`."""
        corners = len(self.task.q1)
        idle = corners - len(np.union1d(*(corner for corner, _ in self._ruling[:2])))
        return f"corners: {idle} of {corners} rule no node" if idle else ""


def _slacks(task: LimitQuestion) -> dict[str, tuple[float, Array, Array, Array]]:
    """Slacks `sense q + weight p` of the rows of all corners: sense, weight (N,), and the slack (K, N) at load factor 0 and its rate."""
    f = task.friction
    kinds = {"no_forward_slip": (1.0, f), "no_backward_slip": (-1.0, f), "no_opening": (0.0, np.ones_like(f))}
    return {name: (sense, weight, sense * task.q0 + weight * task.p0, sense * task.q1 + weight * task.p1) for name, (sense, weight) in kinds.items()}
