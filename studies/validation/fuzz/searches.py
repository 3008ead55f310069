"""The questions about all starts and all designs of a random contact, in the plane and in space."""

import cvxpy as cp
import numpy as np

import frictopt as fo
from studies.validation.fuzz.known import NotApplicable, Subject, Wrong, same

# Number of cycles that are compared with the least slip.
_CYCLES = 4
# Number of cycles that are followed to find the outcome of a start.
_BRUTE = 40
# A range or a limit after a protocol follows many transients. Only one case in this many has them,
# and only contacts of at most this many nodes.
_EVERY = 16
_MOST_NODES = 6
# Shortfall of the weighted slip that counts as rounding, relative to the sum of the sizes of its
# terms.
_WITHIN = 1e-8


def least_slip(known: Subject) -> tuple[float, bool]:
    """Compare the proven least slip with the cycles of a transient.

    No cycle may slip less, whether the transient is periodic or not. With open nodes the proof
    holds for fewer cycles, so these cases are not compared.
    """
    if not known.finite or known.answered_limit.open.any():
        raise NotApplicable
    case = known.case
    least = known.answered_limit.least_slip((1 + case.share) * known.answered_limit.load_factor)
    path = fo.march(
        *known.args,
        least.load_factor,
        initial_slip=case.start,
        cycles=_CYCLES,
        **known.options,
    )
    corner_times = np.arange(1, _CYCLES * len(case.cycle.corners) + 0.5)
    at_corners = np.searchsorted(path.time, corner_times + 1e-9) - 1
    slips = path.slip[at_corners].reshape(_CYCLES, *least.g.shape)
    gaps = path.gap[at_corners].reshape(_CYCLES, *least.h.shape)
    for slip, gap in zip(slips, gaps, strict=True):
        size_of_terms = float(np.abs(least.g * slip).sum() + np.abs(least.h * gap).sum())
        size = abs(least.bound) + least.load_factor + size_of_terms
        weighted_slip = least.of(slip, gap)
        if weighted_slip < least.bound - _WITHIN * size:
            raise Wrong(f"a cycle slips {weighted_slip:.9g}, less than the bound {least.bound:.9g}")
    return max(least.residual, path.residual), True


def dissipation_range(known: Subject) -> tuple[float, bool]:
    """Compare both ends of the range of the work with transients from their starts.

    Without coupling both ends are equal. The start without slip leads to a work between them.
    """
    case = known.case
    if case.system.nodes > _MOST_NODES or case.seed % _EVERY:
        raise NotApplicable
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
        except fo.SolverError:
            # The slips are so large that their rounding hides the cycle.
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
    uncoupled = not case.system.B.any()
    opens = span.most_state.open.any() or span.least_state.open.any()
    if uncoupled and not opens:
        same("least and most without coupling", span.least, span.most, 1e-6, 1e-8 * scale)
    work = fo.steady_state(*known.args, known.load_factor, **known.options).dissipation
    low = span.least * (1 - 1e-6) - 1e-8 * scale
    high = span.most * (1 + 1e-6) + 1e-8 * scale
    if not low <= work <= high:
        raise Wrong(
            f"no slip leads to the work {work:.9g}, outside {span.least:.9g} to {span.most:.9g}"
        )
    return span.residual, compared


def limit_after_protocol(known: Subject) -> tuple[float, bool]:
    """Compare the limit after a protocol with steady states and transients from the same start.

    Slip must stop at the limit and continue above it.
    """
    case = known.case
    if case.system.nodes > _MOST_NODES or case.seed % _EVERY:
        raise NotApplicable
    if not known.finite or known.answered_limit.load_factor == 0:
        raise NotApplicable
    start = np.zeros(case.system.slip_shape) if case.start is None else case.start
    limit = fo.limit_after_protocol(
        known.answered_limit, start=start, scan=5, tolerance=1e-2, **known.options
    )
    size = known.force * (known.length + float(np.abs(start).max()))
    compared = False
    for factor, slip_stops in ((limit.load_factor, True), (limit.upper, False)):
        if not 0 < factor < np.inf:
            continue
        try:
            steady = fo.steady_state(*known.args, factor, initial_slip=start, **known.options)
        except (fo.NoContinuation, fo.SolverError):
            continue
        outcome = steady.outcome
        if slip_stops != (outcome is fo.Outcome.SHAKEDOWN):
            raise Wrong(
                f"{outcome.name} at {factor:.9g}, between {limit.load_factor:.9g} and "
                f"{limit.upper:.9g}"
            )
        path = fo.march(*known.args, factor, initial_slip=start, cycles=_BRUTE, **known.options)
        before, last = path.cycle_work.sum(axis=1)[-2:]
        dissipates = last > 1e-7 * size * max(1.0, factor) ** 2 and last > 0.999 * before
        if slip_stops and dissipates:
            raise Wrong(
                f"cycles still dissipate {last:.3e} at the limit after a protocol {factor:.9g}"
            )
        compared = True
    return limit.residual, compared


EVERY = 4
"""A question that computes tens of limits is answered for one case in this many."""
# Number of random designs within the bounds that are compared with the best one.
_OTHERS = 3
_SAME = 1e-7


def best_design(known: Subject) -> tuple[float, bool]:
    """Check the best preload "b" and the best profile of a contact within random bounds.

    The limit of the contact with the design built in must be the limit of the design. No other
    design within the bounds may have a larger limit with closed nodes.
    """
    if known.case.seed % EVERY:
        raise NotApplicable
    system, cycle, friction = known.args
    rng = np.random.default_rng([known.case.seed, 7])
    largest_preload = rng.uniform(0.0, 0.3)
    # The depth is measured in slips that the mean load makes.
    depth = known.length * 10.0 ** rng.uniform(-2, 0.5)
    model = fo.DesignModel(system, cycle, preloads=["b"], profile=True)
    bounds = [cp.abs(model.preload) <= largest_preload, cp.abs(model.profile) <= depth]
    design = model.solve(friction, bounds)
    built = design.system, design.cycle, friction
    built_limit = fo.shakedown_limit(*built, open_nodes=design.open)
    same("the design built in", built_limit.load_factor, design.load_factor, _SAME, _SAME)
    same("the least load factor of the design", built_limit.least, design.least, _SAME, _SAME)
    residual = max(design.residual, built_limit.residual)
    if design.least > 0:
        # A search may prefer a limit with other openings that begins at a lower load factor.
        return residual, True
    searched = fo.shakedown_limit(*built)
    if searched.load_factor < design.load_factor * (1 - _SAME) - _SAME:
        raise Wrong(
            f"the design built in has the limit {searched.load_factor:.9g} with the open nodes of "
            f"a search, and {design.load_factor:.9g} with its own"
        )
    shares = np.vstack(
        [np.zeros(1 + system.nodes), rng.uniform(-1, 1, (_OTHERS, 1 + system.nodes))]
    )
    preloads = largest_preload * shares[:, 0]
    profiles = depth * shares[:, 1:]
    for amplitude, profile in zip(preloads, profiles, strict=True):
        mean = {**cycle.mean, "b": cycle.mean.get("b", 0.0) + amplitude, "added": 1.0}
        shaped = system.with_gap(system.gap + np.maximum(profile, 0.0)).with_interference(
            {"added": np.maximum(-profile, 0.0)}
        )
        limit = fo.shakedown_limit(shaped, fo.LoadCycle(mean, cycle.corners), friction)
        keeps_nodes_closed = not limit.open.any() and limit.events.empty
        if keeps_nodes_closed and limit.load_factor > design.load_factor * (1 + _SAME) + _SAME:
            raise Wrong(
                f"a design within the bounds has the limit {limit.load_factor:.9g}, the best one "
                f"{design.load_factor:.9g}"
            )
    return residual, True
