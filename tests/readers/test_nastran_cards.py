"""One joint in all the ways in which Nastran lets its cards be written: each is the same job."""

import re
from pathlib import Path

import numpy as np
import pytest

import frictopt as fo

DATA = Path(__file__).parents[1] / "data"
PLAIN = fo.readers.read_nastran(DATA / "joint.pch", deck=DATA / "joint.bdf")
POINTS = dict(zip(PLAIN.deck.numbers.tolist(), PLAIN.deck.points.tolist(), strict=True))
NODES = {
    int(name): PLAIN.deck.numbers[nodes].tolist()
    for block in PLAIN.deck.elements
    for name, nodes in zip(block.numbers, block.nodes, strict=True)
}


def small(*entries):
    """A line of small fields."""
    return "".join(f"{entry!s:<8}" for entry in entries) + "\n"


def large(first, *entries):
    """A line of large fields."""
    return f"{first:<8}" + "".join(f"{entry!s:>16}" for entry in entries) + "\n"


def grid(name, x, y, z):
    return small("GRID", name, "", x, y, z)


def brick(name, *nodes):
    return small("CHEXA", name, 1, *nodes[:6]) + small("", *nodes[6:])


def deck(grid=grid, brick=brick):
    grids = "".join(grid(name, *point) for name, point in POINTS.items())
    return grids + "".join(brick(name, *nodes) for name, nodes in NODES.items())


def read(folder, bulk):
    (folder / "j.bdf").write_text(f"SOL 101\nCEND\nBEGIN BULK\n{bulk}ENDDATA\n")
    return fo.readers.read_nastran(DATA / "joint.pch", deck=folder / "j.bdf")


def agrees(job):
    assert (job.K != PLAIN.K).nnz == 0 and np.array_equal(job.labels, PLAIN.labels)
    numbers = job.deck.numbers.tolist()
    assert dict(zip(numbers, job.deck.points.tolist(), strict=True)) == POINTS
    (block,) = job.deck.elements
    nodes = job.deck.numbers[block.nodes].tolist()
    assert block.kind == "C3D8"
    assert dict(zip(block.numbers.tolist(), nodes, strict=True)) == NODES


GRIDS = {
    "large": lambda n, x, y, z: large("GRID*", n, "", x, y) + large("*", z),
    "a comment between": lambda n, x, y, z: large("GRID*", n, "", x, y) + "$ z\n" + large("*", z),
    "a blank line between": lambda n, x, y, z: large("GRID*", n, "", x, y) + "\n" + large("*", z),
    "large and small": lambda n, x, y, z: large("GRID*", n, "", x, y) + small("+", z),
    "large with commas": lambda n, x, y, z: f"GRID*,{n},,{x},{y}\n*,{z}\n",
    "named": lambda n, x, y, z: f"GRID*,{n},,{x},{y},*G{n}\n*G{n},{z},,,\n",
    "small with commas": lambda n, x, y, z: f"grid, {n}, , {x}, {y}, {z}, 0\n",
    "exponents": lambda n, x, y, z: f"GRID,{n},,{x * 10}-1,{y / 100}+2,{z}D0\n",
    "commas in comments": lambda n, x, y, z: grid(n, x, y, z).rstrip() + " $ corner, left\n",
    "not at the margin": lambda n, x, y, z: f"  GRID,{n},,{x},{y},{z}\n",
    "tabs": lambda n, x, y, z: f"GRID\t{n}\t\t{x}\t{y}\t{z}\n",
    "twice": lambda n, x, y, z: 2 * grid(n, x, y, z),
}
BRICKS = {
    "large": lambda n, *c: large("CHEXA*", n, 1, *c[:2]) + large("*", *c[2:6]) + large("*", *c[6:]),
    "large with commas": lambda n, *c: (
        f"CHEXA*,{n},1,{c[0]},{c[1]}\n*,{', '.join(map(str, c[2:6]))}\n*,{c[6]},{c[7]}\n"
    ),
    "commas, then columns": lambda n, *c: (
        f"CHEXA,{n},1,{','.join(map(str, c[:6]))}\n" + small("+", *c[6:])
    ),
    "columns, then commas": lambda n, *c: small("CHEXA", n, 1, *c[:6]) + f",{c[6]},{c[7]}\n",
    "small, then large": lambda n, *c: small("CHEXA", n, 1, *c[:6]) + large("*", *c[6:]),
    "a comment between": lambda n, *c: brick(n, *c).replace("\n", "\n$ more\n", 1),
    "named": lambda n, *c: small("CHEXA", n, 1, *c[:6], f"+E{n}") + small(f"+E{n}", *c[6:]),
}


@pytest.mark.parametrize("form", GRIDS)
def test_grid_points_in_other_forms(tmp_path, form):
    agrees(read(tmp_path, deck(GRIDS[form])))


@pytest.mark.parametrize("form", BRICKS)
def test_elements_in_other_forms(tmp_path, form):
    agrees(read(tmp_path, deck(brick=BRICKS[form])))


def test_lines_that_continue_cards_stand_below_them(tmp_path):
    heads = deck(
        lambda n, x, y, _: large("GRID*", n, "", x, y).rstrip("\n") + f"*G{n}\n",
        lambda n, *c: small("CHEXA", n, 1, *c[:6], f"+E{n}"),
    )
    tails = "".join(large(f"*G{name}", point[2]) for name, point in POINTS.items())
    tails += "".join(small(f"+E{name}", *nodes[6:]) for name, nodes in NODES.items())
    for lines in (heads + tails, tails + heads):
        with pytest.raises(fo.ModelError, match=r"deck j\.bdf: the line '\*G.* does not continue"):
            read(tmp_path, lines)


def test_what_stands_outside_the_bulk_data_is_left_out(tmp_path):
    agrees(read(tmp_path, deck() + "ENDDATA\n" + deck(lambda n, x, y, _: grid(n, x, y, 9.0))))
    (tmp_path / "points.inc").write_text(deck(brick=lambda *_: ""))
    elements = deck(grid=lambda *_: "")
    for include in ("INCLUDE 'points.inc'", 'include "points.inc"', "INCLUDE 'poi\n  nts.inc'"):
        agrees(read(tmp_path, f"{include}\n{elements}"))


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("GRID,1,,9.,9.,9.\n", "two cards GRID 1 differ; give the bulk data of one job"),
        ("CHEXA,1,1,3,2,5,4,7,8\n,11,10\n", "two cards CHEXA 1 differ"),
        ("GRID,1,,0.,0.,zero\n", r"the card GRID 1 cannot be read \(.*ZERO"),
        ("BEGIN SUPER=1\nGRID,1,,9.,9.,9.\n", "several parts.*: BEGIN BULK, BEGIN SUPER=1; give"),
        ("GRID,501,,0.,0.,0.\n=,*1,=,*1.,==\n=3\n", r"the line '=,\*1,=,\*1\.,==' repeats the"),
        ("CHEXA,9,1,1,2,5,4,7,8,11,10\n", "CHEXA 9 has a line of more than ten fields"),
        ("INCLUDE 'gone.inc'\n", r"deck: there is no file '.*gone\.inc'"),
        ("INCLUDE 'j.bdf'\n", "it includes itself"),
    ],
)
def test_what_would_be_read_wrongly_is_refused(tmp_path, more, message):
    with pytest.raises(fo.ModelError, match=message):
        read(tmp_path, deck() + more)


def column(form, head, rows):
    """A column of DMIG: grid point and direction, and those of its rows with their values."""
    if form == "small":
        entries = ["KAAX", *head, ""]
        for node, direction, value in rows:
            entries += [node, direction, f"{value:.1f}", ""]
        lines = [entries[i : i + 8] for i in range(0, len(entries), 8)]
        return "".join(small("" if i else "DMIG", *line) for i, line in enumerate(lines))
    if form == "commas":
        lines = [f"*,{node},{direction},{value!r}\n" for node, direction, value in rows]
        return f"DMIG*,KAAX,{head[0]},{head[1]}\n" + "".join(lines)
    between = {"large": "", "comments": "$ next\n", "blank lines": "\n"}[form]
    lines = [large("*", node, direction, f"{value:.9E}") for node, direction, value in rows]
    return between.join([large("DMIG*", "KAAX", *head), *lines])


@pytest.mark.parametrize("form", ["small", "large", "commas", "comments", "blank lines"])
@pytest.mark.parametrize("has_header_first", [True, False])
def test_matrices_in_other_forms(tmp_path, form, has_header_first):
    K, labels = PLAIN.K.toarray(), PLAIN.labels.tolist()
    columns = ""
    for j, head in enumerate(labels):
        rows = [(*labels[i], float(K[i, j])) for i in range(j, len(K)) if K[i, j]]
        columns += column(form, head, rows)
    header = "DMIG,KAAX,0,6,2,0\n"
    (tmp_path / "k.pch").write_text(header + columns if has_header_first else columns + header)
    agrees(fo.readers.read_nastran(tmp_path / "k.pch", deck=DATA / "joint.bdf"))


def test_matrices_of_two_jobs_in_one_file_are_refused(tmp_path):
    text = (DATA / "joint.pch").read_text()
    (tmp_path / "k.pch").write_text(text + text)
    with pytest.raises(fo.ModelError, match=r"k\.pch has KAAX 2 times; give a file of one job"):
        fo.readers.read_nastran(tmp_path / "k.pch")


def test_results_behind_the_matrix_are_left_out(tmp_path):
    """A punch file may also have displacements, on lines that begin with blanks."""
    results = (
        "$TITLE   = JOINT\n$DISPLACEMENTS\n"
        "         1       G      0.000000E+00      1.000000E+00      0.000000E+00             999\n"
        "-CONT-                 0.000000E+00      0.000000E+00      0.000000E+00            1000\n"
    )
    text = (DATA / "joint.pch").read_text()
    assert re.search(r"\n\*.*\n$", text)
    (tmp_path / "k.pch").write_text(text + results)
    agrees(fo.readers.read_nastran(tmp_path / "k.pch", deck=DATA / "joint.bdf"))
