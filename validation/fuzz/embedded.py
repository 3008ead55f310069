"""Plane contacts embedded in space: what the plane answers, space has to answer alike."""

import re
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

import frictopt as fo
from frictopt.transients.increments import ExactIncrement
from validation.fuzz.cases import random_case
from validation.fuzz.known import Asked, NotAsked, Wrong, same
from validation.fuzz.searches import EVERY

T = TypeVar("T")
Answered = tuple[float, bool]  # residual, and whether it was compared

_SAME = 1e-7
_FRICTION_PROVEN = 2e-5  # both sides of its proof are this close
_APART = 0.01  # of the two polygons of a region
_EVERY = 8  # cases that are asked for a steady state
_FRICTION = 0.5  # at most, for increments: with more, several states may obey the law


def embedded(
    flat: fo.ContactSystem, rng: np.random.Generator, across: Any = None
) -> tuple[fo.ContactSystem, Any]:
    """A plane contact in space, its tangents turned node by node; returns the unit vectors (N, 2) along which the plane slips, too.

    Across the plane it has the stiffness `across` (N, N), and no load: whatever the plane carries is
    carried, and slips across it help nothing. By default the stiffness holds some, all or none of
    the motions across, and all if the contact is uncoupled.
    """
    n, none = flat.nodes, np.zeros((flat.nodes, flat.nodes))
    if across is None:
        # Where loads alone open nodes, a body that slides freely across would be lifted off.
        held = n if not flat.B.any() else int(rng.integers(0, n + 1))
        G = rng.normal(size=(n, held))
        across = float(np.diag(flat.A).mean()) * G @ G.T
    S = np.block([[flat.A, none, flat.B.T], [none, across, none], [flat.B, none, flat.C]])
    along = np.exp(1j * rng.uniform(0, 2 * np.pi, n))
    c, s = np.diag(along.real), np.diag(along.imag)
    turn = np.block([[c, -s, none], [s, c, none], [none, none, np.eye(n)]])
    bonded = {name: turn @ np.r_[q, np.zeros(n), p] for name, (q, p) in flat.bonded.items()}
    points = np.column_stack([flat.x, np.zeros((n, 2))])
    return fo.ContactSystem(turn @ S @ turn.T, points, bonded, gap=flat.gap), np.column_stack(
        [along.real, along.imag]
    )


class Embedded(Asked):
    """A plane case of the random ones, and the same contact in space."""

    none = 0.0

    def __init__(self, seed: int) -> None:
        super().__init__(random_case(seed))
        self.rng = np.random.default_rng(seed)
        self.solid, self.along = embedded(self.case.system, self.rng)

    @cached_property
    def answered_limit(self) -> fo.results.ShakedownLimit:
        """The limit of the plane contact."""
        return in_plane(fo.shakedown_limit, *self.args)


def in_plane(ask: Callable[..., T], *given: Any, **options: Any) -> T:
    """What the plane contact answers.

    Raises
    ------
    NotAsked
        It has no answer.
    """
    try:
        return ask(*given, **options)
    except fo.FrictoptError as error:
        raise NotAsked from error


def alike(
    subject: Embedded,
    question: str,
    values: Sequence[str],
    *rest: Any,
    relative: float = _SAME,
    absolute: float = _SAME,
) -> Answered:
    """The same numbers from both contacts; asked of the load cycle and friction of the case where nothing else is given."""
    rest = rest or subject.args[1:]
    plane = in_plane(getattr(fo, question), subject.case.system, *rest)
    found = getattr(fo, question)(subject.solid, *rest)
    for name in values:
        same(f"{name} is", getattr(found, name), getattr(plane, name), relative, absolute)
    return found.residual, True


def safe_slip(subject: Embedded) -> Answered:
    """The largest margin.

    If no slip is safe, the margins are not compared: one contact may be proven to have no state of
    rest for all openings and closings, the other one with all nodes closed.
    """
    asked = *subject.args[1:], subject.load_factor
    plane = in_plane(fo.safe_slip, subject.case.system, *asked)
    found = fo.safe_slip(subject.solid, *asked)
    if plane.exists != found.exists:
        raise Wrong(f"{found.reason}; in the plane {plane.reason}")
    if not plane.exists:
        return found.residual, False
    same("margin is", found.margin, plane.margin, _SAME, _SAME)
    return found.residual, True


def required_friction(subject: Embedded) -> Answered:
    """The least friction that is enough at the load factor of the case."""
    if subject.case.seed % EVERY:
        raise NotAsked
    return alike(
        subject,
        "required_friction",
        ("required",),
        subject.case.cycle,
        subject.load_factor,
        relative=_FRICTION_PROVEN,
        absolute=0.0,
    )


def _open_nodes(reason: str) -> str:
    """How many nodes stay open, as a reason says it; empty if all nodes are closed."""
    said = re.match(r"with \d+ of \d+ nodes open", reason)
    return said[0] if said else ""


def safe_region(subject: Embedded) -> Answered:
    """The polygon of the plane lies between both polygons, if the same nodes stay open."""
    case = subject.case
    if case.seed % EVERY:
        raise NotAsked
    asked = {"mean": 1.0}, ["a", "b"], case.friction
    plane = in_plane(fo.safe_region, case.system, *asked)
    found = fo.safe_region(subject.solid, *asked, tolerance=_APART)
    if _open_nodes(found.reason) != _open_nodes(plane.reason):
        # Regions hold for one set of open nodes, and two sets may have equal limits.
        return found.residual, False
    if (len(found.vertices) > 0, found.unlimited) != (len(plane.vertices) > 0, plane.unlimited):
        raise Wrong(f"{found.reason}; in the plane {plane.reason}")
    for name, points, region, share in (
        ("safe point", found.vertices, plane, 1 - _SAME),
        ("vertex", plane.vertices, found, 1 - _APART - _SAME),
    ):
        for first, second in points[np.isfinite(points).all(axis=1)]:
            if not region.contains(share * first, share * second):
                raise Wrong(
                    f"the {name} ({first:.9g}, {second:.9g}) is not safe in the other contact"
                )
    return found.residual, True


def least_slip(subject: Embedded) -> Answered:
    """The proven sum of the weighted slips, up to the gap of the limit: both are proven by its mechanism."""
    if not subject.finite:
        raise NotAsked
    case, factor = subject.case, 1.5 * subject.answered_limit.load_factor
    limit = fo.shakedown_limit(subject.solid, case.cycle, case.friction)
    found, gap = limit.least_slip(factor), 1 - limit.load_factor / limit.bound
    same(
        "the bound is",
        found.bound,
        subject.answered_limit.least_slip(factor).bound,
        _SAME * 10 + 2 * gap,
    )  # of half the limit
    return found.residual, True


def steady_state(subject: Embedded) -> Answered:
    """The work of friction by as many increments."""
    if not subject.finite or subject.case.seed % _EVERY:
        raise NotAsked
    case, f = subject.case, np.minimum(subject.case.friction, _FRICTION)
    factor, slip = (
        min(subject.load_factor, 3 * subject.answered_limit.load_factor),
        np.zeros(case.system.nodes) if case.start is None else case.start,
    )
    options: dict[str, Any] = {"steps": 2, "most_cycles": 200}
    plane = in_plane(
        fo.steady_state, case.system, case.cycle, f, factor, initial_slip=slip, **options
    )
    found = fo.steady_state(
        subject.solid, case.cycle, f, factor, initial_slip=slip[:, None] * subject.along, **options
    )
    force = float(np.abs(case.system.reaction(case.cycle.mean)).max()) + factor * float(
        np.abs(case.cycle.corner_reactions(case.system)).max()
    )
    same(
        "the work is",
        found.dissipation,
        plane.dissipation,
        1e-6,
        1e-8 * force**2 / case.system.stiffness_scale,
    )
    return found.residual, True


def increment(subject: Embedded) -> Answered:
    """The reactions after one increment; across the plane no node moves."""
    case, rng = subject.case, subject.rng
    f, slip = (
        np.minimum(case.friction, _FRICTION),
        np.zeros(case.system.nodes) if case.start is None else case.start,
    )
    loads = {"mean": 1.0, "a": 0.3 * float(rng.normal()), "b": 0.3 * float(rng.normal())}
    plane = in_plane(ExactIncrement(case.system, f).solve, slip, case.system.reaction(loads))
    found = fo.increments.NewtonIncrement(subject.solid, f).solve(
        slip[:, None] * subject.along, subject.solid.reaction(loads)
    )
    force = float(
        max(np.abs(plane.q).max(), np.abs(plane.p).max(), np.abs(case.system.reaction(loads)).max())
    )
    off = max(
        float(np.abs(np.sum(found.q * subject.along, axis=1) - plane.q).max()),
        float(np.abs(found.p - plane.p).max()),
    )
    if off > _SAME * force:
        raise Wrong(f"reactions differ from those of the plane by {off / force:.1e} of the largest")
    return found.residual, True
