"""Contact, load cycle and friction from files and arguments."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ModelError

if TYPE_CHECKING:  # commands import what they need, so that `frictopt --help` is quick
    from ..contact import ContactSystem, LoadCycle
    from ..joint_files.joint import Joint


def add_system(command: argparse.ArgumentParser) -> None:
    """The options of a contact in a file."""
    about = "SYSTEM.npz of ContactSystem.save, a deck, or a joint file"
    command.add_argument("file", help=about)
    command.add_argument("--keep", metavar="FILE", help="write the contact of a deck: npz")
    units = "names of the units of force and length, if the file has none, such as 'N, mm'"
    command.add_argument("--units", metavar="NAMES", help=units)


def add_cycle(command: argparse.ArgumentParser) -> None:
    """The options of a load cycle, from corners or from a history."""
    mean = "static load (default: none; for a history, the middle of the range of each load)"
    form = "STATE|CASE=X[,CASE=X]"
    command.add_argument("--mean", metavar=form, help=mean)
    cycle = command.add_mutually_exclusive_group()
    corners = "corners of the load cycle, in their order; of a deck also states of its steps"
    cycle.add_argument("--corners", nargs="+", metavar=form, help=corners)
    cycle.add_argument(
        "--history",
        metavar="FILE",
        help="measured history instead: csv, xlsx or parquet, a column for each load case",
    )
    command.add_argument(
        "--tolerance",
        type=float,
        metavar="X",
        help="noise of the history, as a share of the range of each load case (default: 0)",
    )
    command.add_argument(
        "--time",
        metavar="COLUMN",
        help="column with the time of the history (default: the column named time)",
    )


def add_friction(command: argparse.ArgumentParser, *, scatters: bool) -> None:
    """The option of the coefficient of friction. With `scatters`, it may be a range."""
    friction = "coefficient of friction, one, one per node, or NAME=X per contact"
    read, form = numbers_of, "[NAME=]X[,X]"
    if scatters:
        friction += "; LEAST:NOMINAL:MOST for safety factors with scatter, or a distribution of "
        friction += "scipy.stats for a probability: lognorm:.15:0:.3 is lognorm(.15, 0, .3)"
        read, form = scatter_of, "[NAME=]X[,X]|X:X:X|LAW:X[:X]"
    friction += " (default: that of a deck)"
    part = _named(read)
    command.add_argument("--friction", nargs="+", type=part, metavar=form, help=friction)


def _named(read: Callable[[str], Any]) -> Callable[[str], tuple[str, Any]]:
    """A reader of NAME=X, with the name "" for X alone."""

    def named(text: str) -> tuple[str, Any]:
        name, _, value = text.rpartition("=")
        return name, read(value)

    return named


def joint_of(options: argparse.Namespace) -> Joint | None:
    """The joint of a deck, with its units; None for a contact system."""
    if Path(options.file).suffix.lower() not in (".inp", ".toml"):
        return None
    from ..joint_files.read_joint import read_joint

    joint = read_joint(options.file)
    return replace(joint, units=options.units) if options.units else joint


def system_of(file: str, units: str | None) -> ContactSystem:
    """The contact in a file; `units` names its units if the file does not."""
    from ..contact import ContactSystem

    system = ContactSystem.load(file)
    if units is None or system.units == units:
        return system
    if system.units is not None:
        raise ModelError(
            f"--units: {units!r}, and {file!r} is in {system.units!r}; leave the option out, "
            "because it converts nothing"
        )
    return replace(system, units=units)


def friction_of(options: argparse.Namespace, joint: Joint | None) -> Any:
    """The friction of the options, or of a deck."""
    given = dict(options.friction or {})
    if "" in given:
        if len(options.friction) > 1:
            raise ModelError("--friction: several numbers; give one, or NAME=X for each contact")
        return given[""]
    if joint is not None and any({**joint.friction, **given}.values()):
        return joint.friction_with(given)
    if joint is None and given:
        return given
    raise ModelError("--friction: there is none; give the coefficient of friction")


def cycle_of(options: argparse.Namespace, joint: Joint | None, friction: Any) -> LoadCycle:
    """The load cycle of corners, or of a history."""
    from ..contact import LoadCycle
    from ..study.plans import read_table

    mean = None
    if options.mean and options.history:
        mean = joint.cycle(options.mean, [{}], friction).mean if joint else _loads(options.mean)
    if options.history:
        return LoadCycle.from_history(
            read_table(options.history),
            mean=mean,
            time=options.time,
            tolerance=options.tolerance or 0.0,
        )
    for name in ("tolerance", "time"):
        value = getattr(options, name)
        if value is not None:
            raise ModelError(
                f"--{name}: {value}; only a history has it: leave the option out, or give a "
                "--history"
            )
    if joint is not None:
        return joint.cycle(options.mean, options.corners, friction)
    if not options.corners:
        raise ModelError("--corners: there are none; give the corners, or a --history")
    mean = _loads(options.mean) if options.mean else {}
    return LoadCycle(mean, [_loads(corner) for corner in options.corners])


def _loads(text: str) -> dict[str, float]:
    try:
        return loads_of(text)
    except argparse.ArgumentTypeError as error:
        raise ModelError(f"--mean, --corners: {error}") from error


def loads_of(text: str) -> dict[str, float]:
    """Loads of one corner: "P=1,Q=-0.5"."""
    return _by_names(text, float, "CASE=AMPLITUDE, several with commas between")


def ranges_of(text: str) -> dict[str, Any]:
    """Ranges of amplitudes, distributions, or tightening factors: "P=0.9:1.1,Q=1.6"."""
    form = "CASE=LEAST:MOST or CASE=ALPHA_A, several with commas between"
    return _by_names(text, lambda ends: _scattered(text, ends, (1, 2), form), form)


def _by_names(text: str, read: Callable[[str], Any], form: str) -> dict[str, Any]:
    """The values of NAME=VALUE, several with commas between; each name once."""
    values = dict[str, Any]()
    parts = text.split(",")
    for part in parts:
        name, _, value = part.rpartition("=")
        with suppress(ValueError):
            values[name] = read(value)
    if len(values) < len(parts) or "" in values:
        raise argparse.ArgumentTypeError(f"{text!r}; give {form}")
    return values


def load_of(text: str) -> Any:
    """The range of a load factor, ".8:1.2", or its distribution."""
    return _scattered(text, text, (2,), "LEAST:MOST")


def scatter_of(text: str) -> Any:
    """A number, a list of numbers, a distribution, or a tuple of three, such as ".1:.15:.2"."""
    if ":" not in text:
        return numbers_of(text)
    return _scattered(text, text, (3,), "LEAST:NOMINAL:MOST, or numbers with commas between")


def _scattered(text: str, part: str, counts: Sequence[int], form: str) -> Any:
    """A part of a text: a number or several with colons between, or a distribution.

    "norm:1:0.1" is `scipy.stats.norm(1, 0.1)`.
    """
    from ..study.plans import named_distribution

    family, *parameters = part.split(":")
    try:
        if family.isidentifier():
            return named_distribution(family, family, *map(float, parameters))
        ends = tuple(map(float, part.split(":")))
    except ValueError as error:  # a ModelError is a ValueError
        raise argparse.ArgumentTypeError(
            f"{text!r}: {error}; give {form}, or a distribution of scipy.stats: norm:MEAN:DEVIATION"
        ) from error
    if len(ends) not in counts:
        raise argparse.ArgumentTypeError(f"{text!r}; give {form}")
    return ends if len(ends) > 1 else ends[0]


def numbers_of(text: str) -> Any:
    """A number, or a list of several with commas between."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError as error:
        raise argparse.ArgumentTypeError(
            f"{text!r}; give a number, or several with commas between"
        ) from error
    return numbers[0] if len(numbers) == 1 else numbers
