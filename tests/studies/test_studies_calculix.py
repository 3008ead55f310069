"""The study of CalculiX beside frictopt: what needs no `ccx`, and its quick tables, run by `ccx`."""

import numpy as np
import pytest

from studies.validation import calculix
from studies.validation.calculix import (
    CONTACTS,
    FORMULATIONS,
    HISTORIES,
    MATRICES,
    OURS,
    QUICK,
    History,
    Job,
    deck_of,
    forces_of_calculix,
    forces_of_frictopt,
    work_of_last_cycle,
)


def test_a_block_that_is_put_down_elsewhere_has_no_shear():
    """Coulomb's law counts slip from the place where the bodies touch."""
    history = HISTORIES["lands elsewhere"]
    forces = forces_of_frictopt(history, QUICK)
    assert forces[-1, 2] > 1.0 and np.abs(forces[:, 1]).max() < 1e-9


def test_a_stuck_block_has_the_forces_of_a_glued_one():
    """They are linear in the displacement, at any friction that is large enough."""
    few, many = (
        forces_of_frictopt(History(HISTORIES["closed"].corners, 0.0, friction), QUICK)
        for friction in (5.0, 50.0)
    )
    assert np.allclose(few, many) and few[-1, 1] == pytest.approx(2 * few[-2, 1])


def test_the_work_of_a_block_that_slides_both_ways_is_that_of_its_friction():
    """By hand: a bound of 0.6 along 4 mm there and back; the way to the first corner is left out."""
    history = HISTORIES["loop"]
    times = np.arange(4.0)
    shear = np.array([0.0, -0.6, 0.6, -0.6])
    square = np.array([[1.0, 0.6], [2.0, 0.6], [2.0, -0.6], [3.0, -0.6]])
    forces = np.column_stack([square[:, 0], square[:, 1], np.full(4, 2.0)])
    # The first row of the cycle is at time 2, where the block begins to go to -2 mm and back.
    assert len(history.corners) == 4 and len(times) == len(shear)
    moved = np.array([[2.0, 0.6, 2.0], [3.0, 0.6, 2.0], [3.0, -0.6, 2.0], [4.0, -0.6, 2.0]])
    assert work_of_last_cycle(moved, history) == pytest.approx(2 * 0.6 * 0.004)
    assert work_of_last_cycle(np.vstack([forces[:1], moved]), history) == pytest.approx(4.8e-3)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_a_deck_has_its_formulation_and_both_faces(formulation):
    deck = deck_of(HISTORIES["closed"], formulation, QUICK)
    assert f"TYPE={FORMULATIONS[formulation]}\n" in deck
    assert "*SURFACE, NAME=Sup\n1, S3\n2, S3\n" in deck
    assert "*SURFACE, NAME=Slo\n1005, S5\n1006, S5\n1007, S5\n1008, S5\n" in deck


def test_without_calculix_the_study_says_how_to_install_it(monkeypatch):
    monkeypatch.setenv("PATH", "")
    for table in (MATRICES, CONTACTS):
        with pytest.raises(calculix.fo.ModelError, match="ccx: not found; install CalculiX"):
            list(table.compute(QUICK))


@pytest.mark.ccx
def test_all_statements_hold(quick):
    table = quick((MATRICES,))[MATRICES.name]
    assert len(table) == 15 and table["holds"].all(), table


@pytest.mark.ccx
def test_closed_contact_is_that_of_frictopt(quick):
    table = quick((CONTACTS,))[CONTACTS.name].set_index("method")
    one, other = table.loc[OURS], table.loc["node to surface"]
    assert other["shear"] == pytest.approx(one["shear"], rel=0.01)
    assert other["pressure"] == pytest.approx(one["pressure"], rel=0.01)


@pytest.mark.ccx
def test_a_job_that_is_stopped_has_no_forces(tmp_path):
    job = Job(tmp_path, seconds=1e-3)
    assert forces_of_calculix(job, HISTORIES["closed"], "mortar", QUICK).shape == (0, 3)
