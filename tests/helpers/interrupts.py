"""Ctrl-C at a place that a test knows: where the progress of a computation has counted so far."""

from contextlib import contextmanager

import pytest

from frictopt.base import Bar


@contextmanager
def stops(what, most, error=KeyboardInterrupt):
    """Stop the computation `what` as its progress counts `most`, whether it is shown or not."""
    count = Bar.update

    def update(bar, more=1):
        count(bar, more)
        if bar.what == what and bar.count >= most:
            raise error("stop")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Bar, "update", update)
        yield


@contextmanager
def interrupted(what, most, error=KeyboardInterrupt):
    """The same; gives the error that reaches the user."""
    with stops(what, most, error), pytest.raises(error) as stopped:
        yield stopped
