"""Tables no wider than the terminal: words fold at blanks, numbers are never broken."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console, ConsoleOptions, RenderableType
from rich.measure import Measurement
from rich.style import Style
from rich.table import Table
from rich.text import Text

from .output import console, fold, longest_piece

_NARROW = 110  # columns of a terminal below which rules between columns are left out
_LONGEST_WORD = 24  # a longer one may be broken if the table would not fit otherwise


def is_narrow() -> bool:
    """Whether the terminal has room only for the essential columns of a table."""
    return console.width < _NARROW


def with_unit(value: float, unit: str) -> str:
    """A number and its unit, if it has one."""
    return f"{value:g}" if unit == "1" else f"{value:g} {unit}"


class ReportTable(Table):
    """A table of words and numbers; a ``title`` stands above it.

    If it is wider than the terminal even when folded, each row becomes a list of its cells.
    """

    def __init__(self, title: str | None = None) -> None:
        super().__init__(pad_edge=False)
        self._heading = title
        self._whole: list[bool] = []
        self._widest: list[int | None] = []
        self._texts: list[list[Text]] = []
        if is_narrow():
            self.box = SIMPLE_HEAD
            self.collapse_padding = True

    def words(self, *headers: str, widest: int | None = None) -> None:
        """Add columns of text, at most ``widest`` characters wide, that fold at blanks if space is short."""
        for header in headers:
            self._add(header, whole=False, widest=widest)

    def numbers(self, *headers: str, justify: str = "right", least: int | None = None) -> None:
        """Add columns of numbers with their units, ``least`` wide or more: a header may fold, a cell never does."""
        for header in headers:
            self._add(header, whole=True, right=justify == "right")
            if least is not None:
                self._texts[-1].append(Text(" " * least))

    def _add(self, header: str, *, whole: bool, widest: int | None = None, right: bool = False) -> None:
        text = Text.from_markup(header)
        self.add_column(_Cell(text), justify="right" if right else "left")
        self._whole.append(whole)
        self._widest.append(widest)
        self._texts.append([text])

    def add_row(
        self, *cells: RenderableType | None, style: str | Style | None = None, end_section: bool = False
    ) -> None:
        """Add a row of strings with markup."""
        texts = [Text.from_markup(str(cell or "")) for cell in cells]
        texts += [Text()] * (len(self.columns) - len(texts))
        for column, text in zip(self._texts, texts, strict=True):
            column.append(text)
        super().add_row(*map(_Cell, texts), style=style, end_section=end_section)

    def fits(self, width: int | None = None) -> bool:
        """Whether all words and numbers fit unbroken into ``width``, by default the terminal's."""
        return self._widths(console.width if width is None else width) is not None

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        if self._heading:
            yield fold(Text(self._heading, "table.title"), options.max_width)
        widths = self._widths(options.max_width, break_words=True)
        if widths is None:
            yield from self._lists(options.max_width)
            return
        for column, width in zip(self.columns, widths, strict=True):
            column.width = width
        yield from super().__rich_console__(console, options)  # type: ignore[misc]

    def _widths(self, room: int, *, break_words: bool = False) -> list[int] | None:
        """Column widths that fit into ``room``, narrowing the widest first; None if they do not fit."""
        least, widths = [], []
        for whole, widest, (header, *cells) in zip(self._whole, self._widest, self._texts, strict=True):
            word = max(longest_piece(text) for text in ([header] if whole else [header, *cells]))
            line = max(len(line) for text in (header, *cells) for line in text.plain.split("\n"))
            least.append(max(word, *map(len, cells), 0) if whole else word)
            widths.append(max(least[-1], min(line, widest or line)))
        room -= self._frame()
        while sum(widths) > room:
            foldable = [k for k, width in enumerate(widths) if width > least[k]]
            if not foldable and break_words:
                foldable = [k for k, width in enumerate(widths) if width > _LONGEST_WORD and not self._whole[k]]
            if not foldable:
                return None
            widths[max(foldable, key=widths.__getitem__)] -= 1
        return widths

    def _frame(self) -> int:
        """Number of characters per line that rules and gaps take."""
        for column in self.columns:
            column.width = 1
        roomy = console.options.update(width=10_000)
        return Measurement.get(console, roomy, self).minimum - len(self.columns)

    def _lists(self, width: int) -> Iterator[Text]:
        headers, *rows = zip(*self._cells(), strict=True)
        for first, *others in rows:
            if first.plain:
                yield fold(Text("", "bold").append(first.plain), width)
            for header, cell in zip(headers[1:], others, strict=True):
                if cell.plain:
                    yield fold(Text.assemble(f"  {header.plain}: ", cell), width)

    def _cells(self) -> Sequence[Sequence[Text]]:
        rows = len(self.rows)
        return [[header, *cells[len(cells) - rows :]] for header, *cells in self._texts]


class _Cell:
    """A text that ``fold`` folds to the width of its column."""

    def __init__(self, text: Text) -> None:
        self.text = text

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Text]:
        yield fold(self.text, options.max_width)

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        return Measurement(1, max(1, len(self.text)))
