import numpy as np
import pytest
from scipy.linalg import block_diag

import frictopt as fo
from helpers.systems import CYCLE, FIRST_PAIR, all_closed, random_system, system


def limit_of(contact, friction, cycle=CYCLE, **options):
    return fo.shakedown_limit(contact, cycle, friction, **options).load_factor


def test_pressure_must_stay_where_there_is_no_friction():
    """A node without friction must keep its pressure: |q| <= f p keeps it closed only if f > 0."""
    one = np.eye(1)
    pulled = fo.ContactSystem.from_blocks(
        one, 0 * one, one, [0], {"mean": ([0.0], [-1.0]), "cyclic": ([0.0], [0.0])}
    )
    assert np.isnan(fo.shakedown_limit(pulled, CYCLE, 0.0).load_factor)
    assert not fo.safe_slip(pulled, CYCLE, 0.0, 1.0).exists
    loads = {"mean": ([0.0, 0.0], [1.0, 1.0]), "cyclic": ([0.1, 0.0], [0.0, -1.0])}
    half = fo.ContactSystem.from_blocks(np.eye(2), 0.1 * np.eye(2), np.eye(2), [0, 1], loads)
    limit = fo.shakedown_limit(half, CYCLE, [0.5, 0.0])
    assert limit.load_factor == pytest.approx(1.0, rel=1e-9) and 0 in set(limit.mechanism.direction)
    assert fo.safe_slip(half, CYCLE, [0.5, 0.0], 0.99).exists
    assert not fo.safe_slip(half, CYCLE, [0.5, 0.0], 1.01).exists


@pytest.mark.parametrize(
    ("contact", "friction"),
    [
        (system(1.0, 0.0, 0.0, 1.0, 1.0, 0.0), 0.0),
        (system(np.eye(2), np.zeros((2, 2)), 0.0, (1.0, 0.0), (1.0, 1.0), 0.0), 0.5),
        (system(np.eye(2), np.zeros((2, 2)), 0.0, 0.0, (1.0, 1.0), 0.0), 0.5),
    ],
)
def test_a_limit_of_zero(contact, friction):
    for simplify in (True, False):
        # All nodes closed.
        limit = all_closed(contact, CYCLE, friction, simplify=simplify)
        assert limit.load_factor == pytest.approx(0.0, abs=1e-10) and limit.load_factor >= 0


@pytest.mark.parametrize("B", [1e-6, 1e-8, 1e-9, 1e-10, 1e-12])
def test_weak_coupling_is_neither_lost_nor_a_failure(B):
    rng = np.random.default_rng(7)
    for _ in range(5):
        contact = random_system(rng, 8, coupling=B)
        limit = fo.shakedown_limit(contact, CYCLE, 0.5)
        assert limit.load_factor == pytest.approx(limit_of(contact, 0.5, simplify=False), rel=1e-8)


def test_stiffness_that_is_rounding_counts_as_none():
    tiny = fo.ContactSystem.from_blocks(
        [[1e-17]], [[0.0]], [[1.0]], [0], {"mean": ([0.2], [1.0]), "cyclic": ([1.0], [0.0])}
    )
    assert limit_of(tiny, 0.5) == pytest.approx(0.3, rel=1e-9)


COARSE = {
    16: (0.1534, 0.2513, 0.3660, 0.4999, 0.6558, 1.0479),
    32: (0.1285, 0.2204, 0.3355, 0.4784, 0.6548, 1.1365),
    64: (0.1081, 0.1950, 0.3115, 0.4656, 0.6671, 1.2131),
}


@pytest.mark.parametrize("elements", COARSE)
def test_the_papers_scene_on_coarse_meshes(punch, paper_cycle, elements):
    """The scene of the paper agrees with an independent trial on coarse meshes.

    The number is sigma a / P; P is the total force, twice the mean pressure at a = 1.
    """
    found = (
        fo.ShakedownModel(punch(elements), paper_cycle)
        .sweep([0.2, 0.3, 0.4, 0.5, 0.6, 0.8])
        .load_factor
        / 2
    )
    assert np.allclose(found, COARSE[elements], rtol=1e-3)


def test_normal_forces_that_drown_in_the_shear_of_the_mean_load_are_refused():
    """The mean shear is 1e10 mean pressures, at which HiGHS did not come back (fuzzed seed 552)."""
    contact = system(0.6, 0.0, 0.016, 1e-12, 1.5, 0.3)
    loads = {"mean": [0.0096, 0.0128, 1e-12], "cyclic": [1.0, 0.0, 0.0]}
    for node in (contact, fo.ContactSystem(np.eye(3), [[0, 0, 0]], loads)):
        for ask in (fo.shakedown_limit, lambda *args: fo.safe_slip(*args, 0.0)):
            with pytest.raises(
                fo.ModelError,
                match=r"mean: its shear force at node 0 is 1\.6e\+10 times the mean normal force 1e-12",
            ):
                ask(node, CYCLE, 0.465)
    assert limit_of(system(0.6, 0.0, 0.5, 1e-6, 1.5, 0.3), 0.465, CYCLE) > 0


@pytest.mark.parametrize("ratio", [1e-15, 1e-10, 1e10, 1e15])
def test_a_soft_contact_beside_a_stiff_one_is_no_free_one(ratio):
    """Two contacts that know nothing of each other have the limits of the one that is loaded."""
    alone = system(*FIRST_PAIR)
    A, B, C = (block_diag(part, ratio * part) for part in (alone.A, alone.B, alone.C))
    mean, cyclic = alone.bonded["mean"], alone.bonded["cyclic"]
    bonded = {
        "mean": tuple(np.r_[part, part] for part in mean),
        "cyclic": tuple(np.r_[part, 0 * part] for part in cyclic),
    }
    beside = fo.ContactSystem.from_blocks(A, B, C, np.arange(4.0), bonded)
    for limit in (fo.shakedown_limit, fo.guaranteed_limit):
        assert limit(beside, CYCLE, 0.5).load_factor == pytest.approx(
            limit(alone, CYCLE, 0.5).load_factor, rel=1e-9
        )


@pytest.mark.parametrize("coupling", [0.0, 0.1])
def test_a_node_without_friction_is_named_where_it_leaves_no_limit(coupling):
    """The node slides without work, so that transients count the contact as at rest until the other
    node slips."""
    loads = {"mean": ([0.0, 0.0], [1.0, 1.0]), "cyclic": ([1.0, 0.5], [0.0, 0.0])}
    pair = fo.ContactSystem.from_blocks(
        np.diag([2.0, 5.0]), [[0.0, coupling], [-coupling, 0.0]], np.eye(2), [0.0, 1.0], loads
    )
    limit = fo.shakedown_limit(pair, CYCLE, [0.0, 0.5])
    assert limit.load_factor == 0
    assert limit.reason.endswith("node 0 has no friction, and the cyclic load shears it")
    assert fo.steady_state(pair, CYCLE, [0.0, 0.5], 0.5).outcome is fo.Outcome.SHAKEDOWN
