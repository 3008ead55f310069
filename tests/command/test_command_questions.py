"""Each question of the command line gives the answer of its function, as text, JSON and table; its
options are those of the function."""

import argparse
import inspect
import json
import re
import shlex
import warnings
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from scipy import stats
from scipy.integrate import quad

import frictopt as fo
from frictopt.base.files import strict_json
from frictopt.command import main as run
from frictopt.command import options, questions
from helpers.command import main
from helpers.interrupts import stops
from helpers.systems import CYCLE, random_system, system

ROOT = Path(__file__).parents[2]
CONTACT = random_system(np.random.default_rng(3), 4)
PUNCH = fo.scenes.PunchOnHalfPlane(elements=4, growth=2.0).condense(progress=False)
PULL = ["--mean", "P=1", "--corners", "sigma=-1", "sigma=1"]
PUSH = ["--mean", "P=1", "--corners", "Q=-1", "Q=1"]
SIGMA = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
SHEAR = fo.LoadCycle({"P": 1.0}, [{"Q": -1.0}, {"Q": 1.0}])
F = ["--friction", "0.5"]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    PUNCH.save("punch.npz")
    CONTACT.save("system.npz")
    yield tmp_path
    plt.close("all")


def strict(text):
    """JSON without the tokens NaN and Infinity, which the standard does not know."""

    def refused(token):
        raise AssertionError(f"{token} is no JSON")

    return json.loads(text, parse_constant=refused)


ASKED = {
    "limit": ([*PULL, *F], lambda: fo.shakedown_limit(PUNCH, SIGMA, 0.5)),
    "limit of the nodes": (
        [*PULL, "--friction", ".1,.2,.3,.4,.5"],
        lambda: fo.shakedown_limit(PUNCH, SIGMA, [0.1, 0.2, 0.3, 0.4, 0.5]),
    ),
    "limit within a bound": (
        [*PULL, *F, "--slip-bound", ".05", "--no-simplify", "--solver", "HIGHS"],
        lambda: fo.shakedown_limit(
            PUNCH, SIGMA, 0.5, slip_bound=0.05, simplify=False, solver="HIGHS"
        ),
    ),
    "limit guaranteed": (
        [*PULL, *F, "--kind", "guaranteed"],
        lambda: fo.guaranteed_limit(PUNCH, SIGMA, 0.5),
    ),
    "limit onset": ([*PULL, *F, "--kind", "onset"], lambda: fo.onset(PUNCH, SIGMA, 0.5)),
    "gross-slip": ([*PUSH, *F], lambda: fo.gross_slip(PUNCH, SHEAR, 0.5)),
    "gross-slip of a fit": ([*PULL, *F], lambda: fo.gross_slip(PUNCH, SIGMA, 0.5)),
    "steady": (
        [*PULL, *F, "--load-factor", "1.3", "--overload", "2"],
        lambda: fo.steady_state(PUNCH, SIGMA, 0.5, 1.3, overload=2.0),
    ),
    "backbone": (
        [*PUSH, *F, "--load-factors", ".2", ".4"],
        lambda: fo.joints.backbone_curve(PUNCH, SHEAR, 0.5, [0.2, 0.4]),
    ),
    "required-friction": (
        [*PULL, "--load-factor", "1"],
        lambda: fo.required_friction(PUNCH, SIGMA, 1.0),
    ),
    "report": ([*PULL, *F, "--load-factors", ".5"], lambda: fo.report(PUNCH, SIGMA, 0.5, [0.5])),
}


def equal(told, value):
    """Whether a part of JSON is a value of Python: infinite numbers are texts, nan is null."""
    if isinstance(value, float | np.floating):
        if np.isnan(value):
            return told is None
        return float(told) == pytest.approx(float(value), rel=1e-6, abs=1e-9)
    if isinstance(value, dict):
        return told.keys() == value.keys() and all(equal(told[k], v) for k, v in value.items())
    return str(told) == str(getattr(value, "name", value))


@pytest.mark.parametrize("name", ASKED)
def test_a_command_gives_the_answer_of_its_function(name, capsys):
    words, ask = ASKED[name]
    command = name.split(" ")[0]
    found = ask()
    assert main([command, "punch.npz", *words, "--json", "--save", "answer.npz"]) == 0
    told = strict(capsys.readouterr().out)
    assert told["question"]["command"] == command and told["warnings"] == []
    numbers = found._answer()
    assert set(numbers) <= set(told["answer"])
    for part, value in numbers.items():
        if part not in ("residual", "nodes") and isinstance(value, float | int | str):
            assert equal(told["answer"][part], value), part
    kept = fo.results.load("answer.npz")
    assert type(kept) is type(found)
    if hasattr(found, "to_frame") and command != "steady":
        rows = found.to_frame()
        assert len(told["tables"]["rows"]) == len(rows)
        for row, record in zip(told["tables"]["rows"], rows.to_dict("records"), strict=True):
            assert list(row) == list(record)


def test_an_event_of_the_onset_has_its_parts_as_json(capsys):
    assert main(["limit", "punch.npz", *PULL, *F, "--kind", "onset", "--json"]) == 0
    slip = strict(capsys.readouterr().out)["answer"]["slip"]
    event = fo.onset(PUNCH, SIGMA, 0.5).slip
    assert slip == {
        "corner": event.corner,
        "loads": event.loads,
        "event": "slip",
        "load_factor": pytest.approx(event.load_factor),
        "node": event.node,
        "sense": event.sense,
    }


def test_every_question_is_tried_here_and_stands_on_the_pages():
    """The table of the questions names commands that exist, and no command is missing there."""
    names = {question.name for question in questions.QUESTIONS}
    assert {name.split(" ")[0] for name in ASKED} == names
    page = (ROOT / "docs" / "questions.md").read_text(encoding="utf-8")
    rows = [line.strip("|").split("|")[-1].strip() for line in page.splitlines() if "|" in line][2:]
    asked = {row.strip("`").split(" ")[0] for row in rows} - {"Python"}
    assert asked == names | {"study"}
    page = (ROOT / "docs" / "command.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"^frictopt ([\w-]+)", page, re.MULTILINE))
    assert shown == {command.name for command in run.commands()} - {"study", "merge"}


def test_every_argument_of_a_function_is_an_option_or_needs_python():
    """What a shell cannot write: states, slips and flags of all nodes, and functions."""
    written, left = set(), set()
    for question in questions.QUESTIONS:
        for function in question.kinds.values():
            parameters = inspect.signature(options.public(function)).parameters
            parser = run.parser([question.name])
            actions = parser._subparsers._group_actions[0].choices[question.name]._actions
            values = {action.dest.removeprefix("of_") for action in actions}
            written |= parameters.keys() & values
            left |= parameters.keys() - values
    supplied = {"system", "cycle", "progress"}
    for_python = {"open_nodes", "initial_slip", "initial_state", "show"}
    assert left - supplied == for_python | {"life", "model"}
    assert {"steps", "load_factor", "load_factors", "events", "overload"} <= written


def test_a_report_has_a_range_of_frictions(tmp_path, capsys):
    file = tmp_path / "punch.npz"
    PUNCH.save(file)
    options = ["--pages", "2", "--load-factors", ".5"]
    assert main(["report", str(file), *PULL, "--friction", ".4:.5:.6", *options]) == 0
    joint = fo.report(PUNCH, SIGMA, (0.4, 0.5, 0.6), [0.5], pages=2, file=file)
    assert capsys.readouterr().out.strip() == str(joint).strip()
    for odd in (".4:.5", ".4:a:.6", ".4:.5:.6:.7"):
        with pytest.raises(SystemExit):
            main(["report", str(file), *PULL, "--friction", odd])
        assert "LEAST:NOMINAL:MOST" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["limit", str(file), *PULL, "--friction", ".4:.5:.6"])
    assert "several with commas between" in capsys.readouterr().err


def test_a_report_has_thresholds_and_ranges_of_preloads(tmp_path, capsys):
    file = tmp_path / "punch.npz"
    PUNCH.save(file)
    scatter = ["--preload", "P=.9:1.1", "--limits", "slip range=1,gross slip=1.2", "--pages", "2"]
    assert main(["report", str(file), *PULL, *F, *scatter, "--load-factors", ".5"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    sheet = fo.report(
        PUNCH, SIGMA, 0.5, [0.5], preload={"P": (0.9, 1.1)}, limits={"slip range": 1.0}, pages=2
    )
    assert "Scatter: P of 0.9 to 1.1." in said and f"{sheet.verdicts['value'][0]:.4g}" in said
    tightened = ["--preload", "P=1.2", "--pages", "1"]
    assert main(["report", str(file), *PULL, *F, *tightened]) == 0
    assert "alpha_A = 1.2 of VDI 2230" in " ".join(capsys.readouterr().out.split())
    for name, friction in (("today.json", ".5"), ("oiled.json", ".4")):
        options = ["--friction", friction, "--pages", "1", "--save", name]
        assert main(["report", str(file), *PULL, *options]) == 0
    assert main(["compare", "today.json", "oiled.json"]) == 0
    assert re.search(r"work per cycle .* (today|oiled)\n", capsys.readouterr().out)
    for odd in ("P=", "P=.9:x", ".9:1.1", "P=.9:1.1,P=.5:1.5"):
        with pytest.raises(SystemExit):
            main(["report", str(file), *PULL, *F, "--preload", odd])


def test_a_report_has_random_inputs_as_scipy_defines_them(tmp_path, capsys):
    """A node holds a load factor if its friction is at least 0.2 of it: an integral over both."""
    file, loads = str(tmp_path / "two.npz"), {"P": ([0, 0], [1, 1]), "Q": ([1, 1], [0, 0])}
    eye, zero = np.eye(2), np.zeros((2, 2))
    faces = {"contact": ["head", "lap"]}
    fo.ContactSystem.from_blocks(eye, zero, eye, [0.0, 1.0], loads, **faces).save(file)
    asked = ["report", file, "--mean", "P=2", "--corners", "Q=.4", "Q=-.4", "--load-factors", "1"]
    laws = ["--friction", "head=lognorm:.2:0:.22", "lap=.5", "--load", "uniform:.8:.4"]
    assert main([*asked, *laws, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    law = stats.lognorm(0.2, scale=0.22)
    exact = quad(lambda factor: law.sf(0.2 * factor) / 0.4, 0.8, 1.2)[0]
    assert told["answer"]["probability_for_some_start"] == pytest.approx(exact, abs=0.03)
    assert told["question"]["load"] == {"distribution": "uniform", "parameters": [0.8, 0.4]}
    field = [
        "--friction",
        "lognorm:.2:0:.22",
        "--correlation-length",
        "0",
        "--preload",
        "P=norm:2:.1",
    ]
    assert main([*asked, *field, "--pages", "1"]) == 0
    assert "correlation length of friction 0, P of 1.80" in " ".join(
        capsys.readouterr().out.split()
    )
    ranges = ["--friction", "head=.1:.2:.3", "lap=.5", "--pages", "1"]
    assert main([*asked, *ranges, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["answer"]
    assert told["scatter"] == "friction of 0.1 to 0.5 to 0.3 to 0.5"
    assert main([*asked, *ranges[:2], "lap=norm:.5:.1"]) == 2
    assert "give ranges or distributions, not both" in capsys.readouterr().err
    for odd in (["load", "1"], ["load", "norm:x"], ["preload", "P=nothing:1"], ["load", ".9:1:2"]):
        with pytest.raises(SystemExit):
            main([*asked, "--friction", ".3", f"--{odd[0]}", odd[1]])
        assert f"argument --{odd[0]}: {odd[1]!r}" in capsys.readouterr().err


@pytest.mark.parametrize("command", questions.COMMANDS, ids=lambda command: command.name)
def test_the_help_of_a_command_says_what_the_docstring_says(command, capsys):
    with pytest.raises(SystemExit):
        main([command.name, "--help"])
    text = " ".join(capsys.readouterr().out.split())
    question = next(question for question in questions.QUESTIONS if question.name == command.name)
    for function in question.kinds.values():
        said = options.described(options.public(function))
        parameters = inspect.signature(options.public(function)).parameters.keys() - {
            "mean",
            "friction",
            "tolerance",
        }
        for parameter in parameters & said.keys():
            if f"--{parameter.replace('_', '-')} " in text and question.name != "limit":
                assert said[parameter][:25] in text, parameter
    if question.name == "limit":
        assert options.described(fo.shakedown_limit)["events"][:60] in text
    assert command.example in text


def test_texts_that_refer_to_another_function_are_followed():
    texts = options.described(fo.required_friction)
    assert texts["events"].startswith(options.described(fo.shakedown_limit)["events"])
    assert "each friction that needs events has a search of its own." in texts["events"]
    assert "progress" not in options.described(fo.dissipation_range)["steps"]


def test_the_examples_of_help_and_of_the_page_are_commands():
    page = (ROOT / "docs" / "command.md").read_text(encoding="utf-8")
    lines = re.findall(r"^frictopt (.+)", page, re.MULTILINE)
    lines += [f"{command.name} {command.example}" for command in run.commands()]
    assert len(lines) > 20
    for line in lines:
        words = shlex.split(line)
        assert run.parser(words).parse_args(words).run


def test_the_json_of_the_page_has_the_parts_of_an_answer(capsys):
    page = (ROOT / "docs" / "command.md").read_text(encoding="utf-8")
    shown = strict(re.search(r"```json\n(.*?)```", page, re.DOTALL)[1])
    main(["gross-slip", "punch.npz", *PUSH, "--friction", ".4", "--json"])
    told = strict(capsys.readouterr().out)
    assert list(told) == list(shown) and told["question"] == shown["question"]
    assert list(shown["answer"]) == list(told["answer"])[: len(shown["answer"])]
    assert told["answer"]["load_factor"] == pytest.approx(0.4)
    assert shown["tables"]["rows"][0].keys() <= told["tables"]["rows"][0].keys()


def test_the_file_of_a_table_has_the_numbers_of_its_answer():
    """Also where the table has no rows, as that of a contact that nothing slides off."""
    assert main(["steady", "punch.npz", *PULL, *F, "--load-factor", "1.3", "--table", "s.csv"]) == 0
    steady = fo.steady_state(PUNCH, SIGMA, 0.5, 1.3)
    table = pd.read_csv("s.csv")
    assert (table["answer_load_factor"] == 1.3).all() and set(table["answer_outcome"]) == {
        steady.outcome.name
    }
    assert table["answer_dissipation"][0] == pytest.approx(steady.dissipation)
    assert table["work"].sum() == pytest.approx(steady.dissipation)
    assert table["slip"].to_numpy() == pytest.approx(steady.slip)
    assert main(["gross-slip", "punch.npz", *PULL, *F, "--table", "g.xlsx"]) == 0
    table = pd.read_excel("g.xlsx")
    assert len(table) == 1 and table["answer_load_factor"][0] in (np.inf, "inf")


def test_no_answer_is_not_zero(capsys):
    """A contact that the mean load pulls off has no limit, which is nan: null in JSON."""
    pulled = system(np.eye(1), np.zeros((1, 1)), 0.0, [-1.0], [1.0], [0.0], C=[[1.0]])
    pulled.save("pulled.npz")
    arguments = ["limit", "pulled.npz", "--mean", "mean=1", "--corners", "cyclic=1", "cyclic=-1"]
    found = fo.shakedown_limit(pulled, CYCLE, 0.5)
    assert np.isnan(found.load_factor)
    assert main([*arguments, *F]) == 3 and found.reason[:20] in capsys.readouterr().out
    assert main([*arguments, *F, "--json"]) == 3
    assert strict(capsys.readouterr().out)["answer"]["load_factor"] is None


def test_an_infinite_limit_is_an_answer(capsys):
    assert main(["gross-slip", "punch.npz", *PULL, *F, "--json"]) == 0
    assert strict(capsys.readouterr().out)["answer"]["load_factor"] == "inf"
    values = {"a": -np.inf, "b": np.float64(np.nan), "c": np.arange(2), "d": pd.NA}
    assert strict(strict_json(values)) == {
        "a": "-inf",
        "b": None,
        "c": [0, 1],
        "d": None,
    }


def test_errors_and_warnings_are_json_too(capsys):
    assert main(["limit", "punch.npz", *PULL, "--friction", "-1", "--json"]) == 2
    said = capsys.readouterr()
    told = strict(said.out)
    assert told["exit_code"] == 2 and told["error"].startswith("friction: -1")
    assert said.err == f"frictopt: error: {told['error']}\n"
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert main(["limit", "punch.npz", *PULL, "--friction", "40", "--json"]) == 0
    assert "per cent" in strict(capsys.readouterr().out)["warnings"][0]


def test_units_are_names_and_convert_nothing(capsys):
    assert main(["limit", "punch.npz", *PULL, *F, "--units", "N, mm", "--json"]) == 0
    told = strict(capsys.readouterr().out)
    assert told["question"]["units"] == "N, mm" and told["answer"]["load_factor"] == pytest.approx(
        fo.shakedown_limit(PUNCH, SIGMA, 0.5).load_factor
    )
    assert main(["limit", "punch.npz", *PULL, *F, "--units", "N"]) == 2
    assert "units: 'N'" in capsys.readouterr().err
    replace(PUNCH, units="kN, m").save("named.npz")
    assert main(["limit", "named.npz", *PULL, *F, "--units", "N, mm"]) == 2
    assert "is in 'kN, m'; leave the option out" in capsys.readouterr().err
    assert main(["limit", "named.npz", *PULL, *F, "--units", "kN, m"]) == 0


def test_an_option_of_another_kind_is_refused(capsys):
    assert main(["limit", "punch.npz", *PULL, *F, "--kind", "onset", "--events"]) == 2
    assert "--events: not an option of --kind onset" in capsys.readouterr().err
    for words in (
        ["steady", "punch.npz", *PULL, *F],
        ["steady", "punch.npz", *PULL, *F, "--load-factor", "one"],
        ["steady", "punch.npz", *PULL, "--friction", "0.3,", "--load-factor", "1"],
        ["required-friction", "punch.npz", *PULL],
    ):
        with pytest.raises(SystemExit) as end:
            main(words)
        assert end.value.code == 2


def test_an_interrupted_question_prints_what_it_knows(capsys):
    words = [*PULL, *F, *"--load-factors 1.1 1.2 1.3".split()]
    with stops("backbone curve", 2):
        assert main(["backbone", "punch.npz", *words]) == 130
    said = capsys.readouterr()
    assert said.out.startswith("BackboneCurve\n") and "frictopt: interrupted\ncurve: " in said.err
    with stops("backbone curve", 2):
        assert main(["backbone", "punch.npz", *words, "--json"]) == 130
    told = strict(capsys.readouterr().out)
    assert told["interrupted"] is True and told["curve"]["load_factors"] >= 1


STUDY = """
system = "system.npz"
friction = [0.3, 0.4]
load_factors = [0.5, 2.0]
[cycle]
mean = { mean = 1.0 }
corners = [{ cyclic = -1.0 }, { cyclic = 1.0 }]
[starts]
no_slip = {}
random_slips = { amplitudes = [AMPLITUDE], count = 2 }
"""


@pytest.mark.parametrize(("what", "most", "runs"), [("transients", 5, 5), ("limits", 2, 20)])
def test_an_interrupted_study_says_how_many_runs_its_store_keeps(what, most, runs, capsys):
    """The same command goes on from there."""
    Path("study.toml").write_text("limits = true\n" + STUDY.replace("AMPLITUDE", "0.1"))
    with stops(what, most):
        assert main(["study", "study.toml"]) == 130
    line = f"frictopt: interrupted\n{runs} of 20 runs kept in study.sqlite; the same command continues\n"
    assert capsys.readouterr().err.endswith(line)
    assert len(fo.results.read_store("study.sqlite")) == runs
    assert main(["study", "study.toml", "--json"]) == 0
    told = strict(capsys.readouterr().out)
    assert told["answer"] == {"runs": 20, "failed": 0} and len(told["tables"]["runs"]) == 20


def test_a_study_of_which_a_run_fails_is_no_answer_and_names_it(capsys):
    Path("study.toml").write_text(STUDY.replace("AMPLITUDE", "1e30"))
    assert main(["study", "study.toml"]) == 3
    said = capsys.readouterr()
    assert "FAILED" in said.out and "kept in study.sqlite" in said.out
    assert "frictopt: 16 of 20 runs FAILED; the first: load factor " in said.err.splitlines()[-1]
    assert "'smooth 1e+30 #0': " in said.err.splitlines()[-1]


def test_a_flag_of_a_true_default_switches_it_off():
    parser = argparse.ArgumentParser()
    options.add_options(parser, ["shakedown_limit"])
    switched_off = options.arguments_of("shakedown_limit", parser.parse_args(["--no-simplify"]))
    switched_on = options.arguments_of("shakedown_limit", parser.parse_args(["--events"]))
    assert switched_off == {"simplify": False}
    assert switched_on == {"events": True}
