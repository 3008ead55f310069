#!/usr/bin/env bash
# COPT says "optimal" for a point of a small convex quadratic program that is far from the optimum.
#
# Guess: solvers agree on a strictly convex quadratic program with four variables and whole numbers,
# whose unconstrained minimum obeys all rows.
# Seen: COPT stops at a vertex of its rows, with the status "optimal" and the value 0.88 instead of
# -1. Its presolve is to blame: without it the value is right, as it is if the limits x <= 5 are
# removed. coptpy without cvxpy gives the same, if it has cvxpy's rows and the variable y = c x whose
# squares are summed. `sum_squares(x)`, with the same value for these c, has no such y, and is right.
# Versions: cvxpy 1.9.3, coptpy 8.0.7 (size-limited, without a licence), clarabel 0.11.1,
# numpy 2.3.5, Python 3.11; 2026-11-28.
# Output: "CLARABEL: optimal -1.00", "COPT: optimal 0.88", "COPT without presolve: optimal -1.00",
# "COPT, squares of x: optimal -1.00", then "as described".
. "$(dirname "$0")/common.sh"
packages cvxpy==1.9.3 coptpy==8.0.7 clarabel==0.11.1 numpy==2.3.5
cd "$folder"

cat > program.py <<'PYTHON'
import cvxpy as cp
import numpy as np

c = np.array([1, 1, -1, -1])
rows = np.array([[-1, 0, 0, 5], [0, -1, -1, -2], [0, 1, 0, 0]])
x = cp.Variable(4)
limits = [rows @ x <= [10, 1, 1], x >= -5, x <= 5]
scaled = cp.Problem(cp.Minimize(c @ x + cp.sum_squares(cp.multiply(c, x))), limits)
plain = cp.Problem(cp.Minimize(c @ x + cp.sum_squares(x)), limits)

# By hand: without limits the minimum is -1 at -c / 2, which obeys them.
assert np.all(rows @ (-c / 2) < [10, 1, 1])

for name, problem, options in (
    ("CLARABEL", scaled, {"solver": "CLARABEL"}),
    ("COPT", scaled, {"solver": "COPT"}),
    ("COPT without presolve", scaled, {"solver": "COPT", "Presolve": 0}),
    ("COPT, squares of x", plain, {"solver": "COPT"}),
):
    problem.solve(**options)
    print(f"{name}: {problem.status} {problem.value:.2f}")
PYTHON

venv/bin/python program.py | grep -E '^(CLARABEL|COPT)[a-z, ]*: ' | tee seen
diff - seen <<'OUTPUT'
CLARABEL: optimal -1.00
COPT: optimal 0.88
COPT without presolve: optimal -1.00
COPT, squares of x: optimal -1.00
OUTPUT
echo "as described"
