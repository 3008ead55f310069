"""The interior point method for large cone programs.

It is tested on programs with known solutions, and on limits in space against Clarabel.
"""

import cvxpy as cp
import numpy as np
import pytest
from scipy.sparse import csr_array

import frictopt as fo
from frictopt.solve import interior_point
from frictopt.solve.arrays import Arrays
from frictopt.solve.condensed import Condensed, Cones, Scaling
from frictopt.solve.step_equations import Equations, _factor
from helpers.arrays_of import arrays_of
from helpers.cases import few
from helpers.spatial import cycle, random_contact, vectors


def planted(rng, n, numbers, circles, defined):
    """A program whose optimum is planted.

    Its slacks and multipliers are complementary, for numbers and for cones of two dimensions.
    """
    x, rows, total = cp.Variable(n), [], np.zeros(n)
    z0 = rng.normal(size=n)
    G = rng.normal(size=(defined, n))
    g = cp.Variable(defined)
    g0 = G @ z0 + 1.0
    C, D = rng.normal(size=(numbers, n)), rng.normal(size=(numbers, defined))
    active = rng.random(numbers) < 0.5
    slack = np.where(active, 0.0, rng.uniform(0.1, 2.0, numbers))
    multiplier = np.where(active, rng.uniform(0.1, 2.0, numbers), 0.0)
    rows.append(C @ z0 + D @ g0 + slack - C @ x - D @ g >= 0)
    total += (C + D @ G).T @ multiplier
    for _ in range(circles):
        d = int(rng.integers(2, 5))
        A, B = rng.normal(size=(d, n)), rng.normal(size=(d, defined))
        side = rng.normal(size=d - 1)
        side /= np.linalg.norm(side)
        room, by = [
            (np.r_[1.0, side], np.r_[1.0, -side]),
            (np.zeros(d), np.r_[1.5, side]),
            (np.r_[1.5, side], np.zeros(d)),
        ][int(rng.integers(3))]
        s = A @ z0 + B @ g0 + rng.uniform(0.1, 2.0) * room - A @ x - B @ g
        rows.append(cp.SOC(s[0], s[1:]))
        total += (A + B @ G).T @ (rng.uniform(0.1, 2.0) * by)
    of_g = rng.normal(size=defined)
    return cp.Problem(
        cp.Maximize((total - G.T @ of_g) @ x + of_g @ g), [*rows, g == G @ x + 1.0]
    ), float((total - G.T @ of_g) @ z0 + of_g @ g0)


def ours(problem, above=-np.inf):
    """Status, value and proven bound of a largest objective."""
    program = arrays_of(problem)
    status, x, y = interior_point.interior_point(program, above)
    # Multipliers in their cones, or they prove nothing.
    for head, size in zip(program.heads, program.sizes, strict=True):
        assert y[head] >= np.linalg.norm(y[head + 1 : head + size]) * (1 - 1e-12)
    least, error = program.lower_bound(x, y)
    return status, -float(program.cost @ x), error - least


@pytest.mark.parametrize("seed", few(range(6)))
def test_a_planted_optimum_is_found_with_multipliers_that_prove_it(seed):
    rng = np.random.default_rng(seed)
    problem, optimum = planted(
        rng,
        n=int(rng.integers(2, 12)),
        numbers=int(rng.integers(1, 20)),
        circles=int(rng.integers(4, 20)),
        defined=seed % 4,
    )
    _, value, bound = ours(problem)
    assert value == pytest.approx(optimum, rel=1e-8, abs=1e-8)
    assert bound == pytest.approx(optimum, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("seed", few(range(6)))
def test_it_ends_early_only_where_multipliers_prove_that_the_optimum_is_not_above_a_number(seed):
    problem, optimum = planted(np.random.default_rng(seed), n=9, numbers=9, circles=9, defined=2)
    for off in (-1.0, -0.01, -1e-6):
        assert ours(problem, optimum + off)[1:] == pytest.approx([optimum] * 2, rel=1e-8)
    bound = ours(problem, optimum + 10.0)[2]
    assert optimum < bound <= optimum + 10.0


def test_programs_without_an_optimum_are_told():
    x, g = cp.Variable(3), cp.Variable(2)
    define, ball = g - np.array([[1.0, 2.0, 0.0], [0.0, 1.0, -1.0]]) @ x == 0, cp.norm(x) <= 1
    beyond = cp.Problem(cp.Maximize(x[0]), [define, ball, g[0] >= 3])
    endless = cp.Problem(cp.Maximize(g[0]), [define, cp.norm(x[:2] - x[2]) <= 1])
    assert [ours(problem)[0] for problem in (beyond, endless)] == [
        "PrimalInfeasible",
        "DualInfeasible",
    ]


@pytest.mark.parametrize("seed", few(range(5)))
def test_limits_and_margins_in_space_are_those_of_clarabel(seed):
    rng = np.random.default_rng(seed)
    contact = random_contact(rng, int(rng.integers(1, 9)))
    friction = rng.uniform(0.1, 0.9)
    most = rng.uniform(0.2, 1.0) if seed % 2 else None
    ours, theirs = (
        fo.shakedown_limit(contact, cycle(), friction, slip_bound=most, solver=name)
        for name in ("INTERIOR_POINT", "CLARABEL")
    )
    assert ours.kind is theirs.kind and ours.record.solver == "INTERIOR_POINT"
    assert ours.load_factor == pytest.approx(theirs.load_factor, rel=1e-8, nan_ok=True)
    assert ours.bound == pytest.approx(theirs.load_factor, rel=1e-8, nan_ok=True)
    at = 0.5 if not np.isfinite(theirs.load_factor) else 1.3 * theirs.load_factor
    safe, other = (
        fo.safe_slip(contact, cycle(), friction, at, slip_bound=most, solver=name)
        for name in ("INTERIOR_POINT", "CLARABEL")
    )
    assert safe.exists == other.exists
    assert (safe.margin, safe.bound) == pytest.approx((other.margin, other.margin), abs=1e-8)


def test_equations_without_a_variable_of_their_own_are_solved_for_one():
    """A node without friction has no circle but an equation, which keeps its shear at zero; a
    critical node of a guaranteed limit has three equations."""
    rng = np.random.default_rng(1)
    contact, friction = random_contact(rng, 4), np.array([0.0, 0.5, 0.6, 0.4])
    cases = {
        name: r * np.tile(friction > 0, 3) if name in "abc" else r
        for name, r in vectors(contact).items()
    }
    still = fo.ContactSystem(contact.S, contact.points, cases)
    for ask in (fo.shakedown_limit, fo.guaranteed_limit):
        theirs = ask(still, cycle(), friction, solver="CLARABEL")
        ours = ask(still, cycle(), friction, solver="INTERIOR_POINT")
        assert (ours.record.solver, ours.load_factor) == (
            "INTERIOR_POINT",
            pytest.approx(theirs.load_factor, rel=1e-8),
        )
        assert ours.load_factor > 0 and ours.residual <= 1e-9


def test_a_matrix_that_rounding_leaves_indefinite_has_a_factor_still_and_any_other_has_none():
    x = np.linspace(0.0, 1.0, 400)
    bells = np.exp(-((x[:, None] - x) ** 2))  # positive definite, down to 1e-300
    assert np.linalg.eigvalsh(bells)[0] < -1e-15
    factor = np.tril(_factor(lambda: bells.copy(order="F")))
    assert factor @ factor.T == pytest.approx(bells, abs=1e-12)
    with pytest.raises(ArithmeticError, match="cannot be factorised"):
        _factor(lambda: np.diag([1.0, -1e-9]))


@pytest.mark.parametrize("error", [ArithmeticError, np.linalg.LinAlgError])
@pytest.mark.parametrize(
    ("from_end", "outcome"),
    [(0, "AlmostSolved"), (6, "rounding leaves no step towards an optimum")],
)
def test_where_rounding_leaves_no_step_it_ends_close_to_an_optimum_and_gives_up_far_from_it(
    from_end, outcome, error, monkeypatch
):
    problem, optimum = planted(np.random.default_rng(5), n=6, numbers=9, circles=9, defined=2)
    honest, ends, made = Equations.__init__, [], []

    def factored(self, program, scaling, *arguments):
        made.append(scaling)
        if len(made) in ends:
            raise error("cannot be factorised")
        honest(self, program, scaling, *arguments)

    monkeypatch.setattr(Equations, "__init__", factored)
    ours(problem)
    ends.append(len(made) - from_end)
    made.clear()
    status, *found = ours(problem)
    assert status == outcome
    if outcome == "AlmostSolved":
        assert found == pytest.approx([optimum] * 2, rel=1e-5)


def test_under_a_stiff_punch_no_step_spoils_more_of_the_multipliers_than_it_mends():
    punch = fo.scenes.SquarePunch(elements=9, punch_material=fo.fem.Material(1e2))
    turning = fo.LoadCycle({"P": 1.0}, [{"Qx": 1.0}, {"Qy": 1.0}, {"Qx": -1.0}, {"Qy": -1.0}])
    limit = fo.shakedown_limit(
        punch.condense(), turning, 0.5, simplify=False, solver="INTERIOR_POINT"
    )
    assert limit.record.attempts[0].residual <= 1e-9 and limit.residual <= 1e-9


def inside(rng, cones, depth):
    """A vector within cones, at most `depth` of its size from their boundary."""
    found = cones.tail * rng.normal(size=cones.size)
    side = np.sqrt(cones.sums(found**2))
    found *= ((1 - depth * rng.uniform(0.5, 1.0, cones.degree)) / np.where(side > 0, side, 1.0))[
        cones.of
    ]
    return (found + cones.unit) * rng.uniform(0.5, 2.0, cones.degree)[cones.of]


@pytest.mark.parametrize("depth", [1.0, 1e-3, 1e-5])
@pytest.mark.parametrize("zero", [0, 2])
def test_the_equations_of_a_step_hold(zero, depth):
    """A step fulfils its equations, by one dense solve.

    The dense system has all rows on the unknowns that the equations leave, a row that counts as
    dense, and cones of several sizes.
    """
    rng, sizes = np.random.default_rng(4), np.array([1, 1, 2, 3, 3, 4] * 5)
    rows, block = zero + int(sizes.sum()), rng.normal(size=(4, 9))
    sparse = csr_array(rng.normal(size=(rows, 13)) * (rng.random((rows, 13)) < 0.3))
    whole = Arrays(sparse, block, rng.normal(size=rows), rng.normal(size=9), zero, sizes)
    program, cones, n = Condensed(whole), Cones(sizes), 9 - zero
    scaling = Scaling(cones, inside(rng, cones, depth), depth * inside(rng, cones, depth))
    u, v = rng.normal(size=n), rng.normal(size=cones.size)
    y, z = Equations(program, scaling).solved(u, v)
    A = np.column_stack([program.rows(e) for e in np.eye(n)])
    square = np.column_stack([scaling.times(scaling.times(e)) for e in np.eye(cones.size)])
    exact = np.linalg.solve(np.block([[np.zeros((n, n)), A.T], [A, -square]]), np.r_[u, v])
    assert np.r_[y, z] == pytest.approx(exact, rel=1e-6, abs=1e-6 * np.abs(exact).max())
    assert program.columns(v) == pytest.approx(A.T @ v)
    x = program.whole(y, z)[0]
    assert (whole.matrix @ x)[:zero] == pytest.approx(whole.right[:zero])
    assert whole.right[zero:] - (whole.matrix @ x)[zero:] == pytest.approx(program.right - A @ y)
    assert whole.cost @ x == pytest.approx(program.objective @ y + program.constant)
    slopes = [whole.slack(np.zeros(9)) - whole.slack(e) for e in np.eye(9)]
    assert whole.columns(whole.right) == pytest.approx(np.array(slopes) @ whole.right)


def of_nodes(rng, nodes, depth):
    """A program like that of a contact in space, with points in its cones.

    Each node has two unknowns, a row of the block and two cones; the last unknown is in all cones.
    """
    width = 2 * nodes + 1
    columns = [[2 * k, 2 * k + 1, width - 1, width + k] for k in range(nodes)]
    entries = np.repeat(columns, 6, axis=0)
    places = np.repeat(np.arange(6 * nodes), 4), entries.ravel()
    sparse = csr_array((rng.normal(size=24 * nodes), places), shape=(6 * nodes, width + nodes))
    sizes = np.full(2 * nodes, 3)
    block = rng.normal(size=(nodes, width))
    whole = Arrays(sparse, block, np.zeros(6 * nodes), np.zeros(width), 0, sizes)
    cones = Cones(sizes)
    scaling = Scaling(cones, inside(rng, cones, depth), depth * inside(rng, cones, depth))
    return Condensed(whole), scaling, rng.normal(size=width), rng.normal(size=6 * nodes)


@pytest.mark.parametrize("depth", [1.0, 1e-2])
def test_equations_through_the_block_are_those_of_all_rows(depth):
    """Equations through the block agree with one dense solve of all rows."""
    program, scaling, u, v = of_nodes(np.random.default_rng(1), 7, depth)
    equations = Equations(program, scaling, through_block=True)
    found = np.concatenate(equations.solved(u, v))
    assert equations.through_block
    A = np.column_stack([program.rows(e) for e in np.eye(len(u))])
    square = np.column_stack([scaling.times(scaling.times(e)) for e in np.eye(len(v))])
    both = np.block([[np.zeros((len(u), len(u))), A.T], [A, -square]])
    exact = np.linalg.solve(both, np.r_[u, v])
    assert found == pytest.approx(exact, rel=1e-8, abs=1e-8 * np.abs(exact).max())


def test_without_digits_the_equations_of_a_step_are_solved_directly():
    program, scaling, u, v = of_nodes(np.random.default_rng(2), 7, 1e-4)
    equations = Equations(program, scaling, through_block=True)
    assert equations.through_block
    found = np.concatenate(equations.solved(u, v))
    assert not equations.through_block
    assert found == pytest.approx(np.concatenate(Equations(program, scaling).solved(u, v)))


def test_limits_by_steps_through_the_block_are_those_by_direct_steps(monkeypatch):
    """All programs of small contacts are solved in both ways."""
    for seed in few(range(6)):
        contact = random_contact(np.random.default_rng(seed), 6)
        question = contact, cycle(), 0.5
        direct = fo.shakedown_limit(*question, solver="INTERIOR_POINT")
        with monkeypatch.context() as patch:
            patch.setattr(interior_point, "begins_through_block", lambda program: True)
            through_block = fo.shakedown_limit(*question, solver="INTERIOR_POINT")
        assert through_block.load_factor == pytest.approx(direct.load_factor, rel=1e-8)
