"""Planted faults of `base`, see `helpers/planting.py`."""

from helpers.planting import Fault

FAULTS = (
    Fault(
        "base/checks.py",
        "True is a whole number",
        old="bool | np.timedelta64",
        new="np.timedelta64",
        tests="checks",
        within="whole_number",
    ),
    Fault(
        "base/checks.py",
        "one thing is several",
        old="count == 1",
        new="count == 0",
        tests="checks",
        within="number_of",
    ),
    Fault(
        "base/files.py",
        "damaged members are let pass",
        old="archive.testzip()",
        new="None",
        tests="storage",
    ),
    Fault(
        "base/archive.py",
        "the units of a saved table are lost",
        old="table.attrs.update(attrs)",
        new="None",
        tests="copies",
    ),
    Fault(
        "base/archive.py",
        "a contact is written wherever it stands",
        old="id(value) not in self._numbers",
        new="True",
        tests="copies",
    ),
    Fault(
        "base/archive.py",
        "a field that a file lacks is refused",
        old="name not in state and name not in _optional(kind)",
        new="name not in state",
        tests="copies",
    ),
    Fault(
        "base/archive.py",
        "arrays of a file can be written",
        old="array.flags.writeable = False",
        new="pass",
        tests="copies",
    ),
    Fault(
        "base/tolerances.py",
        "inaccurate elimination is let pass",
        old="1000.0 * CONDENSATION",
        new="100000000.0 * CONDENSATION",
        tests="condense condense_matrices contact_model punch studies_extremes",
    ),
    Fault(
        "base/progress.py",
        "an interrupt is swallowed",
        old="raise",
        new="pass",
        tests="progress dissipation_study",
    ),
    Fault(
        "base/progress.py",
        "an interrupt keeps nothing",
        old="setattr(error, attribute, value() if callable(value) else value)",
        new="value",
        tests="progress dissipation_study",
    ),
    Fault(
        "base/progress.py",
        "a bar within a silent one is shown",
        old="flag('progress', show) and sys.stderr is not None and all((bar.shown for bar in outer))",
        new="flag('progress', show) and sys.stderr is not None",
        tests="progress",
    ),
    Fault(
        "base/progress.py",
        "each bar keeps what it has",
        old="any((other.partial is not None for other in outer))",
        new="False",
        tests="progress",
    ),
    Fault(
        "base/progress.py",
        "one of several parts is one part",
        old="self.count if self.total is None else self.total",
        new="self.count",
        tests="progress",
    ),
)
