"""Sphinx configuration: one command builds the site, ``sphinx-build -W -n docs docs/_build``."""

import sys
from pathlib import Path

import contactstudy as cs

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

# Public objects are documented under their public name.
for _name in cs.__all__:
    _object = getattr(cs, _name)
    if getattr(_object, "__module__", "").startswith("contactstudy."):
        _object.__module__ = "contactstudy"

project = "contactstudy"
author = "the contactstudy developers"
copyright = author
release = version = cs.__version__
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_click",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "mathml",
    "generated_reference",
    "accessible_pages",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["_build", "_ext", "_templates"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
suppress_warnings = ["config.cache"]
smartquotes = False  # two dashes are an option of a command

html_theme = "furo"
html_title = f"contactstudy {release}"
templates_path = ["_templates"]
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_math_renderer = "mathml"
html_show_sphinx = False

napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_attr_annotations = False  # types are in the signature
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
nitpicky = True
# Names of numpy, xarray, matplotlib and the standard library. Their inventories are on the network, where the site is not built from; the
# names say what they are without a link.
nitpick_ignore_regex = [
    ("py:class", r"(numpy|xarray|matplotlib|collections\.abc|os)\.[\w.]+"),
    ("py:obj", r"typing\.Annotated\[float"),
    # parts of answers and of scenes, whose classes have no page of their own
    ("py:class", r"SteadyRolling|RepeatedRolling|Trajectory|FilmTrajectory|StressModel|AdhesiveSolver|ShearCompliance"),
]

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": r"plot_",
    "within_subsection_order": "FileNameSortKey",
    "remove_config_comments": True,
    "show_signature": False,
    "capture_repr": (),
    "min_reported_time": 1e9,
    "download_all_examples": False,
    "image_scrapers": ("gallery_figures.scrape",),
    "write_computation_times": False,
}
