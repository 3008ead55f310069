"""What an increment does not need is left out, and the answer is the same with everything kept."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.transients.increments import ExactIncrement, FrozenBoundIncrement
from systems import mirrored, odd

ENGINES = pytest.mark.parametrize("engine", [ExactIncrement, FrozenBoundIncrement])


def same(lean, full):
    for name in ("slip", "gap", "q", "p"):
        assert getattr(lean, name) == pytest.approx(getattr(full, name), abs=1e-10)
    return (lean.status == full.status).all() and max(lean.residual, full.residual) < 1e-9


@ENGINES
def test_half_of_a_symmetric_increment_is_enough(engine):
    rng = np.random.default_rng(3)
    halved = 0
    for nodes in (2, 3, 4, 5, 6):
        contact = mirrored(rng, nodes, gap=nodes > 3)
        lean, full = (engine(contact, 0.3, simplify=simplify) for simplify in (True, False))
        slip = 0.2 * odd(rng, nodes)
        for load in ({"mean": 1.0, "one": 0.7}, {"mean": 1.0, "one": -1.5, "other": 2.5}, {"mean": 0.1, "other": 2.0}):
            found, kept = (one.solve(slip, contact.reaction(load)) for one in (lean, full))
            assert same(found, kept) and kept.record.left_out == ()
            halved += "mirror" in found.record.left_out[0]
            stuck = found.status == 0
            assert (found.slip[stuck] == slip[stuck]).all()
            slip = kept.slip if kept.record.solver != "closed form" else slip
            slip = (slip - slip[::-1]) / 2
    assert halved > 10


@ENGINES
def test_an_increment_that_is_not_symmetric_is_not_halved(engine):
    rng = np.random.default_rng(4)
    contact = mirrored(rng, 5)
    q, p = contact.reaction({"mean": 1.0, "one": 1.5})
    uneven = 0.3 * np.ones(5)
    uneven[0] = 0.31
    tilted = p * (1 + 1e-10 * np.arange(5))
    shifted = 0.05 * np.arange(-2, 3) + 1e-12
    for friction, slip, load in (
        (uneven, np.zeros(5), (q, p)),
        (0.3, 0.1 * np.ones(5), (q, p)),
        (0.3, shifted, (q, p)),
        (0.3, np.zeros(5), (q, tilted)),
    ):
        found, kept = (engine(contact, friction, simplify=simplify).solve(slip, load) for simplify in (True, False))
        assert same(found, kept) and not any("mirror" in text for text in found.record.left_out)


@ENGINES
def test_where_the_half_has_no_answer_the_whole_is_asked(engine, monkeypatch):
    contact = mirrored(np.random.default_rng(5), 4)
    bonded = contact.reaction({"mean": 1.0, "one": 2.0})
    lean, full = (engine(contact, 0.3, simplify=simplify) for simplify in (True, False))
    expected = full.solve(np.zeros(4), bonded)
    assert "mirror" in lean.solve(np.zeros(4), bonded).record.left_out[0]

    def none(slip, load):
        raise fo.NoContinuation("no symmetric state")

    monkeypatch.setattr(lean._half[1], "solve", none)
    found = lean.solve(np.zeros(4), bonded)
    assert same(found, expected) and not any("mirror" in text for text in found.record.left_out)


@pytest.mark.parametrize("engine", ["qp", "milp"])
def test_transients_of_the_paper_scene(engine, punch, paper_cycle):
    contact = punch(8)
    lean, full = (fo.march(contact, paper_cycle, 0.7, 2.5, cycles=1, engine=engine, steps=3, simplify=simplify) for simplify in (True, False))
    assert full.record.left_out == () and any("of 9 increments, mirror symmetry: v is odd, 5 of 9 nodes" in text for text in lean.record.left_out)
    for name in ("slip", "q", "p", "work"):
        assert getattr(lean, name) == pytest.approx(getattr(full, name), abs=1e-11)
