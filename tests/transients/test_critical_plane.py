"""Multiaxial fatigue parameters of a cycle.

They are compared with closed forms in arbitrary axes, and are evaluated from the fields of a
contact.
"""

import numpy as np
import pandas as pd
import pytest
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

import frictopt as fo
from frictopt.transients.critical_plane import critical_planes
from helpers.cases import few

E, NU, K, FS, C = 200e3, 0.3, 0.25, 1 / 400.0, 0.35
PULL = np.diag([1.0, 0.0, 0.0])
TWIST = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def strain(stress):
    return (
        (1 + NU) * stress - NU * np.trace(stress, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    ) / E


def parameters(stress, turned=0):
    turn = Rotation.random(random_state=turned).as_matrix()
    stress = turn @ np.array(stress) @ turn.T
    states = stress[:, None], strain(stress)[:, None]
    weights = {"SWT": 0.0, "Findley": K, "Fatemi_Socie": FS, "Crossland": C}
    found = critical_planes(*states, weights)
    return {name: values.item() for name, values in found.items()}


def most(value):
    """Largest value over the angle of the plane, by another search."""
    starts = np.radians(np.arange(0, 180, 5))
    best = starts[np.argmax([value(t) for t in starts])]
    return -minimize_scalar(
        lambda t: -value(t),
        bounds=(best - 0.1, best + 0.1),
        method="bounded",
        options={"xatol": 1e-10},
    ).fun


HALF = (1 + NU) / E
# states, SWT, Findley and Crossland in closed form, and Fatemi and Socie's value over the angle of
# the plane
LOADED = {
    "reversed tension": (
        [150.0 * PULL, 0 * PULL, -150.0 * PULL],
        (150.0**2 / E, 75.0 * (K + np.sqrt(1 + K**2)), 150.0 / np.sqrt(3) + C * 50.0),
        lambda t: HALF * 150.0 * abs(np.sin(2 * t)) * (1 + FS * 150.0 * np.cos(t) ** 2),
    ),
    "pulsating tension": (
        [150.0 * PULL, 0 * PULL],
        (150.0**2 / (2 * E), 37.5 * (2 * K + np.sqrt(1 + 4 * K**2)), 75.0 / np.sqrt(3) + C * 50.0),
        lambda t: HALF * 75.0 * abs(np.sin(2 * t)) * (1 + FS * 150.0 * np.cos(t) ** 2),
    ),
    "reversed torsion": (
        [100.0 * TWIST, -100.0 * TWIST],
        (HALF * 100.0**2, 100.0 * np.sqrt(1 + K**2), 100.0),
        lambda t: 2 * HALF * 100.0 * abs(np.cos(2 * t)) * (1 + FS * 100.0 * abs(np.sin(2 * t))),
    ),
}


@pytest.mark.parametrize("turned", few(range(3)))
@pytest.mark.parametrize("load", LOADED)
def test_simple_loads_have_their_closed_forms(load, turned):
    states, (swt, findley, crossland), shear = LOADED[load]
    found = parameters(states, turned)
    assert (found["SWT"], found["Findley"]) == pytest.approx((swt, findley), rel=1e-6)
    assert found["Crossland"] == pytest.approx(crossland, rel=1e-9)
    assert found["Fatemi_Socie"] == pytest.approx(most(shear), rel=1e-6)
    if load == "reversed tension":
        assert (found["from"], found["to"]) == pytest.approx((-150.0, 150.0), rel=1e-6)


def test_compression_that_comes_and_goes_has_no_tension():
    found = parameters([-100.0 * np.eye(3), 0 * PULL])
    assert found["SWT"] == 0
    assert found["Crossland"] == pytest.approx(0, abs=1e-9)
    assert found["Findley"] == pytest.approx(0, abs=1e-9)


def test_pressure_on_every_plane_leaves_no_damage_by_shear_and_none_below_zero():
    held = -2.0 / FS * np.eye(3)
    turning = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    assert (
        parameters([held + 10.0 * TWIST, held + 10.0 * turning, held - 10.0 * TWIST])[
            "Fatemi_Socie"
        ]
        == 0
    )


@pytest.mark.parametrize("seed", [13, 24, 27, 112])
def test_no_plane_is_worse_where_stresses_turn(seed):
    """Loads out of phase have several peaks, some of them nearly as high as the highest peak."""
    rng = np.random.default_rng(seed)
    stress = 100.0 * rng.normal(size=(4, 3, 3))
    stress += stress.swapaxes(1, 2)
    planes = rng.normal(size=(40000, 3))
    planes /= np.linalg.norm(planes, axis=1)[:, None]
    pairs = np.array(np.triu_indices(4, 1)).T

    def on_planes(tensors):
        across = planes @ tensors
        normal = np.sum(across * planes, axis=2)
        along = across - normal[..., None] * planes
        return normal, np.max(
            [np.linalg.norm(along[i] - along[j], axis=1) for i, j in pairs], axis=0
        ) / 2

    (sigma, tau) = on_planes(stress)
    (epsilon, gamma) = on_planes(strain(stress))
    found = parameters(stress)
    tension = sigma.max(axis=0)
    assert np.max(tension * np.ptp(epsilon, axis=0) / 2) <= found["SWT"]
    assert np.max(tau + K * tension) <= found["Findley"]
    assert np.max(2 * gamma * (1 + FS * tension)) <= found["Fatemi_Socie"]


def fields_of(model, steady):
    states = steady.states()
    corners = [np.flatnonzero(states.time <= k + 1e-9)[-1] for k in (1, 2)]
    loads = steady.cycle.at(steady.load_factor)
    return [
        model.recover(load, states.slip[row], states.gap[row])
        for load, row in zip(loads, corners, strict=True)
    ]


def test_the_table_takes_fields_or_their_model():
    model = fo.scenes.PunchOnHalfPlane(elements=8, growth=2.0).model()
    system = model.condense()
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    one = fo.steady_state(system, cycle, 0.5, 0.9)
    other = fo.steady_state(system, cycle, 0.5, 0.9, initial_slip=0.3 * np.linspace(-1, 1, 9))
    both = [fields_of(model, one), fields_of(model, other)]
    first, second = (one.fretting_table(fields=each, side=2) for each in both)
    pd.testing.assert_frame_equal(one.fretting_table(fields=model, side=2), first, rtol=1e-9)
    assert "from, to: least and largest normal stress" in first.attrs["note"]
    assert "from, to" not in one.fretting_table().attrs["note"]
    along, extent = (
        np.array(parts) for parts in zip(*(each.at_contact(2) for each in both[0]), strict=True)
    )
    old = one.fretting_table(stress=along, strain=extent)
    assert (first["SWT"] >= old["SWT"] - 1e-9).all()
    assert not np.allclose(first["Findley"], second["Findley"])
    assert (first["to"] >= first["from"]).all() and first["work"].equals(old["work"])
    stress, strains = (
        np.array(parts)[:, [3]]
        for parts in zip(*(each.tensors_at_contact(2) for each in both[0]), strict=True)
    )
    (findley,) = critical_planes(stress, strains, {"SWT": 0.0, "Findley": 0.3})["Findley"]
    assert first["Findley"][3] == pytest.approx(findley, rel=1e-12)
    # Without weight: of two states, a quarter of the largest difference of stresses.
    tresca = np.ptp(np.linalg.eigvalsh(stress[1, 0] - stress[0, 0])) / 4
    assert one.fretting_table(fields=both[0], side=2, findley=0.0)["Findley"][3] == pytest.approx(
        tresca, rel=1e-6
    )


def test_what_are_no_fields_of_the_contact_is_refused():
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    field = model.recover({"P": 1.0}, np.zeros(5))
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    steady = fo.steady_state(
        rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 1.0
    )
    both = {"fields": [[]], "stress": [[0.0] * 4], "strain": [[0.0] * 4]}
    for options, said in (
        ({"fields": []}, "fields: give fields"),
        ({"fields": [1.0]}, "fields: give fields"),
        ({"fields": 1.0}, "fields: give fields .*or the model itself"),
        ({"fields": [[]]}, "fields: give fields"),
        (both, "fields, stress: both"),
        ({"fields": 2 * [field], "crossland": -1.0}, "crossland: -1"),
        ({"fields": 2 * [field]}, "a contact with 5 nodes, but this contact has 4"),
        ({"fields": [field]}, "at two states of a cycle or more"),
    ):
        with pytest.raises(fo.ModelError, match=said):
            steady.fretting_table(**options)


def test_stresses_of_a_slipping_contact_are_largest_between_corners_too():
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    corners = [{"sigma": -1.0}, {"sigma": 1.0, "Q": 0.2}, {"sigma": 0.3, "Q": -0.2}]
    steady = fo.steady_state(model.condense(), fo.LoadCycle({"P": 1.0}, corners), 0.5, 2.2)
    states = steady.states()
    fields = []
    for amplitudes, slip, gap in zip(states.amplitudes, states.slip, states.gap, strict=True):
        loads = dict(zip(steady.system.bonded, amplitudes, strict=True))
        fields.append(model.recover(loads, slip, gap))
    table = steady.fretting_table(fields=model, side=2)
    every = steady.fretting_table(fields=fields, side=2)
    is_corner = np.abs(states.time - np.round(states.time)) < 1e-9
    at_corners = steady.fretting_table(
        fields=[field for field, is_one in zip(fields, is_corner, strict=True) if is_one], side=2
    )
    for name in ("SWT", "Findley", "Fatemi_Socie", "Crossland"):
        assert table[name].to_numpy() == pytest.approx(every[name].to_numpy(), rel=1e-6)
    assert at_corners["Findley"].max() < 0.99 * table["Findley"].max()
