"""Planted faults of `reference`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "reference/hertz.py",
        "slip from the wrong root",
        old="c ** 2 * np.arccosh(outside / c)",
        new="c * np.arccosh(outside / c)",
        tests="reference_*",
    ),
    Fault(
        "reference/uncoupled.py",
        "sign of the coupling",
        old="p0 - d * q0",
        new="p0 + d * q0",
        tests="reference_limits",
    ),
    Fault(
        "reference/uncoupled.py",
        "half of the travel",
        old="2 * (lam * abs(A * q1 - f ** 2 * B * p1) - f * D)",
        new="lam * abs(A * q1 - f ** 2 * B * p1) - f * D",
        tests="reference_dissipation",
    ),
    Fault(
        "reference/uncoupled.py",
        "the largest circle",
        old="lambda circle: circle[1]",
        new="lambda circle: -circle[1]",
        tests="spatial_limits",
    ),
    Fault(
        "reference/sliders.py",
        "one node too many",
        old="F0 * m * (m + 1)",
        new="F0 * m * (m - 1)",
        tests="reference_dissipation",
    ),
    Fault(
        "reference/half_spaces.py",
        "shear of two materials opens gaps on one side alone",
        old="np.sign(np.subtract.outer(np.arange(nodes), np.arange(nodes)))",
        new="np.clip(np.sign(np.subtract.outer(np.arange(nodes), np.arange(nodes))), 0, 1)",
        tests="reference_line_contact",
    ),
    Fault(
        "reference/half_spaces.py",
        "a force drags its neighbours aside the wrong way",
        old=(
            "[[(1 - nu) * normal + nu * along, nu * mixed], [nu * mixed, (1 - nu) * normal + nu * across]]"
        ),
        new=(
            "[[(1 - nu) * normal + nu * along, -nu * mixed], [-nu * mixed, (1 - nu) * normal + nu * across]]"
        ),
        tests="reference_line_contact::test_influence_in_space_is_far_away_that_of_point_forces",
    ),
)
