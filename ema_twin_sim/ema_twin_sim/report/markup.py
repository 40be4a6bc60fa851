"""Build HTML from parts: everything that is not markup already is escaped."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Sequence

# blanks between a number and its unit or standard error, where a line must not break
_TIE = re.compile(r"(?<=\d) (?=[%±×]|[nµmkM]?(?:A|V|s|Hz|rad|N|kg|m)\b)|(?<=±) |(?<=N) (?=m\b)")


class Markup(str):
    """Text that is HTML."""


def tag(name: str, *content: str, **attributes: str) -> Markup:
    """An element; ``class_`` and ``data_chart`` stand for the attributes ``class`` and ``data-chart``."""
    given = "".join(f' {key.rstrip("_").replace("_", "-")}="{html.escape(value)}"' for key, value in attributes.items())
    return Markup(f"<{name}{given}>{joined(content)}</{name}>")


def joined(content: Iterable[str]) -> Markup:
    """The parts one after the other."""
    return Markup("".join(part if isinstance(part, Markup) else _escaped(part) for part in content))


def _escaped(text: str) -> str:
    """Text as HTML, with every number kept on one line with its unit."""
    return _TIE.sub("\N{NO-BREAK SPACE}", html.escape(text))


def section(id: str, title: str, *content: str) -> Markup:
    """A section of the page, with its heading."""
    return tag("section", tag("h2", title), *content, id=id)


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    words: Sequence[int] = (0,),
    caption: str = "",
    stacked: bool = True,
) -> Markup:
    """A table whose columns hold numbers, except ``words``.

    On a narrow screen, each row becomes a list of its cells under their heads if ``stacked``; else the table scrolls.
    """
    kinds = ["word" if k in words else "number" for k in range(len(head))]
    titles = (tag("th", title, scope="col", class_=kind) for title, kind in zip(head, kinds, strict=True))
    body = [
        tag(
            "tr",
            *(
                tag("td", cell, class_=kind, data_head=title)
                for cell, kind, title in zip(row, kinds, head, strict=True)
            ),
        )
        for row in rows
    ]
    named = [tag("caption", caption)] if caption else []
    whole = tag("table", *named, tag("thead", tag("tr", *titles)), tag("tbody", *body))
    return tag("div", whole, class_="stacked" if stacked else "scroll", tabindex="0")


def items(*lines: str) -> Markup:
    """A list."""
    return tag("ul", *(tag("li", line) for line in lines))


def bar(share: float, text: str, kind: str) -> Markup:
    """A bar with a length from 0 to 1, and its number next to it."""
    length = tag("span", "", class_=f"length {kind}", style=f"width:{100.0 * min(max(share, 0.0), 1.0):.1f}%")
    return tag("span", tag("span", length, class_="room"), tag("span", text, class_="value"), class_="bar")


def swatch(role: str, *name: str) -> Markup:
    """A legend's entry: the colour of a role in the charts, and what it stands for."""
    return tag("span", tag("span", "", class_=f"swatch {role}"), *name)


def capitalised(text: str) -> str:
    """The text with its first letter capitalised, the rest unchanged."""
    return text[:1].upper() + text[1:]
