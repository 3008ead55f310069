"""What is asked of a random contact about all starts and designs, in the plane and in space."""

import cvxpy as cp
import numpy as np

import frictopt as fo
from validation.fuzz.known import Asked, NotAsked, Wrong, same

_CYCLES = 4  # followed to hold the least slip against
_BRUTE = 40  # followed to see what becomes of a start
# Cases that are asked for a range or a limit after a protocol, which follow many transients: one in
# so many, with at most so many nodes.
_EVERY = 16
_MOST_NODES = 6
# shortfall of the weighted slip, over the sum of the sizes of its terms, that counts as rounding
_WITHIN = 1e-8


def least_slip(known: Asked) -> tuple[float, bool]:
    """No cycle of a transient slips less than the multipliers of the limit prove, periodic or not; with open nodes this is said of fewer cycles."""
    if not known.finite or known.answered_limit.open.any():
        raise NotAsked
    least = known.answered_limit.least_slip(
        (1 + known.case.share) * known.answered_limit.load_factor
    )
    path = fo.march(
        *known.args,
        least.load_factor,
        initial_slip=known.case.start,
        cycles=_CYCLES,
        **known.options,
    )
    at = (
        np.searchsorted(
            path.time, np.arange(1, _CYCLES * len(known.case.cycle.corners) + 0.5) + 1e-9
        )
        - 1
    )
    for slip, gap in zip(
        *(
            values[at].reshape(_CYCLES, *shape.shape)
            for values, shape in ((path.slip, least.g), (path.gap, least.h))
        ),
        strict=True,
    ):
        size = (
            abs(least.bound)
            + least.load_factor
            + float(np.abs(least.g * slip).sum() + np.abs(least.h * gap).sum())
        )
        if least.of(slip, gap) < least.bound - _WITHIN * size:
            raise Wrong(
                f"a cycle slips {least.of(slip, gap):.9g}, less than the bound {least.bound:.9g}"
            )
    return max(least.residual, path.residual), True


def found_range(known: Asked) -> tuple[float, bool]:
    """Both ends of the range are dissipated for ever from their starts; without coupling they are one, and no slip leads to a work between them."""
    case = known.case
    if case.system.nodes > _MOST_NODES or case.seed % _EVERY:
        raise NotAsked
    span = fo.dissipation_range(*known.args, known.load_factor, **known.options)
    scale = known.force * known.length * max(1.0, known.load_factor) ** 2
    compared = False
    for name, work, start in (
        ("least", span.least, span.least_start),
        ("most", span.most, span.worst_start),
    ):
        try:
            works = fo.march(
                *known.args, known.load_factor, initial_slip=start, cycles=_BRUTE, **known.options
            ).cycle_work.sum(axis=1)
        except fo.SolverError:  # slips so large that their rounding hides the cycle
            continue
        spread = float(np.abs(start).max()) * known.force
        same(
            f"{name} work",
            work,
            float(works[-1]),
            1e-6,
            1e-8 * (scale + spread) + 10 * float(abs(works[-1] - works[-4])),
        )
        compared = True
    if (
        not case.system.B.any()
        and not span.most_state.open.any()
        and not span.least_state.open.any()
    ):
        same("least and most without coupling", span.least, span.most, 1e-6, 1e-8 * scale)
    none = fo.steady_state(*known.args, known.load_factor, **known.options).dissipation
    if not span.least * (1 - 1e-6) - 1e-8 * scale <= none <= span.most * (1 + 1e-6) + 1e-8 * scale:
        raise Wrong(
            f"no slip leads to the work {none:.9g}, outside {span.least:.9g} to {span.most:.9g}"
        )
    return span.residual, compared


def limit_after_protocol(known: Asked) -> tuple[float, bool]:
    """From the case's own start, slip stops at the limit and goes on above it, as steady states say, and at the limit cycles followed as well."""
    case = known.case
    if (
        case.system.nodes > _MOST_NODES
        or case.seed % _EVERY
        or not known.finite
        or known.answered_limit.load_factor == 0
    ):
        raise NotAsked
    start = np.zeros(case.system.slip_shape) if case.start is None else case.start
    one = fo.limit_after_protocol(*known.args, start=start, scan=5, tolerance=1e-2, **known.options)
    compared, size = False, known.force * (known.length + float(np.abs(start).max()))
    for factor, rests in ((one.load_factor, True), (one.upper, False)):
        if not 0 < factor < np.inf:
            continue
        try:
            outcome = fo.steady_state(
                *known.args, factor, initial_slip=start, **known.options
            ).outcome
        except (fo.NoContinuation, fo.SolverError):
            continue
        if rests != (outcome is fo.Outcome.SHAKEDOWN):
            raise Wrong(
                f"{outcome.name} at {factor:.9g}, between {one.load_factor:.9g} and {one.upper:.9g}"
            )
        before, last = fo.march(
            *known.args, factor, initial_slip=start, cycles=_BRUTE, **known.options
        ).cycle_work.sum(axis=1)[-2:]
        if rests and last > 1e-7 * size * max(1.0, factor) ** 2 and last > 0.999 * before:
            raise Wrong(
                f"cycles still dissipate {last:.3e} at the limit after a protocol {factor:.9g}"
            )
        compared = True
    return one.residual, compared


EVERY = 4
"""Cases that are asked for what takes tens of limits."""
_OTHERS = 3  # designs within the bounds that are asked for their limits, beside none
_SAME = 1e-7


def best_design(known: Asked) -> tuple[float, bool]:
    """Of the best preload "b" and profile of a contact within random bounds, of which the depth is in the slip that the mean load makes."""
    if known.case.seed % EVERY:
        raise NotAsked
    system, cycle, friction = known.args
    rng = np.random.default_rng([known.case.seed, 7])
    most, depth = rng.uniform(0.0, 0.3), known.length * 10.0 ** rng.uniform(-2, 0.5)
    model = fo.DesignModel(system, cycle, preloads=["b"], profile=True)
    design = model.solve(friction, [cp.abs(model.preload) <= most, cp.abs(model.profile) <= depth])
    built = design.system, design.cycle, friction
    again = fo.shakedown_limit(*built, open=design.open)
    same("the design built in", again.load_factor, design.load_factor, _SAME, _SAME)
    same("the least load factor of the design", again.least, design.least, _SAME, _SAME)
    if design.least > 0:
        # A search may prefer a limit with other openings that begins at a lower load factor.
        return max(design.residual, again.residual), True
    searched = fo.shakedown_limit(*built)
    if searched.load_factor < design.load_factor * (1 - _SAME) - _SAME:
        raise Wrong(
            f"the design built in has the limit {searched.load_factor:.9g} with the open nodes of "
            f"a search, and {design.load_factor:.9g} with its own"
        )
    shares = np.vstack(
        [np.zeros(1 + system.nodes), rng.uniform(-1, 1, (_OTHERS, 1 + system.nodes))]
    )
    for amplitude, profile in zip(most * shares[:, 0], depth * shares[:, 1:], strict=True):
        mean = {**cycle.mean, "b": cycle.mean.get("b", 0.0) + amplitude, "added": 1.0}
        shaped = system.with_gap(system.gap + np.maximum(profile, 0.0)).with_interference(
            {"added": np.maximum(-profile, 0.0)}
        )
        other = fo.shakedown_limit(shaped, fo.LoadCycle(mean, cycle.corners), friction)
        keeps_nodes_closed = not other.open.any() and other.events.empty
        if keeps_nodes_closed and other.load_factor > design.load_factor * (1 + _SAME) + _SAME:
            raise Wrong(
                f"a design within the bounds has the limit {other.load_factor:.9g}, the best one "
                f"{design.load_factor:.9g}"
            )
    return max(design.residual, again.residual), True
