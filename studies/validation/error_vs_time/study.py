"""Error against run time of every computation, compared with other packages in the same run.

Run with `python -m studies error_vs_time [--quick]`; it writes its tables and prints them in short
form. Each computation has several settings of its accuracy. Errors are measured against references
that are independent of the package: closed forms, linear programs and increments in rational
arithmetic, elimination in extended precision, and for the mesh the singular exponents of the
corner. The times depend on the machine. To add a computation, write a function that yields its
`Question`, and call it in `questions`.
"""

from collections.abc import Iterator
from importlib.metadata import version

import pandas as pd
from threadpoolctl import threadpool_limits

from studies.limits import CORNER
from studies.origin import machine
from studies.progress import each
from studies.tables import Study, Table
from studies.validation.error_vs_time import condensation, limits, space, transients
from studies.validation.error_vs_time.methods import RIVALS, Question, absent, measured
from studies.validation.error_vs_time.parameters import FULL, QUICK, Parameters, punch
from studies.validation.error_vs_time.report import report


def questions(parameters: Parameters) -> Iterator[Question]:
    """All comparisons, one computation after the other on each mesh."""
    yield from condensation.questions(parameters)
    for elements in parameters.elements:
        scene = punch(parameters, elements)
        yield from limits.questions(parameters, scene)
        yield from transients.questions(parameters, scene, elements)
        yield from space.questions(parameters, scene, elements)
    for elements in parameters.increment_elements:
        yield from transients.increments(parameters, punch(parameters, elements))
    yield from transients.cylinders(parameters)
    yield space.spheres(parameters)
    yield space.amplitudes(parameters)


def error_against_time(parameters: Parameters) -> pd.DataFrame:
    """One row per question and method.

    Rivals that are not installed are named in `attrs["absent"]`.
    """
    rows = []
    with threadpool_limits(1):
        for question in each(questions(parameters), "error against time"):
            rows += measured(question, parameters.repetitions)
    table = pd.DataFrame(rows)
    missing = absent()
    table.attrs = {
        "machine": f"{machine()}, one thread used",
        "absent": missing,
        "rivals": {name: version(name) for name in RIVALS if name not in missing},
    }
    return table


_ERROR = {
    "computation": "name of the computation",
    "quantity": "quantity whose relative error is measured",
    "scene": "name of the scene; questions on one scene and quantity are the same work",
    "nodes": "node pairs of the interface; 0 where they differ from row to row",
    "method": "name of the method",
    "rival": "package that is called directly, empty for frictopt; solvers get the matrices that frictopt compiles; their answers are not checked",
    "knob": "parameter that controls the accuracy",
    "setting": "value of this parameter",
    "result": "'answer', or the error",
    "error": "relative error, at least 2.2e-16; inf without an answer",
    "residual": "residual that frictopt reports for its answer; NaN for rivals, and for answers that have none",
    "seconds": "processor time, one thread: median of the repetitions; inf without an answer",
    "repetitions": "timed runs, after one that is not timed; fewer if a run takes long, and from 2 s on that one alone",
    "on_front": "no other method is as fast and as accurate, and better in one of the two; errors below 1e-12 count as equal",
    "ahead": "a rival on the front: frictopt has no answer as fast and as accurate",
}
ERROR = Table(
    "error_vs_time",
    "one method with one setting for one question",
    _ERROR,
    full=FULL,
    quick=QUICK,
    compute=error_against_time,
    alone=True,
)
STUDY = Study(
    "studies.validation.error_vs_time",
    __doc__,
    "coarse meshes and few settings, in seconds",
    (ERROR,),
    report,
    needs=(CORNER,),
)
