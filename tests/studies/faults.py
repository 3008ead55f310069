"""Planted faults of `studies`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
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
)
