import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.spatial import single
from helpers.systems import random_system

F, NODE = 0.5, single()


def admissible(seed, nodes=4):
    """A contact, bonded reactions and a state that obeys every line of the law of friction.

    Its nodes are open, stuck or slipping.
    """
    rng = np.random.default_rng(seed)
    contact = random_system(rng, nodes).with_gap(0.1 * rng.random(nodes))
    p = rng.uniform(0.5, 2.0, nodes)
    w = np.zeros(nodes)
    v = rng.normal(size=nodes)
    before = np.zeros(nodes)
    q = rng.uniform(-0.99, 0.99, nodes) * F * p
    before[0], q[0] = v[0] - 0.3, -F * p[0]
    before[1], q[1] = v[1] + 0.3, F * p[1]
    before[2] = v[2]
    p[3], q[3], w[3] = 0.0, 0.0, 0.7
    bonded = (np.r_[q, p] - contact.S @ np.r_[v, w - contact.gap]).reshape(2, nodes)
    return contact, tuple(bonded), {"v": v, "w": w, "q": q, "p": p, "previous_slip": before}


@settings(max_examples=few(25))
@given(seed=st.integers(0, 10**6), scale=st.sampled_from([1e-9, 1.0, 1e9]))
def test_a_lawful_state_passes_in_any_units(seed, scale):
    contact, bonded, state = admissible(seed)
    stiff = fo.ContactSystem.from_blocks(
        scale * contact.A,
        scale * contact.B,
        scale * contact.C,
        contact.x,
        dict(contact.bonded),
        contact.gap,
    )
    verdict = fo.reference.check_contact_law(
        stiff,
        tuple(scale * b for b in bonded),
        F,
        **{k: scale * a if k in "qp" else a for k, a in state.items()},
    )
    assert verdict.residual < 1e-12


STATE = {"v": [[-0.3, 0.0]], "w": [0.0], "q": [[0.5, 0.0]], "p": [1.0]}


@pytest.mark.parametrize(
    ("line", "size", "change"),
    [
        ("equilibrium", 0.1, {"v": [[-0.2, 0.0]]}),
        ("bound", 0.3, {"v": [[0.0, 0.0]], "q": [[0.8, 0.0]]}),
        # It slips along +x, and friction pushes it on.
        ("direction", 0.3, {"v": [[-0.3, 0.0]], "previous_slip": [[-0.6, 0.0]]}),
        # Friction on its bound, but across the slip.
        ("direction", 0.1, {"previous_slip": [[-0.3, 0.1]]}),
        ("contact", 0.2, {"w": [-0.2], "p": [0.8]}),
        ("contact", 0.2, {"p": [-0.2]}),
        ("contact", 0.1, {"w": [0.1]}),
    ],
)
def test_the_referee_sees_each_violation(line, size, change):
    bonded = NODE.reaction({"P": 1.0, "X": 0.8})
    assert (
        fo.reference.check_contact_law(
            NODE, bonded, 0.5, **STATE, previous_slip=[[0.0, 0.0]]
        ).residual
        < 1e-15
    )
    verdict = fo.reference.check_contact_law(
        NODE, bonded, 0.5, **({"previous_slip": [[0.0, 0.0]]} | STATE | change)
    )
    assert getattr(verdict, line) == pytest.approx(size)


@pytest.mark.parametrize(
    ("place", "step", "across", "allowed"),
    [(1e3, 1e-9, 0.0, 1e-12), (1.0, 1e-8, 2e-15, 3e-15), (0.0, 1e-5, 1e-12, 1.1e-12)],
)
def test_a_small_slip_is_not_blamed_for_rounding_across_it(place, step, across, allowed):
    before = place * (1 + np.pi / 10)
    v = before + np.array([[0.6 * step - 0.8 * across, 0.8 * step + 0.6 * across]])
    q = np.array([[-0.3, -0.4]])
    verdict = fo.reference.check_contact_law(
        NODE,
        (q - v, [1.0]),
        0.5,
        v=v,
        w=[0.0],
        q=q,
        p=[1.0],
        previous_slip=[[before, before]],
        force_scale=1.0,
    )
    assert verdict.direction < allowed and verdict.bound < 1e-15


@pytest.mark.parametrize("step", [1e-8, 1e-3, 1.0, 1e3])
@pytest.mark.parametrize("angle", [1e-3, 1.0, 2.0, 3.1])
def test_slip_in_a_wrong_direction_counts_by_what_mends_it(step, angle):
    """Corrections of the state are to drop the slip, to turn q, or to turn the slip; the last two
    cost the same angle."""
    slip = step * np.array([np.cos(angle), np.sin(angle)])
    q = np.array([[-0.5, 0.0]])
    verdict = fo.reference.check_contact_law(
        NODE,
        (q - slip, [1.0]),
        0.5,
        v=[slip],
        w=[0.0],
        q=q,
        p=[1.0],
        previous_slip=[[0.0, 0.0]],
        force_scale=1.0,
    )
    turned, across = 2 * 0.5 * np.sin(angle / 2), step * np.sin(min(angle, np.pi / 2))
    assert verdict.direction == pytest.approx(min(step, turned, across), rel=1e-6)


def test_many_states_at_once_give_the_worst():
    contact, bonded, state = admissible(6)
    several = {k: np.array([a, a, a]) for k, a in state.items()}
    several["q"][1, 2] += 3.0
    one = {k: a[1] for k, a in several.items()}
    verdict = fo.reference.check_contact_law(
        contact, tuple(np.array([b, b, b]) for b in bonded), F, **several
    )
    assert verdict.bound > 1.0
    assert verdict.residual == pytest.approx(
        fo.reference.check_contact_law(contact, bonded, F, **one).residual, rel=1e-12
    )


def test_not_a_number_is_never_lawful():
    contact, bonded, state = admissible(7)
    state["q"] = state["q"] * np.nan
    assert fo.reference.check_contact_law(contact, bonded, F, **state).residual == np.inf


def test_different_numbers_of_states_are_refused():
    contact, bonded, state = admissible(8)
    with pytest.raises(fo.ModelError, match=r"arrays of \[2, 3\] states"):
        fo.reference.check_contact_law(
            contact, bonded, F, **state | {"q": np.zeros((2, 4)), "p": np.zeros((3, 4))}
        )
