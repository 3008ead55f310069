"""A rounded punch, or a cylinder, pressed on a half-plane: the contact ends inside the meshed face."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..contact import ContactSystem
from ..contact.checks import Array, shown
from ..errors import ModelError
from ..fem.contacts import Contact
from ..fem.model import ContactModel
from .punch import PunchOnHalfPlane
from .scene import Scene


@dataclass(frozen=True)
class RoundedPunch(Scene):
    """A punch with a flat middle and round ends on a block that stands for a half-plane; without a flat, a cylinder.

    The punch starts `max(|x| - flat_half_width, 0)^2 / (2 radius)` above the block: the parabola of the radius, as an initial gap on straight
    meshes. Load cases are those of `PunchOnHalfPlane`. Outer nodes are open under any load, and pressure falls to zero where the contact ends.

    Parameters
    ----------
    radius
        Radius of the round ends, or of the cylinder, length.
    flat_half_width
        Half of the flat in the middle, length; 0: a cylinder.
    punch
        Meshes, sizes, materials and supports; the contact must end within its `half_width`. Elements of one size suit an end that moves.

    Raises
    ------
    ModelError
        A radius that is not positive, a flat as wide as the punch.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.scenes.RoundedPunch(radius=50, punch=fo.scenes.PunchOnHalfPlane(elements=20, grading=1.0, growth=1.5)).condense()
    >>> system
    ContactSystem(nodes=21, x=-1 .. 1, loads=['P', 'Q', 'sigma'], gap=True)
    >>> float(system.gap[-1])
    0.01
    """

    radius: float = 50.0
    flat_half_width: float = 0.0
    punch: PunchOnHalfPlane = PunchOnHalfPlane(elements=80, grading=1.0, growth=1.15)

    def __post_init__(self) -> None:
        if not isinstance(self.punch, PunchOnHalfPlane):
            raise ModelError(f"punch: {shown(self.punch)}; give a PunchOnHalfPlane")
        super().__post_init__()

    def _check_sizes(self) -> None:
        if not self.flat_half_width < self.punch.half_width:
            raise ModelError(f"flat_half_width: {self.flat_half_width:g}; it must be less than the punch's half_width = {self.punch.half_width:g}")

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        return self.punch._grids

    @property
    def gap(self) -> Array:
        """(N,) initial gap."""
        return self._gap_at(self.punch.contact_nodes)

    def _gap_at(self, x: Array, _: Array | None = None) -> Array:
        return np.asarray(np.maximum(np.abs(x) - self.flat_half_width, 0.0) ** 2 / (2 * self.radius))

    def model(self) -> ContactModel:
        """The two straight meshes with supports, load cases and the initial gap."""
        return replace(self.punch.model(), contacts=[Contact("punch", "block", gap=self._gap_at)])

    def condense(self) -> ContactSystem:
        """Mesh, assemble, condense to the contact, and take the gap in."""
        return self.punch.condense().with_gap(self.gap)
