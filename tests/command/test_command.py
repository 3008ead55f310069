"""The command line: from files to the answers of the functions, and errors with their exit
codes."""

import os
import signal
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from scipy import stats

import frictopt as fo
from helpers.command import main
from helpers.liars import told
from helpers.systems import CYCLE, random_system

CONTACT = random_system(np.random.default_rng(3), 4)
CORNERS = [
    "--mean",
    "mean=1",
    "--corners",
    *(f"cyclic={corner['cyclic']}" for corner in CYCLE.corners),
]
LIMIT = ["limit", "system.npz", "--friction", "0.4"]
STUDY = """
system = "system.npz"
friction = {friction}
load_factors = [0.5, 2.0]
{files}

[cycle]
mean = {{ mean = 1.0 }}
corners = [{corners}]

[starts]
no_slip = {{}}
random_slips = {{ amplitudes = [0.1], count = 2 }}
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    CONTACT.save("system.npz")
    for name, text in {
        "semicolons": "time;cyclic\n0.0;1.5\n1.0;-1.5\n",
        "decimals": "cyclic\n0,5\n1,5\n-1,5\n",
    }.items():
        Path(f"{name}.csv").write_text(text)
    yield tmp_path
    plt.close("all")


def study_file(friction="0.4", files="", name="study.toml"):
    corners = ", ".join(f"{{ cyclic = {corner['cyclic']} }}" for corner in CYCLE.corners)
    Path(name).write_text(STUDY.format(friction=friction, files=files, corners=corners))


def same(table, other):
    table = table.assign(cycle=table["cycle"].astype(object).fillna(""))
    other = other.astype({"start": str, "family": str, "outcome": str, "engine": str})
    pd.testing.assert_frame_equal(
        table.drop(columns=["seconds", "error", "seed"]),
        other.drop(columns=["seconds", "error", "seed"]),
        check_dtype=False,
        rtol=1e-12,
    )


@pytest.mark.parametrize("kind", ["shakedown", "guaranteed", "onset"])
def test_a_limit_is_that_of_the_function_with_its_table_and_picture(kind, capsys):
    assert (
        main([*LIMIT, *CORNERS, "--kind", kind, "--table", "limit.csv", "--picture", "limit.png"])
        == 0
    )
    question = {
        "shakedown": fo.shakedown_limit,
        "guaranteed": fo.guaranteed_limit,
        "onset": fo.onset,
    }[kind]
    found = question(CONTACT, fo.LoadCycle({"mean": 1.0}, CYCLE.corners), 0.4)
    assert capsys.readouterr().out.startswith(str(found))
    expected = found.to_frame()
    table = pd.read_csv("limit.csv")
    pd.testing.assert_frame_equal(table[list(expected)], expected, check_dtype=False)
    assert plt.imread("limit.png").std() > 0


def test_values_that_are_seldom_meant_are_one_line_of_warning(capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert main(["limit", "system.npz", "--friction", "40", *CORNERS]) == 0
    assert (
        capsys.readouterr().err
        == "frictopt: warning: friction: 40, above 5; give the coefficient of friction, not per cent\n"
    )


def test_a_history_in_a_file_is_a_load_cycle(capsys):
    time = np.linspace(0, 6, 301)
    history = pd.DataFrame(
        {
            "time": time,
            "mean": 1.0,
            "cyclic": np.sin(2 * np.pi * time / 3) + 0.01 * np.cos(300 * time),
        }
    )
    history.to_csv("loads.csv", index=False)
    assert main([*LIMIT, "--history", "loads.csv", "--mean", "mean=1", "--tolerance", "0.05"]) == 0
    cycle = fo.LoadCycle.from_history(pd.read_csv("loads.csv"), mean={"mean": 1.0}, tolerance=0.05)
    assert len(cycle.corners) == 6 and capsys.readouterr().out.startswith(
        str(fo.shakedown_limit(CONTACT, cycle, 0.4))
    )
    history.assign(time=pd.Timestamp("2026-01-01") + pd.to_timedelta(time, unit="h")).rename(
        columns={"time": "when"}
    ).to_csv("loads.csv", index=False)
    arguments = [*LIMIT, "--history", "loads.csv", "--mean", "mean=1", "--tolerance", "0.05"]
    assert main([*arguments, "--time", "when"]) == 0
    assert capsys.readouterr().out.startswith(str(fo.shakedown_limit(CONTACT, cycle, 0.4)))
    assert main(arguments) == 2 and "history['when']" in capsys.readouterr().err


def test_a_contact_of_stored_matrices_is_looked_at(capsys, flat):
    loads = {"P": flat.force("N_TOP", pressure=1.0), "Q": flat.force("N_TOP", traction=[1.0, 0.0])}
    pairs = flat.pairs("N_CONTACT_PUNCH", "N_CONTACT_BLOCK")
    fo.condense(flat.K, loads, pairs, [0.0, 1.0], flat.unknowns, flat.points).save("flat.npz")
    assert main(["look", "flat.npz"]) == 0
    said = capsys.readouterr().out
    assert "P" in said and "10" in said and "e-" not in said
    assert "next: frictopt report flat.npz --mean P=1 --corners Q=-1 Q=1" in said


def test_a_study_in_a_file_is_that_of_the_function_and_its_parts_make_the_whole(capsys):
    """Each part has a store of its own; merged, the study follows no run again."""
    study_file("[0.3, 0.4]", 'store = "runs.sqlite"\ntable = "runs.csv"\npicture = "runs.png"')
    for part in (1, 2):
        assert main(["study", "study.toml", "--shard", f"{part}/2"]) == 0
    assert not Path("runs.csv").exists()
    assert main(["merge", "runs.sqlite", "runs.1-of-2.sqlite", "runs.2-of-2.sqlite"]) == 0
    assert "20 runs in runs.sqlite" in capsys.readouterr().out
    seconds = fo.results.read_store("runs.sqlite").seconds.sum()
    assert main(["study", "study.toml"]) == 0
    starts = fo.starts.no_slip() + fo.starts.random_slips(CONTACT, [0.1], 2)
    expected = fo.dissipation_study(
        CONTACT,
        fo.LoadCycle({"mean": 1.0}, CYCLE.corners),
        [0.3, 0.4],
        [0.5, 2.0],
        starts,
        progress=False,
    )
    table = pd.read_csv("runs.csv")
    same(table, expected)
    assert table.seconds.sum() == pytest.approx(seconds) and plt.imread("runs.png").std() > 0


def test_a_study_in_a_file_takes_a_distribution():
    study_file('{ distribution = "norm", loc = 0.4, scale = 0.05, draws = 2, seed = 7 }')
    assert main(["study", "study.toml", "--table", "runs.csv"]) == 0
    starts = fo.starts.no_slip() + fo.starts.random_slips(CONTACT, [0.1], 2)
    cycle = fo.LoadCycle({"mean": 1.0}, CYCLE.corners)
    same(
        pd.read_csv("runs.csv"),
        fo.dissipation_study(
            CONTACT, cycle, [stats.norm(0.4, 0.05)] * 2, [0.5, 2.0], starts, seed=7, progress=False
        ),
    )


def test_a_study_in_a_file_takes_load_cycles_by_their_labels(capsys):
    plan = """
system = "system.npz"
friction = 0.4
load_factors = [0.5, 2.0]
table = "runs.csv"
[cycle.straight]
mean = { mean = 1.0 }
corners = [{ cyclic = -1.0 }, { cyclic = 1.0 }]
[cycle."90 deg"]
mean = { mean = 1.0 }
harmonic = { cyclic = 1.0, mean = [0.3, 90] }
points = 6
"""
    Path("study.toml").write_text(plan)
    assert main(["study", "study.toml"]) == 0
    turning = fo.LoadCycle.harmonic(
        {"cyclic": 1.0, "mean": (0.3, 90)}, mean={"mean": 1.0}, points=6
    )
    cycles = {
        "straight": fo.LoadCycle({"mean": 1.0}, [{"cyclic": -1.0}, {"cyclic": 1.0}]),
        "90 deg": turning,
    }
    same(
        pd.read_csv("runs.csv"),
        fo.dissipation_study(CONTACT, cycles, 0.4, [0.5, 2.0], progress=False),
    )
    assert "straight" in capsys.readouterr().out
    for old, new, message in (
        ('[cycle."90 deg"]', '[cycle."90 deg"]\nsteps = 3', "cycle.90 deg 'steps' is unknown"),
        (
            '[cycle."90 deg"]',
            '[cycle]\nodd = 3\n[cycle."90 deg"]',
            "cycle.odd: 3; give a table of TOML",
        ),
    ):
        Path("study.toml").write_text(plan.replace(old, new))
        assert main(["study", "study.toml"]) == 2 and message in capsys.readouterr().err


def test_the_forces_of_a_contact_whose_flanks_turn_are_those_of_its_loads(capsys):
    """Pull and sway of 1 on a neck 2 wide, held by two flanks."""
    scene = fo.scenes.Dovetail(elements=6, growth=1.5, neck_half_width=1.0)
    scene.condense().save("root.npz")
    assert main(["look", "root.npz"]) == 0
    rows = {
        name: parts
        for name, *parts in map(str.split, capsys.readouterr().out.splitlines())
        if name in ("pull", "sway")
    }
    sums = {name: [float(part) for part in parts[:2]] for name, parts in rows.items()}
    assert sums == {
        "pull": pytest.approx([0.0, -2.0], abs=1e-4),
        "sway": pytest.approx([-2.0, 0.0], abs=1e-4),
    }


@pytest.mark.parametrize(
    ("arguments", "unbuffered"),
    [
        (["look", "system.npz"], ""),
        (["limit", "--help"], ""),
        ([*LIMIT, *CORNERS, "--table", "limit.csv"], "1"),
    ],
)
def test_a_reader_that_stops_early_hears_no_complaint_and_has_its_files(arguments, unbuffered):
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "frictopt", *arguments]
    done = subprocess.run(
        command,
        stdout=write,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
        env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (141, "") and all(
        Path(file).exists() for file in arguments[-1:] if file.endswith(".csv")
    )


# What is said, and the command that brings it about: exit code 2, and 4 where a file is missing.
WRONG = {
    "(File is not a zip file); give a file that ContactSystem.save wrote": [
        "look",
        "semicolons.csv",
    ],
    "--tolerance: 0.0; only a history has it": [*LIMIT, *CORNERS, "--tolerance", "0"],
    "--time: t; only a history has it": [*LIMIT, *CORNERS, "--time", "t"],
    "has semicolons between its columns": [*LIMIT, "--history", "semicolons.csv"],
    "or rows with more values than names": [
        *LIMIT,
        "--mean",
        "mean=1",
        "--history",
        "decimals.csv",
    ],
    "'cyclic'; give CASE=AMPLITUDE": [*LIMIT, "--corners", "cyclic"],
    "'cyclic=1,cyclic=-1'; give CASE=AMPLITUDE": [*LIMIT, "--corners", "cyclic=1,cyclic=-1"],
    "--corners: there are none": [*LIMIT, "--mean", "mean=1"],
    "--friction: there is none": ["limit", "system.npz", *CORNERS],
    "load case 'other': unknown": [*LIMIT, "--corners", "other=1"],
    "give a file that ends in": [*LIMIT, "--history", "system.npz"],
    "give a file in TOML": ["study", "system.npz"],
    "'limit.doc'; give a file that ends in": [*LIMIT, *CORNERS, "--table", "limit.doc"],
    "'nowhere/limit.png' is in a folder that does not exist": [
        *LIMIT,
        *CORNERS,
        "--picture",
        "nowhere/limit.png",
    ],
}
MISSING = {
    "there is no file 'none.npz'; give its path": ["look", "none.npz"],
    "there is no file 'none.csv'; give its path": [*LIMIT, "--history", "none.csv"],
    "there is no file 'none.inp'; give its path": ["look", "none.inp"],
    "there is no file 'none.toml'; give its path": ["study", "none.toml"],
    "cannot be used (file is not a database)": ["merge", "runs.sqlite", "system.npz"],
    "cannot be used (there is no such file); give another name": [
        "merge",
        "runs.sqlite",
        "none.sqlite",
    ],
}


@pytest.mark.parametrize("message", [*WRONG, *MISSING])
def test_errors_are_said_without_a_traceback(message, capsys):
    assert main({**WRONG, **MISSING}[message]) == (2 if message in WRONG else 4)
    said = capsys.readouterr().err
    assert said.startswith("frictopt: error: ") and message in said and "Traceback" not in said


@pytest.mark.parametrize(
    "arguments",
    [["study", "study.toml", "--shard", "three"], ["study", "study.toml", "--workers", "many"]],
)
def test_bad_options_are_refused_before_anything_is_computed(arguments, capsys):
    with pytest.raises(SystemExit) as end:
        main(arguments)
    assert end.value.code == 2 and f"{arguments[-1]!r}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("friction", "files", "message"),
    [
        ("0.4", "color = 1", "entry 'color' is unknown; give one of"),
        ("0.4", "[cycel]", "entry 'cycel' is unknown; give one of ['cycle'"),
        (
            "0.4",
            "[starts.overloads]\nload = 1",
            "starts.overloads 'load' is unknown; give one of ['load_factors']",
        ),
        ("0.4", "store = 1", "store = 1; give a str"),
        ("0.4", 'picture = "nowhere/p.png"', "a folder that does not exist"),
        ('{ distribution = "nothing" }', "", "distribution 'nothing'"),
        ('{ distribution = "norm", where = 1.0 }', "", "friction: "),
    ],
)
def test_bad_studies_are_refused_by_name(friction, files, message, capsys):
    study_file(friction, files)
    assert main(["study", "study.toml"]) == 2 and message in capsys.readouterr().err


def test_a_study_says_what_is_missing(capsys):
    Path("half.toml").write_text("load_factors = [1.0]\n[cycle]\n")
    assert (
        main(["study", "half.toml"]) == 2
        and "half.toml: system, friction missing; give system" in capsys.readouterr().err
    )


def test_an_answer_is_printed_where_its_picture_cannot_be_written(capsys):
    assert main([*LIMIT, *CORNERS, "--picture", "limit.odd"]) == 2
    said = capsys.readouterr()
    assert "load_factor " in said.out and "limit.odd' cannot be written" in said.err


def test_names_of_a_history_may_have_semicolons(capsys):
    pd.DataFrame({"mean;kN": [1.0, 1.0], "cyclic": [0.5, -0.5]}).to_csv("loads.csv", index=False)
    assert (
        main([*LIMIT, "--history", "loads.csv"]) == 2
        and "load case 'mean;kN': unknown" in capsys.readouterr().err
    )


def test_a_long_table_is_printed_in_part_and_says_so(capsys):
    random_system(np.random.default_rng(3), 12).save("system.npz")
    assert main([*LIMIT, *CORNERS]) == 0 and capsys.readouterr().out.endswith(
        "... 12 rows in all; --table FILE writes them\n"
    )
    assert (
        main([*LIMIT, *CORNERS, "--table", "limit.csv"]) == 0
        and "rows in all" not in capsys.readouterr().out
    )


@pytest.mark.parametrize(
    ("option", "message"),
    [("--shard=4/3", "shard k: 4"), ("--shard=4", "shard: (4,)"), ("--workers=0", "--workers: 0")],
)
def test_bad_numbers_of_a_study_are_refused(option, message, capsys):
    study_file("0.4")
    assert (
        main(["study", "study.toml", option]) == 2
        and message in capsys.readouterr().err
        and not list(Path.cwd().glob("*.sqlite"))
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_ends_with_its_code(number, capsys):
    """So does a scheduler's signal, which left workers behind."""
    before = (
        signal.signal(signal.SIGTERM, signal.SIG_IGN),
        signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # which a shell's `&` ignores
    try:
        with told("shakedown_limit", lambda _: signal.raise_signal(number)):
            assert main([*LIMIT, *CORNERS]) == 130
        assert "interrupted" in capsys.readouterr().err
        assert signal.getsignal(signal.SIGTERM) == signal.SIG_IGN  # as it was
    finally:
        signal.signal(signal.SIGTERM, before[0])
        signal.signal(signal.SIGINT, before[1])


def test_a_second_interrupt_while_python_ends_leaves_the_code():
    """Python frees what a module holds at the very end, when it handles no signals any more."""
    code = """
import os, signal, sys
import frictopt as fo
from frictopt.__main__ import main

class Last:
    def __del__(self, kill=os.kill, pid=os.getpid(), number=signal.SIGINT):
        kill(pid, number)

last = Last()
signal.signal(signal.SIGINT, signal.default_int_handler)
fo.shakedown_limit = lambda system, cycle, friction: signal.raise_signal(signal.SIGINT)
sys.exit(main(sys.argv[1:]))
"""
    done = subprocess.run([sys.executable, "-c", code, *LIMIT, *CORNERS], capture_output=True)
    assert (done.returncode, done.stderr) == (130, b"frictopt: interrupted\n")


def test_a_command_runs_in_any_thread(capsys):
    with ThreadPoolExecutor(1) as threads:
        assert (
            threads.submit(main, ["look", "system.npz"]).result() == 0
            and "ContactSystem\n" in capsys.readouterr().out
        )


def test_help_imports_no_solver():
    code = "import sys; from frictopt.__main__ import main\ntry: main(['--help'])\nfinally: print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0 and not {
        "cvxpy",
        "pandas",
        "scipy",
        "numba",
        "matplotlib",
        "skfem",
    } & set(done.stdout.split())
