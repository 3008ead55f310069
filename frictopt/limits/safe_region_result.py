"""The amplitudes of two loads that vary independently at which some residual slip is safe, between two polygons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pandas as pd

from ..contact import Array, LoadCycle, Plotted, Recorded, SolveRecord, finite_number, frame


@dataclass(frozen=True, eq=False, repr=False)
class SafeRegion(Recorded, Plotted):
    """The amplitudes `(a, b)` of two loads at which some residual slip is safe.

    The region is convex, and holds all smaller amplitudes with any that it holds: both loads come back to zero, so that the mean load is in every
    domain, and must be safe. Its border goes from an amplitude of the first load alone to one of the second load alone: in the plane straight sides,
    in space a curve between the polygon of points that are proven safe, `vertices`, and that of mechanisms, `outer`.

    Attributes
    ----------
    loads, unlimited
        Names of the two loads, and of those whose amplitude has no limit.
    vertices
        (V, 2) amplitudes on the border, each proven safe, from the first load alone to the second; inf where there is no limit, empty where none is
        safe. Between them all are safe, too.
    outer
        (W, 2) amplitudes at the ends of the sides; in the plane the vertices.
    sides
        One row for each side, between two of `outer`: columns a, b, bound. No amplitudes are safe with `a * first + b * second > bound`;
        a, b and bound are works of the side's mechanism, scaled to `bound = 1` where the mean load has a resistance.
    gap
        Largest distance of the two polygons on a ray from zero, over its length: 0 in the plane, at most the tolerance in space.
    mechanisms
        For each side, which nodes limit the amplitudes: as in `ShakedownLimit.mechanism`, corners of `cycle(a, b)`.
    reason
        Why the region is what it is, in words.
    record
        How it was found. Its `residual`, at most 2e-8, is the largest of: the residuals of the limits at all vertices, and the distance of each side
        from its two vertices, relatively.

    Examples
    --------
    >>> import frictopt as fo
    >>> node = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [2.0]), "Q": ([1.0], [0.0]), "R": ([0.0], [-1.0])})
    >>> region = fo.safe_region(node, {"P": 1.0}, ["Q", "R"], friction=0.5)
    >>> region.contains(0.5, 0.9), region.contains(0.5, 1.1)
    (True, False)
    """

    loads: tuple[str, str]
    vertices: Array
    outer: Array = field(repr=False)
    sides: pd.DataFrame = field(repr=False)
    mechanisms: tuple[pd.DataFrame, ...] = field(repr=False)
    unlimited: tuple[str, ...]
    gap: float
    reason: str
    record: SolveRecord
    _mean: Mapping[str, float] = field(repr=False)
    _parts: tuple[Sequence[Mapping[str, float]], Sequence[Mapping[str, float]]] = field(repr=False)

    def contains(self, first: float, second: float) -> bool:
        """Whether some slip is proven safe at these amplitudes, in the polygon of `vertices`; ModelError if not finite or negative."""
        at = np.array([finite_number("first", first, least=0.0), finite_number("second", second, least=0.0)])
        within = all(across @ at <= across @ one for one, across in _chords(self.vertices))
        return within and bool((at <= self.vertices.max(axis=0, initial=-1.0)).all())

    def cycle(self, first: float, second: float) -> LoadCycle:
        """The vertices of the domain of loads at these amplitudes, a load cycle for other functions; ModelError if not finite or negative."""
        amplitudes = finite_number("first", first, least=0.0), finite_number("second", second, least=0.0)
        return domain(self._mean, self._parts, amplitudes)

    def to_frame(self) -> pd.DataFrame:
        """One row for each vertex: its two amplitudes."""
        return frame({name: self.vertices[:, number] for number, name in enumerate(self.loads)})

    def _answer(self) -> Mapping[str, object]:
        curved = {"gap": self.gap} if self.gap else {}
        said = {"loads": self.loads, "sides": len(self.sides), "unlimited": self.unlimited, **curved}
        return said | {"residual": self.residual, "reason": self.reason}


def domain(mean: Mapping[str, float], parts: tuple[Sequence[Mapping[str, float]], ...], amplitudes: tuple[float, float]) -> LoadCycle:
    """The vertices of the loads that vary around the mean, each within the hull of its corners, see `SafeRegion.cycle`."""
    scaled = [
        [{case: factor * amplitude for case, amplitude in corner.items()} for corner in part] for factor, part in zip(amplitudes, parts, strict=True)
    ]
    return LoadCycle.vertices(mean, *scaled)


def _chords(vertices: Array) -> list[tuple[Array, Array]]:
    """For each two neighbouring points of the border, the first one and a vector across their chord, outwards."""
    return [(one, np.array([other[1] - one[1], one[0] - other[0]])) for one, other in pairwise(vertices)]


def beyond_chord(one: Array, other: Array, at: Array) -> float:
    """How far a point is beyond the chord of two points of the border on its ray from zero, over its distance from zero."""
    ((_, across),) = _chords(np.array([one, other]))
    return float(1 - across @ one / (across @ at))
