"""Load factors that a mechanism proves without a program, and a search that is interrupted."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits import pose, with_open
from frictopt.limits.search import set_search
from helpers.cases import few
from helpers.interrupts import interrupted
from helpers.separation import lifted_system, pulled_system
from helpers.systems import CYCLE
from studies.validation.fuzz.cases import random_case
from studies.validation.moving_events import KINDS, contact


def cases(seed):
    """Contacts with gaps, lifted contacts, and cases of the fuzz.

    Some of them have fixed parts of the load.
    """
    rng = np.random.default_rng([seed, 47])
    nodes = int(rng.integers(2, 7))
    case = random_case(6_400_000 + seed, nodes=nodes)
    fixed = contact(640_000 + seed, KINDS[seed % len(KINDS)])
    return [
        (pulled_system(rng, nodes), CYCLE, 0.4),
        (lifted_system(rng, nodes), CYCLE, 0.005),
        (case.system, case.cycle, case.friction),
        in_space(rng, nodes),
        fixed.arguments,
    ]


def in_space(rng, nodes):
    """A contact with gaps in space; half of them slide freely, some have a shear strength."""
    G = rng.normal(size=(3 * nodes, 3 * nodes))
    if rng.random() < 0.5:
        slides = np.kron(np.eye(2, 3), np.ones(nodes)) / np.sqrt(nodes)
        G = G - (G @ slides.T) @ slides
    S = G.T @ G / (3 * nodes) + np.diag(np.repeat([0.0, 0.0, 0.3], nodes))
    loads = {name: 0.3 * rng.normal(size=3 * nodes) for name in "abc"}
    mean = np.r_[0.1 * rng.normal(size=2 * nodes), rng.uniform(0.5, 1.5, nodes)]
    mean[2 * nodes + np.flatnonzero(rng.random(nodes) < 0.3)] = -0.05
    mean[-1] *= -0.5
    system = fo.ContactSystem(
        S, rng.normal(size=(nodes, 3)), {"mean": mean, **loads}, width=np.ones(nodes)
    )
    system = system.with_gap(np.where(rng.random(nodes) < 0.4, 0.3 * rng.random(nodes), 0.0))
    if rng.random() < 0.3:
        system = system.with_shear_strength(rng.uniform(0.2, 1.0))
    corners = [{"a": 1.0}, {"b": -1.0}, {"c": 0.5}]
    fixed = [{"b": share} for share in rng.uniform(0, 0.2, 3)] if rng.random() < 0.5 else None
    cycle = fo.LoadCycle({"mean": 1.0}, corners, fixed=fixed)
    return system, cycle, rng.choice([0.005, 0.5]) * rng.uniform(0.6, 1.4, nodes)


@pytest.mark.parametrize("seed", few(range(47, 71)))
def test_no_limit_is_above_the_load_factor_that_a_mechanism_proves(seed):
    rng = np.random.default_rng([seed, 11])
    for case in cases(seed):
        closed = pose(*case, question_name="shakedown_limit")
        pulled = closed.r0[:, -1].min(axis=0) < 0
        question = with_open(closed, pulled | (rng.random(len(pulled)) < 0.2))
        if question is None or question.open_nodes.all():
            continue
        tried = question.load_unit * np.geomspace(1e-3, 1e3, 13)
        proven = [
            load_factor for load_factor in tried if set_search.is_at_most(question, load_factor)
        ]
        if proven:
            limit = fo.shakedown_limit(*case, open_nodes=question.open_nodes).load_factor
            assert not limit > min(proven) * (1 + 1e-9)


def test_an_interrupted_search_keeps_a_proven_limit():
    flat = fo.scenes.PunchOnHalfPlane(elements=24).condense()
    rounded = flat.with_gap(2.0 * flat.x**4)
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    with interrupted("open nodes", 3) as stopped:
        fo.shakedown_limit(rounded, cycle, 0.6)
    limit = stopped.value.limit
    assert limit.load_factor > 0 and limit.residual < 1e-9
    assert limit.bound == pytest.approx(limit.load_factor, rel=1e-8)
