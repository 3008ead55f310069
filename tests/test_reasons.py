"""An answer that is no number says why: which nodes the mean load leaves open, or which way it pulls."""

import pytest

import frictopt as fo
from systems import explained

OPEN = "with 8 of 25 nodes open under the mean load"
CALLS = {"shakedown": fo.shakedown_limit, "guaranteed": fo.guaranteed_limit, "safe": lambda *asked: fo.safe_slip(*asked, 0.5)}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
@pytest.mark.parametrize(
    ("pressure", "shear", "text"),
    [(1.0, 0.0, OPEN), (-1.0, 0.0, "the mean load pulls the bodies apart: its normal reactions sum to -2"), (0.0, 1.0, "does not press")],
)
def test_the_reason_stands_in_the_result_its_line_and_its_model(call, pressure, shear, text, rounded, punch):
    contact = rounded if pressure > 0 else punch(24)
    result = call(contact, fo.LoadCycle({"P": pressure, "Q": shear}, [{"sigma": -1.0}, {"sigma": 1.0}]), 0.6)
    printed = explained(result)
    text = "keeps the 17 nodes that the mean load closes closed and stuck" if text == OPEN and isinstance(result, fo.results.SafeSlip) else text
    assert text in result.reason and result.reason in repr(result) and result.reason in printed


def test_a_safe_slip_says_what_it_does_and_too_much_load_what_the_mean_load_does(punch, paper_cycle):
    assert fo.safe_slip(punch(8), paper_cycle, 0.7, 0.5).reason == "this slip keeps every node closed and stuck at every corner"
    too_much = fo.safe_slip(punch(8), paper_cycle, 0.7, 9.0, slip_bound=1.0)
    assert too_much.reason.startswith("no residual slip within the slip bound is safe at this load factor (the mean load presses all nodes")
