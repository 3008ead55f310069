"""Small contacts with stresses at points, for the tests of fatigue parameters."""

from itertools import combinations
from types import SimpleNamespace

import numpy as np

import frictopt as fo

TO_FRO = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
TURNING = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}, {"Q": 0.3, "T": 1.0}])
WEIGHTS = {"findley": 0.3, "crossland": 0.3, "fatemi_socie": 0.3}


def plane_strain(rng, *shape):
    """(..., 2, points, 3, 3) random stress in a section, and the strain of it."""
    stress = rng.normal(size=(*shape, 3, 3))
    stress = stress + stress.swapaxes(-1, -2)
    stress[..., 2] = stress[..., 2, :] = 0.0
    stress[..., 2, 2] = 0.3 * np.trace(stress, axis1=-2, axis2=-1)
    pressure = 0.3 * np.trace(stress, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    return np.stack([stress, 1.3 * stress - pressure], axis=-4)


def random_contact(seed, coupling=0.1, gap=(0.0, 0.0, 0.0)):
    """A contact of three nodes, and random stresses at three points."""
    rng = np.random.default_rng(seed)
    X, Y = rng.normal(size=(2, 3, 3))
    A, C = X @ X.T + np.eye(3), Y @ Y.T + np.eye(3)
    loads = {
        "P": (0.1 * rng.normal(size=3), 1 + rng.random(3)),
        "Q": (rng.normal(size=3), 0.2 * rng.normal(size=3)),
        "T": (rng.normal(size=3), 0.2 * rng.normal(size=3)),
    }
    B = coupling * rng.normal(size=(3, 3))
    contact = fo.ContactSystem.from_blocks(A, B, C, np.arange(3.0), loads, gap)
    cases = {name: plane_strain(rng, 3) for name in loads}
    return fo.results.StressMap(contact, np.zeros((3, 2)), cases, plane_strain(rng, 6, 3))


def vertices(contact, cycle, friction, load_factor):
    """All vertices of the safe slips of three closed nodes."""
    rows, right = [], []
    for loads in cycle.at(load_factor):
        q, p = contact.reaction(loads)
        for sign in (1, -1):
            rows.append(sign * contact.A - friction * contact.B)
            right.append(friction * p - sign * q)
    rows, right = np.vstack(rows), np.concatenate(right)
    found = []
    for three in combinations(range(len(rows)), 3):
        if np.linalg.cond(rows[list(three)]) > 1e10:
            continue  # rows of one node at different corners
        slip = np.linalg.solve(rows[list(three)], right[list(three)])
        if (rows @ slip <= right + 1e-9).all():
            found.append(slip)
    return np.array(found)


def parameters(stresses, cycle, load_factor, slip):
    """The table of fretting, with the stresses of the points of a slip as those of the nodes."""
    states = [stresses.tensors(loads, slip) for loads in cycle.at(load_factor)]
    fields = [SimpleNamespace(tensors_at_contact=lambda side, s=s: s) for s in states]
    steady = fo.steady_state(stresses.system, TO_FRO, 0.5, 0.0)
    return steady.fretting_table(fields=fields, **WEIGHTS)


def held_node(coupling=0.0, opposed=None):
    """One held node with A = 1, p = 2, and the stress 2 v + load / 2 and the strain of the load.

    A second point has the stress `opposed` - 2 v + load / 2.
    """
    loads = {"P": ([0.0], [2.0]), "Q": ([1.0], [0.0])}
    contact = fo.ContactSystem.from_blocks([[1.0]], [[coupling]], [[9.0]], [0.0], loads)
    count = 1 if opposed is None else 2
    motions = np.zeros((2, 2, count, 3, 3))
    motions[0, 0, :, 0, 0] = [2.0, -2.0][:count]
    moving = np.zeros((2, count, 3, 3))
    moving[:, :, 0, 0] = [[0.5], [1.0]]
    still = np.zeros((2, count, 3, 3))
    still[0, 1:, 0, 0] = opposed
    cases = {"P": still, "Q": moving}
    return fo.results.StressMap(contact, np.zeros((count, 2)), cases, motions)
