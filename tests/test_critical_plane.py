"""Multiaxial parameters of a cycle against closed forms, whatever the axes, and from the fields of a contact."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

import frictopt as fo
from frictopt.transients.fretting import critical_planes

E, NU, K, FS, C = 200e3, 0.3, 0.25, 1 / 400.0, 0.35
PULL = np.diag([1.0, 0.0, 0.0])
TWIST = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])


def strain(stress):
    return ((1 + NU) * stress - NU * np.trace(stress, axis1=1, axis2=2)[:, None, None] * np.eye(3)) / E


def parameters(stress, turned=0):
    turn = Rotation.random(random_state=turned).as_matrix()
    stress = turn @ np.array(stress) @ turn.T
    return critical_planes(stress, strain(stress), findley=K, crossland=C, fatemi_socie=FS)


def most(value):
    """Largest value over the angle of the plane, by another search."""
    starts = np.radians(np.arange(0, 180, 5))
    best = starts[np.argmax([value(t) for t in starts])]
    return -minimize_scalar(lambda t: -value(t), bounds=(best - 0.1, best + 0.1), method="bounded", options={"xatol": 1e-10}).fun


@pytest.mark.parametrize("turned", range(3))
def test_reversed_tension_has_its_closed_forms(turned):
    a = 150.0
    found = parameters([a * PULL, 0 * PULL, -a * PULL], turned)
    assert found["SWT"] == pytest.approx(a**2 / E, rel=1e-6) and (found["from"], found["to"]) == pytest.approx((-a, a), rel=1e-6)
    assert found["Findley"] == pytest.approx(a / 2 * (K + np.sqrt(1 + K**2)), rel=1e-6)
    assert found["Crossland"] == pytest.approx(a / np.sqrt(3) + C * a / 3, rel=1e-9)
    expected = most(lambda t: (1 + NU) * a / E * abs(np.sin(2 * t)) * (1 + FS * a * np.cos(t) ** 2))
    assert found["Fatemi_Socie"] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("turned", range(3))
def test_pulsating_tension_counts_its_mean(turned):
    a = 150.0
    found = parameters([a * PULL, 0 * PULL], turned)
    assert found["SWT"] == pytest.approx(a**2 / (2 * E), rel=1e-6)
    assert found["Findley"] == pytest.approx(a / 4 * (2 * K + np.sqrt(1 + 4 * K**2)), rel=1e-6)
    assert found["Crossland"] == pytest.approx(a / (2 * np.sqrt(3)) + C * a / 3, rel=1e-9)


@pytest.mark.parametrize("turned", range(3))
def test_reversed_torsion_has_its_closed_forms(turned):
    a = 100.0
    found = parameters([a * TWIST, -a * TWIST], turned)
    assert found["SWT"] == pytest.approx((1 + NU) * a**2 / E, rel=1e-6)
    assert found["Findley"] == pytest.approx(a * np.sqrt(1 + K**2), rel=1e-6)
    assert found["Crossland"] == pytest.approx(a, rel=1e-9)
    expected = most(lambda t: 2 * (1 + NU) * a / E * abs(np.cos(2 * t)) * (1 + FS * a * abs(np.sin(2 * t))))
    assert found["Fatemi_Socie"] == pytest.approx(expected, rel=1e-6)


def test_compression_that_comes_and_goes_has_no_tension():
    found = parameters([-100.0 * np.eye(3), 0 * PULL])
    assert found["SWT"] == 0 and found["Crossland"] == pytest.approx(0, abs=1e-9) and found["Findley"] == pytest.approx(0, abs=1e-9)


def fields_of(model, steady):
    states = steady.states()
    corners = [np.flatnonzero(states.time <= k + 1e-9)[-1] for k in (1, 2)]
    loads = steady.cycle.at(steady.load_factor)
    return [model.recover(load, states.slip[row], states.gap[row]) for load, row in zip(loads, corners, strict=True)]


def test_the_table_takes_fields_and_the_worst_of_several_cycles():
    model = fo.scenes.PunchOnHalfPlane(elements=8, growth=2.0).model()
    system, cycle = model.condense(), fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    one = fo.steady_state(system, cycle, 0.5, 0.9)
    other = fo.steady_state(system, cycle, 0.5, 0.9, initial_slip=0.3 * np.linspace(-1, 1, 9))
    both = [fields_of(model, one), fields_of(model, other)]
    first, second = (one.fretting_table(fields=each, side=2) for each in both)
    worst = one.fretting_table(fields=both, side=2)
    for name in ("SWT", "Findley", "Fatemi_Socie", "Crossland"):
        assert np.array_equal(worst[name], np.maximum(first[name], second[name]))
    along, extent = (np.array(parts) for parts in zip(*(each.at_contact(2) for each in both[0]), strict=True))
    old = one.fretting_table(stress=along, strain=extent)
    assert (first["SWT"] >= old["SWT"] - 1e-9).all() and not np.allclose(first["Findley"], second["Findley"])
    assert (first["to"] >= first["from"]).all() and first["work"].equals(old["work"])
    stress, strains = (np.array(parts)[:, 3] for parts in zip(*(each.tensors_at_contact(2) for each in both[0]), strict=True))
    assert first["Findley"][3] == critical_planes(stress, strains, findley=0.3, crossland=0.3, fatemi_socie=0.0)["Findley"]
    tresca = np.ptp(np.linalg.eigvalsh(stress[1] - stress[0])) / 4  # without weight: of two states, a quarter of the largest difference of stresses
    assert one.fretting_table(fields=both[0], side=2, findley=0.0)["Findley"][3] == pytest.approx(tresca, rel=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fields": []}, "fields: give fields"),
        ({"fields": [1.0]}, "fields: "),
        ({"fields": [[]]}, "fields: give fields"),
        ({"fields": [[]], "stress": [[0.0] * 4], "strain": [[0.0] * 4]}, "fields, stress: both"),
    ],
)
def test_what_are_no_fields_is_refused(options, message):
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    steady = fo.steady_state(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 1.0)
    with pytest.raises(fo.ModelError, match=message):
        steady.fretting_table(**options)


def test_negative_weights_and_other_contacts_are_refused():
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    fields = [model.recover({"P": 1.0}, np.zeros(5))]
    rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
    steady = fo.steady_state(rod, fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}]), 0.5, 1.0)
    with pytest.raises(fo.ModelError, match="crossland: -1"):
        steady.fretting_table(fields=fields, crossland=-1.0)
    with pytest.raises(fo.ModelError, match="a contact with 5 nodes, this one has 4"):
        steady.fretting_table(fields=fields)
