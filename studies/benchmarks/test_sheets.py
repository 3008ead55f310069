"""Sheets of joints: probabilities against draws, verdicts inside of their scatter, and time."""

import numpy as np
import pytest
from scipy.stats import lognorm, norm
from test_spatial import ratio, seconds
from test_within_gap import random_contact

import frictopt as fo
from frictopt.joints.thresholds import QUANTITIES
from joints import PULL, lap_of_three_bolts

DRAWS = 2000
CONTACTS = 40


def _random_limit(rng):
    """A finite limit of a contact of few nodes, with all nodes closed."""
    while True:
        contact, cycle = random_contact(rng, 1, rng.uniform(0, 0.6), below=8)
        closed = np.zeros(contact.nodes, dtype=bool)
        limit = fo.shakedown_limit(contact, cycle, rng.uniform(0.3, 0.8), open_nodes=closed)
        if 0 < limit.load_factor < np.inf:
            return limit


def _safe_draws(limit, law, preload, load, rng):
    """The number of draws of friction and preload with a safe slip at a load.

    Without gaps a slip scales with the preload, so only the ratio of load to preload counts. A slip
    that is safe stays safe with more friction. So limits at 24 frictions decide most draws.
    """

    def range_of(friction):
        asked = limit.system, limit.cycle, friction
        safe = fo.shakedown_limit(*asked, open_nodes=limit.open)
        return safe.least, safe.load_factor

    frictions = law.rvs(DRAWS, random_state=rng)
    ratios = load / preload.rvs(DRAWS, random_state=rng)
    grid = np.quantile(frictions, np.linspace(0, 1, 24))
    least, most = np.transpose([range_of(friction) for friction in grid])
    safe = (least[:, None] <= ratios) & (ratios <= most[:, None])  # at each friction of the grid
    count = 0
    for friction, ratio_of_draw, at_grid in zip(frictions, ratios, safe.T, strict=True):
        if at_grid[grid <= friction].any():
            count += 1
        elif at_grid[grid >= friction].all():
            low, high = range_of(friction)
            count += low <= ratio_of_draw <= high
    return count


def test_probabilities_are_those_of_draws(record_property):
    """In 40 random contacts a probability differs from the share of 2,000 draws by at most 3.5 standard errors."""
    rng = np.random.default_rng(11)
    errors = []
    for number in range(CONTACTS):
        limit = _random_limit(rng)
        law = lognorm(0.15, scale=limit.friction[0])
        preload, load = norm(1.0, 0.08), limit.load_factor * rng.uniform(0.8, 1.1)
        random = limit.probability(friction=law, preload={"P": preload}, load=load, seed=number)
        share = _safe_draws(limit, law, preload, load, rng) / DRAWS
        of_draws = ((share * (1 - share) + 1 / DRAWS) / DRAWS) ** 0.5
        errors.append(abs(random.probability - share) / np.hypot(of_draws, random.standard_error))
        print(f"    {random.probability:.4f}, draws {share:.4f}, {errors[-1]:.2f} standard errors")
    record_property("largest", max(errors))
    assert max(errors) <= 3.5  # one of 40 differences is larger in 2 % of all runs


def test_no_verdict_passed_fails_inside_of_its_scatter(record_property):
    """60 random joints with scatter of friction, preload and load, 10 inputs in each."""
    rng = np.random.default_rng(5)
    passed = failed = 0
    for _ in range(60):
        limit = _random_limit(rng)
        factor = limit.load_factor * rng.uniform(0.8, 1.6)
        corners = [{case: factor * x for case, x in each.items()} for each in limit.cycle.corners]
        cycle = fo.LoadCycle(limit.cycle.mean, corners)
        nominal = float(limit.friction[0])
        at_load = fo.steady_state(limit.system, cycle, nominal, 1.0)
        limits = {
            name: QUANTITIES[name].judged(at_load).value * rng.uniform(1.0, 8.0) + 1e-9
            for name in ("slip range", "work")
        }
        ends = 0.85 * nominal, nominal, 1.15 * nominal
        sheet = fo.report(
            *(limit.system, cycle, ends, [1.0]),
            preload={"P": (0.9, 1.1)}, load=(0.9, 1.1), limits=limits, pages=2, progress=False,
        )  # fmt: skip
        for verdict in sheet.verdicts.query("passed").itertuples():
            passed += 1
            for _ in range(10):
                inside = fo.LoadCycle({"P": rng.uniform(0.9, 1.1)}, corners)
                steady = fo.steady_state(
                    limit.system, inside, rng.uniform(*ends[::2]), rng.uniform(0.9, 1.1)
                )
                value = QUANTITIES[verdict.quantity].judged(steady).value
                if value > verdict.limit * (1 + 1e-9):
                    failed += 1
                    break
    record_property("passed", passed)
    print(f"\n    {failed} of {passed} verdicts 'passed' fail inside of their scatter")
    assert failed == 0


def test_the_first_page_of_a_lap_in_steady_states(tmp_path, record_property):
    """The first page of a lap with three bolts takes the time of at most three steady states."""
    system, model = lap_of_three_bolts(tmp_path)
    # The number of nodes depends on the version of gmsh.
    assert system.nodes == pytest.approx(440, rel=0.1)
    steady = seconds(lambda: fo.steady_state(system, PULL, 0.3, 1.0, steps=2))
    page = seconds(lambda: fo.report(system, PULL, 0.3, pages=1, model=model, progress=False))
    assert ratio(page, steady, record_property) <= 3
