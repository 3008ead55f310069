"""The study of increments at quick size: facts of the contact law that hold on any mesh."""

import numpy as np
import pytest

import frictopt as fo
from studies import increments, paper

pytestmark = pytest.mark.slow

STUDY = increments.STUDY
COMPLIANCE = 2 * (1 - 0.3**2)  # 1/E* of two bodies with E = 1, nu = 0.3


@pytest.fixture(scope="module")
def contact():
    return fo.scenes.PunchOnHalfPlane(elements=increments.QUICK.elements).condense()


def test_every_row_obeys_the_contact_law(tables):
    for name in ("increments_cycle", "increments_corner"):
        table = tables[name]
        assert (table["q"].abs() <= table["friction"] * table["p"] * (1 + 1e-9)).all(), name


def test_load_is_above_the_limit(tables, contact):
    factor = tables["increments_cycle"]["load_factor"].iloc[0]
    assert factor == pytest.approx(1.4 * fo.shakedown_limit(contact, paper.LOADS, 0.7).load_factor, rel=1e-9)


def test_instants_have_the_reactions_of_their_loads_and_slips(tables, contact):
    (q0, p0), (q1, p1) = contact.bonded["P"], contact.bonded["sigma"]
    levels = {0: 1, 0.5: 0, 0.75: -0.5, 0.9: -0.8, 1: -1, 1.5: 0, 1.75: 0.5, 1.9: 0.8, 2: 1}
    assert set(tables["increments_cycle"]["instant"]) == set(levels)
    for instant, rows in tables["increments_cycle"].groupby("instant"):
        sigma = levels[instant] * rows["load_factor"].iloc[0]
        v = rows["slip"].to_numpy() * COMPLIANCE
        assert np.allclose(rows["sigma"], sigma, rtol=0, atol=1e-12)
        assert np.allclose(rows["q"], q0 + sigma * q1 + contact.A @ v, rtol=0, atol=1e-10)
        assert np.allclose(rows["p"], p0 + sigma * p1 + contact.B @ v, rtol=0, atol=1e-10)
        assert rows["p"].sum() == pytest.approx(2, rel=1e-9)


def test_loop_encloses_the_work_of_its_node(tables):
    """Shear and slip are linear between events, so the trapezoids are exact; q over P/2 and v over (P/2)/E* make four times P^2/E*."""
    table = tables["increments_corner"]
    assert table["node"].nunique() == 2
    for _, rows in table.groupby("node"):
        steady = rows[rows["cycles"] == "steady"]
        q, slip, work = (steady[name].to_numpy() for name in ("q", "slip", "work"))
        assert slip[0] == pytest.approx(slip[-1], abs=1e-8) and steady["time"].iloc[-1] - steady["time"].iloc[0] == 2
        area = -np.sum((q[1:] + q[:-1]) / 2 * np.diff(slip))
        assert area == pytest.approx(4 * (work[-1] - work[0]), rel=1e-8) and area > 0
