"""The README's examples run, and print what it says they print."""

import re
from pathlib import Path

from paper_figures.__main__ import FIGURES

README = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")


def test_examples_run_as_they_stand(capsys):
    names = {}
    blocks = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    for block in blocks:
        exec(block, names)
    printed = capsys.readouterr().out
    assert len(blocks) == 4 and names["system"].nodes == 5
    assert "load_factor=0.798" in printed and "node=0, sense=-1" in printed
    assert "0.1483" in printed and "0 0.6527" in printed
    assert "1.8280" in printed and "0.0025" in printed and "True 0.0" in printed and "SHAKEDOWN 0.0" in printed and "CYCLIC_SLIP 0." in printed
    assert "0.0 0.00" in printed and "LeastSlip(" in printed and "{'P': 0.0" in printed


def test_it_lists_the_figures_that_there_are():
    table = re.findall(r"^\| .* \| `paper_figures/(\w+)\.py` \| .*\|$", README, re.MULTILINE)
    assert sorted(table) == sorted(FIGURES)


def test_files_that_it_names_exist():
    root = Path(__file__).parent.parent
    for name in re.findall(r"`((?:paper_figures|studies|tests)/\w+\.py)`", README) + re.findall(r"\]\((docs/[^)]+)\)", README):
        assert (root / name).is_file(), name
