"""The guaranteed limit against a bare loop of HiGHS calls, one for each node, on the same matrices."""

import highspy
import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import frictopt as fo
from frictopt.models.task import Task, cycle_loads

OPTIONS = {"default": {}, "no presolve": {"presolve": "off"}}


def bare_loop(system, cycle, friction, options):
    """A function that solves the linear program of every node with HiGHS, and nothing else; the matrices are made beforehand."""
    task = Task(system, cycle, cycle_loads(system, cycle), friction, False, False)
    interface = task.interface()
    rows, n = task.rows(interface), system.nodes
    lift, shear = rows.friction[:, None] * interface.normal, interface.shear
    matrix = np.hstack([np.vstack([lift + shear, lift - shear]), -np.concatenate([rows.forward, rows.backward])[:, None]])
    right = -np.concatenate([rows.g_mean + rows.q_mean, rows.g_mean - rows.q_mean])
    height, width = matrix.shape
    both = np.flatnonzero(rows.corners[0] != rows.corners[1])

    def run():
        least = np.inf
        for node in both:
            model = highspy.HighsModel()
            lp = model.lp_
            lp.num_col_, lp.num_row_ = width, height
            lp.col_cost_ = np.eye(width)[-1]
            lp.col_lower_, lp.col_upper_ = np.r_[np.full(width - 1, -np.inf), 0.0], np.full(width, np.inf)
            upper = np.full(height, np.inf)
            upper[[node, n + node]] = right[[node, n + node]]
            lp.row_lower_, lp.row_upper_ = right, upper
            lp.a_matrix_.format_ = highspy.MatrixFormat.kColwise
            lp.a_matrix_.start_ = np.arange(width + 1) * height
            lp.a_matrix_.index_, lp.a_matrix_.value_ = np.tile(np.arange(height), width), matrix.T.ravel()
            solver = highspy.Highs()
            solver.setOptionValue("output_flag", False)
            for name, value in options.items():
                solver.setOptionValue(name, value)
            solver.passModel(model)
            solver.run()
            if solver.getModelStatus() == highspy.HighsModelStatus.kOptimal:  # the others are infeasible or, of some without presolve, "unknown"
                least = min(least, solver.getInfo().objective_function_value * rows.load_unit)
        return least

    return run


@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("elements", [40, 124])
def test_guaranteed_limit_against_a_bare_loop(compare, cycle, elements, options):
    system = fo.PunchOnHalfPlane(elements=elements).condense()
    model = fo.GuaranteedModel(system, cycle)
    rival = bare_loop(system, cycle, 0.5, OPTIONS[options])
    assert rival() == pytest.approx(model.solve(0.5).upper, rel=1e-6)
    assert compare(lambda: model.solve(0.5), rival, rounds=5) < 1 / 3


@pytest.mark.parametrize(("elements", "friction", "most"), [(40, 0.5, 0.5), (124, 0.3, 5.0), (124, 0.7, 5.0), (124, 1.5, 5.0)])
def test_first_time(benchmark, cycle, elements, friction, most):
    system = fo.PunchOnHalfPlane(elements=elements).condense()
    with threadpool_limits(1):
        benchmark.pedantic(lambda: fo.guaranteed_limit(system, cycle, friction), rounds=5)
    assert benchmark.stats.stats.median < most
