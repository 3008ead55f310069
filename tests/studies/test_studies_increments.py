"""Studies of increments and of ranges of dissipation at quick size: the contact law on any mesh,
the sample of starts, and what is proven."""

import numpy as np
import pandas as pd

from studies.range import against_sample

LOADS = {"friction": [0.5, 0.5], "load_ratio": [0.9, 1.2]}


def test_runs_outside_are_counted_at_their_load():
    found = pd.DataFrame(LOADS | {"least": [0.0, 1.0], "most": [2.0, 3.0]})
    works = {0.9: [0.0, 2.0, 2.1], 1.2: [0.9, 1.0 - 1e-9, 2.5, 3.1, 4.0, np.nan]}
    runs = pd.DataFrame(
        [(0.5, ratio, work) for ratio, row in works.items() for work in row],
        columns=["friction", "load_ratio", "dissipation_scaled"],
    )
    table = against_sample(
        found,
        runs.assign(outcome=np.where(runs["dissipation_scaled"].isna(), "FAILED", "CYCLIC_SLIP")),
    )
    assert table[["sampled_least", "sampled_most", "runs", "outside"]].to_numpy().tolist() == [
        [0.0, 2.1, 3, 1],
        [0.9, 4.0, 5, 3],
    ]


def test_no_sampled_run_lies_outside(tables):
    table = against_sample(tables["range_found"], tables["dissipation_runs"])
    assert (table["outside"] == 0).all() and (table["runs"] >= 18).all()
    assert (table["least"] <= table["sampled_least"] * (1 + 1e-6)).all() and (
        table["most"] >= table["sampled_most"] * (1 - 1e-6)
    ).all()
    assert (table["most"] > 1.1 * table["sampled_most"]).any()


def test_slip_is_never_less_than_proven(tables):
    table = tables["range_slip"]
    assert (
        (table["bound"] > 0).all()
        and (table["least"] >= table["bound"] * (1 - 1e-9)).all()
        and (table["most"] >= table["least"]).all()
    )
    assert (table["least_total"] >= table["proven_total"]).all() and (
        table["proven_total"] > 0
    ).all()


def test_the_worst_start_needs_a_protocol_and_the_safe_one_needs_none(tables):
    ratios = tables["range_protocols"].pivot(index="friction", columns="protocol", values="ratio")
    assert (ratios["safe"] > 0.999).all() and (ratios["nothing"] < 0.6).all()
    assert np.all(
        ratios[["overload", "unload", "unload at tension", "assembled"]].gt(
            ratios["nothing"], axis=0
        )
    )
    assert tables["range_protocols"]["monotonic"].all()
