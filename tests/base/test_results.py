"""Results show their answer in one line and in a small table; plain data are equal where their
content is."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import frictopt as fo
from helpers.answers import (
    ASKED,
    CHECK,
    CURED,
    DRAWN,
    FIRST,
    LEAST,
    LIMIT,
    LOWER,
    MOVED,
    NEEDED,
    PAIR,
    PATH,
    REGION,
    REST,
    SAFE,
    SPAN,
    STEADY,
    WORN,
)
from helpers.systems import CYCLE

LARGEST = np.abs(LIMIT.slip).max()


@pytest.mark.parametrize(
    ("result", "said"),
    [
        (PAIR, ["nodes=2", "loads=['cyclic', 'mean']"]),
        (FIRST.slip, ["corner=", f"load_factor={FIRST.slip.load_factor:.6g}"]),
        (FIRST, ["slip=OnsetEvent", f"load_factor={FIRST.slip.load_factor:.6g}"]),
        (
            STEADY,
            [
                f"outcome={STEADY.outcome.name}",
                f"dissipation={STEADY.dissipation:.6g}",
                "residual=",
            ],
        ),
        (PATH, ["nodes=2", "cycles=2", "engine=path", "residual="]),
        (PATH.verdict, ["residual=", "direction="]),
        (
            LIMIT,
            [
                f"load_factor={LIMIT.load_factor:.6g}",
                "kind=FINITE",
                f"largest_slip={LARGEST:.6g}",
                "residual=",
                "reason=no residual slip",
            ],
        ),
        (
            LOWER,
            [
                f"load_factor={LOWER.load_factor:.6g}",
                "proven=False",
                "node=0",
                f"largest_slip={np.abs(LOWER.slip).max():.6g}",
                "residual=",
            ],
        ),
        (
            SAFE,
            [
                "exists=True",
                f"largest_slip={np.abs(SAFE.slip).max():.6g}",
                f"margin={SAFE.margin:.6g}",
                "residual=",
            ],
        ),
        (
            DRAWN,
            [
                f"load_factor={DRAWN.load_factor:.6g}",
                "bound=",
                "preload other=0.2",
                "profile=0.1 .. 0.1",
                "residual=",
            ],
        ),
        (
            NEEDED,
            [
                f"required={NEEDED.required:.6g}",
                f"largest_slip={np.abs(NEEDED.slip).max():.6g}",
                "residual=",
                "reason=no residual slip",
            ],
        ),
        (REGION, ["loads=('cyclic', 'other')", f"sides={len(REGION.sides)}", "reason="]),
        (LEAST, ["load_factor=1", f"bound={LEAST.bound:.6g}", "residual="]),
        (SPAN, [f"least={SPAN.least:.6g}", f"most={SPAN.most:.6g}", "residual=", "proven=False"]),
        (REST, [f"ratio={REST.ratio:.6g}", "monotonic=True", "residual="]),
        (CURED, [f"share={CURED.share:.6g}", "sampled=60", "residual="]),
        (MOVED, ["nodes=2", f"slipping={(np.abs(MOVED.status) == 1).sum()}", "open=0", "solver="]),
        (WORN, ["cycles=1", f"volume={WORN.volume:.6g}", "reason=1 cycles are over"]),
        (
            CHECK,
            [
                f"load_factor={CHECK.limit.load_factor:.6g}",
                f"runs={len(CHECK.runs)}",
                f"dies_out={CHECK.dies_out}",
            ],
        ),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_result_says_its_answer_in_one_line_and_as_a_table(result, said):
    line, table = repr(result), result._repr_html_()
    assert line.startswith(type(result).__name__ + "(") and "\n" not in line and len(line) < 300
    assert all(part in line for part in said)
    assert table.count("<table") == table.count("</table>") == 1
    assert table.count("<tr") >= len(said) and "array" not in table

    lines = str(result).split("\n")
    assert lines[0] == type(result).__name__ and all(
        len(line) <= 79 and line == line.rstrip() for line in lines
    )
    assert " ".join(" ".join(lines[1:]).split()).count(" ") >= len(said)
    assert len(lines) > 2 and all(line.startswith("  ") for line in lines[1:])


def test_the_lines_of_a_result_have_its_answer_first_and_its_reason_second():
    assert [line.split()[0] for line in str(LIMIT).split("\n")[1:3]] == ["load_factor", "reason"]
    words = str(LIMIT).split()
    assert (
        " ".join(words[: words.index("least")])
        == f"ShakedownLimit load_factor {LIMIT.load_factor:.6g} reason {LIMIT.reason}"
    )
    assert str(SAFE).split("\n")[1] == "  exists        True" and str(FIRST).split("\n")[
        1
    ].startswith("  slip        OnsetEvent(corner=")
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


@pytest.mark.parametrize(
    "result",
    [STEADY, PATH, LIMIT, LOWER, SAFE, NEEDED, REGION, MOVED, DRAWN],
    ids=lambda value: type(value).__name__,
)
def test_every_result_has_a_record(result):
    record = result.record
    assert (
        0 < record.residual == result.residual < 1e-9 and record.solver and 0 < record.seconds < 600
    )
    assert all(isinstance(text, str) for text in record.left_out) and all(
        isinstance(attempt, fo.results.Attempt) for attempt in record.attempts
    )
    assert (len(record.attempts) > 0) is (
        result in (LIMIT, LOWER, SAFE, NEEDED, REGION, MOVED, DRAWN)
    )
    assert pickle.loads(pickle.dumps(result)).record == record


def test_the_record_of_a_guaranteed_limit_covers_that_of_the_shakedown_limit():
    inner = LOWER.shakedown.record
    assert (
        LOWER.record.attempts[: len(inner.attempts)] == inner.attempts
        and LOWER.record.seconds > inner.seconds
    )


def test_a_table_for_notebooks_shows_names_of_load_cases_as_they_are():
    contact = fo.ContactSystem.from_blocks(
        [[1.0]], [[0.0]], [[1.0]], [0.0], {"<b>": ([0.0], [1.0])}
    )
    assert "&lt;b&gt;" in contact._repr_html_() and "<b>" not in contact._repr_html_()


def test_the_frame_of_a_steady_state_has_a_row_for_each_node():
    table = STEADY.to_frame()
    assert list(table.columns) == ["node", "x", "slip", "open", "dissipation"] and table[
        "node"
    ].tolist() == [0, 1]
    assert STEADY.dissipation > 0 and table["dissipation"].sum() == pytest.approx(
        STEADY.dissipation, rel=1e-14
    )
    assert np.array_equal(table["slip"], STEADY.slip) and np.array_equal(table["x"], PAIR.x)
    assert np.array_equal(table["open"], STEADY.open) and STEADY.open.any()


@pytest.mark.parametrize(
    "result", [LIMIT, LOWER, SAFE, MOVED, DRAWN], ids=lambda value: type(value).__name__
)
def test_the_frame_of_a_limit_or_an_increment_has_a_row_for_each_node(result):
    table = result.to_frame()
    assert (
        table["node"].tolist() == [0, 1]
        and np.array_equal(table["slip"], result.slip)
        and np.abs(result.slip).max() > 0
    )


def test_a_check_has_the_residual_of_its_worst_transient():
    assert CHECK.runs["residual"].between(0, 1e-9).all()
    assert CHECK.residual == max(CHECK.limit.residual, CHECK.runs["residual"].max()) > 0


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
        (fo.Material, [fo.Material(E=2.0)]),
        (lambda: fo.Support("block", (0, 1)), [fo.Support("punch", (0, 1))]),
        (lambda: fo.Traction("block", "top", 1), [fo.Traction("block", "top", 0, 1)]),
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
