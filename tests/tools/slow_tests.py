"""A plugin of pytest that measures all tests, and writes the list of slow tests, `tests/slow.txt`.

Run with `python -m pytest -n auto --dist worksteal -m "" -p tests.tools.slow_tests`. The cost of a
test is its processor time with that of its processes. Other work on the machine raises all costs,
but hardly changes their order. The default run of pytest leaves the listed tests out. These are

- the dearest third of each room, without tests below half the mean cost of all tests, and
- all tests of a fixture that computes for several tests, because the cost of such a fixture falls on
  the test that happens to be the first or the last one.

If a planted fault names its tests (`tests/ROOM/faults.txt`), the cheapest of them is never listed.
A fault that only one test finds therefore names this test, and not its whole file.
"""

import os
import resource
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

import pytest

from .mutants import FAULTS, ROOT, test_files

LIST = ROOT / "tests" / "slow.txt"
# The part of the tests of a room that is left out.
SHARE = 1 / 3
# Fixtures that compute for several tests: tables of studies, and commands in a process.
TOGETHER = {"quick", "typed"}

BEGIN = pytest.StashKey[float]()


def processor_time() -> float:
    """Seconds of this process and of its ended processes."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(part.ru_utime + part.ru_stime for part in used)


def slow_tests(
    costs: Mapping[str, float], together: Iterable[str], faults: Iterable[Iterable[str]]
) -> list[str]:
    """The tests that the default run leaves out.

    Parameters
    ----------
    costs
        The seconds of each test.
    together
        Tests of fixtures that compute for several tests.
    faults
        For each planted fault, the tests that should find it.
    """
    rooms = defaultdict(list)
    for test in costs.keys() - set(together):
        rooms[Path(test).parts[:2]].append(test)
    mean = sum(costs.values()) / len(costs)
    listed = set(together)
    for tests in rooms.values():
        tests.sort(key=lambda test: (-costs[test], test))
        dearest = tests[: int(SHARE * len(tests))]
        listed.update(test for test in dearest if costs[test] > mean / 2)
    for tests in faults:
        left = list(tests)
        if left and listed.issuperset(left):
            listed.remove(min(left, key=lambda test: (costs[test], test)))
    return sorted(listed)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item):
    item.stash[BEGIN] = processor_time()
    return (yield)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_makereport(item, call):
    if call.when == "teardown":
        # Properties travel with the report from the process of the test to the one that writes.
        together = not TOGETHER.isdisjoint(item.fixturenames)
        item.user_properties.append(("cost", (processor_time() - item.stash[BEGIN], together)))


class _Costs:
    """What the reports of a run say, in the process that writes the list."""

    def __init__(self):
        self._costs, self._together = {}, []

    def pytest_runtest_logreport(self, report):
        for name, value in report.user_properties:
            if name == "cost" and report.when == "teardown":
                self._costs[report.nodeid], together = value
                self._together += [report.nodeid] if together else []

    def pytest_sessionfinish(self):
        faults = []
        for fault in FAULTS:
            names = test_files(fault, ROOT)
            faults.append(
                [
                    test
                    for test in self._costs
                    if any(
                        test == name or test.startswith((f"{name}::", f"{name}[")) for name in names
                    )
                ]
            )
        listed = slow_tests(self._costs, self._together, faults)
        LIST.write_text("".join(f"{test}\n" for test in listed), encoding="utf-8")
        left = sum(self._costs[test] for test in self._costs.keys() - set(listed))
        print(
            f"\n{LIST}: {len(listed)} of {len(self._costs)} tests; the others take {left:.0f} of "
            f"{sum(self._costs.values()):.0f} processor seconds"
        )


def pytest_configure(config):
    if "PYTEST_XDIST_WORKER" not in os.environ:
        config.pluginmanager.register(_Costs())
