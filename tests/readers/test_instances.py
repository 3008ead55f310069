"""Parts and instances: the same mesh as a flat deck that is written by hand."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import frictopt as fo

CUBE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
PART = (
    "*Part, name=Block\n*Node\n"
    + "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(CUBE, 1))
    + "*Element, type=C3D8\n 1, 1, 2, 3, 4,\n 5, 6, 7, 8\n*Nset, nset=Low, generate\n 1, 4, 1\n*Elset, elset=All\n 1,\n"
    "*Surface, type=ELEMENT, name=Top\nAll, S2\n*Surface, type=NODE, name=Nodes\n 5, 1.\n Low, 1.\n"
    "*Solid Section, elset=All, material=M\n,\n*End Part\n"
)
ASSEMBLY = (
    "*Assembly, name=Assembly\n*Instance, name=A-1, part=Block\n*End Instance\n"
    "*Instance, name=B-1, part=Block\n{moved}*End Instance\n"
    "*Nset, nset=Both, instance=A-1\n 5, 6, 7, 8\n*Nset, nset=Both, instance=B-1\n Low\n"
    "*Elset, elset=_S, internal, instance=B-1, generate\n 1, 1, 1\n"
    "*Surface, type=ELEMENT, name=Under\n_S, S1\n*Surface, type=ELEMENT, name=Joined\nA-1.All, S2\nB-1.1, S3\n"
    "*End Assembly\n*Material, name=M\n*Elastic\n1., 0.3\n*Boundary\nA-1.Low, ENCASTRE\n"
)


def read(folder, text):
    (folder / "a.inp").write_text(text)
    return fo.readers.read_mesh(folder / "a.inp")


def places(mesh, name):
    return np.unique(mesh.p[:, np.unique(mesh.facets[:, mesh.boundaries[name]])].T.round(9), axis=0)


def test_two_instances_of_a_part_are_two_bodies(tmp_path):
    mesh = read(tmp_path, PART + ASSEMBLY.format(moved="0., 0., 1.\n"))
    assert mesh.p.shape == (3, 16)
    assert {name: members.tolist() for name, members in mesh.subdomains.items()} == {
        "A-1": [0], "B-1": [1], "A-1.ALL": [0], "B-1.ALL": [1], "_S": [1],
    }  # fmt: skip
    assert sorted(mesh.boundaries) == sorted(
        [
            "A-1.LOW",
            "A-1.NODES",
            "A-1.TOP",
            "B-1.LOW",
            "B-1.NODES",
            "B-1.TOP",
            "BOTH",
            "UNDER",
            "JOINED",
        ]
    )
    assert places(mesh, "B-1.TOP")[:, 2].tolist() == [2.0] * 4
    assert places(mesh, "UNDER")[:, 2].tolist() == places(mesh, "A-1.TOP")[:, 2].tolist()
    assert len(mesh.boundaries["BOTH"]) == len(mesh.boundaries["JOINED"]) == 2
    bodies = fo.fem.split_bodies(mesh, dict.fromkeys(("A-1", "B-1"), fo.fem.Material()))
    system = fo.fem.ContactModel(
        bodies,
        [fo.fem.Support("A-1", "A-1.LOW")],
        {"P": [fo.fem.Pressure("B-1", "B-1.TOP", 2.0)]},
        [fo.fem.Contact("B-1", "A-1", "UNDER", "A-1.TOP")],
    ).condense()
    assert system.bonded["P"][1].sum() == pytest.approx(2.0)


@settings(max_examples=10, deadline=None)
@given(
    shift=st.tuples(*[st.floats(-5, 5)] * 3),
    start=st.tuples(*[st.floats(-5, 5)] * 3),
    axis=st.tuples(st.floats(0.1, 1), st.floats(-1, 1), st.floats(-1, 1)),
    angle=st.floats(-360, 360),
)
def test_an_instance_is_shifted_and_then_turned(tmp_path_factory, shift, start, axis, angle):
    end = np.add(start, axis)
    lines = (
        ", ".join(map(repr, shift)) + "\n" + ", ".join(map(repr, (*start, *end.tolist(), angle)))
    )
    mesh = read(tmp_path_factory.mktemp("i"), PART + ASSEMBLY.format(moved=lines + "\n"))
    unit = np.array(axis) / np.linalg.norm(axis)
    # Rodrigues' formula, on the shifted points
    arm = np.array(CUBE) + shift - np.array(start)
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turned = arm * c + np.cross(unit, arm) * s + np.outer(arm @ unit, unit) * (1 - c) + start
    mine = mesh.p[:, np.unique(mesh.t[:, mesh.subdomains["B-1"]])].T
    assert np.allclose(sorted(mine.round(7).tolist()), sorted(turned.round(7).tolist()), atol=2e-7)


def test_a_quarter_turn_about_z_takes_x_to_y(tmp_path):
    mesh = read(tmp_path, PART + ASSEMBLY.format(moved="5., 0., 0.\n0., 0., 0., 0., 0., 1., 90.\n"))
    assert places(mesh, "B-1.LOW")[:, :2].tolist() == [[-1, 5], [-1, 6], [0, 5], [0, 6]]
    assert Rotation.from_euler("z", 90, degrees=True).apply([5, 0, 0]) == pytest.approx([0, 5, 0])


def test_sets_of_an_instance_begin_with_its_name(tmp_path):
    one = "*Assembly, name=X\n*Instance, name=I, part=Block\n*Nset, nset=Own\n 5, 6, 7, 8\n*End Instance\n*Nset, nset=Rim, instance=I\n 1, 2, 5, 6\n*Surface, type=ELEMENT, name=S\nI.All, S2\n*End Assembly\n"
    mesh = read(tmp_path, PART + one)
    assert sorted(mesh.boundaries) == ["I.LOW", "I.NODES", "I.OWN", "I.TOP", "RIM", "S"]
    assert sorted(mesh.subdomains) == ["I", "I.ALL"]
    job = tmp_path / "k.mtx"
    labels = [(n, d) for n in range(1, 9) for d in (1, 2, 3)]
    job.write_text("".join(f"{n},{d},{n},{d},2.\n" for n, d in labels) + "".join(
        f"{a},{b},{c},{d},-1.\n" for (a, b), (c, d) in pairwise(labels)))  # fmt: skip
    read_job = fo.readers.read_abaqus(job, deck=tmp_path / "a.inp")
    assert read_job.force("I.Top", pressure=3.0).sum() == pytest.approx(-3.0)
    assert sorted(read_job.nodes("I.Nodes").tolist()) == [0, 1, 2, 3, 4]
    (tmp_path / "a.inp").write_text(PART + ASSEMBLY.format(moved=""))
    with pytest.raises(
        fo.ModelError, match=r"2 instances, and Abaqus numbers the nodes.*flat deck"
    ):
        fo.readers.read_abaqus(job, deck=tmp_path / "a.inp")


BAD = {
    "its part 'PLATE' is not in this deck": ("part=Block", "part=Plate"),
    "names an unknown instance": ("instance=B-1", "instance=C-1"),
    "turns by 3 numbers": ("{moved}", "0.\n1., 2., 3.\n"),
    "\\*INSTANCE .*: an entry is no number": ("{moved}", "one\n"),
}


@pytest.mark.parametrize("message", BAD)
def test_bad_assemblies_are_refused(tmp_path, message):
    old, new = BAD[message]
    text = PART + ASSEMBLY.replace(old, new).replace("{moved}", "")
    with pytest.raises(fo.ModelError, match=message):
        read(tmp_path, text)


def test_a_part_or_an_instance_without_an_end_hides_no_blocks(tmp_path):
    assembly = ASSEMBLY.format(moved="")
    endless = {
        "INSTANCE": PART + "".join(assembly.rsplit("*End Instance\n", 1)),
        "PART": PART.replace("*End Part\n", "") + assembly,
    }
    for keyword, text in endless.items():
        with pytest.raises(fo.ModelError, match=rf"\*{keyword} .* has no \*END {keyword}"):
            read(tmp_path, text)
