#!/usr/bin/env bash
# ProxQP says "infeasible" for a linear program in which zero obeys all rows.
#
# Guess: an answer of a few digits, or an iteration limit; ProxQP is a method for quadratic programs.
# Seen: "infeasible" for chains of 20 and 40 springs on a surface with friction, whose largest safe
# load the other solvers find. Zero load without slip obeys every row with a margin of 0.5. The
# chain of 10 springs is solved. So the status is no proof.
# Versions: proxsuite 0.8.0, highspy 1.15.1, cvxpy 1.9.3, Python 3.11; 2026-11-27.
# Output: "10 springs: PROXQP optimal, HIGHS optimal", and "PROXQP infeasible, HIGHS optimal" for 20
# and 40, then "as described".
. "$(dirname "$0")/common.sh"
packages proxsuite==0.8.0 highspy==1.15.1 cvxpy==1.9.3

cat > "$folder/solve.py" <<'PYTHON'
import cvxpy as cp
import numpy as np

def largest_load(springs):
    """The largest load that a chain of springs holds to and fro, by one slip of each spring."""
    stiffness = 2 * np.eye(springs) - np.eye(springs, k=1) - np.eye(springs, k=-1)
    coupling = 0.1 * (np.eye(springs, k=1) - np.eye(springs, k=-1))
    shape = np.linspace(-1, 1, springs)
    load = cp.Variable()
    slip = cp.Variable(springs)
    bound = 0.5 * (1 + coupling @ slip)
    held = [cp.abs(sign * load * shape + stiffness @ slip) <= bound for sign in (-1, 1)]
    return cp.Problem(cp.Maximize(load), [*held, load >= 0])

for springs in (10, 20, 40):
    problem = largest_load(springs)
    problem.solve(solver=cp.PROXQP)
    status = problem.status
    problem.solve(solver=cp.HIGHS)
    print(f"{springs} springs: PROXQP {status}, HIGHS {problem.status}")
PYTHON

"$folder/venv/bin/python" -W ignore "$folder/solve.py" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
10 springs: PROXQP optimal, HIGHS optimal
20 springs: PROXQP infeasible, HIGHS optimal
40 springs: PROXQP infeasible, HIGHS optimal
OUTPUT
echo "as described"
