"""What the paper says beside ours: order of the limits at quick size, and the counts of the
page."""

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from studies import flicek
from studies.validation.closed_forms import uncoupled_limit


def test_limits_are_in_order_and_one_where_the_contact_is_uncoupled(tables):
    asked = dict(list(tables["flicek"].groupby("question")))
    for question in ("guaranteed limit", "coupled", "incomplete", "uncoupled"):
        assert (asked[question]["value"] <= asked[question]["other"] * (1 + 1e-9)).all() and (
            asked[question]["residual"] < 1e-8
        ).all()
    for question in ("incomplete", "uncoupled"):
        assert asked[question]["value"].to_numpy() == pytest.approx(
            asked[question]["other"].to_numpy(), rel=1e-9
        )
    assert (asked["coupled"]["value"] < 0.99 * asked["coupled"]["other"]).all()
    assert np.diff(asked["incomplete"]["other"]).max() < 0
    flat = fo.reference.half_plane_contact(flicek.QUICK.uncoupled, 1.0, 1.0)
    known = uncoupled_limit(0.0, flat["bonded"]["P"][1], flat["A"] @ flat["x"], 0.0, 0.5)
    assert asked["uncoupled"]["value"].iloc[0] == pytest.approx(known, rel=1e-9)
    assert asked["shakedown limit"]["value"].to_numpy() == pytest.approx(
        asked["guaranteed limit"]["other"].to_numpy(), rel=1e-8
    )


def test_the_page_has_a_line_for_each_claim_of_both_studies(quick):
    page = flicek.STUDY.summary(quick((*flicek.STUDY.needs, *flicek.STUDY.tables)))
    assert (
        page.count("`python -m studies flicek`") == 9
        and page.count("`python -m studies dissipation`") == 6
    )


def runs_of(*rows):
    """Runs at f = 0.5, with the guaranteed limit at 1 and the shakedown limit at 2: (load factor,
    outcome, work, cycles)."""
    table = pd.DataFrame(rows, columns=["load_factor", "outcome", "dissipation_scaled", "cycles"])
    return table.assign(friction=0.5, load_ratio=table["load_factor"] / 2, error="")


def test_the_counts_are_those_of_the_runs():
    runs = runs_of(
        *(
            (0.8, "SHAKEDOWN", 0.0, 2),
            (0.8, "SHAKEDOWN", 0.0, 3),
            (1.5, "SHAKEDOWN", 0.0, 9),
            (1.5, "CYCLIC_SLIP", 1e-3, 4),
        ),
        *(
            (2.4, "CYCLIC_SLIP", 2e-3, 4),
            (2.4, "CYCLIC_SLIP", 8e-3, 4),
            (4.0, "CYCLIC_SLIP", 0.5, 4),
            (4.0, "CYCLIC_SLIP", 0.6, 4),
        ),
    )
    said = {
        row[0]: row[2]
        for row in flicek._transients(runs, pd.DataFrame({"at": [0.5], "value": [1.0]}))
    }
    assert said["transients followed"] == "8, of which 8 reach a steady state"
    assert said["above the shakedown limit none comes to rest"] == "0 of 4 starts rest"
    assert said["below the guaranteed limit all do"] == "2 of 2 starts rest"
    assert said["between them the start decides"] == "1 of 2 starts rest"
    assert said["dissipation depends on the initial slip"].endswith(
        "f = 0.5: 4 at 1.2 of the limit, 1.2 at 2 of the limit"
    )
    assert said["slip ceases after the first few cycles"] == "3 cycles in the median, at most 9"
