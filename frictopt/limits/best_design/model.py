"""The model of a best design: the contact whose preloads and profile are unknowns.

`program.py` lists the terms of a design in the program of a limit. `design.py` has
the result, and finds its open nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import cvxpy as cp
import numpy as np

from ...base import (
    Array,
    PerNode,
    SolveRecord,
    flag,
    frozen,
    listed,
    progress_bar,
    warns_of_odd_values,
)
from ...contact import ContactSystem, LoadCycle
from ...errors import SolverError
from ..answers.answered import answered
from ..printed.user_rows import UserRows
from ..program.question import with_open
from ..program.rest_program import RestProgram
from ..program.solution import Solution, solve
from ..search.loose_nodes import LooseNodes
from ..search.set_search import is_small
from ..user_models import SafeModel
from .design import Design, DesignSearch, NoneSafeError, OpenNodes, limits_of
from .program import (
    Scenario,
    checked_choice,
    checked_scenario,
    design_problem,
    design_program,
    open_slips,
    press,
    raise_refusal,
    under_mean_load,
)


class DesignModel(SafeModel):
    """A contact whose preloads and profile are unknowns, in addition to its residual slip.

    Your own constraints and objectives may contain all these unknowns. Reactions are linear in
    them. So for given open nodes a convex program finds the best design, with the same proof as for
    the shakedown limit. All nodes are closed at first. If the best design leaves a node without
    pressure, or if no design is safe, design and open nodes are computed in turn. This ends when
    `shakedown_limit`, with the design built in, has the same open nodes. A design does not count if
    this limit is below the load factor of the design. If some design is safe both at its load
    factor and under its mean load alone, only such designs count. Theory, eq. (32).

    Parameters
    ----------
    system, cycle, slip_bound, solver
        See `ShakedownModel`.
    preloads
        Names of load cases whose amplitudes in the mean load are free: bolt forces, pressures,
        temperatures, interferences. The design adds to the amplitudes of `cycle`.
    profile
        Whether the depth of material removed from the faces is free at each node.
    scenarios
        More pairs (load cycle, friction) under which the design has to be safe. Each has its own
        residual slip; the load factor is common to all. In a triple (load cycle, friction, shares),
        `shares` has the share of each preload that acts (load case name -> share), for bolts that
        scatter or loosen. A design that is safe for all combinations of the least and the largest
        shares is safe for all shares in between, if the same nodes are open.

    Attributes
    ----------
    load_factor, slip, q, p
        As in `ShakedownModel`, for the contact with the design.
    preload
        (J,) amplitudes that the design adds to the mean load, in the order of `preloads`; None if
        there are no preloads.
    profile
        (N,) depth g of material removed, length; negative: material added. It increases the gap, so
        that `B^T g` is subtracted from q and `C g` from p. None if the profile is not free.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases, preloads whose reactions are only rounding, neither
        preloads nor a profile, a scenario that is not a pair or triple.

    Examples
    --------
    Each of two bolts presses one node with 0.1 or more. The load shears both nodes. The sum of the
    bolt forces is at most 3:

    >>> import cvxpy as cp
    >>> import frictopt as fo
    >>> loads = {"one": ([0, 0], [1, 0]), "two": ([0, 0], [0, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> stiff, uncoupled = [[2, 0], [0, 2]], [[0, 0], [0, 0]]
    >>> system = fo.ContactSystem.from_blocks(stiff, uncoupled, stiff, [0, 1], loads)
    >>> cycle = fo.LoadCycle({}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> model = fo.DesignModel(system, cycle, preloads=["one", "two"])
    >>> design = model.solve(0.5, [cp.sum(model.preload) <= 3.0, model.preload >= 0.1])
    >>> round(design.load_factor, 6), design.preload.round(6).to_dict()
    (1.0, {'one': 2.0, 'two': 1.0})
    """

    preload: Any
    profile: Any

    def __init__(
        self,
        system: ContactSystem,
        cycle: LoadCycle,
        *,
        preloads: Sequence[str] = (),
        profile: bool = False,
        scenarios: Sequence[tuple[Any, ...]] = (),
        slip_bound: PerNode | None = None,
        solver: str | None = None,
    ) -> None:
        super().__init__(system, cycle, slip_bound=slip_bound, solver=solver)
        self._choice = checked_choice(system, preloads, flag("profile", profile))
        variables = {name: variable for variable, name in self._choice.variables.items()}
        self.preload = variables.get("preload")
        self.profile = variables.get("profile")
        question = self._question
        self._others = [
            checked_scenario(f"scenarios[{number}]", scenario, self._choice, question)
            for number, scenario in enumerate(listed("scenarios", scenarios))
        ]

    @warns_of_odd_values
    def solve(
        self,
        friction: PerNode,
        constraints: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
        *,
        progress: bool = True,
    ) -> Design:
        """Design with the largest load factor or objective, under user constraints.

        Parameters
        ----------
        friction, constraints
            As in `ShakedownModel.solve`; constraints may also contain `preload` and `profile`. With
            the same open nodes, more friction never lowers the load factor.
        objective
            Scalar to maximize instead of the load factor: a concave cvxpy expression.
        progress
            See `shakedown_limit`. Ctrl-C raises KeyboardInterrupt. Its attribute `design` is the
            best design so far, if there is one.

        Raises
        ------
        ModelError
            Bad friction; contradictory constraints (the error names them); a design that grows
            without end (the error names its direction); constraints or an objective that are not
            convex, need other cones, or belong to another model.
        SolverError
            No solver gave an answer that passes the checks, or every design of the search opens
            other nodes under its mean load, with a smaller limit.

        Examples
        --------
        The least bolt force for a load factor of 2:

        >>> import frictopt as fo
        >>> loads = {"bolt": ([0.0], [0.5]), "Q": ([1.0], [0.0])}
        >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
        >>> cycle = fo.LoadCycle({}, [{"Q": -1.0}, {"Q": 1.0}])
        >>> model = fo.DesignModel(node, cycle, preloads=["bolt"])
        >>> design = model.solve(0.5, [model.load_factor >= 2.0], objective=-model.preload[0])
        >>> design.preload.round(6).to_dict()
        {'bolt': 8.0}
        """
        with self._turn, progress_bar(progress, "design", "program") as bar:
            user = self._user(constraints, objective, self._slip_of_open_nodes)
            scenarios = [Scenario(self._posed(friction), {}), *self._others]
            questions = [scenario.question for scenario in scenarios]
            search = DesignSearch(
                partial(self._best_with, scenarios, user),
                partial(self._listed, user),
                bar,
            )
            search.alternate([question.open_nodes for question in questions])
            if not search.counted or search.counted[0].touches:
                search.alternate(self._open_nodes_if_pressed(scenarios, user))
            search.alternate([limit.open for limit in limits_of(questions)])
            if is_small(questions):
                search.compare(self._loose(scenarios, user))
            if search.best is None:
                raise search.refusal

            design = replace(search.best, _is_best_of_all=search.is_best_of_all)
            design = self._listed(user, design)
            if self.preload is not None:
                self.preload.save_value(design.preload.to_numpy())
            if self.profile is not None:
                self.profile.save_value(design.profile)
            return self._shown(design)

    @property
    def _named(self) -> dict[cp.Variable, str]:
        return {**super()._named, **self._choice.variables}

    def _loose(self, scenarios: Sequence[Scenario], user: UserRows | None) -> LooseNodes:
        """The programs for designs in which every node may be open or closed."""
        nodes = np.arange(self._question.system.nodes)
        program = design_program(self._choice, scenarios, loose=nodes)
        if user is not None:
            user.add_to(program)
        largest = self._question.load_unit if program.goal == "load_factor" else np.inf
        return LooseNodes(program, nodes, largest)

    def _slip_of_open_nodes(self, program: RestProgram) -> Array:
        """(open slips, named) slips of the open nodes of the first scenario due to the design."""
        question = program.question
        opened = int(question.open_nodes.sum()) * question.system.tangents
        rates = np.zeros((opened, len(program.named_units)))
        for name, reactions in self._choice.effects(Scenario(question, {})).items():
            rates[:, program.named[name]] = open_slips(question, reactions)
        return rates

    def _listed(self, user: UserRows | None, design: Design) -> Design:
        """A design with its printed problem."""
        assert design._found is not None  # the problem has not been listed yet
        problem = design_problem(self._choice, *design._found, self._x, user)
        return replace(design, problem=problem, _found=None)

    def _best_with(
        self,
        scenarios: Sequence[Scenario],
        user: UserRows | None,
        open_nodes: OpenNodes,
    ) -> Design:
        """The best design with given nodes open in each scenario.

        If the best design is not safe under the mean load, but some other design is, the result is
        the best design that is.
        """
        design = self._solved(scenarios, user, open_nodes)
        if design._is_safe_at_mean_load:
            return design
        at_mean_load = [under_mean_load(scenario) for scenario in scenarios]
        both = [*scenarios, *at_mean_load]
        try:
            safe = self._solved(both, user, [*open_nodes, *open_nodes])
        except (NoneSafeError, SolverError):
            return design
        count = len(scenarios)
        return replace(
            safe,
            slips=safe.slips[:count],
            _questions=safe._questions[:count],
            _without_mean_load=design.value,
        )

    def _solved(
        self,
        scenarios: Sequence[Scenario],
        user: UserRows | None,
        open_nodes: OpenNodes,
    ) -> Design:
        """The solution of the program of a design, see `_best_with`."""
        opened = []
        for scenario, nodes in zip(scenarios, open_nodes, strict=True):
            question = None if nodes.all() else with_open(scenario.question, nodes)
            if question is None:
                raise NoneSafeError("design: the closed nodes do not hold the open ones")
            opened.append(Scenario(question, scenario.shares))
        program = design_program(self._choice, opened)
        if user is not None:
            user.add_to(program)
        design, record = solve(
            program,
            partial(self._checked, opened, user),
            no_optimum=lambda outcome: raise_refusal(program, self._choice),
        )
        return answered(design, record)

    def _checked(
        self, scenarios: Sequence[Scenario], user: UserRows | None, solution: Solution
    ) -> Design:
        """The design of a solution, with its residual.

        Its slips are checked by the contact law in every scenario, with the design built in. Its
        bound is checked by the multipliers of all rows.
        """
        load_factor = solution.load_factor
        values = {name: solution.values(name) for name in self._choice.parts}
        built = self._choice.built(scenarios, values)
        slips: list[Array] = []
        violations: list[float] = []
        for number, question in enumerate(built.questions):
            slip = frozen(question.slip_at_mean_load(solution.closed_slip(number)))
            slips.append(slip)
            violations.append(question.violation(load_factor, slip))
        bound, defect = solution.bound
        import pandas as pd  # imported here, because only designs need it

        names = pd.Index(self._choice.names, name="load", dtype=object)
        return Design(
            load_factor=load_factor,
            objective=None if solution.program.goal == "load_factor" else solution.value,
            bound=bound + defect,
            preload=pd.Series(built.preload, index=names, name="preload"),
            profile=built.profile,
            slip=slips[0],
            slips=tuple(slips),
            _question=built.questions[0],
            prices={} if user is None else user.prices(solution),
            record=SolveRecord(residual=solution.residual(*violations)),
            _questions=built.questions,
            _found=(scenarios, solution),
        )

    def _open_nodes_if_pressed(
        self, scenarios: Sequence[Scenario], user: UserRows | None
    ) -> OpenNodes | None:
        """The open nodes under preloads that press as much as the constraints admit.

        They are another start of the search. Preloads are at most ten times the forces of the
        contact. If there are no preloads, the start is a zero profile. None if no answer passes the
        checks.
        """
        values = {"profile": np.zeros(self._question.system.nodes)}
        try:
            if self.preload is not None:
                values = press(self._choice, scenarios[0], user)
            built = self._choice.built(scenarios, values)
        except SolverError:
            return None
        return [limit.open for limit in limits_of(built.questions)]
