"""Joint files: TOML beside a deck or a mesh."""

import json
import re
import shutil
from pathlib import Path

import meshio
import numpy as np
import pytest
from scipy import stats

import frictopt as fo
from helpers.command import main

LOGNORM = 'distribution = "lognorm", s = 0.2, scale = 0.2'
DATA = Path(__file__).parents[1] / "data"
PAGE = (Path(__file__).parents[2] / "docs" / "command.md").read_text(encoding="utf-8")
BESIDE_DECK, BESIDE_MESH = re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A deck, and a mesh of a punch of 20 x 10 on a block, which share nodes."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "block.inp", tmp_path)
    points = [(x, y, 0.0) for y in (0.0, 10.0, 20.0) for x in (0.0, 10.0, 20.0)]
    quads = np.array(
        [[i + 3 * j, i + 1 + 3 * j, i + 4 + 3 * j, i + 3 + 3 * j] for j in (0, 1) for i in (0, 1)]
    )
    lines = np.array([[0, 1], [1, 2], [6, 7], [7, 8]])
    meshio.write(
        "two.msh",
        meshio.Mesh(
            points,
            [("quad", quads), ("line", lines)],
            cell_data={
                name: [np.array([1, 1, 2, 2]), np.array([3, 3, 4, 4])]
                for name in ("gmsh:physical", "gmsh:geometrical")
            },
            field_data={
                "block": np.array([1, 2]),
                "punch": np.array([2, 2]),
                "bottom": np.array([3, 1]),
                "top": np.array([4, 1]),
            },
        ),
        file_format="gmsh22",
        binary=False,
    )


def read(text):
    Path("joint.toml").write_text(text)
    return fo.read_joint("joint.toml")


def test_a_file_adds_to_a_deck_its_cycle_scatter_and_thresholds(capsys):
    """f = 0.1 and 0.9 of the pressure: 0.1 x 3600 / 600, a third of the nominal."""
    joint = read(BESIDE_DECK.replace("title", "Title").replace("[preload]", "[Preload]"))
    assert joint.of_report.keys() == {"title", "preload", "limits"}
    assert joint.cycle().corners == ({"CLOAD NLEFT": 1.0}, {"CLOAD NLEFT": -1.0})
    assert joint.friction == {"SPUNCH-SBLOCK": (0.1, 0.2, 0.3)}
    assert main(["report", "joint.toml", "--pages", "2", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["answer"]
    assert told["title"] == "Punch 7" and told["scatter"].startswith("friction of 0.1 to 0.3")
    sheet = fo.report(joint.system(), joint.cycle(), joint.friction, pages=2, **joint.of_report)
    (row,) = sheet.safety.to_dict("records")
    assert (row["nominal"], row["worst"]) == pytest.approx((4 / 3, 0.6), rel=1e-6)
    assert not sheet.verdicts["passed"].any()
    words = ["--mean", "STEP 1", "--corners", "CLOAD NLEFT=2", "STEP 1", "--friction", ".2"]
    assert main(["gross-slip", "joint.toml", *words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["answer"]["load_factor"] == pytest.approx(2 / 3, rel=1e-6)
    assert found["question"]["units"] == "N, mm"


def test_a_file_has_distributions_as_a_call_of_python_has_them(capsys):
    """The same numbers come from the distributions of scipy; preloads and bolts take the median."""
    text = BESIDE_DECK.replace("DRY = [0.1, 0.2, 0.3]", f"DRY = {{ {LOGNORM} }}").replace(
        '"DLOAD ETOP P3" = [0.9, 1.1]',
        '"DLOAD ETOP P3" = { distribution = "norm", loc = 1.0, scale = 0.05 }',
    )
    load = (
        'load = { distribution = "uniform", loc = 0.8, scale = 0.4 }\ncorrelation_length = 50.0\n'
    )
    joint = read(load + text)
    assert joint.cycle().corners == ({"CLOAD NLEFT": 1.0}, {"CLOAD NLEFT": -1.0})
    assert main(["report", "joint.toml", "--pages", "2", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["question"]["friction"]["SPUNCH-SBLOCK"]["distribution"] == "lognorm"
    laws = {
        "friction": {"SPUNCH-SBLOCK": stats.lognorm(0.2, scale=0.2)},
        "preload": {"DLOAD ETOP P3": stats.norm(1.0, 0.05)},
        "load": stats.uniform(0.8, 0.4),
        "correlation_length": 50.0,
    }
    sheet = fo.report(joint.system(), joint.cycle(), **laws, pages=2, limits={"gross slip": 1.3})
    assert told["answer"]["scatter"] == sheet.scatter
    assert told["answer"]["gross-slip_load"] == sheet.gross_slip.load_factor


@pytest.mark.parametrize(
    ("load", "message"),
    [
        ('{ distribution = "nothing" }', "load: distribution 'nothing'"),
        ("{ loc = 1.0 }", "load: distribution None"),
        ('{ distribution = "norm", name = 1.0 }', "load: .*parameters of `scipy.stats`"),
        ('{ distribution = "norm", loc = "one" }', "load: "),
        ('{ distribution = "norm", scale = -1.0 }', "load: .*frozen distribution"),
    ],
)
def test_odd_distributions_are_refused_by_name(load, message):
    with pytest.raises(fo.ModelError, match=message):
        read(f"load = {load}\n{BESIDE_DECK}")


def test_a_file_describes_a_joint_beside_a_mesh(capsys):
    """10 x 20 x 20 = 4000 N, 3 x 20 x 20 / 2 = 600 N: 0.2 x 4000 / 600."""
    joint = read(BESIDE_MESH.replace("friction", "Friction"))
    system = joint.system()
    assert system.width.sum() == pytest.approx(400) and system.thickness == 20
    assert system.reaction({"P": 1.0})[1].sum() == pytest.approx(4000)
    found = fo.gross_slip(system, joint.cycle(), joint.friction)
    assert found.load_factor == pytest.approx(4 / 3, rel=1e-6)
    assert main(["look", "joint.toml"]) == 0
    assert "punch: E=210000" in capsys.readouterr().out


def test_harmonic_loads_run_along_an_ellipse():
    text = BESIDE_MESH.replace(
        "corners = [{ Q = 0.5 }, { Q = -0.5 }]",
        "harmonic = { Q = 0.5, P = [0.1, 90.0] }\npoints = 8",
    )
    cycle = fo.LoadCycle.harmonic({"Q": 0.5, "P": (0.1, 90.0)}, mean={"P": 1.0}, points=8)
    found = read(text).cycle().corners
    zero = {"P": 0.0, "Q": 0.0}
    assert [zero | dict(corner) for corner in found] == [dict(corner) for corner in cycle.corners]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("title", "titel", r"entry 'titel' is unknown; give one of \['title'"),
        ('title = "Punch 7"', "title = 7", "title = 7; give a str"),
        ("title", 'Title = "A"\ntitle', "entry 'title' is given twice"),
        ('deck = "block.inp"', "", r"entry 'preload'|neither deck nor mesh"),
        ("[cycle]\nmean", "[cycle]\nmeans", r"cycle: entry 'means' is unknown; .*'mean'"),
        ("DRY", "WET", r"friction of 'WET' is unknown; give one of"),
        ('"STEP 1"', '"STEP 9"', "state 'STEP 9' is unknown"),
        ("CLOAD NLEFT", "CLOAD NRIGHT", "load case 'CLOAD NRIGHT' is unknown; .*'CLOAD NLEFT'"),
        ("units =", "units", "give a file in TOML"),
        ("block.inp", "none.inp", "none.inp"),
    ],
)
def test_unknown_names_beside_a_deck_are_refused_with_the_nearest(old, new, message):
    with pytest.raises(fo.ModelError, match=message):
        read(BESIDE_DECK.replace(old, new, 1)).cycle()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("amount", "amounts", r"loads.P: Pressure 'amounts' is unknown; give one of \['amount'"),
        ("Pressure", "Presure", r"loads.P 'Presure' is unknown; give one of \['Pressure'"),
        ('"steel" }', '"stell" }', r"bodies.block: material 'stell' is unknown"),
        ("boundary_1", "face_1", "contacts 'face_1' is unknown"),
        ("nu = 0.3", "nu = 0.7", "materials.steel: nu"),
        ("[{ Traction = ", "[{ Traction = 3, x = ", r"loads.Q: \{.*give the table of a load"),
        (', where = "bottom"', "", r"supports: .*where.*; give a table of body, where"),
        ('{ punch = "steel", block = "steel" }', "3", "bodies = 3; give a dict"),
        ("materials.steel = { E = 210e3, nu = 0.3 }\n", "", "materials missing"),
        ("mean = { P", "mean = { p = 1.0, R", "load case 'R' is unknown"),
        ("mean = { P = 1.0 }\n", "", "mean, corners: give both"),
    ],
)
def test_unknown_names_beside_a_mesh_are_refused_with_the_nearest(old, new, message):
    with pytest.raises(fo.ModelError, match=message):
        read(BESIDE_MESH.replace(old, new, 1)).cycle()


COLUMN = """mesh = "column.msh"
kinematics = "plane_stress"
materials.steel = { E = 210e3, nu = 0.3 }
bodies = { one = "steel", two = "steel", three = "steel" }
contacts = [{ body_1 = "two", body_2 = "one", boundary_1 = "one", boundary_2 = "two", adjust = 0.1 }]
ties = [{ body_1 = "three", body_2 = "two", boundary_1 = "two", boundary_2 = "three" }]
supports = [{ body = "one", where = "bottom" }]
loads.P = [{ Pressure = { body = "three", boundary = "top", amount = 10.0 } }]
"""


def test_ties_and_position_tolerances_beside_a_mesh():
    """Three blocks in a column, of which the upper two are tied: 10 x 2 in the contact."""
    points = [(x, y, 0.0) for y in (0.0, 1.0, 2.0, 3.0) for x in (0.0, 2.0)]
    meshio.write(
        "column.msh",
        meshio.Mesh(
            points,
            [
                ("quad", np.array([[0, 1, 3, 2], [2, 3, 5, 4], [4, 5, 7, 6]])),
                ("line", np.array([[0, 1], [6, 7]])),
            ],
            cell_data={
                name: [np.array([1, 2, 3]), np.array([4, 5])]
                for name in ("gmsh:physical", "gmsh:geometrical")
            },
            field_data={
                name: np.array([n, 2 if n < 4 else 1])
                for n, name in enumerate(("one", "two", "three", "bottom", "top"), start=1)
            },
        ),
        file_format="gmsh22",
        binary=False,
    )
    joint = read(COLUMN)
    assert joint.system().reaction({"P": 1.0})[1].sum() == pytest.approx(20)
    assert joint.model.contacts[0].adjust == 0.1
    with pytest.raises(fo.ModelError, match=r"ties 'body' is unknown; give one of .*'body_1'"):
        read(COLUMN.replace("ties = [{ body_1", "ties = [{ body"))
