"""Joints of the size that users bring, against dense solves, plain cycling, and Clarabel.

Steady states are compared with dense solves and with plain cycling, limits with Clarabel on the
same rows. Each call is timed by the processor time of one thread, once if it takes seconds.
"""

import numpy as np
import pytest
from test_spatial import ratio, seconds

import frictopt as fo
from frictopt.contact import joined
from frictopt.limits.program import assembled
from frictopt.solve.solvers import run
from frictopt.transients.march import open_at_rest
from frictopt.transients.stepped import SteppedPath
from joints import ASKEW, FRICTION, PULL, SHEAR, VIBRATION, fir_tree, flange, lap_joint


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Contacts by name, each made once."""
    folder, known = tmp_path_factory.mktemp("joints"), {}
    ways = {
        "flange": lambda: flange(folder, 9),
        "fine flange": lambda: flange(folder, 5),
        "lap joint": lap_joint,
        "fir tree": lambda: fir_tree(folder),
    }

    def system(name):
        if name not in known:
            known[name] = ways[name]()
        return known[name]

    return system


def asked(name):
    """Load cycle and friction of a joint."""
    return {"lap joint": (PULL, 0.3), "fir tree": (VIBRATION, 0.3)}.get(name, (SHEAR, FRICTION))


@pytest.mark.parametrize(
    ("name", "nodes"), [("flange", 747), ("fine flange", 1096), ("fir tree", 96)]
)
def test_the_joints_have_their_sizes(made, name, nodes):
    # The number of nodes depends on the version of gmsh.
    assert made(name).nodes == pytest.approx(nodes, rel=0.02)


@pytest.mark.parametrize(
    ("name", "load_factor", "most"),
    [("flange", 1.0, 60.0), ("flange", 5.0, 90.0), ("lap joint", 1.0, 1000.0)],
)
def test_steady_state_in_dense_solves(made, name, load_factor, most, record_property):
    """The steady state by two increments per segment, with its proof and its error.

    The unit of time is one dense solve of the contact by LAPACK.
    """
    system, (cycle, friction), found = made(name), asked(name), []
    ours = seconds(
        lambda: found.append(fo.steady_state(system, cycle, friction, load_factor, steps=2))
    )
    S, r = (
        system.S + system.stiffness_scale * np.eye(len(system.S)),
        joined(*system.reaction(cycle.mean)),
    )
    assert (
        found[0].open.any()
        and found[0].outcome is fo.Outcome.CYCLIC_SLIP
        and found[0].record.residual <= 1e-9
    )
    record_property("cycles", found[0].cycles)
    assert ratio(ours, seconds(lambda: np.linalg.solve(S, r), rounds=3), record_property) < most


@pytest.mark.parametrize(("name", "most"), [("flange", 3.0), ("lap joint", 3.0)])
def test_steady_state_against_plain_cycling(made, name, most, record_property):
    """The rival follows as many load cycles by increments, without extrapolation, proof or error."""
    system, (cycle, friction), found, path = made(name), asked(name), [], []
    ours = seconds(lambda: found.append(fo.steady_state(system, cycle, friction, 1.0, steps=2)))

    def plain():
        path.append(SteppedPath("newton", 2, system, cycle, friction, 1.0).start())
        path.append(path[0].cycle_on(found[0].cycles))

    rival = seconds(plain)
    assert path[1].works[0] == pytest.approx(found[0].first_cycle, rel=1e-9) and path[1].works[
        -1
    ] == pytest.approx(found[0].dissipation, rel=1e-3)
    assert ratio(ours, rival, record_property) < most


def limit_ratio(model, friction, open_nodes, record_property):
    """Time of the first limit of a contact with one set of open nodes, relative to Clarabel on the same rows.

    The first time contains the assembly and the proof.
    """
    limits = []
    ours = seconds(lambda: limits.append(model.solve(friction, open_nodes=open_nodes)))
    program = assembled.shakedown(limits[0]._question)
    arrays = program.arrays()
    rival = seconds(lambda: run(arrays, "CLARABEL", -np.inf))
    assert limits[0].residual <= 1e-9
    return ratio(ours, rival, record_property)


@pytest.mark.parametrize(
    ("name", "most"),
    [("flange", 0.5), ("fine flange", 0.5), ("lap joint", 4.0), ("fir tree", 40.0)],
)
def test_limit_of_one_set_against_clarabel(made, name, most, record_property):
    system, (cycle, friction) = made(name), asked(name)
    open_nodes = open_at_rest(system, cycle, friction)
    assert (
        open_nodes.any()
        and limit_ratio(fo.ShakedownModel(system, cycle), friction, open_nodes, record_property)
        < most
    )


@pytest.mark.parametrize(("elements", "most"), [(29, 0.4), (49, 0.4)])
def test_limit_without_symmetry_against_clarabel(elements, most, record_property):
    contact = fo.scenes.SquarePunch(elements=elements).condense()
    assert (
        limit_ratio(
            fo.ShakedownModel(contact, ASKEW, simplify=False),
            0.5,
            np.zeros(contact.nodes, dtype=bool),
            record_property,
        )
        < most
    )


def test_required_friction_in_limits(made, record_property):
    """Time of the required friction of the fir tree at half its limit, relative to one limit."""
    system, (cycle, friction), limits = made("fir tree"), asked("fir tree"), []
    rival = seconds(lambda: limits.append(fo.shakedown_limit(system, cycle, friction)))
    ours = seconds(lambda: fo.required_friction(system, cycle, 0.5 * limits[0].load_factor))
    assert ratio(ours, rival, record_property) < 3.0


@pytest.mark.parametrize("friction", [0.2, 0.3, 0.5])
def test_the_search_of_open_nodes_against_one_limit(made, friction, record_property):
    """The search computes 15 to 34 sets. The rival is the limit of the best set."""
    system = made("fir tree")
    cycle, _ = asked("fir tree")
    limit = fo.shakedown_limit(system, cycle, friction)
    rounds = [
        (
            seconds(lambda: fo.shakedown_limit(system, cycle, friction)),
            seconds(lambda: fo.shakedown_limit(system, cycle, friction, open_nodes=limit.open)),
        )
        for _ in range(3)
    ]
    whole, one = np.min(rounds, axis=0)
    record_property("ratio", whole / one)
    print(f"\n    search {whole:.3f} s, one limit {one:.3f} s, ratio {whole / one:.1f}")
    assert whole / one < 20.0


def test_the_search_of_open_nodes_in_space_against_one_limit(made, record_property):
    """The search computes about 60 sets of the flange in two minutes.

    The rival is the limit of the best set.
    """
    system, (cycle, friction), limits = made("flange"), asked("flange"), []
    whole = seconds(lambda: limits.append(fo.shakedown_limit(system, cycle, friction)))
    one = seconds(lambda: fo.shakedown_limit(system, cycle, friction, open_nodes=limits[0].open))
    assert limits[0].load_factor > 0.4831 and ratio(whole, one, record_property) < 45.0
