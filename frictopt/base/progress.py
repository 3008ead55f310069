"""Progress of long computations, and what an interrupt keeps of them.

A terminal and a notebook show a bar; elsewhere a line comes every few seconds.
"""

import io
import math
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any
from weakref import WeakSet

from .checks import flag


@dataclass(frozen=True)
class Pace:
    """Times in seconds."""

    # Time before a bar or a line is first shown.
    first: float = 2.0
    # Time between two lines.
    line: float = 5.0
    # Time between two updates of a bar.
    look: float = 1.0


PACE = Pace()


class OutOfTime(Exception):
    """A computation has reached the time limit of a bar around it."""


class _Here(threading.local):
    """The bars of one thread, outer ones first."""

    def __init__(self) -> None:
        self.bars = list[Bar]()


@dataclass(eq=False)
class Bar:
    """Progress of one computation: its count, its best result, and what an interrupt keeps.

    tqdm is imported only if a bar is shown.
    """

    what: str
    unit: str
    total: int | None
    done: int
    shown: bool
    screen: bool
    within: bool
    ends: float
    best: str | Callable[[], str] = ""
    count: int = field(init=False)
    partial: tuple[str, object, str] | None = None
    started: float = field(default_factory=time.time)
    drawn: Any = None

    def __post_init__(self) -> None:
        self.count = self.done

    def update(self, count: int = 1) -> None:
        """Count further units; OutOfTime after the time limit of this bar or an outer one."""
        self.count += int(count)  # `count` may be a numpy integer, which cannot repeat a text.
        if time.monotonic() >= min((bar.ends for bar in _here.bars), default=math.inf):
            raise OutOfTime

    def keep(
        self,
        attribute: str,
        value: object,
        note: str,
        best: str | Callable[[], str] | None = None,
    ) -> None:
        """Set the value that a later interrupt keeps, and the `best` result so far in words.

        The interrupt gets the value as this attribute, and the note. If the value is a function, it
        is called when the interrupt comes. If `best` is a function, it is called when the bar is
        drawn. Call `keep` before `update`.
        """
        self.partial = attribute, value, note
        if best is not None:
            self.best = best

    def look(self) -> Any:
        """Update the bar of tqdm, and return it."""
        if self.drawn is None:
            self.drawn = self._new_drawn()
        if not self.drawn.disable:  # True if the environment variable TQDM_DISABLE is set
            self.drawn.n = self.count
            self.drawn.bar_format = self._format
            best = self.best() if callable(self.best) else self.best
            self.drawn.set_postfix_str(best, refresh=self.screen)
        return self.drawn

    @property
    def _format(self) -> str | None:
        """The format for tqdm; None, which is its default, for a known total on a screen."""
        if self.total is not None and self.screen:
            return None
        counted = "" if self.total is None else " of {total_fmt}"
        if self.unit:
            number = self.count if self.total is None else self.total
            plural = "" if number == 1 else "s"
            counted += f" {self.unit}{plural}"
        if counted:
            counted = f"{{n_fmt}}{counted}, "
        return "{desc}: " + counted + "{elapsed}{postfix}"

    def _new_drawn(self) -> Any:
        options: dict[str, Any] = {"leave": not self.within, "dynamic_ncols": True}
        # Without ipywidgets, tqdm.auto would warn and draw the bar as text.
        if self.screen and find_spec("ipywidgets"):
            from tqdm.auto import tqdm
        else:
            from tqdm.std import tqdm
        if not self.screen:
            options = {"file": io.StringIO()}
        drawn = tqdm(
            desc=self.what,
            unit=self.unit or "it",
            total=self.total,
            initial=self.done,
            bar_format=self._format,
            **options,
        )
        drawn.start_t = self.started
        return drawn


_here = _Here()
_under_way: WeakSet[Bar] = WeakSet()  # the shown bars of all threads
_lock = threading.Lock()
_drawing: threading.Thread | None = None


@contextmanager
def progress_bar(
    show: bool,
    what: str,
    unit: str = "",
    *,
    total: int | None = None,
    done: int = 0,
    at_once: bool = False,
    seconds: float = math.inf,
    on: tuple[type[BaseException], ...] = (KeyboardInterrupt,),
) -> Iterator[Bar]:
    """The bar of a computation, which counts `unit`s and shows the best so far in words.

    A bar inside a hidden bar is hidden. An interrupt (Ctrl-C), or any other error of `on`, gets the
    value that `Bar.keep` has set last. If several nested bars keep a value, the interrupt gets the
    value of the outermost bar. After `seconds` the next `Bar.update` raises OutOfTime.
    """
    outer = _here.bars[:]
    shown = flag("progress", show) and sys.stderr is not None and all(bar.shown for bar in outer)
    screen = shown and ("ipykernel.zmqshell" in sys.modules or sys.stderr.isatty())
    ends = time.monotonic() + seconds
    bar = Bar(what, unit, total, done, shown, screen, within=bool(outer), ends=ends)
    _here.bars.append(bar)
    try:
        if shown:
            _draw(bar, at_once)
        yield bar
    except on as error:  # it keeps its class, so that Python ends with its usual exit status
        _attach(bar, outer, error)
        raise
    finally:
        _here.bars[:] = outer
        with _lock:
            _under_way.discard(bar)
            if bar.drawn is not None and bar.screen:
                bar.look().close()


def _attach(bar: Bar, outer: Sequence[Bar], error: BaseException) -> None:
    """Attach the value that a bar keeps to an interrupt, unless an outer bar keeps a value."""
    if bar.partial is None or any(other.partial is not None for other in outer):
        return
    attribute, value, note = bar.partial
    setattr(error, attribute, value() if callable(value) else value)
    error.add_note(f"{bar.what}: {note}")


def _draw(bar: Bar, at_once: bool) -> None:
    """Show a bar from now on."""
    global _drawing
    with _lock:
        if at_once and bar.screen:
            bar.look()
        _under_way.add(bar)
        if _drawing is None or not _drawing.is_alive():
            _drawing = threading.Thread(target=_draw_bars, daemon=True)
            _drawing.start()


def _draw_bars() -> None:
    """Show the running computations, and end with the last of them.

    This function runs in a thread, so that progress is shown also within a long step.
    """
    global _drawing
    wait = PACE.first
    next_line = 0.0
    while True:
        time.sleep(wait)
        wait = PACE.look
        with _lock:
            if not _under_way:
                _drawing = None
                return
            with suppress(OSError, ValueError):  # nobody reads the lines any more
                lines = _lines()
                now = time.time()
                if lines and now >= next_line:
                    next_line = now + PACE.line
                    print(*lines, sep="; ", file=sys.stderr, flush=True)


def _lines() -> list[str]:
    """Draw the bars on a screen, and return the lines for all other bars."""
    now = time.time()
    lines = list[str]()
    for bar in sorted(_under_way, key=lambda bar: bar.started):
        if now - bar.started >= PACE.first:
            drawn = bar.look()
            if not bar.screen and not drawn.disable:
                lines.append(str(drawn))
    return lines


def _forget() -> None:
    """Forget, in a forked process, the bars of the parent process."""
    global _lock, _drawing
    _lock = threading.Lock()
    _drawing = None
    _under_way.clear()
    _here.bars.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
