"""Error against run time of every computation, for several settings of its accuracy, compared with other packages in the same run.

Run with `python -m studies error_vs_time [--quick]`; it writes its tables and prints them in short form. Errors are measured against references
that are independent of the package: closed forms, linear programs and increments in rational arithmetic, elimination in extended precision, and for
the mesh the singular exponents of the corner. Its times depend on the machine. To add a computation: a function that yields its `Question`, called
by `study.questions`.
"""

from ...limits import CORNER
from ...tables import Study
from .parameters import FULL, QUICK, Parameters
from .report import report
from .study import ERROR

__all__ = ["ERROR", "FULL", "QUICK", "STUDY", "Parameters"]

STUDY = Study("studies.validation.error_vs_time", __doc__, "coarse meshes and few settings, in seconds", (ERROR,), report, needs=(CORNER,))
