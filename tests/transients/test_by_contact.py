"""The behaviour of each contact in a steady cycle.

It is compared with equilibrium of the body of the contact, and with the table of its nodes.
"""

import numpy as np
import pytest

import frictopt as fo
from helpers.meshes import rotation, traction, wedge
from helpers.paths import ASKED, ROUND


def loaded_wedge(angle):
    """A wedge between two jaws under pressure and shear on top, without fits."""
    loads = {
        "P": [traction(angle, "wedge", "top", y=-1.0)],
        "Q": [traction(angle, "wedge", "top", x=1.0)],
    }
    return wedge(angle, loads=loads).condense()


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_the_forces_on_both_flanks_of_a_wedge_balance_its_loads(angle):
    system = loaded_wedge(angle)
    cycle = fo.LoadCycle({"P": 1.0}, [{"Q": 0.5}, {"Q": -0.6}, {"P": 0.3}])
    steady = fo.steady_state(system, cycle, 0.2, 1.5)
    table = steady.by_contact()
    top = 1.0 + 2 / np.tan(np.pi / 3)  # its length
    frames = [system.frames[system.contact == name][0] for name in table["contact"]]
    for corner, loads in enumerate(cycle.at(1.5)):
        forces = [[one[f"Q_{corner}"], one[f"P_{corner}"]] for one in table.to_dict("records")]
        resultant = sum(
            np.array(force) @ frame for force, frame in zip(forces, frames, strict=True)
        )
        assert rotation(angle).T @ resultant == pytest.approx(
            -top * np.array([loads.get("Q", 0.0), -loads["P"]]), abs=1e-9
        )
        assert table[f"fP_{corner}"].to_numpy() == pytest.approx(0.2 * table[f"P_{corner}"])
    assert steady.outcome is fo.Outcome.CYCLIC_SLIP
    assert table.attrs["corners"] == list(cycle.corner_names)
    # The flanks are one high.
    assert table["area"].to_numpy() == pytest.approx([1 / np.sin(np.pi / 3)] * 2)
    assert table[["sticking", "slipping", "open"]].sum(axis=1).to_numpy() == pytest.approx(
        [1.0, 1.0]
    )
    lifted = system.width * (steady.open & ~steady.slipping)
    assert table["open"] @ table["area"] == pytest.approx(lifted.sum())
    assert lifted.any()
    assert (table["sticking"] > 0).all()
    nodes = steady.fretting_table().groupby("contact", sort=False)
    assert table["work"].to_numpy() == pytest.approx(nodes["work"].sum())
    assert table["work"].sum() == pytest.approx(steady.dissipation)
    assert table["slip_range"].to_numpy() == pytest.approx(nodes["slip_range"].max())
    assert steady.slipping_share == pytest.approx(
        table["slipping"] @ table["area"] / table["area"].sum()
    )


def test_shear_around_a_pin_has_the_resultant_of_its_directions():
    """Twist of a pin in a hole has no resultant, though each node carries shear along its own
    tangent."""
    turns = 2 * np.pi * np.arange(8) / 8
    normals = np.column_stack([np.cos(turns), np.sin(turns)])
    frames = np.stack([np.column_stack([normals[:, 1], -normals[:, 0]]), normals], axis=1)
    loads = {
        "P": (np.zeros(8), np.ones(8)),
        "twist": (np.full(8, 0.1), np.zeros(8)),
        "Q": (0.1 * frames[:, 0, 0], np.zeros(8)),
    }
    pin = fo.ContactSystem(np.eye(16), normals, loads, frames=frames)
    for case, resultant in (("twist", 0.0), ("Q", 0.4)):
        table = fo.steady_state(pin, fo.LoadCycle({"P": 1.0}, [{case: 1.0}]), 0.5, 1.0).by_contact()
        assert table["Q_0"][0] == pytest.approx(resultant, abs=1e-12)
        assert table["P_0"][0] == pytest.approx(8.0)
        assert table["contact"][0] == "the contact"
        assert "area" not in table
        assert "no width" in table.attrs["note"]


def test_of_a_period_of_two_cycles_the_last_one_counts():
    """The cycle written down twice has the forces of both cycles. Its last three corners are the
    corners of the cycle that ends in the last slip."""
    steady = fo.steady_state(*ASKED)
    twice = fo.steady_state(
        ASKED[0], fo.LoadCycle(ROUND.mean, [*ROUND.corners, *ROUND.corners]), *ASKED[2:]
    )
    last = 3 * (np.abs(steady.slip - twice.slip).max() < 1e-9)
    one, both = steady.by_contact().iloc[0], twice.by_contact().iloc[0]
    for name in ("P", "Q"):
        found, wanted = (
            [row[f"{name}_{corner}"] for corner in corners]
            for row, corners in ((one, range(3)), (both, range(last, last + 3)))
        )
        assert found == pytest.approx(wanted, abs=1e-9)
        assert found != pytest.approx(
            [both[f"{name}_{k}"] for k in range(3 - last, 6 - last)], abs=1e-3
        )


def test_the_share_of_a_cylinder_that_slips_is_that_of_partial_slip():
    """The slipping share of a cylinder is the share by Cattaneo and Mindlin.

    Under alternating shear the strip from c to the half-width a slips, with c / a = sqrt(1 - Q / (f
    P)); the nodes beyond a are open.
    """
    cylinder = fo.ContactSystem.from_blocks(
        **fo.reference.half_plane_contact(nodes=400, half_length=1.25, E_star=1.0, R=1.0)
    )
    P, f, share = np.pi / 4, 0.5, 0.64
    steady = fo.steady_state(
        cylinder, fo.LoadCycle({"P": P}, [{"Q": 1.0}, {"Q": -1.0}]), f, share * f * P
    )
    (row,) = steady.by_contact().to_dict("records")
    assert 1.25 * row["sticking"] == pytest.approx(np.sqrt(1 - share), abs=0.02)
    assert 1.25 * row["open"] == pytest.approx(0.25, abs=0.02)
    assert row["slipping"] == steady.slipping_share
    assert [abs(row["Q_0"]), row["P_0"]] == pytest.approx([share * f * P, P])
    assert row["Q_1"] == pytest.approx(-row["Q_0"])
