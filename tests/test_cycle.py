import numpy as np
import pytest

import frictopt as fo
from systems import random_system


@pytest.mark.parametrize(
    ("mean", "corners", "message"),
    [
        ({"P": 1.0}, [], "corners: empty"),
        ({"P": 1.0}, {"sigma": 1.0}, "corners: a dict; give a list"),
        ({"P": 1.0}, "sigma", "corners: a str"),
        ({"P": 1.0}, [1.0], r"corners\[0\]: a float"),
        ({"P": np.nan}, [{"sigma": 1.0}], r"mean\['P'\]: nan; it must be finite"),
        ({"P": 1.0}, [{"sigma": 1.0}, {"sigma": np.inf}], r"corners\[1\]\['sigma'\]: inf"),
        ({"P": 1j}, [{"sigma": 1.0}], r"mean\['P'\]: 1j"),
        ({"P": "1"}, [{"sigma": 1.0}], r"mean\['P'\]: '1'"),
        ({"P": [1.0, 2.0]}, [{"sigma": 1.0}], "is not one real number"),
        (1.0, [{"sigma": 1.0}], "mean: a float"),
        ({1: 1.0}, [{"sigma": 1.0}], "load case name 1"),
    ],
)
def test_bad_cycles_are_refused(mean, corners, message):
    with pytest.raises(fo.ModelError, match=message):
        fo.LoadCycle(mean=mean, corners=corners)


def test_reactions_of_a_cycle():
    system = random_system(np.random.default_rng(0), 3, loads=("mean", "a", "b"))
    cycle = fo.LoadCycle(mean={"mean": 2.0}, corners=[{"a": 1.0}, {"a": -1.0, "b": 0.5}, {}])
    q1, p1 = cycle.corner_reactions(system)
    assert np.array_equal(cycle.mean_reaction(system)[1], 2 * system.bonded["mean"][1])
    assert np.allclose(q1[1], -system.bonded["a"][0] + 0.5 * system.bonded["b"][0])
    assert not q1[2].any() and not p1[2].any() and p1.shape == (3, 3)


def test_cycles_cannot_be_changed():
    cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": 1.0}])
    with pytest.raises(TypeError):
        cycle.corners[0]["sigma"] = 2.0
    with pytest.raises(AttributeError):
        cycle.mean = {}
