#!/usr/bin/env bash
# QOCO says "optimal" for linear programs that have no optimum.
#
# Guess: "unbounded", as Clarabel and ECOS say, or an error.
# Seen: status "optimal" with an objective of 1e11 and more. The first point beyond the tolerances
# along the ray counts as the optimum.
# Versions: qoco 0.3.2, cvxpy 1.9.3, clarabel 0.11.1, Python 3.11; 2026-11-27.
# Output: three lines "QOCO optimal above 1e9, CLARABEL unbounded", then "as described".
. "$(dirname "$0")/common.sh"
packages qoco==0.3.2 cvxpy==1.9.3 clarabel==0.11.1

cat > "$folder/solve.py" <<'PYTHON'
import cvxpy as cp

x = cp.Variable(2)
without_optimum = [
    cp.Problem(cp.Maximize(x[0]), [x >= 0, x[1] <= 1]),
    cp.Problem(cp.Maximize(x[0] + x[1]), [x[0] == x[1]]),
    cp.Problem(cp.Maximize(x[0]), [x >= 0, x[0] - x[1] <= 1]),
]
for problem in without_optimum:
    problem.solve(solver=cp.CLARABEL)
    right = problem.status
    problem.solve(solver=cp.QOCO)
    size = "above 1e9" if problem.value > 1e9 else f"{problem.value:g}"
    print(f"QOCO {problem.status} {size}, CLARABEL {right}")
PYTHON

"$folder/venv/bin/python" -W ignore "$folder/solve.py" | tee "$folder/seen"
[ "$(sort --unique "$folder/seen")" = "QOCO optimal above 1e9, CLARABEL unbounded" ]
echo "as described"
