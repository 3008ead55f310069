"""The terms of a design in the program of a limit: preloads and a profile as unknowns.

A design is linear in its unknowns. Preloads b of load cases with reactions q_j, p_j add `q_j b` to
the shear forces and `p_j b` to the normal forces. A profile g increases the gap, so that the shear
forces decrease by `B^T g` and the normal forces by `C g`. Open nodes follow without force, so
preloads and profile also change the gaps and slips of these nodes.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import cvxpy as cp
import numpy as np

from ..base import CONDENSATION, GROWN, Array, SolveRecord, checked_loads, frozen, listed, shown
from ..contact import ContactSystem, LoadCycle, joined
from ..errors import ModelError
from .design_search import NoneSafeError
from .models import Row, Unknowns, constant, defines
from .programs import Program, listed_rows
from .question import Question, pose, with_open

# Name of the load case of the overlap that a profile causes.
PROFILE = "profile"

# Largest mean normal force of the preloads, divided by the mean normal force of the contact.
_MOST_PRESSED = 10.0

# Largest number of unbounded components of a design that an error names.
_MOST_NAMES = 4

_ROUNDING = (
    "preloads: {name!r} has reactions of {size:.1e}, which is only rounding relative to the "
    "reactions {largest:.1e} of others; leave it out if it has no effect on the contact, "
    "otherwise enlarge its unit, or reduce the unit of the other load cases"
)
_NONE_SAFE = "no design is safe at any load factor with all nodes closed"
_CONTRADICT = "they contradict each other"
_NONE_SAFE_AT_ALL = (
    "preloads: {why}; press nodes that are open, or call `shakedown_limit` for designs of your own"
)
_NONE_OBEYS = "{names}: {why} under these constraints; drop or relax one of them"
_GROWS = (
    "{goal}: it grows without bound for any design; bound it by a constraint, "
    "or give another objective"
)
_GROWS_WITH_DESIGN = (
    "{goal}: it grows without bound with the design: {directions}; bound them by constraints, "
    "or subtract their cost"
)


class Scenario(NamedTuple):
    """A question in which a design has to hold, and the share of each preload that acts there."""

    question: Question
    shares: Mapping[str, float]


class Added(NamedTuple):
    """The terms that a design adds to a question, and the rows that define their unknowns."""

    listed: list[cp.Expression]  # added to q, p and, if nodes are open, to the gaps
    open_slip: cp.Expression | None  # added to the slips of open nodes
    rows: list[Row]


class Built(NamedTuple):
    """The values of a design, and the question of each scenario with the design built in."""

    preload: Array
    profile: Array | None
    questions: tuple[Question, ...]


@dataclass(frozen=True, eq=False)
class Choice:
    """The unknowns of a design: amplitudes of load cases in the mean load, and a profile."""

    system: ContactSystem
    names: tuple[str, ...]
    preload: cp.Variable | None  # (J,)
    profile: cp.Variable | None  # (N,)

    @cached_property
    def reactions(self) -> Array:
        """(M, J) reactions of unit amplitudes of the load cases, force."""
        by_load = [joined(*self.system.bonded[name]) for name in self.names]
        return np.reshape(by_load, (len(self.names), len(self.system.S))).T

    @property
    def components(self) -> dict[cp.Variable, Sequence[object]]:
        """Names of the components of each unknown."""
        names: dict[cp.Variable, Sequence[object]] = {}
        if self.preload is not None:
            names[self.preload] = self.names
        if self.profile is not None:
            names[self.profile] = range(self.system.nodes)
        return names

    def units(self, question: Question) -> dict[cp.Variable, Any]:
        """Units of the unknowns: each causes about the mean normal force at a node."""
        units: dict[cp.Variable, Any] = {}
        if self.preload is not None:
            sizes = np.abs(self.reactions).mean(axis=0)
            units[self.preload] = question.force / np.where(sizes > 0, sizes, question.force)
        if self.profile is not None:
            normal_stiffness = self.system.own_stiffness[-self.system.nodes :]
            units[self.profile] = question.force / normal_stiffness
        return units

    def added(self, scenario: Scenario, suffix: str = "") -> Added:
        """The terms that the design adds to a scenario. All names end with `suffix`."""
        question, shares = scenario
        by_part: list[list[cp.Expression]] = []
        rows: list[Row] = []
        if self.preload is not None:
            acting = self.reactions * [shares.get(name, 1.0) for name in self.names]
            products = _products(
                question, acting, ("q_j", "p_j", "w_j", "v_j"), self.preload, suffix
            )
            by_part.append(products)

        if self.profile is not None:
            closing = -self.system.S[:, -self.system.nodes :]
            products = _products(
                question, closing, ("-B.T", "-C", "-w", "-v"), self.profile, suffix
            )
            # These matrices are dense. `frictopt.solve` keeps them out of cvxpy if each product is
            # defined by an equation.
            unknowns = [
                cp.Variable(product.size, name=f"{symbol}_g{suffix}")
                for product, symbol in zip(products, "qpwv", strict=False)
            ]
            rows = [
                defines(part, product) for part, product in zip(unknowns, products, strict=True)
            ]
            by_part.append(unknowns)

        q, p, *of_open_nodes = (sum(parts[1:], parts[0]) for parts in zip(*by_part, strict=True))
        if self.system.tangents > 1:
            q = cp.reshape(q, self.system.slip_shape, order="F")
        open_slip = of_open_nodes[1] if of_open_nodes else None
        return Added([q, p, *of_open_nodes[:1]], open_slip, rows)

    def no_larger(self, share: float, preload: Array, profile: Array | None) -> list[Row]:
        """Rows that bound preloads and depths by a share of the largest given ones."""
        rows: list[Row] = []
        for variable, values in ((self.preload, preload), (self.profile, profile)):
            if variable is not None and values is not None:
                size = share * float(np.abs(values).max())
                rows.append((cp.abs(variable) <= size).set_label(f"size_{variable.name()}"))
        return rows

    def built(self, scenarios: Sequence[Scenario]) -> Built:
        """The design from the values of the unknowns, built into the questions of all scenarios."""
        # Adding 0 turns -0 into 0.
        preload = np.zeros(0) if self.preload is None else frozen(self.preload.value + 0.0)
        profile = None if self.profile is None else frozen(self.profile.value + 0.0)
        system, overlap = _with_profile(self.system, profile)
        built: list[Question] = []
        for question, shares in scenarios:
            mean = dict(question.cycle.mean)
            for name, amount in zip(self.names, preload.tolist(), strict=True):
                mean[name] = mean.get(name, 0.0) + amount * shares.get(name, 1.0)
            cycle = replace(question.cycle, mean={**mean, **overlap})
            closed = pose(system, cycle, question.friction, slip_bound=question.slip_bound)
            built.append(with_open(closed, question.open_nodes) or closed)
        return Built(preload, profile, tuple(built))


def checked_choice(system: ContactSystem, preloads: Sequence[str], has_profile: bool) -> Choice:
    """The unknowns of a design; ModelError for load cases whose reactions are only rounding."""
    names = listed("preloads", preloads)
    known = list(system.bonded)
    for name in names:
        if not (isinstance(name, str) and name in known):
            raise ModelError(
                f"preloads: {shown(name)} is no load case; this system has {shown(known)}"
            )
    if len(set(names)) < len(names):
        raise ModelError(f"preloads: {shown(names)}; name each load case once")
    if has_profile and PROFILE in known:
        raise ModelError(
            f"profile: the system has a load case {PROFILE!r}, which is the name of an overlap "
            "that a design adds; rename it"
        )
    if not (names or has_profile):
        raise ModelError(
            "preloads, profile: none, so the design has no unknowns; name load cases, or give "
            "profile=True"
        )
    preload = cp.Variable(len(names), name="preload") if names else None
    profile = cp.Variable(system.nodes, name="profile") if has_profile else None
    choice = Choice(system, tuple(names), preload, profile)
    largest = max(np.abs(joined(*pair)).mean() for pair in system.bonded.values())
    for name, size in zip(names, np.abs(choice.reactions).mean(axis=0), strict=True):
        if 0 < size < CONDENSATION * largest:
            raise ModelError(_ROUNDING.format(name=name, size=size, largest=largest))
    return choice


def checked_scenario(name: str, scenario: Any, choice: Choice, slip_bound: Any) -> Scenario:
    """A scenario of the user, under its name."""
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
    return Scenario(pose(choice.system, cycle, friction, slip_bound=slip_bound), shares)


def under_mean_load(scenario: Scenario) -> Scenario:
    """A scenario at load factor 0, with the same preloads."""
    question, shares = scenario
    cycle = question.cycle
    # Without a fixed part all corners are the same load, and one is enough.
    at_zero = LoadCycle(cycle.mean, [{}] * len(cycle.unscaled), cycle.fixed)
    return Scenario(
        pose(question.system, at_zero, question.friction, slip_bound=question.slip_bound), shares
    )


def _products(
    question: Question, r: Array, names: Sequence[str], chosen: cp.Variable, suffix: str
) -> list[cp.Expression]:
    """The terms of loads, with unknown amplitudes `chosen` (J,), in q and p.

    `r` (M, J) are their bonded reactions. If nodes are open, also the terms in the gaps and in the
    slips of these nodes.
    """
    n = question.system.nodes
    carried = question.carried(r.T).reshape(r.shape[::-1]).T
    effects = [carried[:-n], carried[-n:]]
    if question.compliance is not None:
        follow = -(question.compliance @ r)
        open_nodes = question.open_nodes
        open_slips = np.tile(open_nodes, question.system.tangents)
        effects += [follow[-n:][open_nodes], follow[:-n][open_slips]]
    return [
        constant(effect, name + suffix) @ chosen
        for effect, name in zip(effects, names, strict=False)
    ]


def _with_profile(
    system: ContactSystem, profile: Array | None
) -> tuple[ContactSystem, dict[str, float]]:
    """The contact with a profile in its gap, and a load of the overlap if material overlaps."""
    if profile is None:
        return system, {}
    gap = system.gap + profile
    system = system.with_gap(np.maximum(gap, 0.0))
    if gap.min() >= 0:
        return system, {}
    return system.with_interference({PROFILE: np.maximum(-gap, 0.0)}), {PROFILE: 1.0}


def press(
    choice: Choice, scenario: Scenario, x: Unknowns, f: cp.Parameter, user_rows: Mapping[str, Row]
) -> None:
    """Set the unknowns to the preloads with the largest force that the user's rows admit.

    The force is at most `_MOST_PRESSED` times the normal force of the contact. SolverError if no
    answer passes the checks.
    """
    question = scenario.question
    n = question.system.nodes
    added = choice.added(scenario)
    at_corners = dict.fromkeys(range(len(question.r1)), added.listed)
    program = listed_rows(
        question, x, f, every=True, friction=lambda x, corners: [], more=at_corners
    )
    program.user_rows = user_rows
    force = choice.reactions[-n:].sum(axis=0) @ choice.preload
    bounded = force <= _MOST_PRESSED * n * question.force
    problem = cp.Problem(cp.Maximize(force), [*program.rows, *added.rows, bounded])
    program.compiled(problem, n * question.force, choice.units(question))
    program.chain.solve(lambda: SolveRecord(residual=program.chain.violation))


def raise_refusal(program: Program, choice: Choice, goal: str) -> None:
    """Raise an error if it is proven that there is no best design; return if not.

    `goal` is the name of the maximized value.
    """
    contradiction = program.chain.contradiction()
    if contradiction:
        raise _contradiction_error(program, contradiction.ruling)
    growth = program.chain.growth(CONDENSATION)
    if growth is None:
        return
    along: dict[str, float] = {}
    units = choice.units(program.question)
    for variable, components in choice.components.items():
        growing = np.ravel(program.chain.value_along(growth, variable) / units[variable])
        for component, value in zip(components, growing.tolist(), strict=True):
            along[f"{variable.name()}[{component!r}]"] = value
    raise ModelError(_growth_text(goal, along))


def _contradiction_error(program: Program, ruling: Collection[int]) -> ModelError:
    """The error for rows, by their ids, that contradict each other."""
    user_rows = {row.id for row in program.user_rows.values()}
    names = ", ".join(program.ruling(ruling))
    if set(ruling) <= user_rows:
        error, why = ModelError, _CONTRADICT
    else:
        error, why = NoneSafeError, _NONE_SAFE
    if not names:
        return error(_NONE_SAFE_AT_ALL.format(why=why))
    return error(_NONE_OBEYS.format(names=names, why=why))


def _growth_text(goal: str, along: Mapping[str, float]) -> str:
    """The text of the error for a goal that grows without end.

    `along`: name of each component -> its growth, divided by its unit.
    """
    largest = max(abs(value) for value in along.values())
    if not largest > GROWN:
        return _GROWS.format(goal=goal)
    growing = {name: value for name, value in along.items() if abs(value) > GROWN * largest}
    directions: list[str] = []
    for name, value in list(growing.items())[:_MOST_NAMES]:
        side = "upper" if value > 0 else "lower"
        directions.append(f"{name} has no {side} bound")
    text = ", ".join(directions)
    if len(growing) > _MOST_NAMES:
        text += f" and {len(growing) - _MOST_NAMES} more"
    return _GROWS_WITH_DESIGN.format(goal=goal, directions=text)
