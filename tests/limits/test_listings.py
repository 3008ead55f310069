"""A printed problem is a few lines of names.

Copies and other processes solve it, and its multipliers are motions. `test_printed_problems.py`
compares it with its answer.
"""

import pickle
import re
import subprocess
import sys
from functools import cache
from itertools import product

import cvxpy as cp
import numpy as np
import pytest

import frictopt as fo
from frictopt.limits.printed import models
from helpers.cases import ALL_CASES
from helpers.spatial import CORNERS, random_contact
from helpers.systems import CYCLE, random_system

BOTH = pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])
FINE = dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), 1e-10)


def small_contact(tangents, seed=0, nodes=3):
    """A small contact and a cycle of two corners, or three in space."""
    rng = np.random.default_rng(seed)
    if tangents == 2:
        return random_contact(rng, nodes), fo.LoadCycle({"mean": 1.0}, CORNERS)
    return random_system(rng, nodes), CYCLE


def near(value, tangents):
    return pytest.approx(value, rel=1e-7 if tangents == 1 else 1e-6, abs=1e-8)


def test_one_function_of_arrays_is_the_printed_limit_of_a_closed_plane_contact():
    """One function of arrays prints the limit of a closed plane contact, and has its value."""
    contact, cycle = small_contact(1)
    q1, p1 = zip(*(contact.reaction(corner) for corner in cycle.corners), strict=True)
    q0, p0 = contact.reaction(cycle.mean)
    friction = np.array([0.5, 0.3, 0.6])
    by_arrays = models.plane_shakedown(contact.A, contact.B, q0, p0, q1, p1, friction)
    limit = fo.shakedown_limit(contact, cycle, friction)
    model = fo.ShakedownModel(contact, cycle)
    for problem in (limit.problem, model.problem):
        assert str(by_arrays) == str(problem)
        labels = [row.label for row in problem.constraints]
        assert sorted(row.label for row in by_arrays.constraints) == sorted(labels)
    assert by_arrays.solve(solver="HIGHS") == near(limit.load_factor, 1)
    rates = sum(
        row.dual_value * by_arrays.var_dict[f"p[{row.label[6]}]"].value
        for row in by_arrays.constraints
        if row.label.startswith("stuck")
    )
    assert rates == pytest.approx(limit.friction_rate, abs=1e-8)


@BOTH
def test_a_model_has_its_problem_before_it_is_solved(tangents):
    """Plain cvxpy solves it with any friction, also with other rows, and each of its loads is the
    reaction of a load of the cycle."""
    contact, cycle = small_contact(tangents)
    model = fo.ShakedownModel(contact, cycle, slip_bound=0.5)
    options = {"solver": "HIGHS"} if tangents == 1 else {"solver": "CLARABEL", **FINE}
    with pytest.raises(cp.error.ParameterError, match="'f'"):
        model.problem.solve(**options)
    for friction in (0.5, 0.3):
        model.f.value = np.full(3, friction)
        limit = fo.shakedown_limit(contact, cycle, friction, slip_bound=0.5)
        assert model.problem.solve(**options) == near(limit.load_factor, tangents)
        assert model.slip.value is not None
    little = size(model.slip) <= 0.02
    extended = cp.Problem(model.problem.objective, [*model.problem.constraints, little])
    assert extended.solve(**options) == near(model.solve(0.3, [little]).load_factor, tangents)
    assert model.f.value.tolist() == [0.3] * 3
    assert repr(model) == f"ShakedownModel({contact!r}, {cycle})"
    loads = {"q0": cycle.mean, **{f"q1[{k}]": corner for k, corner in enumerate(cycle.corners)}}
    assert len(model.loads) == 2 * len(loads)
    for name, load in loads.items():
        q, p = contact.reaction(load)
        assert model.loads[name] == pytest.approx(q)
        assert model.loads[name.replace("q", "p")] == pytest.approx(p)


def size(q):
    return cp.abs(q) if q.ndim == 1 else cp.norm(q, 2, axis=1)


def test_a_model_that_is_given_friction_says_where_it_goes():
    with pytest.raises(fo.ModelError, match=r"friction: .*give it to `solve`"):
        fo.ShakedownModel(*small_contact(1), friction=0.5)


PLANE, SPACE = small_contact(1), small_contact(2)
LIFTED, LIFTED_IN_SPACE = (
    (contact.with_gap([0.0, 0.0, 8.0]), cycle) for contact, cycle in (PLANE, SPACE)
)
LITTLE = cp.Constant(0.1, name="little")
ANGLES = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
TURNS = fo.LoadCycle({"mean": 1.0}, [{"a": np.cos(angle), "b": np.sin(angle)} for angle in ANGLES])


def own(asked, rows, friction=0.5):
    """The limit of a model with rows of the user."""
    model = fo.ShakedownModel(*asked)
    return model.solve(friction, rows(model))


def with_objective():
    model = fo.ShakedownModel(*PLANE)
    return model.solve(0.5, objective=model.load_factor - cp.norm1(model.slip))


def design():
    model = fo.DesignModel(*PLANE, preloads=["mean"], profile=True)
    return model.solve(0.5, [cp.abs(model.preload) <= LITTLE, cp.abs(model.profile) <= LITTLE])


ANSWERS = {
    "shakedown": lambda: fo.shakedown_limit(*PLANE, 0.5),
    "bounded": lambda: fo.shakedown_limit(*PLANE, 0.5, slip_bound=0.02),
    "little": lambda: fo.shakedown_limit(*PLANE, 0.005),
    "open": lambda: fo.shakedown_limit(*LIFTED, 0.5),
    "open, little and own": lambda: own(LIFTED, lambda m: [cp.abs(m.q) <= LITTLE * 50], 0.005),
    "own": lambda: own(PLANE, lambda m: [m.slip <= LITTLE]),
    "objective": with_objective,
    "margin": lambda: fo.safe_slip(*PLANE, 0.5, 0.2),
    "guaranteed": lambda: fo.guaranteed_limit(*PLANE, 0.6),
    "design": design,
    "space": lambda: fo.shakedown_limit(*SPACE, 0.5),
    "open in space": lambda: own(LIFTED_IN_SPACE, lambda m: [cp.norm(m.slip, axis=1) <= LITTLE]),
    "many corners in space": lambda: fo.shakedown_limit(SPACE[0], TURNS, 0.5),
    "margin in space": lambda: fo.safe_slip(*SPACE, 0.5, 0.2),
    "guaranteed in space": lambda: fo.guaranteed_limit(*SPACE, 0.5),
}
EACH = pytest.mark.parametrize("name", ANSWERS)


@cache
def answer_of(name):
    """An answer with its problem, made when a test first asks for it."""
    return ANSWERS[name]()


@EACH
def test_a_listing_is_a_few_lines_of_names(name):
    answer = answer_of(name)
    quantity = {"objective": "objective"}.get(name, "margin" if "margin" in name else "load_factor")
    printed = str(answer.problem)
    assert len(printed.splitlines()) <= 14, printed
    numbers = re.sub(r"\b(0\.0|1\.0|2\.0|50\.0)\b", "", printed)  # cvxpy prints 0, 1, 2 and 50 so
    assert not re.search(r"\d\.\d", numbers), printed
    assert "[[" not in printed, printed
    assert "..." not in printed.replace("k = 0, 1, ..., 23", ""), printed
    assert answer.problem.value == pytest.approx(getattr(answer, quantity), rel=1e-12, abs=1e-12)
    assert answer.problem.status == "optimal"


def test_a_plain_copy_of_a_problem_is_solved_whatever_solver_has_had_it():
    """The test runs in a separate process, because cvxpy's own copies end the process."""
    some = [answer_of(name) for name in list(ANSWERS)[:: 1 if ALL_CASES else 13]]
    pickled = pickle.dumps(some)
    script = """
import copy, pickle, sys, warnings
warnings.simplefilter("ignore")  # SCS may be inaccurate
given = sys.stdin.buffer.read()
for problem, solver in ((answer.problem, solver) for solver in (None, "CLARABEL", "SCS") for answer in pickle.loads(given)):
    value = problem.value
    problem.get_problem_data("CLARABEL"), solver and problem.solve(solver=solver)
    for again in (copy.deepcopy(problem), pickle.loads(pickle.dumps(problem)), copy.deepcopy(copy.deepcopy(problem)), copy.copy(problem)):
        print((again.solve(solver="CLARABEL", tol_feas=1e-10, tol_gap_abs=1e-10, tol_gap_rel=1e-10) - value) / (1 + abs(value)))
"""
    run = subprocess.run(
        [sys.executable, "-c", script], input=pickled, capture_output=True, check=False
    )
    assert run.returncode == 0, run.stderr.decode()
    off = np.array(run.stdout.split(), dtype=float)
    assert len(off) == 3 * 4 * len(some) and np.abs(off).max() <= 1e-6


def test_events_follow_each_other_on_their_segment():
    first, second = cp.Variable(), cp.Variable()
    rows = models.ordered([([first, second], 1.0)])
    for places in product([-0.1, 0.2, 0.8, 1.1], repeat=2):
        first.value, second.value = places
        assert all(row.value() for row in rows) == (0 <= places[0] <= places[1] <= 1)


def test_the_scenarios_of_a_design_are_names():
    contact, cycle = small_contact(1)
    model = fo.DesignModel(contact, cycle, preloads=["mean"], scenarios=[(cycle, 0.4)])
    problem = model.solve(0.5, [model.preload <= 0.4]).problem
    assert "abs(q[k]) <= f * p[k]" in str(problem) and "abs(q_1[k]) <= f_1 * p_1[k]" in str(problem)
    assert len({variable.name() for variable in problem.variables()}) == len(problem.variables())
