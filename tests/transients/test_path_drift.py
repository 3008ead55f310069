"""A body that nothing guides rolls a little in every cycle.

The answers about this drift are compared with the march of all cycles.
"""

import re

import numpy as np
import pytest
from skfem import MeshQuad

import frictopt as fo
from helpers.paths import followed

CYCLE = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
FRICTION, LOAD_FACTOR = 0.5, 1.0


@pytest.fixture(scope="module")
def rolling():
    """A parabolic pad that is pushed to and fro above its contact on a block.

    The mesh of the pad is a little to one side.
    """
    radius = 50.0
    across = np.sinh(np.linspace(-3, 3, 21)) / np.sinh(3) * 6
    up = np.linspace(0, 1, 7) ** 1.5
    across = across + 0.03 * (1 - (across / 6) ** 2)
    pad = MeshQuad.init_tensor(across, up).with_boundaries(
        {"arc": lambda x: x[1] == 0, "top": lambda x: x[1] == 1}
    )
    arc = pad.p[0] ** 2 / (2 * radius)
    pad = MeshQuad(np.array([pad.p[0], arc + pad.p[1] * (8 - arc)]), pad.t).with_boundaries(
        pad.boundaries
    )
    block = MeshQuad.init_tensor(np.r_[-15, -10, across, 10, 15], -10 * up[::-1])
    block = block.with_boundaries({"top": lambda x: x[1] == 0, "bottom": lambda x: x[1] == -10})
    steel = fo.fem.Material(E=210e3)
    loads = {
        "P": [fo.fem.Traction("pad", "top", y=-200 / 12)],
        "Q": [fo.fem.Traction("pad", "top", x=10 / 12)],
    }
    bodies = {"pad": fo.fem.Body(pad, steel), "block": fo.fem.Body(block, steel)}
    return fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("block", "bottom")],
        loads,
        [fo.fem.Contact("pad", "block", "arc", "top", gap="measured")],
    ).condense()


def drifts(contact, cycles):
    """Slip and gap after each cycle, and the slip scale."""
    path = followed(contact, CYCLE, FRICTION, LOAD_FACTOR)
    states = []
    for _ in range(cycles):
        path.follow(path.segments)
        states.append(path.state.u.copy())
    return np.array(states), path.length


def test_a_drift_that_does_not_end_is_named(rolling):
    most = 400
    with pytest.raises(fo.NoContinuation, match="guide it by a Support") as caught:
        fo.steady_state(rolling, CYCLE, FRICTION, LOAD_FACTOR, most_cycles=most)
    numbers = re.search(r"within (\d+) of .* changes by (\S+) slip", str(caught.value)).groups()
    cycle, change = (float(number) for number in numbers)
    states, length = drifts(rolling, most + 1)
    steps = np.abs(np.diff(states, axis=0)).max(axis=1) / length
    assert change == pytest.approx(steps[int(cycle) - 1], rel=0.03)
    assert "allow more" not in str(caught.value)
