"""A best design with its proof: preloads and profile, the slips that are safe with it, and what each constraint costs."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import IO

import cvxpy as cp
import pandas as pd

from ..contact import Array, LoadCycle, SolveRecord
from ..solve.explain import Units, explain
from .answered import Answered
from .question import LimitQuestion


@dataclass(frozen=True, eq=False, repr=False)
class Design(Answered):
    """A best design, built into a contact that every other function takes: `system` and `cycle`.

    Its profile is in the initial gap of the system; where it adds material, in an overlap, the load case "profile". The largest load factor can be
    above one from which some starts slip for ever: ask `guaranteed_limit(design.system, design.cycle, friction)` too.

    Attributes
    ----------
    load_factor
        The largest load factor that is safe with the design in all scenarios: their least shakedown limit; with an objective, the one that it
        chooses, no limit.
    objective
        Largest value of an objective of your own; None without.
    bound
        Upper bound of the load factor of all designs that the constraints admit (of their objective where there is one), from the multipliers alone.
        It equals the value up to `residual`.
    preload
        Series: amplitude that the design adds to the mean load, for each load case that was free.
    profile
        (N,) material taken off at each node, length; negative: added. None where the faces were not free.
    slip, slips
        (N,) or (N, 2) a residual slip that is safe at the load factor, length; and one for each scenario, of which `slip` is the first.
    prices
        Name of each constraint of your own -> the rate at which the load factor (the objective) grows as the constraint gives way, in your units and
        its shape: >= 0; of an equation the rate with its right side. Where the best design is not unique it is one of several.
    record
        How it was found. Its `residual` is the largest of: the violations of the contact law by the slips at all corners with the design built in,
        the excess over your constraints, dimensionless, and the relative distance of `bound`. At most 1e-9.
    problem
        The solved cvxpy problem; None in a copy. A later solve of the same `DesignModel` overwrites its values.

    Examples
    --------
    >>> import frictopt as fo
    >>> loads = {"bolt": ([0.0], [1.0]), "Q": ([1.0], [0.0])}
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], loads)
    >>> model = fo.DesignModel(node, fo.LoadCycle({}, [{"Q": -1.0}, {"Q": 1.0}]), preloads=["bolt"])
    >>> design = model.solve(0.5, [(model.preload <= 4.0).set_label("strength")])
    >>> round(design.load_factor, 6), round(float(design.prices["strength"][0]), 6)
    (2.0, 0.5)
    >>> dict(design.cycle.mean)
    {'bolt': 4.0}
    """

    load_factor: float
    objective: float | None
    bound: float
    preload: pd.Series
    profile: Array | None = field(repr=False)
    slip: Array = field(repr=False)
    slips: tuple[Array, ...] = field(repr=False)
    prices: Mapping[str, Array]
    record: SolveRecord
    _tasks: tuple[LimitQuestion, ...] = field(repr=False)
    problem: cp.Problem | None = field(repr=False, default=None)
    _units: Units = field(repr=False, default_factory=dict)

    @property
    def _task(self) -> LimitQuestion:  # type: ignore[override]
        return self._tasks[0]

    @property
    def cycle(self) -> LoadCycle:
        """The load cycle with the preloads in its mean load."""
        return self._task.cycle

    @property
    def scenarios(self) -> tuple[tuple[LoadCycle, Array], ...]:
        """The pairs (load cycle, friction) of all scenarios, with the design built in; the first one is `cycle` with its friction."""
        return tuple((task.cycle, task.friction) for task in self._tasks)

    def to_frame(self) -> pd.DataFrame:
        """One row for each node: node, its place, its slip, and the profile where there is one."""
        table = super().to_frame()
        return table if self.profile is None else table.assign(profile=self.profile)

    def _answer(self) -> Mapping[str, object]:
        chosen = () if self.objective is None else ("objective",)
        shown = {name: getattr(self, name) for name in ("load_factor", *chosen, "bound", "largest_slip", "residual")}
        shaped = {} if self.profile is None else {"profile": f"{self.profile.min():.4g} .. {self.profile.max():.4g}"}
        return {**shown, **{f"preload {name}": amount for name, amount in self.preload.items()}, **shaped}

    def explain(self, file: IO[str] | None = None) -> None:
        """Print the model by its names: sizes, curvature, DPP, units, what was left out, and the rows that bind."""
        value = self.load_factor if self.objective is None else self.objective
        explain("best design", self.problem, value, self._units, self.record.left_out, None, file)
