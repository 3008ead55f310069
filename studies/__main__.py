"""All that can be run: `python -m studies` lists it, `python -m studies NAME [options]` runs a study."""

import ast
import re
import sys
from collections.abc import Iterator, Sequence
from importlib import import_module
from math import ceil
from pathlib import Path

from frictopt.base.files import to_its_end

from .tables import Study

_ROOT = Path(__file__).parents[1]
_OF_CONTACTS = "Studies of the paper, of scenes and of joints"
_COMPARED = "Studies that compare with independent answers"
_MODULES = {
    _OF_CONTACTS: """
studies.first_look studies.limits studies.scenes studies.guaranteed studies.separation
studies.moving_areas studies.lift_off studies.vanishing studies.increments studies.dissipation
studies.range studies.fatigue_band studies.damping studies.wear studies.design studies.joint
studies.space studies.spatial studies.size studies.validity studies.flicek studies.published.study
studies.datasets.study
""",
    _COMPARED: """
studies.validation.left_out studies.validation.all_sets studies.validation.followed
studies.validation.forced_response studies.validation.campaign studies.validation.solvers
studies.validation.calculix studies.validation.peers.study studies.validation.error_vs_time.study
studies.validation.extremes.study studies.validation.fuzz.study
""",
}
_KINDS: dict[str, list[Study]] = {
    kind: [import_module(name).STUDY for name in names.split()] for kind, names in _MODULES.items()
}
STUDIES: dict[str, Study] = {study.name: study for studies in _KINDS.values() for study in studies}
# Command -> the file whose first sentence describes it.
PROGRAMS = {
    "Random contacts from given seeds": {
        "python -m studies.validation.moving_areas FIRST COUNT": "studies/validation/moving_areas.py",
        "python -m studies.validation.moving_events FIRST COUNT": "studies/validation/moving_events.py",
        "python -m studies.validation.rest_intervals FIRST COUNT": "studies/validation/rest_intervals.py",
        "python -m studies.validation.area_numbers [SEED [COUNT]]": "studies/validation/area_numbers.py",
    },
    "Benchmarks": {
        "pytest studies/benchmarks": "studies/benchmarks/conftest.py",
        "python studies/benchmarks/answers.py write|compare FILE": "studies/benchmarks/answers.py",
    },
    "Tests, figures and pages": {
        "python tests/tools/mutants.py [FILE ...]": "tests/tools/mutants.py",
        "python -m paper_figures [NAME ...]": "paper_figures/__main__.py",
        "python docs/claims.py": "docs/claims.py",
        "python docs/writeups/build.py [NAME ...]": "docs/writeups/build.py",
    },
}


def time_of(study: Study) -> tuple[str, str]:
    """Minutes that a study takes, and the options of its command, both from the last line of its page."""
    for folder in ("docs/tables", "docs/writeups/tables"):
        page = _ROOT / folder / f"{study.name}.md"
        if page.is_file():
            made = rf"^\*Made by `python -m studies {study.name}(.*?)`, .*, in (\d+) s on "
            found = re.search(made, page.read_text(encoding="utf-8"), re.MULTILINE)
            if found:
                return f"{ceil(int(found[2]) / 60)} min", found[1].strip()
    return "-", ""


def listed() -> Iterator[str]:
    """The lines of the list: each study with its minutes and options, and all other programs."""
    yield "python -m studies NAME [options]; the minutes are those of its table in docs"
    for kind, studies in _KINDS.items():
        yield f"\n{kind}"
        for study in studies:
            minutes, options = time_of(study)
            note = f" The minutes are with {options}." if options else ""
            yield f"{study.name:17}{minutes:>6}  {(study.about or '').splitlines()[0]}{note}"
            yield f"{'':25}{' '.join(study.parser().format_usage().split()[5:])}"
    for kind, programs in PROGRAMS.items():
        yield f"\n{kind}"
        for command, file in programs.items():
            tree = ast.parse((_ROOT / file).read_text(encoding="utf-8"))
            yield command
            yield f"{'':25}{(ast.get_docstring(tree) or '').splitlines()[0]}"


def main(argv: Sequence[str] | None = None) -> int:
    """List the studies, or run the named one; returns the exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    if arguments and arguments[0] in STUDIES:
        return STUDIES[arguments[0]].run(arguments[1:])
    if arguments and arguments[0] not in ("-h", "--help"):
        print(f"unknown study {arguments[0]!r}; known are {', '.join(STUDIES)}", file=sys.stderr)
        return 2
    print("\n".join(listed()))
    return 0


if __name__ == "__main__":
    with to_its_end():
        raise SystemExit(main())
