"""Starts of a study in every form that a user may have them in, and what is refused before anything runs."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from frictopt.histories.starts import Start, given_slips, no_slip, overloads
from systems import CYCLE, random_system

CONTACT = random_system(np.random.default_rng(3), 3)
STARTS = no_slip() + overloads([2.0])


def study(starts, contact=CONTACT, cycle=CYCLE, factors=(0.5,)):
    return fo.dissipation_study(contact, cycle, 0.4, factors, starts)


@pytest.mark.parametrize("make", [tuple, iter, lambda starts: pd.Series(starts), lambda starts: np.array(starts, dtype=object)])
def test_starts_come_in_any_row(make):
    assert study(make(STARTS)).start.tolist() == ["none", "overload to 2"]


@pytest.mark.parametrize("make", [list, iter, pd.DataFrame])
def test_slips_come_in_any_row(make):
    slips = [[0.0, 0.0, 0.0], [1.0, 2.0, 4.0]]
    assert study(make(slips)).amplitude.tolist() == pytest.approx([0.0, np.sqrt(7.0)])
    assert [start.slip.tolist() for start in given_slips(make(slips))] == slips


@pytest.mark.parametrize(
    ("message", "make"),
    [
        ("starts: Start", lambda: study(no_slip()[0])),
        ("a list among starts; .* add lists up", lambda: study([*no_slip(), overloads([2.0])])),
        (r"starts: \[\[0.0, 0.0, 0.0\], \[0.0\]\]", lambda: study([[0.0, 0.0, 0.0], [0.0]])),
        ("starts: empty", lambda: study(iter([]))),
        ("seed of start 'b': 9223372036854775808", lambda: Start("a", "b", seed=2**63)),
    ],
)
def test_what_is_refused(message, make):
    with pytest.raises(fo.ModelError, match=message):
        make()


def test_a_force_too_small_for_the_scale_of_the_dissipation_does_not_cost_the_table():
    tiny = fo.LoadCycle({"mean": 1e-170}, [{"cyclic": 1e-170}, {"cyclic": -1e-170}])
    table = study(STARTS, replace(CONTACT, E_star=1.0), tiny)
    assert len(table) == 2 and table.dissipation_scaled.isna().all()
