"""Small contacts in three dimensions for the tests."""

import numpy as np

import frictopt as fo
from frictopt.contact import joined

CORNERS = ({"a": 1.0}, {"a": -1.0}, {"b": 0.7, "c": 0.2})


def single(*, friction_bound=1.0):
    """One node with unit stiffness and the load cases P, X and Y."""
    return fo.ContactSystem(
        np.eye(3), [[0, 0, 0]], {"P": [0, 0, friction_bound], "X": [1, 0, 0], "Y": [0, 1, 0]}
    )


def random_contact(rng, nodes, coupling=0.5, stiffness=1.0):
    """A coupled contact with a well-conditioned S.

    The load case "mean" presses, and a, b and c are random.
    """
    G = rng.normal(size=(3 * nodes, 3 * nodes))
    S = stiffness * (G @ G.T / (3 * nodes) + 0.3 * np.eye(3 * nodes))
    S[: 2 * nodes, 2 * nodes :] *= coupling
    S[2 * nodes :, : 2 * nodes] *= coupling
    bonded = {
        name: np.r_[rng.normal(size=2 * nodes), 0.3 * rng.normal(size=nodes)] for name in "abc"
    }
    bonded["mean"] = np.r_[0.1 * rng.normal(size=2 * nodes), rng.uniform(0.5, 1.5, size=nodes)]
    return fo.ContactSystem(S, rng.normal(size=(nodes, 3)), bonded)


def flat_body(points):
    """A rigid body on nodes of the plane z = 0 that nothing else holds."""
    x, y = points.T
    n, zero = len(x), np.zeros(len(x))
    one = zero + 1
    v1, v2 = [one, zero, zero, -y, zero, zero], [zero, one, zero, x, zero, zero]
    w = [zero, zero, one, zero, y, -x]
    motions = np.hstack([v1, v2, w]).T
    S = np.eye(3 * n) - motions @ np.linalg.pinv(motions)
    loads = {
        "P": np.r_[zero, zero, one / n],
        "push": np.r_[-one / n, zero, zero],
        "torque": np.r_[y, -x, zero] / n,
        "moment": np.r_[zero, zero, x / n],
    }
    return fo.ContactSystem(S, np.column_stack([points, zero]), loads)


def vectors(contact):
    """Load case name -> bonded reactions in the order of S."""
    return {name: joined(*pair) for name, pair in contact.bonded.items()}


def cycle(corners=3):
    return fo.LoadCycle({"mean": 1.0}, CORNERS[:corners])


def thick(thickness):
    """A plane contact, and the same contact with a thickness in space.

    No load acts across the plane.
    """
    flat = fo.scenes.PunchOnHalfPlane(elements=6, growth=1.5).condense()
    n, none = flat.nodes, np.zeros((flat.nodes, flat.nodes))
    S = thickness * np.block(
        [[flat.A, none, flat.B.T], [none, flat.A, none], [flat.B, none, flat.C]]
    )
    loads = {name: thickness * np.r_[q, np.zeros(n), p] for name, (q, p) in flat.bonded.items()}
    return flat, fo.ContactSystem(S, np.column_stack([flat.x, np.zeros((n, 2))]), loads)
