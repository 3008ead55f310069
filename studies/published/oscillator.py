"""An oscillator of three masses and two wedge faces, whose damping depends on residual tractions.

The range of a search is compared with a range that others sampled.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

import frictopt as fo

from .case import Case, opposed

_FRICTION = 0.9
# Modal force -> sampled values: least and most damping, and least frequency in hertz.
_SAMPLED = {
    200.0: (0.0, 0.0436, 47.01),
    800.0: (0.0286, 0.0381, np.nan),
    1200.0: (0.0210, 0.0274, 42.93),
}


@dataclass(frozen=True)
class Parameters:
    """Parameters of the case."""

    forces: tuple[float, ...] = tuple(_SAMPLED)


def cases(parameters: Parameters) -> Iterator[Case]:
    """All cases of the oscillator."""
    system, stuck = oscillator()
    curve = fo.joints.backbone_curve(
        system,
        opposed({"static": 1.0}, {"mode": 1.0}),
        _FRICTION,
        list(parameters.forces),
        natural_frequency=stuck,
        with_range=True,
    )
    at = [int(np.flatnonzero(curve.load_factor == force)[0]) for force in parameters.forces]
    how = "a search over residual slips; theirs are 25 samples in 100 steps a quarter cycle, right to 1 %"
    found = (
        ("least damping ratio", 0, curve.least_damping, parameters.forces),
        ("most damping ratio", 1, curve.most_damping, parameters.forces),
        (
            "least frequency in Hz",
            2,
            curve.least_frequency,
            [force for force in parameters.forces if np.isfinite(_SAMPLED[force][2])],
        ),
    )
    for quantity, number, ours, forces in found:
        values = [
            float(ours[row])
            for row, force in zip(at, parameters.forces, strict=True)
            if force in forces
        ]

        def theirs(force: float, number: int = number) -> float:
            return _SAMPLED[force][number] if force in _SAMPLED else np.nan

        quantity = f"{quantity} over residual tractions, oscillator of three masses"
        yield Case(
            "Balaji & Ferhatoglu, code nonuniq",
            quantity,
            "modal force",
            how,
            forces,
            theirs,
            values,
            curve.residual,
        )


def oscillator() -> tuple[fo.ContactSystem, float]:
    """The contact with the load of its third mode, and the frequency of this mode without slip.

    The springs are condensed. The model is from the file c1_demobbs.m of the authors. Unknowns are
    x and y of two masses and of the damper between them. The damper rests on both masses by faces
    inclined by 40 degrees, with springs in both directions.
    """
    k, between, damper, spring = 1e5, 3e5, 1e6, 3e5
    J = np.array([[1.0, -1.0], [-1.0, 1.0]])
    K = np.diag([k, k, k, k, 0.0, 0.0])
    for number, stiffness in enumerate((3 * between, between, damper)):
        K[2 * number : 2 * number + 2, 2 * number : 2 * number + 2] += stiffness * J
    M = np.diag([10.0] * 4 + [0.1] * 2)
    c, s = np.cos(np.radians(40)), np.sin(np.radians(40))
    rows = np.vstack(
        [np.kron([-1, 0, 1], [[c, s], [-s, c]]), np.kron([0, -1, 1], [[c, -s], [s, c]])]
    )
    tangents, normals = rows[::2], rows[1::2]
    glued = K + spring * rows.T @ rows
    flexible = np.linalg.inv(glued)
    squares, modes = eigh(glued, M)
    loads = np.column_stack([240.0 * np.eye(6)[5], M @ modes[:, 2]])
    system = fo.ContactSystem.from_blocks(
        spring * np.eye(2) - spring**2 * tangents @ flexible @ tangents.T,
        spring**2 * normals @ flexible @ tangents.T,
        spring * np.eye(2) - spring**2 * normals @ flexible @ normals.T,
        [0.0, 1.0],
        {
            name: (-spring * tangents @ flexible @ load, spring * normals @ flexible @ load)
            for name, load in zip(("static", "mode"), loads.T, strict=True)
        },
        compliance=loads.T @ flexible @ loads,
    )
    return system, float(np.sqrt(squares[2]) / (2 * np.pi))
