"""The joints of the tutorial, as gmsh meshes them: a blade and a flange."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial"


def scripted(name, folder, monkeypatch):
    """A mesh of the tutorial from its script.

    The script has the bodies and boundaries of the file beside it.
    """
    monkeypatch.chdir(folder)
    runpy.run_path(str(TUTORIAL / f"{name}.py"))
    mesh, kept = fo.readers.read_mesh(f"{name}.msh"), fo.readers.read_mesh(TUTORIAL / f"{name}.msh")
    assert sorted(mesh.subdomains) == sorted(kept.subdomains)
    assert sorted(mesh.boundaries) == sorted(kept.boundaries)
    assert np.allclose(
        [mesh.p.min(axis=1), mesh.p.max(axis=1)], [kept.p.min(axis=1), kept.p.max(axis=1)]
    )
    return mesh


def test_the_blade_of_the_tutorial(tmp_path, monkeypatch, capfd):
    """The blade of the tutorial has the same damping from the script as from the file.

    At the amplitude whole flanks slip. A mesh that is twice as fine has as much damping: it settles
    with the mesh.
    """
    script = (TUTORIAL / "blade.py").read_text()
    (tmp_path / "fine.py").write_text(
        script.replace('"SizeMin": 0.5', '"SizeMin": 0.25').replace("blade.msh", "fine.msh")
    )
    meshes = [
        scripted("blade", tmp_path, monkeypatch),
        fo.readers.read_mesh(TUTORIAL / "blade.msh"),
    ]
    runpy.run_path(str(tmp_path / "fine.py"))
    found = []
    titanium = fo.fem.Material(E=115e3, nu=0.33, density=4.4e-9)
    for mesh in (*meshes, fo.readers.read_mesh("fine.msh")):
        bodies = fo.fem.split_bodies(
            mesh, dict.fromkeys(("blade", "disc"), titanium), element="quadratic"
        )
        model = fo.fem.ContactModel(
            bodies,
            contacts=[
                fo.fem.Contact("blade", "disc", flank, flank, name=flank)
                for flank in ("R1", "L1", "R2", "L2")
            ],
            supports=[
                fo.fem.Support("disc", "bottom"),
                fo.fem.Support("disc", "left", "x"),
                fo.fem.Support("disc", "right", "x"),
            ],
            loads={
                "spin": [
                    fo.fem.Centrifugal(name, titanium.density, speed=300.0, centre=(0.0, -300.0))
                    for name in bodies
                ]
            },
        )
        modes = model.modes(1)
        system = model.with_loads({"mode": modes.load(0)}).condense()
        omega = 2 * np.pi * modes.frequency[0]
        factors = np.array([0.4, 0.7, 1.1]) / np.abs(modes.shapes["blade"][0]).max() * omega**2
        cycle = fo.LoadCycle(mean={"spin": 1.0}, corners=[{"mode": 1.0}, {"mode": -1.0}])
        curve = fo.joints.backbone_curve(
            system, cycle, 0.3, factors, natural_frequency=modes.frequency[0]
        )
        assert modes.frequency[0] > curve.frequency[0] > curve.frequency[1] > curve.frequency[2]
        found.append(curve.damping)
    assert found[0] == pytest.approx(found[1], rel=1e-2)
    assert found[2][1:] == pytest.approx(found[1][1:], rel=5e-3)


def test_the_flange_of_the_tutorial(tmp_path, monkeypatch, capfd):
    """The nodes on both cuts of the quarter from the script match, as those of the file do."""
    mesh, steel = scripted("flange", tmp_path, monkeypatch), fo.fem.Material()
    for each in (mesh, fo.readers.read_mesh(TUTORIAL / "flange.msh")):
        body = fo.fem.split_bodies(each, dict.fromkeys(("upper", "lower", "bolt"), steel))["lower"]
        low, high = (body.boundary_nodes(name, "cut") for name in ("low", "high"))
        turned = body.mesh.p[:, low][[1, 0, 2]] * [[-1], [1], [1]]
        apart = np.linalg.norm(turned[:, :, None] - body.mesh.p[:, None, high], axis=0)
        assert len(low) == len(high) > 20 and apart.min(axis=0).max() < 1e-8
