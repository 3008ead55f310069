"""Notebooks: each cell shows its own picture, and so do the cells of the user after them; bars
where there are no widgets."""

import subprocess
import sys

import pytest

CELLS = (
    """import frictopt as fo
rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
first = fo.onset(rod, cycle, 0.5).plot();""",
    "import matplotlib.pyplot as plt\nplt.plot([0, 1]);",
    "fo.shakedown_limit(rod, cycle, 0.5).plot();",
    "plt.figure()\nplt.scatter([0, 1], [1, 0]);",
)


@pytest.mark.filterwarnings("ignore:Proactor event loop:RuntimeWarning")  # of zmq on Windows
def test_each_of_four_pictures_is_shown_below_its_own_cell():
    from nbclient import NotebookClient  # here, for it takes seconds
    from nbformat.v4 import new_code_cell, new_notebook

    done = NotebookClient(
        new_notebook(cells=[new_code_cell(cell) for cell in CELLS]),
        kernel_name="python3",
        timeout=300,
        startup_timeout=300,
    ).execute()
    images = [
        [output for output in cell.outputs if "image/png" in output.get("data", {})]
        for cell in done.cells
    ]
    assert [len(shown) for shown in images] == [1, 1, 1, 1]
    assert len({shown[0].data["image/png"] for shown in images}) == 4


WITHOUT_WIDGETS = """
import sys, types, warnings
warnings.simplefilter("always")
for name in ("ipykernel.zmqshell", "IPython", "IPython.display"):
    sys.modules[name] = types.ModuleType(name)
sys.modules["IPython"].get_ipython = lambda: types.SimpleNamespace()
for name in ("HTML", "display", "clear_output"):
    setattr(sys.modules["IPython.display"], name, None)
sys.modules["ipywidgets"] = None
import frictopt as fo
rod = fo.ContactSystem.from_blocks(**fo.reference.foundation_rod(nodes=4, EA=1.0, h=1.0))
cycle = fo.LoadCycle({"pressure": 1.0}, [{"force": 1.0}, {"force": -1.0}])
print(len(fo.dissipation_study(rod, cycle, 0.5, [0.3])))
"""


def test_a_notebook_without_widgets_gets_a_bar_of_text_and_no_warning():
    done = subprocess.run([sys.executable, "-c", WITHOUT_WIDGETS], capture_output=True, text=True)
    assert (
        done.stdout == "1\n" and "transients: 100%" in done.stderr and "Warning" not in done.stderr
    ), done.stderr
