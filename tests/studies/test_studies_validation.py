"""Studies of sizes, of followed contacts and of what is left out, at quick size: what does not
depend on the machine. Times are not tested."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from studies.validation import all_sets, campaign, followed


def test_all_rest_below_and_all_witnesses_slip_above(tables):
    table = tables["followed"]
    assert (
        table["seed"].nunique() == followed.QUICK.contacts
        and (table["guaranteed"] <= table["shakedown"] * (1 + 1e-9)).all()
    )
    rests = table["outcome"] == "SHAKEDOWN"
    assert (
        (rests == (table["share"] < 1)).all()
        and (table.loc[rests, "work"] == 0).all()
        and (table.loc[~rests, "work_error"] < 1).all()
    )


def test_a_row_is_what_a_transient_does(tables):
    row = tables["followed"].query("share > 1").iloc[-1]
    system, cycle, friction = followed.random_contact(int(row["seed"]))
    limit = fo.guaranteed_limit(system, cycle, friction)
    mean = cycle.mean_reaction(system)
    assert (
        np.abs(np.sum(cycle.corner_reactions(system)[0], axis=0)).max() < 1e-12
        and not mean[0].any()
        and mean[1].min() >= 1
    )
    again = fo.steady_state(
        system, cycle, friction, row["share"] * limit.load_factor, initial_slip=limit.slip, steps=1
    )
    assert (
        again.dissipation == pytest.approx(row["work"], rel=1e-6)
        and row["outcome"] == again.outcome.name
    )


def test_the_counts_tell_slip_from_what_is_within_its_error():
    rows = [
        ("witness", 0.995, "SHAKEDOWN", 0.0, 0.5),
        ("random", 0.995, "CYCLIC_SLIP", 2.0, 0.5),
        ("random", 0.995, "RATCHETING", 0.1, 0.5),
    ]
    rows += [
        ("witness", 1.005, "CYCLIC_SLIP", 0.1, 0.5),
        ("witness", 1.005, "SHAKEDOWN", 0.0, 1.0),
        ("none", 0.0, "not followed", 0.0, 0.0),
    ]
    table = pd.DataFrame(
        [
            dict(zip(("start", "share", "outcome", "work_error", "guaranteed"), row, strict=True))
            for row in rows
        ]
    )
    printed = followed.STUDY.summary({"followed": table.assign(seed=range(6), shakedown=1.0)})
    counts = [
        line.split("|")[2:-1]
        for line in printed.splitlines()
        if line.startswith(("| below", "| above"))
    ]
    assert [[int(cell) for cell in row] for row in counts] == [
        [1, 1, 0, 0],
        [2, 0, 1, 1],
        [1, 0, 0, 1],
        [1, 1, 0, 0],
    ]
    assert "6 contacts, of which 1 have a limit of about 0" in printed


def test_a_campaign_loses_nothing_when_a_worker_is_killed(tables):
    (row,) = tables["campaign"].to_dict("records")
    assert (row["runs"], row["killed"], row["lost"]) == (20, 1, 0)
    assert (row["repeated"], row["different"]) == (12, 0)
    assert 0 < row["busy"] <= 1 and row["residual"] <= 1e-9


def test_a_repeated_transient_with_another_bit_is_different():
    table = pd.DataFrame(
        {
            "load_factor": [1.0, 1.0, 2.0],
            "start": ["given 0", "given 1", "given 0"],
            "dissipation": [0.0, np.nan, 3.0],
            "residual": [0.0, 1e-16, 0.0],
            "seconds": [1.0, 2.0, 3.0],
        }
    )
    assert campaign._different(table, table.iloc[[2, 1]].assign(seconds=7.0)) == 0
    changed = table.assign(dissipation=[0.0, np.nan, np.nextafter(3.0, 4.0)])
    assert campaign._different(table, changed.iloc[[2, 1]]) == 1
    assert campaign._different(table, table.iloc[[1]].assign(dissipation=0.0)) == 1


def test_an_executor_kills_once_after_some_tasks():
    killed = []
    with ThreadPoolExecutor(1) as threads:
        executor = campaign.Killing(threads, 2, lambda: killed.append(True))
        ended = [executor.submit(abs, -number).result() for number in range(4)]
    assert ended == [0, 1, 2, 3] and len(killed) == 1


def test_no_set_of_open_nodes_is_missed(tables):
    table = tables["all_sets"]
    assert table["best_of_all"].all() and not all_sets.missed(table).any()
    tried = table[table["every_set"].notna()]
    assert len(tried) > 5
    assert np.allclose(tried["bound_of_sets"], tried["every_set"], rtol=1e-6)
    # A contact of which another set is better would be listed.
    worse = table.assign(load_factor=table["load_factor"] * (1 - 1e-3))
    assert all_sets.missed(worse).sum() == (tried["load_factor"] < np.inf).sum()
    assert "block, 4 nodes | 3 | 0 of 3" in all_sets.STUDY.summary({"all_sets": table})
