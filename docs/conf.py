"""How Sphinx builds the documentation: `make docs`. Nothing is fetched, neither here nor by the pages."""

project = "EMA twin"
copyright = "EMA twin authors, Apache-2.0"
extensions = ["myst_parser"]
exclude_patterns = ["_build"]
myst_heading_anchors = 3  # as far down as pages link to their own headings
html_theme = "furo"
html_title = project
html_copy_source = html_show_sourcelink = False
html_static_path = ["_static"]
html_css_files = ["wide.css"]
