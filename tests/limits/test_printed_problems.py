"""The printed problem of each kind of answer, judged by plain cvxpy.

Two solvers find the value of the answer again. The values and the multipliers that the answer puts
into its problem obey the conditions of optimality of the printed rows. cvxpy evaluates them.
"""

import copy
from dataclasses import replace
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np
import pytest
from cvxpy.constraints import Equality

import frictopt as fo
from helpers.separation import pulled_system
from helpers.spatial import CORNERS, random_contact
from helpers.systems import CYCLE, block, random_system, uncoupled
from studies.validation.fuzz.embedded import embedded

FINE = dict.fromkeys(("tol_feas", "tol_gap_abs", "tol_gap_rel"), 1e-10)
CLARABEL = {"solver": "CLARABEL", **FINE}
SCS = {"solver": "SCS", "eps_abs": 1e-9, "eps_rel": 1e-9}
BOTH = pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])


class Asked(NamedTuple):
    system: fo.ContactSystem
    cycle: fo.LoadCycle
    friction: Any
    options: dict[str, Any]


def asked(tangents: int, *features: str) -> Asked:
    """A contact of three nodes that has all the features."""
    rng = np.random.default_rng(0)
    system, cycle = random_system(rng, 3), CYCLE
    if tangents == 2:
        system, cycle = random_contact(rng, 3), fo.LoadCycle({"mean": 1.0}, CORNERS)
    friction, options = np.array([0.5, 0.4, 0.6]), {}
    if "no friction" in features:
        # Nothing holds the first node, so no cyclic load shears it.
        friction = np.array([0.0, 0.005, 0.5])
        loads = {name: (q.copy(), p) for name, (q, p) in system.bonded.items() if name != "mean"}
        for q, _ in loads.values():
            q[0] = 0.0
        system = system.with_bonded(loads)
    if "fixed parts" in features:
        loads = {f"fixed {k}": 0.1 * rng.normal(size=len(system.S)) for k in range(2)}
        system = system.with_bonded(loads)
        fixed = [{name: 1.0} for name in loads] + [{}] * (len(cycle.corners) - 2)
        cycle = fo.LoadCycle(cycle.mean, cycle.corners, fixed)
    if "open" in features:
        # The last node is hardly open, so that its gap may govern.
        system = system.with_gap([0.0, 0.05, 0.6 if tangents == 1 else 0.85])
    if "slip bound" in features:
        options["slip_bound"] = [0.15, 0.1, 0.05]
    if "strength" in features:
        system = replace(system, shear_strength=np.array([0.25, 0.3, np.inf]))
    if "orthotropic" in features:
        system = system.with_orthotropic_friction([0.5, 2.0, 0.7])
    return Asked(system, cycle, friction, options)


def size(slip):
    return cp.abs(slip) if slip.ndim == 1 else cp.norm(slip, axis=1)


def limit(case):
    answer = fo.shakedown_limit(*case[:3], **case.options)
    return answer, answer.load_factor


def guaranteed(case):
    answer = fo.guaranteed_limit(*case[:3], **case.options)
    return answer, answer.load_factor


def margin(case, share=0.5):
    load_factor = share * limit(case)[1]
    answer = fo.safe_slip(*case[:3], load_factor, **case.options)
    assert np.sign(answer.margin) == np.sign(1 - share)
    return answer, answer.margin


def no_margin(case):
    return margin(case, 6.0)


def required(case):
    answer = fo.required_friction(*case[:2], 0.8 * limit(case)[1], **case.options)
    return answer, 0.0


def design(case):
    """The best preload and profile for two cycles, one with less friction."""
    model = fo.DesignModel(
        *case[:2],
        preloads=["mean"],
        profile=True,
        scenarios=[(case.cycle, 0.9 * case.friction)],
        **case.options,
    )
    rows = [
        cp.abs(model.preload) <= 0.1,
        cp.abs(model.profile) <= 0.1,
        cp.abs(model.slip[2]) <= 0.05,
    ]
    answer = model.solve(case.friction, rows)
    return answer, answer.load_factor


def with_rows(kind):
    """Answers of a model with rows on all its unknowns, and with a variable of the user."""

    def question(case):
        model, most = kind(*case[:2], **case.options), cp.Variable(name="most")
        rows = [
            size(model.slip) <= most,
            most <= 0.15,
            cp.sum(model.q[0]) <= 0.5,
            model.p[1] <= 1.6,
        ]
        answer = model.solve(case.friction, rows)
        return answer, answer.load_factor

    return question


def with_objective(case):
    model = fo.ShakedownModel(*case[:2], **case.options)
    answer = model.solve(case.friction, objective=model.load_factor - cp.norm1(model.slip))
    return answer, answer.objective


QUESTIONS = {
    "limit": limit,
    "guaranteed": guaranteed,
    "margin": margin,
    "no margin": no_margin,
    "required": required,
    "design": design,
    "rows": with_rows(fo.ShakedownModel),
    "guaranteed with rows": with_rows(fo.GuaranteedModel),
    "objective": with_objective,
}
ALL = "open, slip bound, fixed parts"
# Questions by features. Only `shakedown_limit` supports a strength. In space the guaranteed limit
# supports no fixed parts.
ASKED = {
    "closed": [*QUESTIONS],
    "open": ["limit", "guaranteed", "margin"],
    "fixed parts": ["limit", "guaranteed", "design"],
    "slip bound": ["limit", "no margin", "required"],
    "open, slip bound": ["limit", "guaranteed", "guaranteed with rows"],
    ALL: [*QUESTIONS],
    "no friction": ["limit", "guaranteed", "design", "objective"],
    "strength": ["limit", "rows", "objective"],
    f"{ALL}, strength": ["limit", "rows"],
    "orthotropic": ["limit", "guaranteed", "margin", "design"],
    f"{ALL}, orthotropic": ["limit", "required", "rows"],
}
CASES = [
    pytest.param(question, tangents, features, id=f"{question}, {place}, {features}")
    for features, questions in ASKED.items()
    for question in questions
    for tangents, place in ((1, "plane"), (2, "space"))
    if tangents == 2 or "orthotropic" not in features
    if tangents == 1 or "guaranteed" not in question or "fixed parts" not in features
]


# cvxpy has another backend for rows on `model.q` in space.
@pytest.mark.filterwarnings("ignore:.*support CPP backend")
@pytest.mark.parametrize(("question", "tangents", "features"), CASES)
def test_the_printed_problem_has_the_value_and_the_multipliers_of_the_answer(
    question, tangents, features
):
    answer, value = QUESTIONS[question](asked(tangents, *features.split(", ")))
    judge(answer.problem, value, tangents)


def judge(problem, value, tangents):
    """Check a printed problem: its value, its multipliers, and what two solvers find."""
    assert problem.status == "optimal"
    assert problem.value == pytest.approx(value, rel=1e-9, abs=1e-5 if value == 0 else 1e-12)
    assert max(np.max(row.violation(), initial=0) for row in problem.constraints) < 1e-9
    certify(problem, tangents)
    for options in solvers(tangents):
        # The answer keeps its own values.
        found = copy.deepcopy(problem).solve(**options)
        assert found == pytest.approx(problem.value, rel=1e-6, abs=1e-8)


def solvers(tangents):
    return [{"solver": "HIGHS"} if tangents == 1 else SCS, CLARABEL]


def certify(problem, tangents):
    """No other values near those of the problem make its Lagrangian larger.

    The multipliers of inequalities are not negative, so the Lagrangian is concave, and an upper
    bound of the goal of all values that obey the rows. At the answer it is the goal.
    """
    value = goal(problem).value
    lagrangian = goal(problem) - resistance(problem)
    assert lagrangian.value == pytest.approx(value, abs=1e-9)
    assert largest(lagrangian, tangents) == pytest.approx(value, abs=1e-7)


def goal(problem):
    return problem.objective.expr * (1 if isinstance(problem.objective, cp.Maximize) else -1)


def resistance(problem):
    """The sum of the rows, `left - right`, times their multipliers."""
    total = 0
    for row in problem.constraints:
        left, right = row.args
        multipliers = row.dual_value
        if not isinstance(row, Equality):
            assert np.min(multipliers, initial=0) > -1e-9, row
            multipliers = np.maximum(multipliers, 0)
        total += cp.sum(cp.multiply(multipliers, left - right))
    return total


def largest(expression, tangents):
    """The largest value of an expression, if no entry of a variable changes by more than 1."""
    expression = cp.Constant(0) + expression
    near = [
        cp.abs(part - (0 if part.value is None else part.value.copy())) <= 1
        for part in expression.variables()
    ]
    values = {part: part.value for part in expression.variables()}
    found = cp.Problem(cp.Maximize(expression), near).solve(
        **{"solver": "HIGHS"} if tangents == 1 else CLARABEL
    )
    for part, value in values.items():
        part.save_value(value)
    return found


@BOTH
def test_the_least_load_is_that_of_the_printed_rows(tangents):
    """The least load is that of the printed rows: a mean load pulls, and the corners press."""
    system = asked(tangents).system
    still, pull = np.zeros(system.slip_shape), np.array([-0.1, 1.0, 1.0])
    press = {"N": (still + 0.1, [1.0, 0.2, 0.3]), "M": (still - 0.05, [1.0, 0.2, 0.3])}
    system = replace(system, bonded={"mean": (still, pull), **press})
    cycle = fo.LoadCycle({"mean": 1.0}, [{"N": 1.0}, {"M": 1.0}])
    model = fo.ShakedownModel(system, cycle)
    answer = model.solve(0.3, [size(model.slip) <= 0.01])
    assert answer.least > 0.01
    problem = answer.problem
    judge(problem, answer.load_factor, tangents)
    least = cp.Problem(cp.Minimize(problem.var_dict["load_factor"]), problem.constraints)
    for options in solvers(tangents):
        assert least.solve(**options) == pytest.approx(answer.least, rel=1e-6)


@BOTH
def test_no_values_obey_the_printed_rows_if_no_load_factor_is_safe(tangents):
    """No values obey the printed rows if no load factor is safe: their multipliers prove it."""
    case = asked(tangents, "fixed parts", "slip bound")
    pulled = fo.LoadCycle({"mean": -1.0}, case.cycle.corners)
    problem = fo.shakedown_limit(
        case.system, pulled, 0.5, open_nodes=[False] * 3, **case.options
    ).problem
    # Values that obey the rows would make the sum at least 0.
    assert largest(-resistance(problem), tangents) < -1e-3
    for options in solvers(tangents):
        found = copy.deepcopy(problem)
        found.solve(**options)
        assert found.status == problem.status == "infeasible"


@BOTH
@pytest.mark.parametrize("question", ["limit", "margin"])
def test_an_order_of_events_is_printed_as_it_is_solved(tangents, question):
    system = pulled_system(np.random.default_rng(15), 3)
    if tangents == 2:
        system = embedded(system, np.random.default_rng(1))[0]
    answer = fo.shakedown_limit(system, CYCLE, 0.5, events=True)
    value = answer.load_factor
    assert not answer.events.empty
    if question == "margin":
        answer = fo.safe_slip(system, CYCLE, 0.5, 0.7 * value, events=True)
        value = answer.margin
    judge(answer.problem, value, tangents)


@BOTH
def test_areas_that_move_are_printed_as_their_loads_and_stiffness(tangents):
    system, p = uncoupled(np.random.default_rng(0), 3, tangents)
    lift = np.zeros(len(system.S))
    lift[-3] = -1.5 * p[0]
    system = system.with_bonded({"lift": lift})
    cycle = fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}, {"cyclic": -1.0}], [{"lift": 1.0}, {}])
    answer = fo.shakedown_limit(system, cycle, 0.5)
    assert not answer.events.empty
    judge(answer.problem, answer.load_factor, tangents)


@BOTH
@pytest.mark.parametrize("strength", [np.inf, 0.1])
def test_forces_balance_the_sliding_off_load_and_its_motion_is_a_multiplier(tangents, strength):
    """The printed problem has no multipliers; the motion phi is that of the balance, up to size."""
    system = block(np.random.default_rng(0), nodes=2, axes=tangents + 1)
    system = replace(system, shear_strength=np.full(system.nodes, strength))
    answer = fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -0.5}]), 0.4)
    problem = answer.problem
    balance, *rows = problem.constraints
    assert max(row.violation().max() for row in problem.constraints) < 1e-9
    (motions,) = {
        part.value.tobytes(): part.value for part in balance.constants() if part.ndim == 2
    }.values()
    rate = answer.phi.ravel() @ np.concatenate(
        [part.ravel(order="F") for part in system.reaction({"Q": 1.0})]
    )
    multipliers = np.linalg.lstsq(motions.T, -answer.phi.ravel() / rate)[0]
    left, right = balance.args
    relaxed = cp.Problem(cp.Maximize(problem.objective.expr - multipliers @ (left - right)), rows)
    for options in solvers(tangents):
        for each in (problem, relaxed):
            assert copy.deepcopy(each).solve(**options) == pytest.approx(
                answer.load_factor, rel=1e-6
            )
