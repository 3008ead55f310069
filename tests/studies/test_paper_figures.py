"""The figures at quick size: which files they make, when they compute data, and what a reader needs
to see."""

from contextlib import redirect_stdout
from io import StringIO

import numpy as np
import pytest
from matplotlib.image import imread
from matplotlib.text import Text

from paper_figures import style
from paper_figures.__main__ import FIGURES, main, make

NAMES = list(FIGURES)


@pytest.fixture(scope="module")
def data(quick, quick_data):
    """Folder with the quick tables of all figures."""
    for script in FIGURES.values():
        quick(script.TABLES.values())
    return quick_data


def options(data, output):
    return ["--quick", "--data", str(data), "--output", str(output)]


@pytest.fixture(scope="module")
def run(data, tmp_path_factory):
    """The command without names: its figures by name, the folder of its files, and what it
    prints."""
    folder, save, figures = tmp_path_factory.mktemp("figures"), style.save, {}

    def kept(figure, name, output):
        figures[name] = figure
        return save(figure, name, output)

    with pytest.MonkeyPatch.context() as patch, redirect_stdout(StringIO()) as printed:
        patch.setattr(style, "save", kept)
        assert main(options(data, folder)) == 0
    return figures, folder, printed.getvalue()


@pytest.fixture
def figures(run):
    """The drawn and saved figures, name -> figure."""
    return run[0]


@pytest.fixture
def drawn(run):
    """Folder with the files of all figures."""
    return run[1]


def test_all_figures_are_drawn_by_default(run):
    figures, folder, printed = run
    assert list(figures) == NAMES
    files = [folder / f"{name}.{kind}" for name in NAMES for kind in ("pdf", "png")]
    assert printed.split() == list(map(str, files)) and sorted(folder.iterdir()) == sorted(files)


@pytest.mark.parametrize("name", NAMES)
def test_files_show_something(drawn, name):
    pdf, png = (drawn / f"{name}.{kind}" for kind in ("pdf", "png"))
    assert pdf.read_bytes().startswith(b"%PDF") and pdf.stat().st_size > 8_000
    assert b"CreationDate" not in pdf.read_bytes() and b"/Type3" not in pdf.read_bytes()
    assert png.stat().st_size > 10_000
    image = imread(png)[..., :3]
    width = image.shape[1] / 300 * 25.4
    assert min(abs(width - 84), abs(width - 174)) < 0.2
    dark = (image.min(axis=-1) < 0.6).mean(axis=0)
    assert np.mean(dark > 0) > 0.7, "most columns of pixels carry ink"
    assert 0.01 < dark.mean() < 0.5


def test_same_data_gives_the_same_bytes(data, drawn, tmp_path):
    again = make("onset", quick=True, data=data, output=tmp_path)
    assert [path.read_bytes() for path in again] == [
        (drawn / path.name).read_bytes() for path in again
    ]


def test_second_call_does_not_compute_again(data, tmp_path):
    before = {path: (path.stat().st_mtime_ns, path.read_bytes()) for path in data.glob("*.parquet")}
    assert main(["traction_ratio", "hysteresis", *options(data, tmp_path)]) == 0
    assert {path: (path.stat().st_mtime_ns, path.read_bytes()) for path in before} == before


def test_unknown_name_is_refused_before_anything_is_drawn(data, tmp_path, capsys):
    assert main(["scene", "figure9", *options(data, tmp_path)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "'figure9'" in said.err and all(name in said.err for name in NAMES)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", NAMES)
def test_letters_are_large_enough(figures, name):
    texts = [text for text in figures[name].findobj(Text) if text.get_text().strip()]
    assert len(texts) > 10
    assert min(text.get_fontsize() for text in texts) >= 7


@pytest.mark.parametrize("name", NAMES[1:])
def test_axes_are_named(figures, name):
    """Panels above another share its horizontal axis; enlargements at the right share the vertical
    one of their neighbour."""
    drawn = [
        axes
        for axes in figures[name].axes
        if axes.axison and axes.xaxis.get_visible() and axes.get_subplotspec()
    ]  # pictures and second scales have none, colour bars no place in the grid
    for axes in drawn:
        place, shared = axes.get_subplotspec(), axes.get_shared_x_axes().get_siblings(axes)
        below = [other.get_subplotspec() for other in shared if other.axison]
        lowest = not any(
            other.colspan == place.colspan and other.rowspan.start > place.rowspan.start
            for other in below
        )
        assert bool(axes.get_xlabel()) == lowest
        assert (
            any(label.get_visible() and label.get_text() for label in axes.get_xticklabels())
            or not lowest
        )
    assert all(axes.get_ylabel() for axes in drawn if axes.get_subplotspec().is_first_col())


@pytest.mark.parametrize("name", NAMES[1:])
def test_legends_cover_no_data(figures, name):
    legends = 0
    for axes in figures[name].axes:
        legend = axes.get_legend()
        if legend is None:
            continue
        legends += 1
        box = legend.get_window_extent()
        for line in axes.get_lines():
            points = line.get_transform().transform(line.get_xydata())
            assert not any(box.contains(x, y) for x, y in points)
    assert legends or figures[name].legends
