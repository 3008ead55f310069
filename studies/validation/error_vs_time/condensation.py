"""Condensation: its rounding against scipy on the same matrix, and what the mesh does to the singular corner."""

from collections.abc import Iterator
from functools import partial
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
from scipy.sparse.linalg import splu

import frictopt as fo
from frictopt.fem.condense import schur_complement
from frictopt.fem.ordering import nested_dissection
from frictopt.reference import bonded_corner

from .parameters import Parameters
from .ways import Question, Way

__all__ = ["ORDERINGS", "Elimination", "corner_exponent", "elimination", "multiple_right_hand_sides", "questions", "refined_stiffness"]

Array = np.ndarray[Any, Any]

ORDERINGS: dict[str, dict[str, Any]] = {
    "COLAMD": {"permc_spec": "COLAMD"},  # scipy's default
    "MMD_AT_PLUS_A": {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}},
}
"""Orderings of scipy's sparse factorisation, with the options that suit each."""

_COLUMNS = 64  # right-hand sides refined at once, for the sake of memory
_ROUNDS = 3  # solutions with residuals in extended precision; each gains some ten digits


class Elimination(NamedTuple):
    """What the glued model of a scene hands to the elimination.

    Attributes
    ----------
    K
        Stiffness of all unknowns, sparse.
    forces
        Loads on them, a column each.
    order
        Free unknowns in elimination order, the kept ones last.
    kept
        Number of kept unknowns.
    graph
        Arguments of the ordering.
    """

    K: Any
    forces: Array
    order: Array
    kept: int
    graph: tuple[Any, ...]

    def ours(self) -> Array:
        """Stiffness of the kept unknowns by the package's ordering and elimination."""
        nested_dissection(*self.graph)
        return schur_complement(self.K, self.forces, self.order, self.kept)[0]

    @property
    def blocks(self) -> tuple[Any, Any, Array]:
        """Stiffness of the eliminated unknowns, its coupling to the kept ones, and the stiffness of those, in the unknowns' own order."""
        free, kept = np.sort(self.order[: -self.kept]), self.order[-self.kept :]
        return self.K[free][:, free].tocsc(), self.K[free][:, kept], self.K[kept][:, kept].toarray()


def elimination(scene: fo.PunchOnHalfPlane) -> Elimination:
    """The elimination that condenses a scene."""
    with (
        patch("frictopt.fem.glue.schur_complement", side_effect=schur_complement) as eliminates,
        patch("frictopt.fem.glue.nested_dissection", side_effect=nested_dissection) as orders,
    ):
        scene.condense()
    K, forces, order, kept = eliminates.call_args.args
    return Elimination(K, forces, order, kept, orders.call_args.args)


def multiple_right_hand_sides(blocks: tuple[Any, Any, Array], ordering: str) -> Array:
    """The same stiffness as most write it with scipy: one solution for each kept unknown."""
    K_ii, K_ir, K_rr = blocks
    return np.asarray(K_rr - K_ir.T @ splu(K_ii, **ORDERINGS[ordering]).solve(K_ir.toarray()))


def refined_stiffness(blocks: tuple[Any, Any, Array]) -> Array:
    """The same stiffness, each solution refined by residuals in numpy's extended precision (longdouble, 64 bits of mantissa on x86)."""
    K_ii, K_ir, K_rr = blocks
    factors, exact = splu(K_ii, **ORDERINGS["MMD_AT_PLUS_A"]), K_ii.tocsr().astype(np.longdouble)
    columns = []
    for first in range(0, K_ir.shape[1], _COLUMNS):
        right = K_ir[:, first : first + _COLUMNS].toarray().astype(np.longdouble)
        solution = np.zeros_like(right)
        for _ in range(_ROUNDS):
            solution = solution + factors.solve((right - exact @ solution).astype(float))
        columns.append(K_ir.T.astype(np.longdouble) @ solution)
    return np.asarray(K_rr - np.hstack(columns))


def corner_exponent(system: fo.ContactSystem, corner_size: float) -> float:
    """Exponent of the stronger singular mode of the bonded corner, fitted to the reactions under the load case "P".

    The weaker mode is taken out by its ratio of shear to pressure: `P r2 - Q`, with P and Q the forces between the corner and r, has the stronger
    one alone, and grows as r to its exponent. Fitted from half to twice the geometric mean of corner element and half-width a, which is many
    elements and still close to the corner.
    """
    q, p = system.bonded["P"]
    r = (system.x[1:] + system.x[:-1]) / 2 - system.x[0]
    pressed, sheared = np.cumsum(p)[:-1], np.cumsum(q)[:-1]
    middle = np.sqrt(corner_size * system.x[-1])
    near = (r > middle / 2) & (r < middle * 2)
    alone = np.abs(pressed * bonded_corner()[1].traction_ratio - sheared)
    return float(np.polyfit(np.log(r[near]), np.log(alone[near]), 1)[0])


def questions(parameters: Parameters) -> Iterator[Question]:
    """Rounding of the elimination on each mesh, and the corner exponent over all meshes."""
    for elements in parameters.elements:
        yield _elimination(elements)
    exact = bonded_corner()[0].exponent
    ways = []
    for grading in parameters.mesh_gradings:
        for elements in parameters.mesh_elements:
            scene = fo.PunchOnHalfPlane(elements=elements, grading=grading)
            error = partial(_exponent_error, exact, scene.corner_size)
            ways.append(Way("frictopt", f"elements, grading {grading:g}", f"{elements}", scene.condense, error, rest="assembly"))
    reference = "exponent 0.5445 of the bonded corner of a square punch (closed form), which the reactions near the corner must show"
    yield Question("condensation", "corner exponent", "paper's scene, any mesh", 0, reference, ways)


def _elimination(elements: int) -> Question:
    task = elimination(fo.PunchOnHalfPlane(elements=elements))
    blocks = task.blocks
    exact = refined_stiffness(blocks)
    error = partial(_stiffness_error, exact)
    ways = [Way("frictopt", "ordering", "nested dissection", task.ours, error, rest="condensation")]
    for ordering in ORDERINGS:
        run = partial(multiple_right_hand_sides, blocks, ordering)
        ways.append(Way("scipy, one right-hand side each", "ordering", ordering, run, error, rival="scipy", rest="condensation"))
    reference = "the same solutions refined by residuals in extended precision"
    return Question("condensation", "stiffness S", f"paper's scene, {elements} elements", elements + 1, reference, ways)


def _stiffness_error(exact: Array, S: Array) -> float:
    return float(np.abs(S - exact).max() / np.abs(exact).max())


def _exponent_error(exact: float, corner_size: float, system: fo.ContactSystem) -> float:
    return abs(corner_exponent(system, corner_size) / exact - 1)
