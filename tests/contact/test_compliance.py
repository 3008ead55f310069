"""Displacements at the loads.

They are compared with solutions of the whole model, with springs, and with the work of friction in
the loops.
"""

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from skfem import MeshQuad

import frictopt as fo
from helpers.components import joined
from helpers.meshes import box

PAPER = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])


def springs(n=6, seed=3):
    """Random bodies, n nodes of which the first four make two pairs: K, loads, and the contact."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(2 * n, 2 * n))
    one, two = [0, 2, 4], [1, 3, 5]  # bodies
    K = np.zeros((2 * n, 2 * n))
    for body in (one, two):
        rows = np.r_[np.array(body) * 2, np.array(body) * 2 + 1]
        K[np.ix_(rows, rows)] = (root @ root.T + np.eye(2 * n))[np.ix_(rows, rows)]
    loads = {name: rng.normal(size=2 * n) for name in ("a", "b")}
    points = np.array([[0, 0], [0, 0], [1, 0], [1, 0], [0.5, 1], [0.5, -1]], float)
    unknowns = np.arange(2 * n).reshape(n, 2)
    system = fo.condense(csr_matrix(K), loads, [[0, 1], [2, 3]], [0.0, 1.0], unknowns, points)
    return K, loads, system.with_interference({"fit": 0.1, "b": 0.02})


def test_the_displacement_is_that_of_the_whole_model():
    """Slip and opening are given to the whole model by multipliers."""
    K, loads, system = springs()
    slip, gap, amplitudes = np.array([0.1, -0.2]), np.array([0.0, 0.3]), np.array([0.7, -1.3, 0.5])
    assert list(system.bonded) == ["a", "b", "fit"]
    overlap = 0.02 * amplitudes[1] + 0.1 * amplitudes[2]
    rules = np.zeros((4, 12))
    for i, (node, other) in enumerate([(0, 1), (2, 3)]):
        for axis in range(2):
            rules[i + 2 * axis, 2 * node + axis], rules[i + 2 * axis, 2 * other + axis] = 1, -1
    force = amplitudes[0] * loads["a"] + amplitudes[1] * loads["b"]
    right = np.r_[force, slip, gap + overlap]
    u = np.linalg.solve(np.block([[K, rules.T], [rules, np.zeros((4, 4))]]), right)
    pressed = u[14:].sum()  # the multipliers pull body 1 away from body 2 where positive: minus p
    expected = [loads["a"] @ u[:12], loads["b"] @ u[:12] + 0.02 * pressed, 0.1 * pressed]
    assert system.displacements(amplitudes, slip, gap) == pytest.approx(expected, rel=1e-10)


def test_moved_supports_are_those_of_their_force():
    """A block on rigid ground is pulled down by its top. The force at the top follows from the
    stress of a column."""
    x = np.linspace(0, 1, 3)
    material = fo.fem.Material(E=2.0, nu=0.0)
    model = fo.fem.ContactModel(
        bodies={
            "punch": fo.fem.Body(box(MeshQuad, x, x), material),
            "block": fo.fem.Body(box(MeshQuad, x, x - 1), material),
        },
        supports=[fo.fem.Support("block", "y-"), fo.fem.Support("punch", "y+")],
        loads={
            "push": [fo.fem.Displacement("punch", "y+", y=-0.1)],
            "shear": [fo.fem.Traction("punch", "contact", x=1.0)],
        },
    )
    system = model.condense()
    # Force E/2 x 0.1, times 0.1.
    assert system.displacements([1.0, 0.0], np.zeros(3), np.zeros(3))[0] == pytest.approx(
        -0.1 * 0.1 * 2.0 / 2.0
    )
    # Open by 0.1 more, twice the force.
    assert system.displacements([1.0, 0.0], np.zeros(3), np.full(3, 0.1))[0] == pytest.approx(
        -2 * 0.1 * 0.1
    )


@pytest.mark.parametrize("factor", [1.05, 1.5])
def test_the_area_of_the_loop_is_the_work_of_friction(factor):
    system = fo.scenes.PunchOnHalfPlane(elements=40).condense()
    steady = fo.steady_state(
        system, PAPER, 0.7, factor * fo.shakedown_limit(system, PAPER, 0.7).load_factor
    )
    loop = steady.loop("sigma")
    assert steady.dissipation > 0 and loop.area == pytest.approx(steady.dissipation, rel=1e-10)
    # The load is constant.
    assert steady.loop("P").area == pytest.approx(0.0, abs=1e-12 * np.ptp(steady.displacement("P")))
    assert np.ptp(loop.amplitude) == pytest.approx(2 * steady.load_factor)
    assert np.ptp(steady.displacement("sigma")) == pytest.approx(
        np.ptp(loop.amplitude) / loop.stiffness
    )


def test_the_transient_knows_its_amplitudes_from_the_mean_load_on():
    system = fo.scenes.PunchOnHalfPlane(elements=8, growth=1.6).condense()
    path = fo.march(system, PAPER, 0.5, 0.3, initial_slip=np.linspace(0, 0.01, 9), cycles=2)
    q, p = system.reaction({"P": 1.0})
    for row in range(len(path.time)):
        loads = dict(zip(system.bonded, path.amplitudes[row], strict=True))
        q, p = system.reaction(loads)
        assert np.abs(path.bonded_p[row] - p).max() + np.abs(path.bonded_q[row] - q).max() < 1e-12
    later = fo.march(system, PAPER, 0.5, 0.3, initial_state=path.state_at(-1), cycles=1)
    assert np.isnan(later.amplitudes[0]).all()
    assert later.amplitudes[-1].tolist() == path.amplitudes[-1].tolist()


def test_contact_stiffness_and_gaps_carry_the_compliance(tmp_path):
    system = springs()[2]
    widths = fo.ContactSystem(
        system.S, system.points, dict(system.bonded), width=[0.5, 0.7], compliance=system.compliance
    )
    soft = widths.with_gap([0.1, 0.0]).with_contact_stiffness(tangential=3.0, normal=5.0)
    # Tractions: what they and the loads do to the bodies and to the springs.
    r = np.random.default_rng(0).normal(size=4)
    give = 1 / np.array([1.5, 2.1, 2.5, 3.5])
    loads = np.array([0.3, 0.2, -0.1])
    held = np.column_stack([joined(*pair) for pair in widths.bonded.values()])
    bodies = np.linalg.solve(system.S, r - held @ loads)
    motion = bodies + give * r
    expected = loads @ system.compliance - bodies @ held
    found = soft.displacements(loads, motion[:2], motion[2:] + [0.1, 0.0])
    assert found == pytest.approx(expected, rel=1e-10)
    soft.save(tmp_path / "soft.npz")
    assert np.array_equal(fo.ContactSystem.load(tmp_path / "soft.npz").compliance, soft.compliance)
    assert soft.with_bonded({"more": np.ones(4)}).compliance is None


def test_no_compliance_and_odd_input():
    system = springs()[2]
    bare = fo.ContactSystem(system.S, system.points, dict(system.bonded))
    with pytest.raises(fo.ModelError, match="compliance: not known"):
        bare.displacements([1, 1, 1], [0, 0], [0, 0])
    with pytest.raises(fo.ModelError, match="amplitudes, slip, gap: shapes"):
        system.displacements([1, 1], [0, 0], [0, 0])
    for odd in (np.eye(2), [[1, 2, 0], [0, 1, 0], [0, 0, 1]], np.full((3, 3), np.nan)):
        with pytest.raises(fo.ModelError, match="compliance"):
            fo.ContactSystem(system.S, system.points, dict(system.bonded), compliance=odd)
    path = fo.march(
        fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).condense(), PAPER, 0.5, 0.1, cycles=1
    )
    with pytest.raises(fo.ModelError, match="case: 'R'"):
        path.displacement("R")
