"""The study of peers: what needs no peer."""

import sys

import cvxpy as cp
import numpy as np
import pytest

from studies.validation.closed_forms import masing_dissipation
from studies.validation.error_vs_time.transients import last_work
from studies.validation.peers import plane, programs, spheres
from studies.validation.peers.printed import Arrays
from studies.validation.peers.programs import NoAnswer, Peer, Pythons
from studies.validation.peers.questions import Asked, Contact, answered, seconds_of_ours
from studies.validation.peers.study import PEERS_TABLE

HERE = Pythons((sys.executable,))
FAKE = Peer("Fake", "json", "fake", "pip install fake")


def _program(monkeypatch, folder, text):
    monkeypatch.setattr(programs, "OUTSIDE", folder)
    (folder / "fake_peer.py").write_text(text, encoding="utf-8")


def test_a_peer_is_compared_with_our_fastest_answer_that_is_as_exact():
    ours = [{"error": 1e-3, "seconds": 1.0}, {"error": 1e-5, "seconds": 3.0}]
    assert seconds_of_ours(ours, 1e-2) == 1.0
    assert seconds_of_ours(ours, 1e-4) == 3.0
    assert seconds_of_ours(ours, 1e-6) == np.inf
    # The same discretisation: errors that differ by their rounding are equal.
    assert seconds_of_ours(ours, 0.999e-5) == 3.0
    # Below rounding, errors count as equal.
    assert seconds_of_ours([{"error": 5e-13, "seconds": 2.0}], 1e-15) == 2.0


def test_the_block_is_a_slider_on_a_spring():
    slider = masing_dissipation([plane.SHEAR_MODULUS], [plane.BOUND], plane.FAR)
    assert plane.block_work() == pytest.approx(slider)
    for elements in (1, 3):
        assert last_work(plane._block_path(elements)) == pytest.approx(slider, rel=1e-9)


@pytest.mark.parametrize("increments", [1, 3])
def test_the_work_of_the_top_is_that_of_a_slider_followed_by_hand(increments):
    motions = np.array(plane.steps(increments))[:, 0]
    slip = 0.0
    shears = []
    for x in motions:
        shear = np.clip(plane.SHEAR_MODULUS * (x - slip), -plane.BOUND, plane.BOUND)
        slip = x - shear / plane.SHEAR_MODULUS
        shears.append(shear)
    assert np.allclose(shears, np.array(plane.steps(increments))[:, 1])
    work = plane.work_of_top(motions, np.array(shears), increments)
    assert work == pytest.approx(plane.block_work())


def test_the_tractions_of_the_sphere_carry_their_forces():
    r = np.linspace(0, 1, 20001)
    pressed = np.trapezoid(spheres.pressure(r) * r, r)
    sheared = np.trapezoid(spheres.shear(r) * r, r)
    assert pressed == pytest.approx(1 / 3, rel=1e-4)
    assert sheared == pytest.approx(spheres.SHARE * pressed, rel=1e-4)


def test_our_tractions_of_the_sphere_approach_the_closed_forms():
    r, found = spheres._sheared_once(16, 0.5)
    assert spheres.norm_error(found, spheres.shear(r)) < 0.1
    assert spheres.norm_error(0 * found, spheres.shear(r)) == pytest.approx(1.0)


def test_a_printed_problem_keeps_its_equations_as_arrays():
    x, y = cp.Variable(), cp.Variable()
    problem = cp.Problem(cp.Maximize(x + y), [x == 2 * y, y <= 3, x + y >= 0])
    arrays = Arrays(problem)
    assert arrays.equal == 1
    assert arrays.highs({}) == pytest.approx(9.0)
    assert arrays.clarabel(1e-9) == pytest.approx(9.0, rel=1e-6)
    assert arrays.osqp(1e-8) == pytest.approx(9.0, rel=1e-5)


def test_a_peer_that_is_not_installed_is_named_with_its_command():
    nothing = Peer("Nothing", "no_such_module_at_all", "nothing", "pip install nothing")
    contact = Contact("c", "q", "r", [], [Asked(nothing, "m", "s", {}, float)])
    (row,) = answered(contact, HERE, 0, 10.0)
    assert row["result"] == "not installed (pip install nothing)" and row["error"] == np.inf
    assert HERE.version(nothing) == ""


def test_the_answer_of_a_program_is_its_last_line(monkeypatch, tmp_path):
    text = "import json, sys\nprint('banner')\nasked = json.load(sys.stdin)\n"
    _program(monkeypatch, tmp_path, text + "print(json.dumps({'twice': 2 * asked['x']}))\n")
    assert HERE.answer(FAKE, {"x": 21}, 60.0) == {"twice": 42}


def test_a_program_that_fails_or_does_not_end_has_a_reason(monkeypatch, tmp_path):
    _program(monkeypatch, tmp_path, "raise SystemExit('no convergence')\n")
    with pytest.raises(NoAnswer, match="no convergence"):
        HERE.answer(FAKE, {}, 60.0)
    _program(monkeypatch, tmp_path, "import time\ntime.sleep(60)\n")
    with pytest.raises(NoAnswer, match=r"no answer in 0\.5 s"):
        HERE.answer(FAKE, {}, 0.5)


def test_the_quick_table_has_our_answers_and_names_all_peers(quick):
    table = quick((PEERS_TABLE,))[PEERS_TABLE.name]
    assert set(table["code"]) >= {"frictopt", "tamaas", "Kratos", "Siconos", "GetFEM"}
    ours = table[table["code"] == "frictopt"]
    assert set(ours["result"]) == {"answer"}
    proven = ours[ours["reference"] != "Mindlin and Deresiewicz"]
    assert proven["error"].max() < 0.12
    exact = ours[ours["contact"].str.startswith(("block", "punch"))]
    assert exact["error"].max() < 1e-9
    lemke = table[(table["method"] == "Lemke") & table["contact"].str.startswith("cylinder")]
    cylinder = ours[ours["contact"].str.startswith("cylinder")]
    assert np.allclose(lemke["error"], cylinder["error"].iloc[0], rtol=1e-3)
