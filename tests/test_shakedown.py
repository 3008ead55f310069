import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import block_diag

import frictopt as fo
from studies.validation.oracles import largest_load_factor
from systems import CYCLE, FIRST_PAIR, random_system, system
from test_slip_bound import freed

EXACT = 1e-9


def limit_of(contact, friction, cycle=CYCLE, **options):
    return fo.shakedown_limit(contact, cycle, friction, **options).load_factor


@settings(max_examples=40)
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(1, 7),
    corners=st.integers(1, 6),
    f=st.floats(0.05, 2.0),
    simplify=st.booleans(),
    nodewise=st.booleans(),
)
def test_any_cycle_against_a_linear_program_of_all_corners(seed, nodes, corners, f, simplify, nodewise):
    rng = np.random.default_rng(seed)
    contact = random_system(rng, nodes, loads=("mean", "a", "b"), coupling=rng.choice([0.0, 0.5, 1.0]))
    cycle = fo.LoadCycle({"mean": 1.0}, [{"a": float(a), "b": float(b)} for a, b in rng.normal(size=(corners, 2))])
    friction = f * rng.uniform(0.5, 1.5, nodes) if nodewise else f
    expected = largest_load_factor(contact, cycle, friction)
    limit = fo.shakedown_limit(contact, cycle, friction, simplify=simplify)
    if np.isfinite(expected):
        assert limit.load_factor == pytest.approx(expected, rel=1e-8, abs=1e-9)
        assert limit.bound == pytest.approx(limit.load_factor, rel=EXACT, abs=1e-9)
        q, p = limit.reactions
        assert (np.abs(q) - friction * p).max() < 1e-8
    else:
        assert limit.load_factor == pytest.approx(expected, nan_ok=True)
    assert limit.residual < EXACT


def test_a_limit_that_does_not_exist_is_an_answer():
    nothing = system(np.eye(2), np.zeros((2, 2)), 0.0, 1.0, 0.0, 0.0)
    never = fo.shakedown_limit(nothing, CYCLE, 0.5)
    assert never.load_factor == np.inf and np.isnan(never.slip).all()
    coupled = random_system(np.random.default_rng(0), 2)
    pressing = fo.LoadCycle({"mean": 1.0}, [{"mean": 1.0}, {"mean": 2.0}])
    assert fo.shakedown_limit(coupled, pressing, 3.0).load_factor == np.inf
    pulled = system(1.0, 0.0, 0.0, -1.0, 1.0, 0.0)
    for simplify in (True, False):
        none = fo.shakedown_limit(pulled, CYCLE, 0.5, simplify=simplify)
        assert np.isnan(none.load_factor) and set(none.mechanism.node) == {0} and none.residual < EXACT
    for limit in (never, none):
        assert np.isnan(limit.friction_rate).all() and np.isnan(limit.reactions).all()
        limit.explain(io.StringIO())


def test_pressure_must_stay_where_there_is_no_friction():
    """|q| <= f p keeps a node closed only if f > 0."""
    one = np.eye(1)
    pulled = fo.ContactSystem.from_blocks(one, 0 * one, one, [0], {"mean": ([0.0], [-1.0]), "cyclic": ([0.0], [0.0])})
    assert np.isnan(fo.shakedown_limit(pulled, CYCLE, 0.0).load_factor) and not fo.safe_slip(pulled, CYCLE, 0.0, 1.0).exists
    loads = {"mean": ([0.0, 0.0], [1.0, 1.0]), "cyclic": ([0.1, 0.0], [0.0, -1.0])}
    half = fo.ContactSystem.from_blocks(np.eye(2), 0.1 * np.eye(2), np.eye(2), [0, 1], loads)
    limit = fo.shakedown_limit(half, CYCLE, [0.5, 0.0])
    assert limit.load_factor == pytest.approx(1.0, rel=1e-9) and 0 in set(limit.mechanism.direction)
    assert fo.safe_slip(half, CYCLE, [0.5, 0.0], 0.99).exists and not fo.safe_slip(half, CYCLE, [0.5, 0.0], 1.01).exists


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
        limit = fo.shakedown_limit(contact, CYCLE, friction, simplify=simplify)
        assert limit.load_factor == pytest.approx(0.0, abs=1e-10) and limit.load_factor >= 0


@pytest.mark.parametrize("B", [1e-6, 1e-8, 1e-9, 1e-10, 1e-12])
def test_weak_coupling_is_neither_lost_nor_a_failure(B):
    rng = np.random.default_rng(7)
    for _ in range(5):
        contact = random_system(rng, 8, coupling=B)
        limit = fo.shakedown_limit(contact, CYCLE, 0.5)
        assert limit.load_factor == pytest.approx(limit_of(contact, 0.5, simplify=False), rel=1e-8)


def test_stiffness_that_is_rounding_counts_as_none():
    tiny = fo.ContactSystem.from_blocks([[1e-17]], [[0.0]], [[1.0]], [0], {"mean": ([0.2], [1.0]), "cyclic": ([1.0], [0.0])})
    assert limit_of(tiny, 0.5) == pytest.approx(0.3, rel=1e-9)


@settings(max_examples=15)
@given(seed=st.integers(0, 10**6), sideways=st.floats(0.0, 2.0))
def test_an_uncoupled_punch_without_supports_may_slip_as_a_whole(seed, sideways):
    contact = freed(random_system(np.random.default_rng(seed), 4, coupling=0.0))
    q1, p1 = contact.bonded["cyclic"]
    contact = contact.with_bonded({"cyclic": (q1 + sideways, p1)})
    closed = fo.shakedown_limit(contact, CYCLE, 0.4)
    assert closed.record.solver == "closed form"
    assert closed.load_factor == pytest.approx(largest_load_factor(contact, CYCLE, 0.4), rel=1e-9, nan_ok=True)


COARSE = {
    16: (0.1534, 0.2513, 0.3660, 0.4999, 0.6558, 1.0479),
    32: (0.1285, 0.2204, 0.3355, 0.4784, 0.6548, 1.1365),
    64: (0.1081, 0.1950, 0.3115, 0.4656, 0.6671, 1.2131),
}


@pytest.mark.parametrize("elements", COARSE)
def test_the_papers_scene_on_coarse_meshes(punch, paper_cycle, elements):
    """sigma a / P of an independent trial on the same scene; P is the total force, twice the mean pressure at a = 1."""
    found = fo.ShakedownModel(punch(elements), paper_cycle).sweep([0.2, 0.3, 0.4, 0.5, 0.6, 0.8]).load_factor / 2
    assert np.allclose(found, COARSE[elements], rtol=1e-3)


def scaled_scene(elements=16, size=1.0, E=1.0, nu=0.3, element="linear"):
    material = fo.Material(E, nu)
    sizes = {"half_width": size, "punch_height": 2 * size, "block_half_width": 12 * size, "block_depth": 12 * size}
    materials = {"punch_material": material, "block_material": material}
    return fo.scenes.PunchOnHalfPlane(elements, **sizes, grading="sine", growth=1.15, **materials, element=element).condense()


def test_neither_stiffness_nor_size_of_the_scene_matters(paper_cycle):
    """Similar materials under tractions alone."""
    base = limit_of(scaled_scene(), 0.7, paper_cycle)
    assert limit_of(scaled_scene(E=2.1e11), 0.7, paper_cycle) == pytest.approx(base, rel=EXACT)
    for size in (1e-6, 10.0, 1e6):
        assert limit_of(scaled_scene(size=size), 0.7, paper_cycle) == pytest.approx(base, rel=1e-7)


def test_averaged_dilatation_takes_most_of_poissons_ratio_out(paper_cycle):
    """Stresses of similar bodies under tractions do not depend on nu (Michell 1899), but linear elements lose over 60 % of the limit up to 0.5."""
    for friction in (0.3, 0.7):
        changes = {}
        for element in ("linear", "mean_dilatation"):
            soft, base, hard = (limit_of(scaled_scene(32, nu=nu, element=element), friction, paper_cycle) for nu in (0.1, 0.3, 0.4999))
            changes[element] = abs(base / soft - 1), 1 - hard / soft
        assert changes["linear"][1] > 0.6 and changes["mean_dilatation"][1] < 0.1
        assert changes["mean_dilatation"][0] < 0.5 * changes["linear"][0]


def test_normal_forces_that_drown_in_the_shear_of_the_mean_load_are_refused():
    """Fuzzed seed 552: a mean shear of 1e10 mean pressures, at which HiGHS did not come back."""
    contact, loads = system(0.6, 0.0, 0.016, 1e-12, 1.5, 0.3), {"mean": [0.0096, 0.0128, 1e-12], "cyclic": [1.0, 0.0, 0.0]}
    for node in (contact, fo.ContactSystem(np.eye(3), [[0, 0, 0]], loads)):
        for ask in (fo.shakedown_limit, lambda *args: fo.safe_slip(*args, 0.0)):
            with pytest.raises(fo.ModelError, match=r"mean: its shear force at node 0 is 1\.6e\+10 times the mean normal force 1e-12"):
                ask(node, CYCLE, 0.465)
    assert limit_of(system(0.6, 0.0, 0.5, 1e-6, 1.5, 0.3), 0.465, CYCLE) > 0


@pytest.mark.parametrize("ratio", [1e-15, 1e-10, 1e10, 1e15])
def test_a_soft_contact_beside_a_stiff_one_is_no_free_one(ratio):
    """Two contacts that know nothing of each other have the limits of the one that is loaded."""
    alone = system(*FIRST_PAIR)
    A, B, C = (block_diag(part, ratio * part) for part in (alone.A, alone.B, alone.C))
    mean, cyclic = alone.bonded["mean"], alone.bonded["cyclic"]
    bonded = {"mean": tuple(np.r_[part, part] for part in mean), "cyclic": tuple(np.r_[part, 0 * part] for part in cyclic)}
    beside = fo.ContactSystem.from_blocks(A, B, C, np.arange(4.0), bonded)
    for limit in (fo.shakedown_limit, fo.guaranteed_limit):
        assert limit(beside, CYCLE, 0.5).load_factor == pytest.approx(limit(alone, CYCLE, 0.5).load_factor, rel=1e-9)
