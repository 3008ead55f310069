"""The commands of the documentation, as they are typed, in a fresh clone of the repository: each is
run here, by a job, or is named with a reason."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import frictopt as fo

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "docs" / "examples" / "README.rst",
    *sorted((ROOT / "docs").rglob("*.md")),
]
FILES = (
    "docs/command.md",
    "docs/tutorial/growing.md",
    "docs/tutorial/deck.md",
)  # whose commands need the files there
PROGRAMS = [
    "python",
    "pip",
    "pytest",
    "ruff",
    "mypy",
    "pre-commit",
    "frictopt",
    "sphinx-build",
    "bash",
    "sh",
    "git",
    "make",
    "apt-get",
]

NOT_RUN = {
    "python -m venv .venv": "the tests run in an environment",
    "python -m pip install --quiet --editable '.[studies]'": "set up, of the environment that the tests run in",
    "python -m pip install --quiet --editable '.[test]'": "set up; `.ci/run` runs it",
    "python -m pip install --editable '.[dev]'": "set up; the job of style and types installs it",
    "python -m pip install --editable '.[mesh]'": "set up, of a part of what the tests have",
    "python -m pip install --editable '.[docs]'": "set up; the job of the documentation installs it",
    "python -m pip install --editable '.[figures,mesh,nastran]'": "set up, of a part of what the tests have",
    "python -m pip install .": "set up; `.ci/wheel` installs the same",
    "python -m pip install '.[figures]'": "set up; `.ci/wheel` installs the same",
    "python -m pip install '.[figures,mesh]'": "set up, of a part of what the tests have",
    "pre-commit install": "changes the repository",
    "pip install pylife": "set up; the tests have it",
    "pip install pyscipopt": "another solver, which a page names and does not need",
    "python -m studies peers --pythons peers/bin/python /usr/bin/python3": "needs the peers in a Python of their own; the weekly job runs it without",
    "apt-get install python3-siconos python3-getfem": "changes the system; the study names peers that are absent",
    "apt-get install calculix-ccx": "changes the system; the job of the tests installs it",
    "cd docs/tutorial": "a folder, which is there",
    "python": "waits for what is typed",
    "python -m pytest -n auto --dist worksteal": "these tests; `.ci/run` takes the command from the page",
    "pytest -n auto --dist worksteal": "the same",
    "pytest tests/limits": "a part of them",
    'pytest -n auto --dist worksteal -m ""': "the weekly job runs them with all cases",
    'python -m pytest -n auto --dist worksteal -m "" -p tests.tools.slow_tests': "all tests, which it measures",
    "bash docs/findings/NAME.sh": "each script installs packages of its own",
    "bash .ci/run": "runs these tests; a job runs it",
    "python -m pytest studies/benchmarks/test_limits.py -k plain -s": "a part of `pytest studies/benchmarks`",
    "pytest studies/benchmarks/test_within_gap.py": "a part of `pytest studies/benchmarks`",
    "python -m sphinx -b html docs docs/_build/html": "a job builds the same pages and takes warnings for errors",
}
BY_JOBS = {  # command -> how a job has it, with what only its machine needs
    "ruff check .": "ruff check .",
    "ruff format --check .": "ruff format --check .",
    "mypy": "&& mypy",
    "python -m sphinx -W --keep-going -j auto -b html docs docs/_build/html": "python -m sphinx -W --keep-going -j auto -t online -b html docs",
    "python -m studies fuzz": "python -m studies fuzz --seed",
    "python tests/tools/mutants.py": "- python tests/tools/mutants.py",
    "bash .ci/wheel dist/*.whl": "bash .ci/wheel dist/*.whl",
    "python -m build": "python -m build",
    "pip install --constraint .ci/lowest.txt --editable '.[test]'": "pip install --quiet --constraint .ci/lowest.txt --editable '.[test]'",
}
DRIVER = """
import gc, glob, os, runpy, shlex, sys
import cvxpy, matplotlib.pyplot, numba, pandas, scipy.optimize, skfem
import frictopt, frictopt.command.main
contact = frictopt.scenes.PunchOnHalfPlane(elements=4).condense()
asked = contact, frictopt.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}]), 0.4
frictopt.shakedown_limit(*asked), frictopt.steady_state(*asked, 0.5)  # which import the rest
gc.freeze()  # else each process copies the memory of the libraries to look through it for garbage
for line in sys.stdin:
    folder, output, *words = map(os.path.expandvars, shlex.split(line))
    if not (process := os.fork()):
        os.chdir(folder)
        os.dup2(os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 1)
        os.dup2(os.open(output + ".err", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
        words = [name for word in words for name in (sorted(glob.glob(word)) if "*" in word else [word])]
        sys.argv = words[1:] if words[0] == "-m" else words
        run, name = (runpy.run_module, words[1]) if words[0] == "-m" else (runpy.run_path, words[0])
        sys.path.insert(0, os.path.dirname(words[0]))
        run(name, run_name="__main__", **{"alter_sys": True} if words[0] == "-m" else {})
        sys.exit()
    print(os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]), flush=True)
"""


def commands(text):
    """The commands of a page, one by one: lines of blocks for a shell, and what stands in
    backquotes and begins with a program."""
    block = re.compile(r"^ *```([^`\n]*)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
    lines = [
        line
        for kind, body in block.findall(text)
        if kind in ("", "sh", "bash", "console")
        for line in body.splitlines()
    ]
    inline = re.findall(r"`([^`\n]+)`", block.sub("", text))
    typed = [
        one.strip()
        for line in lines
        if not line.startswith("#")
        for one in line.removeprefix("$ ").split("&&")
        if one.strip()
    ]
    for span in inline:
        parts = [one.strip() for one in span.split("&&")]
        typed += [
            one
            for one in parts
            if plain(one).split(" ")[0] in PROGRAMS and (" " in one or len(parts) > 1)
        ]
    return [plain(one) for one in typed]


def plain(command):
    """A command without the folder of the environment and what may be left out."""
    return re.sub(
        r"^python3\b",
        "python",
        re.sub(r"^(\.\./)*\.venv/bin/", "", re.sub(r" \[[A-Z]+\]", "", command)),
    )


FOUND = {
    path.relative_to(ROOT).as_posix(): commands(path.read_text(encoding="utf-8"))
    for path in PAGES
    if not {"_build", "writeups"} & set(path.parts)  # write-ups need pandoc, and tables of hours
}
OTHERS = list(
    dict.fromkeys(
        command for page, found in FOUND.items() if page not in FILES for command in found
    )
)
JOBS = "".join(
    path.read_text(encoding="utf-8")
    for path in sorted((ROOT / ".github" / "workflows").glob("*.yml"))
)
WEEKLY = re.findall(
    r"^ +- ((?:python|pytest) .*)$",
    (ROOT / ".github" / "workflows" / "weekly.yml").read_text(encoding="utf-8"),
    re.MULTILINE,
)
TYPED = [command for command in OTHERS if command not in NOT_RUN and command not in BY_JOBS]
LONG = [command for command in TYPED if command in WEEKLY]
READ = re.compile(
    r"python -m studies \w+"
)  # which `quick` of conftest.py runs for those that read its tables
SOME = {
    "python -m paper_figures": " dissipation two_states"
}  # of tables that are there by then; tests/studies/test_paper_figures.py draws them all
STUDIED = [
    command
    for command in LONG
    if re.match(r"python -m (studies|paper_figures)( |$)", command) and not READ.fullmatch(command)
]
QUICK = [
    re.sub(r" --(only|cases|seed) \S+", "", command) + SOME.get(command, "") + " --quick"
    for command in STUDIED
]
QUICK.sort(key=lambda command: "figures" in command)  # which take the tables of the others
HERE = [command for command in TYPED if command not in LONG] + list(dict.fromkeys(QUICK))


@pytest.fixture(scope="module")
def clone(tmp_path_factory):
    """A fresh clone, with the machine code of those of its files that are the same as here: to
    compile them again takes a minute in all."""
    folder = tmp_path_factory.mktemp("clone") / "frictopt"
    subprocess.run(
        ["git", "clone", "--quiet", str(ROOT), str(folder)], check=True, capture_output=True
    )
    for source in (
        path for path in (folder / "frictopt").rglob("*.py") if path.stem in ("kernel", "sweeps")
    ):
        mine = ROOT / source.relative_to(folder)
        if mine.read_bytes() == source.read_bytes():
            shutil.copystat(mine, source)  # by which numba knows what it has compiled
            source.with_name("__pycache__").mkdir(exist_ok=True)
            for kept in mine.parent.glob(f"__pycache__/{mine.stem}.*.nb?"):
                shutil.copy(kept, source.with_name("__pycache__"))
    return folder


@pytest.fixture(scope="module")
def typed(clone, tmp_path_factory):
    """Runs a command as it is typed, in a folder, with the package of the clone: in a process of
    its own that has the libraries and the package of the clone already."""
    output = tmp_path_factory.mktemp("output") / "told"
    paths = {"PYTHONPATH": str(clone), "MPLBACKEND": "agg", "SLURM_ARRAY_TASK_ID": "1"}
    options = {
        "cwd": clone,
        "env": {**os.environ, **paths},
        "text": True,
        "stdin": subprocess.PIPE,
        "stdout": subprocess.PIPE,
        "start_new_session": True,
    }

    with subprocess.Popen([sys.executable, "-c", DRIVER], **options) as driver:

        def told(command, folder):
            program, _, rest = command.partition(" ")
            words = {"python": rest, "frictopt": f"-m frictopt {rest}"}[program]
            print(
                f"{shlex.quote(str(folder))} {shlex.quote(str(output))} {words}",
                file=driver.stdin,
                flush=True,
            )
            status, said, errors = (
                driver.stdout.readline(),
                output.read_text(),
                output.with_name("told.err").read_text(),
            )
            assert status == "0\n" and said, f"{command}\n{said[-1000:]}\n{errors[-3000:]}"

        try:
            yield told
        finally:
            # A command that was given up still runs in a process of its own.
            os.killpg(driver.pid, signal.SIGKILL)


def test_every_command_is_run_or_named_with_a_reason():
    assert len(OTHERS) > 40 and all(len(FOUND[page]) > 3 for page in FILES)
    for command in TYPED:
        assert command in LONG or re.match(
            r"python -m (studies|paper_figures)( |$)|python tests/tools/\w+\.py", command
        ), f"who runs {command!r}?"
    for command in (*NOT_RUN, *BY_JOBS, *WEEKLY):
        assert command in OTHERS, f"no page has {command!r} any more"
    for command, line in BY_JOBS.items():
        assert line in JOBS, f"no job has {command!r}"


@pytest.mark.parametrize("command", HERE)
def test_a_command_runs_as_it_is_typed(command, clone, typed):
    typed(command, clone)


def test_commands_on_files_run_as_they_are_typed(typed, tmp_path):
    """With the files that their page describes: a contact, a history, a deck, and the study
    that it shows."""
    page = (ROOT / FILES[1]).read_text(encoding="utf-8")
    punch = fo.scenes.PunchOnHalfPlane(elements=8).condense()
    punch.save(tmp_path / "punch.npz")
    cycle = fo.LoadCycle({"P": 1.0}, [{"sigma": -1.0}, {"sigma": 1.0}])
    fo.shakedown_limit(punch, cycle, 0.4).save(tmp_path / "limit.npz")
    for name, friction in (("today", 0.4), ("thicker", 0.5)):
        fo.report(punch, cycle, friction, pages=1).save(tmp_path / f"{name}.json")
    (tmp_path / "loads.csv").write_text("time,P,sigma\n0,1,-1\n1,1,1\n2,1,-1\n")
    (tmp_path / "study.toml").write_text(
        re.search(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)[1], encoding="utf-8"
    )
    for name in ("block.inp", "joint.inp"):
        shutil.copy(ROOT / "tests" / "data" / "block.inp", tmp_path / name)
    joint = re.search(
        r"^```toml\n(.*?)^```", (ROOT / FILES[0]).read_text(encoding="utf-8"), re.M | re.S
    )
    (tmp_path / "joint.toml").write_text(joint[1], encoding="utf-8")
    for name in ("clamp.inp", "clamp.toml"):
        shutil.copy(ROOT / "docs" / "tutorial" / name, tmp_path / name)
    for command in [command for name in FILES for command in FOUND[name]]:
        if command != "frictopt --help" and not command.endswith(" --help"):
            typed(command, tmp_path)
    assert {"punch.png", "limit.csv", "limit.png", "runs.csv", "runs.png", "runs.sqlite"} <= {
        path.name for path in tmp_path.iterdir()
    }
