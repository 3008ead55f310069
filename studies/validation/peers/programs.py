"""Peers run in other processes: the Python that has them, their versions, and their answers."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

OUTSIDE = Path(__file__).parent / "outside"


@dataclass(frozen=True)
class Peer:
    """A code that runs in another Python.

    Attributes
    ----------
    name
        Its name in the table.
    module
        The module that a Python must be able to import.
    package
        The name of its package, on PyPI or on Debian.
    install
        The command that installs it.
    """

    name: str
    module: str
    package: str
    install: str


TAMAAS = Peer("tamaas", "tamaas", "tamaas", "pip install tamaas==2.9.0")
KRATOS = Peer(
    "Kratos",
    "KratosMultiphysics.ContactStructuralMechanicsApplication",
    "KratosMultiphysics",
    "pip install KratosContactStructuralMechanicsApplication==10.4.4 "
    "KratosLinearSolversApplication==10.4.4",
)
SICONOS = Peer("Siconos", "siconos.numerics", "python3-siconos", "apt-get install python3-siconos")
GETFEM = Peer("GetFEM", "getfem", "python3-getfem", "apt-get install python3-getfem")
PEERS = (TAMAAS, KRATOS, SICONOS, GETFEM)


class NoAnswer(Exception):
    """A peer is not installed, fails, or takes too long; the text is the reason."""


@dataclass(frozen=True)
class Pythons:
    """The Python interpreters that may have peers, in the order in which they are tried."""

    paths: tuple[str, ...] = field(default_factory=lambda: known_pythons())

    def with_peer(self, peer: Peer) -> str:
        """The first interpreter that imports the peer.

        Raises
        ------
        NoAnswer
            No interpreter imports it.
        """
        for python in self.paths:
            if _imports(python, peer.module):
                return python
        raise NoAnswer(f"not installed ({peer.install})")

    def version(self, peer: Peer) -> str:
        """Version of the package of a peer; empty if it is not installed."""
        try:
            python = self.with_peer(peer)
        except NoAnswer:
            return ""
        asked = f"import importlib.metadata as m; print(m.version({peer.package!r}))"
        said = _run([python, "-c", asked], "", 60.0)
        if said.returncode == 0:
            return said.stdout.split()[-1]
        query = ["dpkg-query", "--show", "--showformat=${Version}", peer.package]
        return _run(query, "", 60.0).stdout.strip() if shutil.which("dpkg-query") else ""

    def answer(self, peer: Peer, asked: Mapping[str, Any], seconds: float) -> dict[str, Any]:
        """The answer of a peer's program to a question; question and answer are JSON.

        Raises
        ------
        NoAnswer
            The peer is not installed, its program fails, or it runs for more than `seconds`.
        """
        python = self.with_peer(peer)
        program = OUTSIDE / f"{peer.name.lower()}_peer.py"
        try:
            said = _run([python, str(program)], json.dumps(asked), seconds)
        except subprocess.TimeoutExpired:
            raise NoAnswer(f"no answer in {seconds:g} s") from None
        if said.returncode:
            lines = said.stderr.strip().splitlines() or [f"exit status {said.returncode}"]
            raise NoAnswer(lines[-1][:100])
        # Peers print banners and tables of their iterations; the answer is the last line.
        return dict(json.loads(said.stdout.strip().splitlines()[-1]))


def known_pythons() -> tuple[str, ...]:
    """The Python of this process, and the Python of the system, which sees packages of the system."""
    system = shutil.which("python3", path=os.defpath)
    return (sys.executable, *([system] if system else []))


@cache
def _imports(python: str, module: str) -> bool:
    """Whether a Python imports a module."""
    try:
        return _run([python, "-c", f"import {module}"], "", 120.0).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def _run(command: Sequence[str], text: str, seconds: float) -> "subprocess.CompletedProcess[str]":
    """Run a command with one thread, without the folders of modules of this process."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    return subprocess.run(
        command,
        input=text,
        env=environment | threads,
        capture_output=True,
        text=True,
        timeout=seconds,
    )
