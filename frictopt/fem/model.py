"""A contact of two meshed bodies: its description by the user, and the checks of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy.linalg import null_space

from ..contact import ContactSystem
from ..contact.checks import Array, check_name, choice, shown
from ..errors import ModelError
from ..tolerances import EQUILIBRIUM, SAME_POINT
from .bodies import Body, BodyName, Support, Traction
from .glue import GluedBodies
from .ordering import Integers

__all__ = ["ContactModel"]


@dataclass(frozen=True, eq=False)
class ContactModel:
    """Two elastic bodies that meet along a straight interface parallel to x, the punch above the block; plane strain.

    Parameters
    ----------
    punch, block
        The bodies 1 and 2. Both meshes name the interface, and their nodes on it coincide.
    supports
        Supports. They must prevent all rigid motions of the glued bodies; the punch alone may be free.
    loads
        Load case name -> its tractions.
    interface
        Name of the interface's boundary in both meshes.

    Raises
    ------
    ModelError
        Bodies without the interface or with nodes that do not match, an unknown boundary, a load case without traction, a support on the punch's
        interface, rigid motions that no support prevents.

    Examples
    --------
    >>> from skfem import MeshQuad
    >>> import frictopt as fo
    >>> x = [0.0, 0.5, 1.0]
    >>> upper = MeshQuad.init_tensor(x, [0.0, 1.0]).with_boundaries({"contact": lambda x: x[1] == 0, "top": lambda x: x[1] == 1})
    >>> lower = MeshQuad.init_tensor(x, [-1.0, 0.0]).with_boundaries({"contact": lambda x: x[1] == 0, "bottom": lambda x: x[1] == -1})
    >>> model = fo.ContactModel(
    ...     punch=fo.Body(upper),
    ...     block=fo.Body(lower),
    ...     supports=[fo.Support("block", "bottom")],
    ...     loads={"P": [fo.Traction("punch", "top", y=-1.0)]},
    ... )
    >>> system = model.condense()
    >>> system
    ContactSystem(nodes=3, x=0 .. 1, loads=['P'], gap=False)
    >>> q, p = system.bonded["P"]
    >>> round(float(p.sum()), 6)  # the whole pressure
    1.0
    """

    punch: Body
    block: Body
    supports: Sequence[Support]
    loads: Mapping[str, Sequence[Traction]]
    interface: str = "contact"

    def __post_init__(self) -> None:
        for name in ("punch", "block"):
            if not isinstance(getattr(self, name), Body):
                raise ModelError(f"{name}: a {type(getattr(self, name)).__name__}; give a Body(mesh, material)")
        if not isinstance(self.loads, Mapping) or not self.loads:
            raise ModelError(f"loads: {shown(self.loads)}; give at least one load case, name -> list of Traction")
        for name in self.loads:
            check_name("loads", name)
        for argument, kind, parts in [
            ("supports", Support, self.supports),
            *((f"loads[{name!r}]", Traction, parts) for name, parts in self.loads.items()),
        ]:
            if isinstance(parts, str) or not isinstance(parts, Sequence) or not all(isinstance(part, kind) for part in parts):
                raise ModelError(f"{argument}: {shown(parts)}; give a list of {kind.__name__}")
            if kind is Traction and not parts:
                raise ModelError(f"{argument}: no traction; give at least one, or leave the load case out")
        object.__setattr__(self, "supports", tuple(self.supports))
        object.__setattr__(self, "loads", MappingProxyType({name: tuple(parts) for name, parts in self.loads.items()}))
        for name, parts in self.loads.items():
            for part in parts:
                self.body(part.body).boundary_nodes(part.boundary, f"loads[{name!r}]")
        self._check_interface()
        self._check_supports()

    def body(self, name: BodyName) -> Body:
        """The body of that name."""
        return self.punch if choice("name", name, ("punch", "block")) == "punch" else self.block

    def interface_nodes(self, name: BodyName) -> Integers:
        """Nodes of that body on the interface, in the order of x."""
        body = self.body(name)
        nodes = body.boundary_nodes(self.interface, f"interface of the {name}")
        return nodes[np.argsort(body.mesh.p[0, nodes])]

    def _support_nodes(self, support: Support) -> Integers:
        """Nodes that a support holds."""
        mesh = self.body(support.body).mesh
        if isinstance(support.where, str):
            return self.body(support.body).boundary_nodes(support.where, f"support of the {support.body}")
        distance = np.hypot(*(mesh.p - np.array(support.where)[:, None]))
        if distance.min() > SAME_POINT * np.ptp(mesh.p):
            nearest = tuple(float(value) for value in mesh.p[:, distance.argmin()])
            raise ModelError(f"support of the {support.body}: no node at {support.where}; the nearest is at {nearest}")
        return np.array([distance.argmin()])

    def condense(self) -> ContactSystem:
        """Condense the glued bodies to the relative motion of the interface.

        Raises
        ------
        ModelError
            The stiffness cannot be factorised, or not accurately enough (extreme materials, sizes or elements).
        """
        contact = self.interface_nodes("block")
        bodies = GluedBodies(self.punch, self.block, self.interface_nodes("punch"), contact)
        held = np.concatenate([bodies.unknowns(support.body, self._support_nodes(support), support.directions) for support in self.supports])
        S, R = bodies.condense(np.column_stack([self._forces(bodies, case) for case in self.loads]), held)
        n = len(contact)
        S, R = self._balanced(S, R)
        return ContactSystem(
            A=S[:n, :n],
            B=S[n:, :n],
            C=S[n:, n:],
            x=self.block.mesh.p[0, contact],
            bonded={case: (R[:n, j], R[n:, j]) for j, case in enumerate(self.loads)},
            E_star=1 / (1 / self.punch.material.plane_modulus + 1 / self.block.material.plane_modulus),
        )

    def _balanced(self, S: Array, R: Array) -> tuple[Array, Array]:
        """S and R without the rounding errors of the elimination in the rigid motions of the punch.

        Only the rigid motions count that the punch's own supports allow. S must have no stiffness against them, and in each of them the reactions of
        a load case must do the work of the load on the punch, with the opposite sign. The deviation measures the accuracy of the elimination.

        Raises
        ------
        ModelError
            The deviation exceeds the tolerance.
        """
        contact, mesh = self.block.mesh.p[:, self.interface_nodes("block")], self.punch.mesh
        free = self._free_motions([support for support in self.supports if support.body == "punch"])
        rigid, to_unit = np.linalg.qr(_rigid_motions(contact, contact) @ free)
        motions = _rigid_motions(mesh.p, contact) @ free @ np.linalg.inv(to_unit)
        loads = np.zeros((2 * mesh.p.shape[1], len(self.loads)))
        for column, parts in zip(loads.T, self.loads.values(), strict=True):
            for part in parts:
                if part.body == "punch":
                    column += self.punch.force(part).ravel()
        excess = rigid.T @ R + motions.T @ loads
        scale = np.abs(R).sum(axis=0) + np.abs(loads).sum(axis=0)
        errors = [*(np.abs(excess) / np.where(scale > 0, scale, 1.0)).ravel(), *(np.abs(S @ rigid) / np.abs(S).max()).ravel()]
        error = float(max(errors, default=0.0))
        if error > EQUILIBRIUM:
            raise ModelError(
                f"model: elimination leaves equilibrium of the punch with an error of {error:.1e}; materials, sizes or elements differ too much: "
                "bring the stiffness of the two bodies, the lengths, or the element sizes closer together"
            )
        S = S - rigid @ (rigid.T @ S)
        return np.asarray(S - (S @ rigid) @ rigid.T), np.asarray(R - rigid @ excess)

    def _forces(self, bodies: GluedBodies, case: str) -> Array:
        forces = np.zeros(bodies.size)
        for part in self.loads[case]:
            forces += bodies.scattered(part.body, self.body(part.body).force(part))
        return forces

    def _check_interface(self) -> None:
        punch, block = (self.body(name).mesh.p[:, self.interface_nodes(name)] for name in ("punch", "block"))
        if punch.shape != block.shape:
            raise ModelError(f"interface: {punch.shape[1]} nodes on the punch, {block.shape[1]} on the block; mesh both with the same nodes")
        length = np.ptp(block[0])
        distance = np.hypot(*(punch - block))
        if distance.max() > SAME_POINT * length:
            i = int(distance.argmax())
            raise ModelError(
                f"interface: node {i} is at {tuple(map(float, punch[:, i]))} on the punch, at {tuple(map(float, block[:, i]))} on the block; "
                "mesh both with the same nodes"
            )
        if np.ptp(block[1]) > SAME_POINT * length:
            raise ModelError(f"interface: y varies by {np.ptp(block[1]):g} along it; turn the meshes so that it is straight and parallel to x")
        for name, body, side, other in (("punch", self.punch, 1.0, "below"), ("block", self.block, -1.0, "above")):
            mesh = body.mesh
            centres = mesh.p[1, mesh.t[:, mesh.f2t[0, mesh.boundaries[self.interface]]]].mean(axis=0)
            if np.any(side * (centres - block[1].mean()) <= 0):
                raise ModelError(f"{name}: it lies {other} the interface; the punch is the upper body, the block the lower one")

    def _check_supports(self) -> None:
        contact = self.interface_nodes("punch")
        for support in self.supports:
            if support.body == "punch" and np.isin(self._support_nodes(support), contact).any():
                raise ModelError(f"supports: {support} holds nodes of the punch on the interface; hold it elsewhere, or hold the block there")
        held = 3 - self._free_motions(self.supports).shape[1]
        if held < 3:
            raise ModelError(f"supports: they prevent {held} of the 3 rigid motions of the glued bodies; hold two displacements and the rotation")

    def _free_motions(self, supports: Sequence[Support]) -> Array:
        """(3, k) rigid motions that some supports allow: displacements x, y of the middle of the interface, and turn times its length."""
        contact = self.block.mesh.p[:, self.interface_nodes("block")]
        rows = [np.zeros((1, 3))]
        for support in supports:
            points = self.body(support.body).mesh.p[:, self._support_nodes(support)]
            x, y = np.split(_rigid_motions(points, contact), 2)
            rows += [{"x": x, "y": y}[direction] for direction in support.directions]
        rigid = np.concatenate(rows)
        scale = np.maximum(np.abs(rigid).max(axis=0), 1.0)  # supports far away turn over long arms
        return np.asarray(null_space(rigid / scale, rcond=SAME_POINT) / scale[:, None])


def _rigid_motions(points: Array, contact: Array) -> Array:
    """(2n, 3) displacements x, then y, of n points in the rigid motions of `_free_motions`, with respect to the nodes of the interface."""
    arm = (points - contact.mean(axis=1)[:, None]) / np.ptp(contact[0])
    one, zero = np.ones_like(arm[0]), np.zeros_like(arm[0])
    return np.concatenate([np.array([one, zero, -arm[1]]).T, np.array([zero, one, arm[0]]).T])
