"""The README's examples run, and print what it says they print."""

import importlib.util
import re
import shlex
from pathlib import Path

import matplotlib.pyplot as plt

from studies.__main__ import STUDIES

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_examples_run_as_they_stand(capsys, monkeypatch):
    monkeypatch.chdir(ROOT)
    names = {}
    blocks = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    with plt.rc_context({"backend": "agg"}):
        for block in blocks:
            exec(block, names)
    plt.close("all")
    printed = capsys.readouterr().out
    assert (
        len(blocks) == 4
        and names["foot"].nodes > 10
        and names["flat"].nodes == 26
        and set(names["dovetail"].contact) == {"right", "left"}
    )
    first = {line.split()[0]: line.split()[-1] for line in printed.split("\n")[1:6]}
    assert first["load_factor"].startswith("0.798") and (first["node"], first["sense"]) == (
        "0",
        "-1",
    )
    assert (
        printed.count("1.8280") >= 2
        and "SHAKEDOWN 0.0" in printed
        and "CYCLIC_SLIP 0." in printed
        and "gross-slip load: " in printed
    )


def test_it_is_short():
    assert README.count("\n") <= 120 and all(
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
