"""Planted faults of `studies`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "validation/calculix_statements.py",
        "a contact in a perturbation step counts as none",
        old="change > 0.1",
        new="change < 0.1",
        tests="studies_calculix",
    ),
    Fault(
        "validation/calculix_statements.py",
        "the labels of a chosen nodal diameter are those of all rows",
        old="rows == 2",
        new="rows == 1",
        tests="studies_calculix",
    ),
    Fault(
        "validation/calculix_statements.py",
        "substructures are reduced",
        old="difference < 1e-9",
        new="difference > 1e-9",
        tests="studies_calculix",
    ),
    Fault(
        "validation/calculix.py",
        "the slice of 0.5 is taken for a whole depth",
        old="forces[:, :3] * [1.0, -2.0, -2.0]",
        new="forces[:, :3] * [1.0, -1.0, -1.0]",
        tests="studies_calculix",
    ),
    Fault(
        "validation/calculix.py",
        "the work counts the way to the cycle",
        old="forces[:, 0] >= len(history.corners) - 2 - 1e-9",
        new="forces[:, 0] >= 0",
        tests="studies_calculix",
    ),
    Fault(
        "validation/lower_bound.py",
        "sign of the derived bounds",
        old="-ends",
        new="ends",
        tests="guaranteed_lower",
    ),
    Fault(
        "validation/solvers.py",
        "an answer counts as right if the solver says so",
        old="row['error'] <= parameters.right",
        new="not row['error'] > parameters.right",
        tests="studies_solvers",
    ),
    Fault(
        "validation/solvers.py",
        "a program without an optimum may have one",
        old="(cp.OPTIMAL, cp.INFEASIBLE, cp.UNBOUNDED)",
        new="(cp.INFEASIBLE, cp.UNBOUNDED)",
        tests="studies_solvers",
    ),
    Fault(
        "validation/vibrations.py",
        "a force at a mass is not that of the mode",
        old="np.eye(len(omega))[point] / shapes[point, k]",
        new="np.eye(len(omega))[point] * shapes[point, k]",
        tests="studies_forced_response",
    ),
    Fault(
        "validation/vibrations.py",
        "friction holds every shear",
        old="abs(shear) > friction * pressed",
        new="abs(shear) > 10 * friction * pressed",
        tests="studies_forced_response",
    ),
    Fault(
        "validation/forced_response.py",
        "rows above the threshold count as below",
        old="_product(known) <= _SORTED_AT",
        new="_product(known) > _SORTED_AT",
        tests="studies_forced_response",
    ),
)
