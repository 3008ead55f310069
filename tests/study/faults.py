"""Planted faults of `study`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "study/case.py",
        "what is fixed has no part in the keys of a study",
        old=("_digest(system.S, system.gap, self.friction, *reactions, *fixed, *constants)"),
        new="_digest(system.S, system.gap, self.friction, *reactions, *constants)",
        tests="fixed_part",
    ),
    Fault(
        "study/case.py",
        "a study takes runs of another shear strength",
        old=("_digest(system.S, system.gap, self.friction, *reactions, *fixed, *constants)"),
        new="_digest(system.S, system.gap, self.friction, *reactions, *fixed)",
        tests="shear_strength",
    ),
    Fault(
        "study/case.py",
        "overload is not part of a run's key",
        old="start.overload",
        new="None",
        tests="dissipation_study",
        within="Run.key",
    ),
    Fault(
        "study/runs.py",
        "a task follows all its runs",
        old="time.perf_counter() >= end",
        new="False",
        tests="dissipation_study",
    ),
    Fault(
        "study/runs.py",
        "few runs are one task",
        old="ceil(len(self.waiting) / (SETTINGS.most_tasks - len(self.at_work)))",
        new="min(16, len(self.waiting))",
        tests="dissipation_study",
    ),
    Fault(
        "study/store.py",
        "damaged rows count",
        old="checksum == _checksum(values)",
        new="True",
        tests="dissipation_store",
    ),
    Fault(
        "study/runs.py",
        "an interrupt loses what tasks at work have finished",
        old="getattr(error, 'rows', [])",
        new="[]",
        tests="dissipation_store",
    ),
    Fault(
        "study/protocols.py",
        "undecided counts as rest",
        old="UNDECIDED if UNDECIDED in outcomes else REST",
        new="REST",
        tests="protocols",
    ),
    Fault(
        "study/protocols.py",
        "rest above counts for nothing",
        old="self.upper",
        new="np.inf",
        tests="protocols",
    ),
    Fault(
        "study/excursion.py",
        "no sampled slip is smooth",
        old="number % 2 == 0",
        new="False",
        tests="protocols",
    ),
    Fault(
        "study/protocols.py",
        "the bisection goes the wrong way",
        old="if changed(middle):\n    high = middle\nelse:\n    low = middle",
        new="if changed(middle):\n    low = middle\nelse:\n    high = middle",
        tests="protocols",
    ),
    Fault(
        "study/verify.py",
        "slip above the limit counts below it",
        old="self.runs['share'] < 1",
        new="self.runs['share'] < 2",
        tests="guaranteed_transients",
    ),
    Fault(
        "study/range_search.py",
        "descends where it should climb",
        old="sense * (tried.work - orbit.work)",
        new="tried.work - orbit.work",
        tests="dissipation_range",
    ),
)
