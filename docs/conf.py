"""How Sphinx builds the documentation: `make docs`. Nothing is fetched, neither here nor by the pages."""

import sys
from pathlib import Path

for package in ("ema_bench_replay", "ema_twin_sim"):  # the sources beside this file, whatever is installed
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / package))

project = "EMA twin"
copyright = "EMA twin authors, Apache-2.0"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_maximum_signature_line_length = 100
exclude_patterns = ["_build"]
myst_heading_anchors = 3  # as far down as pages link to their own headings
html_theme = "furo"
html_title = project
html_copy_source = html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["wide.css"]
