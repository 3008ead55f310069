"""Load cycles: a static load and the corners of a cyclic load."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ModelError
from .checks import Array, checked_loads
from .system import ContactSystem, checked_system

__all__ = ["LoadCycle", "checked_cycle"]


@dataclass(frozen=True)
class LoadCycle:
    """A mean load and the corners of a closed cycle around it; between corners the load is linear in time.

    At load factor `lam` corner k carries the loads `mean + lam * corners[k]`.

    Parameters
    ----------
    mean
        Static load, load case name -> amplitude (in the unit of the load case).
    corners
        The K corners in the order in which they are visited, each load case name -> amplitude at load factor 1.

    Raises
    ------
    ModelError
        No corner, a name that is not a text, an amplitude that is not finite; and, when used, a load case that the system lacks.

    Examples
    --------
    >>> import frictopt as fo
    >>> cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
    >>> cycle
    LoadCycle(mean={'P': 1.0}, corners=[{'sigma': -1.0}, {'sigma': 1.0}])
    >>> cycle == fo.LoadCycle({"P": 1}, [{"sigma": -1}, {"sigma": 1}])
    True
    """

    mean: Mapping[str, float]
    corners: Sequence[Mapping[str, float]]

    def __post_init__(self) -> None:
        object.__setattr__(self, "mean", checked_loads("mean", self.mean))
        if isinstance(self.corners, Mapping | str) or not isinstance(self.corners, Sequence):
            raise ModelError(f"corners: a {type(self.corners).__name__}; give a list of load corners, each load case name -> amplitude")
        if not self.corners:
            raise ModelError("corners: empty; a load cycle visits at least one corner")
        object.__setattr__(self, "corners", tuple(checked_loads(f"corners[{k}]", corner) for k, corner in enumerate(self.corners)))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self.mean), [dict(corner) for corner in self.corners])

    def __hash__(self) -> int:
        return hash((frozenset(self.mean.items()), tuple(frozenset(corner.items()) for corner in self.corners)))

    def __repr__(self) -> str:
        return f"LoadCycle(mean={dict(self.mean)}, corners={[dict(corner) for corner in self.corners]})"

    def mean_reaction(self, system: ContactSystem) -> tuple[Array, Array]:
        """(N,) reactions `q0, p0` of the closed, unslipped contact under the mean load."""
        return checked_system(system).closed_reaction(self.mean)

    def corner_reactions(self, system: ContactSystem) -> tuple[Array, Array]:
        """(K, N) bonded reactions `q1, p1` of the corners at load factor 1, without the mean."""
        pairs = [checked_system(system).reaction(corner) for corner in self.corners]
        return np.array([q for q, _ in pairs]), np.array([p for _, p in pairs])


def checked_cycle(cycle: Any) -> LoadCycle:
    """Check that `cycle` is a load cycle."""
    if not isinstance(cycle, LoadCycle):
        raise ModelError(f"cycle: a {type(cycle).__name__}; give a LoadCycle(mean=..., corners=[...])")
    return cycle
