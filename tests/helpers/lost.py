"""Starts of runs that end, hold or fill their process, for tests of studies in processes."""

import os
import signal
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import frictopt as fo
from frictopt.study.starts import Start
from helpers.systems import CYCLE, random_system

CONTACT = random_system(np.random.default_rng(3), 3)


@dataclass(frozen=True, eq=False)
class Kills(Start):
    """Kills its process, at most `times` times; the file counts them."""

    file: str = field(default="", repr=False)
    times: int = 1

    def slip_at(self, *args, **options):
        kills = Path(self.file)
        done = len(kills.read_bytes()) if kills.exists() else 0
        if done < self.times:
            kills.write_bytes(b"x" * (done + 1))
            os.kill(os.getpid(), signal.SIGKILL)
        return super().slip_at(*args, **options)


@dataclass(frozen=True, eq=False)
class Holds(Start):
    """Never ends; the file has the number of its process."""

    file: str = field(default="", repr=False)

    def slip_at(self, *_args, **_options):
        Path(self.file).write_text(str(os.getpid()))
        time.sleep(1e6)


@dataclass(frozen=True, eq=False)
class Fills(Start):
    """Needs more memory than there is."""

    def slip_at(self, *_args, **_options):
        return np.zeros(2**57)


def study(starts, **options):
    return fo.dissipation_study(CONTACT, CYCLE, 0.4, [1.0], starts, progress=False, **options)
