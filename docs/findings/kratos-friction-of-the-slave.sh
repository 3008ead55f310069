#!/usr/bin/env bash
# Kratos ignores the friction coefficient of the contact process if the slave's material has one.
#
# Guess: the coefficient that the contact process is given holds for its pair.
# Seen: `FRICTION_COEFFICIENT` in the material of the slave replaces it, without a warning. The
# coefficient of the process holds only if the materials have none.
# Versions: KratosMultiphysics 10.4.4 with its applications ContactStructuralMechanics,
# StructuralMechanics and LinearSolvers, Python 3.11; 2026-11-27.
# Output: shear over pressing force of a block that slides, for three pairs of coefficients:
# "material 0.1, process 0.3: 0.10", "material none, process 0.1: 0.10",
# "material 0.3, process 0.1: 0.30", then "as described".
. "$(dirname "$0")/common.sh"
packages KratosMultiphysics==10.4.4 \
    KratosContactStructuralMechanicsApplication==10.4.4 \
    KratosStructuralMechanicsApplication==10.4.4 KratosLinearSolversApplication==10.4.4

cat > "$folder/slide.py" <<'PYTHON'
import json
import sys

import KratosMultiphysics as Kratos
from KratosMultiphysics.StructuralMechanicsApplication import structural_mechanics_analysis

material, process = (float(word) for word in sys.argv[1:])


def grid(columns, rows, left, bottom, first):
    nodes = [
        (first + i + j * (columns + 1), left + i / 4, bottom + j / 4, 0)
        for j in range(rows + 1)
        for i in range(columns + 1)
    ]
    corners = [first + i + j * (columns + 1) for j in range(rows) for i in range(columns)]
    return nodes, [(c, c + 1, c + columns + 2, c + columns + 1) for c in corners]


def block(name, words, rows):
    lines = "\n".join(" ".join(map(str, row)) for row in rows)
    return f"Begin {name} {words}\n{lines}\nEnd {name}\n"


upper, cells = grid(4, 4, 0.0, 0.0, 1)
ground, more = grid(6, 1, -0.25, -0.25, 101)
bottom = [node[0] for node in upper if node[2] == 0]
top = [node[0] for node in upper if node[2] == 1]
face = [node[0] for node in ground if node[2] == 0]
text = "Begin Properties 1\nEnd Properties\nBegin Properties 2\nEnd Properties\n"
text += block("Nodes", "", upper + ground)
cells = [(k, 1, *cell) for k, cell in enumerate(cells, 1)]
more = [(k, 2, *cell) for k, cell in enumerate(more, 101)]
text += block("Elements", "SmallDisplacementElement2D4N", cells + more)
for name, nodes, members in (
    ("upper", [node[0] for node in upper], cells),
    ("lower", [node[0] for node in ground], more),
    ("contact", bottom + face, []),
    ("slave", bottom, []),
):
    inside = block("SubModelPartNodes", "", [(node,) for node in nodes])
    inside += block("SubModelPartElements", "", [cell[:1] for cell in members])
    text += f"Begin SubModelPart {name}\n{inside}End SubModelPart\n"
open("mesh.mdpa", "w").write(text)

variables = {"DENSITY": 1.0, "YOUNG_MODULUS": 1.0, "POISSON_RATIO": 0.0, "THICKNESS": 1.0}
if material > 0:
    variables["FRICTION_COEFFICIENT"] = material
law = {"name": "LinearElasticPlaneStrain2DLaw"}
properties = [
    {
        "model_part_name": f"Structure.{name}",
        "properties_id": k,
        "Material": {"constitutive_law": law, "Variables": variables, "Tables": {}},
    }
    for k, name in ((1, "upper"), (2, "lower"))
]
json.dump({"properties": properties}, open("materials.json", "w"))
project = {
    "problem_data": {
        "problem_name": "slide",
        "parallel_type": "OpenMP",
        "echo_level": 0,
        "start_time": 0.0,
        "end_time": 12.5,
    },
    "solver_settings": {
        "solver_type": "Static",
        "model_part_name": "Structure",
        "domain_size": 2,
        "echo_level": 0,
        "model_import_settings": {"input_type": "mdpa", "input_filename": "mesh"},
        "material_import_settings": {"materials_filename": "materials.json"},
        "time_stepping": {"time_step": 1.0},
        "contact_settings": {"mortar_type": "ALMContactFrictional"},
        "convergence_criterion": "contact_residual_criterion",
        "max_iteration": 60,
        "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"},
    },
    "processes": {
        "contact_process_list": [
            {
                "python_module": "alm_contact_process",
                "kratos_module": "KratosMultiphysics.ContactStructuralMechanicsApplication",
                "process_name": "ALMContactProcess",
                "Parameters": {
                    "model_part_name": "Structure",
                    "contact_model_part": {"0": ["contact"]},
                    "assume_master_slave": {"0": ["slave"]},
                    "friction_coefficients": {"0": process},
                    "contact_type": "Frictional",
                },
            }
        ]
    },
    "output_processes": {},
}


class Slide(structural_mechanics_analysis.StructuralMechanicsAnalysis):
    step = 0

    def ApplyBoundaryConditions(self):
        super().ApplyBoundaryConditions()
        sideways = 1e-5 * max(0, self.step - 1)
        self.step += 1
        for nodes, place in (([node[0] for node in ground], (0, 0)), (top, (sideways, -1e-4))):
            for number in nodes:
                node = self.model["Structure"].GetNode(number)
                for axis, value in zip("XY", place):
                    variable = Kratos.KratosGlobals.GetVariable(f"DISPLACEMENT_{axis}")
                    node.Fix(variable)
                    node.SetSolutionStepValue(variable, value)


analysis = Slide(Kratos.Model(), Kratos.Parameters(json.dumps(project)))
analysis.Run()
force = [
    sum(
        analysis.model["Structure"].GetNode(node).GetSolutionStepValue(
            Kratos.KratosGlobals.GetVariable(f"REACTION_{axis}")
        )
        for node in top
    )
    for axis in "XY"
]
named = material if material > 0 else "none"
print(f"\nmaterial {named}, process {process}: {abs(force[0] / force[1]):.2f}")
PYTHON

cd "$folder"
for pair in "0.1 0.3" "0 0.1" "0.3 0.1"; do
    # shellcheck disable=SC2086
    OMP_NUM_THREADS=1 venv/bin/python slide.py $pair 2> said | grep '^material' | tee --append seen
done
cat > expected <<'TEXT'
material 0.1, process 0.3: 0.10
material none, process 0.1: 0.10
material 0.3, process 0.1: 0.30
TEXT
cmp seen expected
echo "as described"
