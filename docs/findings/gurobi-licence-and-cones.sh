#!/usr/bin/env bash
# With gurobipy installed, a bare solve() in cvxpy fails for a cone program above 200 variables.
#
# Guess: the licence inside the wheel of gurobipy allows 2,000 variables, and above that either the
# message names the licence or cvxpy takes Clarabel, which is installed as well.
# Seen: with second-order cones the licence ends at 200 variables, auxiliary ones counted. cvxpy
# prefers Gurobi to Clarabel for such problems as soon as it is installed, does not fall back, and
# says only "Solver 'GUROBI' failed". A linear program of 1,000 variables is solved. The same cone
# program with solver="CLARABEL" is solved.
# Versions: gurobipy 13.0.3, cvxpy 1.9.3, clarabel 0.11.1, Python 3.11; 2026-11-27.
# Output: "linear 1000: optimal", "cones 33: optimal", "cones 50: SolverError, licence not named",
# "cones 50 by Clarabel: optimal", then "as described".
. "$(dirname "$0")/common.sh"
packages gurobipy==13.0.3 cvxpy==1.9.3 clarabel==0.11.1

cat > "$folder/solve.py" <<'PYTHON'
import cvxpy as cp

def cones(count):
    """The largest t of points in unit circles, all with a first coordinate of at least t."""
    t = cp.Variable()
    points = cp.Variable((count, 2))
    circles = cp.norm(points, 2, axis=1) <= 1
    return cp.Problem(cp.Maximize(t), [circles, points[:, 0] >= t])

def outcome(problem, **options):
    try:
        problem.solve(**options)
    except cp.SolverError as error:
        named = "named" if "licen" in str(error).lower() else "not named"
        return f"SolverError, licence {named}"
    return problem.status

x = cp.Variable(1000)
print("linear 1000:", outcome(cp.Problem(cp.Minimize(cp.sum(x)), [x >= 1])))
print("cones 33:", outcome(cones(33)))
print("cones 50:", outcome(cones(50)))
print("cones 50 by Clarabel:", outcome(cones(50), solver=cp.CLARABEL))
PYTHON

"$folder/venv/bin/python" "$folder/solve.py" | grep -v "^Restricted license" | tee "$folder/seen"
diff - "$folder/seen" <<'OUTPUT'
linear 1000: optimal
cones 33: optimal
cones 50: SolverError, licence not named
cones 50 by Clarabel: optimal
OUTPUT
echo "as described"
