"""The README's examples run, and print what it says they print."""

import importlib.util
import re
import shlex
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from studies.__main__ import STUDIES

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_examples_run_as_they_stand_and_print_what_it_says(capsys, monkeypatch):
    """If other words are printed, paste what the first example prints."""
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("TQDM_DISABLE", "1")
    names = {}
    blocks = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    (said,) = re.findall(r"```text\n(.*?)```", README, re.DOTALL)
    printed = []
    with plt.rc_context({"backend": "agg"}):
        for block in blocks:
            exec(block, names)
            printed.append(capsys.readouterr().out)
    plt.close("all")
    assert len(blocks) == len(printed) == 2 and names["foot"].nodes > 10
    assert printed[0].splitlines() == said.splitlines()
    assert "gross-slip load" in printed[1]
    # The printed problem has the limit as its value, for a solver that knows nothing of frictopt.
    limit = names["limit"]
    assert limit.problem.solve() == pytest.approx(limit.load_factor, rel=1e-6)


def test_it_is_short():
    assert README.count("\n") <= 90 and all(
        block.count("\n") <= 18 for block in re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    )


def test_the_two_commands_are_where_scripts_look_for_them():
    for marker, module in (("set up and run", "studies"), ("set up and test", "pytest")):
        line = README.split(f"<!-- {marker} -->\n```\n")[1].splitlines()[0]
        words = shlex.split(line.removesuffix(" -n auto --dist worksteal"))
        assert words[:4] == ["python3", "-m", "venv", ".venv"] and words[words.index("-m", 5) :][
            :3
        ] == ["-m", "pip", "install"]
        assert words[-1] in STUDIES if module == "studies" else words[-1] == "pytest"


def test_on_a_package_index_its_links_and_pictures_lead_somewhere():
    spec = importlib.util.spec_from_file_location("hatch_build", ROOT / "hatch_build.py")
    build = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(build)
    inner = re.findall(r"\]\((?!https://)([^)]+)\)", README)
    published = build.description(README, "https://host.example/owner/frictopt", "v0.1.0")
    for target in inner:
        assert (ROOT / target.partition("#")[0]).exists()
        assert (
            f"https://host.example/owner/frictopt/{'raw' if target.endswith(('.png', '.svg')) else 'blob'}/v0.1.0/{target})"
            in published
        )
    alone = build.description(README, "", "v0.1.0")
    for page in (published, alone):
        assert len(inner) > 10 and not re.findall(r"\]\((?!https://)", page)
    assert "![" not in alone and "tutorial" in alone
