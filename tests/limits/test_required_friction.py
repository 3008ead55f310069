import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from scipy.stats import lognorm, norm, uniform

import frictopt as fo
from helpers.cases import few
from helpers.liars import misread
from helpers.separation import open_contact, rests
from helpers.systems import (
    BLOCK,
    CYCLE,
    NODE,
    PUSHED_AND_PULLED,
    SEEDS,
    fixed_contact,
    has_safe_slip,
    random_system,
    stress_of,
    system,
    unit_nodes,
)


def brute_force(contact, cycle, load_factor, bound=None):
    """Least friction by bisection on the feasibility of all rows of all corners in raw slips.

    No slip exceeds `bound`. The value is inf if no friction up to 1000 is enough.
    """
    if not has_safe_slip(contact, cycle, 1e3, load_factor, bound):
        return np.inf
    least, most = 0.0, 1e3
    while most - least > 1e-7 * most + 1e-9:
        middle = np.sqrt(least * most) if least > 1e-4 else (least + most) / 2
        enough = has_safe_slip(contact, cycle, middle, load_factor, bound)
        least, most = (least, middle) if enough else (middle, most)
    return most


@settings(max_examples=few(12))
@given(
    seed=SEEDS,
    nodes=st.integers(1, 5),
    factor=st.floats(0.01, 4.0),
    coupling=st.sampled_from([0.0, 0.5, 1.0]),
    most=st.none() | st.floats(0.0, 2.0),
)
@example(seed=0, nodes=3, factor=1.0, coupling=0.0, most=None)  # a node opens in each cycle
@example(seed=1, nodes=2, factor=1.0, coupling=0.5, most=1e-147)
def test_required_friction_by_brute_force(seed, nodes, factor, coupling, most):
    contact = random_system(np.random.default_rng(seed), nodes, coupling=coupling)
    required = fo.required_friction(contact, CYCLE, factor, slip_bound=most)
    expected = brute_force(contact, CYCLE, factor, most)
    assert required.residual <= 1e-9
    # No row of the brute force knows nodes that are open in all or in a part of the cycle.
    if required.open.any() or not required.events.empty:
        assert required.required <= expected * (1 + 1e-5)
    elif expected < 500:
        assert required.required == pytest.approx(expected, rel=1e-5, abs=1e-6)
        assert most is None or required.largest_slip <= most * (1 + 1e-9)
    elif np.isfinite(required.required):  # more friction than the brute force tries
        assert required.required > 500


@pytest.mark.parametrize("make", [open_contact, fixed_contact])
@settings(max_examples=few(3, 1))
@given(seed=st.integers(0, 10**6))
def test_required_friction_is_where_the_ends_of_the_safe_load_factors_cross_the_load(make, seed):
    """With nodes that stay open, and where a part of the cycle is fixed."""
    contact, *rest = make(seed)
    cycle, f = rest if make is fixed_contact else (CYCLE, rest[0])
    limit = fo.shakedown_limit(contact, cycle, f)
    assume(1e-3 < limit.load_factor < np.inf and limit.open.any() == (make is open_contact))
    factor = limit.least + 0.9 * (limit.load_factor - limit.least)
    required = fo.required_friction(contact, cycle, factor)
    assume(np.isfinite(required.required) or make is open_contact)
    assert make is fixed_contact or required.required <= f * (1 + 1e-5)
    enough = fo.shakedown_limit(contact, cycle, required.required * (1 + 1e-4))
    less = fo.shakedown_limit(contact, cycle, required.required * (1 - 1e-4))
    assert enough.least <= factor <= enough.load_factor
    assert not less.least <= factor <= less.load_factor
    assert required.reactions[1].min() >= -1e-9


def test_a_pressing_whose_multipliers_prove_nothing_is_no_answer(monkeypatch):
    contact = random_system(np.random.default_rng(1), 3)

    def ask():
        return fo.required_friction(contact, CYCLE, 9.0, slip_bound=0.0)

    assert ask().required == np.inf

    def more(program, x, y):
        y += 0.1

    misread(monkeypatch, more)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        ask()


def test_faces_that_lock_themselves_need_slips_without_bound():
    """A dovetail that is pushed from below is held by friction alone, equal to the cotangent of its
    angle. With this friction the slip has no bound."""
    contact = fo.scenes.Dovetail(angle=50, elements=4, growth=2.0).condense()
    cot = 1 / np.tan(np.radians(50))
    cycle = fo.LoadCycle({"pull": 1.0}, [{"pull": 1.0}, {"pull": -1.0}])
    free = fo.required_friction(contact, cycle, 1.5)
    assert free.required == pytest.approx(cot, rel=1e-5) and free.largest_slip > 1e6
    held = [fo.required_friction(contact, cycle, 1.5, slip_bound=most) for most in (1e2, 1e4)]
    assert [required.largest_slip for required in held] == pytest.approx([1e2, 1e4])
    assert held[0].required > held[1].required > free.required
    assert "within the slip bound" in held[0].reason
    for required, most in few([*zip(held, (1e2, 1e4), strict=True)], 1):
        less, more = (
            fo.shakedown_limit(contact, cycle, f, slip_bound=most).load_factor
            for f in (required.bound, required.required)
        )
        assert less < 1.5 < more < 1.5001
    assert (
        "within the slip bound" in fo.required_friction(contact, cycle, 1.5, slip_bound=1.0).reason
    )
    with pytest.raises(
        fo.SolverError,
        match=r"no slip is safe with 0\.838.*a slip of up to .* is safe with 0\.839.*give a smaller slip_bound",
    ):
        fo.required_friction(contact, cycle, 1.5, slip_bound=1e6)


def test_it_is_proven_from_both_sides(punch, paper_cycle):
    contact = punch(40)
    required = fo.required_friction(contact, paper_cycle, 1.5)
    (q0, p0) = paper_cycle.mean_reaction(contact)
    (q1, p1) = paper_cycle.corner_reactions(contact)
    q, p = q0 + 1.5 * q1 + contact.A @ required.slip, p0 + 1.5 * p1 + contact.B @ required.slip
    assert (np.abs(q) <= required.required * p + 1e-12 * p.mean()).all()
    less, table = required.bound, required.mechanism
    assert (1 - 1e-5) * required.required < less < required.required
    node, corner, sense, share = (
        table[name].to_numpy() for name in ("node", "corner", "direction", "share")
    )
    assert np.abs(stress_of(contact, table, less)).max() < 1e-9 * np.abs(contact.A).max()
    work = (
        sense * (q0 + 1.5 * q1[corner])[np.arange(len(node)), node]
        + less * (p0 + 1.5 * p1[corner])[np.arange(len(node)), node]
    )
    assert share @ work < 0
    assert fo.shakedown_limit(contact, paper_cycle, required.required).load_factor == pytest.approx(
        1.5, rel=1e-5
    )


def test_where_no_friction_is_needed():
    still = system(np.eye(2), np.zeros((2, 2)), 0.3, 1.0, 0.0, 0.1)
    required = fo.required_friction(still, CYCLE, 1.0)
    assert required.required == 0.0 and np.isnan(required.bound) and required.mechanism.empty
    assert np.allclose(required.slip, -0.3) and "none is needed" in required.reason


def test_where_no_friction_is_enough():
    """No friction is enough for a node that slip cannot press.

    The second node is pulled at one corner, and slip presses one node only as much as it unloads
    the other.
    """
    B = np.array([[0.5, -0.5], [-0.5, 0.5]])
    pulled = system(np.eye(2), B, 0.0, (1.0, 1.0), 0.2, (0.0, 3.0))
    required = fo.required_friction(pulled, CYCLE, 1.0, slip_bound=1.0)
    assert required.required == np.inf and np.isnan(required.slip).all()
    assert "no friction is enough" in required.reason and "x = 1" in required.reason
    with pytest.raises(fo.ModelError, match="problem: this answer has none"):
        print(required.problem)
    table = required.mechanism
    assert set(table["direction"]) == {0}
    assert dict(zip(table["node"], table["corner"], strict=True))[1] == 0
    assert np.isfinite(fo.required_friction(pulled, CYCLE, 0.6).required)
    # A slip of 8 keeps node 1 open, and node 0 sticks.
    opened = fo.required_friction(pulled, CYCLE, 1.0)
    assert opened.open.tolist() == [False, True] and opened.required == pytest.approx(1.6, rel=1e-6)
    assert rests(pulled, CYCLE, opened.required * 1.001, 1.0, initial_state=opened.state)


def test_friction_next_to_none_is_no_answer():
    hardly = system(np.eye(1), np.zeros((1, 1)), 0.0, 1.0, 1e-7, 0.0)
    with pytest.raises(fo.SolverError, match="is enough and 0 is not"):
        fo.required_friction(hardly, CYCLE, 1.0)


def test_pressures_within_rounding_of_zero_are_no_answer():
    bare = system(np.eye(2), np.zeros((2, 2)), 0.0, (1.0, 1e-8), 0.2, 0.0)
    with pytest.raises(
        fo.SolverError, match="with the best residual slip, the pressure at one node is only"
    ):
        fo.required_friction(bare, CYCLE, 1.0)


def test_too_little_friction_is_proven_where_a_node_has_a_small_part_of_the_margin():
    """The node has a millionth of the pressure and limits the friction. The margin hardly feels a
    little less friction, so that the step to the proof is wider."""
    light = 1e-6
    contact = system(np.eye(2), np.zeros((2, 2)), 0.0, (1.0, light), (0.1, 0.5 * light), 0.0)
    required = fo.required_friction(contact, CYCLE, 1.0)
    assert required.required == pytest.approx(0.5, rel=1e-5)
    assert required.required * (1 - 1e-5) < required.bound < required.required
    assert not fo.safe_slip(contact, CYCLE, required.bound, 1.0).exists
    assert set(required.mechanism["node"]) == {1}


def test_where_the_mean_load_pulls_more_load_needs_less_friction():
    """A node that is pulled by 1 and pressed by lam at corners that shear it by +-0.6 lam needs f
    (lam - 1) >= 0.6 lam. Its least safe load factor agrees."""
    cycle = fo.LoadCycle({"P": -1.0}, [{"N": 1.0, "Q": 0.6}, {"N": 1.0, "Q": -0.6}])
    required = [fo.required_friction(NODE, cycle, load_factor) for load_factor in (0.5, 2.0, 5.0)]
    assert [each.required for each in required] == pytest.approx([np.inf, 1.2, 0.75], rel=1e-6)
    for each in required[1:]:
        least = fo.shakedown_limit(NODE, cycle, each.required).least
        assert least == pytest.approx(each.load_factor, rel=1e-4)
        assert fo.shakedown_limit(NODE, cycle, each.bound).least > each.load_factor


def by_slips(S, loads, node, slips):
    """Least friction of one of two nodes, of which the other one is open, by trying all slips.

    The loads have the shape (K, 4).
    """
    closed, other = [node, node + 2], [1 - node, 3 - node]
    take = S[closed][:, other] @ np.linalg.inv(S[other][:, other])
    moved = np.multiply.outer(S[closed, node] - take @ S[other, node], slips)
    q, p = (loads[:, closed] - loads[:, other] @ take.T).T[:, None] + moved[..., None]
    return np.where(p > 0, np.abs(q) / p, np.inf).max(axis=1).min()


def test_less_friction_is_enough_with_the_node_that_it_leaves_open():
    """Under the mean load node 1 opens with friction 0.25 and does not open with 0.3. The open node
    leaves a contact of one node, whose slips are tried here."""
    S = np.array(
        [
            [1.8, 0.1, -0.6, -0.6],
            [0.1, 1.0, 0.0, 0.5],
            [-0.6, 0.0, 1.5, -0.2],
            [-0.6, 0.5, -0.2, 1.4],
        ]
    )
    mean = np.array([-0.1, 0.1, 1.2, 1.0])
    corners = np.array([[1.5, -0.2, -0.4, 0.2], [-0.5, 0.5, -0.2, 0.1], [-0.9, 0.4, -0.1, -0.1]])
    contact = fo.ContactSystem(
        S,
        [[0, 0], [1, 0]],
        {"P": mean} | {str(k): r for k, r in enumerate(corners)},
        gap=[0.0, 1.2],
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"0": 1.0}, {"1": 1.0}, {"2": 1.0}])
    required = fo.required_friction(contact, cycle, 0.2)
    assert required.required == pytest.approx(
        by_slips(S, mean + 0.2 * corners, 0, np.linspace(-1, 1, 200_001)), rel=1e-4
    )
    assert required.open.tolist() == [False, True]
    assert required.reason.startswith(
        "no residual slip is safe with less, 1 node open and the others closed: see the mechanism"
    )
    opened, pressed = (fo.shakedown_limit(contact, cycle, f) for f in (0.25, 0.3))
    assert opened.load_factor < pressed.load_factor
    assert pressed.open.tolist() == [False, True]
    assert mean[3] < 1.2 * S[3, 3]


def test_as_assembled_a_joint_slips_with_more_friction_than_it_needs():
    """The reason says so, and names the question that answers it. Without coupling it does not."""
    joint = fo.scenes.Dovetail(angle=45, elements=6, edge_radius=2.0).condense()
    sway = fo.LoadCycle({"pull": 1.0}, [{"sway": 0.1}, {"sway": -0.1}])
    required = fo.required_friction(joint, sway, 0.6)
    steady = fo.steady_state(joint, sway, 1.1 * required.required, 0.6)
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP
    assert "slip need not stop from every start" in required.reason
    assert "limit_after_protocol" in required.reason
    limit = fo.shakedown_limit(joint, sway, 1.1 * required.required)
    as_assembled = fo.limit_after_protocol(limit, scan=4)
    assert as_assembled.load_factor < 0.6
    node = unit_nodes({"P": ([0.0], [1.0]), "Q": ([1.0], [0.0])})
    uncoupled = fo.required_friction(node, fo.LoadCycle({"P": 2.0}, [{"Q": -1.0}, {"Q": 3.0}]), 1.0)
    assert "start" not in uncoupled.reason


@pytest.mark.parametrize("seed", few(range(3)))
def test_the_probability_is_that_of_the_limits_of_drawn_frictions(seed):
    """Some slip is safe with just those of the drawn frictions that exceed the required one."""
    contact = random_system(np.random.default_rng(seed), 4)
    required = fo.required_friction(contact, CYCLE, 1.0)
    friction = lognorm(0.2, scale=1.05 * required.required)
    drawn = friction.rvs(40, random_state=seed)
    safe = [fo.shakedown_limit(contact, CYCLE, f).load_factor >= 1 for f in drawn]
    assert (drawn > required.required).tolist() == safe and 0 < sum(safe) < 40
    probability = required.probability(friction)
    assert abs(np.mean(safe) - probability) <= 3 * np.sqrt(probability * (1 - probability) / 40)


def test_the_probability_of_a_block_is_that_of_a_closed_form():
    """A force of 0.8 on a pressure of 1 needs friction of 0.8; 0 always suffices for no force."""
    cycle = fo.LoadCycle({"N": 1.0}, [{"F": 0.8}, {"F": -0.8}])
    needed = fo.required_friction(BLOCK, cycle, 1.0)
    for friction, wanted in (
        (uniform(0.6, 0.4), 0.5),
        (norm(1.0, 0.1), norm.cdf(2.0)),
        (lognorm(0.25, scale=0.8), 0.5),
    ):
        assert needed.probability(friction) == pytest.approx(wanted, abs=1e-4)


@pytest.mark.parametrize("friction", [norm, norm([0.1, 0.2], 0.1), norm(np.nan), 0.3, "norm"])
def test_only_a_distribution_of_one_number_has_a_probability(friction):
    required = fo.required_friction(BLOCK, PUSHED_AND_PULLED, 1.0)
    with pytest.raises(fo.ModelError, match=r"friction: .*frozen distribution of scipy\.stats"):
        required.probability(friction)


def test_a_node_in_space_needs_the_radius_of_the_smallest_circle_around_its_shears():
    """The required friction is the radius of the circle around the shears, over the pressure.

    Three shears of size 1 are 120 degrees apart, and slip takes the mean shear away. A pressure of
    2 gives f = 1 / 2; at half the load f is a quarter.
    """
    node = fo.ContactSystem(
        np.eye(3), [[0, 0, 0]], {"P": [0, 0, 2], "X": [1, 0, 0], "Y": [0, 1, 0]}
    )
    angles = 2 * np.pi * np.arange(3) / 3
    cycle = fo.LoadCycle(
        {"P": 1.0, "X": 0.7}, [{"X": float(np.cos(a)), "Y": float(np.sin(a))} for a in angles]
    )
    for load_factor, expected in ((1.0, 0.5), (0.5, 0.25)):
        required = fo.required_friction(node, cycle, load_factor)
        assert required.required == pytest.approx(expected, rel=1e-5)
        assert required.bound < required.required
        q, p = required.reactions
        assert (np.hypot(q[..., 0], q[..., 1]) <= required.required * p * (1 + 1e-9)).all()
    assert required.slip.shape == (1, 2)
    assert {"slip1", "slip2"} <= set(required.to_frame()) & set(required.mechanism)


def test_no_friction_is_enough_in_space_for_a_node_that_the_load_opens():
    """With a bound on the slip the nodes have to stay as they are."""
    pulled = fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "N": [0, 0, -1]})
    cycle = fo.LoadCycle({"P": 1.0}, [{"N": 1.0}, {"N": -1.0}])
    answer = fo.required_friction(pulled, cycle, 2.0, slip_bound=1.0)
    assert answer.required == np.inf and "open one of these nodes (at (0, 0, 0))" in answer.reason
    assert answer.mechanism[["node", "corner", "slip1", "slip2"]].to_numpy().tolist() == [
        [0, 0, 0, 0]
    ]
