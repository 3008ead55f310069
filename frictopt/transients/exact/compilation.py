"""How numba compiles the exact path (`kernel.py`) and the sweeps (`increments/sweeps.py`)."""

import sys
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from multiprocessing import parent_process
from typing import Any

from numba import njit
from numba.core.event import Event, Listener, install_listener

# If sums may be taken in any order, they take a tenth of the time.
_OPTIONS = {
    "error_model": "numpy",
    "no_cfunc_wrapper": True,
    "no_rewrites": True,
    "fastmath": {"reassoc", "contract"},
}
# Functions that make no array need no count of the references to arrays. The count takes a ninth
# of the time of the compilation, and a sixth of the time of the path.
_IN_PLACE = {**_OPTIONS, "_nrt": False}


def entry_point(function: Callable[..., Any]) -> Any:
    """Compile a function that Python calls; its machine code is kept on disk if possible.

    It may make arrays.
    """
    return _kept(function, _OPTIONS)


def in_place(function: Callable[..., Any]) -> Any:
    """Compile an entry point that makes no array, and only changes the arrays that it receives."""
    return _kept(function, _IN_PLACE)


def _kept(function: Callable[..., Any], options: Mapping[str, Any]) -> Any:
    try:
        return njit(cache=True, **options)(function)
    except RuntimeError:
        # Numba finds no folder for its cache: package and home are read-only.
        return njit(**options)(function)


inner = njit(no_cpython_wrapper=True, **_OPTIONS)
"""Decorator of functions that only compiled code calls.

A wrapper that lets Python call them would take a fifth of the compilation.
"""

inner_in_place = njit(no_cpython_wrapper=True, **_IN_PLACE)
"""Decorator of functions that only compiled code calls, and that make no array."""

once = njit(no_cpython_wrapper=True, inline="always", **_IN_PLACE)
"""Decorator of functions that one compiled function calls, and that make no array.

If they were compiled by themselves, they would be optimised again in all functions that lead to
them, which takes a third of the compilation.
"""


def notice_of_compilation() -> AbstractContextManager[Any]:
    """While this context is open, a notice on stderr announces the first compilation.

    Workers write no notice. Loading machine code from disk does not count as compilation.
    """
    if parent_process():
        return nullcontext()
    return install_listener("numba:compile", _Notice())  # type: ignore[no-any-return]


class _Notice(Listener):  # type: ignore[misc]  # numba has no types
    """Writes a notice when the first function is compiled."""

    written = False

    def on_start(self, event: Event) -> None:
        """The compilation of a function begins."""
        if not self.written:
            self.written = True
            print(
                "frictopt: compiling the exact path; this takes some seconds, and only once if "
                "its machine code can be stored",
                file=sys.stderr,
                flush=True,
            )

    def on_end(self, event: Event) -> None:
        """The compilation of a function ends."""
