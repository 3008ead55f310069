"""The guaranteed limit against a bare loop of HiGHS calls, one for each node, on the same matrices."""

import pytest
from threadpoolctl import threadpool_limits

import frictopt as fo
from studies.validation.error_vs_time.limits import OPTIONS, NodePrograms


@pytest.mark.parametrize("options", OPTIONS)
@pytest.mark.parametrize("elements", [40, 124])
def test_guaranteed_limit_against_a_bare_loop(compare, cycle, elements, options):
    system = fo.scenes.PunchOnHalfPlane(elements=elements).condense()
    model = fo.GuaranteedModel(system, cycle)
    programs = NodePrograms.of(system, cycle, 0.5)

    def rival():
        return programs.least(OPTIONS[options])[0]

    assert rival() == pytest.approx(model.solve(0.5).load_factor, rel=1e-6)
    assert compare(lambda: model.solve(0.5), rival, rounds=5) < 1 / 3


@pytest.mark.parametrize(
    ("elements", "friction", "most"),
    [(40, 0.5, 0.5), (124, 0.3, 5.0), (124, 0.7, 5.0), (124, 1.5, 5.0)],
)
def test_first_time(benchmark, cycle, elements, friction, most):
    system = fo.scenes.PunchOnHalfPlane(elements=elements).condense()
    with threadpool_limits(1):
        benchmark.pedantic(lambda: fo.guaranteed_limit(system, cycle, friction), rounds=5)
    assert benchmark.stats.stats.median < most
