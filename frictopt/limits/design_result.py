"""What a design adds to a state of rest, why there is none that is best; and a best design with its proof: safe slips, and prices of constraints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import cvxpy as cp
import numpy as np
import pandas as pd

from ..contact import CONDENSATION, GROWN, Array, Booleans, ContactSystem, LoadCycle, joined
from ..errors import ModelError
from ..solve.problem import Duals, Explained
from .answered import Answered
from .models import Row, defines, named
from .open_nodes import TOUCHES
from .programs import Program
from .question import Question

PROFILE = "profile"  # load case of the overlap that a profile leaves
_NAMED = 4  # unbounded parts of a design that an error names


def preload_reactions(system: ContactSystem, preloads: Sequence[str]) -> Array:
    """(M, J) reactions of unit amplitudes of the load cases that a design chooses, force; refused where they are rounding."""
    bolts = np.array([joined(*system.bonded[name]) for name in preloads]).reshape(len(preloads), len(system.S))
    largest = max(np.abs(joined(*pair)).mean() for pair in system.bonded.values())
    for name, size in zip(preloads, np.abs(bolts).mean(axis=1), strict=True):
        if 0 < size < CONDENSATION * largest:
            raise ModelError(
                f"preloads: {name!r} makes reactions of {size:.1e}, no more than the rounding of others of up to {largest:.1e}; leave it out "
                "if it does nothing at the contact, else give the load case a larger unit, or others a smaller one"
            )
    return bolts.T


def built_in(
    system: ContactSystem, cycles: Sequence[tuple[LoadCycle, Mapping[str, float]]], profile: Array | None
) -> tuple[ContactSystem, tuple[LoadCycle, ...]]:
    """Contact, and load cycles each with its preloads in its mean load, with a profile in the gap, or as an overlap where it adds material."""
    overlap = dict[str, float]()
    if profile is not None:
        gap = system.gap + profile
        system = system.with_gap(np.maximum(gap, 0.0))
        if gap.min() < 0:
            system = system.with_interference({PROFILE: np.maximum(-gap, 0.0)})
            overlap[PROFILE] = 1.0
    added = [(cycle, {name: cycle.mean.get(name, 0.0) + amount for name, amount in preload.items()}) for cycle, preload in cycles]
    return system, tuple(replace(cycle, mean={**cycle.mean, **preload, **overlap}) for cycle, preload in added)


class NoneSafeError(ModelError):
    """No design is safe with given nodes open; with others one may be."""


def added(
    asked: Question, acting: Array, preload: cp.Variable | None, profile: cp.Variable | None, suffix: str = ""
) -> tuple[list[cp.Expression], list[Row]]:
    """What preloads of these reactions and a profile add to q, p, and to gaps and slips of open nodes; and rows that define it.

    `suffix`: appended to all names.
    """
    system, n, moved = asked.system, asked.system.nodes, asked.open.any()
    parts, rows = list[list[cp.Expression]](), list[Row]()
    for chosen, r, names in ((preload, acting, ("q_j", "p_j", "w_j", "v_j")), (profile, -system.S[:, -n:], ("-B.T", "-C", "-w", "-v"))):
        if chosen is not None:
            left = asked.carried(r.T).reshape(r.shape[::-1]).T
            follow = -(asked.give @ r) if asked.give is not None else np.zeros_like(r)
            open_slip = follow[:-n][np.tile(asked.open, system.tangents)]
            matrices = (left[:-n], left[-n:], *((follow[-n:][asked.open], open_slip) if moved else ()))
            terms = [named(matrix, name + suffix) @ chosen for matrix, name in zip(matrices, names, strict=False)]
            if chosen is profile:  # dense: equations of their own do not go through cvxpy
                unknown = [cp.Variable(len(part), name=f"{name}_g{suffix}") for part, name in zip(matrices, "qpwv", strict=False)]
                rows += [defines(part, product) for part, product in zip(unknown, terms, strict=True)]
                terms = list(unknown)
            parts.append(terms)
    q, *others = (sum(each[1:], each[0]) for each in zip(*parts, strict=True))
    return [q if system.tangents == 1 else cp.reshape(q, system.slip_shape, order="F"), *others], rows


def refused(program: Program, entries: Mapping[cp.Variable | None, Iterable[object]], units: Mapping[cp.Variable, Any], chosen: bool) -> None:
    """Raise why there is no best design; None where that cannot be proven. `entries` are the names of those of each unknown of the design."""
    if none := program.chain.contradiction():
        ruling, own = program.ruling(none.ruling), {row.id for row in program.own.values()}
        safe = "no design is safe at any load factor with all nodes closed" if none.ruling - own else "they contradict each other"
        error = NoneSafeError if none.ruling - own else ModelError
        if not ruling:
            raise error(f"preloads: {safe}; press nodes that are open, or ask `shakedown_limit` of designs of your own")
        raise error(f"{', '.join(ruling)}: {safe} under these constraints; drop or relax one")
    growth = program.chain.growth()
    if growth is None:
        return
    found = dict[str, float]()
    for variable, names in entries.items():
        if variable is not None:
            along = np.ravel(program.chain.value_along(growth, variable) / units[variable])
            found |= {f"{variable.name()}[{name!r}]": value for name, value in zip(names, along.tolist(), strict=True)}
    largest, goal = max(map(abs, found.values())), "objective" if chosen else "load_factor"
    if not largest > GROWN:
        raise ModelError(f"{goal}: it grows without end whatever the design; bound it by a constraint, or give another objective")
    grows = {name: value for name, value in found.items() if abs(value) > GROWN * largest}
    named_parts = [f"{name} has no {'upper' if value > 0 else 'lower'} bound" for name, value in [*grows.items()][:_NAMED]]
    more = f" and {len(grows) - _NAMED} more" if len(grows) > _NAMED else ""
    raise ModelError(
        f"{goal}: it grows without end with the design: {', '.join(named_parts)}{more}; bound them by constraints, or say what they cost"
    )


@dataclass(frozen=True, eq=False, repr=False)
class Design(Answered, Explained):
    """A best design, built into a contact that every other function takes: `system` and `cycle`.

    Its profile is in the initial gap of the system; where it adds material, in an overlap, the load case "profile". The largest load factor can be
    above one from which some starts slip for ever: ask `guaranteed_limit(design.system, design.cycle, friction)` too.

    Attributes
    ----------
    load_factor, objective
        The largest load factor that is safe with the design in all scenarios, their least shakedown limit, and None; or the load factor that an
        objective of your own chooses, which is no limit, and the largest value of the objective.
    bound
        Upper bound of the load factor (or objective) of all designs that the constraints admit with the same nodes open, not of others, from the
        multipliers alone. It equals the value up to `residual`, but where larger designs open other nodes and do not count (`reason`).
    preload
        Series: amplitude that the design adds to the mean load, for each load case that was free.
    profile
        (N,) material taken off at each node, length; negative: added. None where the faces were not free.
    slip, slips
        (N,) or (N, 2) a residual slip that is safe at the load factor, length; and one for each scenario, of which `slip` is the first.
    prices
        Name of each constraint of your own -> the rate, >= 0, at which the load factor (the objective) grows as the constraint gives way, in your
        units and its shape; of an equation the rate with its right side. Where the best design is not unique it is one of several.
    record
        How it was found. Its `residual`, at most 1e-9, is the largest of: the violations of the contact law by the slips at all corners with the
        design built in, the excess over your constraints, dimensionless, and the relative distance of `bound`.
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
    _tasks: tuple[Question, ...]
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
        return tuple((task.cycle, task.friction) for task in self._tasks)

    @property
    def opens(self) -> tuple[Booleans, ...]:
        """Which nodes are open at all corners, (N,) for each scenario; `open` is the first."""
        return tuple(task.open for task in self._tasks)

    @property
    def touches(self) -> bool:
        """Whether a closed node may want to open: a corner leaves it without pressure, or the mean load alone would pull it open."""
        states = [(task, task.states(self.load_factor, slip)[1][:, -1]) for task, slip in zip(self._tasks, self.slips, strict=True)]
        bare = (p.min(axis=0) <= TOUCHES * task.force for task, p in states)
        return any(((no_pressure | (task.r0[:, -1].max(axis=0) < 0)) & ~task.open).any() for no_pressure, (task, _) in zip(bare, states, strict=True))

    @property
    def reason(self) -> str:
        """Why no design is better, in words, and for which open nodes."""
        some = any(opened.any() for opened in self.opens)
        if self._stops:
            return f"{self._opened}larger designs are better{self._task.pattern}, but under their mean load others open: the search stops before them"
        return f"{self._opened}no design that the constraints admit is better{self._task.pattern}{'; with others open one may be' * some}"

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, its place, its slip, and the profile where there is one."""
        table = super().to_frame()
        return table if self.profile is None else table.assign(profile=self.profile)

    def _answer(self) -> Mapping[str, object]:
        chosen = () if self.objective is None else ("objective",)
        shown = {name: getattr(self, name) for name in ("load_factor", *chosen, "bound", "largest_slip", "residual")}
        shaped = {} if self.profile is None else {"profile": f"{self.profile.min():.4g} .. {self.profile.max():.4g}"}
        return {**shown, **{f"preload {name}": amount for name, amount in self.preload.items()}, **shaped, "reason": self.reason}

    def _told(self) -> tuple[str, float | None, pd.DataFrame | None, str]:
        return "best design", self.value, None, self.reason


def no_larger(preload: cp.Variable | None, profile: cp.Variable | None, share: float, of: Design) -> list[Row]:
    """Rows by which no preload is larger than a share of the largest one of a design, and the profile no deeper."""
    rows = list[Row]()
    for part, size in ((preload, of.preload.to_numpy()), (profile, of.profile)):
        if part is not None and size is not None:
            rows.append((cp.abs(part) <= share * float(np.abs(size).max())).set_label(f"size_{part.name()}"))
    return rows
