"""Names of units: on axes, in tables and in files, and nowhere in the numbers; words for what nodes
do; Datasets."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import frictopt as fo
from frictopt.plots.style import in_units
from helpers.systems import CYCLE, random_system

pytestmark = pytest.mark.usefixtures("no_figures_stay_open")

CONTACT = replace(
    random_system(np.random.default_rng(3), 4), width=[0.5, 1.0, 1.0, 0.5], units="N, mm"
)


@pytest.mark.parametrize(
    ("text", "units", "named"),
    [
        ("slip $v$ (length)", "N, mm", "slip $v$ (mm)"),
        ("work\n(force times length per depth)", "kN, m", "work\n(kN m / m)"),
        ("(force per area)", "N, mm", "(MPa)"),
        ("(force per area)", "lbf, in", "(lbf / in²)"),
        ("weight $g$ of the slip (1 / length)", "N, um", "weight $g$ of the slip (1 / um)"),
        ("longest 0.1 (length), (a length), force", "N, mm", "longest 0.1 (mm), (a length), force"),
    ],
)
def test_meanings_have_names(text, units, named):
    assert in_units(text, units) == named and in_units(text, None) == text


@pytest.mark.parametrize("units", ["N", "N,", "N, mm, s", 3])
def test_units_are_two_names(units):
    with pytest.raises(fo.ModelError, match="units: "):
        replace(CONTACT, units=units)


def test_units_stay_in_files_copies_and_tables(tmp_path):
    CONTACT.save(tmp_path / "one.npz")
    read = fo.ContactSystem.load(tmp_path / "one.npz")
    assert read.units == read.with_gap(np.ones(4)).units == "N, mm" and "units=N, mm" in repr(read)
    replace(CONTACT, units=None).save(tmp_path / "two.npz")
    assert fo.ContactSystem.load(tmp_path / "two.npz").units is None
    steady = fo.steady_state(read, CYCLE, 0.4, 1.0)
    study = fo.dissipation_study(read, CYCLE, 0.4, [1.0], progress=False)
    limit = fo.shakedown_limit(read, CYCLE, 0.4)
    for table in (
        read.to_frame(),
        steady.to_frame(),
        steady.states().to_frame(),
        steady.fretting_table(),
        study,
        limit.to_frame(),
    ):
        assert table.attrs["units"] == "N, mm"


def test_models_pass_their_units_on():
    scene = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    model = replace(scene, units="N,mm")
    assert model.condense().units == "N, mm" and model.plot().get_xlabel() == "$x$ (mm)"
    assert scene.plot().get_xlabel() == "$x$ (length)"


def test_axes_and_legends_have_the_units():
    steady = fo.steady_state(CONTACT, CYCLE, 0.4, 1.0)
    slip, force, work = steady.plot()
    assert [one.get_ylabel() for one in (slip, force, work)] == [
        "slip range (mm)",
        "traction\n(MPa)",
        "work of friction per cycle\n(N mm / mm)",
    ]
    assert work.get_xlabel().endswith("(mm)")
    table = fo.dissipation_study(CONTACT, CYCLE, 0.4, [1.0, 2.0], progress=False)
    assert fo.plot_study(table).get_ylabel().endswith("(N mm / mm)")
    _, given = plt.subplots(3, 1)
    assert steady.plot(given)[0].get_ylabel() == "slip range (mm)"


def test_states_have_words_and_are_a_dataset():
    steady = fo.steady_state(CONTACT, CYCLE, 0.4, 2.0)
    states = steady.states()
    words = {0: "stick", 1: "slip+", -1: "slip-", 2: "open"}
    assert states.to_frame()["status"].tolist() == [
        words[code] for code in states.status.ravel().tolist()
    ]
    data = states.to_xarray()
    assert isinstance(data, xr.Dataset) and data.attrs == {"units": "N, mm"}
    assert np.array_equal(data["slip"].isel(state=-1), states.slip[-1]) and np.array_equal(
        data["x"], CONTACT.x
    )
    assert np.array_equal(
        data["amplitude"].sel(case="cyclic"),
        states.amplitudes[:, list(CONTACT.bonded).index("cyclic")],
    )
    assert float((data["work"].isel(state=-1)).sum()) == pytest.approx(
        steady.period * steady.dissipation
    )


def test_a_study_is_a_dataset_by_its_axes():
    """Also where one friction is a field with the mean of another."""
    frictions = [0.3, 0.4, np.linspace(0.3, 0.5, CONTACT.nodes)]
    table = fo.dissipation_study(CONTACT, CYCLE, frictions, [1.0, 2.0], progress=False)
    data = table.set_index(["friction_number", "load_factor", "start"]).to_xarray()
    assert dict(data.sizes) == {"friction_number": 3, "load_factor": 2, "start": 1}
    assert np.allclose(data["friction"].sel(friction_number=2), 0.4)
    for number, friction in enumerate(frictions):
        work = data["dissipation"].sel(friction_number=number, load_factor=2.0, start="none")
        assert float(work) == fo.steady_state(CONTACT, CYCLE, friction, 2.0).dissipation
