"""Faces of body 1 that reach beyond body 2.

The tests cover the part that lies opposite, the nodes that carry the load, the free share,
and exchanged bodies.
"""

import re

import numpy as np
import pytest
from skfem import MeshHex, MeshQuad, MeshTet, MeshTri

import frictopt as fo
from helpers.meshes import box

KINDS = [(MeshQuad, MeshQuad), (MeshTri, MeshQuad), (MeshHex, MeshHex), (MeshTet, MeshHex)]


def narrow_below(kinds, edge, cells=(8, 5)):
    """A block from 0 to 4 on one from -1 to `edge`, in space both 1 deep; and a mean load."""
    d = 2 if kinds[0] in (MeshQuad, MeshTri) else 3
    across = [np.linspace(0.0, 1.0, 3)] * (d - 2)
    upper = box(kinds[0], np.linspace(0.0, 4.0, cells[0] + 1), *across, [0.0, 0.5, 1.0])
    lower = box(kinds[1], np.linspace(-1.0, edge, cells[1] + 1), *across, [-1.0, -0.5, 0.0])
    return {"upper": fo.fem.Body(upper), "lower": fo.fem.Body(lower, fo.fem.Material(2.0))}


def model(bodies, *contact, loads=None):
    up = "y" if bodies["upper"].mesh.dim() == 2 else "z"
    loads = loads or {
        "P": [fo.fem.Traction("upper", f"{up}+", **{up: -1.0})],
        "Q": [fo.fem.Traction("upper", f"{up}+", x=1.0, **{up: lambda x, *_: x})],
    }
    supports = [fo.fem.Support("lower", f"{up}-")]
    return fo.fem.ContactModel(bodies, supports, loads, [fo.fem.Contact(*contact)])


@pytest.mark.parametrize("kinds", KINDS)
def test_up_to_an_edge_between_facets_it_is_the_contact_of_the_part(kinds):
    """The edge of body 2, at x = 2.5, is one between two facets of body 1."""
    bodies = narrow_below(kinds, 2.5, (8, 4))
    part = bodies["upper"].mesh.with_boundaries(
        {"part": lambda x: (abs(x[-1]) < 1e-9) & (x[0] < 2.5 + 1e-9)}
    )
    bodies["upper"] = fo.fem.Body(part)
    with pytest.warns(fo.ModelWarning, match=r"1\.5 \(37\.5%\) has no opposite part of body"):
        whole = model(bodies, "upper", "lower").condense()
    named = model(bodies, "upper", "lower", "part", "contact").condense()
    assert np.allclose(whole.points, named.points) and np.allclose(whole.width, named.width)
    assert np.allclose(whole.S, named.S, rtol=0, atol=1e-12 * abs(named.S).max())
    for case, forces in named.bonded.items():
        for mine, right in zip(whole.bonded[case], forces, strict=True):
            assert np.allclose(mine, right, rtol=0, atol=1e-11)


@pytest.mark.parametrize("kinds", KINDS)
@pytest.mark.parametrize("edge", [2.55, 2.7, 2.8, 2.99])
def test_the_contact_carries_the_load_and_has_the_size_of_what_lies_opposite(kinds, edge):
    bodies = narrow_below(kinds, edge)
    size = "length" if bodies["upper"].mesh.dim() == 2 else "area"
    beyond = f"the {size} {4 - edge:.3g} ({(4 - edge) / 4:.1%}) has no opposite part"
    with pytest.warns(fo.ModelWarning, match=re.escape(beyond)):
        system = model(bodies, "upper", "lower").condense()
    assert system.width.sum() == pytest.approx(edge) and system.width.min() > 0
    q, p = system.bonded["P"]
    assert p.sum() == pytest.approx(4.0) and np.abs(q.sum(axis=0)).max() < 1e-10
    q, p = system.bonded["Q"]
    assert q.sum(axis=0) == pytest.approx(-4.0 if q.ndim == 1 else [-4.0, 0.0], abs=1e-9)
    assert p.sum() == pytest.approx(-8.0)
    # Half a facet, 0.25, of a quadrilateral reaches this far beyond the edge; half the area of a
    # triangle lies within 1 - sqrt(1/2) of its height.
    furthest = 0.5 * np.sqrt(0.5) if kinds[0] is MeshTet else 0.25
    assert system.points[:, 0].max() < edge + furthest + 1e-9


@pytest.mark.parametrize("at", [2.0, 2.45, 2.85, 3.2])
def test_a_block_on_an_edge_tips_over_where_its_weight_lies_beyond(at):
    """The load acts on the facet of the top around `at`. The edge of the ground is at 2.6, and
    pressure acts up to half a facet, 0.1, beyond the edge or short of it."""
    upper = box(MeshQuad, np.linspace(0.0, 4.0, 21), [0.0, 0.5, 1.0])
    upper = upper.with_boundaries({"load": lambda x: (x[1] == 1.0) & (abs(x[0] - at) < 0.11)})
    bodies = {"upper": fo.fem.Body(upper), "lower": narrow_below(KINDS[0], 2.6)["lower"]}
    loads = {
        "P": [fo.fem.Traction("upper", "load", y=-1.0)],
        "Q": [fo.fem.Traction("upper", "load", x=1e-3)],
    }
    system = model(bodies, "upper", "lower", loads=loads).condense()
    slide = fo.gross_slip(system, fo.LoadCycle({"P": 1.0}, [{"Q": 1.0}, {"Q": -1.0}]), 0.5)
    assert (slide.load_factor > 0) is (at < 2.6), slide.reason


def test_what_has_no_node_opposite_is_refused():
    bodies = narrow_below((MeshQuad, MeshQuad), 2.7, (1, 5))
    bodies["lower"] = fo.fem.Body(box(MeshQuad, np.linspace(1.0, 2.0, 5), [-1.0, 0.0]))
    with pytest.raises(
        fo.ModelError, match="or less than half of each facet has one; name the part"
    ):
        model(bodies, "upper", "lower")

    # A ground up to x = 2, and a narrow tower from 3.2 to 3.4 below the last facet.
    pieces = box(MeshQuad, [-1.0, 2.0, 3.2, 3.4, 3.9], [-1.0, -0.5, 0.0])
    x, y = pieces.p[:, pieces.t].mean(axis=1)
    kept = (y < -0.5) | (x < 2.0) | ((x > 3.2) & (x < 3.4))
    pieces = pieces.remove_elements(np.flatnonzero(~kept)).with_boundaries(
        {"contact": lambda x: x[1] == 0, "y-": lambda x: x[1] == -1}
    )
    bodies = {
        "upper": fo.fem.Body(box(MeshQuad, np.arange(5.0), [0.0, 1.0])),
        "lower": fo.fem.Body(pieces),
    }
    with pytest.raises(
        fo.ModelError, match=r"around \(3\.5, 0\) has facets too large for the part of body 'lower'"
    ):
        model(bodies, "upper", "lower")
