"""The shakedown limit at the paper's size against a bare HiGHS call on the same arrays.

Required friction is compared with the limit.
"""

import pickle

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits import pose
from frictopt.limits.program import assembled
from studies.validation.error_vs_time.bare_lp import SIMPLEX, LinearProgram, highs, highs_cost
from studies.validation.error_vs_time.plain import plain_limit

OPTIONS = {"defaults": {}, "primal simplex": SIMPLEX}


def arrays(system, cycle, friction, **options):
    """The arrays of a limit of the closed contact, as frictopt solves them."""
    program = assembled.shakedown(pose(system, cycle, friction, **options))
    return LinearProgram.of(program)


@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("simplify", [True, False])
def test_limit_of_a_model_against_bare_highs(compare, system, cycle, options, simplify):
    model = fo.ShakedownModel(system, cycle, simplify=simplify)
    limit = model.solve(0.7)
    program = arrays(system, cycle, 0.7, simplify=simplify)
    assert -highs_cost(highs(program, OPTIONS[options])) == pytest.approx(
        limit.load_factor, rel=1e-7
    )
    assert (
        compare(lambda: model.solve(0.7), lambda: highs(program, OPTIONS[options]), rounds=25) < 1.5
    )


@pytest.mark.parametrize("nodes", [125, 251, 501])
def test_first_time_against_bare_highs(compare, cycle, nodes):
    """The first limit of a contact keeps nothing from an earlier one."""
    system = fo.scenes.PunchOnHalfPlane(elements=nodes - 1).condense()
    program = arrays(system, cycle, 0.7)
    fresh = pickle.dumps(system)  # a copy has no cached results
    ratio = compare(
        lambda: fo.shakedown_limit(pickle.loads(fresh), cycle, 0.7),
        lambda: highs(program, {}),
    )
    assert ratio < 2.5


@pytest.mark.parametrize("solver", ["HIGHS", "CLARABEL"])
def test_first_time_against_plain_cvxpy(compare, system, cycle, solver):
    """The same problem in a dozen lines, which proves nothing."""
    ours = fo.shakedown_limit(system, cycle, 0.7).load_factor
    assert plain_limit(system, cycle, 0.7, solver) == pytest.approx(ours, rel=1e-7)
    fresh = pickle.dumps(system)
    ratio = compare(
        lambda: fo.shakedown_limit(pickle.loads(fresh), cycle, 0.7),
        lambda: plain_limit(system, cycle, 0.7, solver),
    )
    assert ratio < 0.4


def test_first_time_of_40_corners_against_two(compare, system, cycle):
    angles = 2 * np.pi * np.arange(40) / 40
    many = fo.LoadCycle(
        {"P": 1.0}, [{"sigma": float(np.cos(a)), "P": 0.1 * float(np.sin(a))} for a in angles]
    )
    ratio = compare(
        lambda: fo.shakedown_limit(system, many, 0.7),
        lambda: fo.shakedown_limit(system, cycle, 0.7),
    )
    assert ratio < 8.0


def test_sweep_of_50_against_bare_highs(compare, system, cycle):
    """Bare HiGHS on all rows of the closed contact, one program for each friction.

    A sweep needs these programs, too. For half of the frictions nodes tend to open. All questions
    about open nodes may together cost as much as these programs.
    """
    frictions = np.linspace(0.2, 1.5, 50)
    programs = [arrays(system, cycle, friction, simplify=False) for friction in frictions]
    assert (
        compare(
            lambda: fo.ShakedownModel(system, cycle).sweep(frictions),
            lambda: [highs(program, SIMPLEX) for program in programs],
            rounds=3,
        )
        < 2.0
    )


def test_other_loads_on_one_model_against_models_of_their_own(compare, system, cycle):
    """Mean loads, amplitudes and friction vary, with closed nodes."""
    model = fo.ShakedownModel(system, cycle)
    none_open = np.zeros(system.nodes, dtype=bool)
    asked = [
        (fo.LoadCycle({"P": P}, [{"sigma": -amplitude, "Q": 0.05}, {"sigma": amplitude}]), friction)
        for P, amplitude, friction in [(1.0, 1.0, 0.4), (0.7, 1.3, 0.6), (1.5, 0.8, 0.9)]
    ]
    assert (
        compare(
            lambda: [model.solve(f, cycle=other, open_nodes=none_open) for other, f in asked],
            lambda: [
                fo.shakedown_limit(system, other, f, open_nodes=none_open) for other, f in asked
            ],
        )
        < 0.7
    )


def test_swept_loads_and_friction_against_bare_highs(compare, system, cycle):
    """Twenty loads and frictions on one model with closed nodes, against HiGHS on the same rows."""
    model = fo.ShakedownModel(system, cycle)
    none_open = np.zeros(system.nodes, dtype=bool)
    rng = np.random.default_rng(0)
    asked = [
        (fo.LoadCycle({"P": P}, [{"sigma": -amplitude, "Q": 0.05}, {"sigma": amplitude}]), friction)
        for P, amplitude, friction in rng.uniform([0.7, 0.7, 0.5], [1.5, 1.4, 1.0], (20, 3))
    ]
    programs = []
    for other, friction in asked:
        limit = model.solve(friction, cycle=other, open_nodes=none_open)
        programs.append(arrays(system, other, friction))
        bare = -highs_cost(highs(programs[-1], SIMPLEX))
        assert bare == pytest.approx(limit.load_factor, rel=1e-7)
    assert (
        compare(
            lambda: [model.solve(f, cycle=other, open_nodes=none_open) for other, f in asked],
            lambda: [highs(program, SIMPLEX) for program in programs],
        )
        < 2.1
    )


def test_sweep_with_its_search_against_the_closed_contact(compare, system, cycle):
    """A sweep of eight frictions, against eight limits with closed nodes.

    For six of the frictions some node tends to open.
    """
    frictions = np.linspace(0.3, 1.2, 8)
    model = fo.ShakedownModel(system, cycle)
    none_open = np.zeros(system.nodes, dtype=bool)
    assert (
        compare(
            lambda: model.sweep(frictions),
            lambda: [model.solve(friction, open_nodes=none_open) for friction in frictions],
            rounds=3,
        )
        < 2.8
    )


def test_sweep_against_solving_from_scratch(compare, system, cycle):
    frictions = np.linspace(0.2, 1.5, 10)
    assert (
        compare(
            lambda: fo.ShakedownModel(system, cycle).sweep(frictions),
            lambda: [fo.shakedown_limit(system, cycle, f) for f in frictions],
        )
        < 1.0
    )


@pytest.mark.parametrize("ratio", [0.5, 0.9, 1.05])
def test_required_friction_against_the_limit(compare, system, cycle, ratio):
    load_factor = ratio * fo.shakedown_limit(system, cycle, 0.7).load_factor
    assert (
        compare(
            lambda: fo.required_friction(system, cycle, load_factor),
            lambda: fo.shakedown_limit(system, cycle, 0.7),
        )
        < 6.0
    )


def test_required_friction_in_space_against_the_limit(compare, cycle):
    system = fo.scenes.SquarePunch(elements=9).condense()
    load_factor = 0.9 * fo.shakedown_limit(system, cycle, 0.7).load_factor
    assert (
        compare(
            lambda: fo.required_friction(system, cycle, load_factor),
            lambda: fo.shakedown_limit(system, cycle, 0.7),
            rounds=3,
        )
        < 6.0
    )
