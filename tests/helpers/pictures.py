"""The contents of pictures, for their tests."""

import numpy as np
import pytest
from matplotlib.collections import PathCollection

import frictopt as fo
from helpers.systems import CYCLE, FIRST_PAIR, random_system, system

F = 0.6
PAIR = system(*FIRST_PAIR)
FOUR_CORNERS = fo.LoadCycle(
    {"mean": 1.0}, [{"cyclic": 1.0}, {"other": 1.0}, {"cyclic": -1.0}, {"other": -1.0}]
)
FIVE = random_system(np.random.default_rng(3), 5, ("mean", "cyclic", "other"))
JOINT = fo.ContactSystem.from_blocks(
    FIVE.A,
    FIVE.B,
    FIVE.C,
    FIVE.x,
    FIVE.bonded,
    contact=["left", "left", "right", "right", "right"],
    width=[0.5, 1, 1, 2, 1],
)
CASES = {"two contacts": (JOINT, FOUR_CORNERS), "pair": (PAIR, CYCLE)}
ALL = pytest.mark.parametrize(("contact", "cycle"), CASES.values(), ids=CASES)


def labelled(ax):
    """The lines of a picture by their labels."""
    return {
        line.get_label(): line for line in ax.get_lines() if not line.get_label().startswith("_")
    }


def joined(ax, name, parts=1):
    """Values of the lines of a name on all contacts, one line after another."""
    every = ax.get_lines()
    first = every.index(labelled(ax)[name])
    return tuple(
        np.concatenate(
            [np.asarray(line.get_data()[k], float) for line in every[first : first + parts]]
        )
        for k in (0, 1)
    )


def circles(ax):
    """(M, 3) places and areas of all circles."""
    rows = [np.empty((0, 3))]
    for marks in ax.collections:
        if isinstance(marks, PathCollection):
            places = np.asarray(marks.get_offsets(), float)
            rows.append(np.column_stack([places, np.broadcast_to(marks.get_sizes(), len(places))]))
    return np.concatenate(rows)


def parts(contact):
    return 1 if contact.contact is None else len(set(contact.contact))


def check_ratio(ax, contact, q, p, names, friction=F):
    for name, shear, pressure in zip(names, q, p, strict=True):
        x, ratio = joined(ax, name, parts(contact))
        assert np.array_equal(x, contact.x)
        bound = friction * pressure
        pressed = bound > 1e-9 * friction * np.abs(p).max()
        assert (
            np.allclose(ratio[pressed], (shear / bound)[pressed], rtol=1e-12)
            and np.isnan(ratio[~pressed]).all()
        )
    assert ax.get_ylabel() == "$q / (f p)$"
    assert {
        line.get_ydata()[0]
        for line in ax.get_lines()
        if len(set(line.get_ydata())) == 1 and list(line.get_xdata()) == [0, 1]
    } >= {-1.0, 1.0}


def check_mechanism(ax, motion):
    """Check that each node that moves has a circle on its bound, as large as its share."""
    drawn = circles(ax)
    expected = sorted(zip(motion["x"], -motion["direction"], 400 * motion["share"], strict=True))
    assert np.allclose(sorted(map(tuple, drawn.round(9))), expected, atol=1e-6) and np.isclose(
        drawn[:, 2].sum(), 400
    )
