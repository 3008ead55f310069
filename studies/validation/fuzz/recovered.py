"""The fields that `ContactModel.recover` gives for a state with an initial gap, against scikit-fem's own elasticity."""

import warnings
from dataclasses import replace

import numpy as np
from skfem.models.elasticity import linear_elasticity

import frictopt as fo

from .known import Known, NotAsked, Wrong

_SAME = 1e-8


def recovered(known: Known) -> tuple[float, bool]:
    """Two bodies with a random gap, after a cycle: their displacements must part by slip and gap, and need the reactions of the state to do so."""
    if known.case.seed % 8:
        raise NotAsked
    rng = np.random.default_rng([known.case.seed, 7])
    elements, materials = 2 * int(rng.integers(1, 5)), [fo.Material(10.0 ** rng.uniform(-2, 2), rng.uniform(0.0, 0.45)) for _ in "12"]
    scene = fo.scenes.PunchOnHalfPlane(elements=elements, grading=1.0, growth=2.0, punch_material=materials[0], block_material=materials[1])
    flat, x = scene.model(), np.linspace(-1, 1, elements + 1)
    whole = flat.condense()
    gap = rng.uniform(0, 1, len(x)) * (rng.random(len(x)) < 0.6) * np.abs(whole.bonded["P"][1]).mean() / whole.stiffness_scale
    model = replace(flat, contacts=[replace(flat.contacts[0], gap=lambda at, _: np.interp(at, x, gap))])
    system, shear = model.condense(), float(rng.uniform(-0.2, 0.2))
    path = fo.march(system, fo.LoadCycle({"P": 1.0}, [{"Q": shear}, {"Q": -shear}]), float(rng.uniform(0.4, 0.6)), 1.0, cycles=1)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        fields = model.recover({"P": 1.0, "Q": -shear}, path.slip[-1], path.gap[-1])
    moved, force = {}, np.abs(path.p[-1]).max()
    for body, part in model.bodies.items():
        basis, u = fields.vector(body)
        nodes = np.intersect1d(np.flatnonzero(part.mesh.p[1] == 0), np.unique(part.mesh.facets[:, part.mesh.boundaries["contact"]]))
        nodes = nodes[np.argsort(part.mesh.p[0, nodes])]
        forces, moved[body] = (
            (linear_elasticity(*part.material.lame).assemble(basis) @ u)[basis.nodal_dofs[:, nodes]],
            fields.displacement[body][:, nodes],
        )
        sense = 1.0 if body == "punch" else -1.0
        error = np.abs(sense * forces - [path.q[-1], path.p[-1]]).max() / force
        if not error <= _SAME:
            raise Wrong(f"the reactions of the displacements of the {body} are off by {error:.1e}")
    parted = moved["punch"] - moved["block"] - [path.slip[-1], path.gap[-1] - gap]
    if not np.abs(parted).max() <= _SAME * force / system.stiffness_scale:
        raise Wrong(f"the bodies part by {np.abs(parted).max():.1e} more than slip and gap")
    if told:
        raise Wrong(f"a state of the contact is warned of: {told[0].message}")
    return path.residual, True
