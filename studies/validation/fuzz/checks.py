"""The questions about a random plane contact, each with an independent answer to compare with.

`CHECKS` at the end of the file lists the questions. `findings` computes all of them for one case,
and reports a `Finding` for each.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import frictopt as fo
from studies.validation import oracles
from studies.validation.fuzz.cases import Case
from studies.validation.fuzz.guaranteed import followed, guaranteed, guaranteed_transformed
from studies.validation.fuzz.known import Known, Missed, NotApplicable, Wrong, same, transformed
from studies.validation.fuzz.moving import limit_that_moves, safe_slip_that_moves
from studies.validation.fuzz.open_sets import limits_of_sets
from studies.validation.fuzz.searches import (
    best_design,
    dissipation_range,
    least_slip,
    limit_after_protocol,
)
from studies.validation.open_sets import largest_with_open

# Number of increments within the shortest stretch between two events of the path.
_WITHIN_STRETCH = 4
# Shortest stretch, in segments of the load cycle, that is divided into `_WITHIN_STRETCH`
# increments.
_SHORT = 1e-4
# Numbers of increments per segment. They have no common divisors, so that they do not all miss the
# same event.
_STEPS = (7, 30, 131, 1009)
# Largest number of nodes for which all combinations of node statuses are tried.
_FEW = 3
# Number of cycles that are followed to find the outcome of a transient.
_BRUTE = 16


@dataclass(frozen=True)
class Finding:
    """The result of one question.

    Attributes
    ----------
    check, seed
        The question, and the seed of the case.
    result
        "answer", "missed", "wrong", or the name of an error of frictopt. A limit is "missed" if it
        is right for its open nodes, and other open nodes have a larger one.
    residual
        Residual of the answer; nan if there is no answer.
    compared
        Whether an independent answer was available.
    text
        The contradiction, or the message of the error.
    """

    check: str
    seed: int
    result: str
    residual: float
    compared: bool
    text: str


def findings(case: Case, checks: Sequence[str] | None = None) -> Iterator[Finding]:
    """Findings of all questions about a case, or of the questions named in `checks`."""
    names = CHECKS if checks is None else checks
    return findings_of({name: CHECKS[name] for name in names}, Known(case), case.seed)


def findings_of(
    questions: Mapping[str, Callable[[Any], tuple[float, bool]]], subject: Any, seed: int
) -> Iterator[Finding]:
    """Findings of the questions, by name, about a subject that was made from a seed.

    A question that does not apply to the subject has no finding.
    """
    nan = float("nan")
    for name, question in questions.items():
        try:
            residual, compared = question(subject)
            yield Finding(name, seed, "answer", residual, compared, "")
        except NotApplicable:
            continue
        except Missed as better:
            yield Finding(name, seed, "missed", nan, True, str(better))
        except fo.FrictoptError as error:
            yield Finding(name, seed, _kind(error), nan, False, str(error))
        # A wrong answer, or an error of another package: neither may occur.
        except Exception as error:
            yield Finding(name, seed, "wrong", nan, False, f"{type(error).__name__}: {error}")


def _kind(error: fo.FrictoptError) -> str:
    """The name of the public class of errors that an error belongs to."""
    public = (fo.ModelError, fo.NoContinuation, fo.SolverError)
    return next(kind.__name__ for kind in public if isinstance(error, kind))


def _limit(known: Known) -> tuple[float, bool]:
    """Compare the limit with a plain linear program.

    The plain program has the rows of all corners. The slip at the limit must satisfy these rows.
    """
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
    """Compare a limit with open nodes with a linear program in all slips and gaps.

    The program has the same nodes open at all corners. The limit with all nodes closed must not be
    larger.
    """
    if known.limit is not None and known.limit > limit.load_factor * (1 + 1e-6):
        raise Wrong(f"nodes are open, and closed ones have the limit {known.limit}")
    largest = 2 * limit.load_factor + 1.0 if np.isfinite(limit.load_factor) else 1e3
    open_at_corners = np.tile(limit.open, (len(known.case.cycle.corners), 1))
    expected = largest_with_open(*known.args, open_at_corners, largest)
    if expected is None:
        return limit.residual, False
    same("limit with open nodes", min(limit.load_factor, largest), expected[0], 1e-6, 1e-8)
    return limit.residual, True


def _least(known: Known) -> tuple[float, bool]:
    """Compare the least safe load factor with a plain linear program.

    The mean load of the case is changed so that it pulls at some nodes, and the cyclic loads so
    that they press.
    """
    rng = np.random.default_rng([known.case.seed, 6])
    bonded = known.case.system.bonded
    force = known.force
    n = known.case.system.nodes
    q0, p0 = bonded["mean"]
    loads = {"mean": (q0, p0 - force * rng.uniform(0, 2, n) * (rng.random(n) < 0.5))}
    for name in "ab":
        shear = bonded[name][0]
        size = 0.3 * force / (np.abs(shear).max() or 1.0)
        loads[name] = (size * shear, force * rng.uniform(0.5, 1.5, n))
    args = (
        known.case.system.with_bonded(loads),
        fo.LoadCycle({"mean": 1.0}, [{"a": 1.0}, {"b": 1.0}]),
        known.case.friction,
    )
    limit = fo.shakedown_limit(*args)
    expected = oracles.least_load_factor(*args)
    if limit.open.any():
        return limit.residual, False
    # Loads alone may open nodes of an uncoupled contact. It then shakes down below this load
    # factor, too.
    closed = fo.shakedown_limit(*args, open_nodes=np.zeros(n, dtype=bool))
    if limit.least > closed.least * (1 + 1e-6) + 1e-8:
        raise Wrong(f"least safe load factor {limit.least!r}, with closed nodes {closed.least!r}")
    if expected is not None:
        same("least safe load factor", closed.least, expected, absolute=1e-8)
    return max(limit.residual, closed.residual), expected is not None


def _transformed(known: Known) -> tuple[float, bool]:
    """Compare the limit with the limit of the contact in other units, order or orientation."""
    return transformed(known, "limit", fo.shakedown_limit, known.answered_limit)


def _safe_slip(known: Known) -> tuple[float, bool]:
    """Compare the safe slip with a linear program for the margin, or with the limit."""
    safe = known.answered_safe_slip
    if not known.answered_limit.events.empty:
        return safe_slip_that_moves(known, safe)
    if safe.open.any():
        limit = known.answered_limit
        # The open nodes of the limit may be safe only above a larger load factor.
        if (safe.open != limit.open).any():
            return safe.residual, False
        expected = limit.least <= known.load_factor <= limit.load_factor
        if safe.exists != expected and abs(safe.margin) > 1e-8:
            raise Wrong(f"exists = {safe.exists} at {known.load_factor}, limit {limit.load_factor}")
        return safe.residual, True
    excess = oracles.excess(*known.args, known.load_factor, safe.slip)
    if safe.exists and excess > 1e-8:
        raise Wrong(f"the slip is not safe by {excess:.1e}")
    margin = oracles.largest_margin(*known.args, known.load_factor)
    if margin is None:
        return safe.residual, False
    # If the margin is smaller, the load is closer to the limit than the tolerances of both answers.
    if abs(margin) > 1e-8 and safe.exists != (margin > 0):
        raise Wrong(f"exists = {safe.exists}, margin {margin}")
    return safe.residual, True


def _path(known: Known) -> tuple[float, bool]:
    """Compare the energy and the work of the exact path, and the path with increments.

    The increments try all combinations of node statuses, so only contacts of few nodes have them.
    As the increments get smaller, they must approach the path.
    """
    case = known.case
    cycles = 2
    path = fo.march(*known.args, known.load_factor, initial_slip=case.start, cycles=cycles)
    largest_energy = float(np.abs(path.energy).max())
    energy_scale = largest_energy + float(path.work[-1].sum()) + known.force * known.length
    error = float(np.abs(path.energy_error).max()) / energy_scale
    if error > 1e-8:
        raise Wrong(f"energy of the path is off by {error:.1e}")
    if case.system.nodes > _FEW:
        return path.residual, True
    corner_times = np.arange(0, cycles * len(case.cycle.corners) + 0.5)
    at_corners = np.searchsorted(path.time, corner_times + 1e-9) - 1
    size = float(np.abs(path.slip).max()) + float(np.abs(path.gap).max()) + known.length
    errors: list[float] = []
    for steps in _steps(path):
        marched = oracles.Stepper(*known.args).march(
            case.system, case.cycle, known.load_factor, case.start, cycles, steps
        )
        # At a jump an increment may have no state. If it has several states, the path may follow
        # another one.
        if marched is None or marched.states > 1:
            return path.residual, True
        errors.append(float(np.abs(path.slip[at_corners] - marched.slip).max()) / size)
        halved = len(errors) > 1 and errors[-1] < 0.5 * errors[-2]
        if errors[-1] < 1e-6 or (halved and errors[-1] < 0.1):
            return path.residual, True
    raise Wrong(f"increments do not approach the path: {errors}")


def _steps(path: fo.results.Trajectory) -> list[int]:
    """Numbers of increments per segment, the last one fine enough for the shortest stretch."""
    stretches = np.diff(path.time)
    shortest = stretches.min(initial=1.0, where=stretches > 0)
    if shortest > _SHORT:
        return [*_STEPS, int(_WITHIN_STRETCH / shortest)]
    return list(_STEPS)


def _steady(known: Known) -> tuple[float, bool]:
    """Compare the steady state with the same transient, followed for many cycles.

    Above the limit the slip of the steady state must not be safe.
    """
    case = known.case
    steady = fo.steady_state(*known.args, known.load_factor, initial_slip=case.start)
    largest_slip = float(np.abs(steady.slip).max())
    scale = known.force * (known.length + largest_slip) * max(1.0, known.load_factor) ** 2
    if (steady.outcome is fo.Outcome.SHAKEDOWN) != (steady.dissipation == 0.0):
        raise Wrong(f"{steady.outcome.name} with work {steady.dissipation:.3e}")
    above = known.finite and case.share > 1 + 1e-9
    if above and oracles.excess(*known.args, known.load_factor, steady.slip) < -1e-9:
        raise Wrong("a safe slip above the limit")
    if steady.cycles > _BRUTE - 4:
        return steady.residual, False
    followed_path = fo.march(*known.args, known.load_factor, initial_slip=case.start, cycles=_BRUTE)
    works = followed_path.cycle_work.sum(axis=1)
    change_to_come = _change_to_come(works)
    change_seen = float(abs(works[-1] - works[-4]))
    same(
        "work of a cycle",
        steady.dissipation,
        float(works[-1]) + change_to_come,
        1e-6,
        1e-8 * scale + 10 * change_seen + 0.1 * abs(change_to_come),
    )
    return steady.residual, True


def _change_to_come(works: Any) -> float:
    """Change of the work of a cycle after the last cycle, if the changes shrink in proportion."""
    before, last = np.diff(works[-3:])
    shrinks = 0 < last / before < 1 if before else False
    return float(last**2 / (before - last)) if shrinks else 0.0


def _safe_start(known: Known) -> tuple[float, bool]:
    """Check that a contact never slips if it starts from a slip that is safe with a margin.

    The slip must be safe with this margin under the mean load, too.
    """
    system, cycle, friction = known.args
    below = known.finite and known.case.share < 0.95
    if not below or system.gap.any() or not friction.all():
        raise NotApplicable
    safe = known.answered_safe_slip
    with_mean_load = fo.LoadCycle(cycle.mean, [*cycle.corners, {}])
    if not safe.exists:
        return safe.residual, False
    excess = oracles.excess(system, with_mean_load, friction, known.load_factor, safe.slip)
    if excess > -1e-6 * float(friction.min()):
        return safe.residual, False
    steady = fo.steady_state(system, cycle, friction, known.load_factor, initial_slip=safe.slip)
    moved = not np.array_equal(steady.slip, safe.slip) or steady.first_cycle != 0.0
    if steady.outcome is not fo.Outcome.SHAKEDOWN or moved:
        raise Wrong(
            f"from a safe slip: {steady.outcome.name}, first cycle {steady.first_cycle:.1e}"
        )
    return max(safe.residual, steady.residual), True


def _increment(known: Known) -> tuple[float, bool]:
    """Compare one increment with all combinations of node statuses.

    Only contacts of few nodes are compared, and one case in eight.
    """
    case = known.case
    if case.system.nodes > _FEW or case.seed % 8:
        raise NotApplicable
    stepper = oracles.Stepper(*known.args)
    slip = np.zeros(case.system.nodes) if case.start is None else case.start
    load = oracles.corner_loads(case.system, case.cycle, known.load_factor)[1][0]
    states = stepper.states(slip, load)
    try:
        increment = fo.increments.NewtonIncrement(case.system, case.friction).solve(
            slip, np.split(load, 2)
        )
    except fo.NoContinuation as error:
        if states and stepper.regular:
            raise Wrong(f"{error}; but all statuses tried find {len(states)}") from error
        raise
    if stepper.regular:
        reactions = np.r_[increment.q, increment.p] / known.force
        forces_of_slip = np.abs(case.system.S[:, : len(slip)]) @ np.abs(slip)
        size = max(1.0, float((np.abs(load) + forces_of_slip).max()) / known.force)
        differences = [np.abs(forces - reactions).max() for _, forces in states]
        if not any(difference <= 1e-6 * size for difference in differences):
            raise Wrong(f"a state that is none of the {len(states)} that trying all statuses finds")
    return increment.residual, stepper.regular


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
    "found range": dissipation_range,
    "limit after a protocol": limit_after_protocol,
    "exact path": _path,
    "steady state": _steady,
    "safe start": _safe_start,
    "increment": _increment,
}
"""Question -> function that answers it and compares the answer with an independent one.

The function returns the residual of the answer, and whether an independent answer was available.
"""
