"""The families of starts of a study."""

import numpy as np
import pytest

import frictopt as fo
from frictopt.histories.starts import Start, no_slip, random_slips, safe_slips
from systems import CYCLE, random_system


def test_safe_starts_are_multiples_of_the_safe_slip_and_above_the_limit_of_the_one_at_it():
    contact = random_system(np.random.default_rng(3), 4)
    limit = fo.shakedown_limit(contact, CYCLE, 0.4)
    (start,) = safe_slips([-2.0])
    below, above = 0.5 * limit.load_factor, 1.2 * limit.load_factor
    for load_factor, slip in ((below, fo.safe_slip(contact, CYCLE, 0.4, below).slip), (above, limit.slip)):
        assert start.slip_at(contact, CYCLE, 0.4, load_factor) == pytest.approx(-2.0 * slip, rel=1e-9)
    assert no_slip()[0].slip_at(contact, CYCLE, 0.4, 1.0) is None


def test_random_slips_have_their_amplitude_no_mean_and_a_seed_each(punch):
    scene = punch(16)
    starts = random_slips(scene, [0.1, 20.0], 4, seed=5)
    assert [start.family for start in starts] == 2 * (4 * ["smooth"] + 4 * ["rough"])
    assert [start.seed for start in starts] == list(range(5, 21))
    for start, amplitude in zip(starts, 8 * [0.1] + 8 * [20.0], strict=True):
        assert np.sqrt(np.mean(start.slip**2)) == pytest.approx(amplitude, rel=1e-12)
        assert abs(start.slip.mean()) < 1e-12 * amplitude
        left = np.polynomial.Chebyshev.fit(scene.x, start.slip, 6)(scene.x) - start.slip
        assert (np.abs(left).max() < 1e-10 * amplitude) == (start.family == "smooth")
    assert len({start.slip.tobytes() for start in starts}) == 16
    again = random_slips(scene, [0.1, 20.0], 4, seed=5)
    assert all((one.slip == other.slip).all() for one, other in zip(starts, again, strict=True))


@pytest.mark.parametrize(
    ("message", "make"),
    [
        ("count: 9223372036854775808", lambda scene: random_slips(scene, [1.0], 2**63)),
        ("one node", lambda _: random_slips(random_system(np.random.default_rng(0), 1), [1.0], 1)),
        ("family", lambda _: Start("", "name")),
        (r"name of a start: '\\ud800'", lambda _: Start("family", "\ud800")),
        ("give one of them", lambda _: Start("mine", "name", slip=[1.0], safe_multiple=1.0)),
    ],
)
def test_bad_starts_are_refused(punch, message, make):
    with pytest.raises(fo.ModelError, match=message):
        make(punch(16))
