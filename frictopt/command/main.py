"""Run a command: its options, its warnings, and its exit code.

Exit codes: 0 an answer, 2 bad input, 3 no answer, 4 a file that cannot be read or written, or a
missing package, 130 interrupted (Ctrl-C, SIGTERM), 141 nobody read the output to its end
(`| head`).
"""

import argparse
import atexit
import signal
import sys
import warnings
from collections.abc import Sequence
from pathlib import Path

from .. import __version__
from ..base.files import TABLES, output, strict_json, to_its_end
from ..errors import FrictoptError, ModelError, StoreError
from . import files, questions, studies
from .answers import ExitCode, partial_answer
from .options import Command

_EPILOG = """exit codes: 0 an answer; 2 bad input; 3 no answer, such as a limit that is nan;
4 a file that cannot be read or written, or a missing package; 130 interrupted;
141 the reader of the output stopped.
`frictopt COMMAND --help` lists the options of a command, with an example."""

# Arguments that name an output file -> the allowed endings; without endings, any ending is allowed.
_OUTPUTS: dict[str, tuple[str, ...]] = {
    "table": TABLES,
    "picture": (),
    "save": (),
    "page": (".html",),
    "keep": (".npz",),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    with_json = False
    try:
        with to_its_end():
            options = parser(words).parse_args(words)
            with_json = getattr(options, "json", False)
            options.warnings = list[str]()
            _check_files(options)
            with warnings.catch_warnings():
                warnings.showwarning = lambda message, *_: _warn(options, str(message))
                return int(options.run(options) or 0)
    except KeyboardInterrupt as interrupt:
        notes = partial_answer(interrupt, with_json)
        print("frictopt: interrupted", *notes, sep="\n", file=sys.stderr)
        # While Python ends, a second Ctrl-C would end it with another status.
        atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
        return ExitCode.INTERRUPTED
    except (FrictoptError, OSError, ImportError) as error:
        code = _exit_code(error)
        print(f"frictopt: error: {error}", file=sys.stderr)
        if with_json:
            print(strict_json({"error": str(error), "exit_code": code}))
        return code


def _warn(options: argparse.Namespace, message: str) -> None:
    options.warnings.append(message)
    print(f"frictopt: warning: {message}", file=sys.stderr)


def _exit_code(error: Exception) -> int:
    of_file = isinstance(error, StoreError) or isinstance(error.__cause__, OSError)
    if of_file or not isinstance(error, FrictoptError):
        return ExitCode.BAD_FILE
    return ExitCode.BAD_INPUT if isinstance(error, ModelError) else ExitCode.NO_ANSWER


def _check_files(options: argparse.Namespace) -> None:
    """Check the files to be read and to be written before anything is computed."""
    for name in ("file", "history"):
        file = getattr(options, name, None)
        if file and not Path(file).exists():
            raise FileNotFoundError(f"there is no file {file!r}; give its path")
    for name, endings in _OUTPUTS.items():
        file = getattr(options, name, None)
        if file:
            setattr(options, name, output(file, *endings))


def commands() -> tuple[Command, ...]:
    """All commands, in the order of `frictopt --help`."""
    return (files.LOOK, *questions.COMMANDS, *studies.COMMANDS, *files.COMMANDS)


def parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """The parser of all commands; only a command that is among the words gets its options.

    The options of a question come from its function, which is slow to import.
    """
    whole = argparse.ArgumentParser(
        prog="frictopt",
        description="Decides whether a frictional contact will stop slipping.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    whole.add_argument("--version", action="version", version=f"frictopt {__version__}")
    subparsers = whole.add_subparsers(required=True, metavar="COMMAND")
    chosen = next((word for word in words if not word.startswith("-")), None)
    for command in commands():
        options = subparsers.add_parser(
            command.name,
            help=command.about,
            description=command.about,
            epilog=f"example: frictopt {command.name} {command.example}",
        )
        if command.name == chosen:
            command.add_options(options)
    return whole
