"""The block of `plane` by GetFEM, run by a Python that has GetFEM.

This Python need not have frictopt. The program reads one question as JSON and writes the answer as
JSON, see `programs`. The block stands on rigid ground. Both sides carry the shear of the closed
form, so that stress is uniform.
"""

import json
import sys
import time
from typing import Any

import getfem
import numpy as np


class Block:
    """The model: contact is `add_integral_contact_with_rigid_obstacle_brick` with friction.

    GetFEM counts slip from the mesh, unless the last displacement is given as `wt`.
    """

    def __init__(self, asked: dict[str, Any]) -> None:
        self.asked = asked
        along = np.linspace(0.0, 1.0, asked["elements"] + 1)
        mesh = getfem.Mesh("cartesian", along, along)
        vectors, scalars = getfem.MeshFem(mesh, 2), getfem.MeshFem(mesh, 1)
        for fem in (vectors, scalars):
            fem.set_fem(getfem.Fem("FEM_QK(2,1)"))
        rule = getfem.MeshIm(mesh, getfem.Integ("IM_GAUSS_PARALLELEPIPED(2,4)"))
        faces = mesh.outer_faces()
        normals = np.array([mesh.normal_of_face(*face) for face in faces.T])
        ground, top, right, left = 1, 2, 3, 4
        mesh.set_region(ground, faces[:, normals[:, 1] < -0.5])
        mesh.set_region(top, faces[:, normals[:, 1] > 0.5])
        mesh.set_region(right, faces[:, normals[:, 0] > 0.5])
        mesh.set_region(left, faces[:, normals[:, 0] < -0.5])

        model = getfem.Model("real")
        model.add_fem_variable("u", vectors)
        model.add_initialized_data("lambda_", [0.0])
        model.add_initialized_data("mu", [asked["shear_modulus"]])
        model.add_isotropic_linearized_elasticity_brick(rule, "u", "lambda_", "mu")
        for name in ("moved", "upward", "downward"):
            model.add_initialized_data(name, [0.0, 0.0])
        model.add_Dirichlet_condition_with_multipliers(rule, "u", vectors, top, "moved")
        model.add_source_term_brick(rule, "u", "upward", right)
        model.add_source_term_brick(rule, "u", "downward", left)
        model.add_initialized_fem_data("distance", scalars, scalars.basic_dof_nodes()[1])
        model.add_filtered_fem_variable("traction", vectors, ground)
        model.add_initialized_data("r", [asked["augmentation"]])
        model.add_initialized_data("friction", [asked["friction"]])
        contact = [rule, "u", "traction", "distance", "r", "friction", ground, 1]
        if asked["history"]:
            model.add_initialized_data("alpha", [1.0])
            model.add_initialized_fem_data("last", vectors, np.zeros(vectors.nbdof()))
            contact += ["alpha", "last"]
        model.add_integral_contact_with_rigid_obstacle_brick(*contact)
        self.model, self.rule, self.ground = model, rule, ground
        self.kept = [mesh, vectors, scalars]

    def force(self, top: list[float], side: float) -> float:
        """Shear force at the ground with the top moved by (x, y) and this shear on the sides."""
        model = self.model
        model.set_variable("moved", top)
        model.set_variable("upward", [0.0, side])
        model.set_variable("downward", [0.0, -side])
        model.solve("max_res", self.asked["tolerance"], "max_iter", 100)
        if self.asked["history"]:
            model.set_variable("last", model.variable("u"))
        return float(getfem.asm("generic", self.rule, 0, "traction(1)", self.ground, model))


def shears(asked: dict[str, Any]) -> list[float]:
    """The force after each step."""
    block = Block(asked)
    return [block.force([x, -asked["down"]], side) for x, side in asked["steps"]]


if __name__ == "__main__":
    asked = json.load(sys.stdin)
    getfem.util_trace_level(0)
    getfem.util_warning_level(0)
    started = time.process_time()
    answer = {"shears": shears(asked), "seconds": time.process_time() - started}
    print(json.dumps(answer))
