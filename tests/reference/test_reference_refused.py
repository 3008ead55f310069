"""What the closed forms refuse, by name and with what to give instead."""

import numpy as np
import pytest

import frictopt as fo
from frictopt import reference

CYLINDER = {"P": 1.0, "R": 1.0, "E_star": 1.0, "f": 0.5}
CASES = [
    (reference.rod_dissipation, {"F0": -1, "EA": 1, "tau": 1, "h": 1}, "F0: -1"),
    (reference.foundation_rod, {"nodes": 0, "EA": 1, "h": 1}, "nodes: 0"),
    (reference.LineContact, CYLINDER | {"P": 0}, "P: 0"),
    (
        reference.LineContact(**CYLINDER).dissipation,
        {"Q0": 0.5},
        "Q0: 0.5; the body slides, give a shear force below f P = 0.5",
    ),
    (reference.LineContact(**CYLINDER).stick_half_width, {"Q": -0.6}, "Q: -0.6; the body slides"),
    (reference.half_plane_influence, {"nodes": 1, "E_star": 1.0}, "nodes: 1"),
    (
        reference.half_plane_contact,
        {"nodes": 10, "half_length": 1.0, "E_star": 1.0, "R": 0.0},
        "R: 0",
    ),
    (
        reference.sliding_corner_exponent,
        {"f": 2.1},
        "f: 2.1 .*no singular mode; give friction below 2.03788",
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
