"""Fatigue parameters over all states of rest.

They are compared with all vertices of the safe slips and with transients, and with closed forms.
"""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import linprog

import frictopt as fo
from helpers.cases import few
from helpers.refused import refused
from helpers.stresses import TO_FRO, TURNING, held_node, parameters, random_contact, vertices


@pytest.mark.parametrize("seed", few(range(20), share=10))
def test_no_vertex_of_the_safe_slips_is_outside_and_both_ends_occur(seed):
    name = ("SWT", "Findley", "Fatemi_Socie", "Crossland")[seed % 4]
    stresses = random_contact(seed)
    load_factor = 0.6 * fo.shakedown_limit(stresses.system, TURNING, 0.5).load_factor
    corners = vertices(stresses.system, TURNING, 0.5, load_factor)
    rng = np.random.default_rng(seed)
    inside = [rng.dirichlet(np.ones(len(corners))) @ corners for _ in range(4)]

    def values(slip):
        return parameters(stresses, TURNING, load_factor, slip)[name].to_numpy()

    band = fo.fatigue_band(stresses, TURNING, 0.5, load_factor, name, planes=12)
    largest = np.max([values(slip) for slip in corners], axis=0)
    most = band.to_frame()["most"].to_numpy()
    assert most == pytest.approx(largest, rel=2e-4)
    assert (most >= largest * (1 - 1e-9)).all()
    for slip, value in ((band.least_slip, band.least), (band.worst_slip, band.most)):
        assert values(slip).max() == pytest.approx(value, rel=1e-6)
    assert band.bound <= band.least <= min(values(slip).max() for slip in inside)
    assert band.least - band.bound <= 1e-6 * largest.max()
    assert band.residual < 1e-9


def test_both_ends_are_attained_by_transients_that_start_with_their_slips():
    stresses = random_contact(1)
    load_factor = 0.6 * fo.shakedown_limit(stresses.system, TO_FRO, 0.5).load_factor
    band = fo.fatigue_band(stresses, TO_FRO, 0.5, load_factor)
    for slip, value in ((band.least_slip, band.least), (band.worst_slip, band.most)):
        steady = fo.steady_state(
            stresses.system, TO_FRO, 0.5, load_factor, initial_slip=slip, progress=False
        )
        assert steady.outcome is fo.Outcome.SHAKEDOWN
        assert steady.slip == pytest.approx(slip, abs=1e-9)
        assert band.at(steady.slip).max() == pytest.approx(value, rel=1e-9)


@pytest.mark.parametrize("seed", few(range(6)))
def test_open_nodes_follow_the_slip(seed):
    """The parameter with a slip is that of the states of a transient that rests with it."""
    stresses = random_contact(seed, 0.5, [0.0, 5.0, 0.0])
    load_factor = 0.5 * fo.shakedown_limit(stresses.system, TO_FRO, 0.5).load_factor
    band = fo.fatigue_band(stresses, TO_FRO, 0.5, load_factor, planes=12)
    for slip in (band.least_slip, band.worst_slip):
        steady = fo.steady_state(stresses.system, TO_FRO, 0.5, load_factor, initial_slip=slip)
        states = steady.states()
        assert steady.outcome is fo.Outcome.SHAKEDOWN and (states.gap[:, 1] > 0).all()
        fields = []
        for amplitudes, v, w in zip(states.amplitudes, states.slip, states.gap, strict=True):
            loads = dict(zip(stresses.loads, amplitudes, strict=True))
            tensors = stresses.tensors(loads, v, w)
            fields.append(SimpleNamespace(tensors_at_contact=lambda side, t=tensors: t))
        table = steady.fretting_table(fields=fields)
        assert band.at(steady.slip) == pytest.approx(table["SWT"], rel=1e-6)


def uncoupled():
    """Three nodes without coupling, and the stress `v0 - v2 / 2` at one point."""
    A = [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]]
    loads = {"P": ([0, 0, 0], [1, 1, 1]), "Q": ([1.0, 0.2, 0.1], [0, 0, 0])}
    contact = fo.ContactSystem.from_blocks(A, np.zeros((3, 3)), 2 * np.eye(3), range(3), loads)
    motions = np.zeros((6, 2, 1, 3, 3))
    motions[[0, 2], :, 0, 0, 0] = [[1.0, 1.0], [-0.5, -0.5]]
    none = np.zeros((2, 1, 3, 3))
    return fo.results.StressMap(contact, [[0.0, 0.0]], {"P": none, "Q": none}, motions)


def test_above_the_limit_all_steady_cycles_of_an_uncoupled_contact_are_in_the_band():
    stresses = uncoupled()
    band = fo.fatigue_band(stresses, TO_FRO, 0.5, 0.9)
    # SWT: the largest stress times half of its range .4.
    assert band.least == pytest.approx(0.2 * 0.11875, rel=1e-7)
    assert band.most == pytest.approx(0.2 * 0.28125, rel=1e-7)
    (row,) = band.to_frame().to_dict("records")
    ends = [row[f"{end}_{which}"] for which in ("least", "most") for end in ("from", "to")]
    assert ends == pytest.approx([-0.28125, 0.11875, -0.11875, 0.28125], rel=1e-7)
    for start in np.random.default_rng(0).normal(size=(10, 3)):
        steady = fo.steady_state(stresses.system, TO_FRO, 0.5, 0.9, initial_slip=start)
        assert steady.outcome is fo.Outcome.CYCLIC_SLIP
        value = band.at(steady.slip).max()
        states = steady.states()
        largest = (states.slip @ [1.0, 0.0, -0.5]).max()
        assert value == pytest.approx(0.2 * largest, rel=1e-7)
        assert band.least * (1 - 1e-7) <= value <= band.most * (1 + 1e-7)


@pytest.mark.parametrize("seed", few(range(30), share=10))
def test_cycles_that_a_slip_shifts_obey_the_law_and_both_ends_occur(seed):
    """Above the limit, with coupling: the ends are linear programs over the shifts, by scipy."""
    stresses = random_contact(seed)
    contact = stresses.system
    load_factor = 1.05 * fo.shakedown_limit(contact, TO_FRO, 0.5).load_factor
    start = np.random.default_rng(seed).normal(size=3)
    steady = fo.steady_state(contact, TO_FRO, 0.5, load_factor, initial_slip=start)
    states = steady.states()
    moved = np.ptp(states.slip, axis=0) > 1e-9
    assert moved.any() and (states.gap == 0).all()
    fixed = np.vstack([contact.A[moved], contact.B[moved]])
    rows, right = [], []
    for q, p in zip(states.q, states.p, strict=True):
        for sign in (1, -1):
            rows.append((sign * contact.A - 0.5 * contact.B)[~moved])
            right.append((0.5 * p - sign * q)[~moved])
    program = {"A_ub": np.vstack(rows), "b_ub": np.concatenate(right)}
    program |= {"A_eq": fixed, "b_eq": np.zeros(len(fixed)), "bounds": (None, None)}
    at_states = zip(states.amplitudes, states.slip, strict=True)
    loads = [dict(zip(contact.bonded, amplitudes, strict=True)) for amplitudes, _ in at_states]
    tensors = np.array(
        [stresses.tensors(load, slip)[0] for load, slip in zip(loads, states.slip, strict=True)]
    )
    shape = len(tensors), 3, 9
    mean = np.trace(tensors, axis1=-2, axis2=-1) / 3
    deviator = (tensors - mean[..., None, None] * np.eye(3)).reshape(shape)
    apart = np.linalg.norm(deviator[:, None] - deviator[None], axis=-1).max(axis=(0, 1))
    crossland = apart / 2 / np.sqrt(2) + 0.3 * mean.max(axis=0)
    rates = 0.1 * np.trace(np.asarray(stresses.motions)[:3, 0], axis1=-2, axis2=-1)
    ends = [linprog(-rates[:, point], **program) for point in range(3)]
    most = max(value - end.fun for value, end in zip(crossland, ends, strict=True))

    name = "Crossland"
    band = fo.fatigue_band(stresses, TO_FRO, 0.5, load_factor, name, initial_slip=start)
    assert band.most == pytest.approx(most, rel=1e-7)
    assert "that of the initial slip" in band.reason
    assert band.at(steady.slip).max() == pytest.approx(crossland.max(), rel=1e-7)
    for slip, value in ((band.least_slip, band.least), (band.worst_slip, band.most)):
        assert band.at(slip).max() == pytest.approx(value, rel=1e-7)
        shift = slip - steady.slip
        assert np.abs(fixed @ shift).max() < 1e-8
        assert (program["A_ub"] @ shift <= program["b_ub"] + 1e-8).all()


def test_life_is_basquins_line_of_the_parameter():
    band = fo.fatigue_band(uncoupled(), TO_FRO, 0.5, 0.9)
    (row,) = band.life(k_1=5.0, ND=1e6, SD=0.05).to_dict("records")
    assert row["best"] == pytest.approx(1e6 * (0.05 / (0.2 * 0.11875)) ** 5, rel=1e-6)
    assert row["worst"] == pytest.approx(1e6 * (0.05 / (0.2 * 0.28125)) ** 5, rel=1e-6)
    assert np.isnan(row["assembled"])  # these cycles do not have zero slip
    (row,) = band.life(5.0, 1e6, 0.05, slip=band.worst_slip).to_dict("records")
    assert row["assembled"] == pytest.approx(row["worst"], rel=1e-6)


def test_a_point_in_compression_lives_for_ever_and_a_wedged_one_not_at_all():
    pressed = fo.fatigue_band(held_node(coupling=2.5), TO_FRO, 0.5, 0.5)
    (row,) = pressed.life(5.0, 1e6, 0.1).to_dict("records")
    assert row["best"] > 1e30 and row["worst"] == 0.0


def test_matake_is_findleys_sum_on_the_planes_of_the_largest_shear():
    """A stress along x has these planes at 45 degrees; half of it acts across them."""
    band = fo.fatigue_band(uncoupled(), TO_FRO, 0.5, 0.9, "Matake", weight=0.5)
    assert band.proven
    assert band.least == pytest.approx(0.1 + 0.25 * 0.11875, rel=1e-7)
    assert band.most == pytest.approx(0.1 + 0.25 * 0.28125, rel=1e-7)


def test_dang_van_has_tresca_about_the_centre_of_the_smallest_ball():
    """To and fro the centre is the middle. A corner inside of the ball moves nothing."""
    for cycle in (TO_FRO, fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}, {"Q": 0.5}])):
        band = fo.fatigue_band(uncoupled(), cycle, 0.5, 0.9, "Dang_Van", weight=0.6)
        assert band.proven
        assert band.least == pytest.approx(0.1 + 0.2 * 0.11875, rel=1e-7)
        assert band.most == pytest.approx(0.1 + 0.2 * 0.28125, rel=1e-7)


@pytest.mark.parametrize("load_factor", [0.3, 2 / 3, 0.9])
def test_one_held_node_has_a_worst_state_in_closed_form(load_factor):
    """Its safe slips are up to `1 - load factor`, so that the worst falls near the limit."""
    band = fo.fatigue_band(held_node(), TO_FRO, 0.5, load_factor)
    assert band.most == pytest.approx(load_factor * (2 - 1.5 * load_factor), rel=1e-9)
    assert band.worst_slip == pytest.approx([1 - load_factor], rel=1e-9)
    bounded = fo.fatigue_band(held_node(), TO_FRO, 0.5, load_factor, slip_bound=0.05)
    assert bounded.most == pytest.approx(load_factor * (0.1 + 0.5 * load_factor), rel=1e-9)


def test_friction_that_wedges_leaves_no_worst_state():
    band = fo.fatigue_band(held_node(coupling=2.5), TO_FRO, 0.5, 0.5)
    assert band.most == np.inf and "wedges" in band.reason
    assert np.isnan(band.worst_slip).all()
    bounded = fo.fatigue_band(held_node(coupling=2.5), TO_FRO, 0.5, 0.5, slip_bound=0.1)
    assert np.isfinite(bounded.most)


def test_the_face_is_marked_and_a_depth_is_not(tmp_path):
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    on_face, below = (model.stress_map(depth=depth, side=2) for depth in (0.0, 0.4))
    face = fo.fatigue_band(on_face, cycle, 0.7, 0.5, "Crossland")
    assert "grows with each refinement" in face.reason
    assert "grows" not in fo.fatigue_band(below, cycle, 0.7, 0.5, "Crossland").reason
    face.save(tmp_path / "band.npz")
    assert fo.results.load(tmp_path / "band.npz").to_frame().equals(face.to_frame())
    steady = fo.steady_state(on_face.system, cycle, 0.7, 0.5)
    table = steady.fretting_table(fields=model, side=2)
    assert face.at(steady.slip) == pytest.approx(table["Crossland"], rel=1e-8)


@refused(
    (
        lambda: fo.fatigue_band(random_contact(3), TO_FRO, 0.5, 20.0),
        "load_factor: 20 has no state of rest: the shakedown limit is",
    ),
    (
        lambda: fo.fatigue_band(
            uncoupled(), TO_FRO, 0.5, 0.1, slip_bound=1.0, initial_slip=np.zeros(3)
        ),
        "initial_slip: not with a slip_bound",
    ),
    (lambda: fo.fatigue_band(uncoupled(), TO_FRO, 0.5, 0.1).life(5.0, 1e6, 0.0), "SD: 0.0"),
    (lambda: fo.fatigue_band(uncoupled().system, TO_FRO, 0.5, 0.1), "stress_map: .*give the"),
    (lambda: fo.fatigue_band(uncoupled(), TO_FRO, 0.5, 0.1, "Ruiz"), "parameter: 'Ruiz'"),
    (
        lambda: fo.fatigue_band(uncoupled(), TO_FRO, 0.5, 0.1).at([5.0, 0.0, 0.0]),
        "slip: it violates the contact law",
    ),
)
def test_bad_bands_are_refused(call):
    call()


QUESTIONS = Path(__file__).parents[2] / "docs" / "faq.md"


def test_the_code_of_the_page_has_the_lives_of_both_ends_by_goodman_and_basquin():
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    stresses = model.stress_map(depth=0.3, side=2)
    band = fo.fatigue_band(stresses, cycle, 0.7, load_factor=0.8)
    (code,) = (
        part.partition("```")[0]
        for part in QUESTIONS.read_text(encoding="utf-8").split("```python\n")
        if "pylife" in part.partition("```")[0]
    )
    page = {"band": band}
    exec(code, page)
    table = band.to_frame()
    for end in ("least", "most"):
        low, high = table[f"from_{end}"], table[f"to_{end}"]
        # The Haigh diagram falls by 0.3 between R = -inf and 0, by 0.1 up to R = 0.5, and is level
        # below R = -inf.
        amplitude, mean = (high - low) / 2, (high + low) / 2
        alike = amplitude + 0.3 * np.clip(mean, -amplitude, amplitude)
        above = np.clip(mean, amplitude, 3 * amplitude)
        alike = np.where(mean > amplitude, 1.3 * (amplitude + 0.1 * above) / 1.1, alike)
        lives = np.where(alike >= 0.4, 2e6 * (alike / 0.4) ** -5.0, np.inf)
        assert np.asarray(page["cycles"][end]) == pytest.approx(lives, rel=1e-9)
    assert np.isfinite(page["cycles"]["most"]).any()
    assert (page["cycles"]["most"] <= page["cycles"]["least"]).all()
