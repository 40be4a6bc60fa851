"""Tables whose words fold and whose numbers stay whole, so that a terminal of 80 columns shows all of them."""

from __future__ import annotations

from rich.box import SIMPLE_HEAD
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from .output import console

_NARROW = 110  # columns of a terminal below which rules between columns are left out


class ReportTable(Table):
    """A table of words and numbers; a ``title`` stands above it."""

    def __init__(self, title: str | None = None) -> None:
        narrow = console.width < _NARROW
        super().__init__(title=title, title_justify="left", pad_edge=False)
        if narrow:
            self.box = SIMPLE_HEAD
            self.collapse_padding = True

    def words(self, *headers: str, widest: int | None = None) -> None:
        """Add columns of text, at most ``widest`` characters wide, that fold where space is short."""
        for header in headers:
            self.add_column(header, overflow="fold", max_width=widest)

    def numbers(self, *headers: str, justify: str = "right") -> None:
        """Add columns of numbers with their units: a cell is never broken, a header may be."""
        for header in headers:
            self.add_column(header, justify="right" if justify == "right" else "left", overflow="fold", min_width=1)

    def add_row(self, *cells: RenderableType | None, style: str | None = None, end_section: bool = False) -> None:  # type: ignore[override]
        """Add a row; columns of numbers grow with it."""
        for column, cell in zip(self.columns, cells, strict=False):
            if column.min_width is not None and isinstance(cell, str):
                column.min_width = max(column.min_width, Text.from_markup(cell).cell_len)
        super().add_row(*cells, style=style, end_section=end_section)
