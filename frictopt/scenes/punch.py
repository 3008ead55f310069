"""Punches on a block.

They are the paper's scene on a half-plane (Flicek et al. 2015, Fig. 1), a punch with round ends,
and a square punch in space.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from skfem import MeshHex, MeshQuad

from ..base import Array, Booleans, choice, finite_number, frozen, shown
from ..contact import ContactSystem
from ..errors import ModelError
from ..fem.bodies import Body
from ..fem.contacts import Contact
from ..fem.elasticity import ELEMENT_NAMES, ElementName, Material
from ..fem.loads import Traction
from ..fem.model import ContactModel
from ..fem.supports import Support
from .scene import Scene, along, away


@dataclass(frozen=True)
class PunchOnBlock(Scene):
    """Base of scenes of a punch on a block; the last coordinate goes up from the contact."""

    elements: int = 10
    half_width: float = 1.0
    punch_height: float = 2.0
    block_half_width: float = 4.0
    block_depth: float = 3.0
    growth: float = 1.7
    punch_material: Material = Material()
    block_material: Material = Material()
    element: ElementName = "linear"

    _within = (("half_width", "block_half_width"),)
    _directions = "xy"

    def __post_init__(self) -> None:
        choice("element", self.element, ELEMENT_NAMES)
        super().__post_init__()

    @property
    def _supports(self) -> Sequence[Support]:
        return [Support("block", "bottom")]

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        face = self.contact_nodes
        half = self.block_half_width
        up = away(self.punch_height, self.corner_size, self.growth)
        down = -away(self.block_depth, self.corner_size, self.growth)[::-1]
        side = self.half_width + away(half - self.half_width, self.corner_size, self.growth)[1:]
        # The sum may be off by rounding.
        side[-1] = half
        width = np.r_[-side[::-1], face, side]
        across = len(self._directions) - 1
        return [face] * across + [up], [width] * across + [down]

    def model(self) -> ContactModel:
        """The two meshes with supports and load cases."""
        *across, up = list(self._directions)
        shears = {
            "Q" if len(across) == 1 else f"Q{axis}": [Traction("punch", "top", **{axis: 1.0})]
            for axis in across
        }
        return ContactModel(
            bodies={"punch": self._punch(), "block": self._block()},
            supports=self._supports,
            loads={
                "P": [Traction("punch", "top", **{up: -1.0})],
                **shears,
                "sigma": [Traction("block", "left", x=-1.0), Traction("block", "right", x=1.0)],
            },
        )

    def _mesh(self, body: int) -> MeshQuad | MeshHex:
        kind = MeshQuad if self._directions == "xy" else MeshHex
        return kind.init_tensor(*self._grids[body])

    def _punch(self) -> Body:
        """Body 1, with the boundaries "contact" and "top"."""
        mesh = self._mesh(0).with_boundaries(
            {"contact": lambda x: x[-1] == 0, "top": lambda x: x[-1] == self.punch_height}
        )
        return Body(mesh, self.punch_material, self.element)

    def _block(self) -> Body:
        """Body 2, with the boundaries "contact", "bottom", "left" and "right"."""

        def on_contact(x: Array) -> Booleans:
            return np.asarray((x[-1] == 0) & (np.abs(x[:-1]) < self.half_width).all(axis=0))

        mesh = self._mesh(1).with_boundaries(
            {
                "contact": on_contact,
                "bottom": lambda x: x[-1] == -self.block_depth,
                "left": lambda x: x[0] == -self.block_half_width,
                "right": lambda x: x[0] == self.block_half_width,
            }
        )
        return Body(mesh, self.block_material, self.element)


@dataclass(frozen=True)
class PunchOnHalfPlane(PunchOnBlock):
    """Rectangular punch on a block that represents a half-plane, meshed in quadrilaterals.

    The default has about as many unknowns as the paper's scene. The bottom of the block is on
    rollers; one node is held along x. The contact is `-half_width <= x <= half_width`, y = 0. Load
    cases, each of unit traction: "P", pressure on the top of the punch; "sigma", tension on the two
    sides of the block; "Q", shear along +x on the top of the punch. With a mean load of one "P",
    the load factor of "sigma" is therefore `sigma / (P / 2a)`, where P is the total normal force.

    Parameters
    ----------
    elements
        Number of elements along the contact, even, from 2 to 10,000 (N = elements + 1 node pairs).
    half_width, punch_height, block_half_width, block_depth
        Half-width `a` of the contact, height of the punch, and size of the block, length.
    growth
        Ratio of neighbouring element sizes away from the contact, > 1. The first element has the
        size of the corner element.
    punch_material, block_material
        The two materials.
    element
        "linear", or "mean_dilatation": quadrilaterals that do not lock as nu approaches 0.5; the
        answer then depends less on nu.
    grading
        Size of the middle element divided by the size of the corner element, >= 1, with sizes in
        geometric progression. Or "sine": nodes at `x = a sin(pi t / 2)`, with t uniform in [-1, 1].

    Raises
    ------
    ModelError
        Sizes that are not positive, numbers of elements that are odd or too small, a block narrower
        than the punch, a body of more than a million nodes.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).condense()
    ContactSystem(nodes=5, x=-1 .. 1, loads=['P', 'Q', 'sigma'], gap=False)
    """

    elements: int = 124
    block_half_width: float = 12.0
    block_depth: float = 12.0
    growth: float = 1.09
    grading: float | Literal["sine"] = 20.0

    def __post_init__(self) -> None:
        if isinstance(self.grading, str):
            choice("grading", self.grading, ("sine",))
        else:
            grading = finite_number("grading", self.grading, least=1.0, below=1e15)
            object.__setattr__(self, "grading", grading)
        super().__post_init__()

    @property
    def contact_nodes(self) -> Array:
        """(N,) x of the nodes along the contact, exactly mirror-symmetric."""
        if not isinstance(self.grading, str):
            return along(self.half_width, self.elements, self.grading)
        half = self.elements // 2
        right = self.half_width * np.sin(np.pi / 2 * np.arange(1, half + 1) / half)
        right[-1] = self.half_width
        return np.concatenate([-right[::-1], [0.0], right])

    @property
    def _supports(self) -> list[Support]:
        return [Support("block", "bottom", "y"), Support("block", (0.0, -self.block_depth), "x")]

    def condense(self, *, progress: bool = True) -> ContactSystem:
        """Mesh, assemble and condense to the contact.

        The result is the mean of the contact and its mirror image, so that rounding causes no
        asymmetry. `progress`: whether to show a progress bar after two seconds.
        """
        system = self.model().condense(progress=progress)
        # Parity of the shear reactions; the pressures have the opposite parity.
        parity = {"P": -1, "sigma": -1, "Q": 1}
        A = _even(system.A)
        B = _even(system.B, -1)
        C = _even(system.C)
        return replace(
            system,
            S=np.block([[A, B.T], [B, C]]),
            points=np.column_stack([self.contact_nodes, np.zeros(system.nodes)]),
            bonded={
                name: (_even(q, parity[name]), _even(p, -parity[name]))
                for name, (q, p) in system.bonded.items()
            },
        )


def _even(values: Array, sign: int = 1) -> Array:
    """Even (or, with sign -1, odd) part under reversal of the nodes."""
    return frozen((values + sign * np.flip(values)) / 2)


@dataclass(frozen=True)
class RoundedPunch(Scene):
    """Punch with a flat middle and round ends on a block that represents a half-plane.

    Without a flat middle it is a cylinder. The initial gap is `max(|x| - flat_half_width, 0)^2 / (2
    radius)`, a parabola in place of the arc, between straight meshes. `PunchOnHalfPlane` describes
    the load cases. Outer nodes are open under any load, and pressure falls to zero at the end of
    the contact.

    Parameters
    ----------
    radius, flat_half_width
        Radius of the round ends or of the cylinder, and half-width of the flat middle (0: a
        cylinder), length.
    punch
        Meshes, sizes, materials and supports. The contact area must end within the `half_width` of
        this punch. If the end of the contact area moves, use elements of one size.

    Raises
    ------
    ModelError
        A radius that is not positive, a flat as wide as the punch.

    Examples
    --------
    >>> import frictopt as fo
    >>> straight = fo.scenes.PunchOnHalfPlane(elements=20, grading=1.0, growth=1.5)
    >>> punch = fo.scenes.RoundedPunch(radius=50, punch=straight)
    >>> float(punch.condense().gap[-1])
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
            raise ModelError(
                f"flat_half_width: {self.flat_half_width:g}; "
                f"it must be less than the punch's half_width = {self.punch.half_width:g}"
            )

    @property
    def contact_nodes(self) -> Array:
        """(N,) x of the nodes along the faces of the punch and the block."""
        return self.punch.contact_nodes

    @property
    def _grids(self) -> Sequence[Sequence[Array]]:
        return self.punch._grids

    @property
    def gap(self) -> Array:
        """(N,) initial gap."""
        return self._gap_at(self.contact_nodes)

    def _gap_at(self, x: Array, _: Array | None = None) -> Array:
        past_the_flat = np.maximum(np.abs(x) - self.flat_half_width, 0.0)
        return np.asarray(past_the_flat**2 / (2 * self.radius))

    def model(self) -> ContactModel:
        """The two straight meshes with supports, load cases and the initial gap."""
        return replace(self.punch.model(), contacts=[Contact("punch", "block", gap=self._gap_at)])

    def condense(self, *, progress: bool = True) -> ContactSystem:
        """Mesh, assemble, condense to the contact, and add the gap.

        `progress`: whether to show a progress bar after two seconds.
        """
        return self.punch.condense(progress=progress).with_gap(self.gap)


@dataclass(frozen=True)
class SquarePunch(PunchOnBlock):
    """A punch of square section on a block, in structured hexahedra.

    The contact is `|x|, |y| <= half_width`, z = 0; the block's bottom is held. Load cases, each of
    unit traction: "P", pressure on the top of the punch; "Qx" and "Qy", shear on the top of the
    punch along x and y; "sigma", tension along x on the two sides of the block.

    Parameters
    ----------
    elements
        Number of elements along each side of the contact, at least 2: N = (elements + 1)^2 node
        pairs. With 24 elements there are 48,000 unknowns.
    half_width, punch_height, block_half_width, block_depth
        Half the side `a` of the contact, height of the punch, and size of the block, length.
    growth, punch_material, block_material, element
        See `PunchOnHalfPlane`; the first element is as large as the elements on the contact, and
        elements are hexahedra.

    Raises
    ------
    ModelError
        Sizes that are not positive or too far apart, a block narrower than the punch.

    Examples
    --------
    >>> import frictopt as fo
    >>> fo.scenes.SquarePunch(elements=2, growth=2.0).condense()
    ContactSystem(nodes=9, tangents=2, loads=['P', 'Qx', 'Qy', 'sigma'], gap=False)
    """

    punch_height: float = 1.5

    _multiple = 1
    _directions = "xyz"

    @property
    def contact_nodes(self) -> Array:
        """(elements + 1,) x and y of the nodes of the contact, exactly mirror-symmetric."""
        return np.asarray(
            self.half_width * np.arange(-self.elements, self.elements + 1, 2) / self.elements
        )
