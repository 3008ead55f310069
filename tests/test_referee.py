import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from systems import random_system

F = 0.5


def admissible(seed, nodes=4):
    """A contact, bonded reactions and a state of open, stuck and slipping nodes that obeys every line of the law."""
    rng = np.random.default_rng(seed)
    contact = random_system(rng, nodes).with_gap(0.1 * rng.random(nodes))
    p, w, v, before = rng.uniform(0.5, 2.0, nodes), np.zeros(nodes), rng.normal(size=nodes), np.zeros(nodes)
    q = rng.uniform(-0.99, 0.99, nodes) * F * p
    before[0], q[0] = v[0] - 0.3, -F * p[0]
    before[1], q[1] = v[1] + 0.3, F * p[1]
    before[2] = v[2]
    p[3], q[3], w[3] = 0.0, 0.0, 0.7
    bonded = (np.r_[q, p] - contact.S @ np.r_[v, w - contact.gap]).reshape(2, nodes)
    return contact, tuple(bonded), {"v": v, "w": w, "q": q, "p": p, "previous_slip": before}


@settings(max_examples=25)
@given(seed=st.integers(0, 10**6), scale=st.sampled_from([1e-9, 1.0, 1e9]))
def test_a_lawful_state_passes_in_any_units(seed, scale):
    contact, bonded, state = admissible(seed)
    stiff = fo.ContactSystem.from_blocks(scale * contact.A, scale * contact.B, scale * contact.C, contact.x, dict(contact.bonded), contact.gap)
    verdict = fo.reference.referee(stiff, tuple(scale * b for b in bonded), F, **{k: scale * a if k in "qp" else a for k, a in state.items()})
    assert verdict.residual < 1e-12


@pytest.mark.parametrize(
    ("line", "name", "node", "change"),
    [
        ("equilibrium", "v", 2, 0.1),
        ("contact", "p", 3, -0.2),
        ("contact", "w", 2, -0.1),
        ("contact", "w", 0, 0.1),
        ("bound", "q", 0, -0.1),
        ("bound", "q", 2, 5.0),
        ("direction", "q", 1, -0.1),
        ("direction", "previous_slip", 2, 0.1),
        ("direction", "previous_slip", 0, 0.6),
    ],
)
def test_each_line_of_the_law_is_watched(line, name, node, change):
    contact, bonded, state = admissible(5)
    state[name] = state[name] + change * (np.arange(4) == node)
    assert getattr(fo.reference.referee(contact, bonded, F, **state), line) > 0.02


def test_many_states_at_once_give_the_worst():
    contact, bonded, state = admissible(6)
    several = {k: np.array([a, a, a]) for k, a in state.items()}
    several["q"][1, 2] += 3.0
    one = {k: a[1] for k, a in several.items()}
    verdict = fo.reference.referee(contact, tuple(np.array([b, b, b]) for b in bonded), F, **several)
    assert verdict.bound > 1.0
    assert verdict.residual == pytest.approx(fo.reference.referee(contact, bonded, F, **one).residual, rel=1e-12)


def test_not_a_number_is_never_lawful():
    contact, bonded, state = admissible(7)
    state["q"] = state["q"] * np.nan
    assert fo.reference.referee(contact, bonded, F, **state).residual == np.inf


def test_different_numbers_of_states_are_refused():
    contact, bonded, state = admissible(8)
    with pytest.raises(fo.ModelError, match=r"arrays of \[2, 3\] states"):
        fo.reference.referee(contact, bonded, F, **state | {"q": np.zeros((2, 4)), "p": np.zeros((3, 4))})
