"""Plane contacts embedded in space: both contacts must have the same answers."""

import re
from collections.abc import Callable
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

import frictopt as fo
from frictopt.transients.increments import NewtonIncrement
from studies.validation.fuzz.cases import random_case
from studies.validation.fuzz.known import Missed, NotApplicable, Subject, Wrong, same
from studies.validation.fuzz.searches import EVERY

T = TypeVar("T")
# The residual of an answer, and whether it was compared.
Answered = tuple[float, bool]

_SAME = 1e-7
# Relative distance between the two bounds that prove the required friction.
_FRICTION_PROVEN = 2e-5
# Relative distance of the two polygons of a region.
_APART = 0.01
# One case in this many has a steady state.
_EVERY = 8
# Largest friction of increments. With more friction, several states may obey the contact law.
_FRICTION = 0.5


def embedded(
    flat: fo.ContactSystem, rng: np.random.Generator, across: Any = None
) -> tuple[fo.ContactSystem, Any]:
    """A plane contact in space, and the unit vectors (N, 2) along which the plane slips.

    The tangents of each node are turned by a random angle. Across the plane the contact has the
    stiffness `across` (N, N) and no load, so slips across the plane do not change the answers. By
    default the stiffness holds some, all or none of the motions across. If the contact is
    uncoupled, it holds all.
    """
    n = flat.nodes
    none = np.zeros((n, n))
    if across is None:
        # If loads alone open nodes, a body that slides freely across would lift off.
        held = n if not flat.B.any() else int(rng.integers(0, n + 1))
        G = rng.normal(size=(n, held))
        across = float(np.diag(flat.A).mean()) * G @ G.T
    S = np.block([[flat.A, none, flat.B.T], [none, across, none], [flat.B, none, flat.C]])
    along = np.exp(1j * rng.uniform(0, 2 * np.pi, n))
    c, s = np.diag(along.real), np.diag(along.imag)
    turn = np.block([[c, -s, none], [s, c, none], [none, none, np.eye(n)]])
    bonded = {name: turn @ np.r_[q, np.zeros(n), p] for name, (q, p) in flat.bonded.items()}
    points = np.column_stack([flat.x, np.zeros((n, 2))])
    solid = fo.ContactSystem(turn @ S @ turn.T, points, bonded, gap=flat.gap)
    return solid, np.column_stack([along.real, along.imag])


class Embedded(Subject):
    """A random plane case, and the same contact in space."""

    none = 0.0

    def __init__(self, seed: int) -> None:
        super().__init__(random_case(seed))
        self.rng = np.random.default_rng(seed)
        self.solid, self.along = embedded(self.case.system, self.rng)

    @cached_property
    def answered_limit(self) -> fo.results.ShakedownLimit:
        """The limit of the plane contact."""
        return in_plane(fo.shakedown_limit, *self.args)

    @cached_property
    def limit_in_space(self) -> fo.results.ShakedownLimit:
        """The limit of the contact in space."""
        return fo.shakedown_limit(self.solid, *self.args[1:])


def in_plane(question: Callable[..., T], *arguments: Any, **options: Any) -> T:
    """The answer of the plane contact; NotApplicable if it has no answer."""
    try:
        return question(*arguments, **options)
    except fo.FrictoptError as error:
        raise NotApplicable from error


def limit(subject: Embedded) -> Answered:
    """Compare the limits; if the open nodes differ, also for the open nodes of the plane."""
    plane, solid = subject.answered_limit, subject.limit_in_space
    # NaN: with the open nodes of the answer, no load factor is safe.
    if not solid.load_factor >= plane.load_factor and (solid.open != plane.open).any():
        opened = fo.shakedown_limit(subject.solid, *subject.args[1:], open_nodes=plane.open)
        same("load_factor is", opened.load_factor, plane.load_factor, _SAME, _SAME)
        raise Missed(f"{plane.load_factor!r} with {plane.open} open is above {solid.load_factor!r}")
    for name in ("load_factor", "least"):
        same(f"{name} is", getattr(solid, name), getattr(plane, name), _SAME, _SAME)
    return solid.residual, True


def guaranteed_limit(subject: Embedded) -> Answered:
    """Compare the guaranteed limits, if both searches find the same open nodes."""
    if (subject.limit_in_space.open != subject.answered_limit.open).any():
        raise NotApplicable
    plane = in_plane(fo.guaranteed_limit, *subject.args)
    solid = fo.guaranteed_limit(subject.solid, *subject.args[1:])
    same("load_factor is", solid.load_factor, plane.load_factor, _SAME, _SAME)
    return solid.residual, True


def safe_slip(subject: Embedded) -> Answered:
    """Compare whether a slip is safe, and its margin.

    If no slip is safe, the margins are not compared: one contact may be proven to have no state of
    rest for all openings and closings, the other one with all nodes closed.
    """
    arguments = *subject.args[1:], subject.load_factor
    plane = in_plane(fo.safe_slip, subject.case.system, *arguments)
    solid = fo.safe_slip(subject.solid, *arguments)
    if plane.exists and not solid.exists and (plane.open != solid.open).any():
        raise Missed(f"with {plane.open} open a slip is safe; {solid.reason}")
    if plane.exists != solid.exists:
        raise Wrong(f"{solid.reason}; in the plane {plane.reason}")
    if not plane.exists:
        return solid.residual, False
    same("margin is", solid.margin, plane.margin, _SAME, _SAME)
    return solid.residual, True


def required_friction(subject: Embedded) -> Answered:
    """Compare the required friction at the load factor of the case."""
    if subject.case.seed % EVERY:
        raise NotApplicable
    arguments = subject.case.cycle, subject.load_factor
    plane = in_plane(fo.required_friction, subject.case.system, *arguments)
    solid = fo.required_friction(subject.solid, *arguments)
    if solid.required > plane.required and (solid.open != plane.open).any():
        raise Missed(f"{plane.required!r} with {plane.open} open is below {solid.required!r}")
    same("required is", solid.required, plane.required, _FRICTION_PROVEN)
    return solid.residual, True


def _open_nodes(reason: str) -> str:
    """The words of a reason that count the open nodes; empty if all nodes are closed."""
    match = re.match(r"with \d+ of \d+ nodes open", reason)
    return match[0] if match else ""


def safe_region(subject: Embedded) -> Answered:
    """Compare the polygon of the plane with the inner and the outer polygon in space.

    The polygon of the plane must lie between the two, if the same nodes stay open.
    """
    case = subject.case
    if case.seed % EVERY:
        raise NotApplicable
    arguments = {"mean": 1.0}, ["a", "b"], case.friction
    plane = in_plane(fo.safe_region, case.system, *arguments)
    solid = fo.safe_region(subject.solid, *arguments, tolerance=_APART)
    if _open_nodes(solid.reason) != _open_nodes(plane.reason):
        # Regions hold for one set of open nodes, and two sets may have equal limits.
        return solid.residual, False
    exists_alike = (len(solid.vertices) > 0) == (len(plane.vertices) > 0)
    if not exists_alike or solid.unlimited != plane.unlimited:
        raise Wrong(f"{solid.reason}; in the plane {plane.reason}")
    for name, points, region, share in (
        ("safe point", solid.vertices, plane, 1 - _SAME),
        ("vertex", plane.vertices, solid, 1 - _APART - _SAME),
    ):
        for first, second in points[np.isfinite(points).all(axis=1)]:
            if not region.contains(share * first, share * second):
                raise Wrong(
                    f"the {name} ({first:.9g}, {second:.9g}) is not safe in the other contact"
                )
    return solid.residual, True


def least_slip(subject: Embedded) -> Answered:
    """Compare the proven sums of the weighted slips.

    The mechanism of each limit proves its sum, so the two sums may differ by the gap of the limit
    in space.
    """
    limit = subject.limit_in_space
    if not subject.finite or (limit.open != subject.answered_limit.open).any():
        raise NotApplicable
    factor = 1.5 * subject.answered_limit.load_factor
    solid = limit.least_slip(factor)
    plane = subject.answered_limit.least_slip(factor)
    # The bound is proportional to the excess of the load factor over the limit, and this excess is
    # half the limit. An error of the limit therefore counts twice.
    gap = 1 - limit.load_factor / limit.bound
    same("the bound is", solid.bound, plane.bound, _SAME * 10 + 2 * gap, _SAME)
    return solid.residual, True


def steady_state(subject: Embedded) -> Answered:
    """Compare the works of friction of steady states by increments."""
    if not subject.finite or subject.case.seed % _EVERY:
        raise NotApplicable
    case = subject.case
    f = np.minimum(case.friction, _FRICTION)
    factor = min(subject.load_factor, 3 * subject.answered_limit.load_factor)
    slip = np.zeros(case.system.nodes) if case.start is None else case.start
    options: dict[str, Any] = {"steps": 2, "most_cycles": 200}
    plane = in_plane(
        fo.steady_state, case.system, case.cycle, f, factor, initial_slip=slip, **options
    )
    solid = fo.steady_state(
        subject.solid, case.cycle, f, factor, initial_slip=slip[:, None] * subject.along, **options
    )
    mean_force = float(np.abs(case.system.reaction(case.cycle.mean)).max())
    cyclic_force = float(np.abs(case.cycle.corner_reactions(case.system)).max())
    force = mean_force + factor * cyclic_force
    work_scale = force**2 / case.system.stiffness_scale
    relative = 1e-6 + plane.work_error + solid.work_error
    same("the work is", solid.dissipation, plane.dissipation, relative, 1e-8 * work_scale)
    return solid.residual, True


def increment(subject: Embedded) -> Answered:
    """Compare the reactions after one increment, in which no node moves across the plane."""
    case = subject.case
    rng = subject.rng
    f = np.minimum(case.friction, _FRICTION)
    slip = np.zeros(case.system.nodes) if case.start is None else case.start
    loads = {"mean": 1.0, "a": 0.3 * float(rng.normal()), "b": 0.3 * float(rng.normal())}
    load = case.system.reaction(loads)
    plane = in_plane(NewtonIncrement(case.system, f).solve, slip, load)
    solid = NewtonIncrement(subject.solid, f).solve(
        slip[:, None] * subject.along, subject.solid.reaction(loads)
    )
    force = float(max(np.abs(plane.q).max(), np.abs(plane.p).max(), np.abs(load).max()))
    q_along = np.sum(solid.q * subject.along, axis=1)
    q_error = float(np.abs(q_along - plane.q).max())
    p_error = float(np.abs(solid.p - plane.p).max())
    error = max(q_error, p_error)
    if error > _SAME * force:
        raise Wrong(
            f"reactions differ from those of the plane by {error / force:.1e} of the largest"
        )
    return solid.residual, True
