"""What is asked of a random case about all starts: the least slip, the found range of dissipation, and the practical limit."""

import numpy as np

import frictopt as fo

from .known import Known, NotAsked, Wrong, same

_CYCLES = 4  # followed to hold the least slip against
_BRUTE = 40  # followed to see what becomes of a start
_MOST_NODES, _EVERY = 6, 16  # cases that are asked for a range or a practical limit, which follow many transients
_WITHIN = 1e-8  # shortfall of the weighted slip, over the sum of the sizes of its terms, that counts as rounding


def least_slip(known: Known) -> tuple[float, bool]:
    """No cycle of a transient slips less than the multipliers of the limit prove, opened or not, periodic or not."""
    if not known.finite:
        raise NotAsked
    least = known.answered_limit.least_slip(known.load_factor)
    path = fo.march(*known.args, known.load_factor, initial_slip=known.case.start, cycles=_CYCLES)
    at = np.searchsorted(path.time, np.arange(1, _CYCLES * len(known.case.cycle.corners) + 0.5) + 1e-9) - 1
    for slip, gap in zip(*(values[at].reshape(_CYCLES, *least.g.shape) for values in (path.slip, path.gap)), strict=True):
        size = abs(least.bound) + known.load_factor + float(np.abs(least.g * slip).sum() + np.abs(least.h * gap).sum())
        if least.of(slip, gap) < least.bound - _WITHIN * size:
            raise Wrong(f"a cycle slips {least.of(slip, gap):.9g}, less than the bound {least.bound:.9g}")
    return max(least.residual, path.residual), True


def found_range(known: Known) -> tuple[float, bool]:
    """Both ends of the range are dissipated for ever from their starts; without coupling they are one, above the limit the least is not 0."""
    case = known.case
    if case.system.nodes > _MOST_NODES or case.seed % _EVERY:
        raise NotAsked
    span = fo.dissipation_range(*known.args, known.load_factor)
    scale = known.force * known.length * max(1.0, known.load_factor) ** 2
    compared = False
    for name, work, start in (("least", span.least, span.least_start), ("most", span.most, span.worst_start)):
        try:
            works = fo.march(*known.args, known.load_factor, initial_slip=start, cycles=_BRUTE).cycle_work.sum(axis=1)
        except fo.SolverError:  # slips so large that their rounding hides the cycle
            continue
        spread = float(np.abs(start).max()) * known.force
        same(f"{name} work", work, float(works[-1]), 1e-6, 1e-8 * (scale + spread) + 10 * float(abs(works[-1] - works[-4])))
        compared = True
    if not case.system.B.any() and not span.most_state.open.any() and not span.least_state.open.any():
        same("least and most without coupling", span.least, span.most, 1e-6, 1e-8 * scale)
    return span.residual, compared


def limit_after_protocol(known: Known) -> tuple[float, bool]:
    """From the case's own start, slip stops at the limit and goes on above it, as cycles followed show."""
    case = known.case
    if case.system.nodes > _MOST_NODES or case.seed % _EVERY or not known.finite or known.answered_limit.load_factor == 0:
        raise NotAsked
    start = np.zeros(case.system.nodes) if case.start is None else case.start
    one = fo.limit_after_protocol(*known.args, start=start, scan=5, tolerance=1e-2)
    works = []
    for factor in (one.load_factor, one.upper):
        if 0 < factor < np.inf:
            steady = fo.steady_state(*known.args, factor, initial_slip=start) if factor == one.load_factor else None
            if steady is not None and steady.outcome is not fo.Outcome.SHAKEDOWN:
                raise Wrong(f"{steady.outcome.name} at the practical limit {factor:.9g}")
            brute = fo.march(*known.args, factor, initial_slip=start, cycles=_BRUTE).cycle_work.sum(axis=1)
            works.append((factor, float(brute[-1]), float(brute[-2])))
    size = known.force * (known.length + float(np.abs(start).max()))
    for factor, last, before in works:
        if factor == one.load_factor and last > 1e-7 * size * max(1.0, factor) ** 2 and last > 0.999 * before:
            raise Wrong(f"cycles still dissipate {last:.3e} at the practical limit {factor:.9g}")
    return one.residual, bool(works)
