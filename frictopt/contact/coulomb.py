"""Coulomb's law: friction coefficients, the residual of a state (Flicek et al. 2015, section 2), and states from which a transient may go on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..base import (
    CONDENSATION,
    Array,
    Booleans,
    Kept,
    Table,
    check_entries,
    components,
    finite_array,
    finite_number,
    frame,
    real_array,
    shown,
    warns_of_odd_values,
    whole_number,
)
from ..base.checks import per_node
from ..errors import ModelError
from .parts import joined
from .system import ContactSystem, checked_system


def friction_coefficients(friction: ArrayLike, nodes: int) -> Array:
    """Check a friction coefficient, one for all nodes or one per node, and return it as (N,).

    ModelError if it is not a real finite number or array, negative, or of a length other than 1 and
    N.

    Examples
    --------
    >>> from frictopt.contact import friction_coefficients
    >>> friction_coefficients(0.5, nodes=3).tolist()
    [0.5, 0.5, 0.5]
    """
    return per_node("friction", friction, nodes, "a coefficient of friction is not negative")


@dataclass(frozen=True, repr=False)
class Verdict(Kept):
    """Largest violation of each equation of the contact law, dimensionless; a state that obeys the law exactly has 0.

    Attributes
    ----------
    equilibrium, bound
        `|r - r^w - S u|` and `|q| - f p`, or `|q|` less the shear strength, in units of the mean
        normal force.
    contact
        Tension `-p`, overlap `-w`, and contact force across an open gap (the smaller of p and w),
        forces in units of the mean normal force and lengths in units of the slip scale.
    direction
        Friction that does not oppose the slip since the previous state: the least change of that
        slip, of q, or of both that makes q lie on the bound and oppose it. A slip of at most 1e-10
        of the largest motion of the state is rounding and counts as none.

    Examples
    --------
    >>> import frictopt as fo
    >>> verdict = fo.results.Verdict(equilibrium=1e-15, contact=0.0, bound=0.2, direction=0.0)
    >>> verdict.residual
    0.2
    """

    equilibrium: float
    contact: float
    bound: float
    direction: float

    @property
    def residual(self) -> float:
        """The largest of the four violations; inf if any of them is NaN."""
        worst = max(
            self.equilibrium,
            self.contact,
            self.bound,
            self.direction,
            key=lambda value: np.inf if np.isnan(value) else value,
        )
        return float(np.inf if np.isnan(worst) else worst)

    def _answer(self) -> Mapping[str, object]:
        return {"residual": self.residual, **vars(self)}


@warns_of_odd_values
def referee(
    system: ContactSystem,
    bonded: tuple[ArrayLike, ArrayLike],
    friction: ArrayLike,
    *,
    v: ArrayLike,
    w: ArrayLike,
    q: ArrayLike,
    p: ArrayLike,
    previous_slip: ArrayLike | None = None,
    force_scale: float | None = None,
) -> Verdict:
    """Compute the residual of a state, or of T states at once, in every equation of the contact law. Theory, eq. (4).

    Parameters
    ----------
    system, friction
        The contact and its coefficient of friction, one or one per node.
    bonded
        `(q^w, p^w)`, bonded reactions of the load of that state: q (N,) in the plane and (N, 2) in
        space, p (N,); or with T in front. Force.
    v, w, q, p
        Slip, gap and reactions of the state, in the shapes of `bonded`; `w` includes the initial
        gap.
    previous_slip
        Slip at the previous state; None: the slip has not changed.
    force_scale
        Unit of the forces, by default the mean of `abs(p^w)`; over `system.stiffness_scale` it is
        that of the slips.

    Raises
    ------
    ModelError
        Bad friction or arrays that do not match the system.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> bonded = node.reaction({"P": 1.0, "Q": 0.8})
    >>> fo.reference.referee(node, bonded, 0.5, v=[0.0], w=[0.0], q=[0.8], p=[1.0])  # stuck beyond its bound
    Verdict(residual=0.3, equilibrium=0, contact=0, bound=0.3, direction=0)
    >>> fo.reference.referee(node, bonded, 0.5, v=[-0.3], w=[0.0], q=[0.5], p=[1.0]).residual < 1e-12
    True
    """
    f = friction_coefficients(friction, checked_system(system).nodes)
    if not isinstance(bonded, tuple | list) or len(bonded) != 2:
        raise ModelError(f"bonded: a {type(bonded).__name__}; give the pair (q^w, p^w)")
    along = {
        "bonded q": bonded[0],
        "v": v,
        "q": q,
        "previous_slip": v if previous_slip is None else previous_slip,
    }
    across = {"bonded p": bonded[1], "w": w, "p": p}
    qw, v, q, before = (_states(name, value, system.slip_shape) for name, value in along.items())
    pw, w, p = (_states(name, value, (system.nodes,)) for name, value in across.items())
    counts = sorted({len(part) for part in (qw, v, q, before, pw, w, p)} - {1})
    if len(counts) > 1:
        raise ModelError(
            f"states: arrays of {counts} states; give all for the same number of states, or one for all"
        )
    if force_scale is not None:
        force = finite_number("force_scale", force_scale, above=0.0)
    else:
        force = float(np.abs(pw).mean()) or float(max(np.abs(qw).max(), np.abs(q).max())) or 1.0
    size = (*counts, 1)[:1]
    loads, u, r, u_before = (
        joined(
            np.broadcast_to(shear, size + shear.shape[1:]),
            np.broadcast_to(normal, size + normal.shape[1:]),
        )
        for shear, normal in ((qw, pw), (v, w - system.gap), (q, p), (before, w))
    )
    return Verdict(*off_law(system, f, loads, u, r, force, u_before).tolist())


def off_law(
    system: ContactSystem,
    f: Array,
    bonded: Array,
    u: Array,
    r: Array,
    force: float,
    before: Array | None = None,
) -> Array:
    """(4,) largest violations of the law, those of a `Verdict`, by states `u = [v, w - g0]`, (..., M), their loads and reactions; NaN if not finite.

    Without the states `before` the slips have not changed. Friction that does not oppose the slip
    counts by the smallest of three changes: no slip, q on the bound that opposes the slip, or the
    slip without its part across q, and q on the bound. The third one is for small slips in space,
    whose direction rounding turns.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        length, shape = force / system.stiffness_scale, (-1, system.tangents + 1, system.nodes)
        unbalanced = np.abs(r - bonded - u @ system.S) / force
        moved = (np.zeros_like(u) if before is None else (u - before) / length).reshape(shape)[
            :, :-1
        ]
        u, r = (u / length).reshape(shape), (r / force).reshape(shape)
        q, p, w = r[:, :-1], r[:, -1], u[:, -1] + system.gap / length
        slid, size, bound = (
            np.linalg.norm(moved, axis=1),
            np.linalg.norm(q, axis=1),
            np.minimum(f * p, system.shear_strength / force),
        )
        sense, pull = (
            part / np.where(by > 0, by, 1.0)[:, None] for part, by in ((moved, slid), (q, size))
        )
        turned = np.linalg.norm(q + bound[:, None] * sense, axis=1)
        across = np.linalg.norm(
            moved - np.minimum((moved * pull).sum(axis=1), 0.0)[:, None] * pull, axis=1
        )
        rounding = (
            CONDENSATION * np.abs(u).max(axis=(1, 2), initial=0.0)[:, None]
        )  # of slips: a share of the motions
        slid, across = (np.where(way <= rounding, 0.0, way) for way in (slid, across))
        contact, over = np.maximum(np.maximum(-p, -w), np.minimum(p, w)), size - bound
        lines = (
            unbalanced,
            contact,
            over,
            np.minimum(np.minimum(slid, turned), np.maximum(across, np.abs(over))),
        )
        return np.array([np.max(line, initial=0.0) for line in lines])


def most_shear(system: ContactSystem, f: Array, p: Array) -> Array:
    """(..., N) largest size of the shear force under normal forces p (..., N): what friction holds, up to the strength of the surface."""
    return np.minimum(f * p, system.shear_strength)


def lengths(q: Array, p: Array) -> Array:
    """(..., N) lengths of shear forces or slips, (..., N) or (..., N, 2); p are normal ones, (..., N)."""
    return np.abs(q) if q.ndim == p.ndim else np.asarray(np.linalg.norm(q, axis=-1))


def reach(q0: Array, g0: Array, q1: Array, g1: Array) -> Array:
    """Largest lam with `|q0 + lam q1| <= g0 + lam g1`, q (..., 2), g (...,), inf where there is none; the nearest where no lam obeys it."""
    a, b, c = (
        (q1**2).sum(axis=-1) - g1**2,
        (q0 * q1).sum(axis=-1) - g0 * g1,
        g0**2 - (q0**2).sum(axis=-1),
    )  # a lam^2 + 2 b lam <= c
    root = np.sqrt(np.maximum(b**2 + a * c, 0.0))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        apex = np.where(
            g1 < 0, g0 / -g1, np.inf
        )  # where the way is along the cone, or begins at its apex
        last = np.where(
            b > 0, c / (b + root), np.where(a > 0, (root - b) / a, apex)
        )  # each without cancellation
    return np.where(g1 >= np.linalg.norm(q1, axis=-1), np.inf, last)


def _states(name: str, value: object, shape: tuple[int, ...]) -> Array:
    array = real_array(name, value)
    if (
        array.ndim not in (len(shape), len(shape) + 1)
        or array.shape[-len(shape) :] != shape
        or not array.size
    ):
        raise ModelError(f"{name}: shape {array.shape}; give {shape} or (states, {str(shape)[1:]}")
    return array.reshape(-1, *shape)


@dataclass(frozen=True, eq=False, repr=False)
class ContactState(Kept):
    """Slip and gap of all nodes under a load: all that the future of a quasi-static contact depends on.

    Nodes may be open. The reactions follow from the system, so the state fits the system and the
    friction that it was computed with.

    Parameters
    ----------
    slip, gap
        Slip v, (N,) along +x in the plane, (N, 2) along the tangents in space, and (N,) gap w
        (initial gap included, >= 0), length.
    bonded_q, bonded_p
        Bonded reactions of the load, as `ContactSystem.reaction` gives them, in the shape of `slip`
        and (N,): force per depth, in space force.
    next_corner, next_loads
        Number of the corner that the load goes to next, in a straight line; and its name, see
        `LoadCycle.corner_names`; None: its number.

    Raises
    ------
    ModelError
        Arrays of different lengths, entries not finite, a negative gap, or a corner that is no
        whole number >= 0.

    Examples
    --------
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    >>> before = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    >>> before.state
    ContactState(nodes=4, open=0, next_corner='force = +1')
    >>> fo.steady_state(rod, cycle, friction=0.5, load_factor=0.4, initial_state=before.state).outcome.name
    'SHAKEDOWN'
    """

    slip: Array
    gap: Array
    bonded_q: Array
    bonded_p: Array
    next_corner: int = 0
    next_loads: str | None = None

    def __post_init__(self) -> None:
        slip = finite_array(
            "slip", self.slip, (None,) if real_array("slip", self.slip).ndim < 2 else (None, 2)
        )
        shapes = {"gap": slip.shape[:1], "bonded_q": slip.shape, "bonded_p": slip.shape[:1]}
        arrays = {
            name: finite_array(name, getattr(self, name), shape) for name, shape in shapes.items()
        }
        if not len(slip):
            raise ModelError("slip: no nodes; a state has at least one")
        check_entries(
            "gap", arrays["gap"], arrays["gap"] >= 0, "the bodies cannot overlap, give gap >= 0"
        )
        corner = whole_number("next_corner", self.next_corner, least=0)
        if self.next_loads is not None and not isinstance(self.next_loads, str):
            raise ModelError(
                f"next_loads: {shown(self.next_loads)} is no text; give the loads of the corner as LoadCycle.corner_names writes them"
            )
        vars(self).update(slip=slip, **arrays, next_corner=corner)

    @property
    def open(self) -> Booleans:
        """(N,) which nodes have a gap."""
        return self.gap > 0

    def to_frame(self) -> Table:
        """The DataFrame of the nodes: columns node, slip (in space slip1, slip2), gap."""
        return frame(
            {"node": range(len(self.slip)), **components("slip", self.slip), "gap": self.gap}
        )

    def _answer(self) -> Mapping[str, object]:
        corner = self.next_corner if self.next_loads is None else repr(self.next_loads)
        return {"nodes": len(self.slip), "open": int(self.open.sum()), "next_corner": corner}


def checked_state(name: str, state: object, system: ContactSystem, corners: int) -> ContactState:
    """Check that `state` is a state of a contact under a load cycle of K corners."""
    if not isinstance(state, ContactState):
        raise ModelError(
            f"{name}: a {type(state).__name__}; give a ContactState, as `.state` of a steady state or `.state_at(...)` of a trajectory"
        )
    if state.slip.shape != system.slip_shape:
        raise ModelError(
            f"{name}: its slip has the shape {state.slip.shape}, that of the contact {system.slip_shape}; give a state of this contact"
        )
    if state.next_corner >= corners:
        called = f" ({state.next_loads})" if state.next_loads else ""
        raise ModelError(
            f"{name}: its next corner is {state.next_corner}{called}, the load cycle has the corners 0 to {corners - 1}"
        )
    return state
