"""The questions about a random contact in three dimensions, each with an independent answer."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

import frictopt as fo
from studies.validation.fuzz import embedded
from studies.validation.fuzz.cases import Case
from studies.validation.fuzz.checks import Finding, findings_of
from studies.validation.fuzz.embedded import Embedded
from studies.validation.fuzz.known import NotApplicable, Subject, Wrong, same
from studies.validation.fuzz.searches import (
    EVERY,
    best_design,
    dissipation_range,
    least_slip,
    limit_after_protocol,
)
from studies.validation.polygons import least_critical, polygon_limit

# Relative distance from the limit within which the existence of a safe slip is not compared.
_NEAR = 1e-6
_SAME = 1e-7
# Accuracy of critical states by polygons.
_CRITICAL = 1e-4
# A guaranteed limit up to this share of the shakedown limit counts as zero.
_ZERO = 1e-3
# Rounding of a slip, relative to the slips before and after.
_ROUNDING = 1e-14
# Largest number of nodes for which the critical state of each node is computed.
_FEW = 3


class _SpatialSubject(Subject):
    """A random coupled contact in space with its load cycle, friction and slip."""

    none = 0.0
    options: ClassVar[Mapping[str, Any]] = {"steps": 2}

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        n = int(rng.integers(1, 11))
        scale = 10.0 ** rng.uniform(-9, 9)
        coupling = rng.uniform(0.0, 1.0)
        G = rng.normal(size=(3 * n, 3 * n))
        S = scale * (G @ G.T / (3 * n) + 10.0 ** rng.uniform(-3, 0) * np.eye(3 * n))
        S[: 2 * n, 2 * n :] *= coupling
        S[2 * n :, : 2 * n] *= coupling
        bonded = {
            name: np.r_[rng.normal(size=2 * n), rng.uniform(0, 0.6) * rng.normal(size=n)]
            for name in "abc"
        }
        bonded["mean"] = np.r_[0.2 * rng.normal(size=2 * n), rng.uniform(0.0, 1.5, size=n)]
        gap = np.zeros(n)
        if rng.uniform() < 0.3:
            gap = rng.uniform(size=n) * (rng.uniform(size=n) < 0.2) / scale
        if rng.uniform() < 0.2:
            # Only friction holds the body along the contact.
            slides = np.kron(np.eye(3)[:, :2], np.ones((n, 1))) / np.sqrt(n)
            held = np.eye(3 * n) - slides @ slides.T
            S = held @ S @ held
        system = fo.ContactSystem(S, rng.normal(size=(n, 3)), bonded, gap=gap)
        corners = [{"a": 1.0}, {"a": -1.0}, {"b": rng.normal(), "c": rng.normal()}, {"c": 1.0}]
        cycle = fo.LoadCycle({"mean": 1.0}, corners[: int(rng.integers(1, 5))])
        coefficient = rng.uniform(0.05, 1.5, n)
        has_friction = rng.uniform(size=n) > rng.choice([0.0, 0.3], p=[0.8, 0.2])
        friction = coefficient * has_friction
        slip = 0.3 * rng.normal(size=(n, 2)) / scale
        super().__init__(Case(seed, system, cycle, friction, float(rng.uniform(0.2, 1.8)), slip))


def space_findings(seed: int, checks: Sequence[str] | None = None) -> Iterator[Finding]:
    """Findings about the contact of a seed, and about the plane contact of this seed in space.

    `checks` names the questions; None: all questions.
    """
    for questions, subject in ((_SPACE, _SpatialSubject(seed)), (_EMBEDDED, Embedded(seed))):
        names = [name for name in questions if checks is None or name in checks]
        yield from findings_of({name: questions[name] for name in names}, subject, seed)


def _limit(subject: _SpatialSubject) -> tuple[float, bool]:
    """Compare the limit with the limit of a program with polygons instead of friction circles."""
    limit = subject.answered_limit
    expected = polygon_limit(*subject.args)
    if expected is not None and not np.isnan(limit.load_factor) and not limit.open.any():
        same("the limit is", limit.load_factor, expected, _SAME, _SAME)
    return limit.residual, expected is not None


def _least(subject: _SpatialSubject) -> tuple[float, bool]:
    """Compare the least safe load factor with the same program.

    The mean load of the case is changed so that it pulls at some nodes, and the cyclic loads so
    that they press.
    """
    bonded = subject.case.system.bonded
    q0, p0 = bonded["mean"]
    loads = {"mean": (q0, p0 - 0.2)}
    for name in "abc":
        q, p = bonded[name]
        loads[name] = (0.2 * q, 1 + 0.3 * p)
    system = subject.case.system.with_bonded(loads)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0, "c": 0.3}])
    limit = fo.shakedown_limit(system, cycle, subject.case.friction)
    expected = polygon_limit(system, cycle, subject.case.friction, least=True)
    if expected is None or np.isnan(limit.least) or limit.open.any():
        return limit.residual, False
    same("the least safe load factor is", limit.least, expected, _SAME, _SAME)
    return limit.residual, True


def _guaranteed(subject: _SpatialSubject) -> tuple[float, bool]:
    """Compare the guaranteed limit with critical states by polygons, and with an equivalent question.

    Only contacts of few nodes are compared with polygons. The equivalent question has the corners
    in reverse order, one more corner within their hull, and no simplification.
    """
    system, cycle, f = subject.args
    limit = fo.guaranteed_limit(system, cycle, f)
    if len(cycle.corners) < 2:
        return limit.residual, False
    top = limit.shakedown.load_factor
    if system.nodes <= _FEW and limit.least == 0 and 0 < top < np.inf and not limit.open.any():
        least = least_critical(system, cycle, f)
        # A node whose limit is about 0 may be critical at that load factor alone.
        if least is not None and max(limit.load_factor, min(least, top)) > _ZERO * top:
            same("the guaranteed limit is", limit.load_factor, min(least, top), _CRITICAL)
    # The second corner is opposed to the first one, so a part of the first one is within the hull.
    within = {name: 0.4 * value for name, value in cycle.corners[0].items()}
    equal_cycle = fo.LoadCycle(cycle.mean, [within, *cycle.corners[::-1]])
    equal_limit = fo.guaranteed_limit(system, equal_cycle, f, simplify=False)
    same("the guaranteed limit is", limit.load_factor, equal_limit.load_factor, _SAME, _SAME)
    return limit.residual, True


def _safe_slip(subject: _SpatialSubject) -> tuple[float, bool]:
    """Check that no slip is safe above the limit."""
    safe = fo.safe_slip(*subject.args, subject.load_factor)
    compared = subject.finite and abs(subject.case.share - 1) > _NEAR
    if compared and safe.exists and subject.case.share > 1:
        raise Wrong(f"a safe slip at {subject.case.share:.6g} of the limit")
    return safe.residual, compared


def _increment(subject: _SpatialSubject) -> tuple[float, bool]:
    """Check that friction opposes the slip of an increment with its full bound.

    Then the work of the shear forces and the work of the bounds add up to zero.
    """
    f = subject.case.friction
    start = subject.case.start
    load = subject.case.system.reaction({"mean": 1.0, "a": subject.case.share, "b": 0.5})
    increment = fo.increments.NewtonIncrement(subject.case.system, f).solve(start, load)
    q = increment.q
    p = increment.p
    moved = increment.slip - start
    work_of_shear = float(np.sum(q * moved))
    work_of_bounds = float(np.sum(f * p * np.linalg.norm(moved, axis=1)))
    work = work_of_shear + work_of_bounds
    forces = float(np.abs(q).sum() + np.abs(load[0]).sum() + np.abs(load[1]).sum())
    slip_error = _SAME * float(np.abs(moved).max()) + _ROUNDING * float(np.abs(start).max())
    if abs(work) > forces * slip_error:
        raise Wrong(f"friction and slip are off by the work {work:.2e}")
    return increment.residual, True


def _steady(subject: _SpatialSubject) -> tuple[float, bool]:
    """Check that the contact does not shake down above the limit with all nodes closed.

    A node without friction may slide in a contact that is at rest, because it dissipates nothing.
    """
    if not (subject.finite and subject.case.friction.all()):
        return 0.0, False
    above = fo.steady_state(
        *subject.args,
        1.05 * subject.answered_limit.load_factor,
        initial_slip=subject.case.start,
        steps=4,
        most_cycles=200,
    )
    if above.outcome is fo.Outcome.SHAKEDOWN and not above.open.any():
        raise Wrong("shakedown above the limit")
    return above.residual, True


def _safe_start(subject: _SpatialSubject) -> tuple[float, bool]:
    """Check that a transient from a safe slip with a margin shakes down."""
    if not subject.finite or subject.case.cycle.mean_reaction(subject.case.system)[1].min() < 0:
        return 0.0, False
    below = 0.9 * subject.answered_limit.load_factor
    safe = fo.safe_slip(*subject.args, below)
    if not (safe.exists and safe.margin > _NEAR) or fo.safe_slip(*subject.args, 0.0).margin < 0:
        return 0.0, False
    steady = fo.steady_state(*subject.args, below, initial_slip=safe.slip, steps=4)
    if steady.outcome is not fo.Outcome.SHAKEDOWN:
        raise Wrong(f"{steady.outcome.name} from a safe slip, W = {steady.dissipation:.2e}")
    return steady.residual, True


def _turned(subject: _SpatialSubject) -> tuple[float, bool]:
    """Compare the shakedown and the guaranteed limit with the limits of the contact in another description.

    The tangents of each node are turned, and the nodes and the corners have another order.
    """
    system = subject.case.system
    cycle = subject.case.cycle
    friction = subject.case.friction
    n = system.nodes
    rng = np.random.default_rng(subject.case.seed)
    order = rng.permutation(n)
    angle = rng.uniform(0, 2 * np.pi, n)
    c, s = np.diag(np.cos(angle)), np.diag(np.sin(angle))
    turn = np.block(
        [[c, -s, np.zeros((n, n))], [s, c, np.zeros((n, n))], [np.zeros((n, 2 * n)), np.eye(n)]]
    )
    turn = turn[np.r_[order, n + order, 2 * n + order]]
    bonded = {name: turn @ np.r_[q.T.ravel(), p] for name, (q, p) in system.bonded.items()}
    S = turn @ system.S @ turn.T
    points = system.points[order]
    turned_system = fo.ContactSystem((S + S.T) / 2, points, bonded, gap=system.gap[order])
    turned_args = (
        turned_system,
        fo.LoadCycle(cycle.mean, cycle.corners[::-1]),
        friction[order],
    )
    expected = subject.answered_limit
    limit = fo.shakedown_limit(*turned_args)
    # The search is local, and may end with other open nodes if it begins in another order.
    if (limit.open != expected.open[order]).any():
        return limit.residual, False
    for name in ("load_factor", "least"):
        same(f"{name} is", getattr(limit, name), getattr(expected, name), _SAME, _SAME)
    guarantee = fo.guaranteed_limit(system, cycle, friction)
    turned_guarantee = fo.guaranteed_limit(*turned_args)
    same(
        "the guaranteed limit is",
        turned_guarantee.load_factor,
        guarantee.load_factor,
        _SAME,
        _SAME,
    )
    return limit.residual, True


def _required(subject: _SpatialSubject) -> tuple[float, bool]:
    """Compare the required friction with the program with polygons.

    With slightly more friction the load factor must be safe, and with slightly less it must not.
    """
    if subject.case.seed % EVERY:
        raise NotApplicable
    system = subject.case.system
    cycle = subject.case.cycle
    factor = subject.load_factor
    answer = fo.required_friction(system, cycle, factor)
    if not 0 < answer.required < np.inf or answer.open.any():
        return answer.residual, False
    for share, enough in ((0.999, False), (1.001, True)):
        f = np.full(system.nodes, share * answer.required)
        largest = polygon_limit(system, cycle, f, least=False)
        least = polygon_limit(system, cycle, f, least=True)
        # Polygons contain the circles, so they may have no limit although the circles have one.
        if largest is None or least is None or np.isinf(largest):
            return answer.residual, False
        is_safe = least * (1 - _SAME) <= factor <= largest * (1 + _SAME)
        if enough != (not np.isnan(largest) and is_safe):
            raise Wrong(
                f"{share:g} of the required friction {answer.required:.9g} keeps {least:.9g} to "
                f"{largest:.9g} safe, asked is {factor:.9g}"
            )
    return answer.residual, True


_SPACE: Mapping[str, Callable[[Any], tuple[float, bool]]] = {
    "limit, 3-D": _limit,
    "least safe load, 3-D": _least,
    "guaranteed limit, 3-D": _guaranteed,
    "safe slip, 3-D": _safe_slip,
    "turned and renumbered, 3-D": _turned,
    "required friction, 3-D": _required,
    "best design, 3-D": best_design,
    "least slip, 3-D": least_slip,
    "found range, 3-D": dissipation_range,
    "limit after a protocol, 3-D": limit_after_protocol,
    "increment, 3-D": _increment,
    "steady state above the limit, 3-D": _steady,
    "steady state from a safe slip, 3-D": _safe_start,
}
_EMBEDDED: Mapping[str, Callable[[Any], tuple[float, bool]]] = {
    "limit, plane in 3-D": embedded.limit,
    "guaranteed limit, plane in 3-D": embedded.guaranteed_limit,
    "safe slip, plane in 3-D": embedded.safe_slip,
    "required friction, plane in 3-D": embedded.required_friction,
    "safe region, plane in 3-D": embedded.safe_region,
    "least slip, plane in 3-D": embedded.least_slip,
    "steady state, plane in 3-D": embedded.steady_state,
    "increment, plane in 3-D": embedded.increment,
}
SPACE: Mapping[str, Callable[[Any], tuple[float, bool]]] = {**_SPACE, **_EMBEDDED}
"""Question -> function that answers it and compares the answer."""
