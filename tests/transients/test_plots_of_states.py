"""Pictures of loads and contacts, and of the behaviour of nodes.

They show the right numbers, on axes with the right labels.
"""

import gc
import io
from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pytest

import frictopt as fo
from helpers.cases import few
from helpers.spatial import random_contact
from helpers.systems import random_system

pytestmark = pytest.mark.usefixtures("no_figures_stay_open")

F = 0.5
PLANE = replace(
    random_system(np.random.default_rng(3), 5),
    contact=["left", "left", "right", "right", "right"],
    width=[0.5, 1.0, 1.0, 2.0, 1.0],
)
SPACE = random_contact(np.random.default_rng(4), 6)


def test_a_contact_at_rest_shows_no_slip_and_no_rounding():
    punch = fo.scenes.PunchOnHalfPlane(elements=20).condense()
    strain = fo.LoadCycle({"P": 1.0}, [{"sigma": 1.0}, {"sigma": -1.0}])
    steady = fo.steady_state(punch, strain, 0.7, load_factor=1.3)
    assert steady.outcome.name == "SHAKEDOWN" and steady.slip.any()
    drawn = [line.get_ydata() for line in steady.plot()[0].get_lines() if line.get_marker() == "."]
    assert len(drawn) == 1 and not np.any(drawn)


def test_a_system_shows_its_points_normals_and_bonded_pressure():
    place, pressure = PLANE.plot()
    assert np.array_equal(np.column_stack(place.get_lines()[0].get_data()), PLANE.points)
    drawn = [line for line in pressure.get_lines() if line.get_marker() == "."]
    values = np.concatenate([line.get_ydata() for line in drawn])
    assert np.array_equal(
        values, np.concatenate([p / PLANE.width for _, p in PLANE.bonded.values()])
    )
    assert pressure.get_ylabel() == "bonded pressure\n(force per area)"
    (points,) = SPACE.plot().get_lines()
    assert np.array_equal(np.transpose(points.get_data_3d()), SPACE.points)
    with pytest.raises(fo.ModelError, match="projection='3d'"):
        SPACE.plot(plt.subplots()[1])


@pytest.mark.parametrize("many", few([5, 7, 1, 2, 3, 4, 6, 8, 9]))
def test_pictures_of_many_contacts_do_not_wait_for_the_garbage_collector(many):
    """Spare panels of a grid must leave nothing behind that a later drawing would meet."""
    square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    n = 4 * many
    points = np.concatenate([square + [3.0 * k, 0.0, float(k)] for k in range(many)])
    # Seen from below, with other names of axes.
    turned = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    frames = np.repeat([turned if k % 3 == 2 else np.eye(3) for k in range(many)], 4, axis=0)
    loads = {"P": np.repeat([0.0, 0.0, 1.0], n), "Q": np.repeat([0.5, 0.0, 0.0], n)}
    names = np.repeat([f"c{k}" for k in range(many)], 4)
    contact = fo.ContactSystem(
        np.eye(3 * n), points, loads, frames=frames, contact=names, width=np.ones(n)
    )
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}])
    options = {"friction": F, "load_factor": 0.5, "steps": 2, "progress": False}
    results = (
        fo.joints.wear(contact, cycle, coefficient=1e-3, cycles=2, **options),
        fo.steady_state(contact, cycle, **options),
    )
    gc.disable()
    try:
        for result in results:
            axes = result.plot()
            np.ravel(axes)[0].figure.savefig(io.BytesIO(), format="png")
    finally:
        gc.enable()
