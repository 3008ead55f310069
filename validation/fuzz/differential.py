"""Every contact solved in two equivalent descriptions, and the exact path compared with the work and the increments of its own states."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

import frictopt as fo
from validation import oracles
from validation.fuzz.cases import Case
from validation.fuzz.checks import Finding, asked
from validation.fuzz.known import Asked, NotAsked, Wrong, same

SAME = 1e-9
"""Difference between two answers, over the force, length and work of the contact, that counts as none: the residual that an answer may have."""

# a cycle that returns within 1e-10 slip scales may still be so many times farther from its limit
_SETTLING = 100.0
_MOST = 100  # most cycles to a steady state
_MOST_MARCHED = 60
_FEW = 6  # nodes up to which increments are computed, each by its own program


@dataclass(frozen=True)
class Seen:
    """An equivalent description of a contact.

    Attributes
    ----------
    system, cycle, friction, start
        The contact as described; the load factor is a pure number and stays.
    order
        (N,) which node of the contact stands at each place.
    sense
        -1 where seen from behind, else 1.
    force, length
        Units: numbers as described, over those of the contact.
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
        """(N,) values by place as values by node."""
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
) -> Seen:
    """The case with its nodes in another order, seen from behind, in other units, or with a unit of its own for each load case."""
    system, n = case.system, case.system.nodes
    order = np.arange(n) if order is None else np.asarray(order)
    again, unit = (
        oracles.redescribed(system, order, sense, force, length, cases),
        dict.fromkeys(system.bonded, 1.0) | (cases or {}),
    )
    mean, *corners = (
        {name: amplitude * unit[name] for name, amplitude in loads.items()}
        for loads in (case.cycle.mean, *case.cycle.corners)
    )
    start = None if case.start is None else sense * case.start[order] * length
    return Seen(
        again, fo.LoadCycle(mean, corners), case.friction[order], start, order, sense, force, length
    )


class Scene(Asked):
    """A case with the answers that several questions need."""

    def __init__(self, case: Case) -> None:
        super().__init__(case)
        self.n, self.rng = case.system.nodes, np.random.default_rng(case.seed)

    @cached_property
    def steady(self) -> fo.results.SteadyState:
        """The steady state, with everything left out that can be."""
        return fo.steady_state(
            *self.args, self.load_factor, initial_slip=self.case.start, most_cycles=_MOST
        )

    @cached_property
    def marched(self) -> fo.results.Trajectory:
        """The path, for some cycles more than the steady state took."""
        cycles = min(self.steady.cycles + (10 if self.steady.extrapolated else 2), _MOST_MARCHED)
        return fo.march(*self.args, self.load_factor, initial_slip=self.case.start, cycles=cycles)

    @cached_property
    def force(self) -> float:
        """Largest mean nodal force of the loads."""
        q0, p0 = self.case.cycle.mean_reaction(self.case.system)
        q, p = (
            self.load_factor * part for part in self.case.cycle.corner_reactions(self.case.system)
        )
        return float(
            max(np.abs(p0).mean(), *np.abs(q0 + q).max(axis=1), *np.abs(p0 + p).max(axis=1))
        )

    @cached_property
    def length(self) -> float:
        """Slip that this force makes, or the start if that is larger."""
        start = 0.0 if self.case.start is None else float(np.abs(self.case.start).max())
        return max(self.force / self.case.system.stiffness_scale, start)

    def near(
        self, what: str, found: Any, expected: Any, unit: float, tolerance: float = SAME
    ) -> None:
        """Raise Wrong where two numbers, or arrays, differ by more than `tolerance` units."""
        off = np.abs(np.asarray(found) - expected)
        if not float(off.max(initial=0.0)) <= tolerance * unit:
            node = int(off.argmax())
            raise Wrong(
                f"{what} {np.ravel(found)[node]!r}, expected {np.ravel(expected)[node]!r} (entry "
                f"{node}; off by {off.max() / unit:.1e}; {self.case.family}, {self.n} nodes, load "
                f"factor {self.load_factor!r})"
            )


def _limit(scene: Scene) -> tuple[float, bool]:
    """The shakedown limit with nothing left out; a part of the cases."""
    if scene.case.seed % 4:
        raise NotAsked
    kept = fo.shakedown_limit(*scene.args, simplify=False)
    same("shakedown limit", scene.answered_limit.load_factor, kept.load_factor, 1e-8, 1e-10)
    return kept.residual, True


def _again(scene: Scene, seen: Seen) -> tuple[float, bool]:
    """The steady state of the contact as described: outcome, work of friction, by node and in the first cycle, and slip."""
    steady = scene.steady
    options = {"initial_slip": seen.start, "most_cycles": _MOST}
    other = fo.steady_state(seen.system, seen.cycle, seen.friction, scene.load_factor, **options)
    residual = max(steady.residual, other.residual)
    if steady.unproven or other.unproven:  # the rates may not be unique: either result may be right
        return residual, False
    unit = scene.force * scene.length
    work = seen.force * seen.length
    scene.near(
        "work of the first cycle",
        other.first_cycle / work,
        steady.first_cycle,
        unit,
        SAME * scene.n,
    )
    scene.near(
        "work of a cycle", other.dissipation / work, steady.dissipation, unit, _SETTLING * SAME
    )
    scene.near(
        "work of a node",
        seen.back(other.dissipation_per_node) / work,
        steady.dissipation_per_node,
        unit,
        _SETTLING * SAME,
    )
    if (
        other.outcome is not steady.outcome
        and max(steady.dissipation, other.dissipation / work) > _SETTLING * SAME * unit
    ):
        raise Wrong(f"{other.outcome.name}, expected {steady.outcome.name}")
    stiffness = scene.case.system.A
    slip = seen.sense * seen.back(other.slip) / seen.length
    scene.near(
        "shear of the slip",
        stiffness @ slip,
        stiffness @ steady.slip,
        scene.case.system.stiffness_scale * scene.length,
        _SETTLING * SAME,
    )
    return residual, True


def _other_units(scene: Scene) -> tuple[float, bool]:
    """In other units of force and length, and each load case in a unit of its own, from nano to giga."""
    force, length = 10.0 ** scene.rng.uniform(-9, 9, 2)
    names = list(scene.case.system.bonded)
    own = dict(
        zip(names, 10.0 ** scene.rng.choice([-9, -6, -3, 0, 3, 6, 9], len(names)), strict=True)
    )
    return _again(scene, described(scene.case, force=force, length=length, cases=own))


def _path(scene: Scene) -> tuple[float, bool]:
    """The path against its own states, between which all is linear: work of friction is -q dv at each node, and of all loads what is not stored."""
    path = scene.marched
    q, v = path.q, path.slip
    own = -((q[1:] + q[:-1]) / 2 * np.diff(v, axis=0))
    unit, states = scene.force * scene.length, len(q)
    scene.near(
        "work of friction so far",
        path.work - path.work[0],
        np.vstack([0 * own[:1], np.cumsum(own, axis=0)]),
        unit,
        SAME * states,
    )
    scene.near("energy that is not accounted for", path.energy_error, 0.0, unit, SAME * states)
    scene.near(
        "work that friction gives back", np.minimum(np.diff(path.work, axis=0), 0.0), 0.0, unit
    )
    return path.residual, True


def _marched(scene: Scene) -> tuple[float, bool]:
    """The steady state against the path, followed for as many cycles; of slow ones, as far as their work still changes."""
    steady, works = scene.steady, scene.marched.cycle_work
    unit = scene.force * scene.length
    scene.near(
        "work of the first cycle", steady.first_cycle, float(works[0].sum()), unit, SAME * scene.n
    ) if steady.cycles > 1 else None
    if len(works) < steady.cycles + 2:
        return steady.residual, False
    changes = 10 * float(np.abs(works[-1] - works[-3]).max()) / unit if steady.extrapolated else 0.0
    scene.near(
        "work of a node", steady.dissipation_per_node, works[-1], unit, _SETTLING * SAME + changes
    )
    return steady.residual, changes < 1e-6


def _increments(scene: Scene) -> tuple[float, bool]:
    """The path's own states reached in one increment from each to the next, by quadratic programs; few nodes, and a part of the cases."""
    if scene.n > _FEW or scene.case.seed % 8:
        raise NotAsked
    system = scene.case.system
    path = fo.march(*scene.args, scene.load_factor, initial_slip=scene.case.start, cycles=1)
    landed = int(np.searchsorted(path.time, 0.0, side="right")) - 1
    if path.gap[landed].any():  # another transient reaches this state not by slip alone
        raise NotAsked
    loads = {
        f"load {k}": (path.bonded_q[k], path.bonded_p[k]) for k in range(landed, len(path.time))
    }
    names = list(loads)
    again = replace(system, bonded=loads, compliance=None, load_size={})
    cycle = fo.LoadCycle({names[0]: 1.0}, [{name: 1.0, names[0]: -1.0} for name in names[1:]])
    stepped = fo.march(
        again,
        cycle,
        scene.case.friction,
        1.0,
        initial_slip=path.slip[landed],
        cycles=1,
        engine="qp",
        steps=1,
    )
    for name in ("q", "p"):
        scene.near(
            f"{name} in increments",
            getattr(stepped, name)[1:],
            getattr(path, name)[landed:],
            scene.force,
            1e3 * SAME,
        )
    shut = (path.p[landed:] > 1e-6 * scene.force).all(
        axis=0
    )  # an increment does not resolve when a node opens
    work = (path.work[-1] - path.work[landed])[shut]
    scene.near(
        "work in increments", stepped.work[-1][shut], work, scene.force * scene.length, 1e3 * SAME
    )
    return stepped.residual, True


DIFFERENTIAL: dict[str, Callable[[Scene], tuple[float, bool]]] = {
    "limit, nothing left out": _limit,
    "mirrored": lambda scene: _again(
        scene, described(scene.case, np.arange(scene.n)[::-1], sense=-1.0)
    ),
    "renumbered": lambda scene: _again(
        scene, described(scene.case, scene.rng.permutation(scene.n))
    ),
    "other units": _other_units,
    "work along the path": _path,
    "steady state, marched": _marched,
    "path, in increments": _increments,
}
"""Question -> function that solves both descriptions: residual, and whether the two could be compared."""


def differences(case: Case) -> Iterator[Finding]:
    """Ask every question of a case in both descriptions."""
    return asked(DIFFERENTIAL, Scene(case), case.seed)
