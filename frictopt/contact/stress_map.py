"""Stress and strain at points, linear in the loads and in the motions of the contact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from ..base import Array, Kept, Loads, checked_cases, checked_loads, finite_array, flag, frozen
from ..errors import ModelError
from .components import joined
from .system import ContactSystem, checked_system


@dataclass(frozen=True, eq=False, repr=False)
class StressMap(Kept):
    """Stress and strain at points, linear in the loads and in the motions of the contact.

    `ContactModel.stress_map` computes it. If another code has the matrices, give the arrays.

    Parameters
    ----------
    system
        The contact.
    points
        (P, d) places of the points.
    loads
        Load case of the system -> (2, P, 3, 3) stress, tension positive, and strain at the points
        due to the load case at amplitude 1. The bodies are glued at their initial gaps.
    motions
        (M, 2, P, 3, 3) stress and strain due to unit motions of the nodes: their slips as the
        system counts them, component after component, then their gaps.
    on_face
        Whether the points are on the face of the contact. The largest stress over all states of
        rest then grows with each refinement of the mesh.

    Raises
    ------
    ModelError
        Other load cases than the system has, other shapes, or numbers that are not finite.

    Examples
    --------
    >>> import numpy as np
    >>> import frictopt as fo
    >>> rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    >>> along = np.zeros((8, 2, 1, 3, 3))  # 4 slips and 4 gaps
    >>> along[:2, :, 0, 0, 0] = [[-1.0, -1.0], [1.0, 1.0]]  # of the first element
    >>> none = np.zeros((2, 1, 3, 3))
    >>> loads = {name: none for name in rod.bonded}
    >>> stresses = fo.results.StressMap(rod, points=[[0.5, 0.0]], loads=loads, motions=along)
    >>> stress, strain = stresses.tensors({}, slip=[0.1, 0.0, 0.0, 0.0])
    >>> float(stress[0, 0, 0])
    -0.1
    """

    _shown_names = ("nodes", "count", "on_face")
    system: ContactSystem
    points: ArrayLike
    loads: Mapping[str, ArrayLike] = field(repr=False)
    motions: ArrayLike = field(repr=False)
    on_face: bool = False

    def __post_init__(self) -> None:
        checked_system(self.system)
        d = self.system.tangents + 1
        points = finite_array("points", self.points, (None, d))
        shape = (2, len(points), 3, 3)
        loads = checked_cases("loads", self.loads, "array of stress and strain")
        if set(loads) != set(self.system.bonded):
            raise ModelError(
                f"loads: {sorted(loads)}; give the load cases of the system, "
                f"{sorted(self.system.bonded)}"
            )
        cases = {name: finite_array(f"loads[{name!r}]", loads[name], shape) for name in loads}
        motions = finite_array("motions", self.motions, (d * self.system.nodes, *shape))
        vars(self).update(
            points=points,
            loads=MappingProxyType(cases),
            motions=motions,
            on_face=flag("on_face", self.on_face),
        )
        super().__post_init__()

    @property
    def nodes(self) -> int:
        """The number of nodes of the contact."""
        return self.system.nodes

    @property
    def count(self) -> int:
        """The number of points."""
        return len(np.asarray(self.points))

    def tensors(
        self, loads: Loads, slip: ArrayLike, gap: ArrayLike | None = None
    ) -> tuple[Array, Array]:
        """(P, 3, 3) stress and strain at the points, in a state of the contact.

        Parameters
        ----------
        loads
            Load case name -> amplitude.
        slip, gap
            Slip (N,), in space (N, 2), and gap (N,), which includes the initial gap, length. None:
            the initial gap.

        Raises
        ------
        ModelError
            An unknown load case, other shapes, or numbers that are not finite.
        """
        amplitudes = checked_loads("loads", loads)
        if unknown := sorted(set(amplitudes) - set(self.loads)):
            raise ModelError(f"loads: {unknown[0]!r} is unknown; give some of {sorted(self.loads)}")
        system = self.system
        slip = finite_array("slip", slip, system.slip_shape)
        opening = np.zeros(system.nodes)
        if gap is not None:
            opening = finite_array("gap", gap, (system.nodes,)) - system.gap
        both = self.at(amplitudes, joined(slip, opening))
        return frozen(both[0]), frozen(both[1])

    def at(self, loads: Loads, motion: Array) -> Array:
        """(2, P, 3, 3) stress and strain under loads and a motion.

        The motion (M,) has the slips, then the gaps minus the initial gaps.
        """
        total = np.tensordot(motion, np.asarray(self.motions), 1)
        for name, amplitude in loads.items():
            total = total + amplitude * np.asarray(self.loads[name])
        return total
