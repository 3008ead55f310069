"""Planted faults of `solve`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "solve/condensed.py",
        "an objective without its constant",
        old="float(program.cost[self._pivots] @ self._start)",
        new="0.0",
        tests="interior_point",
    ),
    Fault(
        "solve/interior_point.py",
        "multipliers without their defect prove a bound",
        old="self.bound + _SURELY * off / tau",
        new="self.bound",
        tests="interior_point set_search",
    ),
    Fault(
        "solve/arrays.py",
        "multipliers of the block balance nothing",
        old="work[:width] + work[width:] @ block",
        new="work[:width]",
        tests="interior_point set_search",
    ),
    Fault(
        "solve/step_equations.py",
        "an error without the corrections before",
        old="program.rows(y + step) if y.any() else of_step",
        new="of_step",
        tests="interior_point",
    ),
    Fault(
        "solve/arrays.py",
        "an excess by multipliers that do not balance",
        old="float(unbalanced @ np.maximum(np.abs(x), 1.0))",
        new="0.0 * float(unbalanced @ np.maximum(np.abs(x), 1.0))",
        tests="polish",
    ),
    Fault(
        "solve/arrays.py",
        "a program has unknowns",
        old="np.abs(self.columns(y) + self.cost).max(initial=0.0)",
        new="np.abs(self.columns(y) + self.cost).max()",
        tests="polish",
    ),
    Fault(
        "solve/arrays.py",
        "equations need not hold",
        old="np.abs(s[:self.zero]).max(initial=0.0)",
        new="0.0",
        tests="polish own_constraints",
    ),
    Fault(
        "solve/arrays.py",
        "cones need not hold",
        old="np.linalg.norm(s[cone[:, 1:]], axis=1) - s[cone[:, 0]]",
        new="0.0 * s[cone[:, 0]]",
        tests="polish own_constraints",
    ),
    Fault(
        "solve/arrays.py",
        "multipliers stay outside their cones",
        old="np.maximum(y[cone[:, 0]], np.linalg.norm(y[cone[:, 1:]], axis=1))",
        new="y[cone[:, 0]]",
        tests="polish own_constraints",
    ),
    Fault(
        "solve/arrays.py",
        "rows that do not bind become equations",
        old="excess > share * tip",
        new="excess < share * tip",
        tests="polish",
    ),
    Fault(
        "solve/arrays.py",
        "cones that turn their multipliers",
        old="-size[:, None]",
        new="size[:, None]",
        tests="polish spatial_limits",
    ),
    Fault(
        "solve/arrays.py",
        "factors of singular equations are trusted",
        old="dsycon(factor, order, np.abs(matrix).sum(axis=0).max())[0] > _NOT_UNIQUE",
        new="dsycon(factor, order, np.abs(matrix).sum(axis=0).max())[0] > -1.0",
        tests="polish",
    ),
    Fault(
        "solve/arrays.py",
        "the last guess is the best",
        old="off < least",
        new="off < np.inf",
        tests="polish",
    ),
    Fault(
        "solve/arrays.py",
        "multipliers that do not balance are exact",
        old="max(self.violation(x), balance, abs(y @ self.slack(x)))",
        new="max(self.violation(x), abs(y @ self.slack(x)))",
        tests="polish",
    ),
    Fault(
        "solve/arrays.py",
        "equations are no active rows",
        old="np.arange(program.zero)",
        new="np.arange(0)",
        tests="polish",
    ),
    Fault(
        "solve/solvers.py",
        "multipliers of HiGHS have their own sign",
        old="-np.array(solution.row_dual)",
        new="np.array(solution.row_dual)",
        tests="shakedown listings",
    ),
    Fault(
        "solve/solvers.py",
        "equations hold one way alone for HiGHS",
        old="np.where(np.arange(m) < program.zero, program.right, -np.inf)",
        new="np.full(m, -np.inf)",
        tests="guaranteed",
    ),
    Fault(
        "solve/solvers.py",
        "an infeasible program has an optimum",
        old=(
            "{highspy.HighsModelStatus.kOptimal: OPTIMAL, "
            "highspy.HighsModelStatus.kInfeasible: INFEASIBLE, "
            "highspy.HighsModelStatus.kUnbounded: UNBOUNDED, "
            "highspy.HighsModelStatus.kUnboundedOrInfeasible: NONE, "
            "highspy.HighsModelStatus.kObjectiveBound: CUT_OFF, 'Solved': OPTIMAL, "
            "'AlmostSolved': OPTIMAL, 'InsufficientProgress': OPTIMAL, 'PrimalInfeasible': "
            "INFEASIBLE, 'AlmostPrimalInfeasible': INFEASIBLE, 'DualInfeasible': UNBOUNDED, "
            "'AlmostDualInfeasible': UNBOUNDED}"
        ),
        new=(
            "{highspy.HighsModelStatus.kOptimal: OPTIMAL, "
            "highspy.HighsModelStatus.kInfeasible: OPTIMAL, "
            "highspy.HighsModelStatus.kUnbounded: UNBOUNDED, "
            "highspy.HighsModelStatus.kUnboundedOrInfeasible: NONE, "
            "highspy.HighsModelStatus.kObjectiveBound: CUT_OFF, 'Solved': OPTIMAL, "
            "'AlmostSolved': OPTIMAL, 'InsufficientProgress': OPTIMAL, 'PrimalInfeasible': "
            "INFEASIBLE, 'AlmostPrimalInfeasible': INFEASIBLE, 'DualInfeasible': UNBOUNDED, "
            "'AlmostDualInfeasible': UNBOUNDED}"
        ),
        tests="limit_kinds",
    ),
    Fault(
        "solve/condensed.py",
        "variables of equations cost nothing",
        old="program.cost[self._remaining] + self._rest.T @ program.cost[self._pivots]",
        new="program.cost[self._remaining]",
        tests="interior_point",
    ),
    Fault(
        "solve/interior_point.py",
        "infeasible and unbounded are one",
        old="('PrimalInfeasible', 'DualInfeasible')",
        new="('DualInfeasible', 'PrimalInfeasible')",
        tests="interior_point",
    ),
    Fault(
        "solve/step_equations.py",
        "lost digits end no way through the block",
        old="self.through_block and (not error <= _ENOUGH * _largest(u, v))",
        new="False",
        tests="interior_point",
    ),
    Fault(
        "solve/step_equations.py",
        "only unknowns are projected",
        old="matrix[entries.row, entries.col] += entries.data",
        new="pass",
        tests="interior_point",
    ),
    Fault(
        "solve/condensed.py",
        "steps leave their cones",
        old="(aside - ahead).max",
        new="(aside - ahead).min",
        tests="interior_point",
    ),
    Fault(
        "solve/problem.py",
        "an infeasible problem loses its multipliers",
        old="part.save_value(value)",
        new="part.value",
        tests="limit_kinds",
    ),
    Fault(
        "solve/solvers.py",
        "a simplex method may go round in a circle",
        old="each * (m + n) + least_steps",
        new="2147483647",
        tests="solvers",
    ),
    Fault(
        "solve/answer.py",
        "growth along a direction of forces counts, too",
        old="np.zeros((1 if cost is None else 2, width + 1 + len(program.block)))",
        new="-np.eye(1 if cost is None else 2, width + 1 + len(program.block), width)",
        tests="all_sets",
    ),
    Fault(
        "solve/answer.py",
        "an answer that fails is returned",
        old="best and best.residual <= tolerance",
        new="best",
        tests="limit_checks guaranteed answer",
    ),
    Fault(
        "solve/answer.py",
        "multipliers outside their cones prove a limit",
        old="(x, self.program.admissible(y))",
        new="(x, y)",
        tests="answer",
    ),
    Fault(
        "solve/answer.py",
        "a contradiction without its error",
        old="error <= (best[1] if best else RESIDUAL)",
        new="best is None",
        tests="answer limit_checks",
    ),
    Fault(
        "solve/answer.py",
        "a way that leaves the rows is a growth",
        old="leaving > RESIDUAL or -float(program.cost @ ray) <= RESIDUAL * size",
        new="False",
        tests="answer",
    ),
    Fault(
        "solve/condensed.py",
        "equations that follow from others eliminate unknowns",
        old="np.sort(order[:rank])",
        new="np.arange(count)",
        tests="interior_point",
    ),
    Fault(
        "solve/products.py",
        "products keep their factors",
        old="2.0 ** np.round(np.log2(ratio) / 2)",
        new="1.0 + 0.0 * ratio",
        tests="own_constraints",
    ),
    Fault(
        "solve/by_cvxpy.py",
        "infeasible where one solver alone says so",
        old="agreed and outcome in _NO_OPTIMUM",
        new="outcome in _NO_OPTIMUM",
        tests="solvers",
    ),
)
