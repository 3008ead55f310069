"""Plane contacts embedded in space: what the plane answers, space has to answer alike."""

from functools import cached_property
from typing import Any

import numpy as np

import frictopt as fo
from frictopt.transients.increments import ExactIncrement

from .cases import random_case
from .known import NotAsked, Wrong, same

_SAME = 1e-7
_FRICTION_PROVEN = 2e-5  # both sides of its proof are this close
_APART = 0.01  # of the two polygons of a region
_EVERY = 8  # cases that are asked for a steady state
FRICTION_EVERY = 4
"""Cases that are asked for the required friction, which takes tens of safe slips."""
_FRICTION = 0.5  # at most, for increments: with more, several states may obey the law


def embedded(flat: fo.ContactSystem, rng: np.random.Generator) -> tuple[fo.ContactSystem, Any]:
    """A plane contact in space, its tangents turned node by node; returns the unit vectors (N, 2) along which the plane slips, too.

    Across the plane it has some stiffness, or none, and no load: whatever the plane carries is carried, and slips across it help nothing.
    """
    n, none = flat.nodes, np.zeros((flat.nodes, flat.nodes))
    G = rng.normal(size=(n, int(rng.integers(0, n + 1))))
    across = float(np.diag(flat.A).mean()) * G @ G.T
    S = np.block([[flat.A, none, flat.B.T], [none, across, none], [flat.B, none, flat.C]])
    along = np.exp(1j * rng.uniform(0, 2 * np.pi, n))
    c, s = np.diag(along.real), np.diag(along.imag)
    turn = np.block([[c, -s, none], [s, c, none], [none, none, np.eye(n)]])
    bonded = {name: turn @ np.r_[q, np.zeros(n), p] for name, (q, p) in flat.bonded.items()}
    points = np.column_stack([flat.x, np.zeros((n, 2))])
    return fo.ContactSystem(turn @ S @ turn.T, points, bonded, gap=flat.gap), np.column_stack([along.real, along.imag])


class Embedded:
    """The plane case of a seed, in space."""

    def __init__(self, seed: int) -> None:
        self.case, self.rng = random_case(seed), np.random.default_rng(seed)
        self.solid, self.along = embedded(self.case.system, self.rng)

    @cached_property
    def limit(self) -> fo.results.ShakedownLimit:
        """The limit of the plane contact."""
        try:
            limit: fo.results.ShakedownLimit = fo.shakedown_limit(self.case.system, self.case.cycle, self.case.friction)
        except fo.FrictoptError as error:
            raise NotAsked from error
        return limit

    @property
    def load_factor(self) -> float:
        """The load factor of the case."""
        value = self.limit.load_factor
        return self.case.share * (value if np.isfinite(value) and value > 0 else 1.0)


def limit(subject: Embedded) -> tuple[float, bool]:
    """The interval of safe load factors."""
    case, plane = subject.case, subject.limit
    found = fo.shakedown_limit(subject.solid, case.cycle, case.friction)
    for name in ("load_factor", "least"):
        same(f"{name} is", getattr(found, name), getattr(plane, name), _SAME, _SAME)
    return found.residual, True


def guaranteed(subject: Embedded) -> tuple[float, bool]:
    """The guaranteed limit."""
    case = subject.case
    try:
        plane = fo.guaranteed_limit(case.system, case.cycle, case.friction)
    except fo.FrictoptError as error:
        raise NotAsked from error
    found = fo.guaranteed_limit(subject.solid, case.cycle, case.friction)
    same("the guaranteed limit is", found.load_factor, plane.load_factor, _SAME, _SAME)
    return found.residual, True


def safe_slip(subject: Embedded) -> tuple[float, bool]:
    """The largest margin."""
    case, factor = subject.case, subject.load_factor
    try:
        plane = fo.safe_slip(case.system, case.cycle, case.friction, factor)
    except fo.FrictoptError as error:
        raise NotAsked from error
    found = fo.safe_slip(subject.solid, case.cycle, case.friction, factor)
    same("the margin is", found.margin, plane.margin, _SAME, _SAME)
    return found.residual, True


def required_friction(subject: Embedded) -> tuple[float, bool]:
    """The least friction that is enough at the load factor of the case."""
    case, factor = subject.case, subject.load_factor
    if case.seed % FRICTION_EVERY:
        raise NotAsked
    try:
        plane = fo.required_friction(case.system, case.cycle, factor)
    except fo.FrictoptError as error:
        raise NotAsked from error
    found = fo.required_friction(subject.solid, case.cycle, factor)
    same("the required friction is", found.required, plane.required, _FRICTION_PROVEN)
    return found.residual, True


def safe_region(subject: Embedded) -> tuple[float, bool]:
    """The polygon of the plane lies between both polygons."""
    case = subject.case
    if case.seed % FRICTION_EVERY:
        raise NotAsked
    asked = {"mean": 1.0}, ["a", "b"], case.friction
    try:
        plane = fo.safe_region(case.system, *asked)
    except fo.FrictoptError as error:
        raise NotAsked from error
    found = fo.safe_region(subject.solid, *asked, tolerance=_APART)
    if (len(found.vertices) > 0, found.unlimited) != (len(plane.vertices) > 0, plane.unlimited):
        raise Wrong(f"{found.reason}; in the plane {plane.reason}")
    for name, points, region, share in (("safe point", found.vertices, plane, 1 - _SAME), ("vertex", plane.vertices, found, 1 - _APART - _SAME)):
        for first, second in points[np.isfinite(points).all(axis=1)]:
            if not region.contains(share * first, share * second):
                raise Wrong(f"the {name} ({first:.9g}, {second:.9g}) is not safe in the other contact")
    return found.residual, True


def least_slip(subject: Embedded) -> tuple[float, bool]:
    """The proven sum of the weighted slips."""
    if not (np.isfinite(subject.limit.load_factor) and subject.limit.load_factor > 0):
        raise NotAsked
    case, factor = subject.case, 1.5 * subject.limit.load_factor
    found = fo.shakedown_limit(subject.solid, case.cycle, case.friction).least_slip(factor)
    same("the bound is", found.bound, subject.limit.least_slip(factor).bound, _SAME * 10)
    return found.residual, True


def steady_state(subject: Embedded) -> tuple[float, bool]:
    """The work of friction by as many increments."""
    if not (np.isfinite(subject.limit.load_factor) and subject.limit.load_factor > 0) or subject.case.seed % _EVERY:
        raise NotAsked
    case, f = subject.case, np.minimum(subject.case.friction, _FRICTION)
    factor, slip = min(subject.load_factor, 3 * subject.limit.load_factor), np.zeros(case.system.nodes) if case.start is None else case.start
    options: dict[str, Any] = {"steps": 2, "most_cycles": 200}
    try:
        plane = fo.steady_state(case.system, case.cycle, f, factor, initial_slip=slip, **options)
    except fo.FrictoptError as error:
        raise NotAsked from error
    found = fo.steady_state(subject.solid, case.cycle, f, factor, initial_slip=slip[:, None] * subject.along, **options)
    force = float(np.abs(case.system.reaction(case.cycle.mean)).max()) + factor * float(np.abs(case.cycle.corner_reactions(case.system)).max())
    same("the work is", found.dissipation, plane.dissipation, 1e-6, 1e-8 * force**2 / case.system.stiffness_scale)
    return found.residual, True


def increment(subject: Embedded) -> tuple[float, bool]:
    """The reactions after one increment; across the plane no node moves."""
    case, rng = subject.case, subject.rng
    f, slip = np.minimum(case.friction, _FRICTION), np.zeros(case.system.nodes) if case.start is None else case.start
    loads = {"mean": 1.0, "a": 0.3 * float(rng.normal()), "b": 0.3 * float(rng.normal())}
    try:
        plane = ExactIncrement(case.system, f).solve(slip, case.system.reaction(loads))
    except fo.FrictoptError as error:
        raise NotAsked from error
    found = fo.increments.NewtonIncrement(subject.solid, f).solve(slip[:, None] * subject.along, subject.solid.reaction(loads))
    force = float(max(np.abs(plane.q).max(), np.abs(plane.p).max(), np.abs(case.system.reaction(loads)).max()))
    off = max(float(np.abs(np.sum(found.q * subject.along, axis=1) - plane.q).max()), float(np.abs(found.p - plane.p).max()))
    if off > _SAME * force:
        raise Wrong(f"reactions differ from those of the plane by {off / force:.1e} of the largest")
    return found.residual, True
