"""Names of units: on axes, in tables and in files, and nowhere in the numbers; words for what nodes
do; Datasets."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshQuad

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
    assert in_units(text, units) == named


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


def fitted(kinematics):
    """A sleeve on a shaft of radius 10, both 4 high, pressed by a fit and pushed along the axis."""
    height = np.linspace(0.0, 4.0, 5)
    shaft, sleeve = (
        fo.fem.Body(
            MeshQuad.init_tensor(np.linspace(*radii, 5), height).with_boundaries(
                {
                    "face": lambda x: x[0] == 10.0,
                    "bore": lambda x: x[0] == 5.0,
                    "rim": lambda x: x[0] == 18.0,
                    "end": lambda x: x[1] == 4.0,
                }
            )
        )
        for radii in ((5.0, 10.0), (10.0, 18.0))
    )
    model = fo.fem.ContactModel(
        {"shaft": shaft, "sleeve": sleeve},
        [fo.fem.Support("sleeve", "rim"), fo.fem.Support("shaft", "bore", "x")],
        {
            "fit": [fo.fem.Interference("fit", 0.01)],
            "push": [fo.fem.Traction("shaft", "end", y=1.8e-4)],
        },
        [fo.fem.Contact("shaft", "sleeve", "face", "face", name="fit")],
        kinematics,
        units="N, mm",
    )
    return model.condense()


@pytest.mark.parametrize("kinematics", ["plane_strain", "plane_stress", "axisymmetric"])
def test_units_are_per_depth_unless_forces_are_totals_over_the_circumference(tmp_path, kinematics):
    """The width of the contact shows which forces the system holds: 4, or the area 2 pi 10 4."""
    system = fitted(kinematics)
    is_total = system.width.sum() > 4.1
    assert system.width.sum() == pytest.approx(80 * np.pi if is_total else 4.0)
    system.save(tmp_path / "fit.npz")
    system = fo.ContactSystem.load(tmp_path / "fit.npz").with_gap(None)
    cycle = fo.LoadCycle({"fit": 1.0}, [{"push": 1.0}, {"push": -1.0}])
    report = fo.report(system, cycle, 0.3, [1.0], pages=1, limits={"work": 1.0})
    numbers = report.numbers.set_index("number")
    work = "N mm" if is_total else "N mm per depth"
    assert numbers.loc["work per cycle", "unit"] == report.verdicts.unit[0] == work
    assert ("per depth" in str(report)) is not is_total
    steady, bare = report.steady, replace(system, width=None)
    study = fo.dissipation_study(system, cycle, 0.3, [1.0], progress=False)
    per_length = "(N mm)" if is_total else "(N mm / mm)"
    nodal = "(N)" if is_total else "(N / mm)"
    assert per_length in steady.plot()[0].get_title()
    assert per_length in steady.loop("push").plot().get_legend().get_texts()[0].get_text()
    assert per_length in fo.plot_study(study).get_ylabel()
    assert nodal in fo.steady_state(bare, cycle, 0.3, 1.0).plot()[1].get_ylabel()
    assert any(nodal in axes.get_ylabel() for axes in bare.plot())
    assert nodal in steady.states().plot()[0].get_ylabel()
    assert np.array_equal(replace(system, axisymmetric=False).S, system.S)


def test_only_a_contact_in_the_plane_is_axisymmetric():
    with pytest.raises(fo.ModelError, match="axisymmetric: 1; give True or False"):
        replace(CONTACT, axisymmetric=1)
    with pytest.raises(fo.ModelError, match="axisymmetric: True for a contact in space"):
        fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1]}, axisymmetric=True)
