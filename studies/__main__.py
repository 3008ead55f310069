"""The studies: `python -m studies` lists them, `python -m studies NAME [options]` runs one."""

import sys
from collections.abc import Sequence

from . import (
    damping,
    design,
    dissipation,
    first_look,
    guaranteed,
    increments,
    joint,
    limits,
    range,
    scenes,
    separation,
    size,
    space,
    spatial,
    validity,
    wear,
)
from .tables import Study
from .validation import error_vs_time, followed, left_out
from .validation.extremes import study as extremes
from .validation.fuzz import study as fuzz

_MODULES = (
    *(first_look, limits, scenes, guaranteed, separation, increments, dissipation, range, damping, wear, design),
    *(joint, space, spatial, size, validity, left_out, followed, error_vs_time, extremes, fuzz),
)
STUDIES: dict[str, Study] = {module.STUDY.name: module.STUDY for module in _MODULES}


def main(argv: Sequence[str] | None = None) -> int:
    """List the studies, or run the named one; returns the exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    if arguments and arguments[0] in STUDIES:
        return STUDIES[arguments[0]].run(arguments[1:])
    if arguments and arguments[0] not in ("-h", "--help"):
        print(f"unknown study {arguments[0]!r}; known are {', '.join(STUDIES)}", file=sys.stderr)
        return 2
    print("python -m studies NAME [options]\n")
    for name, study in STUDIES.items():
        print(f"{name:15}{(study.about or '').splitlines()[0]}")
        print(f"{'':15}{' '.join(study.parser().format_usage().split()[5:])}")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
