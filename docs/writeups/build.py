"""Build the write-ups as PDF: `python docs/writeups/build.py [name ...] [--quick]`, into `docs/writeups/output`.

It needs `pip install pypandoc_binary typst` and the extra `studies`. It draws the figures of
`python -m paper_figures`, after it has computed missing data; `--quick` uses coarse meshes. In the
Markdown, a block `{include} FILE` stands for a table with the command that made the table, and a
block `{figure} NAME` for a figure with its caption.
"""

import argparse
import re
import sys
from pathlib import Path

import pypandoc
import typst

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT))
from paper_figures.__main__ import make  # noqa: E402  a folder of the repository, not installed

NAMES = ("lift-off", "guaranteed-in-space", "fatigue-band", "paper")
LOOK = {
    "papersize": "a4",
    "fontsize": "9.5pt",
    "header-includes": "#set table(inset: 3pt)\n#show table: set text(size: 8pt)",
}


def build(name: str, quick: bool) -> Path:
    """The PDF file of one write-up."""
    text = (HERE / f"{name}.md").read_text(encoding="utf-8")
    text = re.sub(
        r"```\{include\} (\S+)\n```",
        lambda match: (HERE / match[1]).read_text(encoding="utf-8"),
        text,
    )
    text = re.sub(
        r"```\{figure\} (\S+)\n(.*?)```",
        lambda match: figure(match[1], match[2], quick),
        text,
        flags=re.DOTALL,
    )
    text = text.replace("](../", "](/docs/")  # typst resolves links from the root of the repository
    look = [f"--variable={key}:{value}" for key, value in LOOK.items()]
    options = [
        "--standalone",
        "--columns=300",
        "--citeproc",
        f"--bibliography={HERE / 'paper.bib'}",
        *look,
    ]
    (HERE / "output").mkdir(exist_ok=True)
    source, made = (HERE / "output" / f"{name}.{kind}" for kind in ("typ", "pdf"))
    typeset = pypandoc.convert_text(text, "typst", "markdown", options).replace(
        "x: 1.25in, y: 1.25in", "x: 22mm, y: 20mm"
    )
    source.write_text(typeset, encoding="utf-8")
    typst.compile(source, output=made, root=ROOT)
    return made


def figure(name: str, caption: str, quick: bool) -> str:
    """Draw a figure, and return it in Markdown."""
    return f"![{' '.join(caption.split())}](/{make(name, quick=quick)[0].relative_to(ROOT).as_posix()})"


def main() -> None:
    """Build the named write-ups, or all of them."""
    parser = argparse.ArgumentParser(description="Build the write-ups as PDF.")
    parser.add_argument(
        "names", nargs="*", metavar="name", help=f"all by default: {', '.join(NAMES)}"
    )
    parser.add_argument("--quick", action="store_true", help="figures from coarse meshes")
    options = parser.parse_args()
    for name in options.names or NAMES:
        print(build(name, options.quick))


if __name__ == "__main__":
    main()
