"""The list of the questions, and how each is asked of a contact in a file.

A question is a public function. The function gets the contact, the load cycle and the friction; all
its other arguments are options.
"""

import argparse
import inspect
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from ..errors import ModelError
from .answers import add_outputs, give
from .inputs import add_cycle, add_friction, add_system, cycle_of, friction_of, joint_of, system_of
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
        The command, its description, and an example of its arguments.
    kinds
        Kind of the answer -> the public function. A command with several kinds has the option
        `--kind`, whose default is the first one.
    picture
        Whether the answer has a picture.
    printed
        Names of the tables that are printed, see `tables_of`.
    """

    name: str
    about: str
    example: str
    kinds: Mapping[str, str]
    picture: bool = True
    printed: tuple[str, ...] = ("rows",)


QUESTIONS = (
    Question(
        "report",
        "a report on a joint under its loads, as text and as one page with pictures",
        f"joint.npz {_CYCLE} --friction .15 --page joint.html",
        {"": "report"},
        picture=False,
        printed=(),
    ),
    Question(
        "limit",
        "a limit of a contact: its load factor, its reason, its table and picture",
        f"joint.npz {_CYCLE} --friction .4 --picture limit.png",
        {
            "shakedown": "shakedown_limit",
            "guaranteed": "guaranteed_limit",
            "onset": "onset",
        },
    ),
    Question(
        "gross-slip",
        "the load factor at which bodies slide off, turn over or lift off as a whole",
        f"joint.npz {_CYCLE} --friction .15",
        {"": "gross_slip"},
        picture=False,
    ),
    Question(
        "steady",
        "the steady state at a load: whether slip stops, and the work of friction per cycle",
        f"joint.npz {_CYCLE} --friction .3 --load-factor 1 --table nodes.csv",
        {"": "steady_state"},
        printed=("contacts", "nodes"),
    ),
    Question(
        "backbone",
        "work, slipping share, slip, stiffness and damping for rising loads",
        f"joint.npz {_CYCLE} --friction .3 --load-factors .5 1 2 --picture backbone.png",
        {"": "joints.backbone_curve"},
    ),
    Question(
        "required-friction",
        "the least coefficient of friction with which the contact can stop slipping",
        f"joint.npz {_CYCLE} --load-factor 1",
        {"": "required_friction"},
    ),
)


def _add_options(question: Question, command: argparse.ArgumentParser) -> None:
    functions = list(question.kinds.values())
    is_report = question.name == "report"
    several = len(functions) > 1
    add_system(command)
    add_cycle(command)
    if "friction" in inspect.signature(public(functions[0])).parameters:
        add_friction(command, scatters=is_report)
    if several:
        kinds = list(question.kinds)
        about = f"kind of the result: {', '.join(kinds)} (default: {kinds[0]})"
        command.add_argument("--kind", choices=kinds, default=kinds[0], help=about)
    add_outputs(command, question.picture)
    if is_report:
        page = "write the report with its pictures: html; --save also writes it as json and xlsx"
        command.add_argument("--page", metavar="FILE", help=page)
    add_options(command, functions, shared=several)
    command.set_defaults(run=partial(_answer, question))


def _answer(question: Question, options: argparse.Namespace) -> int:
    """Ask a question of the contact in a file, and give its answer."""
    kind = getattr(options, "kind", "")
    function = question.kinds[kind]
    arguments = arguments_of(function, options)
    _refuse_options_of_other_kinds(question, kind, arguments, options)
    joint = joint_of(options)
    system = joint.system() if joint else system_of(options.file, options.units)
    if options.keep:
        system.save(options.keep)
    friction = friction_of(options, joint) if hasattr(options, "friction") else None
    cycle = cycle_of(options, joint, friction)
    request: dict[str, Any] = {"command": question.name, "file": str(options.file)}
    if kind:
        request["kind"] = kind
    request |= arguments
    request |= {"mean": dict(cycle.mean), "corners": [dict(corner) for corner in cycle.corners]}
    if friction is not None:
        arguments["friction"] = friction
        request["friction"] = friction
    if joint and question.name == "report":
        arguments = {**joint.of_report, **arguments}
        notes = [arguments.get("notes", ""), *joint.left_out, *joint.model.notes]
        arguments["notes"] = "; ".join(filter(None, notes))
        arguments["model"] = joint.model
    if question.name == "report":
        arguments["file"] = options.file
    request["units"] = system.units
    answer = public(function)(system=system, cycle=cycle, **arguments)
    tables = tables_of(answer, joint.model if joint else None)
    printed = [name for name in question.printed if name in tables]
    return give(options, answer, tables, request, printed)


def _refuse_options_of_other_kinds(
    question: Question, kind: str, ours: Mapping[str, object], options: argparse.Namespace
) -> None:
    """Raise ModelError if an option belongs to another kind of answer."""
    for function in question.kinds.values():
        for name in arguments_of(function, options):
            if name not in ours:
                raise ModelError(
                    f"--{name.replace('_', '-')}: not an option of --kind {kind}; leave it out"
                )


def tables_of(answer: Any, model: Any = None) -> "dict[str, Table]":
    """The tables of an answer by their names; `--table` writes the first one.

    The model, if it is known, gives the forces through ties.
    """
    if hasattr(answer, "fretting_table"):
        nodes = answer.fretting_table()
        more = answer.to_frame().drop(columns="dissipation")
        nodes = nodes.join(more[[name for name in more if name not in nodes]])
        return {"nodes": nodes, "contacts": answer.by_contact(model)}
    if hasattr(answer, "to_frame"):
        return {"rows": answer.to_frame()}
    names = ("numbers", "contacts")
    tables = {name: getattr(answer, name) for name in names if hasattr(answer, name)}
    if getattr(answer, "curve", None) is not None:
        tables["curve"] = answer.curve.to_frame()
    return tables


COMMANDS = tuple(
    Command(question.name, question.about, question.example, partial(_add_options, question))
    for question in QUESTIONS
)
