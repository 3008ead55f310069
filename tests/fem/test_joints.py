"""The scripts of the tutorial make the meshes of the files beside them, by gmsh."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial"


@pytest.mark.parametrize("name", ["blade", "flange", "lap"])
def test_a_script_has_the_bodies_and_boundaries_of_the_file(name, tmp_path, monkeypatch, capfd):
    """The nodes on both cuts of the quarter of the flange match, as those of the file do."""
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(TUTORIAL / f"{name}.py"))
    mesh, kept = fo.readers.read_mesh(f"{name}.msh"), fo.readers.read_mesh(TUTORIAL / f"{name}.msh")
    assert sorted(mesh.subdomains) == sorted(kept.subdomains)
    assert sorted(mesh.boundaries) == sorted(kept.boundaries)
    assert np.allclose(
        [mesh.p.min(axis=1), mesh.p.max(axis=1)], [kept.p.min(axis=1), kept.p.max(axis=1)]
    )
    for each in (mesh, kept) if name == "flange" else ():
        bodies = fo.fem.split_bodies(each, dict.fromkeys(each.subdomains, fo.fem.Material()))
        low, high = (bodies["lower"].boundary_nodes(side, "cut") for side in ("low", "high"))
        points = bodies["lower"].mesh.p
        turned = points[:, low][[1, 0, 2]] * [[-1], [1], [1]]
        apart = np.linalg.norm(turned[:, :, None] - points[:, None, high], axis=0)
        assert len(low) == len(high) > 20 and apart.min(axis=0).max() < 1e-8
