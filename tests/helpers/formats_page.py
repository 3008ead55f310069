"""The tables of the page of formats."""

import re
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "formats.md").read_text(encoding="utf-8")


def section(title):
    return PAGE.split(f"## {title}\n")[1].split("\n## ")[0]


def rows(title):
    """Keyword or card, and effect, of each row of a section."""
    return re.findall(
        r"^\| (`.*`) \| (kept|refused|without effect) \|", section(title), re.MULTILINE
    )
