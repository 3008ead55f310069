"""The shakedown limit at the paper's size against a bare HiGHS call on the same reduced matrices."""

import highspy
import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import frictopt as fo
from frictopt.models.solve import _OPTIONS


def bare_highs(problem, options):
    """A function that passes the compiled matrices of a cvxpy problem to HiGHS and solves, and nothing else."""
    data, _, _ = problem.get_problem_data("HIGHS")
    matrix = data["A"].tocsc()
    rows, columns = matrix.shape
    lower, upper = data["lower_bounds"], data["upper_bounds"]

    def run():
        model = highspy.HighsModel()
        lp = model.lp_
        lp.num_col_, lp.num_row_ = columns, rows
        lp.col_cost_ = data["c"]
        lp.col_lower_ = np.full(columns, -np.inf) if lower is None else lower
        lp.col_upper_ = np.full(columns, np.inf) if upper is None else upper
        lp.row_lower_, lp.row_upper_ = np.full(rows, -np.inf), data["b"]
        lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
        lp.a_matrix_.start_, lp.a_matrix_.index_, lp.a_matrix_.value_ = matrix.indptr, matrix.indices, matrix.data
        solver = highspy.Highs()
        solver.setOptionValue("output_flag", False)
        for name, value in options.items():
            solver.setOptionValue(name, value)
        solver.passModel(model)
        solver.run()
        assert solver.getModelStatus() == highspy.HighsModelStatus.kOptimal
        return -solver.getInfo().objective_function_value

    return run


OPTIONS = {"default": {}, "ours": _OPTIONS["HIGHS"]["highs_options"]}


@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("simplify", [True, False])
def test_compiled_limit_against_bare_highs(compare, system, cycle, options, simplify):
    model = fo.ShakedownModel(system, cycle, simplify=simplify, corners="ruling")
    limit = model.solve(0.7)
    rival = bare_highs(limit.problem, OPTIONS[options])
    assert rival() == pytest.approx(limit.problem.value, rel=1e-7)
    assert compare(lambda: model.solve(0.7), rival, rounds=25) < 2.0


def test_first_time(benchmark, system, cycle):
    with threadpool_limits(1):
        benchmark.pedantic(lambda: fo.shakedown_limit(system, cycle, 0.7), rounds=9)
    assert benchmark.stats.stats.median < 0.1


def test_64_corners_against_2(compare, system, cycle):
    angles = 2 * np.pi * np.arange(64) / 64
    many = fo.LoadCycle({"P": 1.0}, [{"sigma": float(np.cos(a)), "P": 0.1 * float(np.sin(a))} for a in angles])
    few = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0, "P": 0.1}, {"sigma": 1.0, "P": -0.1}])
    assert compare(lambda: fo.shakedown_limit(system, many, 0.7), lambda: fo.shakedown_limit(system, few, 0.7), rounds=25) < 1.2


def test_sweep_of_50_against_single_solves(compare, system, cycle):
    frictions = np.linspace(0.2, 1.5, 50)
    assert compare(lambda: fo.ShakedownModel(system, cycle).sweep(frictions), lambda: fo.shakedown_limit(system, cycle, 0.7)) < 20.0


def test_sweep_against_solving_from_scratch(compare, system, cycle):
    frictions = np.linspace(0.2, 1.5, 10)
    assert compare(lambda: fo.ShakedownModel(system, cycle).sweep(frictions), lambda: [fo.shakedown_limit(system, cycle, f) for f in frictions]) < 1.0
