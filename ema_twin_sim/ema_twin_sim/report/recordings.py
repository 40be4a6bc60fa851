"""A row a recording, a column a model: on the recordings given, and on those that were held out."""

from __future__ import annotations

from ..quantities import quantity
from .content import Content, Shown, signal_words
from .findings import UnseenErrors
from .markup import Markup, section, table, tag
from .summary import error_table

ALL = "all recordings"


def recordings(content: Content) -> Markup:
    """The tables a recording."""
    tables = [_by_recording(content.given, name, content.names) for name in content.given.headlines]
    return section("recordings", "Recording by recording", *tables)


def held_out(content: Content) -> Markup:
    """Before and after on recordings that were not fitted to."""
    title = "On recordings that were held out"
    if content.held_out is not None:
        shown = content.held_out
        whole = error_table(shown, content.names, "RMSE, measured minus twin, recordings held out")
        return section(
            "held-out", title, whole, *(_by_recording(shown, name, content.names) for name in shown.headlines)
        )
    unseen = content.findings.unseen if content.findings is not None else None
    if unseen is not None and len(unseen.recordings) > 1:
        told = (
            "None was given apart (--held-out). In the search, each recording was simulated with numbers that were "
            "fitted to the others only:"
        )
        return section("held-out", title, tag("p", told), _unseen(unseen))
    told = "None was given (--held-out): what is shown above may be what the model was fitted to."
    return section("held-out", title, tag("p", told))


def _by_recording(shown: Shown, name: str, names: tuple[str, str]) -> Markup:
    """Thesis, table 5.1: a row a recording, a column a model, and how many times smaller the error is."""
    first, second = shown.comparisons
    unit = first.overall[name]["unit"]
    each = zip(first.recordings, second.recordings, strict=True)
    pairs = sorted((a.name, a.signals[name]["rmse"], b.signals[name]["rmse"]) for a, b in each if name in a.signals)
    rows = [_row(title, before, after, unit) for title, before, after in pairs]
    whole = _row(ALL, first.overall[name]["rmse"], second.overall[name]["rmse"], unit)
    rows.append([tag("strong", cell) for cell in whole])
    floor = quantity(first.overall[name]["noise_floor"], unit)
    caption = f"RMSE of the {signal_words(name)} (the sensors' noise: {floor})"
    return table(("recording", *names, "times smaller"), rows, caption=caption, stacked=False)


def _unseen(unseen: UnseenErrors) -> Markup:
    pairs = (*unseen.recordings, (ALL, unseen.rmse))
    rows = [_row(name, values[0], values[-1], unseen.unit) for name, values in pairs]
    caption = (
        f"RMSE of the {signal_words(unseen.signal)} (the sensors' noise: {quantity(unseen.noise_floor, unseen.unit)})"
    )
    return table(("recording", "before", "after", "times smaller"), rows, caption=caption, stacked=False)


def _row(title: str, before: float, after: float, unit: str) -> list[str]:
    times = f"{before / after:.3g} ×" if after > 0.0 else "–"
    return [title, quantity(before, unit), quantity(after, unit), times]
