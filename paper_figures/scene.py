"""Geometry, supports, loads and mesh of the punch on the half-plane."""

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

import frictopt as fo
from frictopt.plots.bodies import draw_mesh
from studies.tables import Table

from .style import BLACK, SERIES, WIDE, new_figure, panel_label

TABLES: Mapping[str, Table[Any]] = {}

_PUNCH, _BLOCK = SERIES[1]["color"], SERIES[0]["color"]
_LINE = {"color": BLACK, "shrinkA": 0, "shrinkB": 0}
_LOAD = _LINE | {"arrowstyle": "-|>", "mutation_scale": 6, "lw": 0.8}
_AXIS = _LINE | {"arrowstyle": "->", "mutation_scale": 6, "lw": 0.8}
_LENGTH = _LINE | {"arrowstyle": "<|-|>", "mutation_scale": 5, "lw": 0.5}
# A white background keeps a word legible on the lines of the mesh.
_ON_MESH = {
    "facecolor": "white",
    "edgecolor": "none",
    "pad": 0.8,
}
# Half the width of the panel of the corner, over a.
_ZOOM = 0.12


def draw(tables: Mapping[str, pd.DataFrame]) -> Figure:
    """Left: the whole scene. Right: the mesh at the right corner of the contact."""
    scene = fo.scenes.PunchOnHalfPlane()
    figure = new_figure(WIDE, 70)
    whole, corner = figure.subplots(1, 2, width_ratios=[1.95, 1])
    for axes in (whole, corner):
        _mesh(axes, scene)
        axes.set_aspect("equal")
    side, depth, height = (
        length / scene.half_width
        for length in (scene.block_half_width, scene.block_depth, scene.punch_height)
    )
    _supports(whole, side, depth)
    _loads(whole, side, depth, height)
    _dimensions(whole, side, depth, height)
    whole.set_axis_off()
    panel_label(whole, "a")
    _corner(corner, scene)
    panel_label(corner, "b")
    return figure


def _mesh(axes: Any, scene: fo.scenes.PunchOnHalfPlane) -> None:
    model = scene.model()
    for name, color in (("block", _BLOCK), ("punch", _PUNCH)):
        draw_mesh(axes, model.bodies[name].mesh.scaled(1 / scene.half_width), color)


def _loads(axes: Any, side: float, depth: float, height: float) -> None:
    for x in (-0.8, -0.4, 0.0, 0.4, 0.8):
        axes.annotate("", (x, height), (x, height + 1.4), arrowprops=_LOAD)
    axes.plot([-1, 1], [height + 1.4] * 2, color=BLACK, lw=0.8)
    axes.text(1.3, height + 0.9, "$P$", ha="left", va="center")
    for sense, align in ((-1, "right"), (1, "left")):
        for share in (0.1, 0.3, 0.5, 0.7, 0.9):
            axes.annotate(
                "",
                (sense * (side + 1.5), -share * depth),
                (sense * side, -share * depth),
                arrowprops=_LOAD,
            )
        axes.text(sense * (side + 1.7), -depth / 2, r"$\sigma(t)$", ha=align, va="center")


def _supports(axes: Any, side: float, depth: float) -> None:
    """Rollers along the bottom. The node in the middle of the bottom is also held sideways."""
    radius = 0.3
    ground = -depth - 2 * radius
    for share in (-0.96, -0.72, -0.48, -0.24, 0.24, 0.48, 0.72, 0.96):
        axes.add_patch(
            Circle((share * side, -depth - radius), radius, fill=False, ec=BLACK, lw=0.7)
        )
    axes.add_patch(
        Polygon([(0, -depth), (-0.5, ground), (0.5, ground)], facecolor=BLACK, ec=BLACK, lw=0.7)
    )
    axes.fill_between(
        [-side, side],
        ground - 0.5,
        ground,
        facecolor="none",
        edgecolor=BLACK,
        hatch="//////",
        linewidth=0,
    )
    axes.plot([-side, side], [ground, ground], color=BLACK, lw=0.7)


def _dimensions(axes: Any, side: float, depth: float, height: float) -> None:
    axes.annotate("", (-1, -1.3), (1, -1.3), arrowprops=_LENGTH)
    axes.text(0, -1.7, "$2a$", ha="center", va="top", bbox=_ON_MESH)
    axes.annotate("", (-1.6, 0), (-1.6, height), arrowprops=_LENGTH)
    axes.text(-1.9, height / 2, f"${height:g}a$", ha="right", va="center")
    below = -depth - 1.8
    axes.annotate("", (-side, below), (side, below), arrowprops=_LENGTH)
    axes.text(0, below, f"${2 * side:g}a$", ha="center", va="center", bbox=_ON_MESH)
    axes.annotate("", (-0.7 * side, 0), (-0.7 * side, -depth), arrowprops=_LENGTH)
    axes.text(-0.7 * side, -depth / 2, f"${depth:g}a$", ha="center", va="center", bbox=_ON_MESH)
    axes.annotate("", (3.2, 0), (0, 0), arrowprops=_AXIS)
    axes.text(3.4, 0.15, "$x$", ha="left", va="bottom")
    axes.annotate("", (0, 1.7), (0, 0), arrowprops=_AXIS)
    axes.text(0.25, 1.25, "$y$", ha="left", va="center", bbox=_ON_MESH)
    axes.add_patch(Circle((1, 0), 0.4, fill=False, ec=BLACK, lw=0.7))
    axes.annotate(
        "(b)",
        (1.25, 0.3),
        (5.2, 1.9),
        ha="left",
        va="center",
        arrowprops=_LINE | {"arrowstyle": "-", "lw": 0.5, "shrinkA": 2},
    )
    axes.set_xlim(-side - 3.3, side + 3.3)
    axes.set_ylim(below - 0.5, height + 1.6)


def _corner(axes: Any, scene: fo.scenes.PunchOnHalfPlane) -> None:
    axes.plot([1 - _ZOOM, 1], [0, 0], color=BLACK, lw=1.4)
    axes.text(1 - _ZOOM / 2, _ZOOM / 2, "punch", ha="center", va="center", bbox=_ON_MESH)
    axes.text(1, -_ZOOM / 2, "block", ha="center", va="center", bbox=_ON_MESH)
    axes.annotate(
        "contact",
        (1 - 0.1 * _ZOOM, 0),
        (1 + 0.12 * _ZOOM, 0.3 * _ZOOM),
        va="center",
        arrowprops=_LINE | {"arrowstyle": "-", "lw": 0.5},
    )
    axes.text(
        1 + _ZOOM / 2,
        0.7 * _ZOOM,
        f"corner element\n${scene.corner_size / scene.half_width:.4f}\\,a$",
        ha="center",
        va="center",
    )
    axes.set_xlim(1 - _ZOOM, 1 + _ZOOM)
    axes.set_ylim(-_ZOOM, _ZOOM)
    axes.set_xlabel("$x / a$")
    axes.set_ylabel("$y / a$", labelpad=0)
