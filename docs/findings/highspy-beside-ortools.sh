#!/usr/bin/env bash
# A Python process loads either highspy or OR-Tools. The second import fails.
#
# Guess: both wheels bring a copy of the HiGHS library of their own, so that they do not meet.
# Seen: both copies are called libhighs.so.1. The loader keeps the first one for the whole process,
# and the second package misses functions in it: ImportError, "undefined symbol". In cvxpy this
# decides which solver exists: after `import cvxpy`, which imports highspy, GLOP raises ImportError
# when it is asked, although `cvxpy.installed_solvers()` lists it. If OR-Tools is imported first,
# cvxpy says that the solver HIGHS is not installed.
# Versions: highspy 1.15.1, ortools 9.15.6755, cvxpy 1.9.3, Python 3.11, Linux x86_64; 2026-11-27.
# Output: "ImportError" in lines 1 to 3, "SolverError" in line 4, then "as described".
. "$(dirname "$0")/common.sh"
packages highspy==1.15.1 ortools==9.15.6755 cvxpy==1.9.3

cat > "$folder/solve.py" <<'PYTHON'
import sys

first, solver = sys.argv[1:]
if first == "ortools":
    import ortools.linear_solver.pywraplp  # noqa: F401
import cvxpy as cp

x = cp.Variable()
try:
    print(solver, cp.Problem(cp.Minimize(x), [x >= 1]).solve(solver=solver))
except Exception as error:
    print(solver, type(error).__name__)
PYTHON

run() { { "$folder/venv/bin/python" -c "$1" 2>&1 || true; } | tail -n 1 | cut -d: -f1; }
{
  run "import highspy, ortools.linear_solver.pywraplp"
  run "import ortools.linear_solver.pywraplp, highspy"
  "$folder/venv/bin/python" "$folder/solve.py" cvxpy GLOP
  "$folder/venv/bin/python" "$folder/solve.py" ortools HIGHS
} 2>/dev/null | tee "$folder/seen"
printf '%s\n' ImportError ImportError "GLOP ImportError" "HIGHS SolverError" | diff - "$folder/seen"
echo "as described"
