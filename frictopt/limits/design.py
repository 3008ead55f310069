"""The best design: preloads and a profile of the faces with the largest shakedown limit, or the cheapest ones for a given load."""
# One file because the answer, the model that asks for it and the judge that makes it name each
# other.

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ..base import (
    CONDENSATION,
    GROWN,
    Array,
    Booleans,
    SolveRecord,
    bar_of,
    checked_loads,
    flag,
    frozen,
    listed,
    shown,
    warns_of_odd_values,
)
from ..contact import ContactSystem, LoadCycle, joined
from ..errors import ModelError, SolverError
from ..solve.problem import Duals, Explained, put_back
from . import models
from .answered import Answered, answered
from .design_search import DesignSearch, NoneSafeError, Sets
from .models import Row, constant, defines, unknowns
from .open_nodes import TOUCHES
from .programs import Program, listed_rows, own_rows
from .question import Question, pose, with_open
from .safe_model import SafeModel, checked_objective, in_turn
from .shakedown import ShakedownLimit
from .shakedown_model import ShakedownModel

PROFILE = "profile"  # load case of the overlap that a profile leaves
_NAMED = 4  # unbounded parts of a design that an error names


def preload_reactions(system: ContactSystem, preloads: Sequence[str]) -> Array:
    """(M, J) reactions of unit amplitudes of the load cases that a design chooses, force; refused where they are rounding."""
    bolts = np.array([joined(*system.bonded[name]) for name in preloads]).reshape(
        len(preloads), len(system.S)
    )
    largest = max(np.abs(joined(*pair)).mean() for pair in system.bonded.values())
    for name, size in zip(preloads, np.abs(bolts).mean(axis=1), strict=True):
        if 0 < size < CONDENSATION * largest:
            raise ModelError(
                f"preloads: {name!r} makes reactions of {size:.1e}, no more than the rounding of others of up to {largest:.1e}; leave it out "
                "if it does nothing at the contact, else give the load case a larger unit, or others a smaller one"
            )
    return bolts.T


def built_in(
    system: ContactSystem,
    cycles: Sequence[tuple[LoadCycle, Mapping[str, float]]],
    profile: Array | None,
) -> tuple[ContactSystem, tuple[LoadCycle, ...]]:
    """Contact, and load cycles each with its preloads in its mean load, with a profile in the gap, or as an overlap where it adds material."""
    overlap = dict[str, float]()
    if profile is not None:
        gap = system.gap + profile
        system = system.with_gap(np.maximum(gap, 0.0))
        if gap.min() < 0:
            system = system.with_interference({PROFILE: np.maximum(-gap, 0.0)})
            overlap[PROFILE] = 1.0
    added = [
        (cycle, {name: cycle.mean.get(name, 0.0) + amount for name, amount in preload.items()})
        for cycle, preload in cycles
    ]
    return system, tuple(
        replace(cycle, mean={**cycle.mean, **preload, **overlap}) for cycle, preload in added
    )


def added(
    asked: Question,
    acting: Array,
    preload: cp.Variable | None,
    profile: cp.Variable | None,
    suffix: str = "",
) -> tuple[list[cp.Expression], list[Row]]:
    """What preloads of these reactions and a profile add to q, p, and to gaps and slips of open nodes; and rows that define it.

    `suffix`: appended to all names.
    """
    system, n, moved = asked.system, asked.system.nodes, asked.open_nodes.any()
    parts, rows = list[list[cp.Expression]](), list[Row]()
    for chosen, r, names in (
        (preload, acting, ("q_j", "p_j", "w_j", "v_j")),
        (profile, -system.S[:, -n:], ("-B.T", "-C", "-w", "-v")),
    ):
        if chosen is not None:
            left = asked.carried(r.T).reshape(r.shape[::-1]).T
            follow = -(asked.compliance @ r) if asked.compliance is not None else np.zeros_like(r)
            open_slip = follow[:-n][np.tile(asked.open_nodes, system.tangents)]
            matrices = (
                left[:-n],
                left[-n:],
                *((follow[-n:][asked.open_nodes], open_slip) if moved else ()),
            )
            terms = [
                constant(matrix, name + suffix) @ chosen
                for matrix, name in zip(matrices, names, strict=False)
            ]
            if chosen is profile:  # dense: equations of their own do not go through cvxpy
                unknown = [
                    cp.Variable(len(part), name=f"{name}_g{suffix}")
                    for part, name in zip(matrices, "qpwv", strict=False)
                ]
                rows += [
                    defines(part, product) for part, product in zip(unknown, terms, strict=True)
                ]
                terms = list(unknown)
            parts.append(terms)
    q, *others = (sum(each[1:], each[0]) for each in zip(*parts, strict=True))
    return [
        q if system.tangents == 1 else cp.reshape(q, system.slip_shape, order="F"),
        *others,
    ], rows


def refused(
    program: Program,
    entries: Mapping[cp.Variable | None, Iterable[object]],
    units: Mapping[cp.Variable, Any],
    chosen: bool,
) -> None:
    """Raise why there is no best design; None where that cannot be proven. `entries` are the names of those of each unknown of the design."""
    if none := program.chain.contradiction():
        ruling, own = program.ruling(none.ruling), {row.id for row in program.own.values()}
        safe = (
            "no design is safe at any load factor with all nodes closed"
            if none.ruling - own
            else "they contradict each other"
        )
        error = NoneSafeError if none.ruling - own else ModelError
        if not ruling:
            raise error(
                f"preloads: {safe}; press nodes that are open, or ask `shakedown_limit` of designs of your own"
            )
        raise error(f"{', '.join(ruling)}: {safe} under these constraints; drop or relax one")
    growth = program.chain.growth()
    if growth is None:
        return
    found = dict[str, float]()
    for variable, names in entries.items():
        if variable is not None:
            along = np.ravel(program.chain.value_along(growth, variable) / units[variable])
            found |= {
                f"{variable.name()}[{name!r}]": value
                for name, value in zip(names, along.tolist(), strict=True)
            }
    largest, goal = max(map(abs, found.values())), "objective" if chosen else "load_factor"
    if not largest > GROWN:
        raise ModelError(
            f"{goal}: it grows without end whatever the design; bound it by a constraint, or give another objective"
        )
    grows = {name: value for name, value in found.items() if abs(value) > GROWN * largest}
    named_parts = [
        f"{name} has no {'upper' if value > 0 else 'lower'} bound"
        for name, value in [*grows.items()][:_NAMED]
    ]
    more = f" and {len(grows) - _NAMED} more" if len(grows) > _NAMED else ""
    raise ModelError(
        f"{goal}: it grows without end with the design: {', '.join(named_parts)}{more}; bound them by constraints, or say what they cost"
    )


@dataclass(frozen=True, eq=False, repr=False)
class Design(Answered, Explained):
    """A best design, built into a contact that every other function takes: `system` and `cycle`.

    Its profile is in the initial gap of the system; where it adds material, in an overlap, the load
    case "profile". The largest load factor can be above one from which some starts slip for ever:
    ask `guaranteed_limit(design.system, design.cycle, friction)` too.

    Attributes
    ----------
    load_factor, objective
        The largest load factor that is safe with the design in all scenarios, their least shakedown
        limit, and None; or the load factor that an objective of your own chooses, which is no
        limit, and the largest value of the objective.
    bound
        Upper bound of the load factor (or objective) of all designs that the constraints admit with
        the same nodes open, not of others, from the multipliers alone. It equals the value up to
        `residual`, but where larger designs open other nodes and do not count (`reason`).
    preload
        Series: amplitude that the design adds to the mean load, for each load case that was free.
    profile
        (N,) material taken off at each node, length; negative: added. None where the faces were not
        free.
    slip, slips
        (N,) or (N, 2) a residual slip that is safe at the load factor, length; and one for each
        scenario, of which `slip` is the first.
    prices
        Name of each constraint of your own -> the rate, >= 0, at which the load factor (the
        objective) grows as the constraint gives way, in your units and its shape; of an equation
        the rate with its right side. Where the best design is not unique it is one of several.
    record
        How it was found. Its `residual`, at most 1e-9, is the largest of: the violations of the
        contact law by the slips at all corners with the design built in, the excess over your
        constraints, dimensionless, and the relative distance of `bound`.
    problem
        The solved cvxpy problem. A later solve of the same `DesignModel` overwrites its values.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"bolt": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    >>> model = fo.DesignModel(node, fo.LoadCycle({}, [{"Q": -1.0}, {"Q": 1.0}]), preloads=["bolt"])
    >>> design = model.solve(0.5, [(model.preload <= 4.0).set_label("strength")])
    >>> round(design.load_factor, 6), round(float(design.prices["strength"][0]), 6), dict(design.cycle.mean)
    (2.0, 0.5, {'bolt': 4.0})
    """

    objective: float | None
    bound: float
    preload: pd.Series
    profile: Array | None
    slips: tuple[Array, ...]
    prices: Mapping[str, Array]
    _questions: tuple[Question, ...]
    problem: cp.Problem | None = None
    _duals: Duals = ()
    _stops: bool = False  # before designs with more, under whose mean load other nodes open

    @property
    def value(self) -> float:
        """What is largest: the load factor, or the objective where there is one."""
        return self.load_factor if self.objective is None else self.objective

    @property
    def scenarios(self) -> tuple[tuple[LoadCycle, Array], ...]:
        """The pairs (load cycle, friction) of all scenarios, with the design built in (preloads in the mean load); the first one is `cycle`."""
        return tuple((question.cycle, question.friction) for question in self._questions)

    @property
    def opens(self) -> tuple[Booleans, ...]:
        """Which nodes are open at all corners, (N,) for each scenario; `open` is the first."""
        return tuple(question.open_nodes for question in self._questions)

    @property
    def touches(self) -> bool:
        """Whether a closed node may want to open: a corner leaves it without pressure, or the mean load alone would pull it open."""
        states = [
            (question, question.states(self.load_factor, slip)[1][:, -1])
            for question, slip in zip(self._questions, self.slips, strict=True)
        ]
        bare = (p.min(axis=0) <= TOUCHES * question.force for question, p in states)
        return any(
            ((no_pressure | (question.r0[:, -1].max(axis=0) < 0)) & ~question.open_nodes).any()
            for no_pressure, (question, _) in zip(bare, states, strict=True)
        )

    @property
    def reason(self) -> str:
        """Why no design is better, in words, and for which open nodes."""
        some = any(opened.any() for opened in self.opens)
        if self._stops:
            return f"{self._opened}larger designs are better{self._question.pattern}, but under their mean load others open: the search stops before them"
        return f"{self._opened}no design that the constraints admit is better{self._question.pattern}{'; with others open one may be' * some}"

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, its place, its slip, and the profile where there is one."""
        table = super().to_frame()
        return table if self.profile is None else table.assign(profile=self.profile)

    def _answer(self) -> Mapping[str, object]:
        chosen = () if self.objective is None else ("objective",)
        shown = {
            name: getattr(self, name)
            for name in ("load_factor", *chosen, "bound", "largest_slip", "residual")
        }
        shaped = (
            {}
            if self.profile is None
            else {"profile": f"{self.profile.min():.4g} .. {self.profile.max():.4g}"}
        )
        return {
            **shown,
            **{f"preload {name}": amount for name, amount in self.preload.items()},
            **shaped,
            "reason": self.reason,
        }

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return "best design", self.value, None, self.reason


def no_larger(
    preload: cp.Variable | None, profile: cp.Variable | None, share: float, of: Design
) -> list[Row]:
    """Rows by which no preload is larger than a share of the largest one of a design, and the profile no deeper."""
    rows = list[Row]()
    for part, size in ((preload, of.preload.to_numpy()), (profile, of.profile)):
        if part is not None and size is not None:
            rows.append(
                (cp.abs(part) <= share * float(np.abs(size).max())).set_label(f"size_{part.name()}")
            )
    return rows


_PRESSED = (
    10.0  # mean normal force of the preloads where the search begins, over that of the contact
)


class DesignModel(SafeModel):
    """Preloads, fit and profile of a contact as unknowns beside its residual slip, for constraints and objectives of your own.

    Reactions are linear in them, so the best design is the same convex program as the shakedown
    limit, with the same proof, for given open nodes. All are closed at first. If the best design
    leaves a node bare, or none is safe, design and pattern are sought in turn until the open nodes
    are those that `shakedown_limit` leaves open under the chosen loads; one that carries less there
    does not count. Theory, eq. (32).

    Parameters
    ----------
    system, cycle, slip_bound, solver
        See `ShakedownModel`.
    preloads
        Names of load cases whose amplitudes in the mean load are free: bolt forces, pressures,
        temperatures, interferences. The design adds to what the mean load of the cycle has of them.
    profile
        Whether material may be taken off the faces, a depth at each node.
    scenarios
        More pairs (load cycle, friction) under which the design has to hold, each with a residual
        slip of its own; all share the load factor. Or (load cycle, friction, shares): load case
        name -> share of its preload that acts, for bolts that scatter or loosen. While the same
        nodes are open, safe in all combinations of the least and the largest shares is safe in all
        between.

    Attributes
    ----------
    load_factor, slip, q, p
        As in `ShakedownModel`, with the design.
    preload
        (J,) amplitudes that the design adds to the mean load, in the order of `preloads`; None
        without.
    profile
        (N,) material taken off, length: it adds to the gap, so q loses `B^T g` and p loses `C g`.
        Negative: material added. None without.

    Raises
    ------
    ModelError
        Wrong types, unknown load cases, preloads that make no reactions but rounding, nothing to
        choose among, a scenario that is no pair.

    Examples
    --------
    Two bolts, each of which presses one of two nodes that the load shears: how tight, if they have
    3 in all?

    >>> import cvxpy as cp
    >>> import frictopt as fo
    >>> loads = {"one": ([0, 0], [1, 0]), "two": ([0, 0], [0, 1]), "Q": ([1, 0.5], [0, 0])}
    >>> system = fo.ContactSystem.from_blocks([[2, 0], [0, 2]], [[0, 0], [0, 0]], [[2, 0], [0, 2]], [0, 1], loads)
    >>> model = fo.DesignModel(system, fo.LoadCycle({}, [{"Q": -1.0}, {"Q": 1.0}]), preloads=["one", "two"])
    >>> design = model.solve(0.5, [cp.sum(model.preload) <= 3.0, model.preload >= 0])
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
        slip_bound: ArrayLike | None = None,
        solver: str | None = None,
    ) -> None:
        super().__init__(system, cycle, slip_bound=slip_bound, solver=solver)
        names, self._shaped = listed("preloads", preloads), flag("profile", profile)
        if unknown := [
            name for name in names if not (isinstance(name, str) and name in system.bonded)
        ]:
            raise ModelError(
                f"preloads: {shown(unknown[0])} is no load case; this system has {shown(list(system.bonded))}"
            )
        if len(set(names)) < len(names):
            raise ModelError(f"preloads: {shown(names)}; name each load case once")
        if self._shaped and PROFILE in system.bonded:
            raise ModelError(
                f"profile: the system has a load case {PROFILE!r}, which is the name of an overlap that a design adds; rename it"
            )
        self._preloads = tuple(names)
        self._others = [
            self._scenario(s, given) for s, given in enumerate(listed("scenarios", scenarios))
        ]
        if not (names or self._shaped):
            raise ModelError(
                "preloads, profile: none, so nothing is to be chosen; name load cases, or give profile=True"
            )
        self._reactions = preload_reactions(system, names)
        self.preload = cp.Variable(len(names), name="preload") if names else None
        self.profile = cp.Variable(system.nodes, name="profile") if self._shaped else None

    def _scenario(self, s: int, given: Any) -> tuple[Question, Mapping[str, float]]:
        if not isinstance(given, tuple) or len(given) not in (2, 3):
            raise ModelError(
                f"scenarios[{s}]: {shown(given)}; give (load cycle, friction), or these and the shares of the preloads"
            )
        cycle, friction, shares = given if len(given) == 3 else (*given, {})
        shares = checked_loads(f"scenarios[{s}]", shares)
        if unknown := sorted(set(shares) - set(self._preloads)):
            raise ModelError(
                f"scenarios[{s}]: shares of {shown(unknown)}; the preloads are {shown(list(self._preloads))}"
            )
        return pose(self._asked.system, cycle, friction, slip_bound=self._asked.slip_bound), shares

    @property
    def _unknowns(self) -> list[cp.Variable]:
        return [
            *super()._unknowns,
            *(part for part in (self.preload, self.profile) if part is not None),
        ]

    def _listed(
        self, question: Question, own: Sequence[cp.Constraint], opened: Sequence[Booleans]
    ) -> list[Program]:
        """The rows of the first scenario and of all others, each with its open nodes."""
        listed_all = list[Program]()
        for (posed, shares), out in zip(((question, {}), *self._others), opened, strict=True):
            asked = with_open(posed, out)
            assert asked is not None  # it has a limit
            first, suffix, x, f = not listed_all, "", self._x, self._f
            if not first:
                suffix = f"_{len(listed_all)}"
                x = unknowns(
                    asked.system.slip_shape, range(len(asked.r1)), self._x.load_factor, suffix
                )
                f = cp.Parameter(asked.system.nodes, nonneg=True, name=f"f{suffix}")
            acting = self._reactions * [shares.get(name, 1.0) for name in self._preloads]
            more, rows = added(asked, acting, self.preload, self.profile, suffix)
            program = listed_rows(
                asked, x, f, every=True, more=dict.fromkeys(range(len(asked.r1)), more[:3])
            )
            program.rows += rows
            if first:
                program.own = own_rows(own, self._unknowns)
                program.rows += self._rested(asked, more[3]) if own and out.any() else []
            listed_all.append(program)
        return listed_all

    @warns_of_odd_values
    @in_turn
    def solve(
        self,
        friction: ArrayLike,
        constraints: Sequence[cp.Constraint] = (),
        objective: cp.Expression | None = None,
        *,
        progress: bool = True,
    ) -> Design:
        """The design with the largest load factor, or the largest objective, under constraints of your own.

        Parameters
        ----------
        friction, constraints
            As in `ShakedownModel.solve`, constraints also on `preload` and `profile`. With the same
            nodes open more friction never lowers the load factor.
        objective
            What shall be largest, instead of the load factor: a concave cvxpy expression on the
            same.
        progress
            Whether to show after two seconds how far it is, see `shakedown_limit`. Ctrl-C stays a
            KeyboardInterrupt; once there is a design, its attribute `design` is the best one by
            then.

        Raises
        ------
        ModelError
            Bad friction; constraints that contradict each other, which are named; a design that
            grows without end, whose direction is named; constraints that are not convex, need other
            cones, or are on another model; such an objective.
        SolverError
            No solver gave an answer that passes the checks, or every design that was found opens
            other nodes under its mean load and carries less.

        Examples
        --------
        >>> import frictopt as fo
        >>> loads = {"bolt": ([0.0], [0.5]), "Q": ([1.0], [0.0])}
        >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
        >>> model = fo.DesignModel(node, fo.LoadCycle({}, [{"Q": -1.0}, {"Q": 1.0}]), preloads=["bolt"])
        >>> model.solve(0.5, [model.load_factor >= 2.0], objective=-model.preload[0]).preload.round(6).to_dict()  # the least bolt force
        {'bolt': 8.0}
        """
        question, own = self._posed(friction), listed("constraints", constraints)
        posed = [question, *(other for other, _ in self._others)]

        def told() -> str:
            what = "load factor" if objective is None else "objective"
            return f"{what} {search.best.design.value:.4g} so far" if search.best else ""

        def kept(_: object) -> tuple[str, object, str] | None:
            if search.best is None:
                return None
            return "design", search.best.design, "the best by then is in the attribute `design`"

        search = DesignSearch(partial(self._of_sets, question, own, objective), self._limits)
        with bar_of(progress, "design", "program", best=told, keeps=kept) as bar:
            search.tell = bar.update
            search.alternate([each.open_nodes for each in posed])
            if not search.found or search.found[0].design.touches:
                search.alternate(self._where_pressed(question, own))
            search.from_no_design([limit.open for limit in self._limits(posed)])
            best = search.best or search.refuse()
        design: Design = best.design
        put_back(best.values)  # others were solved after it
        for part, value in ((self.preload, design.preload), (self.profile, design.profile)):
            if part is not None:
                part.save_value(np.asarray(value))
        return self._shown(design)

    def _of_sets(
        self,
        question: Question,
        own: Sequence[cp.Constraint],
        objective: cp.Expression | None,
        opened: Sets,
        share: float = 1.0,
        of: Design | None = None,
    ) -> Design:
        """The best design with given nodes open in each scenario.

        `of`: no preload is larger than a share of the largest one of this design, and so is the
        profile.
        """
        (program, *_), chosen = (
            (every := self._listed(question, own, opened)),
            objective is not None,
        )
        problem = models.shakedown(self._x, [row for each in every for row in each.rows])
        if objective is not None:
            problem = cp.Problem(
                cp.Maximize(checked_objective(objective, self._unknowns)), problem.constraints
            )
        if of is not None:
            problem = cp.Problem(
                problem.objective,
                [*problem.constraints, *no_larger(self.preload, self.profile, share, of)],
            )
        program.compiled(
            problem, 1.0 if chosen else question.load_unit, self._units(every), every[1:]
        )
        entries = {self.preload: self._preloads, self.profile: range(question.system.nodes)}
        none = partial(refused, program, entries, self._units([program]), chosen)
        claim, record = program.chain.solve(
            lambda: self._judged(every, chosen), self._solver, no_optimum=none
        )
        return answered(claim, record, program)

    def _limits(self, questions: Sequence[Question]) -> list[ShakedownLimit]:
        """The limit of each scenario with a design built in, of the best pattern of open nodes; none where one has no answer."""
        closed = [
            with_open(question, np.zeros_like(question.open_nodes)) or question
            for question in questions
        ]
        with suppress(SolverError):
            return [
                ShakedownModel(
                    one.system, one.cycle, slip_bound=one.slip_bound, solver=self._solver
                ).of_any_set(one)
                for one in closed
            ]
        return []

    def _where_pressed(self, question: Question, own: Sequence[cp.Constraint]) -> Sets | None:
        """The patterns under preloads that press as much as the constraints admit, within many times the forces of the contact: another start."""
        more, rows = added(question, self._reactions, self.preload, self.profile)
        program = listed_rows(
            question,
            self._x,
            self._f,
            every=True,
            friction=lambda x, corners: [],
            more=dict.fromkeys(range(len(question.r1)), more[:3]),
        )
        program.own, n = own_rows(own, self._unknowns), question.system.nodes
        if self.preload is None:
            self.profile.save_value(np.zeros(n))
        else:
            pressing = self._reactions[-n:].sum(axis=0) @ self.preload
            problem = cp.Problem(
                cp.Maximize(pressing),
                [*program.rows, *rows, pressing <= _PRESSED * n * question.force],
            )
            program.compiled(problem, n * question.force, self._units([program]))
        with suppress(SolverError):
            if self.preload is not None:
                program.chain.solve(lambda: SolveRecord(residual=program.chain.violation))
            return [
                limit.open
                for limit in self._limits(
                    self._built([question, *(posed for posed, _ in self._others)])[2]
                )
            ]
        return None

    def _built(self, asked: Sequence[Question]) -> tuple[Array, Array | None, tuple[Question, ...]]:
        """Preloads and profile that stand in the unknowns, and each scenario with them built in."""
        preload = np.zeros(0) if self.preload is None else frozen(self.preload.value + 0.0)  # no -0
        profile = None if self.profile is None else frozen(self.profile.value + 0.0)
        amounts = dict(zip(self._preloads, preload.tolist(), strict=True))
        acting = [
            amounts,
            *(
                {name: a * shares.get(name, 1.0) for name, a in amounts.items()}
                for _, shares in self._others
            ),
        ]
        system, cycles = built_in(
            self._asked.system,
            [(one.cycle, loads) for one, loads in zip(asked, acting, strict=True)],
            profile,
        )
        posed = [
            pose(system, cycle, one.friction, slip_bound=self._asked.slip_bound)
            for cycle, one in zip(cycles, asked, strict=True)
        ]
        return (
            preload,
            profile,
            tuple(
                with_open(question, one.open_nodes) or question
                for question, one in zip(posed, asked, strict=True)
            ),
        )

    def _units(self, every: Sequence[Program]) -> dict[cp.Variable, Any]:
        """Units of the design, which make reactions of about the force of the contact at a node, and of the other scenarios."""
        question, units = every[0].question, dict[cp.Variable, Any]()
        if self.preload is not None:
            sizes = np.abs(self._reactions).mean(axis=0)
            units[self.preload] = question.force / np.where(sizes > 0, sizes, question.force)
        if self.profile is not None:
            units[self.profile] = (
                question.force / question.system.own_stiffness[-question.system.nodes :]
            )
        for program in every[1:]:
            units |= {
                variable: unit
                for variable, unit in program.units.items()
                if variable is not self.load_factor
            }
        return units

    def _judged(self, every: Sequence[Program], chosen: bool) -> Design:
        """Judge the design that stands in a program: built in, by the contact law in every scenario, and by the multipliers of all rows."""
        program = every[0]
        preload, profile, questions = self._built([one.question for one in every])
        slips = [
            frozen(question.slip_at_mean_load(one.slip))
            for question, one in zip(questions, every, strict=True)
        ]
        load_factor, proof = program.load_factor, program.chain.proof
        unsafe = max(
            question.violation(load_factor, slip)
            for question, slip in zip(questions, slips, strict=True)
        )
        residual = float(
            np.nan_to_num(np.max([unsafe, proof.gap, program.own_violation]), nan=np.inf)
        )
        return Design(
            load_factor=load_factor,
            objective=proof.value if chosen else None,
            bound=proof.bound + proof.defect,
            preload=pd.Series(
                preload, index=pd.Index(self._preloads, name="load", dtype=object), name="preload"
            ),
            profile=profile,
            slip=slips[0],
            slips=tuple(slips),
            _question=questions[0],
            prices=program.prices(),
            record=SolveRecord(residual=residual),
            _questions=questions,
        )
