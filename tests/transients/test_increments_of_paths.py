"""Each increment of a path is a problem that plain cvxpy solves, in each of its forms."""

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from helpers.spatial import cycle as spatial_cycle
from helpers.spatial import random_contact
from helpers.systems import CYCLE, random_system

FINE = dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), 1e-10)


def plane_path(steps=None):
    """A path of three nodes that slip both ways, stick, open and close."""
    contact = random_system(np.random.default_rng(3), 3).with_gap([0.0, 0.1, 0.0])
    path = fo.march(contact, CYCLE, 0.4, 2.0, cycles=1, steps=steps)
    assert {*path.status.ravel().tolist()} == {-1, 0, 1, 2}
    return path


@pytest.fixture(scope="module", params=[None, 2], ids=["exact", "increments"])
def path(request):
    return plane_path(request.param)


def motions(problem):
    """Slip steps and gaps in a problem, by its form."""
    x = {variable.name(): variable.value for variable in problem.variables()}
    if "u" in x:
        n = problem.param_dict["bound"].size
        return x["u"][:-n], x["u"][-n:]
    if "z" in x:
        forward, backward, gap = np.split(x["z"], 3)
        return forward - backward, gap
    return x["slip_step"], x["gap"]


def solve(problem, form):
    """Solve a problem by plain cvxpy, from nothing that it holds."""
    for variable in problem.variables():
        variable.save_value(None)
    if form == "qp":
        problem.solve(solver="CLARABEL", **FINE)
    elif form == "milp":
        # No status is expected.
        problem.param_dict["unexpected"].value = np.ones((3, problem.var_dict["gap"].size))
        problem.solve(solver="HIGHS")
    else:
        # Of each motion and its slack, a boolean chooses the one that vanishes.
        z, slacks = (row.args[1] for row in problem.constraints)
        moves = cp.Variable(z.size, boolean=True)
        rows = [*problem.constraints, z <= 20 * moves, slacks <= 20 * (1 - moves)]
        cp.Problem(cp.Minimize(0), rows).solve(solver="HIGHS")
        assert problem.objective.value == pytest.approx(0.0, abs=1e-6)


def assert_increments(path, form, numbers):
    for number in numbers:
        found = path.increment(number, form)
        step = path.slip[number] - path.slip[number - 1]
        step = step.T.ravel()
        assert found.residual < 1e-9 and found.problem.status == "optimal"
        assert all(row.violation().max() < 1e-9 for row in found.problem.constraints)
        for name in ("slip", "gap", "q", "p"):
            assert getattr(found, name) == pytest.approx(getattr(path, name)[number], abs=1e-9)
        held = motions(found.problem)
        value = found.problem.value
        solve(found.problem, form)
        for slip_step, gap in (held, motions(found.problem)):
            assert slip_step == pytest.approx(step, abs=2e-5)
            assert gap == pytest.approx(path.gap[number], abs=2e-5)
        if form == "qp":
            assert found.problem.value == pytest.approx(value, abs=1e-8)


@pytest.mark.parametrize("form", ["qp", "complementarity", "milp"])
def test_plain_cvxpy_finds_each_state_of_a_plane_path(path, form):
    """The path has found it from event to event, or by Newton's method."""
    assert_increments(path, form, range(1, len(path.time)))


def test_plain_cvxpy_finds_each_state_in_space():
    contact = random_contact(np.random.default_rng(0), 3)
    path = fo.march(contact, spatial_cycle(), 0.4, 1.0, cycles=1, steps=2)
    assert {*path.status.ravel().tolist()} == {0, 1, 2}
    assert_increments(path, "qp", range(1, len(path.time)))
    for form in ("milp", "complementarity"):
        with pytest.raises(fo.ModelError, match=f"form: '{form}'.*choose 'qp'"):
            path.increment(1, form)


def test_the_steady_cycle_has_the_increments_of_its_states():
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    steady = fo.steady_state(rod, cycle, friction=0.5, load_factor=1.0)
    states = steady.states()
    assert_increments(states, "milp", range(1, len(states.time)))


def test_a_path_says_which_increments_it_has():
    path = plane_path()
    for number in (0, len(path.time), -1, 1.0):
        with pytest.raises(fo.ModelError, match=r"^number: .*at least 1 and at most"):
            path.increment(number)
    with pytest.raises(fo.ModelError, match="form: 'newton'; give 'qp' or 'complementarity' or"):
        path.increment(1, "newton")
