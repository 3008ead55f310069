"""Limits after a protocol.

They are compared with the limits on both sides, computed values, and the transients that they
claim.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.systems import BLOCK, CYCLE, FIRST_PAIR, PULL, random_system, system

UNLOADED = [fo.starts.LoadStep({"P": 0.2})]
AT_CORNER = [
    fo.starts.LoadStep({"P": 1.0}, {"sigma": 1.0}),
    fo.starts.LoadStep({"P": 0.3}, {"sigma": 1.0}),
    fo.starts.LoadStep({"P": 1.0}, {"sigma": 1.0}),
]
# Load factor over lambda_2 up to which the contact comes to rest, to 0.005: nothing done,
# assembled, unloaded, at the corner, overload to 2 lambda_2
TABLE = {
    (16, 0.7): (0.216, 0.967, 0.805, 0.979, 0.912),
    (124, 0.5): (0.141, 0.978, 0.902, 0.972, 0.841),
}


@pytest.mark.parametrize("case", [(16, 0.7), (124, 0.5)])
def test_the_table_of_protocols(case, paper_punch):
    (elements, friction), wanted = case, TABLE[case]
    contact = paper_punch(elements)
    limit = fo.shakedown_limit(contact, PULL, friction)
    overload = [fo.starts.LoadStep({"P": 1.0, "sigma": 2 * limit.load_factor})]
    option_sets = [
        {"start": "worst", "protocol": steps} for steps in ((), UNLOADED, AT_CORNER, overload)
    ]
    option_sets.insert(1, {"start": "assembled"})
    for options, ratio in zip(option_sets, wanted, strict=True):
        one = fo.limit_after_protocol(limit, **options)
        assert one.ratio == pytest.approx(ratio, abs=0.005), options
        assert one.load_factor < one.upper <= one.load_factor + 1.1e-4 * limit.load_factor
        assert one.residual <= 1e-9


def test_nothing_done_to_the_worst_start_is_the_guaranteed_limit(paper_punch):
    for contact, cycle, friction in (
        (system(*FIRST_PAIR), CYCLE, 0.6),
        (paper_punch(16), PULL, 0.5),
    ):
        lower = fo.guaranteed_limit(contact, cycle, friction).load_factor
        limit = fo.shakedown_limit(contact, cycle, friction)
        one = fo.limit_after_protocol(limit, start="worst", tolerance=1e-5)
        assert one.load_factor == pytest.approx(lower, abs=2e-5 * one.shakedown_limit)
        assert one.monotonic


def test_a_node_that_stays_open_leaves_the_worst_start_as_it_is():
    pair = system(*FIRST_PAIR)
    blocks = [np.pad(block, (0, 1)) for block in (pair.A, pair.B, pair.C)]
    for block in blocks[::2]:
        block[2, 2] = 1.0
    loads = {
        name: (np.pad(q, (0, 1)), np.pad(p, (0, 1), constant_values=1.0))
        for name, (q, p) in pair.bonded.items()
    }
    contact = fo.ContactSystem.from_blocks(*blocks, np.arange(3), loads, [0, 0, 5])
    one, other = (
        fo.limit_after_protocol(
            fo.shakedown_limit(which, CYCLE, 0.6), start="worst", tolerance=1e-5
        )
        for which in (pair, contact)
    )
    assert other.load_factor == pytest.approx(one.load_factor, abs=2e-5 * one.shakedown_limit)
    # Slips that go equally far in a direction are starts in one contact, not always in both.
    assert len(other.starts) > 2 < len(one.starts)


def test_assembly_from_no_load_is_no_slip_and_the_safe_start_rests_up_to_the_limit(paper_punch):
    contact = paper_punch(16)
    limit = fo.shakedown_limit(contact, PULL, 0.7)
    assembled, none, safe = (
        fo.limit_after_protocol(limit, start=start)
        for start in ("assembled", np.zeros(17), limit.slip)
    )
    assert assembled.ratio == pytest.approx(none.ratio, abs=2e-4)
    assert safe.ratio > 0.9998
    assert fo.steady_state(contact, PULL, 0.7, none.load_factor).outcome is fo.Outcome.SHAKEDOWN
    assert fo.steady_state(contact, PULL, 0.7, none.upper).outcome is fo.Outcome.CYCLIC_SLIP


def test_rest_above_a_load_factor_at_which_slip_goes_on_is_reported(paper_punch):
    """The more it is loaded, the more this contact is unloaded before."""
    steps = [fo.starts.LoadStep({"P": 1.25}, {"P": -0.82})]
    one = fo.limit_after_protocol(
        fo.shakedown_limit(paper_punch(16), PULL, 0.7),
        start="worst",
        protocol=steps,
        up_to=1.2,
        scan=12,
        tolerance=1e-2,
    )
    assert not one.monotonic and 0.2 < one.ratio < 0.4
    tried = one.to_frame()
    assert tried["outcome"].iloc[-1] == "rest"
    assert set(tried.loc[tried["load_factor"] <= one.load_factor, "outcome"]) == {"rest"}
    assert tried["load_factor"].is_monotonic_increasing and (tried["outcome"] == "slip").sum() >= 3


def test_a_limit_that_is_not_finite_needs_a_largest_load_factor():
    limit = fo.shakedown_limit(system(*FIRST_PAIR), fo.LoadCycle({"mean": 1.0}, [{}]), 0.6)
    with pytest.raises(fo.ModelError, match="up_to"):
        fo.limit_after_protocol(limit)
    assert fo.limit_after_protocol(limit, up_to=2.0, scan=3).load_factor == 2.0


def test_a_contact_that_slides_away_is_undecided_and_not_at_rest():
    """Only friction holds the pair. Pulled along by 3 lam at each node it slides freely from 3 lam
    = f p on."""
    loads = {"mean": ([0, 0], [1, 1]), "cyclic": ([1, -1], [0, 0]), "pull": ([1, 1], [0, 0])}
    free = fo.ContactSystem.from_blocks(
        [[1, -1], [-1, 1]], np.zeros((2, 2)), np.eye(2), [0.0, 1.0], loads
    )
    one = fo.limit_after_protocol(
        fo.shakedown_limit(free, CYCLE, 0.5),
        protocol=[fo.starts.LoadStep({"mean": 1.0}, {"pull": 3.0})],
        scan=5,
        tolerance=1e-3,
    )
    tried = one.to_frame()
    assert one.load_factor == pytest.approx(0.5 / 3, abs=1e-3)
    assert set(tried.loc[tried["load_factor"] > 0.5 / 3, "outcome"]) == {"UNDECIDED"}
    assert "rest is possible there" in one.note and "segment 0 of the protocol" in str(one)


def test_a_protocol_that_slides_the_body_off_is_named_as_the_reason():
    """Friction holds 4 nodes x 0.5 x 1 = 2, and 5 slides the rod off at any load factor."""
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
    slide = [fo.starts.LoadStep({"pressure": 1.0, "force": 5.0})]
    limit = fo.shakedown_limit(rod, cycle, 0.5)
    one = fo.limit_after_protocol(limit, protocol=slide, scan=2, tolerance=0.1)
    assert one.load_factor == 0.0 and "may slide" in one.note and one.note in repr(one)
    held = fo.limit_after_protocol(limit, scan=2, up_to=1.0, tolerance=0.1)
    assert held.upper < 1.0 and held.note == "" and "note" not in repr(held)


# The friction after a protocol


@pytest.mark.parametrize("force", [0.3, 0.8])
def test_a_block_as_assembled_needs_the_friction_of_its_load(force):
    """A force to and fro on a pressure of 1, against a spring, needs friction `force`."""
    cycle = fo.LoadCycle({"N": 1.0}, [{"F": force}, {"F": -force}])
    needed = fo.required_friction(BLOCK, cycle, 1.0)
    one = fo.friction_after_protocol(needed)
    assert one.lower <= force <= one.required * (1 + 1e-9)
    assert one.required - one.lower <= 1.1e-4 * one.tried["friction"].max()
    assert one.least == needed.required and one.monotonic


@pytest.mark.parametrize("seed", few(range(6)))
def test_with_the_friction_as_assembled_it_rests_and_with_less_it_slips(seed):
    """Steady states from no slip confirm both frictions; less than the required one never rests."""
    contact = random_system(np.random.default_rng(seed), 4)
    needed = fo.required_friction(contact, CYCLE, 1.0)
    one = fo.friction_after_protocol(needed, start=np.zeros(4), scan=4, tolerance=1e-3)
    assert one.least <= one.required and one.residual <= 1e-9
    for friction, outcome in ((one.required, "SHAKEDOWN"), (one.lower, "CYCLIC_SLIP")):
        assert fo.steady_state(contact, CYCLE, friction, 1.0).outcome.name == outcome
    limit = fo.shakedown_limit(contact, CYCLE, one.required)
    enough = fo.limit_after_protocol(limit, start=np.zeros(4), scan=1)
    assert enough.shakedown_limit >= 1 - 1e-9


def test_more_friction_holds_worse_slips_and_the_gap_is_told():
    """From the worst start the pair rests with some frictions, and slips with all larger ones."""
    pair = system(*FIRST_PAIR)
    load = 0.3
    required = fo.required_friction(pair, CYCLE, load)
    one = fo.friction_after_protocol(required, start="worst", scan=20)
    rests = one.to_frame().query("outcome == 'rest'")["friction"]
    for friction in one.tried["friction"]:
        worst = fo.guaranteed_limit(pair, CYCLE, friction).load_factor
        assert (worst >= load) == (friction in set(rests))
    assert one.required == np.inf and one.lower == 1.0
    assert not rests.empty and not one.monotonic


def test_friction_that_is_not_enough_is_refused():
    cycle = fo.LoadCycle({"N": 1.0}, [{"F": 0.8}, {"F": -0.8}])
    required = fo.required_friction(BLOCK, cycle, 1.0)
    with pytest.raises(fo.ModelError, match=r"up_to: 0\.5.* 0\.8.* more friction"):
        fo.friction_after_protocol(required, up_to=0.5)
