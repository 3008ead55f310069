"""Small contacts in three dimensions for the tests."""

import numpy as np
from scipy.sparse import block_diag, csr_matrix
from skfem import MeshHex, MeshQuad

import frictopt as fo
from frictopt.contact.parts import joined
from frictopt.fem.elasticity import body_stiffness

CORNERS = ({"a": 1.0}, {"a": -1.0}, {"b": 0.7, "c": 0.2})


def single(*, friction_bound=1.0):
    """One node with unit stiffness and the load cases P, X and Y."""
    return fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, friction_bound], "X": [1, 0, 0], "Y": [0, 1, 0]})


def random_contact(rng, nodes, coupling=0.5, stiffness=1.0):
    """Coupled contact with a well-conditioned S; the load case "mean" presses, a, b and c are random."""
    G = rng.normal(size=(3 * nodes, 3 * nodes))
    S = stiffness * (G @ G.T / (3 * nodes) + 0.3 * np.eye(3 * nodes))
    S[: 2 * nodes, 2 * nodes :] *= coupling
    S[2 * nodes :, : 2 * nodes] *= coupling
    bonded = {name: np.r_[rng.normal(size=2 * nodes), 0.3 * rng.normal(size=nodes)] for name in "abc"}
    bonded["mean"] = np.r_[0.1 * rng.normal(size=2 * nodes), rng.uniform(0.5, 1.5, size=nodes)]
    return fo.ContactSystem(S, rng.normal(size=(nodes, 3)), bonded)


def vectors(contact):
    """Load case name -> bonded reactions in the order of S."""
    return {name: joined(*pair) for name, pair in contact.bonded.items()}


def cycle(corners=3):
    return fo.LoadCycle({"mean": 1.0}, CORNERS[:corners])


X = np.array([-1.0, -0.8, -0.4, 0.0, 0.4, 0.8, 1.0])
WIDE = np.r_[-4.0, -2.5, -1.5, X, 1.5, 2.5, 4.0]
UP, DOWN = np.array([0.0, 0.3, 0.8, 1.5]), np.array([-3.0, -1.2, -0.4, 0.0])
LOADS = {"P": ("punch", "top", (0.0, -1.0)), "Q": ("punch", "top", (1.0, 0.0))}


def strip(thickness):
    """A plane-strain strip of hexahedra, one element thick and periodic across it, and the plane contact of the same mesh."""
    plane = {"punch": MeshQuad.init_tensor(X, UP), "block": MeshQuad.init_tensor(WIDE, DOWN)}
    solid = {"punch": MeshHex.init_tensor(X, [0.0, thickness], UP), "block": MeshHex.init_tensor(WIDE, [0.0, thickness], DOWN)}
    materials = {"punch": fo.Material(2.0, 0.25), "block": fo.Material(1.0, 0.35)}
    faces = {"contact": lambda x: (x[-1] == 0) & (abs(x[0]) < 1), "top": lambda x: x[-1] == UP[-1], "bottom": lambda x: x[-1] == DOWN[0]}
    bodies = {name: fo.Body(mesh.with_boundaries(faces), materials[name]) for name, mesh in plane.items()}
    loads = {"P": [fo.Traction("punch", "top", y=-1.0)], "Q": [fo.Traction("punch", "top", x=1.0)]}
    flat = fo.ContactModel(bodies, [fo.Support("block", "bottom")], loads).condense()

    merged, points, unknowns, first = [], [], [], 0
    for name, mesh in solid.items():
        nodes = mesh.p.shape[1]
        front = np.flatnonzero(mesh.p[1] == 0)
        place = {(x, z): k for k, (x, z) in enumerate(mesh.p[[0, 2]][:, front].T)}
        own = np.array([place[x, z] for x, z in mesh.p[[0, 2]].T])
        merge = csr_matrix((np.ones(nodes), (np.arange(nodes), own)))
        T = block_diag([merge] * 3)
        forces = {}
        for case, (body, boundary, (x, z)) in LOADS.items():
            mesh_with = mesh.with_boundaries(faces)
            force = fo.Traction(body, boundary, x=x, z=z)._forces(fo.Body(mesh_with), "space") if body == name else np.zeros((3, nodes))
            forces[case] = T.T @ force.ravel()
        count = len(front)
        merged.append((T.T @ body_stiffness(mesh, materials[name], kinematics="space") @ T, forces))
        points.append(mesh.p[:, front].T)
        unknowns.append(first + np.arange(count)[:, None] + count * np.arange(3))
        first += 3 * count
    where, rows = np.concatenate(points), np.concatenate(unknowns)
    upper = np.arange(len(where)) < len(points[0])
    touching = (where[:, 2] == 0) & (abs(where[:, 0]) <= 1)
    pairs = [np.flatnonzero(touching & side)[np.argsort(where[touching & side, 0])] for side in (upper, ~upper)]
    solid_system = fo.condense(
        block_diag([K for K, _ in merged], format="csr"),
        {case: np.concatenate([forces[case] for _, forces in merged]) for case in LOADS},
        np.column_stack(pairs),
        [0.0, 0.0, 1.0],
        rows,
        where,
        held=rows[where[:, 2] == DOWN[0]].ravel(),
    )
    return flat, solid_system
