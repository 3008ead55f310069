"""Settings of the documentation: `python -m sphinx -W -b html docs docs/_build/html` builds it."""

import os
from importlib.metadata import version as installed
from pathlib import Path

from sphinx.application import Sphinx

import frictopt

os.environ |= {
    "TQDM_DISABLE": "1",
    "PYVISTA_BUILDING_GALLERY": "true",
    "PYVISTA_OFF_SCREEN": "true",
    "MATPLOTLIBRC": str(Path(__file__).with_name("matplotlibrc")),
}  # also for the processes of `sphinx -j 2`
os.environ["PYTHONWARNINGS"] = "error:::__main__"  # a cell of the tutorial that warns is an error

project = "frictopt"
author = "The frictopt developers"
copyright = "the frictopt developers"  # noqa: A001  Sphinx reads this name
version = release = installed("frictopt")

extensions = [
    "myst_nb",  # runs the cells of the tutorial
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "sphinx.ext.intersphinx",
    "sphinx.ext.githubpages",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    "sphinx-mathjax-offline",
    "sphinx_copybutton",
]
myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_timeout = 300  # seconds of one cell, the compiler on a slow machine included
nb_execution_raise_on_error = True
nb_merge_streams = True
nb_output_stderr = "remove"  # progress, and the notice of the compiler

# Names of other packages become links where the build may use the network: `sphinx -t online`, and
# on Read the Docs.
online = tags.has("online") or "READTHEDOCS" in os.environ  # noqa: F821, tags is given by Sphinx
intersphinx_mapping = {
    "python": ("https://docs.python.org/3", None),
    "numpy": ("https://numpy.org/doc/stable", None),
    "scipy": ("https://docs.scipy.org/doc/scipy", None),
    "pandas": ("https://pandas.pydata.org/docs", None),
    "matplotlib": ("https://matplotlib.org/stable", None),
    "skfem": ("https://scikit-fem.readthedocs.io/en/latest", None),
}
if not online:
    intersphinx_mapping = {}
linkcheck_allowed_redirects = {r".*": r".*"}
linkcheck_anchors = False
exclude_patterns = [
    "_build",
    "_templates",
    "tables",
    "examples",  # the gallery shows them
    "writeups",  # `writeups/build.py` makes PDF files of them
    "gallery/*.py",
    "gallery/*.ipynb",
    "gallery/*.zip",
    "gallery/*.json",
    "sg_execution_times.rst",
]
math_number_all = False
math_eqref_format = "({number})"
numfig = True

default_role = "code"  # single backticks in docstrings
autosummary_generate = True
autodoc_typehints = "none"  # types and shapes are in the text, which a reader can understand
numpydoc_class_members_toctree = False
numpydoc_show_class_members = False

# The types in docstrings, which are those of "Returns", are links to their pages.
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"  # words that are no names
numpydoc_xref_aliases = {"Array": "numpy.ndarray", "DataFrame": "pandas.DataFrame"}
numpydoc_xref_aliases |= {name: name for name in ("dict", "float", "int", "list", "tuple")}
for module in (
    frictopt,
    frictopt.fem,
    frictopt.increments,
    frictopt.readers,
    frictopt.reference,
    frictopt.results,
    frictopt.starts,
):
    numpydoc_xref_aliases |= {name: f"{module.__name__}.{name}" for name in module.__all__}

sphinx_gallery_conf = {
    "examples_dirs": ["examples"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r"/ex\d+_",
    "within_subsection_order": "FileNameSortKey",
    "image_scrapers": ("matplotlib", "pyvista"),
    "reset_modules": (),  # would reset matplotlib to letters of its own
    "remove_config_comments": True,
    "show_memory": False,
    "parallel": True,  # as many processes as `sphinx -j` says
    "thumbnail_size": (720, 504),
    "capture_repr": (),  # print what is to be seen
    "show_signature": False,
    "min_reported_time": 1e9,
    "download_all_examples": False,
    "abort_on_example_error": True,
    "write_computation_times": False,
}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

templates_path = ["_templates"]

html_theme = "pydata_sphinx_theme"
html_title = "frictopt"
html_static_path = ["_static"]
html_css_files = ["frictopt.css"]
html_theme_options = {
    "show_prev_next": True,
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "header_links_before_dropdown": 5,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": ["sphinx-version"],
}
html_sidebars = {
    name: []
    for name in (
        "theory",
        "glossary",
        "checked",
        "performance",
        "size",
        "validity",
        "questions",
        "studies",
        "faq",
        "help",
    )
}


def setup(app: Sphinx) -> None:
    """Pages may be read by several processes: this extension only copies files at the end, but does not say so."""
    app.extensions["sphinx-mathjax-offline"].parallel_read_safe = True
