"""The studies: `python -m studies` lists them, `python -m studies NAME [options]` runs one."""

import sys
from collections.abc import Sequence
from importlib import import_module

from frictopt.base.files import to_its_end

from .tables import Study

_MODULES = """
studies.first_look studies.limits studies.scenes studies.guaranteed studies.separation studies.moving_areas
studies.lift_off studies.vanishing studies.increments studies.dissipation studies.range
studies.damping studies.wear studies.design studies.joint studies.space studies.spatial
studies.size studies.validity studies.flicek studies.published.study studies.datasets.study
studies.validation.left_out studies.validation.all_sets studies.validation.followed
studies.validation.forced_response studies.validation.campaign studies.validation.solvers
studies.validation.calculix studies.validation.peers.study studies.validation.error_vs_time.study
studies.validation.extremes.study studies.validation.fuzz.study
"""
STUDIES: dict[str, Study] = {
    study.name: study for study in (import_module(name).STUDY for name in _MODULES.split())
}


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
        print(f"{name:17}{(study.about or '').splitlines()[0]}")
        print(f"{'':17}{' '.join(study.parser().format_usage().split()[5:])}")
    return 0


if __name__ == "__main__":
    with to_its_end():
        raise SystemExit(main())
