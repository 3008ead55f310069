"""Progress of long computations: a bar on a terminal and in a notebook, else a line every few seconds. And what an interrupt keeps."""

import io
import os
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import Any
from weakref import WeakSet

from .checks import flag

_FIRST, _EVERY, _DRAWN = (
    2.0,
    5.0,
    1.0,
)  # seconds before anything is shown, between two lines, and between two looks of a bar


class _Here(threading.local):
    """The bars of one thread, outer ones first."""

    def __init__(self) -> None:
        self.bars = list[Bar]()


@dataclass(eq=False)
class Bar:
    """How far a computation is, and the best that it has so far. tqdm is asked for when it is shown: quick answers pay nothing for it."""

    what: str
    unit: str
    total: int | None
    done: int
    count: int
    best: Callable[[], str]
    keeps: Callable[[Any], tuple[str, object, str] | None] | None
    shown: bool
    screen: bool
    within: bool
    started: float = field(default_factory=time.time)
    drawn: Any = None

    def update(self, count: int = 1) -> None:
        """So many more are done."""
        self.count += int(count)  # of numpy, too, whose comparisons repeat no text

    def look(self) -> Any:
        """The bar of tqdm, as it is now."""
        if self.drawn is None:
            self.drawn = self._made()
        if not self.drawn.disable:  # by the variable TQDM_DISABLE
            self.drawn.n, self.drawn.bar_format = self.count, self._format
            self.drawn.set_postfix_str(self.best(), refresh=self.screen)
        return self.drawn

    @property
    def _format(self) -> str | None:
        """That of tqdm; None: its own, where the screen shows a share of a known total."""
        if self.total is not None and self.screen:
            return None
        of, units = (
            "" if self.total is None else " of {total_fmt}",
            f" {self.unit}{'s' * (self.count != 1)}" * bool(self.unit),
        )
        return "{desc}: " + f"{{n_fmt}}{of}{units}, " * bool(of or units) + "{elapsed}{postfix}"

    def _made(self) -> Any:
        from tqdm import TqdmWarning

        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore", TqdmWarning
            )  # that ipywidgets is missing: then it is one of text
            from tqdm.auto import tqdm
        if not self.screen:
            from tqdm.std import tqdm
        where: dict[str, Any] = (
            {"leave": not self.within, "dynamic_ncols": True}
            if self.screen
            else {"file": io.StringIO()}
        )
        made = tqdm(
            desc=self.what,
            unit=self.unit or "it",
            total=self.total,
            initial=self.done,
            bar_format=self._format,
            **where,
        )
        made.start_t = self.started
        return made


_here = _Here()
_under_way: WeakSet[Bar] = WeakSet()  # those that are shown, of all threads
_lock = threading.Lock()
_teller: threading.Thread | None = None


@contextmanager
def bar_of(
    show: bool,
    what: str,
    unit: str = "",
    *,
    total: int | None = None,
    done: int = 0,
    at_once: bool = False,
    best: Callable[[], str] = str,
    keeps: Callable[[Any], tuple[str, object, str] | None] | None = None,
    on: tuple[type[BaseException], ...] = (KeyboardInterrupt,),
) -> Iterator[Bar]:
    """The bar of a computation, which counts `unit`s and shows the `best` so far in words. One within another that is not shown is not shown either.

    An interrupt (Ctrl-C), or each error of `on`, gets what `keeps` makes of them: the name of an
    attribute, its value, and a sentence about it. Of bars within each other the outermost one that
    keeps anything does.
    """
    outer = _here.bars[:]
    shown = flag("progress", show) and sys.stderr is not None and all(bar.shown for bar in outer)
    screen = shown and ("ipykernel.zmqshell" in sys.modules or sys.stderr.isatty())
    bar = Bar(what, unit, total, done, done, best, keeps, shown, screen, bool(outer))
    _here.bars.append(bar)
    try:
        if shown:
            _tell_of(bar, at_once)
        yield bar
    except on as error:  # no class of its own: the exit status stays Python's
        if (
            keeps
            and not any(one.keeps and one.keeps(error) for one in outer)
            and (kept := keeps(error))
        ):
            setattr(error, kept[0], kept[1])
            error.add_note(f"{what}: {kept[2]}")
        raise
    finally:
        _here.bars[:] = outer
        with _lock:
            _under_way.discard(bar)
            if bar.drawn is not None and bar.screen:
                bar.look().close()


def _tell_of(bar: Bar, at_once: bool) -> None:
    global _teller
    with _lock:
        if at_once and bar.screen:
            bar.look()
        _under_way.add(bar)
        if _teller is None or not _teller.is_alive():
            _teller = threading.Thread(target=_tell, daemon=True)
            _teller.start()


def _tell() -> None:
    """Show what is under way, as long as anything is; from a thread, so that it is shown also within a step that takes long."""
    global _teller
    wait, line = _FIRST, 0.0
    while True:
        time.sleep(wait)
        wait, now = _DRAWN, time.time()
        with _lock:
            if not _under_way:
                _teller = None
                return
            long = sorted(
                (bar for bar in _under_way if now - bar.started >= _FIRST),
                key=lambda bar: bar.started,
            )
            with suppress(OSError, ValueError):  # nobody reads them any more
                for bar in long:
                    if bar.screen:
                        bar.look()
                lines = [
                    str(look) for bar in long if not (bar.screen or (look := bar.look()).disable)
                ]
                if lines and now >= line:
                    line = now + _EVERY
                    print(*lines, sep="; ", file=sys.stderr, flush=True)


def _forget() -> None:
    """In a process that was forked: the bars are those of the one that it comes from."""
    global _lock, _teller
    _lock, _teller = threading.Lock(), None
    _under_way.clear()
    _here.bars.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget)
