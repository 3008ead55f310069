"""Condensation of three bodies and two inclined contacts, against a factorisation by scipy.

The matrices have the size of a dovetail. The rival factorises the stiffness of the glued bodies,
assembled by scikit-fem. The rival does not compute the stiffness of the interface.
"""

import numpy as np
import pytest
from scipy.sparse import block_diag, csr_matrix, identity
from scipy.sparse.linalg import splu
from skfem import Basis, ElementQuad1, ElementVector, MeshQuad
from skfem.models.elasticity import lame_parameters, linear_elasticity

import frictopt as fo
from studies.validation.error_vs_time.condensation import ORDERINGS

# MMD_AT_PLUS_A is the best of scipy's orderings here.
MOST = {"COLAMD": 1.5, "MMD_AT_PLUS_A": 3.0}


def level(bottom, top, elements, sides):
    """Quadrilaterals between two level segments at heights 0 and 1; `sides` renames their sides."""
    mesh = MeshQuad.init_tensor(*(np.linspace(0, 1, number + 1) for number in elements))
    where = {
        "left": lambda x: x[0] == 0,
        "right": lambda x: x[0] == 1,
        "top": lambda x: x[1] == 1,
    }
    mesh = mesh.with_boundaries({name: where[side] for side, name in sides.items()})
    s, t = mesh.p
    across = [(1 - s) * one + s * other for one, other in (bottom, top)]
    return MeshQuad(np.array([(1 - t) * across[0] + t * across[1], t]), mesh.t).with_boundaries(
        mesh.boundaries
    )


@pytest.fixture(scope="module")
def model():
    """A wedge between two jaws, with flanks at 60 degrees to the horizontal."""
    half = 0.5 + 1 / np.tan(np.pi / 3)
    flanks = {"left": "left flank", "right": "right flank", "top": "top"}
    bodies = {
        "wedge": level((-0.5, 0.5), (-half, half), (60, 124), flanks),
        "left jaw": level(
            (-2.0, -0.5), (-2.0, -half), (80, 124), {"left": "wall", "right": "flank"}
        ),
        "right jaw": level((0.5, 2.0), (half, 2.0), (80, 124), {"left": "flank", "right": "wall"}),
    }
    jaws = ("left", "right")
    return fo.fem.ContactModel(
        bodies={name: fo.fem.Body(mesh) for name, mesh in bodies.items()},
        contacts=[fo.fem.Contact("wedge", f"{jaw} jaw", f"{jaw} flank", "flank") for jaw in jaws],
        supports=[fo.fem.Support(f"{jaw} jaw", "wall") for jaw in jaws],
        loads={
            "P": [fo.fem.Traction("wedge", "top", 0.0, -1.0)],
            "Q": [fo.fem.Traction("wedge", "top", 0.0, -1.0)],
        },
    )


@pytest.fixture(scope="module")
def given(model):
    """Arguments of `condense`."""
    bases = [Basis(body.mesh, ElementVector(ElementQuad1())) for body in model.bodies.values()]
    starts = np.cumsum([0] + [basis.N for basis in bases])
    unknowns = np.concatenate(
        [start + basis.nodal_dofs.T for start, basis in zip(starts[:-1], bases, strict=True)]
    )
    points = np.concatenate([basis.mesh.p.T for basis in bases])
    first = len(bases[0].mesh.p.T)
    pairs, normals = [], []
    for number, (side, across) in enumerate((("left", 1.0), ("right", -1.0)), start=1):
        one = bases[0].mesh.facets[:, bases[0].mesh.boundaries[f"{side} flank"]]
        two = bases[number].mesh.facets[:, bases[number].mesh.boundaries["flank"]]
        one, two = (
            nodes[np.argsort(points[nodes, 1])]
            for nodes in (np.unique(one), first + np.unique(two))
        )
        pairs.append(np.column_stack([one, two])[:: -int(across)])
        normals.append(np.tile([across * np.sin(np.pi / 3), np.cos(np.pi / 3)], (len(one), 1)))
        first += bases[number].mesh.p.shape[1]
    force = np.zeros(starts[-1])
    force[unknowns[points[:, 1] == 1.0, 1]] = -1.0
    return {
        "K": block_diag(
            [linear_elasticity(*lame_parameters(1.0, 0.3)).assemble(basis) for basis in bases],
            format="csr",
        ),
        "loads": {"P": force, "Q": force},
        "pairs": np.concatenate(pairs),
        "normals": np.concatenate(normals),
        "unknowns": unknowns,
        "points": points,
        "held": unknowns[np.abs(points[:, 0]) == 2.0].ravel(),
        "contact": ["left"] * len(pairs[0]) + ["right"] * len(pairs[1]),
    }


@pytest.fixture(scope="module")
def whole(given):
    """The stiffness of the glued bodies in the order of their meshes."""
    size = given["K"].shape[0]
    image = np.arange(size)
    image[given["unknowns"][given["pairs"][:, 0]]] = given["unknowns"][given["pairs"][:, 1]]
    same = csr_matrix((np.ones(size), (np.arange(size), image)), shape=(size, size)) @ identity(
        size, format="csr"
    )
    free = np.setdiff1d(image, given["held"])
    return (same.T @ given["K"] @ same)[free][:, free].tocsc()


@pytest.mark.parametrize("ordering", ORDERINGS)
def test_condensation_against_one_factorisation(compare, given, whole, ordering):
    assert whole.shape[0] > 54_000 and len(given["pairs"]) == 250
    ratio = compare(
        lambda: fo.condense(**given), lambda: splu(whole, **ORDERINGS[ordering]), rounds=5
    )
    assert ratio < MOST[ordering]


def test_the_model_gives_the_same_contact(model, given):
    system, other = fo.condense(**given), model.condense()
    assert np.abs(system.S - other.S).max() < 1e-9 * np.abs(other.S).max()
