"""The best design: preloads and a profile of the faces with the largest shakedown limit, or the cheapest ones for a given load."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..contact import GROWN, RESIDUAL, ContactSystem, LoadCycle, SolveRecord, checked_loads, flag, frozen, listed, shown, warns_of_odd_values
from ..errors import ModelError
from ..solve.solvers import contradiction, is_unbounded, solve
from ..solve.standard_form import StandardForm, compiled
from .design_result import PROFILE, Design, DesignLoads, built_in, design_loads
from .friction_bounds import safe_set
from .judge import answered
from .own_rows import OF_A_MODEL
from .question import LimitQuestion, pose
from .safe_model import SafeModel, in_turn
from .safe_set import SafeSet

_NAMED = 4  # unbounded parts of a design that an error names


def design_problem(sets: Sequence[SafeSet]) -> cp.Problem:
    """Largest load factor lam at which a design leaves every scenario s a safe residual slip v_s of its own.

    In full, with amplitudes b of preloads of reactions `q_j, p_j`, and a profile g, material taken off::

        max lam   s.t.   |q_sk| <= f_s p_sk,  p_sk >= 0
        where   q_sk = q0 + lam q1_k + A v_s + sum_j b_j q_j - B^T g,   p_sk = p0 + lam p1_k + B v_s + sum_j b_j p_j - C g

    For the rows of each scenario see `shakedown_problem`.
    """
    lam, rows = sets[0].load_factor, list[cp.Constraint]()
    for s, v in enumerate(sets):
        of = f", scenario {s}" if s else ""
        rows += [row.set_label(row.label + of) for row in v.program(cp.Maximize(lam), v.stuck(lam)).constraints]
    return cp.Problem(cp.Maximize(lam), [*rows, (lam >= 0).set_label("load_factor_not_negative")])


class DesignModel(SafeModel):
    """Preloads, fit and profile of a contact as unknowns beside its residual slip, for constraints and objectives of your own.

    Reactions are linear in them, so the best design is the same convex program as the shakedown limit, with the same proof. Residual slips are any
    that the constraints admit; all nodes are kept closed, so where nodes stay open under the mean load the best design may carry less than
    `shakedown_limit` finds for the contact as it is. Threads that ask one model wait for each other. Theory, eq. (32).

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

    _design: DesignLoads
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
        self._others = [self._scenario(s, names, given) for s, given in enumerate(listed("scenarios", scenarios))]
        if not (names or self._shaped):
            raise ModelError("preloads, profile: none, so nothing is to be chosen; name load cases, or give profile=True")
        self._design = design_loads(system, names, self._shaped, self._asked.force)
        self.preload = cp.Variable(len(names), name=OF_A_MODEL + "preload") if names else None
        self.profile = cp.Variable(system.nodes, name=OF_A_MODEL + "profile") if self._shaped else None
        self._more = [safe_set(task, self._design.shared(shares)) for task, shares in self._others]

    def _scenario(self, s: int, preloads: Sequence[str], given: Any) -> tuple[LimitQuestion, Mapping[str, float]]:
        if not isinstance(given, tuple) or len(given) not in (2, 3):
            raise ModelError(f"scenarios[{s}]: {shown(given)}; give (load cycle, friction), or these and the shares of the preloads")
        cycle, friction, shares = given if len(given) == 3 else (*given, {})
        shares = checked_loads(f"scenarios[{s}]", shares)
        if unknown := sorted(set(shares) - set(preloads)):
            raise ModelError(f"scenarios[{s}]: shares of {shown(unknown)}; the preloads are {shown(list(preloads))}")
        return pose(self._asked.system, cycle, friction, slip_bound=self._asked.most), shares

    def _meant(self, v: SafeSet) -> dict[cp.Variable, cp.Expression]:
        values, count = self._design.values, len(self._design.preloads)
        parts = ((self.preload, values[:count]), (self.profile, values[count:]))
        return super()._meant(v) | {part: expression for part, expression in parts if part is not None}

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
        task = self._posed(friction)
        for v, (other, _) in zip(self._more, self._others, strict=True):
            v.ask(replace(other, load_unit=task.load_unit))
            self._compiled.clear()
        program = self._program(lambda v: design_problem([v, *self._more]), task, listed("constraints", constraints), objective)
        for v in (program, *self._more):
            if found := v.helpless():
                why = f"{found[1]}: no design is safe at any load factor above 0 with all nodes closed"
                raise ModelError(f"friction: {why}; give friction to every node")
        answer = solve(program.problem, lambda: self._judged(program), self._solver, no_optimum=lambda: self._refused(program))
        program.own.save()
        design = answered(answer, program)
        named = {"preload": design.preload, "profile": design.profile}
        return self._shown(design, **{name: values for name, values in named.items() if getattr(self, name) is not None})

    def _judged(self, program: SafeSet) -> Design:
        """Judge the design that stands in a program: built in, by the contact law in every scenario, and by the multipliers of all rows."""
        count, amounts = len(self._design.preloads), frozen(self._design.values.value + 0.0)  # no -0
        preload, profile = amounts[:count], amounts[count:] if self._shaped else None
        every, unit = [program, *self._more], program.own.objective_unit or program.task.load_unit
        named = dict(zip(self._design.preloads, preload.tolist(), strict=True))
        acting = [named, *({name: a * shares.get(name, 1.0) for name, a in named.items()} for _, shares in self._others)]
        system, cycles = built_in(self._asked.system, [(one.task.cycle, loads) for one, loads in zip(every, acting, strict=True)], profile)
        slips = [frozen(one.solved_slip) for one in every]
        tasks = tuple(pose(system, cycle, one.task.friction, slip_bound=self._asked.most) for cycle, one in zip(cycles, every, strict=True))
        load_factor = max(0.0, float(program.load_factor.value) * program.task.load_unit)
        form = StandardForm(program.problem)
        value, bound = form.bounds
        unsafe = max(task.violation(load_factor, slip) for task, slip in zip(tasks, slips, strict=True))
        residual = float(np.nan_to_num(max(unsafe, form.gap, program.own.violation), nan=np.inf))
        return Design(
            load_factor=load_factor,
            objective=None if program.own.objective_unit is None else value * unit,
            bound=bound * unit,
            preload=pd.Series(preload, index=pd.Index(self._design.preloads, name="load", dtype=object), name="preload"),
            profile=profile,
            slip=slips[0],
            slips=tuple(slips),
            _task=tasks[0],
            prices=program.own.prices(unit),
            record=SolveRecord(residual=residual),
            _tasks=tasks,
        )

    def _refused(self, program: SafeSet) -> None:
        """Say why there is no best design; None where that cannot be proven."""
        excess = contradiction(program.problem, self._solver)
        if excess.bound > RESIDUAL:
            ruling = [name for name in program.own.names if name in excess.ruling]
            unsafe = excess.ruling - set(program.own.names)
            safe = "no design is safe at any load factor with all nodes closed" if unsafe else "they contradict each other"
            if not ruling:
                raise ModelError(f"preloads: {safe}; press nodes that are open, or ask `shakedown_limit` of designs of your own")
            raise ModelError(f"{', '.join(ruling)}: {safe} under these constraints; drop or relax one")
        growth = is_unbounded(program.problem, self._solver)
        if growth is None or excess.value > RESIDUAL:
            return
        first = compiled(program.problem)["param_prob"].var_id_to_col[self._design.amounts.id]
        along = growth.z[first : first + self._design.amounts.size]
        grows = np.flatnonzero(np.abs(along) > GROWN * np.abs(along).max(initial=0.0))
        goal = "load_factor" if program.own.objective_unit is None else "objective"
        if not np.abs(along).max(initial=0.0) > GROWN:
            raise ModelError(f"{goal}: it grows without end whatever the design; bound it by a constraint, or give another objective")
        named = [f"{self._design.name(k)} has no {'upper' if along[k] > 0 else 'lower'} bound" for k in grows[:_NAMED]]
        more = f" and {len(grows) - _NAMED} more" if len(grows) > _NAMED else ""
        raise ModelError(f"{goal}: it grows without end with the design: {', '.join(named)}{more}; bound them by constraints, or say what they cost")
