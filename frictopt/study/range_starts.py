"""Starts of a search over residual slips: extreme slips that the contact can hold."""

from contextlib import suppress
from functools import cached_property

import numpy as np

from ..base import RESIDUAL, ROUNDING, Array, Loads
from ..contact import ContactSystem, LoadCycle, lengths, reactions
from ..errors import ModelError, SolverError
from ..limits import Question, guaranteed_limit, pose, shakedown_limit, with_open
from ..limits.program.rest_slips import Furthest, Rests
from ..limits.search.likely_sets import open_under_mean


class RangeStarts:
    """Starts of a search: extreme slips that one contact can hold under the loads of its cycle.

    An extreme slip that no solver finds is left out.
    """

    def __init__(self, question: Question, load_factor: float) -> None:
        self._question = question
        self._load_factor = load_factor

    def simple(self) -> dict[str, Array]:
        """No slip, and the slip that is safe at the shakedown limit, if a solver proves one."""
        question = self._question
        starts = {"no slip": np.zeros(question.system.slip_shape)}
        with suppress(SolverError):
            limit = shakedown_limit(
                question.system, question.cycle, question.friction, slip_bound=question.slip_bound
            )
            if np.isfinite(limit.load_factor):
                starts["safe at the shakedown limit"] = limit.slip
        return starts

    @cached_property
    def under_mean_load(self) -> dict[str, Array]:
        """The admissible slips under the mean load that go furthest in each direction."""
        return self._furthest(self._question.cycle.mean, "under the mean load")

    def at_corners(self) -> dict[str, Array]:
        """The furthest admissible slips at the corners; of many, at the twelve furthest apart."""
        cycle = self._question.cycle
        loads = cycle.at(self._load_factor)
        slips = dict[str, Array]()
        for k in _furthest_apart(reactions(self._question.system, loads)):
            slips |= self._furthest(loads[k], f"at {cycle.corner_names[k]}")
        return slips

    def multiplied(self) -> list[list[tuple[str, Array]]]:
        """Multiples of each extreme slip under the mean load, shortened to the slip bound.

        The closed contact cannot hold these slips: nodes open on the way to the mean load.
        """
        slip_bound = self._question.slip_bound
        return [
            [(f"{factor:g} x {name}", shortened(factor * slip, slip_bound)) for factor in (3, 10)]
            for name, slip in self.under_mean_load.items()
        ]

    def witness(self) -> dict[str, Array]:
        """The witness of the guaranteed limit, from which slip goes on just above this limit."""
        question = self._question
        try:
            limit = guaranteed_limit(
                question.system, question.cycle, question.friction, slip_bound=question.slip_bound
            )
        except (ModelError, SolverError):
            # In space a coupled contact has no guaranteed limit under a cycle with a fixed part.
            return {}
        if not np.isfinite(limit.load_factor):
            return {}
        return {"witness of the guaranteed limit": limit.slip}

    def _furthest(self, loads: Loads, place: str) -> dict[str, Array]:
        """The admissible slips under given loads that go furthest in each direction, each once."""
        extremes = dict[str, Array]()
        slips = self._extreme_slips(loads)
        for name, slip in zip(self._directions, slips, strict=False):
            if slip is not None:
                tolerance = RESIDUAL * np.abs(slip).max()
                known = extremes.values()
                if all(np.abs(slip - extreme).max() > tolerance for extreme in known):
                    extremes[f"{name}, {place}"] = slip
        return extremes

    def _extreme_slips(self, loads: Loads) -> list[Array | None]:
        """An admissible slip for each direction, first with all nodes closed; [] if none is found.

        If no slip is admissible with all nodes closed, the nodes that the loads leave open are
        open.
        """
        system, friction = self._question.system, self._question.friction
        slips = list[Array | None]()
        with suppress(ModelError, SolverError):
            question = pose(
                system, LoadCycle(loads, [{}]), friction, slip_bound=self._question.slip_bound
            )
            # If no slip is admissible, a solver may fail instead of saying so.
            with suppress(SolverError):
                slips = self._slips_along_directions(question)
            if all(slip is None for slip in slips):
                open_sets = open_under_mean(question)
                partly_open = with_open(question, open_sets[0]) if open_sets else None
                if partly_open is not None:
                    slips = self._slips_along_directions(partly_open)
        return slips

    def _slips_along_directions(self, question: Question) -> list[Array | None]:
        """The admissible slip that goes furthest in each direction, None if there is none."""
        furthest = Furthest(Rests(question, 0.0))
        return [furthest.along(direction.T.ravel()) for direction in self._directions.values()]

    @cached_property
    def _directions(self) -> dict[str, Array]:
        """Directions of slip, (N,) or (N, 2), by their names."""
        system = self._question.system
        directions = _load_directions(system, self._question.cycle)
        if system.tangents == 1:
            return directions | _plane_directions(system)
        return directions | _space_directions(system)


def _load_directions(system: ContactSystem, cycle: LoadCycle) -> dict[str, Array]:
    """Directions along and against each change of the bonded shear from corner to corner."""
    shear, _ = cycle.corner_reactions(system)
    changes = np.roll(shear, -1, axis=0) - shear
    directions = dict[str, Array]()
    for name, change in zip(cycle.corner_names, changes, strict=True):
        size = float(np.linalg.norm(change))
        if size == 0:
            continue
        direction = change / size
        if all(np.abs(direction - known).max() > ROUNDING for known in directions.values()):
            directions[f"along the load after {name}"] = direction
            directions[f"against the load after {name}"] = -direction
    return directions


def _plane_directions(system: ContactSystem) -> dict[str, Array]:
    """Directions that stretch and squeeze the face, and that unload one of its ends."""
    x = system.x - system.x.mean()
    return {
        "stretched": x,
        "squeezed": -x,
        "left end unloaded": -system.B[0],
        "right end unloaded": -system.B[-1],
    }


def _space_directions(system: ContactSystem) -> dict[str, Array]:
    """Directions that stretch and turn the face, and that unload one of its outermost nodes."""
    centred = system.points - system.points.mean(axis=0)
    x, y = np.einsum("nij,nj->in", system.frames[:, :2], centred)  # along both tangents, (N,) each
    still = np.zeros_like(x)
    fields = {
        "stretched along tangent 1": np.transpose([x, still]),
        "stretched along tangent 2": np.transpose([still, y]),
        "turned": np.transpose([-y, x]),
    }
    outermost = sorted({int(along.argmax()) for along in (x + y, x - y, y - x, -x - y)})
    unloaded = {f"node {node} unloaded": -system.B[node].reshape(2, -1).T for node in outermost}
    reversed_fields = {f"{name}, reversed": -field for name, field in fields.items()}
    return fields | unloaded | reversed_fields


def _furthest_apart(vectors: Array) -> list[int]:
    """Indices of at most twelve vectors that are furthest apart.

    Each next vector is the one whose nearest neighbour among zero and the chosen vectors is
    furthest.
    """
    # Largest number of corners of a long history at which starts are looked for.
    most = 12
    if len(vectors) <= most:
        return list(range(len(vectors)))
    chosen = list[int]()
    distance = np.linalg.norm(vectors, axis=1)
    for _ in range(most):
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(vectors - vectors[chosen[-1]], axis=1))
    return sorted(chosen)


def shortened(slip: Array, slip_bound: Array | None) -> Array:
    """A slip, (N,) or (N, 2), cut to lengths of at most the slip bound, (N,), if there is one."""
    if slip_bound is None:
        return slip
    size = lengths(slip, slip_bound)
    share = np.minimum(1.0, slip_bound / np.where(size > 0, size, 1.0))
    return (slip.T * share).T
