"""A page as one file that loads nothing else: its styles, scripts and charts are in it."""

from __future__ import annotations

from importlib.resources import files

from .chart import Charts
from .markup import Markup, tag

_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""What a browser may load for the page: nothing. A picture of a plot that a reader saves is made in the page itself."""


def whole_page(title: str, body: Markup, *, charts: Charts | None = None, script: str = "") -> str:
    """The page; plotly is included only if there are ``charts``, since it is too large for folders of many pages."""
    scripts = f"<script>{script}</script>"
    if charts is not None:
        from plotly.offline import get_plotlyjs

        scripts = (
            f"<script>{get_plotlyjs()}</script>"
            f'<script type="application/json" id="charts">{charts.as_json()}</script>'
            f"<script>{_part('page.js')}</script>"
        )
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta name="color-scheme" content="light dark"><meta name="generator" content="ema-twin">'
        f"{tag('title', title)}<style>{_part('page.css')}</style></head>"
        f"<body><main>{body}</main>{scripts}</body></html>\n"
    )


def _part(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")
