"""What is asked of a random contact in three dimensions, and how each answer is held against an independent one."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar

import numpy as np

import frictopt as fo
from frictopt.transients.increments import FrozenBoundIncrement, NewtonIncrement
from validation.fuzz import embedded
from validation.fuzz.cases import Case
from validation.fuzz.checks import Finding, asked
from validation.fuzz.embedded import Embedded
from validation.fuzz.known import Asked, NotAsked, Wrong, same
from validation.fuzz.searches import (
    EVERY,
    best_design,
    found_range,
    least_slip,
    limit_after_protocol,
)
from validation.polygons import least_critical, polygon_limit

# relative distance from the limit within which it is not asked whether a safe slip exists
_NEAR = 1e-6
_SAME = 1e-7
_CRITICAL = 1e-4  # accuracy of critical states by polygons
_ZERO = 1e-3  # guaranteed limits, over the shakedown limit, that are about 0
_ROUNDING = 1e-14  # of a slip, over the slips before and after
_FEW = 3  # nodes at most, of which every one is made critical


class _Subject(Asked):
    """A random coupled contact with its load cycle, friction and slip."""

    none = 0.0
    options: ClassVar[Mapping[str, Any]] = {"steps": 2}

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        n, scale, coupling = (
            int(rng.integers(1, 11)),
            10.0 ** rng.uniform(-9, 9),
            rng.uniform(0.0, 1.0),
        )
        G = rng.normal(size=(3 * n, 3 * n))
        S = scale * (G @ G.T / (3 * n) + 10.0 ** rng.uniform(-3, 0) * np.eye(3 * n))
        S[: 2 * n, 2 * n :] *= coupling
        S[2 * n :, : 2 * n] *= coupling
        bonded = {
            name: np.r_[rng.normal(size=2 * n), rng.uniform(0, 0.6) * rng.normal(size=n)]
            for name in "abc"
        }
        bonded["mean"] = np.r_[0.2 * rng.normal(size=2 * n), rng.uniform(0.0, 1.5, size=n)]
        gap = (
            rng.uniform(size=n) * (rng.uniform(size=n) < 0.2) / scale
            if rng.uniform() < 0.3
            else np.zeros(n)
        )
        if rng.uniform() < 0.2:  # nothing holds the body along the contact
            slides = np.kron(np.eye(3)[:, :2], np.ones((n, 1))) / np.sqrt(n)
            held = np.eye(3 * n) - slides @ slides.T
            S = held @ S @ held
        system = fo.ContactSystem(S, rng.normal(size=(n, 3)), bonded, gap=gap)
        corners = [{"a": 1.0}, {"a": -1.0}, {"b": rng.normal(), "c": rng.normal()}, {"c": 1.0}]
        cycle = fo.LoadCycle({"mean": 1.0}, corners[: int(rng.integers(1, 5))])
        friction = rng.uniform(0.05, 1.5, n) * (
            rng.uniform(size=n) > rng.choice([0.0, 0.3], p=[0.8, 0.2])
        )
        slip = 0.3 * rng.normal(size=(n, 2)) / scale
        super().__init__(Case(seed, system, cycle, friction, float(rng.uniform(0.2, 1.8)), slip))


def space_findings(seed: int, checks: Sequence[str] | None = None) -> Iterator[Finding]:
    """Ask every question, or some of them, by name, of the contact of a seed, and of the plane contact of the same seed in space."""
    for questions, subject in ((_SPACE, _Subject(seed)), (_EMBEDDED, Embedded(seed))):
        yield from asked(
            {name: ask for name, ask in questions.items() if checks is None or name in checks},
            subject,
            seed,
        )


def _limit(subject: _Subject) -> tuple[float, bool]:
    limit, known = subject.answered_limit, polygon_limit(*subject.args)
    if known is not None and not np.isnan(limit.load_factor) and not limit.open.any():
        same("the limit is", limit.load_factor, known, _SAME, _SAME)
    return limit.residual, known is not None


def _least(subject: _Subject) -> tuple[float, bool]:
    """Under a mean load that pulls here and there, safe load factors begin where corners press."""
    bonded = subject.case.system.bonded
    pulled = {"mean": (bonded["mean"][0], bonded["mean"][1] - 0.2)}
    system = subject.case.system.with_bonded(
        pulled | {name: (0.2 * bonded[name][0], 1 + 0.3 * bonded[name][1]) for name in "abc"}
    )
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0, "c": 0.3}])
    limit = fo.shakedown_limit(system, cycle, subject.case.friction)
    known = polygon_limit(system, cycle, subject.case.friction, least=True)
    if known is None or np.isnan(limit.least) or limit.open.any():
        return limit.residual, False
    same("the least safe load factor is", limit.least, known, _SAME, _SAME)
    return limit.residual, True


def _guaranteed(subject: _Subject) -> tuple[float, bool]:
    """By programs of this study for few nodes; with every node's program solved, the corners the other way round, and one more within their hull."""
    system, cycle, f = subject.args
    limit = fo.guaranteed_limit(system, cycle, f)
    if len(cycle.corners) < 2:
        return limit.residual, False
    top = limit.shakedown.load_factor
    if system.nodes <= _FEW and limit.least == 0 and 0 < top < np.inf and not limit.open.any():
        least = least_critical(
            system, cycle, f
        )  # at about 0 it may be critical at that load factor alone
        if least is not None and max(limit.load_factor, min(least, top)) > _ZERO * top:
            same("the guaranteed limit is", limit.load_factor, min(least, top), _CRITICAL)
    within = {
        name: 0.4 * value for name, value in cycle.corners[0].items()
    }  # the second corner is opposed to it
    other = fo.guaranteed_limit(
        system, fo.LoadCycle(cycle.mean, [within, *cycle.corners[::-1]]), f, simplify=False
    )
    same("the guaranteed limit is", limit.load_factor, other.load_factor, _SAME, _SAME)
    return limit.residual, True


def _safe_slip(subject: _Subject) -> tuple[float, bool]:
    safe = fo.safe_slip(*subject.args, subject.load_factor)
    compared = subject.finite and abs(subject.case.share - 1) > _NEAR
    if compared and safe.exists and subject.case.share > 1:
        raise Wrong(f"a safe slip at {subject.case.share:.6g} of the limit")
    return safe.residual, compared


def _increment(
    subject: _Subject, engine: type[NewtonIncrement | FrozenBoundIncrement]
) -> tuple[float, bool]:
    load = subject.case.system.reaction({"mean": 1.0, "a": subject.case.share, "b": 0.5})
    found = engine(subject.case.system, subject.case.friction).solve(subject.case.start, load)
    q, p, f = found.q, found.p, subject.case.friction
    moved = found.slip - subject.case.start
    work = float(np.sum(q * moved)) + float(
        np.sum(f * p * np.linalg.norm(moved, axis=1))
    )  # friction opposes slip: the sum vanishes
    forces = float(np.abs(q).sum() + np.abs(load[0]).sum() + np.abs(load[1]).sum())
    if abs(work) > forces * (
        _SAME * float(np.abs(moved).max()) + _ROUNDING * float(np.abs(subject.case.start).max())
    ):
        raise Wrong(f"friction and slip are off by the work {work:.2e}")
    return found.residual, True


def _steady(subject: _Subject) -> tuple[float, bool]:
    if not subject.finite:
        return 0.0, False
    above = fo.steady_state(
        *subject.args,
        1.05 * subject.answered_limit.load_factor,
        initial_slip=subject.case.start,
        steps=4,
        most_cycles=200,
    )
    if (
        above.outcome is fo.Outcome.SHAKEDOWN and not above.open.any()
    ):  # what lifts off need not slip
        raise Wrong("shakedown above the limit")
    return above.residual, True


def _safe_start(subject: _Subject) -> tuple[float, bool]:
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


def _turned(subject: _Subject) -> tuple[float, bool]:
    """With the tangents of each node turned, and the nodes and the corners in another order."""
    system, cycle, n, rng = (
        subject.case.system,
        subject.case.cycle,
        subject.case.system.nodes,
        np.random.default_rng(subject.case.seed),
    )
    order, angle = rng.permutation(n), rng.uniform(0, 2 * np.pi, n)
    c, s = np.diag(np.cos(angle)), np.diag(np.sin(angle))
    turn = np.block(
        [[c, -s, np.zeros((n, n))], [s, c, np.zeros((n, n))], [np.zeros((n, 2 * n)), np.eye(n)]]
    )
    turn = turn[np.r_[order, n + order, 2 * n + order]]
    bonded = {name: turn @ np.r_[q.T.ravel(), p] for name, (q, p) in system.bonded.items()}
    S = turn @ system.S @ turn.T
    other = fo.ContactSystem((S + S.T) / 2, system.points[order], bonded, gap=system.gap[order])
    corners, f = fo.LoadCycle(cycle.mean, cycle.corners[::-1]), subject.case.friction[order]
    found = fo.shakedown_limit(other, corners, f)
    if (
        found.open != subject.answered_limit.open[order]
    ).any():  # the search is local, and may end elsewhere from another order
        return found.residual, False
    for name in ("load_factor", "least"):
        same(
            f"{name} is", getattr(found, name), getattr(subject.answered_limit, name), _SAME, _SAME
        )
    one, turned = (
        fo.guaranteed_limit(system, cycle, subject.case.friction),
        fo.guaranteed_limit(other, corners, f),
    )
    same("the guaranteed limit is", turned.load_factor, one.load_factor, _SAME, _SAME)
    return found.residual, True


def _required(subject: _Subject) -> tuple[float, bool]:
    """Slips are safe with a little more by the cones of this study, and none is with a little less."""
    system, cycle, factor = subject.case.system, subject.case.cycle, subject.load_factor
    if subject.case.seed % EVERY:
        raise NotAsked
    found = fo.required_friction(system, cycle, factor)
    if not 0 < found.required < np.inf or found.open.any():
        return found.residual, False
    for share, enough in ((0.999, False), (1.001, True)):
        f = np.full(system.nodes, share * found.required)
        most, least = (polygon_limit(system, cycle, f, least=side) for side in (False, True))
        if most is None or least is None or np.isinf(most):  # polygons leave more than circles do
            return found.residual, False
        if enough != (not np.isnan(most) and least * (1 - _SAME) <= factor <= most * (1 + _SAME)):
            raise Wrong(
                f"{share:g} of the required friction {found.required:.9g} keeps {least:.9g} to "
                f"{most:.9g} safe, asked is {factor:.9g}"
            )
    return found.residual, True


_SPACE: Mapping[str, Callable[[Any], tuple[float, bool]]] = {
    "limit, 3-D": _limit,
    "least safe load, 3-D": _least,
    "guaranteed limit, 3-D": _guaranteed,
    "safe slip, 3-D": _safe_slip,
    "turned and renumbered, 3-D": _turned,
    "required friction, 3-D": _required,
    "best design, 3-D": best_design,
    "least slip, 3-D": least_slip,
    "found range, 3-D": found_range,
    "limit after a protocol, 3-D": limit_after_protocol,
    "increment, 3-D": partial(_increment, engine=NewtonIncrement),
    "increment by cones, 3-D": partial(_increment, engine=FrozenBoundIncrement),
    "steady state above the limit, 3-D": _steady,
    "steady state from a safe slip, 3-D": _safe_start,
}
_EMBEDDED: Mapping[str, Callable[[Any], tuple[float, bool]]] = {
    "limit, plane in 3-D": partial(
        embedded.alike, question="shakedown_limit", values=("load_factor", "least")
    ),
    "guaranteed limit, plane in 3-D": partial(
        embedded.alike, question="guaranteed_limit", values=("load_factor",)
    ),
    "safe slip, plane in 3-D": embedded.safe_slip,
    "required friction, plane in 3-D": embedded.required_friction,
    "safe region, plane in 3-D": embedded.safe_region,
    "least slip, plane in 3-D": embedded.least_slip,
    "steady state, plane in 3-D": embedded.steady_state,
    "increment, plane in 3-D": embedded.increment,
}
SPACE: Mapping[str, Callable[[Any], tuple[float, bool]]] = {**_SPACE, **_EMBEDDED}
"""Question -> what asks it and compares the answer."""
