#!/usr/bin/env bash
# The dual values that cvxpy has from SCIP are wrong for bounds that are written as constraints.
#
# Guess: each solver of cvxpy that gives dual values for a linear program gives those of an optimum,
# so that their sum over the rows balances the objective.
# Seen: with SCIP all rows with one variable have the dual value zero, also where such a row is what
# holds the optimum: the limits seem to cost nothing. The optimum itself is right, the status is
# "optimal", and no warning is given. HiGHS and Clarabel are right.
# Versions: cvxpy 1.9.3, pyscipopt 6.3.0, highspy 1.16.0, clarabel 0.11.1, numpy 2.3.5, Python 3.11;
# 2026-11-28.
# Output: largest load that two friction forces below 3 and 4 hold, and what a unit more of each
# limit adds: "SCIP: load 7.0, limits add 0.0 and 0.0", "HIGHS: load 7.0, limits add 1.0 and 1.0",
# the same for CLARABEL, then "as described".
. "$(dirname "$0")/common.sh"
packages \
  cvxpy==1.9.3 pyscipopt==6.3.0 highspy==1.16.0 clarabel==0.11.1 numpy==2.3.5
cd "$folder"

cat > load.py <<'PYTHON'
import cvxpy as cp

for solver in ("SCIP", "HIGHS", "CLARABEL"):
    load, friction = cp.Variable(), cp.Variable(2)
    limits = [friction[0] <= 3, friction[1] <= 4]
    problem = cp.Problem(cp.Maximize(load), [load == cp.sum(friction), friction >= -10, *limits])
    problem.solve(solver=solver)
    added = [abs(float(limit.dual_value)) for limit in limits]
    print(f"{solver}: load {problem.value:.1f}, limits add {added[0]:.1f} and {added[1]:.1f}")
PYTHON

venv/bin/python load.py | grep 'load' | tee seen
diff - seen <<'OUTPUT'
SCIP: load 7.0, limits add 0.0 and 0.0
HIGHS: load 7.0, limits add 1.0 and 1.0
CLARABEL: load 7.0, limits add 1.0 and 1.0
OUTPUT
echo "as described"
