"""The words that pages and docstrings avoid: the table of docs/glossary.md, and habits of writing.

Both lists hold for prose. Code, names in backquotes, formulas, targets of links, and tables of
studies do not count as prose.
"""

import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
GLOSSARY = ROOT / "docs" / "glossary.md"
HEADING = "## Words that are not used"
PROSE = re.compile(
    r"^---\nfile_format.*?^---$|^( *)(`{3,})[^\n]*\n.*?^\1\2|^\$\$.*?^\$\$|\$[^$\n]+\$|``[^`]+``|`[^`]*`"
    r"|\]\([^)\s]*\)|<!--.*?-->|https?://\S+",
    re.DOTALL | re.MULTILINE,
)
# Studies and the build of the site write these folders.
SKIPPED = {"tables", "_build", "gallery", "writeups"}
# Pattern -> the remedy.
HABITS = {
    r"\bthose\b": "repeat the noun",
    r"\b(than|is|are|as|to|by|from) that of\b": "repeat the noun",
    r"\bthe ones?\b(?! hand)": "repeat the noun",
    r"\bbut (where|for)\b": "unless, except",
    r"(?<!there )\b(is|are) (?-i:none)\b": "an adjective or a verb",
    r"\bmostly\b": "give the condition",
    r", for (it|they|there|these|then)\b": "because",
    r"\b(from|out of|along|between) which\b": "two sentences",
}
FIRST = re.compile(
    r"(What|Who|Which|Where|Whether (it|they)|The same|The ones?|Those|These|That|This|One|It|Its"
    r"|They|Their|Others|Also|So|As above)\b"
)


@cache
def unused_words():
    """Pattern -> the word to write instead, from the table of the glossary."""
    rows = GLOSSARY.read_text(encoding="utf-8").split(HEADING)[1].split("\n## ")[0]
    table = re.findall(r"^\| (.+?) \| (.+?) \|$", rows, re.MULTILINE)[1:]
    words = {}
    for instead, unused in table:
        for word in unused.split(", "):
            words[rf"\b{re.escape(word)}\b"] = instead
    return words


def prose(text):
    """The sentences of a page, without code and without the table of unused words."""
    before, heading, after = text.partition(HEADING)
    if heading:
        after = "\n## ".join(after.split("\n## ")[1:])
    return PROSE.sub(" X ", before + after)


def faults(text):
    """Each use of an unused word or habit in a text: the words around it, and the remedy."""
    sentences = " ".join(prose(text).split())
    for pattern, instead in (unused_words() | HABITS).items():
        for place in re.finditer(pattern, sentences, re.IGNORECASE):
            around = sentences[max(place.start() - 40, 0) : place.end() + 20]
            yield f"... {around} ...: {place[0]!r}, write: {instead}"


def pages():
    """The pages whose prose is checked. The write-ups define words of their own."""
    inside = (path for path in (ROOT / "docs").rglob("*.md") if not SKIPPED & set(path.parts))
    names = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")
    names += ("docs/writeups/README.md", "docs/writeups/paper.md")
    named = (ROOT / name for name in names)
    return [*named, *sorted(inside)]


def text_of(page):
    """The text of a page; of the changelog only the part of the last version."""
    text = page.read_text(encoding="utf-8")
    if page.name != "CHANGELOG.md":
        return text
    return text.split("\n## ")[1]
