"""Bounds that every state after an increment obeys, from the energy that the increment can release.

Let `u = [dv, w]` and `r = trial + S u` obey the contact law. Multiplied by u it says `u' S u + trial' u + sum f p |dv| = 0`. Take any reference
reactions `r^ = [q^, p^]` with `p^ >= 0`, in equilibrium with the trial ones (the same resultants on every rigid motion) and with friction that p can
hold, `|q^| <= f p` (for which a lower bound of p is enough). Their work on u is at least `p^' w - sum |q^| |dv|`, so with `b = trial - r^`::

    u' S u + b' u + p^' w + sum (f p - |q^|) |dv| <= 0

Every term behind `b' u` is >= 0. So u lies in the ellipsoid `u' S u + b' u <= 0`, which bounds each reaction and, up to rigid motions, each slip and
gap; and with the energy `E = b' S^+ b / 4` that the first two terms can give at most, `p^_i w_i <= E` and `sum (f p - |q^|) |dv| <= E` bound the
rigid motions. The reference is chosen for a small ellipsoid by a quadratic program; bounds of p so found make room for q^, and the choice is
repeated.
Nothing here assumes small friction or a unique state.

Where a body that is free to slide carries a tangential resultant, `q = e + tau p` with tau the ratio of the resultants: the same steps hold for
`[e, p]`, whose matrix `H` is the symmetric part of S with its first rows less tau times its last ones, and friction `f - |tau|`.
"""

from dataclasses import dataclass

import numpy as np

from ..contact.checks import Array
from ..errors import NoContinuation, SolverError
from ..solve.solvers import Kind, NoOptimum, solve
from .balance import shortfall
from .energy_form import EnergyForm
from .increment import Law, PosedIncrement
from .reference_reaction import ReferenceProblem

__all__ = ["Bounds", "EnergyBounds"]

_ROUNDS = 6
_GAIN = 1.01  # a round that does not raise the least pressures by this factor is the last
_KEPT = 0.1  # share of the friction that a pressure guarantees which the reference leaves, to bound rigid sliding
_FLOORS = 0.02, 1e-3  # least reference pressure where gaps have no other bound, in mean normal forces
_MOST = 1e6  # larger dimensionless bounds are of no use to a solver whose booleans are exact to 1e-9
_LEAST = 1e-6  # dimensionless forces count from this amount on
_NO_SHEAR = 1e-12  # a shear of the whole body below this share of its pressure is rounding
_PAD = 1e-3  # bounds are widened by this share and by this dimensionless amount: above rounding, and no tiny coefficients for the solver


@dataclass(frozen=True, eq=False)
class Bounds:
    """Bounds of every state after one increment, dimensionless.

    Attributes
    ----------
    slip_low, slip_high
        (N,) slip increment.
    gap_high
        (N,) total gap (its lower bound is 0).
    pressure_low, pressure_high
        (N,) normal reaction.
    forward_high, backward_high
        (N,) distances `f p + q` and `f p - q` from forward and backward slip (their lower bound is 0).
    """

    slip_low: Array
    slip_high: Array
    gap_high: Array
    pressure_low: Array
    pressure_high: Array
    forward_high: Array
    backward_high: Array

    def __and__(self, other: "Bounds") -> "Bounds":
        """What both say."""
        names = list(self.__dataclass_fields__)
        return Bounds(*((np.maximum if name.endswith("low") else np.minimum)(getattr(self, name), getattr(other, name)) for name in names))

    @property
    def widened(self) -> "Bounds":
        """The same, with room for rounding."""
        sides = {name: -1.0 if name.endswith("low") else 1.0 for name in self.__dataclass_fields__}
        values = {name: getattr(self, name) for name in sides}
        return Bounds(*(values[name] + side * _PAD * (1 + np.abs(values[name])) for name, side in sides.items()))


class EnergyBounds:
    """The bounds of all increments of one contact with one friction.

    Parameters
    ----------
    law
        Stiffness and friction.
    """

    def __init__(self, law: Law) -> None:
        self._law = law
        self._plain = EnergyForm(law.S, law.S)

    def of(self, posed: PosedIncrement) -> Bounds:
        """Bounds of every state after the increment.

        Raises
        ------
        NoContinuation
            No reactions that obey the law balance the load.
        SolverError
            The energy does not bound the motion: nothing may hold the body.
        """
        try:
            return self._derived(posed)
        except SolverError:
            off = shortfall(self._plain.rigid, posed.trial, self._law.friction)
            if off <= _LEAST:
                raise
        raise NoContinuation(
            f"friction increment: no state obeys the law under this load, which exceeds by {off:.3g} mean normal forces what pressures >= 0 and "
            "friction can balance; the body slides, tips or lifts as a whole: take smaller loads, more friction, or hold it by a support"
        )

    def _derived(self, posed: PosedIncrement) -> Bounds:
        n = self._law.nodes
        ratio = self._ratio(posed)
        form = self._plain if ratio == 0 else self._tilted(ratio)
        trial = np.r_[posed.trial[:n] - ratio * posed.trial[n:], posed.trial[n:]]
        friction = self._law.friction - abs(ratio)
        if friction.min() < 0:
            raise SolverError(_unbounded(f"the body may slide as a whole, and its shear is {abs(ratio):.3g} of its pressure"))
        least, bounds = np.zeros(n), None
        for _ in range(_ROUNDS):
            room = (1 - _KEPT) * friction * least
            room[room < _LEAST] = 0.0
            reference = self._reference(form, trial, room)
            found = self._around(form, posed, trial - reference, reference[n:], _KEPT * friction, least)
            bounds = found if bounds is None else bounds & found
            before, least = least, np.maximum(bounds.pressure_low, 0.0)
            if least.sum() <= _GAIN * before.sum() or friction.max() <= 0:
                break
        if bounds is None or not max(bounds.gap_high.max(), bounds.slip_high.max(), -bounds.slip_low.min()) < _MOST:
            raise SolverError(_unbounded("friction may not keep the body from sliding as a whole"))
        return bounds.widened

    def _ratio(self, posed: PosedIncrement) -> float:
        """Ratio of the resultants on rigid sliding, 0 where there is no such motion or no such force."""
        sliding = self._plain.sliding
        if sliding.shape[1] != 1:
            return 0.0
        q, p = np.split(posed.trial, 2)
        shear, weight = float(sliding[:, 0] @ q), float(sliding[:, 0] @ p)
        return shear / weight if abs(shear) > _NO_SHEAR * abs(weight) else 0.0

    def _tilted(self, ratio: float) -> EnergyForm:
        n, S = self._law.nodes, self._law.S
        tilted = np.vstack([S[:n] - ratio * S[n:], S[n:]])
        form = EnergyForm((tilted + tilted.T) / 2, S)
        if form.least < 0 or form.rigid.shape != self._plain.rigid.shape:
            raise SolverError(_unbounded(f"the body may slide as a whole, and its shear is {abs(ratio):.3g} of its pressure"))
        return form

    def _reference(self, form: EnergyForm, trial: Array, room: Array) -> Array:
        """Reference reactions of a small ellipsoid."""
        for floor in _FLOORS if form.lifting else (0.0,):
            model = ReferenceProblem(form, trial, room, floor)
            try:
                return solve(model, model.claim, "CLARABEL", kind=Kind.QP).claim.reaction
            except NoOptimum:
                continue
        raise SolverError(_unbounded("the load may tip the body over an end of the contact, or there is no state at all"))

    def _around(self, form: EnergyForm, posed: PosedIncrement, b: Array, pressure: Array, kept: Array, least: Array) -> Bounds:
        """Bounds from one reference: its ellipsoid, and what the energy allows."""
        n, f = self._law.nodes, self._law.friction
        centre, energy = -form.compliance @ b / 2, max(float(b @ form.compliance @ b) / 4, 0.0)
        motion = np.sqrt(energy * np.diag(form.compliance))
        low, high = centre - motion, centre + motion
        with np.errstate(divide="ignore", invalid="ignore"):
            by_work = np.where(pressure > 0, energy / pressure, np.inf)
            by_friction = np.where(kept * least > 0, energy / (kept * least), np.inf)
        gap = by_work if form.lifting else np.minimum(by_work, np.maximum(high[n:], 0.0))
        rolling = form.rolling(np.maximum(np.abs(high[n:]), np.abs(gap - low[n:])))
        slip = np.maximum(np.abs(low[:n]), np.abs(high[:n])) + rolling
        total = form.range_of(np.r_[np.zeros(n), np.ones(n)], posed.trial, centre, energy)[0]
        whole = _whole_slip(form.sliding, slip, energy, kept, least, max(total, least.sum()))
        one = np.eye(n)
        p = form.range_of(np.hstack([0 * one, one]), posed.trial, centre, energy)
        forward, backward = (form.range_of(np.hstack([side * one, np.diag(f)]), posed.trial, centre, energy)[1] for side in (1, -1))
        return Bounds(
            slip_low=np.maximum(low[:n] - rolling - whole, -by_friction),
            slip_high=np.minimum(high[:n] + rolling + whole, by_friction),
            gap_high=gap,
            pressure_low=p[0],
            pressure_high=p[1],
            forward_high=forward,
            backward_high=backward,
        )


def _whole_slip(sliding: Array, slip: Array, energy: float, kept: Array, least: Array, total: float) -> Array:
    """Largest slip of each node by rigid sliding, from the work that friction does against it."""
    if sliding.shape[1] == 0:
        return np.zeros(len(slip))
    if sliding.shape[1] > 1:
        return np.full(len(slip), np.inf)
    way = np.abs(sliding[:, 0])
    with np.errstate(divide="ignore", invalid="ignore"):
        by_total = (slip / way).max() + energy / np.maximum((kept * way).min() * total, 0.0)
        by_node = (energy + (kept * least) @ slip) / ((kept * least) @ way)
    return np.asarray(way * np.fmin(by_total, by_node))


def _unbounded(why: str) -> str:
    return (
        f"mixed-integer increment: no bound on the motion can be derived, {why}; hold the body by a support or take smaller loads, "
        "or use a FrozenBoundIncrement, which needs no bounds"
    )
