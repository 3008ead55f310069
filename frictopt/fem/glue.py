"""Two bodies glued along an interface, in the unknowns (glued nodes, relative motion of the interface)."""

from functools import cached_property
from typing import Literal

import numpy as np
from scipy.sparse import csr_matrix, identity

from ..contact.checks import Array
from .bodies import Body, BodyName
from .schur import schur_complement
from .elasticity import body_stiffness
from .ordering import Integers, nested_dissection

__all__ = ["GluedBodies"]


class GluedBodies:
    """Two bodies whose interface moves together, except for the relative motion `u_rel = [v, w]` of the punch.

    Unknowns: x, then y displacements of the glued nodes (the block's, then the punch's off the interface), then v, then w.

    Parameters
    ----------
    punch, block
        The bodies.
    punch_contact, block_contact
        (N,) nodes on the interface, pair by pair.
    """

    def __init__(self, punch: Body, block: Body, punch_contact: Integers, block_contact: Integers) -> None:
        nodes_block, nodes_punch = block.mesh.p.shape[1], punch.mesh.p.shape[1]
        own = np.setdiff1d(np.arange(nodes_punch), punch_contact)
        self._bodies = {"punch": punch, "block": block}
        self._glued = nodes_block + len(own)
        self._kept = 2 * len(punch_contact)
        self._points = np.column_stack([block.mesh.p, punch.mesh.p[:, own]])
        image = np.empty(nodes_punch, dtype=np.intp)  # glued node that each node of the punch moves with
        image[own] = nodes_block + np.arange(len(own))
        image[punch_contact] = block_contact
        self._image = {"punch": image, "block": np.arange(nodes_block)}
        self._relative = np.r_[punch_contact, nodes_punch + punch_contact]
        self.size = 2 * self._glued + self._kept

    @cached_property
    def _motion(self) -> dict[str, csr_matrix]:
        """Matrices that give each body's displacements from the unknowns."""
        unit = identity(self.size, format="csr")
        motion = {name: unit[np.r_[image, self._glued + image]] for name, image in self._image.items()}
        entries = (np.ones(self._kept), (self._relative, 2 * self._glued + np.arange(self._kept)))
        motion["punch"] = motion["punch"] + csr_matrix(entries, shape=motion["punch"].shape)
        return motion

    def unknowns(self, body: BodyName, nodes: Integers, directions: Literal["x", "y", "xy"]) -> Integers:
        """Unknowns that are the displacements of some nodes (off the punch's interface) in x, in y or in both."""
        image = self._image[body][nodes]
        return np.concatenate([image + self._glued * "xy".index(direction) for direction in directions])

    def scattered(self, body: BodyName, forces: Array) -> Array:
        """Forces on the unknowns from (2, nodes) nodal forces on one body."""
        return np.asarray(self._motion[body].T @ forces.ravel())

    def condense(self, forces: Array, held: Integers) -> tuple[Array, Array]:
        """Stiffness S (2N, 2N) of the relative motion, and the reactions R (2N, loads) that hold it at zero.

        Parameters
        ----------
        forces
            (size, loads) forces on the unknowns.
        held
            Unknowns that are zero.
        """
        stiffness = {name: body_stiffness(body.mesh, body.material, body.element) for name, body in self._bodies.items()}
        K = sum(motion.T @ stiffness[name] @ motion for name, motion in self._motion.items())
        nodes = nested_dissection(K[: self._glued, : self._glued], self._points)
        order = np.r_[np.column_stack([nodes, self._glued + nodes]).ravel(), 2 * self._glued + np.arange(self._kept)]
        return schur_complement(K, forces, order[~np.isin(order, held)], self._kept)
