"""The joints of the tutorial, as gmsh meshes them: a blade, a flange, a bolted lap joint."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo
from helpers.cases import ALL_CASES, few

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial"
STEEL = fo.fem.Material(E=210e3, nu=0.3)


def carried(system, load):
    """Force and moment of the reactions on body 1, in space, contact by contact.

    The moment is about the origin.
    """
    forces = np.einsum("nr,nra->na", np.column_stack(system.bonded[load]), system.frames)
    forces, points = (
        np.pad(part, ((0, 0), (0, 3 - part.shape[1]))) for part in (forces, system.points)
    )
    of = {name: system.contact == name for name in dict.fromkeys(system.contact)}
    moments = np.cross(points, forces)
    return {name: forces[nodes].sum(axis=0) for name, nodes in of.items()}, {
        name: moments[nodes].sum(axis=0) for name, nodes in of.items()
    }


def shakes_down_up_to(limit, system, cycle, friction, share, **options):
    """Transients come to rest below a limit and slip for ever above it.

    They start from the residual slip of the limit.
    """
    for ratio, outcome in ((1 - share, "SHAKEDOWN"), (1 + share, "CYCLIC_SLIP")):
        steady = fo.steady_state(
            system, cycle, friction, ratio * limit.load_factor, initial_slip=limit.slip, **options
        )
        assert steady.outcome.name == outcome
    assert 0 < limit.load_factor <= limit.bound * (1 + 1e-9)
    assert limit.bound == pytest.approx(limit.load_factor, rel=1e-6)


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


def test_the_lap_joint_of_the_tutorial(tmp_path, monkeypatch, capfd):
    mesh = scripted("lap", tmp_path, monkeypatch)
    bodies = fo.fem.split_bodies(mesh, dict.fromkeys(mesh.subdomains, STEEL))
    contacts = [("upper", "lower"), ("bolt", "upper"), ("bolt", "lower")]
    model = fo.fem.ContactModel(
        bodies,
        contacts=[
            fo.fem.Contact(one, two, two, one, name=name)
            for (one, two), name in zip(contacts, ("lap", "head", "nut"), strict=True)
        ],
        supports=[fo.fem.Support("lower", "left")],
        loads={
            "preload": [fo.fem.BoltPreload("bolt", "section", 20e3)],
            "pull": [fo.fem.Traction("upper", "right", x=5.0, y=0.5)],
        },
    )
    system = model.condense()
    cycle = fo.LoadCycle(mean={"preload": 1.0}, corners=[{"pull": 1.0}, {"pull": -1.0}])
    limit = fo.shakedown_limit(system, cycle, friction=0.3)
    assert limit.open.any() and set(system.contact[limit.open]) == {"lap"}
    shakes_down_up_to(limit, system, cycle, 0.3, 0.1, steps=2)
    for friction in few(
        [0.1, 0.3],
        1,
        # bolt and plates may slide together, which opens no gap but for rounding, however far interior
        # points go
    ):
        # These nodes in place of a search, which takes half a minute by the interior point.
        options = {"open_nodes": None if ALL_CASES else limit.open}
        one, other = (
            fo.shakedown_limit(system, cycle, friction, solver=solver, **options)
            for solver in ("INTERIOR_POINT", "CLARABEL_DIRECT")
        )
        assert one.load_factor == pytest.approx(other.load_factor, rel=1e-8)
        assert one.largest_slip < 0.02
    forces, moments = carried(system, "preload")
    for name, sign in (("lap", 1), ("head", 1), ("nut", -1)):
        assert forces[name][2] == pytest.approx(sign * 20e3, rel=1e-6)
    # the bolt balances its head and nut, the upper plate its lap and the head
    for other, sign in (("nut", 1), ("lap", -1)):
        assert np.abs(forces["head"] + sign * forces[other]).max() < 0.02
        assert np.abs(moments["head"] + sign * moments[other]).max() < 0.2
    forces, _ = carried(system, "pull")
    assert np.allclose(forces["lap"] - forces["head"], [-5.0 * 192, -0.5 * 192, 0.0], atol=1e-3)
    fields = model.recover({"preload": 1.0}, np.zeros((system.nodes, 2)))
    u, bolt = fields.displacement["bolt"], fields.bodies["bolt"].mesh
    near, far = (u[:, nodes] for nodes in np.flatnonzero(bolt.p[2] == 0).reshape(2, -1))
    apart = near - far
    assert np.allclose(apart[:2], 0.0, atol=1e-12) and np.allclose(apart[2], apart[2, 0], rtol=1e-9)
    assert apart[2, 0] > 20e3 * 16 / (210e3 * np.pi * 25)
