"""Every contact is solved in two equivalent descriptions.

The exact path is also compared with the work between its states, and with increments from each
state to the next.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

import frictopt as fo
from studies.validation import oracles
from studies.validation.fuzz.cases import Case
from studies.validation.fuzz.checks import Finding, findings_of
from studies.validation.fuzz.known import NotApplicable, Subject, Wrong, same

SAME = 1e-9
"""Largest difference of two equal answers, relative to the force, length or work of the contact.

It equals the residual that an answer may have.
"""

# A cycle that returns within 1e-10 slip scales may still be this many times farther from its limit.
_SETTLING = 100.0
# Largest number of cycles to a steady state.
_MOST = 100
# Largest number of cycles of a path.
_MOST_MARCHED = 60
# Largest number of nodes for which increments are computed, each by a program.
_FEW = 6


@dataclass(frozen=True)
class Description:
    """An equivalent description of a contact.

    Attributes
    ----------
    system, cycle, friction, start
        The contact as described; the load factor is a pure number and stays the same.
    order
        (N,) the node of the contact at each place of the description.
    sense
        -1 if the contact is seen from behind, else 1.
    force, length
        A force in the description divided by the same force in the contact, and the same for a
        length.
    """

    system: fo.ContactSystem
    cycle: fo.LoadCycle
    friction: Any
    start: Any
    order: Any
    sense: float = 1.0
    force: float = 1.0
    length: float = 1.0

    def back(self, values: Any) -> Any:
        """Values by node of the contact (N,), from values by place of the description."""
        result = np.empty(len(self.order))
        result[self.order] = values
        return result


def described(
    case: Case,
    order: Any = None,
    sense: float = 1.0,
    force: float = 1.0,
    length: float = 1.0,
    cases: dict[str, float] | None = None,
) -> Description:
    """The case in another description.

    The nodes may have another order, the contact may be seen from behind, force and length may have
    other units, and `cases` gives each load case a unit.
    """
    system = case.system
    order = np.arange(system.nodes) if order is None else np.asarray(order)
    described_system = oracles.redescribed(system, order, sense, force, length, cases)
    unit = dict.fromkeys(system.bonded, 1.0) | (cases or {})
    mean, *corners = (
        {name: amplitude * unit[name] for name, amplitude in loads.items()}
        for loads in (case.cycle.mean, *case.cycle.corners)
    )
    cycle = fo.LoadCycle(mean, corners)
    start = None if case.start is None else sense * case.start[order] * length
    return Description(
        described_system, cycle, case.friction[order], start, order, sense, force, length
    )


class Scene(Subject):
    """A case with the answers that several questions need."""

    def __init__(self, case: Case) -> None:
        super().__init__(case)
        self.n = case.system.nodes
        self.rng = np.random.default_rng(case.seed)

    @cached_property
    def steady(self) -> fo.results.SteadyState:
        """The steady state from the start of the case."""
        return fo.steady_state(
            *self.args, self.load_factor, initial_slip=self.case.start, most_cycles=_MOST
        )

    @cached_property
    def marched(self) -> fo.results.Trajectory:
        """The path, for some cycles more than the steady state needed."""
        cycles = min(self.steady.cycles + (10 if self.steady.extrapolated else 2), _MOST_MARCHED)
        return fo.march(*self.args, self.load_factor, initial_slip=self.case.start, cycles=cycles)

    @cached_property
    def force(self) -> float:
        """Largest mean nodal force of the loads."""
        q0, p0 = self.case.cycle.mean_reaction(self.case.system)
        q, p = (
            self.load_factor * part for part in self.case.cycle.corner_reactions(self.case.system)
        )
        largest_shear = np.abs(q0 + q).max()
        largest_normal = np.abs(p0 + p).max()
        return float(max(np.abs(p0).mean(), largest_shear, largest_normal))

    @cached_property
    def length(self) -> float:
        """The larger of two slips: the slip that this force makes, and the start."""
        start = 0.0 if self.case.start is None else float(np.abs(self.case.start).max())
        return max(self.force / self.case.system.stiffness_scale, start)

    def near(
        self, name: str, values: Any, expected: Any, unit: float, tolerance: float = SAME
    ) -> None:
        """Raise Wrong if two numbers, or arrays, differ by more than `tolerance` units."""
        error = np.abs(np.asarray(values) - expected)
        if not float(error.max(initial=0.0)) <= tolerance * unit:
            entry = int(error.argmax())
            raise Wrong(
                f"{name} {np.ravel(values)[entry]!r}, expected {np.ravel(expected)[entry]!r} "
                f"(entry {entry}; off by {error.max() / unit:.1e}; {self.case.family}, {self.n} "
                f"nodes, load factor {self.load_factor!r})"
            )


def _limit(scene: Scene) -> tuple[float, bool]:
    """Compare the shakedown limit with the limit without simplification, for one case in four."""
    if scene.case.seed % 4:
        raise NotApplicable
    unsimplified = fo.shakedown_limit(*scene.args, simplify=False)
    limit = scene.answered_limit
    same("shakedown limit", limit.load_factor, unsimplified.load_factor, 1e-8, 1e-10)
    return unsimplified.residual, True


def _compare(scene: Scene, description: Description) -> tuple[float, bool]:
    """Compare the steady states of both descriptions: outcome, work of friction, and slip."""
    expected = scene.steady
    steady = fo.steady_state(
        description.system,
        description.cycle,
        description.friction,
        scene.load_factor,
        initial_slip=description.start,
        most_cycles=_MOST,
    )
    residual = max(expected.residual, steady.residual)
    # If a steady state is unproven, the rates may not be unique: either result may be right.
    if expected.unproven or steady.unproven:
        return residual, False
    unit = scene.force * scene.length
    work_unit = description.force * description.length
    settled = _SETTLING * SAME
    first_cycle = steady.first_cycle / work_unit
    work = steady.dissipation / work_unit
    work_per_node = description.back(steady.dissipation_per_node) / work_unit
    scene.near("work of the first cycle", first_cycle, expected.first_cycle, unit, SAME * scene.n)
    scene.near("work of a cycle", work, expected.dissipation, unit, settled)
    scene.near("work of a node", work_per_node, expected.dissipation_per_node, unit, settled)
    # If the work is close to zero, rounding decides between shakedown and slip.
    dissipates = max(expected.dissipation, work) > settled * unit
    if steady.outcome is not expected.outcome and dissipates:
        raise Wrong(f"{steady.outcome.name}, expected {expected.outcome.name}")
    stiffness = scene.case.system.A
    slip = description.sense * description.back(steady.slip) / description.length
    scene.near(
        "shear of the slip",
        stiffness @ slip,
        stiffness @ expected.slip,
        scene.case.system.stiffness_scale * scene.length,
        settled,
    )
    return residual, True


def _mirrored(scene: Scene) -> tuple[float, bool]:
    """Compare with the contact seen from behind."""
    return _compare(scene, described(scene.case, np.arange(scene.n)[::-1], sense=-1.0))


def _renumbered(scene: Scene) -> tuple[float, bool]:
    """Compare with the contact with its nodes in a random order."""
    return _compare(scene, described(scene.case, scene.rng.permutation(scene.n)))


def _other_units(scene: Scene) -> tuple[float, bool]:
    """Compare with the contact in other units of force and length.

    Each load case has a unit, too, from nano to giga.
    """
    force, length = 10.0 ** scene.rng.uniform(-9, 9, 2)
    names = list(scene.case.system.bonded)
    units = 10.0 ** scene.rng.choice([-9, -6, -3, 0, 3, 6, 9], len(names))
    unit_of_case = dict(zip(names, units, strict=True))
    return _compare(scene, described(scene.case, force=force, length=length, cases=unit_of_case))


def _path(scene: Scene) -> tuple[float, bool]:
    """Compare the work along the path with the forces and slips of its states.

    Between two states everything is linear, so the work of friction of a node is -q dv with the
    mean of both q. The work of the loads must be the work of friction plus the change of stored
    energy.
    """
    path = scene.marched
    mean_shear = (path.q[1:] + path.q[:-1]) / 2
    work = -(mean_shear * np.diff(path.slip, axis=0))
    unit = scene.force * scene.length
    states = len(path.q)
    scene.near(
        "work of friction so far",
        path.work - path.work[0],
        np.vstack([0 * work[:1], np.cumsum(work, axis=0)]),
        unit,
        SAME * states,
    )
    scene.near("energy that is not accounted for", path.energy_error, 0.0, unit, SAME * states)
    scene.near(
        "work that friction gives back", np.minimum(np.diff(path.work, axis=0), 0.0), 0.0, unit
    )
    return path.residual, True


def _marched(scene: Scene) -> tuple[float, bool]:
    """Compare the steady state with the path, followed for as many cycles.

    If the steady state is extrapolated, the work of the path may still change.
    """
    steady = scene.steady
    works = scene.marched.cycle_work
    unit = scene.force * scene.length
    if steady.cycles > 1:
        first = float(works[0].sum())
        scene.near("work of the first cycle", steady.first_cycle, first, unit, SAME * scene.n)
    if len(works) < steady.cycles + 2:
        return steady.residual, False
    changes = 0.0
    if steady.extrapolated:
        changes = 10 * float(np.abs(works[-1] - works[-3]).max()) / unit
    scene.near(
        "work of a node", steady.dissipation_per_node, works[-1], unit, _SETTLING * SAME + changes
    )
    return steady.residual, changes < 1e-6


def _increments(scene: Scene) -> tuple[float, bool]:
    """Compare each state of the path with one increment from the state before.

    Only contacts of few nodes are compared, and of these one case in eight.
    """
    if scene.n > _FEW or scene.case.seed % 8:
        raise NotApplicable
    system = scene.case.system
    path = fo.march(*scene.args, scene.load_factor, initial_slip=scene.case.start, cycles=1)
    first = int(np.searchsorted(path.time, 0.0, side="right")) - 1
    # A transient that starts from slip alone does not reach a state with open nodes.
    if path.gap[first].any():
        raise NotApplicable
    loads = {
        f"load {k}": (path.bonded_q[k], path.bonded_p[k]) for k in range(first, len(path.time))
    }
    names = list(loads)
    system_with_loads = replace(system, bonded=loads, compliance=None, load_size={})
    cycle = fo.LoadCycle({names[0]: 1.0}, [{name: 1.0, names[0]: -1.0} for name in names[1:]])
    stepped = fo.march(
        system_with_loads,
        cycle,
        scene.case.friction,
        1.0,
        initial_slip=path.slip[first],
        cycles=1,
        steps=1,
    )
    for name in ("q", "p"):
        scene.near(
            f"{name} in increments",
            getattr(stepped, name),
            getattr(path, name)[first:],
            scene.force,
            1e3 * SAME,
        )
    # An increment does not resolve when a node opens, so only nodes that stay closed are compared.
    closed = (path.p[first:] > 1e-6 * scene.force).all(axis=0)
    work = (path.work[-1] - path.work[first])[closed]
    scene.near(
        "work in increments",
        (stepped.work[-1] - stepped.work[0])[closed],
        work,
        scene.force * scene.length,
        1e3 * SAME,
    )
    return stepped.residual, True


DIFFERENTIAL: dict[str, Callable[[Scene], tuple[float, bool]]] = {
    "limit, nothing left out": _limit,
    "mirrored": _mirrored,
    "renumbered": _renumbered,
    "other units": _other_units,
    "work along the path": _path,
    "steady state, marched": _marched,
    "path, in increments": _increments,
}
"""Question -> function that solves both descriptions.

The function returns the residual, and whether the two answers could be compared.
"""


def differences(case: Case) -> Iterator[Finding]:
    """Findings of all questions about a case in both descriptions."""
    return findings_of(DIFFERENTIAL, Scene(case), case.seed)
