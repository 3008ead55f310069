"""The functions, files and classes that a reader passes from a question to its answer.

`python tests/tools/functions.py` counts them for the limit, the steady state and the condensed model
of a punch in the plane and in space; `--names` lists them. Before a question is counted, it is
answered for another, smaller contact. So earlier questions do not import or compile anything for
later ones, and each question has a contact of its own. Methods and generators count as functions.
Lambdas and comprehensions are a part of the function around them. Functions that dataclasses
generate or numba compiles are not seen. A class counts if an object of it is an argument or a
result of a counted function. The first number is for the whole call, the number in brackets for the
part before the first program is solved.
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType, FrameType

import frictopt as fo
from frictopt.solve.solvers import run

PACKAGE = Path(fo.__file__).parent
SOLVE = run.__code__


@dataclass
class Count:
    """The functions, files and types of one call."""

    functions: set[CodeType] = field(default_factory=set)
    types: set[type] = field(default_factory=set)
    # The types before the first program goes to its solver.
    before: set[type] | None = None

    @property
    def files(self) -> set[str]:
        return {code.co_filename for code in self.functions}

    def see(self, frame: FrameType, event: str, result: object) -> None:
        code = frame.f_code
        if event == "call" and code is SOLVE and self.before is None:
            self.before = set(self.types)
        if (
            event not in ("call", "return")
            or not code.co_filename.startswith(str(PACKAGE))
            or code.co_name == "<module>"
        ):
            return
        if not code.co_name.startswith("<"):
            self.functions.add(code)
        self.types |= {
            type(value)
            for value in passed(frame, event, result)
            if type(value).__module__.startswith("frictopt")
        }


def passed(frame: FrameType, event: str, result: object) -> Iterator[object]:
    """The arguments or results of a function, and the items of tuples and lists among them."""
    code = frame.f_code
    names = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
    for value in [frame.f_locals.get(name) for name in names] if event == "call" else [result]:
        yield from value if type(value) in (tuple, list) else (value,)


def counted(question: Callable[[], object]) -> Count:
    count = Count()
    sys.setprofile(count.see)
    try:
        question()
    finally:
        sys.setprofile(None)
    return count


def questions(world: str, elements: int) -> dict[str, Callable[[], object]]:
    """The questions about a punch, each with another contact."""
    scene = (
        fo.scenes.PunchOnHalfPlane(elements=elements)
        if world == "plane"
        else fo.scenes.SquarePunch(elements=elements)
    )
    cycle = fo.LoadCycle(mean={"P": 1.0}, corners=[{"sigma": -1.0}, {"sigma": 1.0}])
    load_factor = 1.3 * fo.shakedown_limit(scene.condense(), cycle, 0.7).load_factor
    limit, steady, model = scene.condense(), scene.condense(), scene.model()
    return {
        "shakedown_limit": lambda: fo.shakedown_limit(limit, cycle, friction=0.7),
        "steady_state": lambda: fo.steady_state(
            steady, cycle, friction=0.7, load_factor=load_factor
        ),
        "condense": lambda: model.condense(),
    }


def row(*cells: object) -> str:
    return "".join(f"{cell:>{width}}" for cell, width in zip(cells, (24, 11, 7, 12), strict=True))


def main(names: bool) -> None:
    print(row("question", "functions", "files", "types"))
    for world, elements, fewer in (("plane", 24, 8), ("space", 4, 2)):
        smaller = questions(world, fewer)
        for question, ask in questions(world, elements).items():
            smaller[question]()
            count = counted(ask)
            before = "" if count.before is None else f" ({len(count.before)})"
            print(
                row(
                    f"{question}, {world}",
                    len(count.functions),
                    len(count.files),
                    f"{len(count.types)}{before}",
                )
            )
            if names:
                for file in sorted(count.files):
                    own = sorted(
                        code.co_qualname for code in count.functions if code.co_filename == file
                    )
                    print(f"    {Path(file).relative_to(PACKAGE)}: {', '.join(own)}")
                print(f"    types: {', '.join(sorted(kind.__name__ for kind in count.types))}\n")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--names", action="store_true", help="list functions and types too")
    main(parser.parse_args().names)
