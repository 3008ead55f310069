"""Condensation: its rounding, and the error of the mesh at the singular corner.

The rounding is measured against scikit-fem and scipy on the same mesh.
"""

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import block_diag, csr_matrix, hstack, identity
from scipy.sparse.linalg import splu
from skfem import Basis, ElementQuad1, ElementVector
from skfem.models.elasticity import lame_parameters, linear_elasticity

import frictopt as fo
from frictopt.reference import bonded_corner
from studies.validation.error_vs_time.methods import Method, Question
from studies.validation.error_vs_time.parameters import Parameters

Array = np.ndarray[Any, Any]
Blocks = tuple[Any, Any, Array]

ORDERINGS: dict[str, dict[str, Any]] = {
    # The default of scipy.
    "COLAMD": {"permc_spec": "COLAMD"},
    "MMD_AT_PLUS_A": {
        "permc_spec": "MMD_AT_PLUS_A",
        "diag_pivot_thresh": 0.0,
        "options": {"SymmetricMode": True},
    },
}
"""Orderings of scipy's sparse factorisation, with the options that suit each."""

# Number of right-hand sides that are refined at once; more need too much memory.
_COLUMNS = 64
# Number of solutions with residuals in extended precision. Each gains about ten digits.
_ROUNDS = 3


def assembled(scene: fo.scenes.PunchOnHalfPlane) -> Blocks:
    """The glued stiffness of a scene on rollers by scikit-fem alone, on the meshes of the package.

    Unknowns are the displacements of the block and of the punch off the interface. On the interface
    of the punch they are the displacements relative to the block, which are kept: first all in x,
    then all in y.

    Returns
    -------
    tuple
        Stiffness of the eliminated unknowns, its coupling to the kept unknowns, and the stiffness of
        the kept unknowns.
    """
    model = scene.model()
    block, K_block = _stiffness(model.bodies["block"])
    punch, K_punch = _stiffness(model.bodies["punch"])
    below = block.nodal_dofs[:, _contact(block.mesh)].ravel()
    kept = punch.nodal_dofs[:, _contact(punch.mesh)].ravel()
    follows = csr_matrix((np.ones(len(kept)), (kept, below)), shape=(punch.N, block.N))
    motion = hstack([follows, identity(punch.N)]).tocsr()
    K = (
        block_diag([K_block, csr_matrix((punch.N, punch.N))]) + motion.T @ K_punch @ motion
    ).tocsr()
    bottom = block.mesh.p[1] == -scene.block_depth
    held = np.r_[block.nodal_dofs[1, bottom], block.nodal_dofs[0, bottom & (block.mesh.p[0] == 0)]]
    kept = block.N + kept
    free = np.setdiff1d(np.arange(K.shape[0]), np.r_[held, kept])
    return K[free][:, free].tocsc(), K[free][:, kept], K[kept][:, kept].toarray()


def _contact(mesh: Any) -> Any:
    """Nodes on the contact, in the order of x."""
    nodes = np.unique(mesh.facets[:, mesh.boundaries["contact"]])
    return nodes[np.argsort(mesh.p[0, nodes])]


def _stiffness(body: fo.fem.Body) -> tuple[Any, Any]:
    """The basis and the stiffness of a body."""
    basis = Basis(body.mesh, ElementVector(ElementQuad1()))
    form = linear_elasticity(*lame_parameters(body.material.E, body.material.nu))
    return basis, form.assemble(basis)


def multiple_right_hand_sides(blocks: Blocks, ordering: str) -> Array:
    """Stiffness of the kept unknowns by usual code with scipy: one solution for each kept unknown."""
    K_ii, K_ir, K_rr = blocks
    return np.asarray(K_rr - K_ir.T @ splu(K_ii, **ORDERINGS[ordering]).solve(K_ir.toarray()))


def refined_stiffness(blocks: Blocks) -> Array:
    """Stiffness of the kept unknowns, with solutions refined by residuals in extended precision.

    The extended precision is numpy's longdouble, with 64 bits of mantissa on x86.
    """
    K_ii, K_ir, K_rr = blocks
    factors = splu(K_ii, **ORDERINGS["MMD_AT_PLUS_A"])
    exact = K_ii.tocsr().astype(np.longdouble)
    columns = []
    for first in range(0, K_ir.shape[1], _COLUMNS):
        right = K_ir[:, first : first + _COLUMNS].toarray().astype(np.longdouble)
        solution = np.zeros_like(right)
        for _ in range(_ROUNDS):
            solution = solution + factors.solve((right - exact @ solution).astype(float))
        columns.append(K_ir.T.astype(np.longdouble) @ solution)
    return np.asarray(K_rr - np.hstack(columns))


def corner_exponent(system: fo.ContactSystem, corner_size: float) -> float:
    """Exponent of the stronger singular mode of the bonded corner, from the load case "P".

    P and Q are the normal and shear forces between the corner and the distance r. The ratio r2 of
    shear to pressure of the weaker mode removes this mode: `P r2 - Q` contains only the stronger
    mode, and grows as a power of r. The exponent is fitted from half to twice the geometric mean of
    the size of the corner element and the half-width a. This range has many elements and is close
    to the corner.
    """
    q, p = system.bonded["P"]
    r = (system.x[1:] + system.x[:-1]) / 2 - system.x[0]
    pressed = np.cumsum(p)[:-1]
    sheared = np.cumsum(q)[:-1]
    middle = np.sqrt(corner_size * system.x[-1])
    near = (r > middle / 2) & (r < middle * 2)
    alone = np.abs(pressed * bonded_corner()[1].traction_ratio - sheared)
    return float(np.polyfit(np.log(r[near]), np.log(alone[near]), 1)[0])


def questions(parameters: Parameters) -> Iterator[Question]:
    """Rounding of the elimination on each mesh, and the corner exponent over all meshes."""
    for elements in parameters.elements:
        yield _elimination(elements)
    exact = bonded_corner()[0].exponent
    methods = []
    for grading in parameters.mesh_gradings:
        for elements in parameters.mesh_elements:
            scene = fo.scenes.PunchOnHalfPlane(elements=elements, grading=grading)
            error = partial(_exponent_error, exact, scene.corner_size)
            methods.append(
                Method(
                    "frictopt",
                    f"elements, grading {grading:g}",
                    f"{elements}",
                    scene.condense,
                    error,
                )
            )
    # The reference is the exponent 0.5445 of the bonded corner of a square punch, a closed
    # form. The reactions near the corner must have it.
    yield Question("condensation", "corner exponent", "paper's scene, any mesh", 0, methods)


def _elimination(elements: int) -> Question:
    """The stiffness of the scene by several orderings."""
    scene = fo.scenes.PunchOnHalfPlane(elements=elements)
    error = partial(_stiffness_error, refined_stiffness(assembled(scene)))
    methods = [
        Method(
            "frictopt",
            "ordering",
            "nested dissection",
            scene.condense,
            lambda system: error(system.S),
        )
    ]
    for ordering in ORDERINGS:
        run = partial(_plain, scene, ordering)
        methods.append(
            Method(
                "scipy, one right-hand side each", "ordering", ordering, run, error, rival="scipy"
            )
        )
    # The reference refines the same solutions by residuals in extended precision.
    return Question(
        "condensation", "stiffness S", f"paper's scene, {elements} elements", elements + 1, methods
    )


def _plain(scene: fo.scenes.PunchOnHalfPlane, ordering: str) -> Array:
    """The stiffness of the scene by usual code with scipy."""
    return multiple_right_hand_sides(assembled(scene), ordering)


def _stiffness_error(exact: Array, S: Array) -> float:
    return float(np.abs(S - exact).max() / np.abs(exact).max())


def _exponent_error(exact: float, corner_size: float, system: fo.ContactSystem) -> float:
    return abs(corner_exponent(system, corner_size) / exact - 1)
