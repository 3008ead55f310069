"""The error of increments in space in the work of friction, and its estimate `step_error`.

The true work is extrapolated from many more increments, or known in closed form.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.spatial import cycle, random_contact, single

ABOVE = [1.05, 1.15, 1.3, 1.6, 2.0]
# Slow decay, nodes that slip only in the first cycles, errors that cancel, slip close to a corner.
HARD = [1, 11, 14, 16, 23, 29, 31, 35, 36, 38]


def problem(seed, most_nodes=5, most_corners=3, ratios=ABOVE):
    """A random contact, its loads and friction, and its limit times one of some ratios."""
    rng = np.random.default_rng(seed)
    contact = random_contact(rng, int(rng.integers(1, most_nodes + 1)))
    friction = float(rng.choice([0.2, 0.35, 0.5]))
    loads = cycle(int(rng.integers(2, most_corners + 1)))
    ratio = float(rng.choice(ratios))
    limit = fo.shakedown_limit(contact, loads, friction)
    return contact, loads, friction, ratio * limit.load_factor


def estimated_over_true_errors(question, numbers, many):
    """Ratios of the estimated to the true error, one for each number of increments.

    The true work is extrapolated from `many` increments and twice as many. A ratio is inf if there
    is no true error, or if no error could be estimated.
    """
    fine = fo.steady_state(*question, steps=many, progress=False)
    finest = fo.steady_state(*question, steps=2 * many, initial_state=fine.state, progress=False)
    work = 2 * finest.dissipation - fine.dissipation
    states = [fo.steady_state(*question, steps=steps, progress=False) for steps in numbers]
    true = np.array([abs(work - state.dissipation) for state in states])
    estimated = np.array(
        [
            state.step_error * state.dissipation if np.isfinite(state.step_error) else np.inf
            for state in states
        ]
    )
    return np.where(true > 1e-9 * work, estimated / np.maximum(true, 1e-9 * work), np.inf)


@pytest.mark.parametrize("seed", few(HARD))
def test_the_estimated_error_is_not_below_the_true_error(seed):
    assert min(estimated_over_true_errors(problem(seed), [1, 2, 4], 16)) >= 1


def test_the_estimated_errors_of_random_contacts_are_two_to_three_times_the_true_errors():
    ratios = np.array(
        [estimated_over_true_errors(problem(seed), [1, 2, 4], 16) for seed in range(10)]
    )
    assert ratios.min() >= 1 and (np.median(ratios, axis=0) <= 3).all()


def work_of_a_rope(corners, cycles=20000):
    """Work per cycle of a node on a rope of length 1 behind a point that goes round some corners.

    On each segment the node follows a tractrix, in closed form.
    """
    node, last = np.zeros(2), np.inf
    for _ in range(cycles):
        slip_length = 0.0
        for begin, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            length = np.linalg.norm(end - begin)
            along = (end - begin) / length
            arm = begin - node
            aside = arm - (arm @ along) * along
            # Distance that the point moves until the rope is taut.
            slack = max(np.sqrt(max(1 - aside @ aside, 0.0)) - arm @ along, 0.0)
            if slack >= length:
                continue
            rope = begin + slack * along - node
            across = rope - (rope @ along) * along
            sine = np.linalg.norm(across)
            angle = 2 * np.arctan(
                np.tan(np.arctan2(sine, rope @ along) / 2) * np.exp(slack - length)
            )
            slip_length += np.log(sine / np.sin(angle))
            node = end - np.cos(angle) * along - np.sin(angle) * across / sine
        if abs(slip_length - last) <= 1e-13 * slip_length:
            break
        last = slip_length
    return slip_length


@pytest.mark.parametrize("count", [3, 4, 6])
@pytest.mark.parametrize("factor", [1.00001, 1.0003, 1.002, 1.005])
def test_the_estimated_error_next_to_the_limit_is_not_below_the_true_error(count, factor):
    """One node slips only shortly before each corner.

    Increments from corner to corner are much longer than the part of the segment where it slips.
    """
    angles = 2 * np.pi * np.arange(count) / count
    loads = fo.LoadCycle(
        {"P": 1.0}, [{"X": float(np.cos(angle)), "Y": float(np.sin(angle))} for angle in angles]
    )
    work = work_of_a_rope(factor * np.column_stack([np.cos(angles), np.sin(angles)]))
    for steps in (1, 4, 20):
        steady = fo.steady_state(single(), loads, 1.0, factor, steps=steps, progress=False)
        true_error = abs(steady.dissipation / work - 1)
        assert true_error < steady.step_error < 3 * true_error


def test_a_contact_at_rest_has_no_error():
    loads = fo.LoadCycle({"P": 1.0}, [{"X": 1.0}, {"X": -1.0}])
    for steps in (1, 2, 20):
        assert fo.steady_state(single(), loads, 0.5, 0.3, steps=steps).step_error == 0
