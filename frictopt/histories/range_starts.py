"""Starts from which the search for the range of dissipation begins: extreme slips that the contact can hold under the loads of the cycle."""

from collections.abc import Mapping
from contextlib import suppress
from functools import cached_property

import numpy as np

from ..contact import RESIDUAL, ROUNDING, Array, LoadCycle, lengths, reactions
from ..errors import ModelError, SolverError
from ..limits import guaranteed_limit, shakedown_limit
from ..limits.open_nodes import open_under_mean
from ..limits.programs import free_slips
from ..limits.question import Question, pose, with_open
from ..limits.safe_vertices import furthest

_PARALLEL = ROUNDING  # directions of unit length that differ by less are one
_CORNERS = 12  # of a sampled history, furthest apart, at which starts are looked for
_BEYOND = 3.0, 10.0  # multiples of the extreme slips from which nodes open on the way to the mean load


class RangeStarts:
    """The starts of one contact, load cycle and friction at one load factor.

    Parameters
    ----------
    task, load_factor
        The contact, its load cycle, friction and slip bound; the load factor.
    """

    def __init__(self, task: Question, load_factor: float) -> None:
        self._task, self._load_factor = task, load_factor

    def simple(self) -> dict[str, Array]:
        """No slip, and the slip that is safe at the shakedown limit, if a solver proves one."""
        task = self._task
        starts = {"no slip": np.zeros(task.system.slip_shape)}
        with suppress(SolverError):
            limit = shakedown_limit(task.system, task.cycle, task.friction, slip_bound=task.most)
            starts |= {"safe at the shakedown limit": limit.slip} if np.isfinite(limit.load_factor) else {}
        return starts

    @cached_property
    def under_mean_load(self) -> dict[str, Array]:
        """The admissible slips under the mean load that go furthest in each direction, each once."""
        return self._furthest(self._task.cycle.mean, "under the mean load")

    def at_corners(self) -> dict[str, Array]:
        """The same at every corner, of many at those that are furthest apart."""
        cycle, loads, slips = self._task.cycle, self._task.cycle.at(self._load_factor), dict[str, Array]()
        for k in _furthest_apart(reactions(self._task.system, loads)):
            slips |= self._furthest(loads[k], f"at {cycle.corner_names[k]}")
        return slips

    def _furthest(self, loads: Mapping[str, float], place: str) -> dict[str, Array]:
        system, friction, most = self._task.system, self._task.friction, self._task.most

        def extremes(task: Question) -> list[Array | None]:
            give, unit = free_slips(task)[1], np.tile(task.node_unit, system.tangents)  # a traction counts by the slip that it makes
            ways = (unit * (give @ (way.T * ~task.open).ravel()) for way in self._directions.values())
            return furthest(task, 0.0, ways)

        slips = list[Array | None]()  # some starts less where none is found; the range is that of the starts followed
        with suppress(ModelError, SolverError):
            task = pose(system, LoadCycle(loads, [{}]), friction, slip_bound=most)
            with suppress(SolverError):  # solvers tell no slip at all from an answer that is none only where both are plain
                slips = extremes(task)
            if all(slip is None for slip in slips) and (opened := open_under_mean(task)) and (rest := with_open(task, opened[0])):
                slips = extremes(rest)
        found = dict[str, Array]()
        for name, slip in zip(self._directions, slips, strict=False):
            if slip is not None and all(np.abs(slip - other).max() > RESIDUAL * np.abs(slip).max() for other in found.values()):
                found[f"{name}, {place}"] = slip
        return found

    def beyond(self) -> list[list[tuple[str, Array]]]:
        """Multiples of each extreme slip under the mean load, as far as the slip bound allows: more than the closed contact can hold."""
        most, extreme = self._task.most, self.under_mean_load
        multiples = [[(f"{factor:g} x {name}", factor * slip) for factor in _BEYOND] for name, slip in extreme.items()]
        return multiples if most is None else [[(name, shortened(slip, most)) for name, slip in row] for row in multiples]

    def witness(self) -> dict[str, Array]:
        """The witness of the guaranteed limit, from which slip goes on just above it."""
        task = self._task
        try:
            lower = guaranteed_limit(task.system, task.cycle, task.friction, slip_bound=task.most)
        except (ModelError, SolverError):
            return {}  # in space it is not known where a part of the cycle is fixed
        return {"witness of the guaranteed limit": lower.slip} if np.isfinite(lower.load_factor) else {}

    @cached_property
    def _directions(self) -> Mapping[str, Array]:
        """Directions of slip, (N,) or (N, 2): along the changes of the load, stretched and squeezed, and those that unload an end of the contact.

        In space it stretches along both tangents, turns about the normal, and has four ends, between the tangents.
        """
        system, q1 = self._task.system, self._task.cycle.corner_reactions(self._task.system)[0]
        changes: dict[str, Array] = {}
        for name, step in zip(self._task.cycle.corner_names, np.roll(q1, -1, axis=0) - q1, strict=True):
            size = float(np.linalg.norm(step))
            units = [step / size, -step / size] if size > 0 else []
            if units and not any(np.abs(units[0] - other).max() <= _PARALLEL for other in changes.values()):
                changes |= {f"along the load after {name}": units[0], f"against the load after {name}": units[1]}
        if system.tangents == 1:
            x = system.x - system.x.mean()
            return changes | {"stretched": x, "squeezed": -x, "left end unloaded": -system.B[0], "right end unloaded": -system.B[-1]}
        x, y = np.einsum("nij,nj->in", system.frames[:, :2], system.points - system.points.mean(axis=0))
        still = np.zeros_like(x)
        ways = {"stretched along tangent 1": (x, still), "stretched along tangent 2": (still, y), "turned": (-y, x)}
        ways |= {f"node {node} unloaded": -system.B[node].reshape(2, -1) for node in sorted({int(z.argmax()) for z in (x + y, x - y, y - x, -x - y)})}
        fields = {name: np.transpose(way) for name, way in ways.items()}
        return (
            changes | fields | {f"{name}, reversed": -fields[name] for name in ("stretched along tangent 1", "stretched along tangent 2", "turned")}
        )


def _furthest_apart(vectors: Array) -> list[int]:
    """Numbers of those of many vectors that are furthest apart: each next one is as far as can be from the nearest one chosen, and from zero."""
    if len(vectors) <= _CORNERS:
        return list(range(len(vectors)))
    chosen, distance = list[int](), np.linalg.norm(vectors, axis=1)
    for _ in range(_CORNERS):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(vectors - vectors[chosen[-1]], axis=1))
    return sorted(chosen)


def shortened(slip: Array, most: Array) -> Array:
    """A slip, (N,) or (N, 2), cut to lengths of at most `most`, (N,)."""
    size = lengths(slip, most)
    return np.asarray((slip.T * np.minimum(1.0, most / np.where(size > 0, size, 1.0))).T)
