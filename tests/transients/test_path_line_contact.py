"""The exact path of an incomplete contact.

A cylinder is pressed on a half-plane and sheared to and fro (Cattaneo 1938, Mindlin 1949).
"""

import numpy as np
import pytest

import frictopt as fo

CONTACT = fo.reference.LineContact(P=1.3, R=2.0, E_star=2.6 * 4 / np.pi, f=0.3)  # half-width 1
SHARE = 0.75  # of gross sliding: the stick zone ends at half the half-width, on an edge of cells
CYCLE = fo.LoadCycle({"P": CONTACT.P}, [{"Q": 1.0}, {"Q": -1.0}])


def cylinder(nodes):
    return fo.ContactSystem.from_blocks(
        **fo.reference.half_plane_contact(nodes, 1.25, CONTACT.E_star, R=CONTACT.R)
    )


def test_dissipation_converges_to_the_closed_form():
    """Dissipation converges to the closed form with second order in the cell.

    The edges of contact and stick are on edges of cells.
    """
    Q0 = SHARE * CONTACT.f * CONTACT.P
    errors = []
    for nodes in (40, 80, 160):
        steady = fo.steady_state(cylinder(nodes), CYCLE, CONTACT.f, Q0)
        assert steady.outcome is fo.Outcome.CYCLIC_SLIP and steady.residual < 1e-9
        errors.append(abs(steady.dissipation / CONTACT.dissipation(Q0) - 1))
    rates = -np.diff(np.log2(errors))
    assert errors[2] < 5e-4 and np.all((rates > 1.9) & (rates < 2.1))


def test_stick_zone_and_tractions():
    nodes, Q0 = 160, SHARE * CONTACT.f * CONTACT.P
    path = fo.march(cylinder(nodes), CYCLE, CONTACT.f, Q0, cycles=2)
    cell = 2.5 / nodes
    end = np.flatnonzero(path.time == 4.0)[0]
    slipped = path.system.x[path.status[end] != 0][[0, -1]]
    stuck = np.abs(path.system.x[path.status[end] == 0]).max()
    # The outermost are open.
    assert stuck == pytest.approx(CONTACT.stick_half_width(Q0), abs=cell)
    assert np.allclose(np.abs(slipped), 1.25, atol=cell)
    closed = np.abs(path.system.x[path.gap[end] == 0]).max()
    assert closed == pytest.approx(CONTACT.half_width, abs=cell)
    expected = CONTACT.shear(path.system.x, -Q0)
    assert np.abs(path.q[end] / cell - expected).sum() * cell < 0.01 * Q0
    assert path.residual < 1e-9 and np.abs(path.energy_error).max() < 1e-12
