import re
import sqlite3
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from functools import partial
from importlib import import_module
from multiprocessing import get_context

import numpy as np
import pandas as pd
import pytest
from scipy import stats

import frictopt as fo
from helpers.foreign import Foreign
from helpers.interrupts import interrupted, stops
from helpers.liars import lying
from helpers.refused import refused
from helpers.runs import results, same, with_followed
from helpers.systems import CYCLE, ONE_NODE, random_system, system


@pytest.fixture(scope="module")
def contact():
    return replace(random_system(np.random.default_rng(3), 4), E_star=2.0)


@pytest.fixture(scope="module")
def starts(contact):
    return (
        fo.starts.no_slip()
        + fo.starts.safe_slips([1.0, -2.0])
        + fo.starts.random_slips(contact, [0.3, 3.0], 3)
        + fo.starts.overloads([2.0])
        + fo.starts.given_slips(np.eye(4))
    )


@pytest.fixture(scope="module")
def factors(contact):
    return fo.shakedown_limit(contact, CYCLE, 0.4).load_factor * np.array([0.5, 0.95, 1.2])


@pytest.fixture(scope="module")
def table(contact, factors, starts):
    return fo.dissipation_study(contact, CYCLE, 0.4, factors, starts)


def test_one_node_has_the_closed_form_dissipation_from_every_start():
    one = replace(system(*ONE_NODE), E_star=7.0)
    table = fo.dissipation_study(
        one,
        CYCLE,
        0.4,
        [1.2 * (limit := fo.shakedown_limit(one, CYCLE, 0.4).load_factor)],
        [[0.0], [1.0], [-3.0]],
        limits=True,
    )
    assert table.dissipation.to_numpy() == pytest.approx(3 * [0.061945108310], rel=1e-9)
    assert table.dissipation_scaled.to_numpy() == pytest.approx(
        3 * [0.061945108310 * 7.0], rel=1e-9
    )
    assert table.load_ratio.to_numpy() == pytest.approx(3 * [1.2], rel=1e-9)
    assert (table.shakedown_limit == limit).all()
    assert table.attrs == {"missing": 0, "per_depth": True}
    assert (table.slipping == 1).all()
    assert (table.largest_share == 1.0).all()
    assert (table.open == 0).all()


def test_rows_are_the_steady_states_of_each_load_factor_and_start(contact, factors, starts, table):
    assert len(table) == len(factors) * len(starts)
    assert table.load_factor.tolist() == [factor for factor in factors for _ in starts]
    assert table.start.tolist() == 3 * [start.name for start in starts]
    for number, row in table.iterrows():
        start = starts[number % len(starts)]
        slip = start.slip_at(contact, CYCLE, 0.4, row.load_factor)
        overload = start.overload
        steady = fo.steady_state(
            contact, CYCLE, 0.4, row.load_factor, initial_slip=slip, overload=overload
        )
        assert (row.outcome, row.dissipation, row.first_cycle) == (
            steady.outcome.name,
            steady.dissipation,
            steady.first_cycle,
        )
        assert row.amplitude == pytest.approx(0.0 if slip is None else np.sqrt(np.mean(slip**2)))
    assert (table.residual <= 1e-9).all() and (table.error == "").all()


def test_processes_threads_and_foreign_executors_give_the_same_table(
    contact, factors, starts, table
):
    with (
        ThreadPoolExecutor(3) as threads,
        ProcessPoolExecutor(1, get_context("spawn")) as processes,
    ):
        for options in ({"executor": threads}, {"executor": processes}, {}):
            other = fo.dissipation_study(contact, CYCLE, 0.4, factors, starts, **options)
            same(other, table)


def test_a_run_that_fails_is_a_row_with_its_error_and_is_kept(tmp_path):
    """A = 1, B = 1/2, f = 3 > A/|B| = 2 (Klarbring 1990). Pushed on from its backward bound by 5,
    the node jumps; pushed by 1 it stays."""
    wedge = fo.ContactSystem.from_blocks(
        [[1.0]], [[0.5]], [[1.0]], [0], {"mean": ([0.0], [1.0]), "push": ([1.0], [0.0])}
    )
    pushed = fo.LoadCycle({"mean": 1.0}, [{"push": 1.0}])
    table, again = (
        fo.dissipation_study(wedge, pushed, 3.0, [1.0, 5.0], store=tmp_path / "runs")
        for _ in range(2)
    )
    same(table, again)
    assert table.outcome.tolist() == ["SHAKEDOWN", "FAILED"]
    assert fo.results.read_store(tmp_path / "runs").outcome.tolist().count("FAILED") == 1
    assert table.error[0] == ""
    assert re.match(
        r"NoContinuation: the segment to the corner \(push = \+1\): at 0\.6 of it no rates obey the law; nodes \[0\]",
        table.error[1],
    )
    assert table.dissipation.isna().tolist() == [False, True] == table.cycles.isna().tolist()


@pytest.mark.parametrize("tangents", [1, 2], ids=["plane", "space"])
def test_a_body_that_slides_off_is_an_outcome_that_is_not_followed_again(tangents, tmp_path):
    """A node on a spring-free body holds f P = 0.8; the loads 0.4 and 1.2 are below and above."""
    shear = [0.0] * (tangents - 1)
    block = fo.ContactSystem(
        np.zeros((tangents + 1, tangents + 1)),
        [[0.0] * (tangents + 1)],
        {"P": [0.0, *shear, 2.0], "Q": [1.0, *shear, 0.0]},
    )
    pushed = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    ask = partial(fo.dissipation_study, block, pushed, 0.4, [0.4, 1.2], progress=False)
    table = ask(store=tmp_path / "runs")
    assert table.outcome.tolist() == ["SHAKEDOWN", "SLIDES_OFF"]
    assert fo.gross_slip(block, pushed, 0.4).reason in table.error[1]
    assert table.dissipation.isna().tolist() == [False, True]
    again = ask(store=tmp_path / "runs")
    pd.testing.assert_frame_equal(again, table, check_exact=True)  # with the seconds of the first


def test_a_safe_slip_that_no_solver_finds_is_a_row_and_the_others_go_on(
    contact, factors, monkeypatch
):
    lying(monkeypatch, lambda *_: "stopped")
    table = fo.dissipation_study(
        contact, CYCLE, 0.4, factors[:1], fo.starts.no_slip() + fo.starts.safe_slips(), limits=True
    )
    assert table.error[0] == "" and table.error[1].startswith("SolverError: ")
    assert table.load_ratio.isna().all()


def test_a_study_started_again_runs_only_what_is_missing(contact, factors, starts, table, tmp_path):
    store = tmp_path / "runs.sqlite"

    def study(**changes):
        values = {
            "system": contact,
            "cycle": CYCLE,
            "friction": 0.4,
            "load_factors": factors,
            "starts": starts,
        } | changes
        return with_followed(store, lambda: fo.dissipation_study(**values, store=store))

    half, new = study(starts=starts[::2])
    assert len(new) == len(half) == 30
    whole, new = study()
    same(whole, table)
    assert len(new) == len(table) - 30
    again, new = study()
    pd.testing.assert_frame_equal(again, whole, check_exact=True)
    assert new.empty
    assert len(fo.results.read_store(store)) == len(table)
    _, new = study(starts=fo.starts.no_slip(), friction=0.41)
    assert len(new) == len(factors)
    for change in (
        {"system": contact.with_gap(0.01 * np.ones(4))},
        {"cycle": fo.LoadCycle(CYCLE.mean, CYCLE.corners[::-1])},
    ):
        with pytest.warns(fo.results.OtherRows):
            _, new = study(starts=fo.starts.no_slip(), **change)
        assert len(new) == len(factors)


def test_equal_runs_are_followed_once(contact, factors):
    twins = [
        fo.starts.Start("a", "one", slip=np.ones(4)),
        fo.starts.Start("b", "other", slip=np.ones(4)),
    ]
    table = fo.dissipation_study(contact, CYCLE, 0.4, factors[:1], twins)
    assert table.start.tolist() == ["one", "other"]
    assert table.dissipation.nunique() == table.seconds.nunique() == 1


def test_an_interrupt_leaves_the_finished_rows(contact, factors, starts, table, tmp_path):
    study = {
        "system": contact,
        "cycle": CYCLE,
        "friction": 0.4,
        "load_factors": factors,
        "starts": starts,
        "store": tmp_path / "runs.sqlite",
    }
    with interrupted("transients", 7) as stop:
        fo.dissipation_study(**study)
    part, (note,) = stop.value.table, stop.value.__notes__
    assert f"{len(table) - 7} runs are left; the attribute `table` has 7, " in note
    assert note.endswith("runs.sqlite', from which the same call continues")
    same(part, table.head(7))
    assert part.attrs["missing"] == len(table) - 7
    same(fo.dissipation_study(**study), table)


def test_friction_is_an_axis_of_numbers_fields_and_distributions(contact, factors, tmp_path):
    field = [0.3, 0.4, 0.5, 0.4]
    axis = [0.4, field, stats.uniform(0.3, 0.2), stats.uniform(0.3, 0.2)]
    table = fo.dissipation_study(
        contact, CYCLE, axis, factors, seed=5, limits=True, store=tmp_path / "runs"
    )
    draws = np.random.default_rng(5)
    # As the distribution is defined.
    fields = [0.4, field, 0.3 + 0.2 * draws.random(4), 0.3 + 0.2 * draws.random(4)]
    assert table.friction_number.tolist() == [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]
    assert table.load_factor.tolist() == 4 * list(factors)
    for number, f in enumerate(fields):
        rows = table[table.friction_number == number]
        assert rows.dissipation.tolist() == [
            fo.steady_state(contact, CYCLE, f, factor).dissipation for factor in factors
        ]
        assert rows.friction.to_numpy() == pytest.approx(np.mean(f))
        assert rows.friction_std.to_numpy() == pytest.approx(np.std(f))
        assert rows.shakedown_limit.to_numpy() == pytest.approx(
            fo.shakedown_limit(contact, CYCLE, f).load_factor, rel=1e-12
        )
    kept = fo.results.read_store(tmp_path / "runs")
    assert sorted(kept.friction) == sorted(table.friction)
    assert sorted(kept.friction_std) == sorted(table.friction_std)
    # As many numbers as nodes.
    column = fo.dissipation_study(contact, CYCLE, np.c_[[0.4, 0.5, 0.6, 0.7]], factors[2:])
    assert column.friction.tolist() == [0.4, 0.5, 0.6, 0.7]


def test_parts_of_a_study_make_the_whole(contact, factors, starts, table, tmp_path):
    parts = [tmp_path / f"part {k}" for k in (1, 2, 3)]
    tables = [
        fo.dissipation_study(contact, CYCLE, 0.4, factors, starts, shard=(k, 3), store=part)
        for k, part in enumerate(parts, start=1)
    ]
    assert [len(part) for part in tables] == [20, 20, 20]
    file = tmp_path / "whole"
    assert fo.results.merge_stores(file, parts) == len(table)
    whole, new = with_followed(
        file, lambda: fo.dissipation_study(contact, CYCLE, 0.4, factors, starts, store=file)
    )
    same(whole, table)
    assert new.empty


def test_a_limit_is_computed_only_for_a_column_or_a_start_that_needs_it(contact, factors):
    frictions = np.c_[[0.4, 0.6]]
    with stops("limits", 1, AssertionError):
        plain = fo.dissipation_study(contact, CYCLE, frictions, factors)
    assert not {"load_ratio", "shakedown_limit"} & set(plain.columns)
    with interrupted("limits", 2):
        fo.dissipation_study(contact, CYCLE, frictions, factors, fo.starts.safe_slips())
    table = fo.dissipation_study(contact, CYCLE, frictions, factors, limits=True)
    same(table[plain.columns], plain)


def test_a_store_keeps_limits_and_so_does_a_store_of_parts(contact, factors, tmp_path):
    question = contact, CYCLE, np.c_[[0.4, 0.6]], factors
    parts = [tmp_path / f"part{k}" for k in (1, 2)]
    for k, part in enumerate(parts, start=1):
        fo.dissipation_study(*question, limits=True, store=part, shard=(k, 2))
    fo.results.merge_stores(tmp_path / "whole", parts)
    fresh = fo.dissipation_study(*question, limits=True)
    with stops("limits", 1, AssertionError):
        same(fo.dissipation_study(*question, limits=True, store=tmp_path / "whole"), fresh)

    with closing(sqlite3.connect(tmp_path / "whole")) as connection, connection:
        connection.execute("UPDATE limits SET load_factor = 2 * load_factor")
    with pytest.warns(fo.results.DamagedRows, match="2 rows are damaged"):
        same(fo.dissipation_study(*question, limits=True, store=tmp_path / "whole"), fresh)


def test_an_interrupt_of_the_limits_leaves_all_runs_and_the_limits_so_far(contact, factors):
    with interrupted("limits", 1) as stop:
        fo.dissipation_study(contact, CYCLE, np.c_[[0.4, 0.6]], factors, limits=True)
    table = stop.value.table
    assert len(table) == 2 * len(factors) and table.attrs["missing"] == 0
    assert (table.shakedown_limit.isna() == (table.friction > 0.5)).all()


@refused(
    ({"load_factors": [0.5, 0.5]}, "load_factors"),
    ({"starts": fo.starts.given_slips(np.zeros((1, 3)))}, "start 'given 0' has a slip of shape"),
    ({"starts": fo.starts.no_slip() + fo.starts.no_slip()}, "two starts are called 'none'"),
    ({"starts": [*fo.starts.no_slip(), 1.0]}, "a float among starts"),
    ({"friction": np.full(4, 0.4)}, "friction: 4 numbers for 4 nodes"),
    ({"friction": []}, "friction: empty"),
    ({"friction": [stats.norm(-5, 1)], "seed": 0}, "friction: a distribution draws -.*truncnorm"),
    ({"friction": stats.norm(0.5, 0.01)}, "seed: None"),
    ({"shard": (4, 3)}, "shard k: 4"),
    ({"shard": (1, 2, 3)}, "shard: "),
    ({"limits": 1}, "limits: 1; give True or False"),
    ({"cycle": {}}, "cycle: empty; give a LoadCycle, or label"),
    ({"cycle": {"": CYCLE}}, "cycle: label ''; give a printable text"),
    ({"cycle": {"slow": {"corners": []}}}, r"cycle\['slow'\]: a dict; give a LoadCycle"),
    ({"cycle": [CYCLE]}, "cycle: a list; give a LoadCycle"),
)
def test_bad_input_is_refused_by_name(change, contact):
    values = {"system": contact, "cycle": CYCLE, "friction": 0.4, "load_factors": [0.5]} | change
    fo.dissipation_study(**values)


@pytest.mark.parametrize("seconds, sizes", [(1e9, [3] * 20), (0.0, [3] * 20 + [2] * 20 + [1] * 20)])
def test_few_runs_are_spread_and_many_are_tasks_that_end_in_time(
    contact, starts, factors, table, tmp_path, monkeypatch, seconds, sizes
):
    """A task without time follows one of its runs and returns the others, so that there is room for
    twenty tasks again."""
    few = Foreign(Future.set_result)
    fo.dissipation_study(contact, CYCLE, 0.4, factors, executor=few)
    assert few.sizes == [1, 1, 1]
    tasks = replace(import_module("frictopt.study.runs").SETTINGS, most_tasks=20, seconds=seconds)
    monkeypatch.setattr("frictopt.study.runs.SETTINGS", tasks)
    many = Foreign(Future.set_result)
    study = fo.dissipation_study(
        contact, CYCLE, 0.4, factors, starts, executor=many, store=tmp_path / "runs"
    )
    same(study, table)
    assert many.sizes == sizes and len(fo.results.read_store(tmp_path / "runs")) == len(table)


@pytest.mark.parametrize("kind", [ThreadPoolExecutor, ProcessPoolExecutor])
def test_an_executor_that_takes_no_runs_is_named(contact, kind):
    executor = kind(1)
    executor.shutdown()
    for closed in (executor, kind):
        with pytest.raises(
            fo.ModelError, match=r"executor: .* takes no runs .*give one that is open"
        ):
            fo.dissipation_study(contact, CYCLE, 0.4, [0.5], executor=closed)


def test_runs_that_an_executor_loses_are_rows_that_say_so(
    contact, starts, factors, table, tmp_path
):
    part = fo.dissipation_study(
        contact,
        CYCLE,
        0.4,
        factors,
        starts,
        executor=Foreign(Future.set_result, most=16),
        store=tmp_path / "runs",
    )
    lost = part.outcome == "FAILED"
    assert lost.sum() == len(table) - 16 and part.error[lost].str.contains("link down").all()
    same(part[~lost], table[~lost])
    kept = fo.results.read_store(tmp_path / "runs")
    assert (kept.outcome != "FAILED").sum() == 16 and len(kept) == len(table)
    broken = Foreign(lambda future, rows: future.cancel() and future.set_running_or_notify_cancel())
    other = fo.dissipation_study(contact, CYCLE, 0.4, factors, starts, executor=broken)
    assert (other.outcome == "FAILED").all() and other.error.str.contains("CancelledError").all()


def test_an_interrupt_leaves_what_an_executor_has_finished_and_cancels_the_rest(
    contact, starts, factors, table, tmp_path
):
    futures = []

    def first_alone(future, rows):
        futures.append(future)
        if len(futures) == 1:
            future.set_result(rows)
        if len(futures) == len(table):
            futures[1].set_exception(KeyboardInterrupt())

    with pytest.raises(KeyboardInterrupt) as stop:
        fo.dissipation_study(
            contact,
            CYCLE,
            0.4,
            factors,
            starts,
            executor=Foreign(first_alone),
            store=tmp_path / "runs",
        )
    same(stop.value.table, table.head(1))
    assert len(futures) == len(table) and all(future.cancelled() for future in futures[2:])


def test_futures_that_cannot_be_cancelled_are_futures(contact, factors, table):
    """Futures that cannot be cancelled, as those of some libraries, are futures, too."""

    class Kept(Future):
        def cancel(self):
            raise NotImplementedError

    executor = Foreign(Future.set_result, kind=Kept)
    other = fo.dissipation_study(contact, CYCLE, 0.4, factors, executor=executor)
    assert other.dissipation.tolist() == table.dissipation[table.family == "none"].tolist()


SLOW = fo.LoadCycle({"mean": 1.0}, [{"cyclic": -0.5}, {"cyclic": 1.0}])
FAST = fo.LoadCycle({"mean": 1.5}, [{"cyclic": -1.0}, {"cyclic": 1.0}])


@pytest.fixture
def both(contact, factors):
    """A study of two load cycles."""
    return fo.dissipation_study(
        contact, {"slow": SLOW, "fast": FAST}, [0.4, 0.6], factors, limits=True
    )


def test_load_cycles_are_an_axis_between_friction_and_load(contact, factors, both):
    parts = [
        fo.dissipation_study(contact, cycle, friction, factors, limits=True)
        for friction in (0.4, 0.6)
        for cycle in (SLOW, FAST)
    ]
    for part, (number, label) in zip(
        parts, [(0, "slow"), (0, "fast"), (1, "slow"), (1, "fast")], strict=True
    ):
        mine = both[(both["friction_number"] == number) & (both["cycle"] == label)]
        assert (part["cycle"] == "").all() and len(mine) == len(factors)
        left = ["friction_number", "cycle", "seconds"]
        pd.testing.assert_frame_equal(
            mine.drop(columns=left).reset_index(drop=True),
            part.drop(columns=left),
            check_exact=True,
        )
    assert both["cycle"].tolist() == 2 * (3 * ["slow"] + 3 * ["fast"])
    assert both.groupby("cycle")["shakedown_limit"].nunique().to_dict() == {"slow": 2, "fast": 2}


def test_a_store_knows_the_load_cycles_by_label_and_content(contact, factors, both, tmp_path):
    parts = [tmp_path / f"part{k}" for k in (1, 2)]
    for k, part in enumerate(parts, start=1):
        fo.dissipation_study(
            contact, {"slow": SLOW, "fast": FAST}, [0.4, 0.6], factors, store=part, shard=(k, 2)
        )
    assert fo.results.merge_stores(tmp_path / "whole", parts) == len(both)
    kept = fo.results.read_store(tmp_path / "whole")
    assert kept.groupby("cycle").size().to_dict() == {"slow": 6, "fast": 6}
    assert kept.groupby("cycle")["loads"].nunique().to_dict() == {"slow": 1, "fast": 1}
    again = fo.dissipation_study(
        contact, {"slow": SLOW, "fast": FAST}, [0.4, 0.6], factors, store=tmp_path / "whole"
    )
    assert set(again.seconds) == set(kept.seconds)
    runs_alone = results(both).drop(columns=["load_ratio", "shakedown_limit"])
    pd.testing.assert_frame_equal(results(again), runs_alone, check_exact=True)
    renamed = fo.dissipation_study(contact, {"new": FAST}, 0.4, factors, store=tmp_path / "whole")
    assert renamed["cycle"].tolist() == 3 * ["new"]
    assert renamed["dissipation"].tolist() == both["dissipation"][3:6].tolist()
    assert fo.dissipation_study(contact, FAST, 0.4, factors, store=tmp_path / "whole")[
        "cycle"
    ].tolist() == 3 * [""]
    with pytest.raises(
        fo.StoreError,
        match="whole' has runs of another load cycle under the label 'slow'; give one of them another label",
    ):
        fo.dissipation_study(contact, {"slow": FAST}, 0.4, factors, store=tmp_path / "whole")


def test_stores_of_different_load_cycles_under_one_label_are_not_merged(contact, tmp_path):
    for name, cycle in (("one", SLOW), ("two", FAST)):
        fo.dissipation_study(contact, {"same": cycle}, 0.4, [0.5], store=tmp_path / name)
    with pytest.raises(fo.StoreError, match="two' has another load cycle under the label 'same'"):
        fo.results.merge_stores(tmp_path / "whole", [tmp_path / "one", tmp_path / "two"])
    with pytest.raises(
        fo.StoreError, match="one' has runs of another load cycle under the label 'same'"
    ):
        fo.results.merge_stores(tmp_path / "one", [tmp_path / "two"])
    assert len(fo.results.read_store(tmp_path / "one")) == 1
