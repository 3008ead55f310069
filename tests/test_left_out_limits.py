"""Limits of mirror-symmetric contacts are solved by half of them, and the answer is that of the whole contact."""

from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from frictopt.limits.mirrors import half_of, images_of
from frictopt.limits.question import pose
from systems import mirrored as symmetric

SYSTEMS = pytest.mark.parametrize("seed", range(12))


def scene(seed):
    """A random symmetric contact of 2 to 9 nodes, gaps in half of the cases, with its cycle, friction and slip bound."""
    rng = np.random.default_rng(seed)
    nodes = 2 + seed % 8
    contact = symmetric(rng, nodes, gap=seed % 2 == 0, coupling=rng.uniform(0.2, 1.0))
    corners = [{"one": rng.normal(), "other": rng.normal()} for _ in range(rng.integers(1, 4))]
    friction, most = rng.uniform(0.0, 0.8, nodes) * (rng.random(nodes) < 0.9), rng.uniform(0.1, 3.0, nodes)
    most = (most + most[::-1]) / 2 if seed % 3 else None
    return contact, fo.LoadCycle({"mean": 1.0}, corners), (friction + friction[::-1]) / 2, most


def agree(lean, full, *names):
    assert any("mirror" in text for text in lean.record.left_out) and not any("mirror" in text for text in full.record.left_out)
    for name in names:
        assert getattr(lean, name) == pytest.approx(getattr(full, name), rel=1e-8, abs=1e-10, nan_ok=True)


@SYSTEMS
def test_the_limit_of_the_half_is_that_of_the_whole(seed):
    contact, cycle, friction, most = scene(seed)
    lean, full = (fo.shakedown_limit(contact, cycle, friction, slip_bound=most, simplify=simplify) for simplify in (True, False))
    agree(lean, full, "load_factor", "bound")
    assert lean.kind is full.kind
    if lean.kind is fo.LimitKind.FINITE and not lean.open.any():
        assert lean.slip == pytest.approx(-lean.slip[::-1]) and lean.mechanism.share.sum() == pytest.approx(1.0)
        assert lean.friction_rate == pytest.approx(lean.friction_rate[::-1])


@SYSTEMS
@pytest.mark.parametrize("factor", [0.0, 0.5, 1.5])
def test_the_margin_of_the_half_is_that_of_the_whole(seed, factor):
    contact, cycle, friction, most = scene(seed)
    lean, full = (fo.safe_slip(contact, cycle, friction, factor, slip_bound=most, simplify=simplify) for simplify in (True, False))
    agree(lean, full, "margin", "bound")
    assert lean.exists is full.exists and (lean.certificate is None) is lean.exists


@SYSTEMS
def test_nodes_on_both_bounds_are_those_of_the_whole(seed):
    contact, cycle, friction, most = scene(seed)
    lean, full = (fo.guaranteed_limit(contact, cycle, friction, slip_bound=most, simplify=simplify) for simplify in (True, False))
    assert lean.load_factor == pytest.approx(full.load_factor, rel=1e-8, nan_ok=True) and lean.kind is full.kind


def test_a_middle_node_alone_limits_the_load():
    """Little friction in the middle: it cannot slip in a symmetric state, but lifts off at load factor 1; no node else feels the load."""
    one, friction = np.eye(3), [0.5, 0.001, 0.5]
    cases = {"mean": ([0, 0, 0], [1, 1, 1]), "lift": ([0, 0, 0], [0, -1, 0]), "shear": ([0.5, 0, -0.5], [0, 0, 0])}
    contact = fo.ContactSystem.from_blocks(one, np.diag([0.1, 0.0, -0.1]), one, [0.0, 1.0, 2.0], cases)
    for other in ({"mean": 0.0}, {"shear": 0.1}):
        cycle = fo.LoadCycle({"mean": 1.0}, [{"lift": 1.0}, other])
        for simplify in (True, False):
            limit = fo.shakedown_limit(contact, cycle, friction, simplify=simplify)
            assert limit.load_factor == pytest.approx(1.0) and set(limit.mechanism.node) == {1}
            assert fo.safe_slip(contact, cycle, friction, 1.0, simplify=simplify).margin == pytest.approx(0.0, abs=1e-10)


def test_what_is_not_symmetric_is_not_halved():
    contact, even, cycle = symmetric(np.random.default_rng(7), 5), np.full(5, 0.4), fo.LoadCycle({"mean": 1.0}, [{"one": 1.0}, {"other": 1.0}])
    uneven, tilt, task = even + 1e-12 * np.arange(5), 1 + 1e-11 * np.arange(5), pose(contact, cycle, even, slip_bound=even)
    assert images_of(task) and half_of(replace(task, simplify=False)).whole is None
    q, p = contact.reaction({"mean": 1.0})
    for change in ({"friction": uneven}, {"most": uneven}, {"p0": (p * tilt)[None]}, {"q0": (q + 1e-11)[None]}):
        assert not images_of(replace(task, **change))
    A = contact.A + 1e-12 * np.diag([1.0, 0, 0, 0, 0]) * np.abs(contact.A).max()
    assert not images_of(replace(task, system=fo.ContactSystem.from_blocks(A, contact.B, contact.C, contact.x, contact.bonded)))
    one = fo.ContactSystem.from_blocks([[1.0]], [[0.0]], [[1.0]], [0.0], {"P": ([0.0], [1.0])})
    assert not images_of(pose(one, fo.LoadCycle({"P": 1.0}, [{"P": 0.1}]), 0.4))
