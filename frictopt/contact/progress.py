"""Progress of long computations, on a terminal and in a notebook."""

import sys
import warnings
from typing import Any


def bar_of(show: bool, what: str, unit: str, **counts: int) -> Any:
    """A bar of tqdm, to be used in a `with`; in a notebook without ipywidgets one of text."""
    from tqdm import TqdmWarning  # only long computations need it

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TqdmWarning)  # that ipywidgets is missing
        from tqdm.auto import tqdm
    seen = False if "ipykernel.zmqshell" in sys.modules else None  # None: on a terminal
    return tqdm(desc=what, unit=unit, disable=seen if show else True, **counts)
