"""What the closed forms refuse, by name and with what to give instead."""

import numpy as np
import pytest

import frictopt as fo
from frictopt import reference

CYLINDER = {"P": 1.0, "R": 1.0, "E_star": 1.0, "f": 0.5}
NODE = {"A": 2.0, "B": 0.5, "q0": 0.1, "p0": 1.0, "q1": 1.0, "p1": 0.2, "f": 0.4}
ABOVE = NODE | {"load_factor": 0.5}
THREE = {
    "q0": (0.05, 0, -0.1),
    "p0": (1, 0.8, 1.2),
    "q1": (0.5, 0.3, -0.2),
    "p1": (0.1, -0.2, 0.9),
    "f": 0.4,
}
CASES = [
    (
        reference.single_node_limit,
        NODE | {"f": 4.0},
        r"f: 4 .*critical friction A/\|B\| = 4.*less friction",
    ),
    (reference.single_node_limit, NODE | {"f": 0.0}, "f: 0"),
    (reference.single_node_limit, NODE | {"A": -1.0}, "A: -1"),
    (
        reference.uncoupled_limit,
        THREE | {"d": [0.0, 2.5, 0.0]},
        "f: 0.4 at node 1 .*critical friction",
    ),
    (
        reference.uncoupled_limit,
        THREE | {"q1": [1.0, 2.0]},
        r"q1: shape \(2,\); give one number, or one for each of 3 nodes",
    ),
    (reference.uncoupled_limit, THREE | {"p0": []}, r"p0: shape \(0,\)"),
    (reference.uncoupled_limit, THREE | {"f": -0.1}, "f: -0.1; give a positive"),
    (
        reference.single_node_dissipation,
        ABOVE | {"f": 4.0},
        r"f: 4 .*critical friction A/\|B\| = 4.*less friction",
    ),
    (reference.single_node_dissipation, ABOVE | {"load_factor": -0.1}, "load_factor: -0.1"),
    (
        reference.single_node_dissipation,
        ABOVE | {"p0": -1.0},
        "p0: -1; the mean load lifts the node off; give more pressure",
    ),
    (
        reference.masing_dissipation,
        {"k": [1, 0], "bound": 1, "X": 1},
        "k: 0 at node 1; give positive stiffnesses",
    ),
    (
        reference.masing_dissipation,
        {"k": [1, 2], "bound": [0.1, -0.2], "X": 1},
        "bound: -0.2 at node 1; give friction bounds of at least 0",
    ),
    (reference.rod_dissipation, {"F0": -1, "EA": 1, "tau": 1, "h": 1}, "F0: -1"),
    (reference.foundation_rod, {"nodes": 0, "EA": 1, "h": 1}, "nodes: 0"),
    (reference.LineContact, CYLINDER | {"P": 0}, "P: 0"),
    (
        reference.LineContact(**CYLINDER).dissipation,
        {"Q0": 0.5},
        "Q0: 0.5; the body slides, give a shear force below f P = 0.5",
    ),
    (reference.LineContact(**CYLINDER).stick_half_width, {"Q": -0.6}, "Q: -0.6; the body slides"),
    (
        reference.contact_modulus,
        {"E1": 1, "nu1": 0.3, "E2": 1, "nu2": 0.6},
        "nu2: 0.6; give Poisson's ratio of at most 0.5",
    ),
    (reference.half_plane_influence, {"nodes": 1, "E_star": 1.0}, "nodes: 1"),
    (
        reference.half_plane_contact,
        {"nodes": 10, "half_length": 1.0, "E_star": 1.0, "R": 0.0},
        "R: 0",
    ),
    (
        reference.sliding_corner_exponent,
        {"f": 2.1},
        "f: 2.1 .*outward slip; give friction below 2.03788",
    ),
    (
        reference.sliding_corner_exponent,
        {"f": 0.4, "slip": "inward"},
        "f: 0.4 .*inward slip; give friction below 0.31831",
    ),
    (
        reference.sliding_corner_exponent,
        {"f": 0.4, "slip": "sideways"},
        "slip: 'sideways'; give 'outward' or 'inward'",
    ),
    *(
        (mode.stress, {"r": [1.0, 0.0], "theta": 0.0}, "r: 0 at index 1; give distances above 0")
        for mode in reference.bonded_corner()
    ),
    *(
        (mode.stress, {"r": 1.0, "theta": np.nan}, "theta: nan")
        for mode in reference.bonded_corner()
    ),
]


@pytest.mark.parametrize(("ask", "arguments", "complaint"), CASES)
def test_what_is_refused(ask, arguments, complaint):
    with pytest.raises(fo.ModelError, match=complaint):
        ask(**arguments)
