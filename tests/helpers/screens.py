"""Standard error as a terminal, or as a file, on which progress is shown soon."""

import io
import re
import time
from contextlib import contextmanager, redirect_stderr

import pytest

from frictopt.base import progress


class Terminal(io.StringIO):
    """A terminal; its text is what a user has seen."""

    def isatty(self):
        return True


@contextmanager
def soon():
    """Progress is shown after a hundredth of a second."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(progress, "PACE", progress.Pace(first=0.01, line=0.01, look=0.01))
        yield


def until(log, line):
    """Wait for a line of a log; returns what matches it."""
    end = time.monotonic() + 60
    while not (found := re.search(line, log.getvalue())):
        assert time.monotonic() < end, f"no {line!r} in {log.getvalue()[-300:]!r}"
        time.sleep(0.01)
    return found[0]


def seen(ask):
    """What a terminal shows of a computation, however short: each bar is drawn as it begins."""
    screen, draw = Terminal(), progress._draw
    with pytest.MonkeyPatch.context() as patch, redirect_stderr(screen):
        patch.setattr(progress, "_draw", lambda bar, _: draw(bar, True))
        ask()
    return screen.getvalue()
