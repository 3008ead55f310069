import numpy as np
import pytest

import frictopt as fo
from systems import CYCLE, FIRST_PAIR, explained, random_system, system


def test_without_friction_a_contact_without_shear_is_just_safe():
    contact = random_system(np.random.default_rng(0), 3).with_bonded({name: (np.zeros(3), np.ones(3)) for name in ("mean", "cyclic")})
    safe = fo.safe_slip(contact, CYCLE, 0.0, 0.5)
    assert safe.exists and safe.margin == pytest.approx(0.0, abs=1e-9)


def test_explain(punch, paper_cycle):
    text = explained(fo.safe_slip(punch(16), paper_cycle, 0.7, 3.0))
    assert all(part in text for part in ("safe residual slip", "margin", "clearance", "cap", "rows bind"))


def test_the_limit_parts_existence_to_a_billionth(punch, paper_cycle):
    """A safe slip exists at the limit and a part in 1e9 below it, and none a part in 1e9 above it."""
    contact = punch(16)
    limit = fo.shakedown_limit(contact, paper_cycle, 0.7).load_factor
    assert [fo.safe_slip(contact, paper_cycle, 0.7, limit * (1 + d)).exists for d in (-1e-9, 0.0, 1e-9)] == [True, True, False]


@pytest.mark.parametrize("load_factor", [1e16, 1e50, 1e150])
def test_a_load_that_hides_the_mean_load_is_refused(load_factor):
    """From 1e50 on a solver may never return."""
    with pytest.raises(fo.ModelError, match=r"load_factor: 1e\+(16|50|150) makes the cyclic loads"):
        fo.safe_slip(system(*FIRST_PAIR), CYCLE, 16.8, load_factor)


@pytest.mark.parametrize("axes", [2, 3])
def test_more_friction_adds_the_pressure_of_a_node_that_its_slip_frees_of_shear(axes):
    """The slip that stays furthest inside leaves no shear, and the node on its bounds all around: the reserve is f p, p = 0.5."""
    loads = {"P": np.eye(axes)[-1], "Q": np.eye(axes)[0]}
    node = fo.ContactSystem(np.eye(axes), np.zeros((1, axes)), loads)
    safe = fo.safe_slip(node, fo.LoadCycle({"P": 1.0}, [{"P": -0.5, "Q": 1.0}]), friction=0.4, load_factor=1.0)
    assert safe.margin == pytest.approx(0.5) and safe.friction_rate == pytest.approx(0.5 / 0.4)


def test_a_safe_slip_says_what_it_does_and_too_much_load_what_the_mean_load_does(punch, paper_cycle):
    assert fo.safe_slip(punch(8), paper_cycle, 0.7, 0.5).reason == "this slip keeps every node closed and stuck at every corner"
    too_much = fo.safe_slip(punch(8), paper_cycle, 0.7, 9.0, slip_bound=1.0)
    assert too_much.reason.startswith("no residual slip within the slip bound is safe at this load factor; shakedown_limit says which have one; ")
    assert "without residual slip the mean load presses all nodes" in too_much.reason
