"""Hooks of pytest: a test is skipped if CalculiX or the library of an extra is missing.

The reason names what is missing. If all libraries are installed, no error of a test becomes a skip.
"""

import ctypes
import doctest
import re
import shutil
from importlib.util import find_spec

import pytest

EXTRAS = (
    "ansys",
    "distributed",
    "gmsh",
    "h5py",
    "ipykernel",
    "loky",
    "matplotlib",
    "meshio",
    "nbclient",
    "openpyxl",
    "pyarrow",
    "pylife",
    "pyvista",
    "pyyeti",
    "xarray",
)
# Found before the first test, because tests hide libraries from the package.
ABSENT = [library for library in EXTRAS if find_spec(library) is None]
# PyVista draws with it where there is no screen.
try:
    ctypes.CDLL("libEGL.so.1")
except OSError:
    ABSENT.append("libEGL")


def skip_if_absent(error):
    """Skip a test whose error has the absence of a library as its cause."""
    while error is not None:
        if isinstance(error, doctest.UnexpectedException):
            error = error.exc_info[1]
        for library in ABSENT:
            if isinstance(error, ImportError) and re.search(rf"\b{library}\b", str(error)):
                pytest.skip(f"{library} is not installed")
        error = error.__cause__ or error.__context__


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item):
    if item.get_closest_marker("ccx") and shutil.which("ccx") is None:
        pytest.skip("CalculiX is not installed: apt-get install calculix-ccx")
    return (yield from pytest_runtest_call(item))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    try:
        return (yield)
    except Exception as error:
        skip_if_absent(error)
        raise


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    """Skip all tests of a file that imports such a library at its head."""
    report = yield
    if report.failed:
        try:
            skip_if_absent(report.call.excinfo.value)
        except pytest.skip.Exception as skip:
            report.outcome = "skipped"
            report.longrepr = str(collector.path), 0, skip.msg
    return report
