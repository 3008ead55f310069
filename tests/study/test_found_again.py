"""Runs of a store are found again where rounding is another, and only there."""

import os
import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo
from helpers.runs import with_followed
from helpers.systems import CYCLE, random_system

CONTACT = random_system(np.random.default_rng(3), 3)
CHILD = """
import sys, frictopt as fo
system = fo.scenes.PunchOnHalfPlane(elements=20, growth=1.3).condense()
cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
starts = fo.starts.no_slip() + fo.starts.random_slips(system, [0.1], 2)
study = {"store": sys.argv[1], "progress": False}
fo.dissipation_study(system, cycle, [0.3, 0.5], [0.5, 1.5], starts, **study)
print(system.S.sum().hex(), len(fo.results.read_store(sys.argv[1])))
"""


def rounded(contact, size, seed=0):
    """The contact with other digits behind `size`."""
    noise = np.random.default_rng(seed).uniform(-size, size, contact.S.shape)
    bonded = {name: (q * (1 + size), p * (1 - size)) for name, (q, p) in contact.bonded.items()}
    return replace(contact, S=contact.S * (1 + noise + noise.T), bonded=bonded)


def study(contact, file, **options):
    starts = (
        fo.starts.no_slip() + fo.starts.random_slips(contact, [0.1], 1) + fo.starts.safe_slips()
    )
    starts += fo.starts.given_slips([[0.1, 0.0, -0.2]])
    asked = {"friction": [0.4, 0.5], "load_factors": [0.5, 1.0], "starts": starts} | options
    return fo.dissipation_study(contact, CYCLE, **asked, store=file, limits=True, progress=False)


def followed(contact, file, **options):
    """The rows of a study that it does not take from its store."""
    return with_followed(file, lambda: study(contact, file, **options))[1]


def test_a_contact_of_other_rounding_is_the_same_contact(tmp_path):
    first = study(CONTACT, tmp_path / "a")
    assert len(first) == 20
    for seed in range(3):
        again = study(rounded(CONTACT, 1e-12, seed), tmp_path / "a")
        assert again.seconds.tolist() == first.seconds.tolist()
        assert again.dissipation.tolist() == first.dissipation.tolist()
    slip = [[0.1 * (1 + 1e-12), -1e-14, -0.2]]
    starts = fo.starts.given_slips(slip)
    assert followed(CONTACT, tmp_path / "a", starts=starts, load_factors=[0.5 + 1e-13]).empty


def in_units(contact, stiffness, force):
    """The numbers of a contact in units of stiffness and force."""
    bonded = {name: (q * force, p * force) for name, (q, p) in contact.bonded.items()}
    return replace(contact, S=contact.S * stiffness, bonded=bonded)


def beside_a_soft_body(soft):
    """A stiff node and a soft one, which its small load shears to and fro."""
    S = np.diag([1e6, 1e6 * soft, 1e6, 1e6 * soft])
    loads = {"mean": [0.0, 0.0, 1.0, soft], "cyclic": [0.9, 0.9 * soft, 0.0, 0.0]}
    return fo.ContactSystem(S, [[0.0, 0.0], [1.0, 0.0]], loads)


@pytest.mark.parametrize(
    ("contact", "other"),
    [
        (in_units(CONTACT, 1e-12, 1e-12), in_units(CONTACT, 2e-12, 2e-12)),
        (in_units(CONTACT, 1.0, 1e-12), in_units(CONTACT, 1.0, 2e-12)),
        (beside_a_soft_body(1e-9), beside_a_soft_body(1.1e-9)),
    ],
    ids=["units", "small loads", "soft body"],
)
def test_a_contact_that_differs_in_small_numbers_finds_nothing(tmp_path, contact, other):
    def works(system, file):
        return fo.dissipation_study(
            system, CYCLE, [0.5], [0.8], fo.starts.no_slip(), store=file, progress=False
        ).dissipation.tolist()

    alone = works(other, tmp_path / "b")
    works(contact, tmp_path / "a")
    with pytest.warns(fo.results.OtherRows, match="has runs of other contacts or load cycles only"):
        assert works(other, tmp_path / "a") == alone


@pytest.mark.parametrize(
    "change",
    [
        {"friction": [0.4 + 1e-7, 0.5 + 1e-7]},
        {"load_factors": [0.5 + 1e-7, 1.0 + 1e-7]},
        {
            "starts": fo.starts.random_slips(CONTACT, [0.1], 1, seed=2)
            + fo.starts.random_slips(CONTACT, [0.1001], 1)
        },
        {"starts": fo.starts.given_slips([[0.1, 0.0, -0.2 + 1e-7]])},
    ],
    ids=["friction", "load factor", "seed", "slip"],
)
def test_another_run_is_followed(tmp_path, change):
    study(CONTACT, tmp_path / "a")
    table, new = with_followed(tmp_path / "a", lambda: study(CONTACT, tmp_path / "a", **change))
    assert len(table) == len(new) > 0


def test_stores_of_contacts_of_other_rounding_are_merged_as_one(tmp_path):
    for seed, shard in enumerate([(1, 2), (2, 2)]):
        study(rounded(CONTACT, 1e-12, seed), tmp_path / f"part{seed}", shard=shard)
    study(rounded(CONTACT, 1e-12, 5), tmp_path / "all")
    parts = [tmp_path / "part0", tmp_path / "part1"]
    assert fo.results.merge_stores(tmp_path / "all", parts) == 20
    assert followed(CONTACT, tmp_path / "all").empty


def test_rows_of_another_version_are_named_and_followed_again(tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(fo, "__version__", "0.1.9")
        study(CONTACT, tmp_path / "a")
        assert followed(CONTACT, tmp_path / "a").empty
    with pytest.warns(
        fo.results.OtherRows, match="20 runs are of version 0.1.9, and not taken over"
    ):
        assert len(study(CONTACT, tmp_path / "a")) == 20
    assert set(fo.results.read_store(tmp_path / "a").version) == {fo.__version__}


def test_a_damaged_contact_is_named_and_its_runs_are_found_again(tmp_path):
    """Its bits are the same, and so is its key."""
    first = study(CONTACT, tmp_path / "a")
    with closing(sqlite3.connect(tmp_path / "a")) as connection, connection:
        connection.execute("UPDATE contacts SET sketch = zeroblob(8)")
    with pytest.warns(fo.results.DamagedRows, match="1 row is damaged"):
        assert study(CONTACT, tmp_path / "a").seconds.tolist() == first.seconds.tolist()


def test_a_store_goes_to_another_kind_of_processor_and_back(tmp_path):
    """OpenBLAS is told to be one for older processors, which rounds otherwise."""
    said = []
    for kind in ({}, {"OPENBLAS_CORETYPE": "Nehalem"}, {"OPENBLAS_NUM_THREADS": "2"}, {}):
        environment = os.environ | {"PYTHONPATH": str(Path(fo.__file__).parents[1])} | kind
        run = subprocess.run(
            [sys.executable, "-c", CHILD, tmp_path / "runs"],
            env=environment,
            capture_output=True,
            text=True,
            timeout=300,
        )
        said.append(run.stdout.split())
    assert [count for _, count in said] == ["20"] * 4
