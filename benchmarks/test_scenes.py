"""A dovetail of 58,634 unknowns and 250 node pairs: condensation against one sparse factorisation, and its limits."""

import pytest
from scipy.sparse.linalg import splu
from threadpoolctl import threadpool_limits

import frictopt as fo
from frictopt.fem import model as models
from frictopt.fem import schur

CYCLE = fo.LoadCycle({"pull": 1.0}, [{"sway": 1.0}, {"sway": -1.0}])
ORDERINGS = {
    "MMD_AT_PLUS_A": {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}},
    "COLAMD": {},  # scipy's default
}


def called(module, name, run):
    """What a function was given while something ran."""
    function, given = getattr(module, name), []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, name, lambda *args, **options: given.append((args, options)) or function(*args, **options))
        run()
    return given[0]


@pytest.fixture(scope="module")
def model():
    return fo.Dovetail(elements=124).model()


@pytest.fixture(scope="module")
def contact(model):
    return model.condense()


@pytest.mark.parametrize("ordering", ORDERINGS)
def test_condensation_against_one_factorisation(compare, model, ordering):
    """The rival factorises the glued matrix, as scipy orders it; ours is given the stiffness of the bodies."""
    args, options = called(models, "condense", model.condense)
    (glued,), _ = called(schur, "splu", model.condense)
    assert glued.shape[0] > 55_000
    assert compare(lambda: fo.condense(*args, **options), lambda: splu(glued, **ORDERINGS[ordering]), rounds=5) < 1.5


@pytest.mark.parametrize(("limit", "seconds"), [(fo.shakedown_limit, 2.0), (fo.guaranteed_limit, 5.0)], ids=["shakedown", "guaranteed"])
def test_limits(benchmark, contact, limit, seconds):
    assert contact.nodes == 250
    with threadpool_limits(1):
        benchmark.pedantic(lambda: limit(contact, CYCLE, 0.6), rounds=3)
    assert benchmark.stats.stats.median < seconds
