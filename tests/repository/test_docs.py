"""The documentation: its code runs, its names, numbers, links and tables are those of the
package."""

import doctest
import inspect
import re
import runpy
from importlib import import_module
from itertools import combinations
from operator import attrgetter
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

import cvxpy as cp
import matplotlib.pyplot as plt
import numpy as np
import pytest

import frictopt as fo
from helpers.public_names.cited import CITED
from paper_figures.__main__ import FIGURES
from studies.__main__ import STUDIES

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / f"{name}.md" for name in ("README", "CONTRIBUTING", "CHANGELOG")]
PAGES += sorted(path for path in DOCS.rglob("*.md") if "_build" not in path.parts)
EXAMPLES = sorted((DOCS / "examples").glob("*.py"))
FAULTS = DOCS / "tables" / "mutants.md"
TABLES = sorted({*(DOCS / "tables").glob("*.md")} - {FAULTS})


def text(path):
    return path.read_text(encoding="utf-8")


@pytest.fixture
def quiet(monkeypatch, few_starts):
    """No figure is left open, no progress bar printed, and searches are short."""
    pyvista = pytest.importorskip("pyvista")
    monkeypatch.setenv("TQDM_DISABLE", "1")
    monkeypatch.setattr(
        pyvista.Plotter, "show", lambda scene, **_: scene.close()
    )  # a machine that tests need not draw in space
    with plt.rc_context({"backend": "agg"}):
        yield
    plt.close("all")


@pytest.mark.parametrize(
    "page",
    sorted({*(DOCS / "tutorial").glob("*.md")} - {DOCS / "tutorial" / "index.md"}),
    ids=lambda page: page.stem,
)
def test_the_site_runs_the_code_of_a_tutorial_page_and_shows_its_pictures(page):
    body = text(page)
    assert (
        body.startswith(
            "---\nfile_format: mystnb\nkernelspec: {name: python3, display_name: Python 3}\n---\n\n# "
        )
        and "```python" not in body
    )
    cells = re.findall(r"```\{code-cell\} python\n(?::tags: [^\n]*\n)?(.*?)```", body, re.DOTALL)
    for cell in cells:
        compile(cell, str(page), "exec")
    assert any(re.search(r"\bplot\w*\(", cell) for cell in cells)
    assert body.splitlines()[-1].startswith(
        f"{{nb-download}}`This page as a notebook <{page.stem}.ipynb>`"
    )


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")  # of OSQP, as the page says
def test_the_page_that_opens_the_model_runs_as_typed_and_its_numbers_agree(quiet):
    page = dict[str, Any]()
    for cell in re.findall(
        r"```\{code-cell\} python\n(.*?)```", text(DOCS / "tutorial" / "models.md"), re.DOTALL
    ):
        exec(cell, page)
    again = fo.shakedown_limit(page["system"], page["both"], 0.7)
    assert page["model"].solve(0.7, page["shared"]).load_factor == pytest.approx(
        again.load_factor, rel=1e-9
    )
    assert page["half"].value == pytest.approx(
        fo.shakedown_limit(page["system"], page["cycle"], 0.35).load_factor, rel=1e-9
    )
    assert page["kept"].problem.value == pytest.approx(page["limit"].load_factor, rel=1e-9)
    assert page["worst"].load_factor <= min(page["drawn"])
    pairs = [
        dict(zip(page["bolts"], np.add(1.0, 2.0 * np.isin(range(5), pair)), strict=True))
        for pair in combinations(range(5), 2)
    ]
    limits = [
        fo.shakedown_limit(page["lap"], fo.LoadCycle(pair, page["swing"]), 0.4).load_factor
        for pair in pairs
    ]
    assert (
        page["which"].value == pytest.approx(max(limits), rel=1e-7)
        and page["chosen"] == pairs[int(np.argmax(limits))]
    )
    assert fo.shakedown_limit(
        page["small"], page["cycle"], page["five"]
    ).load_factor == pytest.approx(page["most_coated"], rel=1e-7)
    assert page["proven"] <= page["above"] * (1 + 1e-7) and page["above"] < 1.02 * page["proven"]
    few = fo.ShakedownModel(fo.scenes.PunchOnHalfPlane(elements=8).condense(), page["cycle"])
    of_pairs = [
        few.solve(0.4 + 0.3 * np.isin(range(9), pair)).load_factor
        for pair in combinations(range(9), 2)
    ]
    best = page["coat"](few.solve(0.4), 2, lambda q: [cp.abs(q)])[1].solve(solver="HIGHS")
    assert best == pytest.approx(max(of_pairs), rel=1e-7)


@pytest.mark.parametrize(
    "page",
    sorted({*(DOCS / "api").glob("*.md")} - {DOCS / "api" / "index.md"}),
    ids=lambda page: page.stem,
)
def test_a_page_of_the_reference_has_a_sentence_an_example_that_runs_and_a_link_to_theory(
    page, quiet
):
    body = text(page)
    assert re.match(r"# .+\n\n[A-Z]", body) and re.search(
        r"\]\(\.\./(theory|checked|validity)\.md", body
    )
    (code,) = re.findall(r"```python\n(.*?)```", body, re.DOTALL)
    exec(code, {})


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_is_short_and_runs(path, quiet, monkeypatch, tmp_path):
    """From both folders where it asks which of them it is in, else from an empty one."""
    assert text(path).count("\n") <= 60
    for folder in (ROOT, DOCS / "examples") if "Path()" in text(path) else (tmp_path,):
        monkeypatch.chdir(folder)
        runpy.run_path(str(path), run_name="__main__")
        assert plt.get_fignums()
        plt.close("all")


def test_the_gallery_has_examples():
    assert 8 <= len(EXAMPLES) <= 24


def test_pictures_that_pages_draw_themselves_have_the_letters_of_results():
    """The pages' settings are read when the site is built, see `docs/conf.py`."""
    with plt.rc_context(fname=DOCS / "matplotlibrc"):
        figure, ax = plt.subplots()
        figure.canvas.draw()
        own = ax.xaxis.label, ax.get_xticklabels()[0]
    system = fo.scenes.PunchOnHalfPlane(elements=4).condense()
    of_result = fo.onset(system, fo.LoadCycle({"P": 1.0}, [{"Q": 0.1}]), 0.5).plot()
    of_result.figure.canvas.draw()
    for one, other in zip(
        own, (of_result.xaxis.label, of_result.get_xticklabels()[0]), strict=True
    ):
        assert one.get_fontname() == other.get_fontname()
        assert one.get_fontsize() == pytest.approx(other.get_fontsize())
    plt.close("all")


LISTED = re.compile(r"^   (\w+)$", re.MULTILINE)


def listed(page):
    """Names in the lists of an API page."""
    return LISTED.findall(text(page))


def test_every_public_name_is_on_exactly_one_page_of_the_reference():
    pages = sorted((DOCS / "api").glob("*.md"))
    modules = {
        "increments": fo.increments,
        "reference": fo.reference,
        "results": fo.results,
        "scenes": fo.scenes,
        "starts": fo.starts,
    }
    names = [name for page in pages if page.stem not in modules for name in listed(page)]
    rooms = {"fem": fo.fem, "joints": fo.joints, "readers": fo.readers}
    public = set(fo.__all__).union(*(room.__all__ for room in rooms.values()))
    assert sorted(names) == sorted(public - set(modules) - set(rooms))
    for stem, module in modules.items():
        assert sorted(listed(DOCS / "api" / f"{stem}.md")) == sorted(module.__all__)
    for page in pages:
        for part in text(page).split("currentmodule:: ")[1:]:
            module = import_module(part.split()[0])  # as the site imports it
            assert set(LISTED.findall(part)) <= set(dir(module))


def test_a_public_function_says_in_its_section_returns_what_it_returns():
    """If it returns a class of the reference, its type is the name of this class, for a link."""
    modules = (
        fo,
        fo.fem,
        fo.increments,
        fo.joints,
        fo.readers,
        fo.reference,
        fo.results,
        fo.starts,
    )
    classes = {
        name
        for module in modules
        for name in module.__all__
        if inspect.isclass(getattr(module, name))
    }
    for module in modules:
        for name in module.__all__:
            function = getattr(module, name)
            if not inspect.isfunction(function):
                continue
            annotation = inspect.signature(function).return_annotation
            returned = getattr(annotation, "__name__", str(annotation))
            if returned == "None":
                continue
            section = re.search(
                r"^Returns\n-+\n(.+)\n {4}\S", inspect.getdoc(function), re.MULTILINE
            )
            assert section, name
            assert returned not in classes or section[1] == returned, name


def test_docstrings_cite_the_equations_of_the_theory_page_by_their_numbers():
    labels = re.findall(r"^:label: (\w+)$", text(DOCS / "theory.md"), re.MULTILINE)
    assert len(set(labels)) == len(labels) == text(DOCS / "theory.md").count("```{math}")
    for name, label in CITED.items():
        assert f"Theory, eq. ({labels.index(label) + 1})" in " ".join(
            inspect.getdoc(attrgetter(name)(fo)).split()
        ), name
    count = sum(
        " ".join(text(path).split()).count("Theory, eq. (")
        for path in (ROOT / "frictopt").rglob("*.py")
    )
    assert count == len(CITED)
    assert set(re.findall(r"\{eq\}`(\w+)`", text(DOCS / "theory.md"))) <= set(labels)


def test_sections_of_docstrings_have_their_names():
    known = {
        "Attributes",
        "Examples",
        "Notes",
        "Parameters",
        "Raises",
        "References",
        "Returns",
        "See Also",
        "Warns",
        "Yields",
    }
    for path in (ROOT / "frictopt").rglob("*.py"):
        heads = re.findall(r"^ *(.*)\n *-{4,}$", text(path), re.MULTILINE)
        assert set(heads) <= known, path


def anchors(page):
    """Anchors of the headings of a page, as GitHub and the site make them."""
    heads = re.findall(
        r"^#+ (.+)$", re.sub(r"```.*?```", "", text(page), flags=re.DOTALL), re.MULTILINE
    )
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page):
    body = text(page)
    targets = re.findall(r"\]\(([^)\s]+)\)", body) + re.findall(
        r"\{download\}`[^<]*<([^>]+)>`", body
    )
    targets += re.findall(r"```\{(?:image|include)\} (\S+)", body)
    for target in targets:
        if re.match(r"https?://", target):
            continue
        name, _, anchor = target.partition("#")
        found = page.parent / name if name else page
        if found == DOCS / "gallery" / "index.rst":  # the build makes it of the examples
            continue
        assert found.exists(), target
        assert not anchor or anchor in anchors(found), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_what_a_page_names_exists(page):
    body = text(page)
    for name in re.findall(
        r"`((?:paper_figures|studies|tests|docs/examples|frictopt)/[\w/]+(?:\.py)?)`", body
    ):
        assert (ROOT / name).exists() or name in ("studies/data", "paper_figures/output"), name
    for name in re.findall(r"python -m studies (?!NAME)(\w+)", body):
        assert name in STUDIES, name
    for name in re.findall(r"\bfo\.((?:\w+\.)*\w+)", body):
        thing = fo
        for part in name.split("."):
            thing = getattr(thing, part)


def test_pages_in_a_table_of_contents_exist_and_are_complete():
    for index in (DOCS / "index.md", DOCS / "tutorial" / "index.md", DOCS / "api" / "index.md"):
        (entries,) = re.findall(r"```\{toctree\}\n(?::.*\n)*\n(.*?)```", text(index), re.DOTALL)
        wanted = [entry for entry in entries.split() if entry != "gallery/index"]
        assert all((index.parent / f"{entry}.md").exists() for entry in wanted)
        siblings = {path.stem for path in index.parent.glob("*.md")} - {"index"}
        assert siblings == {entry for entry in wanted if "/" not in entry}


def test_the_page_of_figures_lists_all():
    table = re.findall(
        r"^\| .* \| `paper_figures/(\w+)\.py` \| .*\|$", text(DOCS / "studies.md"), re.MULTILINE
    )
    assert sorted(table) == sorted(FIGURES)


def heads(page):
    """First cells of all tables of a page: the names of their columns."""
    return re.findall(r"^\| (.+) \|\n\|[-|]+\|$", page, re.MULTILINE)


def test_tables_come_from_the_studies():
    pages = "".join(
        text(DOCS / f"{page}.md")
        for page in (
            "calculix",
            "checked",
            "paper",
            "peers",
            "performance",
            "published",
            "size",
            "solvers",
            "validity",
        )
    )
    shown = set(re.findall(r"```\{include\} tables/(\w+)\.md", pages))
    assert shown == {path.stem for path in (*TABLES, FAULTS)} and {
        path.stem for path in TABLES
    } <= set(STUDIES)
    for path in (*TABLES, FAULTS):
        page = text(path)
        assert (
            "`python tests/tools/mutants.py"
            if path == FAULTS
            else f"`python -m studies {path.stem}"
        ) in page and heads(page), path
        for part in re.findall(r"(?:^\|.*\|\n)+", page, re.MULTILINE):
            assert (
                len(
                    {line.count(" | ") for line in part.splitlines() if not line.startswith("|---")}
                )
                == 1
            ), path
    assert " --quick" not in "".join(map(text, TABLES))


@pytest.mark.parametrize(
    "path",
    [*TABLES, *sorted((DOCS / "writeups" / "tables").glob("*.md"))],
    ids=lambda path: path.stem,
)
def test_a_table_is_of_this_version(path):
    """Otherwise run the command in its last line, with the option `--page` and its folder."""
    (made_by,) = re.findall(r"^\*Made by .*, frictopt ([^,]+), .*\*$", text(path), re.MULTILINE)
    assert made_by == fo.__version__


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=[pytest.mark.ccx] if path.stem == "calculix" else [], id=path.stem)
        for path in TABLES
        if path.stem != "fuzz"  # which test_fuzz prints anyway
    ],
)
def test_tables_have_the_columns_of_the_studies(path, quick):
    study = STUDIES[path.stem]
    made, kept = heads(study.summary(quick((*study.needs, *study.tables)))), heads(text(path))
    assert [re.sub(r"N = \d+", "N", head) for head in made] == [
        re.sub(r"N = \d+", "N", head) for head in kept
    ]


ROOMS = [
    import_module(f"frictopt.{room.name}")
    for room in iter_modules(fo.__path__)
    if room.ispkg and room.name not in ("scenes", "solve")
]
NAMES = [
    (room, name)
    for room in (*ROOMS, fo, fo.results, fo.starts)
    for name in getattr(room, "__all__", ())
]
PUBLIC = list(dict.fromkeys(getattr(room, name) for room, name in NAMES))


def has_example(thing):
    return not inspect.ismodule(thing) and not (
        inspect.isclass(thing) and issubclass(thing, Exception)
    )


@pytest.mark.parametrize(
    "thing", list(filter(has_example, PUBLIC)), ids=lambda thing: thing.__name__
)
def test_everything_public_has_an_example(thing):
    text = inspect.getdoc(thing)
    assert "\nExamples\n--------\n" in text and doctest.DocTestParser().get_examples(text)
