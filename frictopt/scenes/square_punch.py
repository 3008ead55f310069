"""A scene in three dimensions: a square punch pressed on a block."""

from dataclasses import dataclass

import numpy as np

from ..contact.checks import Array
from .block import PunchOnBlock


@dataclass(frozen=True)
class SquarePunch(PunchOnBlock):
    """A punch of square section on a block, in structured hexahedra.

    The contact is `|x|, |y| <= half_width`, z = 0; the block's bottom is held. Load cases, each of unit traction: "P", pressure on the top of the
    punch; "Qx" and "Qy", shear there along x and y; "sigma", tension along x on the two sides of the block.

    Parameters
    ----------
    elements
        Number of elements along each side of the contact, at least 2: N = (elements + 1)^2 node pairs. 24 make 48,000 unknowns.
    half_width, punch_height
        Half the side `a` of the contact, and height of the punch, length.
    block_half_width, block_depth
        Size of the block, length.
    growth
        Ratio of neighbouring element sizes away from the contact, > 1; the first one has the size of those on the contact.
    punch_material, block_material
        The two materials.
    element
        "linear", or "mean_dilatation": hexahedra that do not lock as nu approaches 0.5.

    Raises
    ------
    ModelError
        Sizes that are not positive or too far apart, a block narrower than the punch.

    Examples
    --------
    >>> import frictopt as fo
    >>> system = fo.scenes.SquarePunch(elements=2, growth=2.0).condense()
    >>> system
    ContactSystem(nodes=9, tangents=2, loads=['P', 'Qx', 'Qy', 'sigma'], gap=False)
    >>> q, p = system.reaction({"P": 1.0})
    >>> round(float(p.sum()), 6)  # the whole pressure, (2 a)^2
    4.0
    """

    punch_height: float = 1.5

    _multiple = 1
    _directions = "xyz"

    @property
    def contact_nodes(self) -> Array:
        """(elements + 1,) x and y of the nodes of the contact, exactly mirror-symmetric."""
        return np.asarray(self.half_width * np.arange(-self.elements, self.elements + 1, 2) / self.elements)
