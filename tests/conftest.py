import gc
import os
import signal
import tarfile
from contextlib import redirect_stdout
from importlib import import_module
from io import StringIO
from pathlib import Path
from zlib import crc32

import numpy as np
import pandas as pd
import pytest
import scipy.linalg  # noqa: F401  brings a BLAS of its own, to be limited too
from hypothesis import settings
from locket import lock_file
from threadpoolctl import threadpool_limits

import frictopt as fo
from frictopt.transients.exact.kernel import compiled
from helpers import absent, cases

collect_ignore_glob = ["tools/*"]  # programs

threadpool_limits(1)  # tests run side by side
os.environ["PYVISTA_OFF_SCREEN"] = "true"  # before PyVista is imported

# Seconds: a test that hangs fails and says where. Slow tests have ten times as long.
PATIENCE = 60.0

# Tests that the default run leaves out, written by tests/tools/slow_tests.py.
SLOW = frozenset(Path(__file__).with_name("slow.txt").read_text(encoding="utf-8").split("\n"))


def compiled_in_space():
    fo.increments.NewtonIncrement(
        fo.ContactSystem(np.eye(3), [[0, 0, 0]], {"P": [0, 0, 1]}), 0.5
    ).solve([[0.0, 0.0]], ([[1.0, 0.0]], [1.0]))


def pytest_addoption(parser):
    parser.addoption(
        "--share",
        metavar="K/N",
        help="run the tests of one N-th of the files, such as 3/7 of seven",
    )


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config):
    """Choose the random cases, and compile what the tests share in a process of several.

    Processes that begin together would all compile all. Each begins with one of two halves, and
    takes the other from the process that has compiled it.
    """
    # Plug-ins of pytest are options: without them, no test is stopped, and all run in one process.
    plugins = config.pluginmanager
    if plugins.hasplugin("timeout") and config.option.timeout is None:
        config.option.timeout = PATIENCE
    if plugins.hasplugin("xdist") and config.option.maxworkerrestart is None:
        # A process that dies ends the run and says in which test.
        config.option.maxworkerrestart = "0"
    # Hooks of this file see no examples of the package, which is in another folder.
    config.pluginmanager.register(absent)
    cases.SEED = config.getoption("hypothesis_seed", None)
    settings.register_profile("tests", derandomize=cases.SEED is None, database=None, deadline=None)
    settings.load_profile("tests")
    if hasattr(config, "workerinput"):
        shared = Path(config.option.basetemp).parent
        number = int(os.environ["PYTEST_XDIST_WORKER"][2:])
        for half in (compiled, compiled_in_space)[:: 1 if number % 2 else -1]:
            with lock_file(str(shared / half.__name__)):
                half()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Mark the slow tests, before `-m` chooses, and keep those of a share of the files.

    A slow test may take ten times as long as others before it counts as one without an end.
    """
    for item in items:
        if item.nodeid in SLOW:
            item.add_marker(pytest.mark.slow)
            if config.pluginmanager.hasplugin("timeout"):
                item.add_marker(pytest.mark.timeout(10 * PATIENCE))
    if share := config.getoption("share"):
        number, shares = map(int, share.split("/"))
        kept, left_out = [], []
        for item in items:
            file = crc32(item.nodeid.partition("::")[0].encode())
            (kept if file % shares == number % shares else left_out).append(item)
        items[:] = kept
        config.hook.pytest_deselected(items=left_out)


def pytest_terminal_summary(terminalreporter, config):
    if config.option.markexpr == "not slow":
        terminalreporter.write_line(
            'The slow tests of tests/slow.txt are left out: `pytest -m ""` runs all tests.'
        )


def pytest_collection_finish():
    """What is imported stays: to look through it for garbage, again and again, costs a twentieth of
    the time. To look for new garbage after each 700 objects costs as much."""
    gc.freeze()
    gc.set_threshold(20_000)


@pytest.fixture(autouse=True)
def broken_pipes_raise():
    """As Python has it; gmsh leaves behind that they end the process."""
    yield
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)


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
            made[key] = fo.scenes.PunchOnHalfPlane(
                elements=elements, grading=grading, growth=growth
            ).condense()
        return made[key]

    return condensed


@pytest.fixture(scope="session")
def paper_punch(punch):
    """The scene as it is without options, by number of elements."""
    return lambda elements: punch(elements, grading=20.0, growth=1.09)


@pytest.fixture(scope="session")
def rounded(punch):
    """A punch with rounded edges, which the mean load leaves open."""
    contact = punch(24, grading=3)
    return contact.with_gap(20 * np.maximum(np.abs(contact.x) - 0.6, 0.0) ** 2)


@pytest.fixture(scope="session")
def flat():
    """The plane job of CalculiX in the folder of data."""
    return fo.readers.read_calculix(Path(__file__).parent / "data" / "flat")


@pytest.fixture(scope="session")
def cube(tmp_path_factory):
    """The job of CalculiX of two blocks of bricks."""
    folder = tmp_path_factory.mktemp("cube")
    with tarfile.open(Path(__file__).parent / "data" / "cube.tar.xz") as archive:
        # Not `extractall` with a filter, which Python 3.11.2 of Debian 12 does not have.
        for member in archive:
            (folder / member.name).write_bytes(archive.extractfile(member).read())
    return fo.readers.read_calculix(folder / "cube")


@pytest.fixture(scope="module")
def few_starts():
    """Searches of ranges try 8 starts around each end, in place of up to 200: for tests that ask
    for no more than a range."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("frictopt.study.range_search.MOST_AROUND", 8)
        yield


@pytest.fixture
def no_figures_stay_open():
    yield
    import_module("matplotlib.pyplot").close("all")


@pytest.fixture(scope="session")
def quick_data(tmp_path_factory):
    """Folder with the tables of studies at quick size, as far as tests have asked for them; one for
    all processes of a run."""
    folder = tmp_path_factory.getbasetemp()
    folder = (folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder) / "quick"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture(scope="session")
def studies():
    """The studies by the names of their tables."""
    return {
        table.name: study
        for study in import_module("studies.__main__").STUDIES.values()
        for table in study.tables
    }


@pytest.fixture(scope="session")
def quick(quick_data, studies):
    """Gives the tables of studies at quick size, by name; the command of each study is run once."""

    def read(tables):
        for study in {studies[table.name].name: studies[table.name] for table in tables}.values():
            read(study.needs)
            with lock_file(
                str(quick_data / f"{study.name}.lock")
            ):  # another process may be running it
                if not all(table.path(quick_data).exists() for table in study.tables):
                    with (
                        redirect_stdout(StringIO()) as printed,
                        pytest.MonkeyPatch.context() as patch,
                    ):
                        patch.setattr(
                            "frictopt.study.range_search.MOST_AROUND", 8
                        )  # starts around ends, of which 200 take minutes
                        assert study.run(["--quick", "--data", str(quick_data)]) == 0
                    assert all(
                        str(table.path(quick_data)) in printed.getvalue() for table in study.tables
                    )
        return {table.name: pd.read_parquet(table.path(quick_data)) for table in tables}

    return read


@pytest.fixture(scope="session")
def tables(quick, studies):
    """The quick tables of all studies, by name; each is computed or read where a test asks for
    it."""
    named = {table.name: table for study in studies.values() for table in study.tables}

    class Read(dict):
        def __missing__(self, name):
            return self.setdefault(name, quick([named[name]])[name])

    return Read()
