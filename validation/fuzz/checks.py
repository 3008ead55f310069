"""The questions that every random case is asked, and how each answer is compared with an independent one."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

import frictopt as fo
from frictopt.transients.increments import ExactIncrement, FrozenBoundIncrement
from validation import oracles
from validation.fuzz.cases import Case
from validation.fuzz.guaranteed import followed, guaranteed, guaranteed_transformed
from validation.fuzz.known import Known, Missed, NotAsked, Wrong, same, transformed
from validation.fuzz.moving import limit_that_moves, safe_slip_that_moves
from validation.fuzz.open_sets import limits_of_sets
from validation.fuzz.searches import best_design, found_range, least_slip, limit_after_protocol
from validation.open_sets import largest_with_open

_WITHIN_STRETCH = 4  # increments within the shortest stretch between events
_SHORT = 1e-4  # stretches that are shorter are not divided into so many increments
# increments from corner to corner; without common divisors, so that not all of them miss the same
# event
_STEPS = (7, 30, 131, 1009)
_FEW = 3  # nodes up to which all statuses are tried
_BRUTE = 16  # cycles that are followed to find the outcome of a transient


@dataclass(frozen=True)
class Finding:
    """The result of one question.

    Attributes
    ----------
    check, seed
        The question, and the seed of the case.
    result
        "answer", "missed" if it is right and another one better, "wrong", or the name of the error.
    residual
        Residual of the answer; nan if there is none.
    compared
        Whether an independent answer was available.
    text
        What is wrong, or the message of the error.
    """

    check: str
    seed: int
    result: str
    residual: float
    compared: bool
    text: str


def findings(case: Case, checks: Sequence[str] | None = None) -> Iterator[Finding]:
    """Ask every question of a case, or some of them, by name."""
    return asked(
        {name: CHECKS[name] for name in (CHECKS if checks is None else checks)},
        Known(case),
        case.seed,
    )


def asked(
    questions: Mapping[str, Callable[[Any], tuple[float, bool]]], subject: Any, seed: int
) -> Iterator[Finding]:
    """Ask questions, by name, of a subject made from a seed."""
    for name, question in questions.items():
        try:
            residual, compared = question(subject)
            yield Finding(name, seed, "answer", residual, compared, "")
        except NotAsked:
            continue
        except Missed as better:
            yield Finding(name, seed, "missed", float("nan"), True, str(better))
        except fo.FrictoptError as error:
            kind = next(
                kind
                for kind in (fo.ModelError, fo.NoContinuation, fo.SolverError)
                if isinstance(error, kind)
            )
            yield Finding(name, seed, kind.__name__, float("nan"), False, str(error))
        except (
            Exception
        ) as error:  # a wrong answer, or an error of another package: neither may occur
            yield Finding(
                name, seed, "wrong", float("nan"), False, f"{type(error).__name__}: {error}"
            )


def _limit(known: Known) -> tuple[float, bool]:
    """Against a linear program on the plain rows of all corners; the safe slip against the rows themselves."""
    limit = known.answered_limit
    if not limit.events.empty:
        return limit_that_moves(known, limit)
    if limit.open.any():
        return _with_open_nodes(known, limit)
    if np.isfinite(limit.load_factor):
        excess = oracles.excess(*known.args, limit.load_factor, limit.slip)
        if excess > 1e-8:
            raise Wrong(f"slip at the limit is not safe by {excess:.1e}")
    if known.limit is not None:
        same("limit", limit.load_factor, known.limit, absolute=1e-8)
    return limit.residual, known.limit is not None


def _with_open_nodes(known: Known, limit: fo.results.ShakedownLimit) -> tuple[float, bool]:
    """Against a linear program in all slips and gaps, with the same nodes open at all corners; with all closed there is no more."""
    if known.limit is not None and known.limit > limit.load_factor * (1 + 1e-6):
        raise Wrong(f"nodes are open, and closed ones have the limit {known.limit}")
    most = 2 * limit.load_factor + 1.0 if np.isfinite(limit.load_factor) else 1e3
    found = largest_with_open(
        *known.args, np.tile(limit.open, (len(known.case.cycle.corners), 1)), most
    )
    if found is not None:
        same("limit with open nodes", min(limit.load_factor, most), found[0], 1e-6, 1e-8)
    return limit.residual, found is not None


def _least(known: Known) -> tuple[float, bool]:
    """Against a linear program on the plain rows of all corners, under a mean load that pulls here and there and corners that press."""
    rng, bonded, force, n = (
        np.random.default_rng([known.case.seed, 6]),
        known.case.system.bonded,
        known.force,
        known.case.system.nodes,
    )
    (q0, p0), sizes = (
        bonded["mean"],
        {name: 0.3 * force / (np.abs(bonded[name][0]).max() or 1.0) for name in "ab"},
    )
    pulled = {"mean": (q0, p0 - force * rng.uniform(0, 2, n) * (rng.random(n) < 0.5))}
    pressed = {
        name: (sizes[name] * bonded[name][0], force * rng.uniform(0.5, 1.5, n)) for name in "ab"
    }
    args = (
        known.case.system.with_bonded(pulled | pressed),
        fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0}]),
        known.case.friction,
    )
    limit, expected = fo.shakedown_limit(*args), oracles.least_load_factor(*args)
    if limit.open.any():
        return limit.residual, False
    # Loads alone may open nodes of an uncoupled contact, which then rests below this load factor.
    closed = fo.shakedown_limit(*args, open=np.zeros(n, dtype=bool))
    if limit.least > closed.least * (1 + 1e-6) + 1e-8:
        raise Wrong(f"least safe load factor {limit.least!r}, with closed nodes {closed.least!r}")
    if expected is not None:
        same("least safe load factor", closed.least, expected, absolute=1e-8)
    return max(limit.residual, closed.residual), expected is not None


def _transformed(known: Known) -> tuple[float, bool]:
    """The same limit of the same contact in other units, order and orientation."""
    return transformed(
        known,
        "limit",
        fo.shakedown_limit,
        lambda limit: float(limit.load_factor),
        known.answered_limit,
    )


def _safe_slip(known: Known) -> tuple[float, bool]:
    """Against a linear program for the margin, and against the limit."""
    safe = known.answered_safe_slip
    if not known.answered_limit.events.empty:
        return safe_slip_that_moves(known, safe)
    if safe.open.any():
        limit = known.answered_limit
        if (
            safe.open != limit.open
        ).any():  # those of the limit may be safe from a larger load factor on
            return safe.residual, False
        if (
            safe.exists != (limit.least <= known.load_factor <= limit.load_factor)
            and abs(safe.margin) > 1e-8
        ):
            raise Wrong(f"exists = {safe.exists} at {known.load_factor}, limit {limit.load_factor}")
        return safe.residual, True
    excess = oracles.excess(*known.args, known.load_factor, safe.slip)
    if safe.exists and excess > 1e-8:
        raise Wrong(f"the slip is not safe by {excess:.1e}")
    room = oracles.largest_margin(*known.args, known.load_factor)
    if (
        room is not None and abs(room) > 1e-8 and safe.exists != (room > 0)
    ):  # else the load is closer to the limit than either tolerance
        raise Wrong(f"exists = {safe.exists}, margin {room}")
    return safe.residual, room is not None


def _path(known: Known) -> tuple[float, bool]:
    """Against its energy, with loads linear between events; on few nodes also against increments with all statuses tried, as they get smaller."""
    case, cycles = known.case, 2
    path = fo.march(*known.args, known.load_factor, initial_slip=case.start, cycles=cycles)
    spent = (
        float(np.abs(path.energy).max()) + float(path.work[-1].sum()) + known.force * known.length
    )
    error = float(np.abs(path.energy_error).max()) / spent
    if error > 1e-8:
        raise Wrong(f"energy of the path is off by {error:.1e}")
    if case.system.nodes > _FEW:
        return path.residual, True
    ends = (
        np.searchsorted(path.time, np.arange(0, cycles * len(case.cycle.corners) + 0.5) + 1e-9) - 1
    )
    size = float(np.abs(path.slip).max()) + float(np.abs(path.gap).max()) + known.length
    errors: list[float] = []
    shortest = np.diff(path.time).min(initial=1.0, where=np.diff(path.time) > 0)
    for steps in (*_STEPS, *([int(_WITHIN_STRETCH / shortest)] if shortest > _SHORT else [])):
        marched = oracles.Stepper(*known.args).march(
            case.system, case.cycle, known.load_factor, case.start, cycles, steps
        )
        if (
            marched is None or marched.states > 1
        ):  # a jump, or two solutions: there the path ends, or passes between two increments
            return path.residual, True
        errors.append(float(np.abs(path.slip[ends] - marched.slip).max()) / size)
        if errors[-1] < 1e-6 or (
            len(errors) > 1 and errors[-1] < 0.5 * errors[-2] and errors[-1] < 0.1
        ):
            return path.residual, True
    raise Wrong(f"increments do not approach the path: {errors}")


def _steady(known: Known) -> tuple[float, bool]:
    """Against brute force: the same transient followed for many cycles; against the limit: nothing safe is claimed above it."""
    case = known.case
    steady = fo.steady_state(*known.args, known.load_factor, initial_slip=case.start)
    scale = (
        known.force
        * (known.length + float(np.abs(steady.slip).max()))
        * max(1.0, known.load_factor) ** 2
    )
    if (steady.outcome is fo.Outcome.SHAKEDOWN) != (steady.dissipation == 0.0):
        raise Wrong(f"{steady.outcome.name} with work {steady.dissipation:.3e}")
    if (
        known.finite
        and case.share > 1 + 1e-9
        and oracles.excess(*known.args, known.load_factor, steady.slip) < -1e-9
    ):
        raise Wrong("a safe slip above the limit")
    if steady.cycles > _BRUTE - 4:
        return steady.residual, False
    brute = fo.march(*known.args, known.load_factor, initial_slip=case.start, cycles=_BRUTE)
    works = brute.cycle_work.sum(axis=1)
    still_to_come = _still_to_come(works)
    same(
        "work of a cycle",
        steady.dissipation,
        float(works[-1]) + still_to_come,
        1e-6,
        1e-8 * scale + 10 * float(abs(works[-1] - works[-4])) + 0.1 * abs(still_to_come),
    )
    return steady.residual, True


def _still_to_come(works: Any) -> float:
    """How much the work of a cycle still changes, if its changes shrink in proportion."""
    before, last = np.diff(works[-3:])
    shrinks = 0 < last / before < 1 if before else False
    return float(last**2 / (before - last)) if shrinks else 0.0


def _safe_start(known: Known) -> tuple[float, bool]:
    """From a slip that is safe with room to spare, at a mean load that leaves it so, the contact never slips at all."""
    if (
        known.case.share >= 0.95
        or not known.finite
        or known.case.system.gap.any()
        or not known.case.friction.all()
    ):
        raise NotAsked
    safe = known.answered_safe_slip
    system, cycle, friction = known.args
    resting = fo.LoadCycle(
        cycle.mean, [*cycle.corners, {}]
    )  # with the mean load itself as a corner
    if not safe.exists or oracles.excess(
        system, resting, friction, known.load_factor, safe.slip
    ) > -1e-6 * float(friction.min()):
        return safe.residual, False
    steady = fo.steady_state(system, cycle, friction, known.load_factor, initial_slip=safe.slip)
    if (
        steady.outcome is not fo.Outcome.SHAKEDOWN
        or not np.array_equal(steady.slip, safe.slip)
        or steady.first_cycle != 0.0
    ):
        raise Wrong(
            f"from a safe slip: {steady.outcome.name}, first cycle {steady.first_cycle:.1e}"
        )
    return max(safe.residual, steady.residual), True


def _increment(
    known: Known, engine: type[ExactIncrement | FrozenBoundIncrement]
) -> tuple[float, bool]:
    """Against all statuses tried, on one load of the cycle; few nodes, and a part of the cases."""
    case = known.case
    if case.system.nodes > _FEW or case.seed % 8:
        raise NotAsked
    stepper = oracles.Stepper(*known.args)
    slip = np.zeros(case.system.nodes) if case.start is None else case.start
    load = oracles.corner_loads(case.system, case.cycle, known.load_factor)[1][0]
    states = stepper.states(slip, load)
    try:
        found = engine(case.system, case.friction).solve(slip, np.split(load, 2))
    except fo.NoContinuation as error:
        if states and stepper.regular:
            raise Wrong(f"{error}; but all statuses tried find {len(states)}") from error
        raise
    r = np.r_[found.q, found.p] / known.force
    size = max(
        1.0,
        float((np.abs(load) + np.abs(case.system.S[:, : len(slip)]) @ np.abs(slip)).max())
        / known.force,
    )
    if stepper.regular and not any(np.abs(forces - r).max() <= 1e-6 * size for _, forces in states):
        raise Wrong(f"a state that is none of the {len(states)} that trying all statuses finds")
    return found.residual, stepper.regular


CHECKS: dict[str, Callable[[Known], tuple[float, bool]]] = {
    "shakedown limit": _limit,
    "least safe load": _least,
    "safe slip": _safe_slip,
    "limit, transformed": _transformed,
    "guaranteed limit": guaranteed,
    "guaranteed, transformed": guaranteed_transformed,
    "guarantee, followed": followed,
    "open nodes": limits_of_sets,
    "best design": best_design,
    "least slip": least_slip,
    "found range": found_range,
    "limit after a protocol": limit_after_protocol,
    "exact path": _path,
    "steady state": _steady,
    "safe start": _safe_start,
    "mixed-integer increment": partial(_increment, engine=ExactIncrement),
    "frozen-bound increment": partial(_increment, engine=FrozenBoundIncrement),
}
"""Question -> function that answers it and holds it against something independent: residual, and whether there was anything to compare with."""
