import itertools
from io import StringIO

import numpy as np
import pandas as pd
import pytest

import frictopt as fo
from helpers.refused import refused
from helpers.systems import random_system, unit_nodes


@refused(
    ({"P": 1.0}, [], "corners: empty"),
    ({"P": 1.0}, [1.0], r"corners\[0\]: a float"),
    ({"P": np.nan}, [{"sigma": 1.0}], r"mean\['P'\]: nan; it must be finite"),
    ({"P": 1.0}, [{"sigma": 1.0}, {"sigma": np.inf}], r"corners\[1\]\['sigma'\]: inf"),
    ({1: 1.0}, [{"sigma": 1.0}], "load case name 1"),
    (pd.Series({"P": 1.0}), [], r"mean: a Series; give a mapping \(`dict` converts it\)"),
    (
        {},
        pd.DataFrame({"P": [1.0]}),
        r"corners: a DataFrame; give a list \(its to_dict\('records'\) converts it\)",
    ),
)
def test_bad_cycles_are_refused(mean, corners):
    fo.LoadCycle(mean=mean, corners=corners)


def test_the_text_of_a_long_cycle_is_short():
    corners = [{"sigma": float(k)} for k in range(200)]
    text = repr(fo.LoadCycle({"P": 1.0}, corners))
    assert text.endswith("{'sigma': 3.0}, ... 200 in all])") and len(text) < 150
    assert repr(fo.LoadCycle({}, corners[:4])).endswith("{'sigma': 3.0}])")


def test_reactions_of_a_cycle():
    system = random_system(np.random.default_rng(0), 3, loads=("mean", "a", "b"))
    cycle = fo.LoadCycle(mean={"mean": 2.0}, corners=[{"a": 1.0}, {"a": -1.0, "b": 0.5}, {}])
    q1, p1 = cycle.corner_reactions(system)
    assert np.array_equal(cycle.mean_reaction(system)[1], 2 * system.bonded["mean"][1])
    assert np.allclose(q1[1], -system.bonded["a"][0] + 0.5 * system.bonded["b"][0])
    assert not q1[2].any() and not p1[2].any() and p1.shape == (3, 3)


def random_history(rng, points):
    """A history of two load cases that turn at random, and its turning points.

    The history also has points on the straight segments between its turning points.
    """
    turns = rng.uniform(-1, 1, size=(points, 2))
    shares = np.linspace(0, 1, 5)[:-1]
    rows = [a + share * (b - a) for a, b in itertools.pairwise(turns) for share in shares]
    frame = pd.DataFrame([*rows, turns[-1]], columns=["a", "b"])
    return frame.assign(time=np.arange(len(frame)) * 0.1), turns


def test_a_history_keeps_its_turning_points_and_no_others():
    history, turns = random_history(np.random.default_rng(3), 40)
    cycle = fo.LoadCycle.from_history(history, mean={"mean": 1.0})
    assert cycle.mean == {"mean": 1.0}
    assert np.array_equal([[corner["a"], corner["b"]] for corner in cycle.corners], turns)


def test_a_history_less_its_mean_is_what_the_load_factor_scales():
    history = pd.DataFrame(
        {"Time": [0.0, 0.5, 2.0], "P": [3.0, 3.0, 3.0], "sigma": [1.0, 5.0, 2.0]}
    )
    assert fo.LoadCycle.from_history(history) == fo.LoadCycle(
        {"P": 3.0, "sigma": 3.0}, [{"sigma": -2.0}, {"sigma": 2.0}, {"sigma": -1.0}]
    )
    cycle = fo.LoadCycle.from_history(history, mean={"P": 2.0, "extra": 1.0}, time="Time")
    assert cycle == fo.LoadCycle(
        {"P": 2.0, "extra": 1.0}, [{"P": 1.0, "sigma": s} for s in (1.0, 5.0, 2.0)]
    )
    still = fo.LoadCycle.from_history(history[["P"]])
    assert still == fo.LoadCycle({"P": 3.0}, [{}])


@pytest.mark.parametrize("gap", [0.0, 1e-16])
def test_a_closed_history_comes_back_to_its_first_corner_once(gap):
    history = pd.DataFrame({"time": range(4), "P": 5.0, "sigma": [1.0, -1.0, 3.0, 1.0 + gap]})
    cycle = fo.LoadCycle.from_history(history, mean={"P": 5.0})
    assert cycle == fo.LoadCycle({"P": 5.0}, [{"sigma": s} for s in (1.0, -1.0, 3.0)])
    assert cycle.times == (0, 1, 2, 3)
    assert cycle.corner_names == ("t = 0: sigma = +1", "t = 1: sigma = -1", "t = 2: sigma = +3")
    other = fo.LoadCycle.from_history(
        history.assign(sigma=[1.0, -1.0, 3.0, 1.0 + 1e-9]), mean={"P": 5.0}
    )
    assert len(other.corners) == 4


def frechet(one, other):
    """Discrete Frechet distance of two paths in the largest norm, by its definition."""
    far = np.abs(one[:, None] - other[None]).max(axis=2)
    reach = np.full((len(one) + 1, len(other) + 1), np.inf)
    reach[0, 0] = 0.0
    for total in range(2, len(one) + len(other) + 1):  # all pairs with this sum at once
        i = np.arange(max(1, total - len(other)), min(len(one), total - 1) + 1)
        j = total - i
        before = np.minimum(np.minimum(reach[i - 1, j], reach[i, j - 1]), reach[i - 1, j - 1])
        reach[i, j] = np.maximum(far[i - 1, j - 1], before)
    return reach[-1, -1]


@pytest.mark.parametrize("cases", [1, 2, 3])
def test_a_filtered_history_stays_within_the_tolerance_in_its_order(cases):
    rng = np.random.default_rng(cases)
    names = [f"load {k}" for k in range(cases)]
    for _ in range(5):
        path = np.cumsum(rng.normal(size=(60, cases)), axis=0) * [1.0, 30.0, 7.0][:cases]
        cycle = fo.LoadCycle.from_history(pd.DataFrame(path, columns=names), mean={}, tolerance=0.1)
        kept = np.array([[corner[name] for name in names] for corner in cycle.corners])
        assert len(kept) < 40 and np.array_equal(kept[[0, -1]], path[[0, -1]])
        size = np.ptp(path, axis=0)
        fine = np.linspace(0, 1, 21)[:-1, None]
        paths = (
            np.concatenate(
                [(a + fine * (b - a)) / size for a, b in itertools.pairwise(points)]
                + [points[-1:] / size]
            )
            for points in (path, kept)
        )
        # The points along the straight ways are so far from each other.
        assert frechet(*paths) < 0.1 + 0.05


def test_one_filtered_load_keeps_the_reversals_that_exceed_the_noise():
    """The load has large triangles between 0 and 1, a small one, and noise of 2 % on 20,000 points."""
    rng = np.random.default_rng(0)
    turns = np.array([0.0, 1.0, 0.4, 0.6, 0.0, 1.0, 0.0])
    time = np.linspace(0, 6, 20_001)
    noisy = np.interp(time, np.arange(7), turns) + rng.uniform(-0.02, 0.02, len(time))
    cycle = fo.LoadCycle.from_history(
        pd.DataFrame({"time": time, "sigma": noisy}), mean={}, tolerance=0.05
    )
    assert [corner["sigma"] for corner in cycle.corners] == pytest.approx(turns, abs=0.04)
    assert cycle.times == pytest.approx(np.arange(7), abs=0.15)
    coarse = fo.LoadCycle.from_history(
        pd.DataFrame({"time": time, "sigma": noisy}), mean={}, tolerance=0.15
    )
    assert [corner["sigma"] for corner in coarse.corners] == pytest.approx(
        turns[[0, 1, 4, 5, 6]], abs=0.04
    )


def test_corners_are_called_by_their_loads_and_times():
    days = pd.DataFrame({"day": pd.to_datetime(["2020-01-01", "2020-01-02"]), "P": [1.0, 3.0]})
    assert fo.LoadCycle.from_history(days, time="day").corner_names == (
        "t = 2020-01-01 00:00:00: P = -1",
        "t = 2020-01-02 00:00:00: P = +1",
    )
    assert fo.LoadCycle({}, [{"P": 1.0}, {"P": 1.0}, {}]).corner_names == (
        "P = +1 (corner 0)",
        "P = +1 (corner 1)",
        "mean load",
    )
    many = {f"c{k}": 1.0 for k in range(50)}
    assert fo.LoadCycle({}, [many, many | {"c49": 2.0}]).corner_names == tuple(
        f"c0 = +1, c1 = +1, c2 = +1, c3 = +1, c4 = +1 and 45 more loads (corner {k})"
        for k in range(2)
    )
    assert fo.LoadCycle({}, [{"x": 1.0, "y": 0.0}, {"x": 6e-17, "y": 1.0}]).corner_names == (
        "x = +1",
        "y = +1",
    )
    assert fo.LoadCycle({}, [{"Q": 1.0}, {"Q": 1.0}], [{"P": -0.5}, {"P": 0.5}]).corner_names == (
        "Q = +1, P = -0.5 fixed",
        "Q = +1, P = +0.5 fixed",
    )
    with pytest.raises(fo.ModelError, match="times: 1 for 2 corners"):
        fo.LoadCycle({}, [{"P": 1.0}, {}], times=[0.0])


SECONDS = pd.to_timedelta([0.0, 0.5, 2.0], unit="s")


@pytest.mark.parametrize(
    "index", [SECONDS, pd.Timestamp("2020-01-01") + SECONDS, pd.Index([0.0, 0.5, 2.0], name="Time")]
)
def test_an_index_of_times_is_the_time(index):
    history = pd.DataFrame({"P": [1.0, 3.0, 2.0]}, index=index)
    cycle = fo.LoadCycle.from_history(history)
    assert cycle.times == ((0.0, 0.5, 2.0) if index is SECONDS else tuple(index))
    assert cycle == fo.LoadCycle.from_history(history.reset_index(drop=True))
    # A column of that name comes first.
    assert fo.LoadCycle.from_history(history.assign(time=[5, 6, 7])).times == (5, 6, 7)
    assert all(name.startswith("t = ") for name in cycle.corner_names)


@refused(
    (pd.DataFrame({"time": [0.0, 1.0]}), {}, "2 rows, 0 load cases"),
    (pd.DataFrame({"a": []}), {}, "0 rows, 1 load case"),
    (pd.DataFrame({"a": [1.0, np.nan]}), {}, r"history\['a'\]: nan at index 1"),
    (
        pd.DataFrame({"a": [1.0, 2.0], "time": [1.0, 0.0]}),
        {},
        r"history\['time'\]: the time decreases",
    ),
    (
        pd.DataFrame({"a": [1.0, 2.0], "time": [1.0, np.nan]}),
        {},
        r"history\['time'\]: the time decreases or is missing",
    ),
    (
        pd.read_csv(StringIO("time,a\ns,N\n0,1\n1,-1\n")),
        {},
        r"history\['time'\]: the text 's' is among the times; .* row of units",
    ),
    (pd.DataFrame([[1.0, 2.0]], columns=["a", "a"]), {}, "the column 'a' occurs twice"),
    (pd.DataFrame([[1.0]]), {}, "history: load case name 0"),
    (
        pd.DataFrame({"time": [0.0], "a": [1.0], "b": [2.0]}).set_index(["time", "a"]),
        {},
        r"2 levels; .* reset_index\(\)",
    ),
    (
        pd.DataFrame({"a": [1.0, 2.0]}, index=pd.to_datetime([1, 0])),
        {},
        r"history\.index: the time decreases",
    ),
    (
        pd.DataFrame({"a": [1.0, 2.0]}, index=pd.Index(["0:10", "0:20"], name="time")),
        {},
        "'0:10' is neither .*pandas.to_datetime",
    ),
    (pd.DataFrame({"a": [1.0, 2.0]}), {"tolerance": -0.1}, "tolerance: -0.1"),
    (
        pd.DataFrame({"date": pd.to_datetime([0, 1]), "a": [1.0, 2.0]}),
        {},
        r"history\['date'\]: .* is no number; .* say time='date' if this",
    ),
    (
        pd.DataFrame({"day": ["1 May", "2 May"], "a": [1.0, 2.0]}),
        {},
        r"history\['day'\]: '1 May' is no number; .* say time='day' if this",
    ),
    (
        pd.Series([1.0, 2.0], name="a"),
        {},
        r"history: a Series; give a pandas DataFrame \(its to_frame\(name\) makes one\)",
    ),
)
def test_bad_histories_are_refused(history, options):
    fo.LoadCycle.from_history(history, **options)


@pytest.mark.parametrize("time", [np.nan, np.inf, True, pd.NaT, "0:10", np.timedelta64("NaT")])
def test_times_are_finite_numbers_or_dates(time):
    for corners in (1, 2):
        with pytest.raises(fo.ModelError, match="times: "):
            fo.LoadCycle({}, [{"P": 1.0}] * corners, times=[0.0, time])
    assert fo.LoadCycle({}, [{"P": 1.0}], times=np.array([0, 1500], "m8[ms]")).times == (0.0, 1.5)


@pytest.mark.parametrize(("clock", "options"), [("time", {}), ("t", {"time": "t"})])
def test_an_index_of_several_levels_beside_a_column_of_the_time_is_no_time(clock, options):
    history = pd.DataFrame(
        {"machine": [7, 7], "run": [1, 2], clock: [0.5, 2.0], "a": [1.0, 2.0]}
    ).set_index(["machine", "run"])
    assert fo.LoadCycle.from_history(history, **options).times == (0.5, 2.0)


def test_vertices_are_all_sums_and_neighbours_differ_in_one_load():
    circle = [{"x": np.cos(t), "y": np.sin(t)} for t in np.arange(6)]
    cycle = fo.LoadCycle.vertices(
        {"P": 1.0}, {"a": (-1.0, 2.0), "b": (0.0, 0.0)}, circle, {"c": (3.0, 4.0)}
    )
    points = [(c["a"], c["b"], (c["x"], c["y"]), c["c"]) for c in cycle.corners]
    corners = [(c["x"], c["y"]) for c in circle]
    assert set(points) == set(itertools.product((-1.0, 2.0), (0.0,), corners, (3.0, 4.0)))
    assert len(points) == 24
    assert all(
        sum(one != other for one, other in zip(*pair, strict=True)) == 1
        for pair in itertools.pairwise(points)
    )


@refused(
    ((), "loads: none"),
    (({},), "loads: none"),
    (({"a": (1.0, 0.0)},), r"loads\[0\]\['a'\] most: 0.0; it must be finite and at least 1"),
    (
        ({"a": (0.0, 1.0, 2.0)},),
        r"loads\[0\]\['a'\] \(least, most\): shape \(3,\), expected \(2,\)",
    ),
    (
        ({"a": (0.0, True)},),
        r"loads\[0\]\['a'\] \(least, most\): \(0.0, True\) \(True and False are not numbers\)",
    ),
    (([],), r"loads\[0\]: no corners"),
    (({"a": (0.0, 1.0)}, [{"a": 1.0}]), "load case 'a' is in two loads"),
    (({f"a{k}": (0.0, 1.0) for k in range(20)},), "1.05e[+]06 vertices"),
)
def test_bad_domains_are_refused(loads):
    fo.LoadCycle.vertices({"P": 1.0}, *loads)


def test_a_reversal_is_a_turning_point_however_far_the_way_back_goes():
    """It lies on the line through its neighbours, but not between them."""
    history = pd.DataFrame({"sigma": [0.0, -1.0, 1.0, 3.0, -3.0]})
    assert [corner["sigma"] for corner in fo.LoadCycle.from_history(history, mean={}).corners] == [
        0.0,
        -1.0,
        3.0,
        -3.0,
    ]


def rotated(turn, size, mean=1.0):
    """One uncoupled node under a normal load `mean`, and loads a quarter of a cycle apart.

    The loads are a shear and a normal load, at the corners of a polygon, which is turned by `turn`
    degrees.
    """
    bonded = {"P": ([0.0], [mean]), "Q": ([1.0], [0.0]), "N": ([0.0], [1.0])}
    return unit_nodes(bonded), {
        "Q": (size, turn),
        "N": (1.0, 90.0 + turn),
    }


@pytest.mark.parametrize("points", [3, 4, 7, 16, 64])
@pytest.mark.parametrize(
    ("friction", "size", "turn"), [(0.3, 1.0, 0.0), (0.8, 0.5, 33.0), (0.5, 2.0, 100.0)]
)
def test_loads_a_quarter_apart_have_the_limit_of_their_ellipse_within_the_error_of_the_polygon(
    points, friction, size, turn
):
    """A node sticks while `|Q cos t| <= f (P - N sin t)`, so up to `f P / sqrt(Q^2 + f^2 N^2)`
    (Jang & Barber 2011: the phase counts)."""
    node, loads = rotated(turn, size)
    exact = friction / np.hypot(size, friction)
    limit = fo.shakedown_limit(
        node, fo.LoadCycle.harmonic(loads, mean={"P": 1.0}, points=points), friction
    ).load_factor
    assert exact * (1 - 1e-9) <= limit <= exact / np.cos(np.pi / points) * (1 + 1e-9)
    if points == 64:
        assert limit == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("phases", [(0, 0), (30, 30), (30, 210), (30, 390), (-75, 105)])
def test_loads_in_phase_or_opposed_go_to_and_fro(phases):
    cycle = fo.LoadCycle.harmonic(
        {"a": (2.0, phases[0]), "b": (-0.5, phases[1]), "none": (0.0, 45)},
        mean={"P": 1.0},
        points=5,
    )
    sense = -0.5 if (phases[1] - phases[0]) % 360 == 0 else 0.5
    ends = np.array([list(corner.values()) for corner in cycle.corners])
    assert ends.shape == (2, 3)
    assert np.abs(ends - [[2.0, sense, 0.0], [-2.0, -sense, 0.0]]).max() < 1e-14


def test_a_positive_phase_is_ahead():
    cycle = fo.LoadCycle.harmonic({"a": 1.0, "b": (1.0, 60)}, mean={}, points=360)
    b = [corner["b"] for corner in cycle.corners]
    # 60 degrees before the peak of a, at 0.
    assert int(np.argmax(b)) == 300
    assert len(cycle.corners) == 360


@refused(
    ([1.0], {}, "loads: a list; give a mapping, load case name"),
    ({}, {}, "loads: {}; give at least one load case an amplitude"),
    ({"a": (0.0, 90)}, {}, "give at least one load case an amplitude"),
    ({"a": (1.0,)}, {}, r"loads\['a'\]: \(1.0,\); give its amplitude"),
    ({"a": "x"}, {}, r"loads\['a'\] amplitude: 'x'"),
    ({"a": (1.0, np.inf)}, {}, r"loads\['a'\] phase: inf"),
    ({"a": (1.0, 0), "b": (1.0, 90)}, {"points": 2}, "points: 2"),
)
def test_bad_harmonic_loads_are_refused_by_name(loads, options):
    fo.LoadCycle.harmonic(loads, mean={}, **options)
