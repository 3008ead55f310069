"""The quick limits of the search against proven ones, and a search that is misled by them."""

from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits import (
    best_set,
    pose,
    quick_bound,
    quick_limits,
    quick_space,
    shakedown,
    with_open,
)
from helpers import spatial
from helpers.cases import few
from helpers.separation import lifted_system, pulled_system
from helpers.systems import CYCLE
from validation.fuzz.cases import random_case
from validation.moving_events import KINDS, contact

quick_limit = quick_limits.quick_limit

UNIT = 1e-6  # largest difference of the two limits, in units of the load


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


@pytest.mark.parametrize("seed", few(range(4, 28)))
def test_a_quick_limit_is_the_proven_one(seed):
    for case in cases(seed):
        closed = pose(*case, question_name="shakedown_limit")
        opened = np.random.default_rng(seed).random(case[0].nodes) < 0.3
        if case[0].tangents == 2:
            opened = closed.r0[:, -1].min(axis=0) < 0
        question = with_open(closed, opened & (np.arange(case[0].nodes) > 0))
        if question is None:
            continue
        proven = fo.shakedown_limit(*case, open=question.open_nodes)
        try:
            quick = quick_limit(question)
        except fo.SolverError:
            assert proven.load_factor == np.inf
            continue
        error = UNIT * question.load_unit
        assert quick.load_factor == pytest.approx(proven.load_factor, abs=error, nan_ok=True)
        assert quick.least == pytest.approx(proven.least, abs=error, nan_ok=True)
        if error < proven.load_factor:
            assert question.violation(quick.load_factor, quick.slip) < 1e-7
            # The multipliers prove the limit: their mechanism dissipates what the loads do.
            drive = quick._motion.drive(question)
            assert drive == pytest.approx(1.0, rel=1e-6)
            # Its net motion of closed nodes causes no stress (`Mechanism`).
            net = quick._motion.moves.sum(axis=0).ravel()
            closed_slips = np.flatnonzero(~question.open_nodes)
            stress = (question.system.S @ net)[closed_slips]
            scale = np.abs(question.system.S) @ np.abs(quick._motion.moves).sum(axis=0).ravel()
            assert np.abs(stress).max() < 1e-6 * scale.max()


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
            load_factor for load_factor in tried if quick_bound.is_at_most(question, load_factor)
        ]
        if proven:
            limit = fo.shakedown_limit(*case, open=question.open_nodes).load_factor
            assert not limit > min(proven) * (1 + 1e-9)


@pytest.mark.parametrize("friction", [0.9, 1.2, 1.5])
def test_the_edge_of_a_punch_that_a_mechanism_keeps_closed_needs_no_program(
    punch, paper_cycle, friction, monkeypatch
):
    """A mechanism proves without a program that the edge of a punch stays closed.

    The load presses the edge nodes: to open one of them divides the limit by about fifty.
    """
    contact = punch(24)
    programs = []
    monkeypatch.setattr(quick_limits, "_QuickProgram", lambda question: programs.append(question))
    limit = fo.shakedown_limit(contact, paper_cycle, friction)
    edges = [[0], [contact.nodes - 1], [0, contact.nodes - 1]]
    for edge in edges:
        opened = np.isin(np.arange(contact.nodes), edge)
        assert (
            fo.shakedown_limit(contact, paper_cycle, friction, open=opened).load_factor
            < limit.load_factor
        )
    assert not programs and not limit.open.any()


@pytest.mark.parametrize("seed", few(range(12)))
def test_the_search_by_quick_limits_ends_where_that_by_proven_ones_does(seed, monkeypatch):
    case = cases(seed)[seed % 4]
    quick = fo.shakedown_limit(*case)
    assert not quick.residual > 1e-9
    monkeypatch.setattr(best_set, "quick_limit", refused)
    slow = fo.shakedown_limit(*case)
    assert (slow.open == quick.open).all()
    assert quick.load_factor == pytest.approx(slow.load_factor, rel=1e-7, nan_ok=True)
    assert quick.least == pytest.approx(slow.least, rel=1e-7, abs=1e-12, nan_ok=True)


def refused(question, above):
    raise fo.SolverError("none")


@pytest.mark.parametrize("wrong", [{"load_factor": 3.0}, {"least": -1.0}])
def test_a_search_that_quick_limits_mislead_is_made_again(wrong, monkeypatch):
    case = pulled_system(np.random.default_rng([3, 12]), 4), CYCLE, 0.5
    right = fo.shakedown_limit(*case)
    assert right.open.any() and right.load_factor > 0

    def misled(question, above):
        quick = quick_limit(question, above)
        changes = {name: factor * right.load_factor for name, factor in wrong.items()}
        return replace(quick, **changes) if question.open_nodes.sum() == 2 else quick

    monkeypatch.setattr(best_set, "quick_limit", misled)
    limit = fo.shakedown_limit(*case)
    assert limit.load_factor == pytest.approx(right.load_factor, rel=1e-9)
    assert limit.residual < 1e-9 and limit.least == right.least


def test_only_multipliers_say_that_a_limit_in_space_is_not_above_another(monkeypatch):
    """Only multipliers prove that a limit in space is not above another limit.

    A solver may call the point at which rounding ended its steps an optimum.
    """
    rng = np.random.default_rng([5, 47])
    question = pose(spatial.random_contact(rng, 4), spatial.cycle(), 0.6)
    right = quick_limit(question).load_factor
    assert right > 0
    assert quick_limit(question, 0.5 * right).load_factor == pytest.approx(right, rel=1e-6)
    assert np.isnan(quick_limit(question, 2 * right).load_factor)

    honest = quick_space.run

    def ended_early(program, *options):
        outcome, x, y = honest(program, *options)
        return outcome, 0.1 * x, 0.0 * y

    monkeypatch.setattr(quick_space, "run", ended_early)
    for above in (-np.inf, 0.5 * right):
        with pytest.raises(fo.SolverError, match="has the bound"):
            quick_limit(question, above)
    monkeypatch.setattr(
        quick_space, "run", lambda *arguments: ("infeasible", *honest(*arguments)[1:])
    )
    with pytest.raises(fo.SolverError, match="no multipliers prove"):
        quick_limit(question)


def test_a_load_factor_that_is_an_error_of_the_solver_is_zero(monkeypatch):
    """A load factor that is an error of the solver counts as zero.

    All load factors up to the limit are safe, but the solver returns 1e-9 units for the least one.
    """
    rng = np.random.default_rng([5, 47])
    question = pose(spatial.random_contact(rng, 4), spatial.cycle(), 0.6)
    honest = quick_space.ConeProgram.state

    def state(program, x):
        load_factor, slip = honest(program, x)
        return load_factor + 1e-9 * question.load_unit, slip

    right = quick_limit(question)
    monkeypatch.setattr(quick_limits, "RESIDUAL", -1.0)  # the second program is always solved
    monkeypatch.setattr(quick_space.ConeProgram, "state", state)
    assert right.least == 0 and quick_limit(question).least == 0
    monkeypatch.setattr(
        quick_space.ConeProgram, "state", lambda *arguments: (1e-9 * question.load_unit, right.slip)
    )
    assert quick_limit(question).load_factor == 0


def test_an_interrupted_search_keeps_a_proven_limit(monkeypatch):
    flat = fo.scenes.PunchOnHalfPlane(elements=24).condense()
    rounded = flat.with_gap(2.0 * flat.x**4)
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    safe = []

    def stopped(question, above):
        if safe:
            raise KeyboardInterrupt
        limit = quick_limit(question, above)
        if limit.load_factor > 0:
            safe.append(limit)
        return limit

    monkeypatch.setattr(best_set, "quick_limit", stopped)
    with pytest.raises(KeyboardInterrupt) as interrupt:
        fo.shakedown_limit(rounded, cycle, 0.6)
    limit = interrupt.value.limit
    assert isinstance(limit, shakedown.ShakedownLimit) and limit.residual < 1e-9
    assert limit.bound == pytest.approx(limit.load_factor, rel=1e-8)


def test_of_a_search_in_the_plane_only_the_best_set_is_compiled(monkeypatch):
    flat = fo.scenes.PunchOnHalfPlane(elements=24).condense()
    rounded = flat.with_gap(4.0 * flat.x**4)
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    proven = []
    quick = []
    of_set = shakedown.ShakedownLimits.of_set

    def counted(self, *args, **options):
        proven.append(1)
        return of_set(self, *args, **options)

    def counted_quick(question, above):
        quick.append(1)
        return quick_limit(question, above)

    monkeypatch.setattr(shakedown.ShakedownLimits, "of_set", counted)
    monkeypatch.setattr(best_set, "quick_limit", counted_quick)
    limit = fo.shakedown_limit(rounded, cycle, 0.6)
    assert limit.open.any() and limit.residual < 1e-9
    assert len(proven) <= 2 < len(quick)
