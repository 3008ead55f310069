"""Files of a contact system: what was saved comes back bit by bit or is refused, whatever happened
to the file."""

import os
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictopt as fo
from helpers.cases import few
from helpers.systems import random_system, unit_nodes

PLACED = {
    "points": [[0, 0], [1, 0], [1, 1]],
    "frames": [[[1, 0], [0, 1]], [[0.8, -0.6], [0.6, 0.8]], [[0, -1], [1, 0]]],
    "contact": ["é", "é", "right"],
    "width": [1, 2, 0.5],
}
SOME = replace(
    random_system(np.random.default_rng(1), 3), gap=[0.0, 0.5, 0.25], E_star=3.0, **PLACED
)
NAMES = st.text(
    st.characters(categories=["L", "N", "P", "S", "Zs"]).filter(str.isprintable),
    min_size=1,
    max_size=12,
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("files")


def content(system):
    arrays = {name: getattr(system, name).tobytes() for name in ("S", "points", "frames", "gap")}
    known = {
        name: None if getattr(system, name) is None else getattr(system, name).tolist()
        for name in ("contact", "width")
    }
    return {
        **arrays,
        **known,
        "E_star": system.E_star,
        **{f"bonded {name}": (q.tobytes(), p.tobytes()) for name, (q, p) in system.bonded.items()},
    }


def saved(path, system=SOME, **changes):
    """A saved system, with members of the archive replaced, left out (None), or packed tighter
    (`compress`)."""
    system.save(path)
    pack = np.savez_compressed if changes.pop("compress", False) else np.savez
    if changes or pack is np.savez_compressed:
        with np.load(path) as archive:
            members = {**archive, **changes}
        pack(path, **{name: value for name, value in members.items() if value is not None})
    return path


def refused(path):
    """That a file or folder is refused by its name."""
    with pytest.raises(fo.ModelError) as caught:
        fo.ContactSystem.load(path)
    assert str(path) in str(caught.value)


@settings(max_examples=few(40))
@given(
    nodes=st.integers(1, 6),
    seed=st.integers(0, 10**6),
    scale=st.sampled_from([1e-12, 1.0, 1e12]),
    gap=st.booleans(),
    modulus=st.none() | st.floats(1e-9, 1e9),
    names=st.lists(NAMES, min_size=1, max_size=4, unique=True),
    placed=st.sets(st.sampled_from(sorted(PLACED))),
    contact=NAMES,
)
def test_saved_systems_come_back_bit_by_bit(
    folder, nodes, seed, scale, gap, modulus, names, placed, contact
):
    rng = np.random.default_rng(seed)
    system = random_system(rng, nodes)
    bonded = {name: (rng.normal(size=nodes), rng.normal(size=nodes)) for name in names}
    blocks = (scale * block for block in (system.A, system.B, system.C))
    turns = rng.uniform(0.1, 3.0, nodes)  # tangents along which the nodes follow each other
    c, s = np.cos(turns), np.sin(turns)
    where = {
        "points": np.column_stack([np.arange(nodes), rng.normal(size=nodes)]),
        "frames": np.moveaxis([[s, -c], [c, s]], -1, 0),
    }
    known = {
        name: part
        for name, part in {
            **where,
            "contact": [contact] * nodes,
            "width": 1 + rng.random(nodes),
        }.items()
        if name in placed
    }
    system = fo.ContactSystem.from_blocks(
        *blocks, system.x, bonded, rng.random(nodes) if gap else None, E_star=modulus
    )
    system = replace(system, **known)
    system.save(folder / "a system")
    again = fo.ContactSystem.load(folder / "a system")
    assert content(again) == content(system) and list(again.bonded) == names


@pytest.mark.parametrize("compress", [False, True])
def test_a_damaged_archive_gives_the_saved_content_or_an_error(folder, compress):
    """Bytes changed, cut off or put in at random; the same seed each time."""
    path = saved(folder / f"damaged {compress}.npz", compress=compress)
    whole, rng, answers = path.read_bytes(), np.random.default_rng(2), {"same": 0, "refused": 0}
    for _ in range(300):
        damaged = bytearray(whole)
        place = int(rng.integers(len(whole)))
        match rng.integers(5):
            case 0:
                del damaged[place:]
            case 1:
                damaged[place:place] = rng.bytes(rng.integers(1, 9))
            case _:
                for spot in rng.integers(len(whole), size=rng.integers(1, 4)):
                    damaged[spot] ^= 1 << rng.integers(8)
        path.write_bytes(damaged)
        try:
            assert content(fo.ContactSystem.load(path)) == content(SOME)
            answers["same"] += 1
        except fo.ModelError as error:
            assert str(path) in str(error)
            answers["refused"] += 1
    assert answers["refused"] > 200


def test_names_of_which_a_damaged_header_shows_a_part_are_refused(tmp_path):
    """Names of seven letters read as of three: readers look at the checksum of a long member only
    where they come to its end."""
    path, cases = tmp_path / "a.npz", {f"case{k:03}": ([0.0], [1.0]) for k in range(400)}
    unit_nodes(cases).save(path)
    whole = path.read_bytes()
    assert whole.count(b"'<U7'") == 1
    path.write_bytes(whole.replace(b"'<U7'", b"'<U3'"))
    refused(path)


def test_what_is_no_archive_of_a_contact_system_is_refused(tmp_path):
    path = tmp_path / "a.npz"
    refused(path)
    path.write_text("not an archive")
    refused(path)
    for change in (
        {"S": None},
        {"format": np.array("another")},
        {"other": np.eye(2)},
        {"cases": np.array(1.0)},
    ):
        refused(saved(path, **change))


def test_files_that_cannot_be_written_or_named_are_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")  # opening it would wait for somebody at its other end
    for path in (tmp_path / "no folder" / "a.npz", tmp_path, "a\0b", None, 3, tmp_path / "pipe"):
        with pytest.raises(fo.ModelError, match="path"):
            SOME.save(path)
        with pytest.raises(fo.ModelError, match="path"):
            fo.ContactSystem.load(path)


@pytest.mark.parametrize("name", ["joint", "joint_f0.3", "joint.v2", "11.23.coarse", "JOINT.NPZ"])
def test_names_with_points_are_names(name, tmp_path):
    SOME.save(tmp_path / name)
    assert [file.name for file in tmp_path.iterdir()] == [name] and content(
        fo.ContactSystem.load(tmp_path / name)
    ) == content(SOME)
