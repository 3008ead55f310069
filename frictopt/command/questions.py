"""The list of the questions, and how each is asked of a contact in a file.

A question is a chain of public functions. The first one gets the contact, the load cycle and the
friction; each later one gets the answer before it. All other arguments are options.
"""

import argparse
import inspect
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from .answers import NumberAnswer, add_outputs, give
from .inputs import add_cycle, add_friction, add_mean, add_system, cycle_of, system_of
from .options import Command, add_options, arguments_of, public

if TYPE_CHECKING:  # commands import what they need, so that `frictopt --help` is quick
    from ..base import Table

_CYCLE = "--mean P=1 --corners Q=-1 Q=1"


@dataclass(frozen=True)
class Question:
    """A question of the command line.

    Attributes
    ----------
    name, about, example
        The command, its description, and its options in an example after the name of a file.
    kinds
        Kind of the answer -> the chain of public functions. A command with several kinds has the
        option `--kind`, whose default is the first one.
    picture
        Whether the answer has a picture.
    printed
        Names of the tables that are printed, see `tables_of`.
    number
        Name of the number that the function returns; "" if it returns a result.
    """

    name: str
    about: str
    example: str
    kinds: Mapping[str, tuple[str, ...]]
    picture: bool = True
    printed: tuple[str, ...] = ("rows",)
    number: str = ""

    @property
    def functions(self) -> list[str]:
        """The functions of all kinds."""
        return list(dict.fromkeys(name for chain in self.kinds.values() for name in chain))


def _single(*chain: str) -> dict[str, tuple[str, ...]]:
    return {"": chain}


QUESTIONS = (
    Question(
        "report",
        "a report on a joint under its loads, as text and as one page with pictures",
        f"joint.npz {_CYCLE} --friction .15 --page joint.html",
        _single("report"),
        picture=False,
        printed=(),
    ),
    Question(
        "limit",
        "a limit of a contact: its load factor, its reason, its table and picture",
        f"joint.npz {_CYCLE} --friction .4 --picture limit.png",
        {
            "shakedown": ("shakedown_limit",),
            "guaranteed": ("guaranteed_limit",),
            "onset": ("onset",),
        },
    ),
    Question(
        "gross-slip",
        "the load factor at which bodies slide off, turn over or lift off as a whole",
        f"joint.npz {_CYCLE} --friction .15",
        _single("gross_slip"),
        picture=False,
    ),
    Question(
        "steady",
        "the steady state at a load: whether slip stops, and the work of friction per cycle",
        f"joint.npz {_CYCLE} --friction .3 --load-factor 1 --table nodes.csv",
        _single("steady_state"),
        printed=("contacts", "nodes"),
    ),
    Question(
        "loop",
        "the loop of a load case in the steady state: amplitude against displacement",
        f"joint.npz {_CYCLE} --friction .3 --load-factor 1 --case Q --picture loop.png",
        _single("steady_state", "results.SteadyState.loop"),
    ),
    Question(
        "march",
        "all states of a transient over some cycles",
        f"joint.npz {_CYCLE} --friction .3 --load-factor 1 --cycles 2 --table states.csv",
        _single("march"),
    ),
    Question(
        "backbone",
        "work, slipping share, slip, stiffness and damping for rising loads",
        f"joint.npz {_CYCLE} --friction .3 --load-factors .5 1 2 --picture backbone.png",
        _single("backbone_curve"),
    ),
    Question(
        "response",
        "the approximate response of a mode to harmonic forces near its resonance",
        f"joint.npz {_CYCLE} --friction .3 --natural-frequency 140 --forces .1 .2 --damping .002",
        _single("backbone_curve", "results.BackboneCurve.response"),
    ),
    Question(
        "largest-force",
        "the approximate largest force on a mode whose resonance stays within a limit",
        f"joint.npz {_CYCLE} --friction .3 --natural-frequency 140 --slip-range .005",
        _single("backbone_curve", "results.BackboneCurve.largest_force"),
        picture=False,
        printed=(),
        number="largest_force",
    ),
    Question(
        "wear",
        "the wear of a contact over many load cycles, by Archard's law",
        f"joint.npz {_CYCLE} --friction .3 --load-factor 1 --coefficient 1e-8 --cycles 1e6",
        _single("wear"),
    ),
    Question(
        "required-friction",
        "the least coefficient of friction with which the contact can stop slipping",
        f"joint.npz {_CYCLE} --load-factor 1",
        _single("required_friction"),
    ),
    Question(
        "safe-slip",
        "the residual slip with the largest margin at a load",
        f"joint.npz {_CYCLE} --friction .4 --load-factor 1",
        _single("safe_slip"),
    ),
    Question(
        "least-slip",
        "the least slip per cycle above the shakedown limit",
        f"joint.npz {_CYCLE} --friction .4 --load-factor 3",
        _single("shakedown_limit", "results.ShakedownLimit.least_slip"),
        picture=False,
    ),
    Question(
        "safe-region",
        "the amplitudes of two loads that vary independently and leave a safe residual slip",
        "joint.npz --mean P=1 --loads Q R --friction .4 --picture region.png",
        _single("safe_region"),
    ),
    Question(
        "after-overload",
        "the guaranteed limit for slips up to the largest slip of one overload",
        f"joint.npz {_CYCLE} --friction .4",
        _single("guaranteed_limit", "after_overload"),
    ),
    Question(
        "range",
        "the least and the largest work of friction over all residual slips at the beginning",
        f"joint.npz {_CYCLE} --friction .3 --load-factor 1",
        _single("dissipation_range"),
    ),
    Question(
        "protocol",
        "the load factor up to which the contact comes to rest after some loads",
        f"joint.npz {_CYCLE} --friction .3 --protocol P=.2 --start worst",
        _single("limit_after_protocol"),
    ),
)


def _parameters(question: Question) -> list[str]:
    """Names of the parameters of the first function of each chain."""
    first = [chain[0] for chain in question.kinds.values()]
    return [name for function in first for name in inspect.signature(public(function)).parameters]


def _add_options(question: Question, command: argparse.ArgumentParser) -> None:
    parameters = _parameters(question)
    add_system(command)
    if "cycle" in parameters:
        add_cycle(command)
    else:
        add_mean(command)
    if "friction" in parameters:
        add_friction(command, scatters=question.name == "report")
    several = len(question.kinds) > 1
    if several:
        kinds = list(question.kinds)
        about = f"kind of the result: {', '.join(kinds)} (default: {kinds[0]})"
        command.add_argument("--kind", choices=kinds, default=kinds[0], help=about)
    add_outputs(command, question.picture, save=not question.number)
    if question.name == "report":
        page = "write the report with its pictures: html"
        command.add_argument("--page", metavar="FILE", help=page)
    add_options(command, question.name, question.functions, shared=several)
    command.set_defaults(run=partial(_answer, question))


def _answer(question: Question, options: argparse.Namespace) -> int:
    """Ask a question of the contact in a file, and give its answer."""
    kind = getattr(options, "kind", "")
    chain = question.kinds[kind]
    _refuse_options_of_other_questions(question, chain, kind, options)
    system = system_of(options.file, options.units)
    request: dict[str, Any] = {"command": question.name, "file": str(options.file)}
    if kind:
        request["kind"] = kind
    answer: Any = None
    for number, name in enumerate(chain):
        arguments = arguments_of(name, options)
        request |= arguments
        if number == 0:
            arguments |= _inputs(name, options, system, request)
            if "protocol" in arguments:
                arguments["protocol"] = _steps(arguments["protocol"])
            answer = public(name)(**arguments)
        else:
            answer = public(name)(answer, **arguments)
    if question.number:
        answer = NumberAnswer(question.number, answer)
    request["units"] = system.units
    tables = tables_of(answer)
    printed = [name for name in question.printed if name in tables]
    return give(options, answer, tables, request, printed)


def _inputs(
    function: str, options: argparse.Namespace, system: Any, request: dict[str, Any]
) -> dict[str, Any]:
    """Contact, load cycle and friction for a function; what can be written goes to `request`."""
    parameters = inspect.signature(public(function)).parameters
    inputs: dict[str, Any] = {"system": system}
    if "cycle" in parameters:
        cycle = cycle_of(options)
        inputs["cycle"] = cycle
        request |= {"mean": dict(cycle.mean), "corners": [dict(corner) for corner in cycle.corners]}
    if "mean" in parameters:
        inputs["mean"] = options.mean or {}
        request["mean"] = inputs["mean"]
    if "friction" in parameters:
        inputs["friction"] = options.friction
        request["friction"] = options.friction
    return inputs


def _steps(protocol: Iterable[Mapping[str, float]]) -> list[Any]:
    from ..study.starts import LoadStep

    return [LoadStep(loads) for loads in protocol]


def _refuse_options_of_other_questions(
    question: Question, chain: Sequence[str], kind: str, options: argparse.Namespace
) -> None:
    """ModelError if an option belongs to another kind of the answer."""
    ours = {name for function in chain for name in arguments_of(function, options)}
    for function in question.functions:
        for name in arguments_of(function, options):
            if name not in ours:
                raise ModelError(
                    f"--{name.replace('_', '-')}: not an option of --kind {kind}; leave it out"
                )


def tables_of(answer: Any) -> "dict[str, Table]":
    """The tables of an answer by their names; the first one is that of its file."""
    if hasattr(answer, "fretting_table"):
        nodes = answer.fretting_table()
        more = answer.to_frame().drop(columns="dissipation")
        nodes = nodes.join(more[[name for name in more if name not in nodes]])
        return {"nodes": nodes, "contacts": answer.by_contact()}
    if hasattr(answer, "to_frame"):
        return {"rows": answer.to_frame()}
    names = ("runs", "numbers", "contacts")
    tables = {name: getattr(answer, name) for name in names if hasattr(answer, name)}
    if getattr(answer, "curve", None) is not None:
        tables["curve"] = answer.curve.to_frame()
    return tables


COMMANDS = tuple(
    Command(question.name, question.about, question.example, partial(_add_options, question))
    for question in QUESTIONS
)
