import pandas as pd
import pytest
import scipy.linalg  # noqa: F401  brings a BLAS of its own, to be limited too
from hypothesis import settings
from threadpoolctl import threadpool_limits

import frictopt as fo

threadpool_limits(1)  # tests run side by side

settings.register_profile("repeatable", derandomize=True)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def paper_cycle():
    return fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])


@pytest.fixture(scope="session")
def punch():
    """Condensed scenes by number of elements, each made once."""
    made = {}

    def condensed(elements, grading="sine", growth=1.15):
        key = elements, grading, growth
        if key not in made:
            made[key] = fo.scenes.PunchOnHalfPlane(elements=elements, grading=grading, growth=growth).condense()
        return made[key]

    return condensed


@pytest.fixture(scope="session")
def quick_data(tmp_path_factory):
    """Folder with the tables of studies at quick size, as far as tests have asked for them."""
    return tmp_path_factory.mktemp("quick")


@pytest.fixture(scope="session")
def quick(quick_data):
    """Gives the tables of a study at quick size, by name; each is computed once."""

    def read(tables):
        for table in tables:
            table.load(table.quick, quick_data)
        return {table.name: pd.read_parquet(table.path(quick_data)) for table in tables}

    return read
