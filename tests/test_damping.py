"""Frequency and damping with amplitude: Jenkins' element, a published oscillator, closed forms of rods, cylinders and spheres, Masing's rule."""

from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csr_matrix

import frictopt as fo
from frictopt.reference import half_plane_contact
from systems import linprog_limit
from worn import sphere


def opposed(case, mean):
    return fo.LoadCycle(mean, [{case: 1.0}, {case: -1.0}])


def test_the_element_of_jenkins():
    """A mass on a spring k0, and on a spring k_t that slides at mu N."""
    k0, kt, mu, N, m = 3.0, 5.0, 0.4, 2.0, 0.7
    one = {"N": ([0.0], [1.0]), "mode": ([-np.sqrt(m)], [0.0])}  # the mode is 1 / sqrt(m), its load m times that
    hard = fo.ContactSystem.from_blocks([[k0]], [[0.0]], [[1.0]], [0.0], one, width=[1.0], compliance=np.zeros((2, 2)))
    system = hard.with_contact_stiffness(tangential=kt)
    force = np.array([0.1, 0.15, 0.5, 1.0, 4.0, 30.0]) * mu * N * (k0 + kt) / kt
    natural = np.sqrt((k0 + kt) / m) / (2 * np.pi)
    curve = fo.damping_curve(system, opposed("mode", {"N": N}), mu, force / np.sqrt(m), natural_frequency=1.005 * natural)
    slides = force > mu * N * (k0 + kt) / kt
    X = np.where(slides, (force - mu * N) / k0, force / (k0 + kt))
    work = np.where(slides, 4 * mu * N * (X - mu * N / kt), 0.0)
    assert slides.sum() == 2
    assert curve.displacement == pytest.approx(X * np.sqrt(m), rel=1e-12)
    assert curve.work == pytest.approx(work, rel=1e-12, abs=1e-12)
    assert (2 * np.pi * curve.frequency) ** 2 == pytest.approx(np.where(slides, k0 + mu * N / X, k0 + kt) / m, rel=1e-12)
    assert curve.damping == pytest.approx(work / (2 * np.pi * force * X), rel=1e-12, abs=1e-13)
    assert curve.natural_frequency == pytest.approx(natural)
    assert curve.shakedown_limit == pytest.approx(mu * N * (k0 + kt) / kt / np.sqrt(m)) == curve.guaranteed_limit
    assert np.isnan(curve.exponent).tolist() == [True] * 5 + [False]  # of load factors without work
    least = fo.damping_curve(system, opposed("mode", {"N": N}), mu, [1e-200], natural_frequency=natural)  # its square is 0
    assert least.damping == 0 and least.frequency == pytest.approx(curve.natural_frequency)
    assert np.array_equal(curve.least_damping, curve.damping) and np.array_equal(curve.most_frequency, curve.frequency)


def test_damping_below_the_guaranteed_limit_where_a_node_opens_and_closes():
    """The closed contact rests there from every start, but a node that is open under the mean load closes in each cycle: random starts tell."""
    loads = {"P": ([0.2, -0.2], [1.2, 0.1]), "Q": ([-0.5, 1.3], [0.7, 0.2])}
    A, B, C = [[2.3, -0.4], [-0.4, 1.4]], [[-0.2, 0.8], [0.5, -0.2]], [[4.3, 0.0], [0.0, 2.6]]
    pair = fo.ContactSystem.from_blocks(A, B, C, [0.0, 1.0], loads, gap=[0.0, 0.1], compliance=2 * np.eye(2))
    cycle, friction, starts = opposed("Q", {"P": 1.0}), [0.5, 0.4], 3.0 * np.random.default_rng(1).normal(size=(20, 2))
    curve = fo.damping_curve(pair, cycle, friction, [0.7])
    seen = [fo.steady_state(pair, cycle, friction, 0.7, initial_slip=start).loop("Q") for start in starts]
    damping = [loop.area / (np.pi * 0.7 * np.ptp(loop.displacement)) for loop in seen]
    rest, found = fo.steady_state(pair, cycle, friction, 0.05), fo.damping_curve(pair, cycle, friction, [0.05], range=False).displacement[0]
    assert rest.outcome is fo.Outcome.SHAKEDOWN and rest.open.any() and abs(found / (2 * 0.05) - 1) > 1e-3  # softer than the glued one
    assert found == pytest.approx(np.ptp(rest.loop("Q").displacement) / 2)
    assert 0.7 < 0.9 * curve.guaranteed_limit and curve.damping[0] < 0.5 * max(damping)
    assert curve.least_damping[0] <= min(damping) + 1e-12 and curve.most_damping[0] >= max(damping) * (1 - 1e-9)


def test_a_node_without_friction_slides_where_the_others_rest():
    """Two springs: the load moves the free one by its compliance from the smallest amplitude on."""
    loads = {"N": ([0.0, 0.0], [1.0, 1.0]), "F": ([-1.0, -0.5], [0.0, 0.0])}
    pair = fo.ContactSystem.from_blocks(np.diag([2.0, 5.0]), np.zeros((2, 2)), np.eye(2), [0.0, 1.0], loads, compliance=np.eye(2))
    curve = fo.damping_curve(pair, opposed("F", {"N": 1.0}), [0.0, 0.5], [0.1, 0.9], natural_frequency=1 / (2 * np.pi))
    assert curve.displacement == pytest.approx((1 + 1.0**2 / 2) * curve.load_factor) and not curve.work.any()
    assert np.array_equal(curve.least_frequency, curve.frequency) and np.array_equal(curve.most_frequency, curve.frequency)


def oscillator():
    """Three masses in the plane, two wedge faces of 40 degrees with springs (Balaji and Ferhatoglu): the contact, frequency of its third mode."""
    k, kxy, kD, kt, kn = 1e5, 3e5, 1e6, 3e5, 3e5
    J, none = np.array([[1.0, -1.0], [-1.0, 1.0]]), np.zeros((2, 2))
    blocks = [3 * kxy * J, kxy * J, kD * J]
    K = np.diag([k, k, k, k, 0.0, 0.0]) + np.block([[blocks[i] if i == j else none for j in range(3)] for i in range(3)])
    M = np.diag([10.0] * 4 + [0.1] * 2)
    c, s = np.cos(np.radians(40)), np.sin(np.radians(40))
    rows = np.vstack([np.kron([-1, 0, 1], [[c, s], [-s, c]]), np.kron([0, -1, 1], [[c, -s], [s, c]])])
    Lt, Ln = rows[::2], rows[1::2]
    Ki = np.linalg.inv(K + kt * Lt.T @ Lt + kn * Ln.T @ Ln)
    squares, modes = eigh(np.linalg.inv(Ki), M)
    static = np.zeros(6)
    static[5] = 240.0
    F = np.column_stack([static, M @ modes[:, 2]])
    blocks = kt * np.eye(2) - kt**2 * Lt @ Ki @ Lt.T, kn * kt * Ln @ Ki @ Lt.T, kn * np.eye(2) - kn**2 * Ln @ Ki @ Ln.T
    bonded = {name: (-kt * Lt @ Ki @ f, kn * Ln @ Ki @ f) for name, f in zip(("static", "mode"), F.T, strict=True)}
    return fo.ContactSystem.from_blocks(*blocks, [0.0, 1.0], bonded, compliance=F.T @ Ki @ F), np.sqrt(squares[2]) / (2 * np.pi)


def test_a_published_oscillator(monkeypatch):
    """Its sampled values are those of 25 residual tractions by a code with 100 steps a quarter cycle, 1 % in damping; the range holds them."""
    system, stuck = oscillator()
    assert stuck == pytest.approx(49.42140619, rel=1e-9)
    cycle = opposed("mode", {"static": 1.0})
    curve = fo.damping_curve(system, cycle, 0.9, [200.0, 800.0, 1200.0], natural_frequency=stuck)
    assert curve.natural_frequency == pytest.approx(stuck, rel=1e-12)
    assert curve.shakedown_limit == pytest.approx(linprog_limit(system, cycle, 0.9)[1], rel=1e-9)
    for factor, least, most in ((200.0, 0.0, 0.0436), (800.0, 0.0286, 0.0381), (1200.0, 0.0210, 0.0274)):
        (row,) = np.flatnonzero(curve.load_factor == factor)
        assert curve.least_damping[row] <= 1.01 * least and curve.most_damping[row] >= 0.99 * most
        assert curve.least_damping[row] <= curve.damping[row] <= curve.most_damping[row]
    assert curve.least_frequency[0] <= 1.001 * 47.01 and curve.most_frequency[0] == pytest.approx(49.42, abs=0.01)
    assert curve.least_frequency[2] <= 1.001 * 42.93 and curve.most_frequency[2] >= 0.999 * 43.24
    same = fo.damping_curve(system, cycle, 0.9, [800.0], natural_frequency=stuck, range=False)
    bare = fo.ContactSystem(system.S, system.points, dict(system.bonded))
    other = fo.damping_curve(bare, cycle, 0.9, [800.0], natural_frequency=stuck, range=False)
    unsaid = fo.damping_curve(system, cycle, 0.9, [800.0])
    assert all(np.isnan(np.r_[getattr(unsaid, name), unsaid.natural_frequency]).all() for name in ("frequency", "least_frequency", "most_frequency"))
    assert unsaid.stiffness == pytest.approx((2 * np.pi * curve.frequency[1:2]) ** 2) and "frequency" not in repr(unsaid)
    assert unsaid.most_damping == pytest.approx(curve.most_damping[1:2])
    assert same.frequency == pytest.approx(curve.frequency[1:2]) == other.frequency and np.isnan(same.most_damping).all()
    twice = fo.LoadCycle({"static": 1.0}, [{"mode": 2.0}, {"mode": -2.0}])
    assert fo.damping_curve(bare, twice, 0.9, [400.0], natural_frequency=stuck / 2, range=False).displacement == pytest.approx(2 * same.displacement)
    found = SimpleNamespace(residual=1e-3, steady_states=())
    monkeypatch.setattr(import_module("frictopt.histories.damping"), "dissipation_range", lambda *_, **__: found)
    assert fo.damping_curve(system, cycle, 0.9, [800.0]).residual == 1e-3
    with pytest.raises(fo.ModelError, match="natural_frequency: 48"):
        fo.damping_curve(system, cycle, 0.9, [800.0], natural_frequency=48.0)


def test_the_cylinder_of_cattaneo_and_mindlin():
    arrays = half_plane_contact(nodes=160, half_length=1.2, E_star=1.0, R=1.0)
    system = fo.ContactSystem.from_blocks(**arrays)
    P, f = np.pi / 4, 0.4
    x = np.array([0.35, 0.5, 0.7, 0.9])
    curve = fo.damping_curve(system, opposed("Q", {"P": P}), f, x * f * P, natural_frequency=0.01, range=False)
    exact = 4 * f**2 * P**2 / np.pi * (x - x**2 / 2 + (1 - x) * np.log(1 - x))
    assert curve.work == pytest.approx(exact, rel=0.02)
    assert curve.exponent == pytest.approx(np.gradient(np.log(exact), np.log(x)), rel=0.02)
    assert 3 < curve.exponent[0] < 3.6  # 3 at small amplitude


@pytest.mark.slow
def test_the_sphere_of_mindlin_and_deresiewicz():
    """Its far end is free; the glued one, all of the grid, is what the compliance tells of."""
    system, cycle, f, _ = sphere(16, 1.1)
    ball = fo.reference.SphereContact(P=2 / 3, R=1.0, E=1.0, nu=0.0, f=f)
    S = fo.reference.half_space_contact(16, 1.1, R=1.0, E=1.0, nu=0.0)["S"]
    far = np.kron(np.eye(3), np.ones((system.nodes, 1)))
    glued = np.linalg.inv(far.T @ S @ far)[[2, 0]][:, [2, 0]]  # displacements under P and Q
    held = fo.ContactSystem(system.S, system.points, dict(system.bonded), gap=system.gap, width=system.width, compliance=glued)
    x = np.array([0.6, 0.9])
    curve = fo.damping_curve(held, cycle, f, x * f * ball.P, range=False)
    exact = np.array([ball.dissipation(Q) for Q in x * f * ball.P])
    shear_modulus = ball.E / 2
    assert curve.work == pytest.approx(exact, rel=0.04)
    assert curve.displacement == pytest.approx(3 * f * ball.P / (4 * shear_modulus * ball.half_width) * (1 - (1 - x) ** (2 / 3)), rel=2e-3)
    assert curve.damping == pytest.approx(exact / (2 * np.pi * x * f * ball.P * curve.displacement), rel=0.04)


def test_a_load_that_is_no_mode_has_no_frequency():
    """A frequency of it would be the root of a stiffness per load factor, in no unit of a frequency."""
    punch, cycle = fo.scenes.PunchOnHalfPlane(elements=24).condense(), opposed("sigma", {"P": 1.0})
    curve = fo.damping_curve(punch, cycle, 0.5, [1.5])
    assert np.isnan([curve.natural_frequency, *curve.frequency, *curve.least_frequency, *curve.most_frequency]).all()
    assert np.isfinite([*curve.stiffness, *curve.most_damping]).all() and curve.to_frame()["frequency"].isna().all()
    above, _ = curve.plot()
    assert "stiffness" in above.get_ylabel() and np.array_equal(above.get_lines()[0].get_ydata(), curve.stiffness)


def test_bad_input():
    punch = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).condense()
    cycle = opposed("sigma", {"P": 1.0})
    for corners in ([{"sigma": 1.0}], [{"sigma": 1.0}, {"sigma": -0.5}], [{"sigma": 1.0}, {}, {"sigma": -1.0}], [{}, {}]):
        with pytest.raises(fo.ModelError, match=r"cycle: .*two opposed corners"):
            fo.damping_curve(punch, fo.LoadCycle({"P": 1.0}, corners), 0.5, [1.0])
    with pytest.raises(fo.ModelError, match=r"cycle: .*no fixed part"):
        fo.damping_curve(punch, fo.LoadCycle({"P": 1.0}, cycle.corners, fixed=[{"Q": 0.1}, {}]), 0.5, [1.0])
    for factors in ([], [0.0, 1.0], [1.0, 1.0], [2.0, 1.0], [-1.0], "1", [np.nan]):
        with pytest.raises(fo.ModelError, match="load_factors"):
            fo.damping_curve(punch, cycle, 0.5, factors)
    bare = fo.ContactSystem(punch.S, punch.points, dict(punch.bonded))
    with pytest.raises(fo.ModelError, match="natural_frequency: None"):
        fo.damping_curve(bare, cycle, 0.5, [1.0])
    for odd in (0.0, -1.0, np.inf, "1"):
        with pytest.raises(fo.ModelError, match="natural_frequency"):
            fo.damping_curve(bare, cycle, 0.5, [1.0], natural_frequency=odd)
    with pytest.raises(fo.ModelError, match="the load does no work"):
        fo.damping_curve(punch.with_interference({"fit": 1.0}), opposed("fit", {"P": 1.0}), 0.5, [1e-3])
    with pytest.raises(fo.ModelError, match="range: 'yes'"):
        fo.damping_curve(punch, cycle, 0.5, [1.0], range="yes")
    space = fo.scenes.SquarePunch(elements=2, growth=2.0).condense()
    curve = fo.damping_curve(space, opposed("Qx", {"P": 1.0}), 0.5, [0.1], range=False)
    assert curve.guaranteed_limit == fo.guaranteed_limit(space, opposed("Qx", {"P": 1.0}), 0.5).load_factor > 0 < curve.displacement[0]


def test_the_load_of_a_mode():
    """Two bodies of three springs and masses each, glued at their ends: the frequency of the glued joint is that of its compliance."""
    rng = np.random.default_rng(4)
    n = 12
    root = rng.normal(size=(n, n))
    bodies = np.repeat([0, 1], 6)
    K, M = (root @ root.T + np.eye(n)) * np.equal.outer(bodies, bodies), np.diag(rng.uniform(0.5, 2.0, n))
    unknowns = np.arange(n).reshape(6, 2)
    glue = np.delete(np.eye(n), [6, 7], axis=1)
    glue[[6, 7], [0, 1]] = 1.0  # node 3 lies on node 0
    squares, modes = eigh(glue.T @ K @ glue, glue.T @ M @ glue)
    frequency = np.sqrt(squares[1]) / (2 * np.pi)
    mode = glue @ modes[:, 1]
    load = fo.modal_load(M, -3.0 * mode)
    by_stiffness = fo.modal_load(K, mode, natural_frequency=frequency, glued=[[0, 6], [1, 7]])
    inertia, apart = M @ mode, np.r_[2:6, 8:12]
    assert load == pytest.approx(-inertia) and by_stiffness[apart] == pytest.approx(inertia[apart])
    assert by_stiffness[:2] == pytest.approx((inertia[:2] + inertia[6:8]) / 2) == by_stiffness[6:8]
    points = np.array([[0, 0], [1, 1], [-1, 1], [0, 0], [1, -1], [-1, -1]], float)
    for forces in (load, by_stiffness):
        system = fo.condense(csr_matrix(K), {"mode": forces, "P": np.eye(n)[3]}, [[0, 3]], [0.0, 1.0], unknowns, points, width=[1.0])
        assert 1 / np.sqrt(system.compliance[0, 0]) / (2 * np.pi) == pytest.approx(frequency, rel=1e-9)
    for odd in (np.eye(3), np.zeros((n, n)), -M, "M", None):
        with pytest.raises(fo.ModelError, match=r"^(M|mode): "):
            fo.modal_load(odd, mode)
    with pytest.raises(fo.ModelError, match="natural_frequency"):
        fo.modal_load(K, mode, natural_frequency=0.0, glued=[[0, 6]])
    for odd in (None, [[0, 12]], [[0, 1, 2]], [[0.5, 1]]):
        with pytest.raises(fo.ModelError, match="glued: "):
            fo.modal_load(K, mode, natural_frequency=frequency, glued=odd)
