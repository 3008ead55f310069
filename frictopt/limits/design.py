"""The best design: preloads and a profile of the faces with the largest shakedown limit, or the cheapest ones for a given load."""

from collections.abc import Mapping, Sequence
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..contact import GROWN, ContactSystem, LoadCycle, SolveRecord, checked_loads, flag, frozen, listed, shown, warns_of_odd_values
from ..errors import ModelError
from . import models
from .answered import answered
from .design_result import PROFILE, Design, built_in, preload_reactions
from .models import Row, named, unknowns
from .programs import Program, listed_rows, own_rows
from .question import Question, pose
from .safe_model import SafeModel, checked_objective, in_turn

_NAMED = 4  # unbounded parts of a design that an error names


class DesignModel(SafeModel):
    """Preloads, fit and profile of a contact as unknowns beside its residual slip, for constraints and objectives of your own.

    Reactions are linear in them, so the best design is the same convex program as the shakedown limit, with the same proof. Residual slips are any
    that the constraints admit; all nodes are kept closed, so where nodes stay open under the mean load the best design may carry less than
    `shakedown_limit` finds for the contact as it is. Theory, eq. (32).

    Parameters
    ----------
    system, cycle
        The contact and its load cycle.
    preloads
        Names of load cases whose amplitudes in the mean load are free: bolt forces, pressures, temperatures, interferences. What the mean load of
        the cycle has of them already stays, and the design adds to it.
    profile
        Whether material may be taken off the faces, a depth at each node.
    scenarios
        More pairs (load cycle, friction) under which the same design has to hold, each with a residual slip of its own; all share the load factor.
        Or (load cycle, friction, shares): load case name -> the share of its preload that acts, for bolts that scatter or lose their tension. Safe in
        all combinations of the least and the largest shares is safe in all between.
    slip_bound, solver
        See `ShakedownModel`.

    Attributes
    ----------
    load_factor
        The load factor, a cvxpy variable, like all others.
    preload
        (J,) amplitudes that the design adds to the mean load, in the order of `preloads`; None without.
    profile
        (N,) material taken off at the nodes, length: it adds to the gap, so that q loses `B^T g` and p loses `C g`. Negative: material added. None
        without.
    slip
        (N,) or (N, 2) residual slip, length.
    q, p
        (K, N) or (K, N, 2) shear and (K, N) normal forces at the corners of the cycle, with the design.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases, preloads that make no reactions but rounding, nothing to choose among, a scenario that is no pair.

    Examples
    --------
    Two bolts, each of which presses one of two nodes that the load shears: how tight, if they have 3 in all?

    >>> import cvxpy as cp
    >>> import frictopt as fo
    >>> system = fo.ContactSystem.from_blocks(
    ...     A=[[2, 0], [0, 2]],
    ...     B=[[0, 0], [0, 0]],
    ...     C=[[2, 0], [0, 2]],
    ...     x=[0, 1],
    ...     bonded={"one": ([0, 0], [1, 0]), "two": ([0, 0], [0, 1]), "Q": ([1, 0.5], [0, 0])},
    ... )
    >>> cycle = fo.LoadCycle({}, [{"Q": -1.0}, {"Q": 1.0}])
    >>> model = fo.DesignModel(system, cycle, preloads=["one", "two"])
    >>> design = model.solve(0.5, [cp.sum(model.preload) <= 3.0, model.preload >= 0])
    >>> round(design.load_factor, 6), design.preload.round(6).to_dict()
    (1.0, {'one': 2.0, 'two': 1.0})
    >>> round(float(design.prices["constraints[0]"]), 6)  # of the budget
    0.333333
    >>> round(fo.shakedown_limit(design.system, design.cycle, 0.5).load_factor, 6)
    1.0
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
        slip_bound: ArrayLike | None = None,
        solver: str | None = None,
    ) -> None:
        super().__init__(system, cycle, slip_bound=slip_bound, solver=solver)
        names, self._shaped = listed("preloads", preloads), flag("profile", profile)
        if unknown := [name for name in names if not (isinstance(name, str) and name in system.bonded)]:
            raise ModelError(f"preloads: {shown(unknown[0])} is no load case; this system has {shown(list(system.bonded))}")
        if len(set(names)) < len(names):
            raise ModelError(f"preloads: {shown(names)}; name each load case once")
        if self._shaped and PROFILE in system.bonded:
            raise ModelError(f"profile: the system has a load case {PROFILE!r}, which is the name of an overlap that a design adds; rename it")
        self._preloads = tuple(names)
        self._others = [self._scenario(s, given) for s, given in enumerate(listed("scenarios", scenarios))]
        if not (names or self._shaped):
            raise ModelError("preloads, profile: none, so nothing is to be chosen; name load cases, or give profile=True")
        self._reactions = preload_reactions(system, names)
        self.preload = cp.Variable(len(names), name="preload") if names else None
        self.profile = cp.Variable(system.nodes, name="profile") if self._shaped else None

    def _scenario(self, s: int, given: Any) -> tuple[Question, Mapping[str, float]]:
        if not isinstance(given, tuple) or len(given) not in (2, 3):
            raise ModelError(f"scenarios[{s}]: {shown(given)}; give (load cycle, friction), or these and the shares of the preloads")
        cycle, friction, shares = given if len(given) == 3 else (*given, {})
        shares = checked_loads(f"scenarios[{s}]", shares)
        if unknown := sorted(set(shares) - set(self._preloads)):
            raise ModelError(f"scenarios[{s}]: shares of {shown(unknown)}; the preloads are {shown(list(self._preloads))}")
        return pose(self._asked.system, cycle, friction, slip_bound=self._asked.most), shares

    @property
    def _unknowns(self) -> list[cp.Variable]:
        return [*super()._unknowns, *(part for part in (self.preload, self.profile) if part is not None)]

    def _more(self, shares: Mapping[str, float]) -> tuple[tuple[cp.Expression, cp.Expression], list[Row]]:
        """What the design adds to q and p, and rows that define it, where some preloads act with a share alone."""
        system, n = self._asked.system, self._asked.system.nodes
        terms, rows = list[tuple[cp.Expression, cp.Expression]](), list[Row]()
        if self.preload is not None:
            acting = self._reactions * [shares.get(name, 1.0) for name in self._preloads]
            terms.append((named(acting[:-n], "Q") @ self.preload, named(acting[-n:], "P") @ self.preload))
        if self.profile is not None:
            q_g, p_g = cp.Variable((len(self._reactions) - n), name="q_g"), cp.Variable(n, name="p_g")
            rows = [q_g == named(-system.B.T, "-B.T") @ self.profile, p_g == named(-system.C, "-C") @ self.profile]
            terms.append((q_g, p_g))
        q, p = (sum(parts[1:], parts[0]) for parts in zip(*terms, strict=True))
        return (q if system.tangents == 1 else cp.reshape(q, system.slip_shape, order="F"), p), rows

    def _listed(self, task: Question) -> list[Program]:
        """The rows of the first scenario, and of all others."""
        listed_all = list[Program]()
        for asked, shares in ((task, {}), *self._others):
            first, of = not listed_all, f"_{len(listed_all)}"
            x = self._x if first else unknowns(asked.system.slip_shape, range(len(asked.r1)), self._x.load_factor, of)
            f = self._f if first else cp.Parameter(asked.system.nodes, nonneg=True, name=f"f{of}")
            more, rows = self._more(shares)
            program = listed_rows(asked, x, f, every=True, more=dict.fromkeys(range(len(asked.r1)), more))
            program.rows += rows
            listed_all.append(program)
        return listed_all

    @warns_of_odd_values
    @in_turn
    def solve(self, friction: ArrayLike, constraints: Sequence[cp.Constraint] = (), objective: cp.Expression | None = None) -> Design:
        """The design with the largest load factor, or the largest objective, under constraints of your own.

        Parameters
        ----------
        friction
            Coefficient of friction, one or one per node. More friction never lowers the load factor, so the least one is the worst case.
        constraints
            cvxpy constraints on `load_factor`, `preload`, `profile`, `slip`, `q` and `p` of this model, in your units, and on variables of your own:
            linear, or of abs, max, norms and the like.
        objective
            What shall be largest, instead of the load factor: a concave cvxpy expression on the same, such as `-cp.sum(model.preload)` at
            `model.load_factor >= 1`.

        Raises
        ------
        ModelError
            Bad friction; constraints that contradict each other, which are named; a design that grows without end, whose direction is named;
            constraints that are not convex, need other cones, or are on another model; such an objective.
        SolverError
            No solver gave an answer that passes the checks.

        Examples
        --------
        The least bolt force for a given load:

        >>> import frictopt as fo
        >>> loads = {"P": ([0.0], [1.0]), "bolt": ([0.0], [0.5]), "Q": ([1.0], [0.0])}
        >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
        >>> model = fo.DesignModel(node, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}]), preloads=["bolt"])
        >>> design = model.solve(0.5, [model.load_factor >= 2.0], objective=-model.preload[0])
        >>> design.preload.round(6).to_dict()
        {'bolt': 6.0}
        """
        task, own = self._posed(friction), listed("constraints", constraints)
        every = self._listed(task)
        program = every[0]
        program.own = own_rows(own, self._unknowns)
        problem = models.design(self._x, [row for each in every for row in each.rows])
        if objective is not None:
            problem = cp.Problem(cp.Maximize(checked_objective(objective, self._unknowns)), problem.constraints)
        program.compiled(problem, task.load_unit if objective is None else 1.0, self._units(every), every[1:])
        chosen = objective is not None
        claim, record = program.chain.solve(lambda: self._judged(every, chosen), self._solver, no_optimum=lambda: self._refused(program, chosen))
        design = answered(claim, record, program)
        for part, value in ((self.preload, design.preload), (self.profile, design.profile)):
            if part is not None:
                part.save_value(np.asarray(value))
        return self._shown(design)

    def _units(self, every: Sequence[Program]) -> dict[cp.Variable, Any]:
        """Units of the design, which make reactions of about the force of the contact at a node, and of the other scenarios."""
        task, units = every[0].task, dict[cp.Variable, Any]()
        if self.preload is not None:
            sizes = np.abs(self._reactions).mean(axis=0)
            units[self.preload] = task.force / np.where(sizes > 0, sizes, task.force)
        if self.profile is not None:
            units[self.profile] = task.force / task.system.own_stiffness[-task.system.nodes :]
        for program in every[1:]:
            units |= {variable: unit for variable, unit in program.units.items() if variable is not self.load_factor}
        return units

    def _judged(self, every: Sequence[Program], chosen: bool) -> Design:
        """Judge the design that stands in a program: built in, by the contact law in every scenario, and by the multipliers of all rows."""
        program, names = every[0], self._preloads
        preload = np.zeros(0) if self.preload is None else frozen(self.preload.value + 0.0)  # no -0
        profile = None if self.profile is None else frozen(self.profile.value + 0.0)
        amounts = dict(zip(names, preload.tolist(), strict=True))
        acting = [amounts, *({name: a * shares.get(name, 1.0) for name, a in amounts.items()} for _, shares in self._others)]
        system, cycles = built_in(self._asked.system, [(one.task.cycle, loads) for one, loads in zip(every, acting, strict=True)], profile)
        slips = [frozen(one.slip) for one in every]
        tasks = tuple(pose(system, cycle, one.task.friction, slip_bound=self._asked.most) for cycle, one in zip(cycles, every, strict=True))
        load_factor, proof = program.load_factor, program.chain.proof
        unsafe = max(task.violation(load_factor, slip) for task, slip in zip(tasks, slips, strict=True))
        residual = float(np.nan_to_num(np.max([unsafe, proof.gap, program.own_violation]), nan=np.inf))
        return Design(
            load_factor=load_factor,
            objective=proof.value if chosen else None,
            bound=proof.bound + proof.defect,
            preload=pd.Series(preload, index=pd.Index(names, name="load", dtype=object), name="preload"),
            profile=profile,
            slip=slips[0],
            slips=tuple(slips),
            _task=tasks[0],
            prices=program.prices(),
            record=SolveRecord(residual=residual),
            _tasks=tasks,
        )

    def _refused(self, program: Program, chosen: bool) -> None:
        """Say why there is no best design; None where that cannot be proven."""
        if none := program.chain.contradiction(self._solver):
            ruling, own = program.ruling(none.ruling), {row.id for group in program.own.values() for row in group}
            safe = "no design is safe at any load factor with all nodes closed" if none.ruling - own else "they contradict each other"
            if not ruling:
                raise ModelError(f"preloads: {safe}; press nodes that are open, or ask `shakedown_limit` of designs of your own")
            raise ModelError(f"{', '.join(ruling)}: {safe} under these constraints; drop or relax one")
        growth = program.chain.growth(self._solver)
        if growth is None:
            return
        parts = {"preload": self.preload, "profile": self.profile}
        units, found = self._units([program]), dict[str, float]()
        for part, variable in parts.items():
            if variable is not None:
                along = np.ravel(program.chain.value_along(growth, variable) / units[variable])
                names = [repr(name) for name in self._preloads] if part == "preload" else [str(node) for node in range(len(along))]
                found |= {f"{part}[{name}]": value for name, value in zip(names, along.tolist(), strict=True)}
        largest, goal = max(map(abs, found.values())), "objective" if chosen else "load_factor"
        if not largest > GROWN:
            raise ModelError(f"{goal}: it grows without end whatever the design; bound it by a constraint, or give another objective")
        grows = {name: value for name, value in found.items() if abs(value) > GROWN * largest}
        named_parts = [f"{name} has no {'upper' if value > 0 else 'lower'} bound" for name, value in [*grows.items()][:_NAMED]]
        more = f" and {len(grows) - _NAMED} more" if len(grows) > _NAMED else ""
        raise ModelError(
            f"{goal}: it grows without end with the design: {', '.join(named_parts)}{more}; bound them by constraints, or say what they cost"
        )
