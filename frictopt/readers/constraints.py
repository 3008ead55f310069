"""Held and dependent displacements of a deck, and the unknowns that take loads on them."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.sparse import csr_matrix

from ..base import ROUNDING, Array, Booleans, Integers
from ..errors import ModelError


@dataclass(frozen=True, eq=False)
class Constraints:
    """Held displacements and rotations, and those that follow others.

    Unknowns 6 i to 6 i + 5 are the displacements and rotations of node i. `*BOUNDARY` holds some;
    `*EQUATION` lets some follow others.
    """

    # (nodes, 6) whether an unknown is held
    held: Booleans
    # (m, 2) an unknown that follows, and one that it follows
    ends: Integers = field(default_factory=lambda: np.zeros((0, 2), dtype=np.intp))
    # (m,) how much it follows
    weights: Array = field(default_factory=lambda: np.zeros(0))
    # keywords whose equations are not in the deck
    unresolved: tuple[str, ...] = ()

    def passed_on(self, forces: Array, present: Booleans, numbers: Integers) -> Array:
        """Forces and moments (nodes, 6), moved from unknowns that follow others to these.

        `present` (nodes, 6) are the unknowns of the matrix, `numbers` those of the nodes.
        """
        missing = ~(present | self.held).ravel()
        in_use = missing[self.ends[:, 0]]
        followers, leaders = self.ends[in_use].T
        size = forces.size
        follow = csr_matrix((self.weights[in_use], (followers, leaders)), shape=(size, size))
        follows = np.zeros(size, dtype=bool)
        follows[followers] = True

        moved = forces.ravel()
        # A chain of unknowns that follow each other has at most this length.
        for _ in followers:
            on_followers = np.where(follows, moved, 0.0)
            if not on_followers.any():
                break
            moved = np.where(follows, 0.0, moved) + follow.T @ on_followers

        lost = missing & (np.abs(moved) > ROUNDING * np.abs(forces).max(initial=0.0))
        if lost.any():
            node, axis = divmod(int(lost.argmax()), 6)
            raise ModelError(self._lost(int(numbers[node]), axis + 1))
        return np.asarray(moved.reshape(forces.shape))

    def _lost(self, node: int, direction: int) -> str:
        reason = "give the deck of the same job"
        if self.unresolved:
            reason = f"the deck has {', '.join(self.unresolved)}"
        return (
            f"force: it acts on node {node}, direction {direction}, which is neither in the "
            f"matrix nor in *BOUNDARY, and no *EQUATION determines it ({reason}); load nodes that "
            "follow no others, write the constraint as *EQUATION, or merge tied nodes"
        )

    def following(self, ends: Integers, weights: Array) -> "Constraints":
        """These constraints, with more unknowns that follow others."""
        return replace(
            self,
            ends=np.concatenate([self.ends, ends]),
            weights=np.concatenate([self.weights, weights]),
        )
