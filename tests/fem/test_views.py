"""Views of models by PyVista show the bodies, the contacts and the fields of results.

Nothing is rendered here.
"""

import ctypes
import sys

import numpy as np
import pytest
import pyvista
from vtkmodules.vtkRenderingCore import vtkTextRenderer

import frictopt as fo
from helpers.meshes import column

pytestmark = pytest.mark.usefixtures("scenes_are_closed")

SCENE = fo.scenes.SquarePunch(elements=4, growth=2.0)


@pytest.fixture
def scenes_are_closed():
    yield
    pyvista.close_all()


def title(scene):
    """Of the field that is shown."""
    (found,) = scene.scalar_bars.keys()
    return found


def test_a_model_is_shown_by_its_meshes_and_its_contact():
    scene = SCENE.model().view()
    punch, block, contact = scene.meshes
    assert punch.volume == pytest.approx(2 * 2 * 1.5) and block.volume == pytest.approx(8 * 8 * 3)
    assert contact.area == pytest.approx(4.0) and np.all(contact.points[:, 2] == 0.0)
    assert not scene.scalar_bars and scene.legend is not None
    # The contact is seen through faces, not behind lines.
    actors = scene.renderer.actors.values()
    looks = [actor.prop for actor in actors if isinstance(actor, pyvista.Actor)]
    assert [look.style for look in looks] == ["Surface"] * 3
    assert [look.opacity for look in looks] == [0.25, 0.25, 1.0]


def test_fields_are_shown_on_the_bodies_in_their_units_and_move_them():
    model = column(units="N, mm", loads={"P": [fo.fem.Pressure("a", "top", 3.0)]})
    fields = model.recover({"P": 1.0}, np.zeros((9, 2)))
    scene = model.view(fields, scale=0.1)
    assert title(scene) == "von Mises stress (MPa)"
    upper, lower = scene.meshes
    assert all(np.allclose(grid[title(scene)], 3.0) for grid in (upper, lower))
    # 3 of strain, a tenth of it.
    assert upper.bounds[4:] == pytest.approx((-0.3, 1 - 0.6))
    assert lower.bounds[4:] == pytest.approx((-1.0, -0.3))
    moved = model.view(fields, "displacement").meshes
    assert [grid["displacement (mm)"].max() for grid in moved] == pytest.approx([6.0, 3.0])
    assert moved[0].bounds[5] == 1.0


def test_signs_of_markup_in_names_are_drawn_as_they_are():
    """VTK itself would draw `$x$` as mathematics."""
    a, b = column(loads={"P": [fo.fem.Pressure("a", "top", 3.0)]}).bodies.values()
    model = column(
        bodies={"$x$": a, "b": b},
        contacts=[fo.fem.Contact("$x$", "b", "b", "a")],
        loads={"P": [fo.fem.Pressure("$x$", "top", 3.0)]},
        units="$N$, mm",
    )
    named = model.view().legend.GetEntryString(0)
    scene = model.view(model.recover({"P": 1.0}, np.zeros((9, 2))))
    titled = scene.scalar_bars[title(scene)].GetTitle()
    for text, drawn in ((named, "$x$"), (titled, "von Mises stress ($N$ / mm²)")):
        assert vtkTextRenderer.GetInstance().DetectBackend(text) == vtkTextRenderer.FreeType
        assert text.replace("\\$", "$").strip() == drawn


def test_colours_of_all_bodies_are_from_the_least_to_the_largest_value():
    model = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).model()
    scene = model.view(model.recover({"P": 1.0}, np.zeros(5)))
    values = np.concatenate([grid[title(scene)] for grid in scene.meshes])
    ranges = [
        actor.mapper.scalar_range
        for actor in scene.actors.values()
        if isinstance(actor, pyvista.Actor)
    ]
    assert len(ranges) == 2 and np.allclose(ranges, [values.min(), values.max()])


def test_fields_of_a_contact_are_seen_through_the_bodies():
    model = column(
        units="N, mm",
        loads={
            "P": [fo.fem.Pressure("a", "top", 3.0)],
            "Q": [fo.fem.Traction("a", "top", x=0.3, y=0.4)],
        },
    )
    fields = model.recover({"P": 1.0, "Q": 1.0}, np.tile([0.06, -0.08], (9, 1)))
    for show, whole in (("pressure", 3.0), ("shear", 0.5), ("slip", 0.1), ("gap", 0.0)):
        scene = model.view(fields, show)
        face, *bodies = scene.meshes
        assert face.integrate_data()[title(scene)].item() == pytest.approx(whole, abs=1e-12), show
        assert len(bodies) == 2
        assert [
            actor.prop.opacity
            for actor in scene.actors.values()
            if isinstance(actor, pyvista.Actor)
        ] == [1.0, 0.25, 0.25]


def test_a_steady_state_has_the_work_of_its_cycle():
    model = fo.scenes.PunchOnHalfPlane(elements=8, growth=2.0).model()
    system = model.condense()
    steady = fo.steady_state(
        system,
        fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}]),
        friction=0.5,
        load_factor=2.0,
    )
    scene = model.view(steady, "work_density")
    assert scene.meshes[0][title(scene)] @ system.width == pytest.approx(
        steady.dissipation, rel=1e-6
    )


def missing(name):
    """In the place of ctypes.CDLL on a machine without libraries."""
    raise OSError(f"{name}: cannot open shared object file")


def test_what_cannot_be_shown_is_refused_by_name(monkeypatch):
    model = SCENE.model()
    fields = model.recover({"P": 1.0}, np.zeros((25, 2)))
    for ask, message in (
        (lambda: model.view(fields, "stress"), "show: 'stress'; give 'von_mises' or"),
        (lambda: model.view(fields, "work_density"), "show: 'work_density'"),
        (lambda: model.view(3), "result: 3; give fields"),
        (lambda: model.view(fields, scale=np.nan), "scale: nan"),
    ):
        with pytest.raises(fo.ModelError, match=f"^{message}"):
            ask()
    with monkeypatch.context() as bare:
        bare.delenv("DISPLAY", raising=False)
        bare.setattr(sys, "platform", "linux")
        bare.setattr(ctypes, "CDLL", missing)
        with pytest.raises(ImportError, match="apt-get install libegl1"):
            model.view()
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(ImportError, match=r"frictopt\[view\]"):
        model.view()
