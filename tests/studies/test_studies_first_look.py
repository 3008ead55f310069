"""The first look: what it prints is what the limits and the steady states say, and its picture is
on disk."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imread

import frictopt as fo
from studies import first_look
from studies.paper import LOADS


def test_it_prints_the_answers_and_draws_them(tmp_path, capsys):
    assert first_look.STUDY.run(["--quick", "--data", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    system, f = (
        fo.scenes.PunchOnHalfPlane(elements=first_look.QUICK.elements).condense(),
        first_look.QUICK.friction,
    )
    table = pd.read_parquet(tmp_path / "first_look.parquet").set_index("question")
    first, lower, limit = (
        fo.onset(system, LOADS, f),
        fo.guaranteed_limit(system, LOADS, f),
        fo.shakedown_limit(system, LOADS, f),
    )
    expected = {
        "onset": first.slip.load_factor,
        "guaranteed limit": lower.load_factor,
        "limit after one overload": fo.after_overload(lower).load_factor,
        "limit as assembled": fo.limit_after_protocol(limit).load_factor,
        "shakedown limit": limit.load_factor,
    }
    for load in first_look.QUICK.load_factors:
        work = (
            fo.steady_state(system, LOADS, f, load).dissipation
            * system.E_star
            / system.reaction(LOADS.mean)[1].sum() ** 2
        )
        expected[f"work of friction per cycle at load {load:g}, W E* / P^2"] = work
    assert np.isnan(table["value"]["compilation of transients"])
    table = table.drop("compilation of transients")
    assert list(table.index) == list(expected) and table["value"].tolist() == pytest.approx(
        list(expected.values()), rel=1e-9, abs=1e-12
    )
    assert table["residual"].max() < 1e-9
    for question, value in expected.items():
        assert f"| {question} | {value:.4g} | {table['proven'][question]} |" in printed
    runs = pd.read_parquet(tmp_path / "first_look_work.parquet")
    assert runs["residual"].max() < 1e-9 and runs["load_factor"].max() == pytest.approx(
        1.3 * limit.load_factor
    )
    most, least = (getattr(runs.groupby("load_factor")["work"], name)() for name in ("max", "min"))
    sure = fo.after_overload(lower).load_factor
    assert not most[most.index < sure].any() and (least[least.index > limit.load_factor] > 0).all()
    between = (most.index > sure) & (most.index < limit.load_factor)
    assert between.any() and (most[between] > 0).all() and not least[between].any()
    # Nothing touches the right edge of the picture, so no mark or word is cut.
    shown = imread(tmp_path / "first_look.png")
    assert shown.shape[1] > 1000 and (shown[:, -4:] == 1).all()
    assert str(tmp_path / "first_look.png") in printed
