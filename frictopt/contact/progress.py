"""Progress of long computations: a bar on a terminal and in a notebook; into a file or a pipe a line every few seconds."""

import io
import sys
import threading
import time
import warnings
from contextlib import suppress
from typing import Any
from weakref import WeakSet

_FIRST, _EVERY = 2.0, 5.0  # seconds before the first line, and between two lines
_unseen: WeakSet[Any] = WeakSet()  # bars that no terminal shows
_lock = threading.Lock()
_teller: threading.Thread | None = None


def bar_of(show: bool, what: str, unit: str, **counts: int) -> Any:
    """A bar of tqdm, to be used in a `with`; without a terminal lines for all bars, without ipywidgets one of text."""
    global _teller
    from tqdm import TqdmWarning  # only long computations need it

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TqdmWarning)  # that ipywidgets is missing
        from tqdm.auto import tqdm
    if not show or sys.stderr is None:
        return tqdm(disable=True)
    if "ipykernel.zmqshell" in sys.modules or sys.stderr.isatty():
        return tqdm(desc=what, unit=unit, disable=False, **counts)
    from tqdm.std import tqdm as plain

    far = "{n_fmt} of {total_fmt}" if "total" in counts else "{n_fmt} so far"
    bar = plain(desc=what, unit=unit, bar_format=f"{{desc}}: {far}, {{elapsed}}", file=io.StringIO(), mininterval=float("inf"), **counts)
    if bar.disable:  # by the variable TQDM_DISABLE
        return bar
    with _lock:
        _unseen.add(bar)
        if _teller is None or not _teller.is_alive():  # also in a process that was forked
            _teller = threading.Thread(target=_tell, daemon=True)
            _teller.start()
    return bar


def _tell() -> None:
    """Lines as long as a bar is under way; from a thread, so that they come also within a step that takes long."""
    global _teller
    wait = _FIRST
    while True:
        time.sleep(wait)
        wait = _EVERY
        with _lock:
            bars = sorted((bar for bar in _unseen if not bar.disable), key=lambda bar: bar.start_t)  # closed ones are disabled
            if not bars:
                _teller = None
                return
        if time.time() - bars[0].start_t >= _FIRST:
            with suppress(OSError, ValueError):  # nobody reads them any more
                print(*bars, sep="; ", file=sys.stderr, flush=True)
