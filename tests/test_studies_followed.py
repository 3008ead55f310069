"""The study of followed contacts at quick size: its counts are those of its rows, and what it says is what its transients did."""

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from studies.validation import followed

STUDY = followed.STUDY


@pytest.fixture
def table(tables):
    return tables["followed"]


def test_all_rest_below_and_all_witnesses_slip_above(table):
    assert table["seed"].nunique() == followed.QUICK.contacts and (table["guaranteed"] <= table["shakedown"] * (1 + 1e-9)).all()
    rests = table["outcome"] == "SHAKEDOWN"
    assert (rests == (table["share"] < 1)).all() and (table.loc[rests, "work"] == 0).all() and (table.loc[~rests, "work_error"] < 1).all()


def test_a_row_is_what_a_transient_does(table):
    row = table.query("share > 1").iloc[-1]
    system, cycle, friction = followed.random_contact(int(row["seed"]))
    limit = fo.guaranteed_limit(system, cycle, friction)
    mean = cycle.mean_reaction(system)
    assert np.abs(np.sum(cycle.corner_reactions(system)[0], axis=0)).max() < 1e-12 and not mean[0].any() and mean[1].min() >= 1
    again = fo.steady_state(system, cycle, friction, row["share"] * limit.load_factor, initial_slip=limit.slip, steps=1)
    assert again.dissipation == pytest.approx(row["work"], rel=1e-6) and row["outcome"] == again.outcome.name


def test_the_counts_tell_slip_from_what_is_within_its_error():
    rows = [("witness", 0.995, "SHAKEDOWN", 0.0, 0.5), ("random", 0.995, "CYCLIC_SLIP", 2.0, 0.5), ("random", 0.995, "RATCHETING", 0.1, 0.5)]
    rows += [("witness", 1.005, "CYCLIC_SLIP", 0.1, 0.5), ("witness", 1.005, "SHAKEDOWN", 0.0, 1.0), ("none", 0.0, "not followed", 0.0, 0.0)]
    table = pd.DataFrame([dict(zip(("start", "share", "outcome", "work_error", "guaranteed"), row, strict=True)) for row in rows])
    printed = followed.STUDY.summary({"followed": table.assign(seed=range(6), shakedown=1.0)})
    counts = [line.split("|")[2:-1] for line in printed.splitlines() if line.startswith(("| below", "| above"))]
    assert [[int(cell) for cell in row] for row in counts] == [[1, 1, 0, 0], [2, 0, 1, 1], [1, 0, 0, 1], [1, 1, 0, 0]]
    assert "6 contacts, of which 1 have a limit of about 0" in printed
