"""Solvers are loaded with the package, and leave the process as it was.

Also questions from several threads leave warnings, BLAS threads, numpy and signals as they were.
"""

import signal
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor

import cvxpy as cp
import numpy as np
import pytest
import threadpoolctl

import frictopt as fo
from frictopt.solve import by_cvxpy, solvers
from helpers.liars import lying_by_cvxpy
from helpers.systems import CYCLE, random_system, unit_nodes


def test_a_highs_that_cannot_be_loaded_is_named_with_a_remedy(tmp_path):
    broken = "raise ImportError('undefined symbol: another HiGHS was first')"
    (tmp_path / "highspy.py").write_text(broken)
    program = f"import sys; sys.path.insert(0, {str(tmp_path)!r}); import frictopt.solve.solvers"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    last = ended.stderr.strip().splitlines()[-1]
    assert ended.returncode == 1
    assert last.startswith("ImportError: highspy cannot be loaded (undefined symbol")
    assert "import frictopt before it" in last


@pytest.mark.parametrize("answers", [False, True])
def test_a_problem_of_cvxpy_is_solved_if_any_solver_finds_an_optimum(monkeypatch, answers):
    *others, last = [name for name in solvers.SOLVERS[solvers.SOCP] if name in solvers.OPTIONS]
    told = dict.fromkeys(others, cp.INFEASIBLE) | {last: cp.OPTIMAL if answers else "stopped"}
    lying_by_cvxpy(monkeypatch, lambda _, name: told[name])
    x = cp.Variable(nonneg=True)
    problem = cp.Problem(cp.Minimize(x))
    if answers:
        attempts = by_cvxpy.solve(problem, lambda: 1e-3)
        assert [attempt.residual for attempt in attempts] == [*[np.inf] * len(others), 1e-3]
        return
    with pytest.raises(fo.SolverError, match="no solver of cvxpy finds an optimum"):
        by_cvxpy.solve(problem, lambda: 1e-3)


@pytest.mark.parametrize("least", [0, 100])
def test_a_simplex_method_that_takes_too_many_steps_is_stopped_and_another_solver_answers(
    monkeypatch, least
):
    """A node under p = 1 and a shear of 1: lambda = f. It takes a step or two."""
    monkeypatch.setattr(solvers, "_STEPS", (0, least))
    loads = {"mean": ([0.0], [1.0]), "shear": ([1.0], [0.0])}
    node = unit_nodes(loads)
    cycle = fo.LoadCycle({"mean": 1.0}, [{"shear": 1.0}, {"shear": -1.0}])
    limit = fo.shakedown_limit(node, cycle, 0.5)
    assert limit.load_factor == pytest.approx(0.5, rel=1e-9)
    solver, *others = (attempt.solver for attempt in limit.record.attempts)
    assert solver == "HIGHS" and ("CLARABEL" in others) == (least == 0)


def state():
    libraries = threadpoolctl.threadpool_info()
    return (
        list(warnings.filters),
        warnings.showwarning,
        np.geterr(),
        [library["num_threads"] for library in libraries],
        [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)],
    )


def ask(seed):
    system = random_system(np.random.default_rng(seed), 3)
    limit = fo.shakedown_limit(system, CYCLE, 0.5, progress=False)
    fo.dissipation_study(system, CYCLE, 0.5, [0.5], progress=False)
    return limit.load_factor


def test_questions_from_eight_threads_leave_the_process_as_it_is():
    alone = [ask(seed) for seed in range(16)]
    before = state()
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(ask, range(16))) == alone
    assert state() == before


def test_odd_contacts_warn_from_eight_threads_as_from_one():
    system = random_system(np.random.default_rng(3), 3)

    def odd(number):
        fo.shakedown_limit(system, CYCLE, 30.0 + number, progress=False)

    with warnings.catch_warnings(record=True) as alone:
        warnings.simplefilter("always")
        for number in range(20):
            odd(number)
    with warnings.catch_warnings(record=True) as together:
        warnings.simplefilter("always")
        with ThreadPoolExecutor(8) as pool:
            list(pool.map(odd, range(20)))
    texts = [sorted(str(warning.message) for warning in some) for some in (alone, together)]
    assert texts[0] == texts[1] and len(texts[0]) == 20
