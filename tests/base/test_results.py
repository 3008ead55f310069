"""Results show their answer in one line and in a small table; plain data are equal where their
content is."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.answers import ASKED, PAIR, QUESTIONS, answer
from helpers.systems import CYCLE, unit_nodes


# A comparison is shown as its table.
@pytest.mark.parametrize("kind", sorted(QUESTIONS.keys() - {"Comparison"} | {"ContactSystem"}))
def test_a_result_says_its_answer_in_one_line_and_as_a_table(kind):
    result = PAIR if kind == "ContactSystem" else answer(kind)
    line, table = repr(result), result._repr_html_()
    assert line.startswith(kind + "(") and "\n" not in line and len(line) < 400
    assert table.count("<table") == table.count("</table>") == 1
    assert table.count("<tr") > 1 and "array" not in table
    lines = str(result).split("\n")
    assert lines[0] == kind and all(len(line) <= 79 and line == line.rstrip() for line in lines)
    assert len(lines) > 2 and all(line.startswith("  ") for line in lines[1:])


def test_the_lines_of_a_result_have_its_answer_first_and_its_reason_second():
    limit = answer("ShakedownLimit")
    assert [line.split()[0] for line in str(limit).split("\n")[1:3]] == ["load_factor", "reason"]
    words = str(limit).split()
    assert (
        " ".join(words[: words.index("least")])
        == f"ShakedownLimit load_factor {limit.load_factor:.6g} reason {limit.reason}"
    )
    assert str(answer("SafeSlip")).split("\n")[1] == "  exists        True"
    assert str(answer("Onset")).split("\n")[1].startswith("  slip        OnsetEvent(corner=")
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    bodies = [line.removeprefix("  bodies") for line in str(model).split("\n") if "E=" in line]
    assert (
        len(bodies) == 2
        and bodies[0].strip().startswith("punch: E=")
        and bodies[1].strip().startswith("block: E=")
    )


def test_the_largest_slip_in_space_is_that_of_a_node():
    node = fo.ContactSystem(
        np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1], "Q": [1, 0, 0], "R": [0, 1, 0]}
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 6.0, "R": 8.0}])
    for found in (fo.safe_slip(node, cycle, 0.5, 1.0), fo.safe_slip(node, cycle, 0.5, 0.5)):
        assert found.largest_slip == pytest.approx(float(np.hypot(*found.slip[0])), rel=1e-12)
        assert f"largest_slip={found.largest_slip:.6g}" in repr(found)
    assert np.isnan(fo.shakedown_limit(node, cycle, 0.5).largest_slip)  # inf, no slip


OF_PROGRAMS = [
    "ShakedownLimit",
    "GuaranteedLimit",
    "SafeSlip",
    "RequiredFriction",
    "SafeRegion",
    "Design",
]


@pytest.mark.parametrize("kind", ["SteadyState", "Trajectory", "Increment", *OF_PROGRAMS])
def test_every_result_has_a_record(kind):
    result = answer(kind)
    record = result.record
    assert (
        0 < record.residual == result.residual < 1e-9 and record.solver and 0 < record.seconds < 600
    )
    assert all(isinstance(text, str) for text in record.left_out) and all(
        isinstance(attempt, fo.results.Attempt) for attempt in record.attempts
    )
    assert (len(record.attempts) > 0) is (kind in OF_PROGRAMS)
    assert pickle.loads(pickle.dumps(result)).record == record


def test_the_record_of_a_guaranteed_limit_covers_that_of_the_shakedown_limit():
    outer, inner = answer("GuaranteedLimit").record, answer("GuaranteedLimit").shakedown.record
    assert outer.attempts[: len(inner.attempts)] == inner.attempts and outer.seconds > inner.seconds


def test_a_table_for_notebooks_shows_names_of_load_cases_as_they_are():
    contact = unit_nodes({"<b>": ([0.0], [1.0])})
    assert "&lt;b&gt;" in contact._repr_html_() and "<b>" not in contact._repr_html_()


def test_the_frame_of_a_steady_state_has_a_row_for_each_node():
    steady = answer("SteadyState")
    table = steady.to_frame()
    assert list(table.columns) == ["node", "x", "slip", "open", "dissipation"] and table[
        "node"
    ].tolist() == [0, 1]
    assert steady.dissipation > 0 and table["dissipation"].sum() == pytest.approx(
        steady.dissipation, rel=1e-14
    )
    assert np.array_equal(table["slip"], steady.slip) and np.array_equal(table["x"], PAIR.x)
    assert np.array_equal(table["open"], steady.open) and steady.open.any()


BOTH = {"Q": 1, "R": 2}


@pytest.mark.parametrize(
    ("make", "others"),
    [
        (
            lambda: fo.LoadCycle({"P": 1}, [BOTH, {"Q": -1}]),
            [
                fo.LoadCycle({"P": 2}, [BOTH, {"Q": -1}]),
                fo.LoadCycle({"P": 1}, [{"Q": -1}, BOTH]),
                fo.LoadCycle({"P": 1}, [BOTH]),
            ],
        ),
        (fo.fem.Material, [fo.fem.Material(E=2.0)]),
        (lambda: fo.fem.Support("block", (0, 1)), [fo.fem.Support("punch", (0, 1))]),
        (lambda: fo.fem.Traction("block", "top", 1), [fo.fem.Traction("block", "top", 0, 1)]),
        (lambda: fo.scenes.PunchOnHalfPlane(elements=4), [fo.scenes.PunchOnHalfPlane(elements=6)]),
        (lambda: fo.onset(*ASKED), [fo.onset(PAIR, CYCLE, 0.5)]),
    ],
    ids=["LoadCycle", "Material", "Support", "Traction", "PunchOnHalfPlane", "Onset"],
)
def test_plain_data_are_equal_where_their_content_is(make, others):
    one, same = make(), make()
    assert (
        one is not same
        and one == same
        and hash(one) == hash(same)
        and len({one, same, *others}) == 1 + len(others)
    )
    assert all(one != other for other in (*others, None, "one"))


def test_the_line_of_a_load_cycle_makes_it_again():
    assert eval(repr(CYCLE), {"LoadCycle": fo.LoadCycle}) == CYCLE


def test_a_mechanism_names_the_contacts_if_there_are_several(punch, paper_cycle):
    contact = punch(16)
    names = np.where(contact.x < 0, "left", "right")
    limits = [
        fo.shakedown_limit(replace(contact, contact=name), paper_cycle, 0.7)
        for name in (None, ["foot"] * contact.nodes, names)
    ]
    *plain, named = (limit.mechanism for limit in limits)
    assert all(
        list(table) == ["node", "x", "corner", "loads", "direction", "share"] for table in plain
    )
    assert list(named) == ["node", "contact", "x", "corner", "loads", "direction", "share"] and set(
        named["contact"]
    ) == {"left", "right"}
    assert ((named["x"] < 0) == (named["contact"] == "left")).all() and named.drop(
        columns="contact"
    ).equals(plain[1])
    assert (named["loads"] == np.array(["sigma = -1", "sigma = +1"])[named["corner"]]).all()
