"""The terms of a design in the program of a limit: preloads and a profile as unknowns.

Reactions are linear in the unknowns of a design. Preloads b of load cases with reactions q_j, p_j
add `q_j b` to the shear forces and `p_j b` to the normal forces. A profile g increases the gap, so
that the shear forces decrease by `B^T g` and the normal forces by `C g`. Open nodes carry no force:
preloads and profile change their gaps and slips.

`design_problem` is the printed problem: the rows of all scenarios, the preloads and the profile.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np

from ...base import (
    CONDENSATION,
    GROWN,
    Array,
    Booleans,
    Integers,
    checked_loads,
    frozen,
    listed,
    shown,
)
from ...contact import ContactSystem, LoadCycle, joined
from ...errors import ModelError
from ...solve.problem import Problem
from ..printed import models
from ..printed.listing import fill, rest_rows, state_rows
from ..printed.models import Row, Unknowns, constant, unknowns
from ..printed.user_rows import UserRows
from ..program.assembled import law_rows, within_slip_bound
from ..program.question import Question, pose_like, with_open
from ..program.rest_program import RestProgram
from ..program.solution import Judged, Solution, Solved, contradiction, growth, solve
from ..search.loose_nodes import own_motions
from .design import NoneSafeError

# Names of the matrices by which a design changes q, p and the gaps of open nodes.
_SYMBOLS = {"preload": ("q_j", "p_j", "w_j"), "profile": ("-B.T", "-C", "-w")}


def design_problem(
    choice: Choice,
    scenarios: Sequence[Scenario],
    solution: Solution,
    x: Unknowns,
    user: UserRows | None,
) -> cp.Problem:
    """The problem of a design with the values and multipliers of its solution."""
    rows = list[Row]()
    whole = solution.solved("design")
    fillings = []
    for number, scenario in enumerate(scenarios):
        question = scenario.question
        corners = range(len(question.r1))
        suffix = f"_{number}" if number else ""
        own = x
        if number:
            own = unknowns(question.system.slip_shape, corners, x.load_factor, suffix)
        f = models.friction(question.friction, suffix)
        added = _added(choice, scenario, suffix)
        more = dict.fromkeys(corners, added)
        listed = state_rows(question, own, f, list(corners), more=more)
        slip = solution.closed_slip(number)
        if number == 0 and user is not None and question.compliance is not None:
            opened = _open_slips_due_to(choice, scenario)
            listed += rest_rows(question, x, opened)
            slip = whole.values["slip"]
        here = solution.program.response_of == number
        fillings.append((listed, _of_scenario(whole, question, here), {own.slip: slip}))
        rows += listed
    problem = models.shakedown(x, rows)
    if user is not None:
        user.save(whole.values["user"])
        goal = problem.objective if user.objective is None else cp.Maximize(user.objective)
        problem = Problem(goal, [*problem.constraints, *user.rows.values()])
    x.load_factor.save_value(np.array(solution.load_factor))
    for variable, name in choice.variables.items():
        variable.save_value(solution.values(name))
    fillings.append(([problem.constraints[len(rows)]], whole, {}))
    for listed, part, values in fillings:
        fill(problem, listed, part, values)
    return problem


def _of_scenario(whole: Solved, question: Question, here: Booleans) -> Solved:
    """The part of a solved design that belongs to one scenario, which has the instants `here`."""
    multipliers = {
        name: value[here] if value.ndim == 2 else value for name, value in whole.multipliers.items()
    }
    return replace(whole, question=question, moves=whole.moves[here], multipliers=multipliers)


def _added(choice: Choice, scenario: Scenario, suffix: str) -> list[cp.Expression]:
    """The terms that a design adds to q, p and the gaps of open nodes. Names end with `suffix`."""
    question = scenario.question
    by_unknown = [
        [
            constant(effect, symbol + suffix) @ choice.parts[name].variable
            for effect, symbol in zip(
                question.parts(question.forces_of(effects).T), _SYMBOLS[name], strict=True
            )
        ]
        for name, effects in choice.effects(scenario).items()
    ]
    q, p, gaps = (sum(terms[1:], terms[0]) for terms in zip(*by_unknown, strict=True))
    if choice.system.tangents > 1:
        q = cp.reshape(q, choice.system.slip_shape, order="F")
    return [q, p, gaps] if question.open_nodes.any() else [q, p]


def _open_slips_due_to(choice: Choice, scenario: Scenario) -> cp.Expression:
    """The term that a design adds to the slips of open nodes, if user constraints contain them."""
    terms = [
        constant(open_slips(scenario.question, effect), f"v_{name}") @ choice.parts[name].variable
        for name, effect in choice.effects(scenario).items()
    ]
    return sum(terms[1:], terms[0])


# Name of the load case for the overlap that a profile causes.
PROFILE = "profile"

# Largest mean normal force of the preloads, divided by the mean normal force of the contact.
_MOST_PRESSED = 10.0

# An error names at most this number of unbounded components of a design.
_MOST_NAMES = 4


class Scenario(NamedTuple):
    """A question in which a design has to hold, and the share of each preload that acts there."""

    question: Question
    shares: Mapping[str, float]


class Built(NamedTuple):
    """The values of a design, and the questions of all scenarios with the design built in."""

    preload: Array
    profile: Array | None
    questions: tuple[Question, ...]


class Part(NamedTuple):
    """An unknown of a design, with the names and the effects of its n components."""

    variable: cp.Variable  # (n,)
    components: Sequence[Any]
    reactions: Array  # (n, M) bonded reactions due to a unit of each component
    sizes: Array  # (n,) sizes of the forces due to a unit of each component


@dataclass(frozen=True, eq=False)
class Choice:
    """The unknowns of a design: amplitudes of load cases in the mean load, and a profile."""

    system: ContactSystem
    names: Sequence[str]  # of the load cases
    parts: Mapping[str, Part]  # "preload" and "profile", or one of them

    @property
    def variables(self) -> dict[cp.Variable, str]:
        """The unknowns with their names in programs."""
        return {part.variable: name for name, part in self.parts.items()}

    def units(self, question: Question) -> dict[str, Array]:
        """Units of the unknowns: each unit causes about the mean normal force at a node."""
        force = question.force
        return {
            name: force / np.where(part.sizes > 0, part.sizes, force)
            for name, part in self.parts.items()
        }

    def effects(self, scenario: Scenario) -> dict[str, Array]:
        """Bonded reactions (n, M) due to units of the design in a scenario, by unknown."""
        effects = dict[str, Array]()
        for name, part in self.parts.items():
            shares = [scenario.shares.get(component, 1.0) for component in part.components]
            effects[name] = part.reactions * np.reshape(shares, (-1, 1))
        return effects

    def built(self, scenarios: Sequence[Scenario], values: Mapping[str, Array]) -> Built:
        """The design with given values, built into the questions of all scenarios."""
        # Adding 0 turns -0 into 0.
        given = {name: frozen(values[name] + 0.0) for name in self.parts}
        preload = given.get("preload", np.zeros(0))
        profile = given.get("profile")
        system, overlap = _with_profile(self.system, profile)
        built: list[Question] = []
        for question, shares in scenarios:
            mean = dict(question.cycle.mean)
            for name, amount in zip(self.names, preload.tolist(), strict=True):
                mean[name] = mean.get(name, 0.0) + amount * shares.get(name, 1.0)
            cycle = replace(question.cycle, mean={**mean, **overlap})
            closed = pose_like(question, cycle, question.friction, system)
            built.append(with_open(closed, question.open_nodes) or closed)
        return Built(preload, profile, tuple(built))


def open_slips(question: Question, reactions: Array) -> Array:
    """(open slips, n) slips of open nodes under bonded reactions (n, M)."""
    assert question.compliance is not None  # it has open nodes
    opened = np.flatnonzero(np.tile(question.open_nodes, question.system.tangents))
    return -(reactions @ question.compliance)[:, opened].T


def checked_choice(system: ContactSystem, preloads: Sequence[str], has_profile: bool) -> Choice:
    """The unknowns of a design; ModelError for load cases whose reactions are only rounding."""
    names = _checked_names(system, preloads)
    if has_profile and PROFILE in system.bonded:
        raise ModelError(
            f"profile: the system has a load case {PROFILE!r}, which is the name of an overlap "
            "that a design adds; rename it"
        )
    if not (names or has_profile):
        raise ModelError(
            "preloads, profile: none, so the design has no unknowns; name load cases, or give "
            "profile=True"
        )
    parts = dict[str, Part]()
    if names:
        reactions = np.array([joined(*system.bonded[name]) for name in names])
        sizes = np.abs(reactions).mean(axis=1)
        largest = max(np.abs(joined(*pair)).mean() for pair in system.bonded.values())
        for name, size in zip(names, sizes, strict=True):
            if 0 < size < CONDENSATION * largest:
                raise ModelError(
                    f"preloads: {name!r} has reactions of {size:.1e}, which is only rounding "
                    f"relative to the reactions {largest:.1e} of others; leave it out if it has no "
                    "effect on the contact, otherwise enlarge its unit, or reduce the unit of the "
                    "other load cases"
                )
        parts["preload"] = Part(cp.Variable(len(names), name="preload"), names, reactions, sizes)
    if has_profile:
        n = system.nodes
        variable = cp.Variable(n, name="profile")
        parts["profile"] = Part(variable, range(n), -system.S[-n:], system.own_stiffness[-n:])
    return Choice(system, names, parts)


def _checked_names(system: ContactSystem, preloads: Sequence[str]) -> list[Any]:
    """The names of the load cases that a design scales, checked: each occurs once."""
    names = listed("preloads", preloads)
    known = list(system.bonded)
    for name in names:
        if not (isinstance(name, str) and name in known):
            raise ModelError(
                f"preloads: {shown(name)} is no load case; this system has {shown(known)}"
            )
    if len(set(names)) < len(names):
        raise ModelError(f"preloads: {shown(names)}; name each load case once")
    return names


def checked_scenario(name: str, scenario: Any, choice: Choice, first: Question) -> Scenario:
    """A scenario of the user, checked; `first` is the question of the first scenario."""
    if not isinstance(scenario, tuple) or len(scenario) not in (2, 3):
        raise ModelError(
            f"{name}: {shown(scenario)}; give (load cycle, friction), or these and the shares of "
            "the preloads"
        )
    cycle, friction, *of_preloads = scenario
    shares = checked_loads(name, of_preloads[0] if of_preloads else {})
    unknown = sorted(set(shares) - set(choice.names))
    if unknown:
        raise ModelError(
            f"{name}: shares of {shown(unknown)}; the preloads are {shown(list(choice.names))}"
        )
    return Scenario(pose_like(first, cycle, friction), shares)


def under_mean_load(scenario: Scenario) -> Scenario:
    """A scenario at load factor 0, with the same preloads."""
    question, shares = scenario
    cycle = question.cycle
    # Without fixed parts all corners have the same load, and one corner is enough.
    at_zero = LoadCycle(cycle.mean, [{}] * len(cycle.unscaled), cycle.fixed)
    return Scenario(pose_like(question, at_zero, question.friction), shares)


def _with_profile(
    system: ContactSystem, profile: Array | None
) -> tuple[ContactSystem, dict[str, float]]:
    """The contact with a profile in its gap, and the load case of an overlap if there is one."""
    if profile is None:
        return system, {}
    gap = system.gap + profile
    system = system.with_gap(np.maximum(gap, 0.0))
    if gap.min() >= 0:
        return system, {}
    return system.with_interference({PROFILE: np.maximum(-gap, 0.0)}), {PROFILE: 1.0}


def design_program(
    choice: Choice,
    scenarios: Sequence[Scenario],
    loose: Integers | None = None,
) -> RestProgram:
    """The program of load factors and designs with a state of rest in every scenario.

    The question of each scenario has its open nodes. The nodes `loose` are closed in all questions;
    in the program they may be open or closed.
    """
    program = _of_scenarios(choice, scenarios, loose)
    for number, question in enumerate(program.questions):
        here = (program.response_of == number)[:, None]
        law_rows(program, question, here & ~question.open_nodes, here & question.open_nodes)
    return program


def _of_scenarios(
    choice: Choice, scenarios: Sequence[Scenario], loose: Integers | None = None, **units: float
) -> RestProgram:
    """The program at the corners of all scenarios, without the rows of the contact law.

    It has the row `load_factor >= 0` and, without `loose`, the slip bounds. `units` are the units
    of further unknowns. `loose`: see `design_program`.
    """
    questions = [scenario.question for scenario in scenarios]
    first = questions[0]
    effects = {"load_factor": np.concatenate([question.rate for question in questions])}
    of_design = [choice.effects(scenario) for scenario in scenarios]
    slip_of = np.repeat(np.arange(len(questions)), [len(each.r1) for each in questions])
    for name in choice.parts:
        by_unit = [
            question.forces_of(reactions[name]).T  # (M, n)
            for question, reactions in zip(questions, of_design, strict=True)
        ]
        effects[name] = np.array(by_unit)[slip_of]
    own_units: dict[str, Array] = {}
    if loose is not None:
        own_units, own_effects = own_motions(questions, slip_of, loose)
        effects |= own_effects
    program = RestProgram(
        questions,
        {"load_factor": first.load_unit, **choice.units(first), **units, **own_units},
        np.vstack([each.start for each in questions]),
        effects,
        slip_of=slip_of,
    )
    program.row("load_factor", {"load_factor": 1.0})
    for number in range(len(questions) if loose is None else 0):
        within_slip_bound(program, number)
    return program


def press(choice: Choice, scenario: Scenario, user: UserRows | None) -> dict[str, Array]:
    """The design whose preloads press the contact most, under the constraints of the user.

    The preloads press with at most `_MOST_PRESSED` times the normal force of the contact.
    SolverError if no answer passes the checks.
    """
    question = scenario.question
    n = question.system.nodes
    preload = choice.parts["preload"]
    most = n * question.force
    program = _of_scenarios(choice, [scenario], pressing=most)
    program.row("pressing", {"pressing": -1.0, "preload": preload.reactions[:, -n:].sum(axis=1)})
    program.row("most", {"pressing": -1.0}, _MOST_PRESSED * most)
    if user is not None:
        user.add_to(program)
    program.goal = "pressing"

    def claimed(solution: Solution) -> Judged:
        values = {name: solution.values(name) for name in choice.parts}
        return Judged(values, program.violation(solution.x))

    pressed, _ = solve(program, claimed)
    return dict(pressed.said)


def raise_refusal(program: RestProgram, choice: Choice) -> None:
    """Raise an error if it is proven that there is no best design; otherwise return."""
    found = contradiction(program)
    if found is not None:
        raise _contradiction_error(found[0])
    grown = growth(program)
    if grown is None:
        return
    along: dict[str, float] = {}
    for name, part in choice.parts.items():
        values = grown[0].x[program.named[name]].tolist()
        for component, value in zip(part.components, values, strict=True):
            along[f"{name}[{component!r}]"] = value
    opened = np.any([question.open_nodes for question in program.questions], axis=0)
    goal = program.goal
    if opened.any():
        goal += f" with nodes {shown(np.flatnonzero(opened).tolist())} open"
    raise ModelError(_growth_text(goal, along))


def _contradiction_error(claim: Solution) -> ModelError:
    """The error for constraints that contradict each other."""
    names = ", ".join(claim.ruling)
    if claim.of_user_alone:
        error, why = ModelError, "they contradict each other"
    else:
        error, why = NoneSafeError, "no design is safe at any load factor with all nodes closed"
    if not names:
        return error(
            f"preloads: {why}; press nodes that are open, or call `shakedown_limit` for designs of "
            "your own"
        )
    return error(f"{names}: {why} under these constraints; drop or relax one of them")


def _growth_text(goal: str, along: Mapping[str, float]) -> str:
    """The text of the error for a goal that grows without end.

    `along`: name of each component -> its growth, divided by its unit.
    """
    largest = max(abs(value) for value in along.values())
    if not largest > GROWN:
        return (
            f"{goal}: it grows without bound for any design; bound it by a constraint, or give "
            "another objective"
        )
    growing = {name: value for name, value in along.items() if abs(value) > GROWN * largest}
    directions: list[str] = []
    for name, value in list(growing.items())[:_MOST_NAMES]:
        side = "upper" if value > 0 else "lower"
        directions.append(f"{name} has no {side} bound")
    text = ", ".join(directions)
    if len(growing) > _MOST_NAMES:
        text += f" and {len(growing) - _MOST_NAMES} more"
    return (
        f"{goal}: it grows without bound with the design: {text}; bound them by constraints, or "
        "subtract their cost"
    )
