"""A bolted lap joint as users mesh it with gmsh."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo

TUTORIAL = Path(__file__).parents[1] / "docs" / "tutorial"
STEEL = fo.Material(E=210e3, nu=0.3)


def carried(system, load):
    """Force and moment about the origin of the reactions on body 1, in space, contact by contact."""
    forces = np.einsum("nr,nra->na", np.column_stack(system.bonded[load]), system.frames)
    forces, points = (np.pad(part, ((0, 0), (0, 3 - part.shape[1]))) for part in (forces, system.points))
    of = {name: system.contact == name for name in dict.fromkeys(system.contact)}
    moments = np.cross(points, forces)
    return {name: forces[own].sum(axis=0) for name, own in of.items()}, {name: moments[own].sum(axis=0) for name, own in of.items()}


def shakes_down_up_to(limit, system, cycle, friction, share, **options):
    """The transient from the residual slip of a limit comes to rest below it, and slips for ever above."""
    for ratio, outcome in ((1 - share, "SHAKEDOWN"), (1 + share, "CYCLIC_SLIP")):
        steady = fo.steady_state(system, cycle, friction, ratio * limit.load_factor, initial_slip=limit.slip, **options)
        assert steady.outcome.name == outcome
    assert 0 < limit.load_factor <= limit.bound * (1 + 1e-9) and limit.bound == pytest.approx(limit.load_factor, rel=1e-6)


def lap(folder, monkeypatch):
    """The joint of the tutorial, from its script."""
    monkeypatch.chdir(folder)
    runpy.run_path(str(TUTORIAL / "lap.py"))
    return fo.read_mesh("lap.msh")


def test_the_lap_joint_of_the_tutorial(tmp_path, monkeypatch, capfd):
    mesh, kept = lap(tmp_path, monkeypatch), fo.read_mesh(TUTORIAL / "lap.msh")
    assert sorted(mesh.subdomains) == sorted(kept.subdomains) and sorted(mesh.boundaries) == sorted(kept.boundaries)
    assert np.allclose([mesh.p.min(axis=1), mesh.p.max(axis=1)], [kept.p.min(axis=1), kept.p.max(axis=1)])
    bodies = fo.split_bodies(mesh, dict.fromkeys(mesh.subdomains, STEEL))
    contacts = [("upper", "lower"), ("bolt", "upper"), ("bolt", "lower")]
    model = fo.ContactModel(
        bodies,
        contacts=[fo.Contact(one, two, two, one, name=name) for (one, two), name in zip(contacts, ("lap", "head", "nut"), strict=True)],
        supports=[fo.Support("lower", "left")],
        loads={"preload": [fo.BoltPreload("bolt", "section", 20e3)], "pull": [fo.Traction("upper", "right", x=5.0, y=0.5)]},
    )
    system = model.condense()
    cycle = fo.LoadCycle(mean={"preload": 1.0}, corners=[{"pull": 1.0}, {"pull": -1.0}])
    limit = fo.shakedown_limit(system, cycle, friction=0.3)
    assert limit.open.any() and set(system.contact[limit.open]) == {"lap"}
    shakes_down_up_to(limit, system, cycle, 0.3, 0.1, steps=4)
    for friction in (0.1, 0.3):  # bolt and plates may slide together, which opens no gap but for rounding, however far interior points go
        one, other = (fo.shakedown_limit(system, cycle, friction, solver=solver) for solver in ("INTERIOR_POINT", "CLARABEL_DIRECT"))
        assert one.load_factor == pytest.approx(other.load_factor, rel=1e-8) and one.largest_slip < 0.01
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
