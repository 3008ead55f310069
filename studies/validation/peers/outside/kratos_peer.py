"""The block of `plane` by Kratos, run by a Python that has Kratos.

This Python need not have frictopt. The program reads one question as JSON and writes the answer as
JSON, see `programs`. The block stands on a wider block whose nodes are all held. Both sides of the
upper block carry the shear of the closed form, so that stress is uniform.
"""

import json
import os
import sys
import tempfile
import time
from typing import Any

import KratosMultiphysics as Kratos
from KratosMultiphysics.StructuralMechanicsApplication import structural_mechanics_analysis

ELEMENT = "SmallDisplacementElement2D4N"


def grid(
    columns: int, rows: int, left: float, bottom: float, size: float, first: int
) -> tuple[list[Any], list[Any]]:
    """Nodes (number, x, y) of a grid of squares, and its elements as four numbers of nodes."""
    nodes = [
        (first + i + j * (columns + 1), left + i * size, bottom + j * size)
        for j in range(rows + 1)
        for i in range(columns + 1)
    ]
    elements = []
    for j in range(rows):
        for i in range(columns):
            corner = first + i + j * (columns + 1)
            elements.append((corner, corner + 1, corner + columns + 2, corner + columns + 1))
    return nodes, elements


def block(name: str, words: str, rows: list[Any]) -> str:
    """A block of Kratos' format of meshes."""
    lines = "\n".join(" ".join(map(str, row)) for row in rows)
    return f"Begin {name} {words}\n{lines}\nEnd {name}\n"


class Mesh:
    """Both blocks, the sides of the upper block, and both faces of the contact."""

    def __init__(self, elements: int) -> None:
        n = elements
        self.size = 1.0 / n
        # Number of elements by which the ground is wider on each side.
        beside = max(1, n // 4)
        up, up_elements = grid(n, n, 0.0, 0.0, self.size, 1)
        ground, ground_elements = grid(
            n + 2 * beside, 1, -beside * self.size, -self.size, self.size, len(up) + 1
        )
        self.bottom = [node for node, _, y in up if y < 1e-9]
        self.top = [node for node, _, y in up if y > 1 - 1e-9]
        self.left = [node for node, x, _ in up if x < 1e-9]
        self.right = [node for node, x, _ in up if x > 1 - 1e-9]
        self.held = [node for node, _, _ in ground]
        face = [node for node, _, y in ground if y > -1e-9]
        cells = [(k, 1, *e) for k, e in enumerate(up_elements, 1)]
        more = [(k, 2, *e) for k, e in enumerate(ground_elements, len(cells) + 1)]
        loads = [(k, 1, node) for k, node in enumerate(self.left + self.right, 1)]
        parts = {
            "upper": ([node for node, _, _ in up], [cell[0] for cell in cells]),
            "lower": (self.held, [cell[0] for cell in more]),
            "contact": (self.bottom + face, []),
            "slave": (self.bottom, []),
        }
        text = "Begin Properties 1\nEnd Properties\nBegin Properties 2\nEnd Properties\n"
        text += block("Nodes", "", [(k, x, y, 0.0) for k, x, y in up + ground])
        text += block("Elements", ELEMENT, cells + more)
        text += block("Conditions", "PointLoadCondition2D1N", loads)
        for name, (nodes, members) in parts.items():
            inside = block("SubModelPartNodes", "", [(node,) for node in nodes])
            inside += block("SubModelPartElements", "", [(member,) for member in members])
            text += f"Begin SubModelPart {name}\n{inside}End SubModelPart\n"
        self.text = text


def materials(asked: dict[str, Any]) -> dict[str, Any]:
    """The materials of both blocks, with the friction of the pair."""
    variables = {
        "DENSITY": 1.0,
        "YOUNG_MODULUS": 2.0 * asked["shear_modulus"],
        "POISSON_RATIO": 0.0,
        "THICKNESS": 1.0,
        "FRICTION_COEFFICIENT": asked["friction"],
    }
    law = {"name": "LinearElasticPlaneStrain2DLaw"}
    material = {"constitutive_law": law, "Variables": variables, "Tables": {}}
    return {
        "properties": [
            {"model_part_name": f"Structure.{name}", "properties_id": k, "Material": material}
            for k, name in ((1, "upper"), (2, "lower"))
        ]
    }


def settings(asked: dict[str, Any]) -> dict[str, Any]:
    """The project of Kratos: a static analysis with frictional mortar contact."""
    contact = {
        "python_module": "alm_contact_process",
        "kratos_module": "KratosMultiphysics.ContactStructuralMechanicsApplication",
        "process_name": "ALMContactProcess",
        "Parameters": {
            "model_part_name": "Structure",
            "contact_model_part": {"0": ["contact"]},
            "assume_master_slave": {"0": ["slave"]},
            "friction_coefficients": {"0": asked["process_friction"]},
            "contact_type": "Frictional",
        },
    }
    tolerance = asked["tolerance"]
    names = ("displacement", "residual")
    solver: dict[str, Any] = {
        "solver_type": "Static",
        "model_part_name": "Structure",
        "domain_size": 2,
        "echo_level": 0,
        "analysis_type": "non_linear",
        "model_import_settings": {"input_type": "mdpa", "input_filename": "mesh"},
        "material_import_settings": {"materials_filename": "materials.json"},
        "time_stepping": {"time_step": 1.0},
        "contact_settings": {"mortar_type": "ALMContactFrictional"},
        "convergence_criterion": "contact_residual_criterion",
        "max_iteration": 60,
        "reform_dofs_at_each_step": True,
        "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
    }
    for name in names:
        solver[f"{name}_relative_tolerance"] = tolerance
        solver[f"{name}_absolute_tolerance"] = tolerance
        for group in ("contact", "frictional_stick_contact", "frictional_slip_contact"):
            solver["contact_settings"][f"{group}_{name}_relative_tolerance"] = tolerance
            solver["contact_settings"][f"{group}_{name}_absolute_tolerance"] = tolerance
    data = {
        "problem_name": "slider",
        "parallel_type": "OpenMP",
        "echo_level": 0,
        "start_time": 0.0,
        "end_time": len(asked["steps"]) - 0.5,
    }
    return {
        "problem_data": data,
        "solver_settings": solver,
        "processes": {"contact_process_list": [contact]},
        "output_processes": {},
    }


class Analysis(structural_mechanics_analysis.StructuralMechanicsAnalysis):  # type: ignore[misc]
    """The analysis with the supports and loads of each step."""

    def __init__(self, model: Any, project: Any, asked: dict[str, Any], mesh: Mesh) -> None:
        super().__init__(model, project)
        self.asked, self.mesh = asked, mesh
        self.shears: list[float] = []

    def RunSolutionLoop(self) -> None:
        """Solve all steps, and count the steps that do not converge; Kratos continues after them."""
        self.failed = 0
        while self.KeepAdvancingSolutionLoop():
            self.time = self._AdvanceTime()
            self.InitializeSolutionStep()
            self._GetSolver().Predict()
            self.failed += not self._GetSolver().SolveSolutionStep()
            self.FinalizeSolutionStep()
            self.OutputSolutionStep()

    def _part(self) -> Any:
        return self.model["Structure"]

    def ApplyBoundaryConditions(self) -> None:
        """Hold the nodes of the ground, move the top, and load the sides."""
        super().ApplyBoundaryConditions()
        part = self._part()
        x, side = self.asked["steps"][len(self.shears)]
        for nodes, place in (
            (self.mesh.held, (0.0, 0.0)),
            (self.mesh.top, (x, -self.asked["down"])),
        ):
            for number in nodes:
                node = part.GetNode(number)
                for name, value in zip(("DISPLACEMENT_X", "DISPLACEMENT_Y"), place, strict=True):
                    variable = Kratos.KratosGlobals.GetVariable(name)
                    node.Fix(variable)
                    node.SetSolutionStepValue(variable, value)
        load = Kratos.KratosGlobals.GetVariable("POINT_LOAD_Y")
        for nodes, sign in ((self.mesh.left, -1.0), (self.mesh.right, 1.0)):
            for rank, number in enumerate(nodes):
                share = 0.5 if rank in (0, len(nodes) - 1) else 1.0
                force = sign * side * self.mesh.size * share
                part.GetNode(number).SetSolutionStepValue(load, force)

    def FinalizeSolutionStep(self) -> None:
        """Note the shear force."""
        super().FinalizeSolutionStep()
        reaction = Kratos.KratosGlobals.GetVariable("REACTION_X")
        part = self._part()
        forces = [part.GetNode(node).GetSolutionStepValue(reaction) for node in self.mesh.top]
        self.shears.append(-sum(forces))


def shears(asked: dict[str, Any]) -> list[float]:
    """The force on the ground after each step."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        mesh = Mesh(asked["elements"])
        with open("mesh.mdpa", "w", encoding="utf-8") as file:
            file.write(mesh.text)
        with open("materials.json", "w", encoding="utf-8") as file:
            json.dump(materials(asked), file)
        project = Kratos.Parameters(json.dumps(settings(asked)))
        analysis = Analysis(Kratos.Model(), project, asked, mesh)
        analysis.Run()
        os.chdir("/")
        if analysis.failed:
            raise SystemExit(f"{analysis.failed} of {len(asked['steps'])} steps do not converge")
        return analysis.shears


if __name__ == "__main__":
    asked = json.load(sys.stdin)
    started = time.process_time()
    answer = {"shears": shears(asked), "seconds": time.process_time() - started}
    print(json.dumps(answer))
