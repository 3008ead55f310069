import pytest
from hypothesis import settings

import frictopt as fo

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
            made[key] = fo.PunchOnHalfPlane(elements=elements, grading=grading, growth=growth).condense()
        return made[key]

    return condensed
