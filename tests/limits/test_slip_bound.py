"""Safe slips, and limits under a bound on the slip.

They are compared with programs over raw slips with the same bound.
"""

from functools import partial

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.liars import is_excess, lying, misread
from helpers.oracle import Oracle
from helpers.spatial import random_contact, single
from helpers.systems import (
    CYCLE,
    FIRST_PAIR,
    all_closed,
    explained,
    freed,
    linprog_limit,
    linprog_margin,
    random_system,
    stress_of,
    system,
)


@pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])
@settings(max_examples=few(10))
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(1, 7),
    corners=st.integers(1, 6),
    f=st.floats(0.05, 2.0),
    coupling=st.sampled_from([0.0, 0.5, 1.0]),
    free=st.booleans(),
    size=st.sampled_from([None, None, 0.0, 0.05, 0.3, 2.0, 100.0]),
    simplify=st.booleans(),
)
def test_the_shakedown_limit_against_a_program_over_raw_slips(
    tangents, seed, nodes, corners, f, coupling, free, size, simplify
):
    """If `free`, nothing holds the body in the plane against a slide."""
    rng = np.random.default_rng(seed)
    rel = 1e-8 if tangents == 1 else 1e-6
    f = f * rng.uniform(0.5, 1.5, nodes)
    most = None if size is None else size * rng.uniform(0.5, 1.5, nodes)
    contact = (partial(random_system, loads=("mean", *"abc")) if tangents == 1 else random_contact)(
        rng, nodes, coupling=coupling
    )
    contact = freed(contact) if free and tangents == 1 else contact
    cycle = fo.LoadCycle(
        {"mean": 1.0},
        [dict(zip("abc", row, strict=True)) for row in rng.normal(size=(corners, 3)).tolist()],
    )
    value = Oracle(contact, cycle, f, most=most).largest()
    options = {"slip_bound": most, "simplify": simplify}
    # All nodes closed.
    limit = all_closed(contact, cycle, f, **options)
    assert limit.load_factor == pytest.approx(value, rel=rel, abs=rel / 10, nan_ok=True)
    assert limit.residual <= 1e-9
    if limit.kind is not fo.LimitKind.FINITE:
        return
    guaranteed = fo.guaranteed_limit(contact, cycle, f, **options)
    assert limit.bound == pytest.approx(limit.load_factor, rel=1e-9, abs=1e-9)
    # Loads alone may open nodes of an uncoupled contact, which comes to rest at higher loads, too.
    highest = max(limit.load_factor, guaranteed.shakedown.load_factor)
    assert guaranteed.load_factor <= highest * (1 + 1e-12)
    q, p = limit.reactions
    assert (np.linalg.norm(q.reshape(*p.shape, -1), axis=-1) - f * p).max() < 1e-8
    for slip in (limit.slip, guaranteed.slip):
        assert (
            most is None
            or (np.linalg.norm(slip.reshape(nodes, -1), axis=1) <= most * (1 + 1e-12)).all()
        )
    assert fo.safe_slip(
        contact, cycle, f, limit.load_factor, slip_bound=most
    ).margin == pytest.approx(0.0, abs=1e-8)


@settings(max_examples=few(10))
# Nothing resists its only node.
@example(seed=787470, nodes=1, f=0.0625, free=True, size=None, factor=1.9, simplify=True)
@example(seed=115175, nodes=1, f=0.0625, free=True, size=2.0, factor=1e-9, simplify=False)
@given(
    seed=st.integers(0, 10**6),
    nodes=st.integers(1, 6),
    f=st.floats(0.05, 1.0),
    free=st.booleans(),
    size=st.sampled_from([None, 0.05, 0.3, 2.0]),
    factor=st.floats(0.0, 3.0),
    simplify=st.booleans(),
)
def test_safe_slips_have_the_largest_reserve_and_certificates_are_proofs(
    seed, nodes, f, free, size, factor, simplify
):
    """With a bound on the slip and without, a linear program over raw slips gives the margin in
    place of the load factor."""
    rng = np.random.default_rng(seed)
    contact = random_system(rng, nodes)
    most = None if size is None else size * rng.uniform(0.5, 1.5, nodes)
    contact = freed(contact) if free else contact
    safe = fo.safe_slip(contact, CYCLE, f, factor, slip_bound=most, simplify=simplify)
    (q0, p0) = CYCLE.mean_reaction(contact)
    (q1, p1) = CYCLE.corner_reactions(contact)
    best = linprog_margin(contact, CYCLE, f, factor, most)
    assert [safe.margin, safe.bound] == pytest.approx([best] * 2, rel=1e-7, abs=1e-8)
    assert safe.residual <= 1e-9
    assert most is None or (np.abs(safe.slip) <= most).all()
    q, p = q0 + factor * q1, p0 + factor * p1
    assert (f * (p + contact.B @ safe.slip) - np.abs(q + contact.A @ safe.slip)).min() / (
        f * p0.mean()
    ) >= safe.margin - 1e-9
    limit = linprog_limit(contact, CYCLE, f, most)[1]
    if abs(factor - limit) < 1e-6:
        return
    assert safe.exists == (factor < limit)
    if not safe.exists:
        table = safe.certificate
        stress = np.abs(stress_of(contact, safe.certificate, f))
        work = (
            table.share
            * (table.direction * q[table.corner, table.node] + f * p[table.corner, table.node])
        ).sum()
        assert (
            (stress.max() <= 1e-8 * np.abs(contact.A).max() and work < 0)
            if most is None
            else work + stress @ most < 0
        )


def test_without_any_slip_the_limit_is_the_first_onset():
    rng = np.random.default_rng(0)
    for _ in range(3):
        contact = random_system(rng, 4)
        first = fo.onset(contact, CYCLE, 0.6).slip.load_factor
        for simplify in (True, False):
            for ask in (fo.shakedown_limit, fo.guaranteed_limit):
                limit = ask(contact, CYCLE, 0.6, slip_bound=0.0, simplify=simplify)
                assert limit.load_factor == pytest.approx(first, rel=1e-9) and not limit.slip.any()


def test_a_false_denial_is_not_believed(monkeypatch):
    """A false claim that no safe slip exists is refused.

    Slips within the bound make the cyclic load safe by itself. They cannot grow with the load, so
    that they prove no unbounded limit.
    """
    contact = random_system(np.random.default_rng(0), 3)
    assert np.isfinite(fo.shakedown_limit(contact, CYCLE, 0.4, slip_bound=1e3).load_factor)
    lying(monkeypatch, lambda program, *_: None if is_excess(program) else "unbounded")
    pressing = contact.with_bonded(
        {"cyclic": (contact.A @ np.ones(3) * 1.0, np.full(3, 2.0) + contact.B @ np.ones(3))}
    )
    with pytest.raises(fo.SolverError):
        fo.shakedown_limit(
            pressing, fo.LoadCycle({"mean": 1.0}, [{"cyclic": 1.0}]), 0.4, slip_bound=1e3
        )


@pytest.mark.parametrize("share", [1.0, 1e-3])
@pytest.mark.parametrize("stiff", [1.0, 1e6, 1e9])
@pytest.mark.parametrize("most", [[0.1, 0.4], [0.4, 0.1]])
def test_a_slide_within_the_bound_is_not_lost_beside_a_stiff_node(most, stiff, share):
    """Two nodes of a sliding body reach v_0 - v_1 = 0.5 within their bounds only by a slide, and so
    carry 1.5. Node 1 has a share of the forces of node 0, and slips in proportion. Neither this
    share nor the third node changes the limit."""
    forces = np.array([1.0, share, 1.0])
    A = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, stiff]]) * np.outer(forces, forces)
    bonded = {"P": (np.zeros(3), forces), "Q": (forces * [-1.0, 1.0, 0.1], np.zeros(3))}
    contact = fo.ContactSystem.from_blocks(
        A, np.zeros((3, 3)), np.diag([2.0, 2 * share**2, stiff]), [0.0, 1.0, 2.0], bonded
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{}, {"Q": 1.0}])
    bound = [*most, 1.0] / forces
    assert fo.shakedown_limit(contact, cycle, 1.0, slip_bound=bound).load_factor == pytest.approx(
        1.5, rel=1e-8
    )


def test_a_bound_is_a_circle_whatever_the_directions_of_the_tangents():
    """One node of unit stiffness is sheared to one side by 2 q. It needs a slip of q to be centred.
    With slips of at most `most` it carries f p + most."""
    turned = np.deg2rad(31.0)
    pull = fo.LoadCycle(
        {"P": 1.0}, [{"X": 2 * np.cos(turned), "Y": 2 * np.sin(turned)}, {"P": 0.0}]
    )
    limit = fo.shakedown_limit(single(), pull, 0.5, slip_bound=0.25)
    assert limit.load_factor == pytest.approx((0.5 + 0.25) / 2, rel=1e-8)
    assert limit.largest_slip == pytest.approx(0.25, rel=1e-8)
    printed = explained(limit)
    assert "slip_bound" in printed and "1 of 1 rows bind" in printed


def test_without_friction_a_contact_without_shear_is_just_safe():
    contact = random_system(np.random.default_rng(0), 3).with_bonded(
        {name: (np.zeros(3), np.ones(3)) for name in ("mean", "cyclic")}
    )
    safe = fo.safe_slip(contact, CYCLE, 0.0, 0.5)
    assert safe.exists and safe.margin == pytest.approx(0.0, abs=1e-9)


def test_the_limit_parts_existence_to_a_billionth(punch, paper_cycle):
    """The limit separates existence from absence of a safe slip to a billionth.

    A safe slip exists at the limit and a part in 1e9 below it, and no safe slip exists a part in
    1e9 above it.
    """
    contact = punch(16)
    limit = fo.shakedown_limit(contact, paper_cycle, 0.7).load_factor
    assert [
        fo.safe_slip(contact, paper_cycle, 0.7, limit * (1 + d)).exists for d in (-1e-9, 0.0, 1e-9)
    ] == [True, True, False]


@pytest.mark.parametrize("load_factor", [1e16, 1e50, 1e150])
def test_a_load_that_hides_the_mean_load_is_refused(load_factor):
    """From 1e50 on a solver may never return."""
    with pytest.raises(fo.ModelError, match=r"load_factor: 1e\+(16|50|150) makes the cyclic loads"):
        fo.safe_slip(system(*FIRST_PAIR), CYCLE, 16.8, load_factor)


@pytest.mark.parametrize("axes", [2, 3])
def test_more_friction_adds_the_pressure_of_a_node_that_its_slip_frees_of_shear(axes):
    """The slip with the largest reserve leaves no shear. The reserve is then the same in all
    directions, f p with p = 0.5."""
    loads = {"P": np.eye(axes)[-1], "Q": np.eye(axes)[0]}
    node = fo.ContactSystem(np.eye(axes), np.zeros((1, axes)), loads)
    safe = fo.safe_slip(
        node, fo.LoadCycle({"P": 1.0}, [{"P": -0.5, "Q": 1.0}]), friction=0.4, load_factor=1.0
    )
    assert safe.margin == pytest.approx(0.5) and safe.friction_rate == pytest.approx(0.5 / 0.4)


def test_a_slip_beyond_its_bound_is_no_answer_though_nothing_resists_it(monkeypatch):
    loads = {"P": ([0.0, 0.0], [1.0, 1.0]), "Q": ([0.1, 0.1], [0.0, 0.0])}
    zero = np.zeros((2, 2))
    loose = fo.ContactSystem.from_blocks(zero, zero, np.eye(2), [0.0, 1.0], loads)
    asked = loose, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), 0.5
    assert fo.shakedown_limit(*asked, slip_bound=0.1).load_factor == pytest.approx(5.0)

    def lie(program, x, y):
        x[1:] += 10.0

    misread(monkeypatch, lie)
    with pytest.raises(fo.SolverError, match="no answer within the tolerance"):
        fo.shakedown_limit(*asked, slip_bound=0.1)


def test_a_safe_slip_says_what_it_does_and_too_much_load_what_the_mean_load_does(
    punch, paper_cycle
):
    assert (
        fo.safe_slip(punch(8), paper_cycle, 0.7, 0.5).reason
        == "this slip keeps every node closed and stuck at every corner"
    )
    too_much = fo.safe_slip(punch(8), paper_cycle, 0.7, 9.0, slip_bound=1.0)
    none = (
        "no residual slip within the slip bound is safe at this load factor with all nodes closed; "
    )
    assert too_much.reason.startswith(
        f"{none}shakedown_limit gives the load factors with a safe slip; "
    )
    assert "without residual slip the mean load presses all nodes" in too_much.reason
