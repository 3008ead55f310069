"""Contacts in space whose tangents and normals have stiffnesses of their own, over eight decades, judged by the entries of S."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.contact.parts import joined, parted
from frictopt.limits.question import pose
from spatial import cycle, random_contact, vectors


def graded(rng, nodes):
    """A random contact, and (3N,) by which the root of each direction's stiffness is multiplied."""
    contact, size = random_contact(rng, nodes, 1.0), 10.0 ** rng.uniform(-2, 2, 3 * nodes)
    return fo.ContactSystem(contact.S * np.outer(size, size), contact.points, dict(contact.bonded)), size


@pytest.mark.parametrize("seed", [4, 9, 20, 22])
def test_limits_of_directions_of_very_unlike_stiffness_are_found(seed):
    """Each tangent and normal has a stiffness of its own, over eight decades; the safe slip and the mechanism are judged by the entries of S."""
    rng = np.random.default_rng(seed)
    contact, size = graded(rng, int(rng.integers(4, 13)))
    f, n = rng.uniform(0.2, 1.5, contact.nodes), contact.nodes
    limit, loads = fo.shakedown_limit(contact, cycle(), f), vectors(contact)
    finite = np.isfinite(limit.load_factor)
    at, slip = (limit.load_factor, limit.slip) if finite else (1e3, fo.safe_slip(contact, cycle(), f, 1e3).slip)
    r = np.array([loads["mean"] + at * sum(by * loads[name] for name, by in corner.items()) for corner in cycle().corners])
    q, p = parted(r + contact.S[:, : 2 * n] @ slip.T.ravel(), 3)
    assert (np.linalg.norm(q, axis=-1) - f * p).max() <= 1e-8 * max(at, 1.0) * np.abs(loads["mean"][2 * n :]).mean()
    if finite:
        motion = limit._motion
        d, lift = np.split(motion.moves.sum(axis=0).ravel(), [2 * n])
        assert np.abs((contact.A @ d + contact.B.T @ lift) / size[: 2 * n]).max() <= 1e-8 * np.abs(lift * size[2 * n :]).max()
        resistance, drive = motion.work(pose(contact, cycle(), f))
        assert resistance / drive == pytest.approx(limit.load_factor, rel=1e-8)


@pytest.mark.parametrize("seed", [2, 13, 32, 86])
def test_increments_of_directions_of_very_unlike_stiffness_are_found(seed):
    rng = np.random.default_rng(seed)
    contact, _ = graded(rng, int(rng.integers(3, 13)))
    f, n = rng.uniform(0.05, 0.6, contact.nodes), contact.nodes
    load = joined(*contact.reaction({"mean": 1.0, "a": 0.3, "b": 0.3}))
    found = fo.increments.NewtonIncrement(contact, f).solve(np.zeros((n, 2)), parted(load, 3))
    q, p = parted(load + contact.S @ np.r_[found.slip.T.ravel(), found.gap], 3)
    force, slid = np.abs(load[2 * n :]).mean(), np.linalg.norm(found.slip, axis=1)
    assert max((np.linalg.norm(q, axis=1) - f * p).max(), -p.min(), (p * (found.gap > 0)).max()) <= 1e-8 * force
    opposed = np.sum(q * found.slip, axis=1) + f * p * slid  # friction opposes slip, with f p
    assert np.abs(opposed / np.where(slid > 0, slid, 1.0)).max() <= 1e-8 * force
