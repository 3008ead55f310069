"""Pictures of transients and steady states: loops, history, work along the contact; the onset."""

from collections.abc import Mapping

import numpy as np

from ..base import SIMULTANEOUS, Array
from ..contact.pictures import (
    ONE_NODE,
    Circles,
    faces_of,
    node_at,
    panels_of,
    shear_ratios,
    traction_axis,
    work_label,
)
from ..plots.along import along, lines_or_band
from ..plots.face import face_map
from ..plots.style import (
    AnyAxes,
    as_is,
    legend,
    line,
    new_axes,
    no_lines,
    picture,
    series,
    together,
    unit,
)
from .fretting import slip_ways
from .onset import Onset
from .outcome import SteadyState
from .trajectory import LoadLoop, Trajectory

# A loop looks like a line if its area is below this share of the rectangle around it.
_THIN = 0.1

_WORK = "force times length"


@picture.register
def _trajectory(path: Trajectory, ax: AnyAxes) -> AnyAxes:
    """Panels for the nodes with the most work: shear against slip, and slip against time.

    Shear against slip has a panel for each tangent. The last panel shows the slip, in space its
    size, over the corners visited.
    """
    system = path.system
    tangents = system.tangents
    panels = new_axes(ax, tangents + 1, (6.4, 4.4 + 2.0 * tangents), common_x=False)
    *loops, history = panels
    nodes = np.argsort(-path.work[-1], kind="stable")[:3]
    shape = (*path.gap.shape, tangents)
    slip = (path.slip / system.stretch).reshape(shape)[:, nodes]
    q = (path.q * system.stretch).reshape(shape)[:, nodes]
    for axis, axes in enumerate(loops):
        index = "" if tangents == 1 else f"_{axis + 1}"
        force = unit("force", system.per_depth)
        axes.set(xlabel=f"slip $v{index}$ (length)", ylabel=f"shear force $q{index}$ {force}")
        for k, node in enumerate(nodes):
            axes.plot(slip[:, k, axis], q[:, k, axis], label=node_at(system, node), **line(k))
    size = slip[:, :, 0] if tangents == 1 else np.linalg.norm(slip, axis=2)
    for k in range(len(nodes)):
        history.plot(path.time, size[:, k], **line(k))
    works = path.work[-1].any()
    loops[0].set_title("nodes with the most work of friction" if works else "no node slips")
    legend(loops[0])
    name = "slip $v$ (length)" if tangents == 1 else "size of the slip $v$ (length)"
    history.set(xlabel="corners visited (0: mean load)", ylabel=name)
    return np.array(panels)


@picture.register
def _steady_state(steady: SteadyState, ax: AnyAxes) -> AnyAxes:
    """Panels of the slip range, the tractions at the corners, and the work of friction per cycle.

    Without a width of the nodes, nodal forces are drawn instead of tractions. In space maps show
    the work of friction per cycle of each node, and the slip range as arrows.
    """
    system = steady.system
    outcome = steady.outcome.name.lower().replace("_", " ")
    work = f"{steady.dissipation:.4g} {unit(_WORK, system.per_depth)}"
    if system.tangents == 2:
        title = f"{outcome}, work of friction per cycle {work}"
        return work_map(ax, steady, title)
    panels = new_axes(ax, 3, (6.4, 7.6))
    panels[0].set_title(f"{outcome}, $W$ = {work} per cycle")
    states = steady.states()
    names = list(map(as_is, steady.cycle.corner_names))
    if steady.period == 2:
        names += [f"{name}, second cycle" for name in names]
    corners = np.searchsorted(states.time, np.arange(1, len(names) + 1) + SIMULTANEOUS) - 1
    width, name = traction_axis(system, "traction", "nodal force")
    q, p = states.q[corners] / width, states.p[corners] / width
    lines_or_band(panels[1], system, q, names, prefix="$q$, ", band=series(0)["color"])
    lines_or_band(
        panels[1], system, p, names, prefix="$p$, ", band=series(1)["color"], lw=0.5, alpha=0.8
    )
    panels[1].set_ylabel(name)
    legend(panels[1])
    ranges, works = slip_and_work({"": steady})
    along(panels, system, [ranges, None, works])
    return np.array(panels)


@picture.register
def _load_loop(loop: LoadLoop, ax: AnyAxes) -> AnyAxes:
    """Load against displacement, with a mark where nodes begin or cease to slip.

    If the size of the load is known, the axes are force and mean motion. If the loop is thin, the
    load minus secant stiffness times displacement is drawn.
    """
    (axes,) = new_axes(ax)
    work = unit(_WORK, loop.per_depth)
    x_name, y_name = f"displacement, work over amplitude {work}", "amplitude of the load case"
    of_stiffness = "(1 / force)" if loop.per_depth else f"(1 / {_WORK})"
    size = 1.0
    if np.isfinite(loop.load_size):
        size = loop.load_size
        x_name = "mean motion of the load (length)"
        y_name = f"force {unit('force', loop.per_depth)}"
        of_stiffness = unit("force per length", loop.per_depth)
    displacement = loop.displacement / size
    amplitude = loop.amplitude * size
    stiffness = loop.stiffness * size**2
    around = float(np.ptp(displacement) * np.ptp(amplitude))
    if 0 < loop.area < _THIN * around:
        middle = (displacement.max() + displacement.min()) / 2
        amplitude = amplitude - stiffness * (displacement - middle)
        y_name = f"{y_name}\nbeyond the secant stiffness"
    label = f"area {loop.area:.4g} {work}"
    axes.plot(displacement, amplitude, color=series(0)["color"], label=label)
    changes = np.flatnonzero(np.diff(loop.slipping, prepend=loop.slipping[:1]))
    axes.plot(
        displacement[changes],
        amplitude[changes],
        linestyle="none",
        marker="o",
        markersize=4,
        mfc="white",
        color=series(1)["color"],
        label="nodes begin or cease to slip",
    )
    name = as_is(repr(loop.case))
    axes.set_title(f"load case {name}: secant stiffness {stiffness:.4g} {of_stiffness}")
    axes.set(xlabel=x_name, ylabel=y_name)
    legend(axes)
    return axes


def work_map(ax: AnyAxes, steady: SteadyState, title: str) -> AnyAxes:
    """Work of friction per cycle at each node that closes, and the slip range as arrows.

    An arrow has the length and the direction of the largest difference of two slips of the cycle.
    """
    panels = panels_of(ax, steady.system)
    panels[0].set_title(title)
    states = steady.states()
    return face_map(
        panels,
        faces_of(steady.system),
        steady.dissipation_per_node,
        f"work of friction per cycle ({_WORK})",
        slip=slip_ways(states),
        slip_name="slip range",
        to_and_fro=True,
        opened=states.gap.min(axis=0) > 0,
    )


def slip_and_work(states: Mapping[str, SteadyState]) -> list[tuple[str, dict[str, Array]]]:
    """Rows of `along`: the slip ranges of steady cycles, and their work of friction per cycle."""
    ranges, works = dict[str, Array](), dict[str, Array]()
    for label, steady in states.items():
        ranges[label] = np.asarray(steady.fretting_table()["slip_range"])
        works[label] = steady.dissipation_per_node
        name = work_label(steady.system)
    return [("slip range (length)", ranges), (name, works)]


@picture.register
def _onset(onset: Onset, ax: AnyAxes) -> AnyAxes:
    """Shear over friction bound in the bonded contact, at the first slip towards each corner.

    In space only the first slip of all is drawn. Slipping nodes are circled.
    """
    system = onset.system
    panels = panels_of(ax, system)
    title = "contact under the settled mean load, at the onset of slip"
    if onset.mean_admissible:
        title = "bonded contact at the onset of slip"
    elif onset.state is None:
        title = "bonded contact; the mean load makes it slip, or pulls"
    panels[0].set_title(title)
    events = [event for event in onset.slips if event.node is not None]
    if not events:
        no_lines(panels, "no corner makes a node slip")
        return together(panels)
    first = events.index(onset.slip)
    q, p = (part[[event.corner for event in events]] for part in onset.reactions)
    drawn = range(len(events)) if system.tangents == 1 else [first]
    circles: Circles = {k: (events[k].node, events[k].sense, ONE_NODE) for k in drawn}
    names = [rf"{as_is(event.loads)}, $\lambda = {event.load_factor:.4g}$" for event in events]
    label = "node that slips first"
    return shear_ratios(panels, onset, q, p, names, circles, label, first)
