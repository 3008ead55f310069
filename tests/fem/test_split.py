import re

import numpy as np
import pytest
from skfem import MeshLine, MeshQuad, MeshTri

import frictopt as fo
from helpers.meshes import blocks, hung, uniform_loads

NAMED = {
    "top": lambda x: x[1] == 1.0,
    "bottom": lambda x: x[1] == -1.0,
    "left": lambda x: x[0] == -1.0,
    "right": lambda x: x[0] == 1.0,
}
UPPER, LOWER = (lambda x: x[1] > 0), (lambda x: x[1] < 0)
ONE = fo.fem.Material()


def whole(kind=MeshQuad, **subdomains):
    mesh = kind.init_tensor(
        np.array([-1.0, -0.5, 0.1, 1.0]), np.array([-1.0, -0.4, 0.0, 0.4, 1.0])
    ).with_boundaries(NAMED)
    return mesh.with_subdomains(subdomains or {"punch": UPPER, "block": LOWER})


def test_one_mesh_gives_the_same_contact_as_two():
    two = fo.fem.ContactModel(blocks(), hung(), uniform_loads()).condense()
    bodies = fo.fem.split_bodies(whole(), {"punch": ONE, "block": ONE})
    assert sorted(bodies["punch"].mesh.boundaries) == ["block", "left", "right", "top"]
    for body in bodies.values():
        assert np.all(body.mesh.p[0, body.boundary_nodes("left", "left")] == -1.0)
    one = fo.fem.ContactModel(
        bodies,
        hung(),
        uniform_loads(),
        [fo.fem.Contact("punch", "block", "block", "punch", name="contact")],
    ).condense()
    assert np.allclose(one.S, two.S, atol=1e-14)
    assert np.allclose(one.bonded["tau"], two.bonded["tau"], atol=1e-14)


def test_materials_elements_and_three_bodies():
    parts = {
        "left": lambda x: (x[1] > 0) & (x[0] < 0.1),
        "right": lambda x: (x[1] > 0) & (x[0] > 0.1),
        "block": LOWER,
    }
    mesh = MeshTri.init_tensor(
        np.array([-1.0, -0.5, 0.1, 1.0]), np.array([-1.0, -0.4, 0.0, 0.4, 1.0])
    ).with_subdomains(parts)
    stiff = fo.fem.Material(E=7.0)
    bodies = fo.fem.split_bodies(
        mesh, {"left": stiff, "right": ONE, "block": ONE}, element="mean_dilatation"
    )
    assert bodies["left"].material == stiff
    assert {body.element for body in bodies.values()} == {"mean_dilatation"}
    assert sorted(bodies["left"].mesh.boundaries) == ["block", "right"]
    assert sorted(bodies["block"].mesh.boundaries) == ["left", "right"]
    assert np.allclose(
        bodies["right"].mesh.p[0, bodies["right"].boundary_nodes("left", "left")], 0.1
    )


BAD = {
    "mesh: a MeshLine1": {"mesh": MeshLine()},
    "materials: subdomain 'bolt' is unknown; this mesh names ['block', 'punch']": {
        "materials": {"bolt": ONE}
    },
    "materials: elements that are in none of ['punch']: 6": {"materials": {"punch": ONE}},
    "materials: subdomain 'all' shares elements with 'punch'": {
        "mesh": whole(punch=UPPER, all=lambda x: x[1] < 5),
        "materials": {"punch": ONE, "all": ONE},
    },
    "materials: []; give a mapping": {"materials": []},
    "body 'punch': material: a float": {"materials": {"punch": 1.0, "block": ONE}},
    "mesh: boundary 'block' has the name of a body": {
        "mesh": whole().with_boundaries({"block": NAMED["bottom"]})
    },
    "body 'punch': mesh: 2 parts that share no edge": {
        "mesh": whole(punch=lambda x: np.abs(x[1]) > 0.4, block=lambda x: np.abs(x[1]) < 0.4)
    },
}


def test_parts_that_share_no_edge_are_bodies():
    """The squares of a row at x = 0, 2 and 4 to 6 are three bodies; the last body has two squares."""
    row = MeshQuad.init_tensor(np.arange(7.0), [0.0, 1.0]).remove_elements(np.array([1, 3]))
    row = row.with_boundaries({"low": lambda x: x[1] == 0})
    row = row.with_subdomains(
        {"all": np.arange(4), "last": np.array([2, 3]), "half": np.array([2])}
    )
    bodies = fo.fem.split_bodies(row, ONE)
    assert list(bodies) == ["body 1", "body 2", "last"]
    assert [body.mesh.p[0].min() for body in bodies.values()] == [0.0, 2.0, 4.0]
    assert [len(body.mesh.boundaries["low"]) for body in bodies.values()] == [1, 1, 2]
    assert {body.material for body in bodies.values()} == {ONE}
    # Elements that share a corner only are bodies of their own.
    hinge = MeshQuad.init_tensor([0.0, 1.0, 2.0], [0.0, 1.0, 2.0]).remove_elements([1, 2])
    assert [b.mesh.p.shape for b in fo.fem.split_bodies(hinge, ONE).values()] == [(2, 4)] * 2


@pytest.mark.parametrize("message", BAD)
def test_meshes_that_do_not_split_are_refused(message):
    with pytest.raises(fo.ModelError, match=re.escape(message)):
        fo.fem.split_bodies(
            **{"mesh": whole(), "materials": {"punch": ONE, "block": ONE}, **BAD[message]}
        )
