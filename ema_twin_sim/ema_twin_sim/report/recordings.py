"""Tables with one row per recording and one column per model, for the given and for the held-out recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..comparison.closeness import Closeness, closer
from ..comparison.compare import Signals
from ..quantities import quantity, signal_words
from ..words.error_cells import ALL, closeness_cell
from ..words.findings import UnseenErrors
from ..words.sentences import by_number
from .content import Content, Shown
from .markup import Markup, section, table, tag
from .steps import from_the_given
from .summary import error_table


def recordings(content: Content) -> Markup:
    """The section with one table per main signal, for the given recordings."""
    tables = [_by_recording(content.given, name, content.labels) for name in content.given.headlines]
    other = "the model after" if len(content.models) == 2 else "the other model"
    told = (
        f"Times closer: error of {'the model before' if len(content.models) == 2 else 'your model'} over that of "
        f"{other}, each with the noise subtracted (√(RMSE² − noise floor²)). ≥: the later model's error is within the "
        "noise."
    )
    return section("recordings", "Recording by recording", *tables, tag("p", told, class_="aside"))


def held_out(content: Content) -> Markup:
    """The section with errors before and after on recordings that were not fitted to."""
    title = "On recordings that were held out"
    if content.held_out is not None:
        shown = content.held_out
        whole = error_table(shown, content.labels, "RMSE, measured minus twin, recordings held out")
        return section(
            "held-out", title, whole, *(_by_recording(shown, name, content.labels) for name in shown.headlines)
        )
    unseen = content.findings.unseen if content.findings is not None else None
    if unseen is not None and len(unseen.recordings) > 1:
        told = (
            "No held-out recordings were given (--held-out). In the search, each recording was simulated with "
            "parameters fitted to the other recordings only:"
        )
        return section("held-out", title, tag("p", told), _unseen(unseen))
    told = "None was given (--held-out): the recordings above may have been used for fitting."
    return section("held-out", title, tag("p", told))


def _by_recording(shown: Shown, name: str, names: Sequence[str]) -> Markup:
    """Table 5.1 of the thesis: a row for each recording, a column for each model, and how many times closer it is."""
    first, *others = shown.comparisons
    unit = first.overall[name]["unit"]
    closest = [closer(first, other) for other in others]

    def cells(errors: Sequence[Signals], times: Sequence[Mapping[str, Closeness]]) -> list[str]:
        before, *after = (quantity(error[name]["rmse"], unit) for error in errors)
        pairs = zip(after, times, strict=True)
        return [before, *(cell for rmse, each in pairs for cell in (rmse, closeness_cell(each.get(name))))]

    rows: list[list[str]] = []
    for k in sorted(range(len(first.recordings)), key=lambda k: by_number(first.recordings[k].name)):
        recording = first.recordings[k]
        if name in recording.signals:
            errors = [comparison.recordings[k].signals for comparison in shown.comparisons]
            rows.append([recording.name, *cells(errors, [each.recordings[k][1] for each in closest])])
    overall = [comparison.overall for comparison in shown.comparisons]
    rows.append([tag("strong", cell) for cell in (ALL, *cells(overall, [each.overall for each in closest]))])
    floor = quantity(first.overall[name]["noise_floor"], unit)
    caption = f"RMSE of the {signal_words(name, unit)} (the sensors' noise: {floor})"
    heads = [head for later in names[1:] for head in (later, "times closer")]
    return table(("recording", names[0], *heads), rows, caption=caption, stacked=False)


def _unseen(unseen: UnseenErrors) -> Markup:
    whole, each = from_the_given(unseen)
    refitted = len(whole) > len(unseen.rmse)
    rows = [
        (name, *(quantity(value, unseen.unit) for value in (*values[: 1 + refitted], values[-1])))
        for name, values in (*each, (ALL, whole))
    ]
    floor = quantity(unseen.noise_floor, unseen.unit)
    caption = f"RMSE of the {signal_words(unseen.signal, unseen.unit)} (the sensors' noise: {floor})"
    head = ("recording", "before", *(["its own constants fitted"] if refitted else []), "after")
    return table(head, rows, caption=caption, stacked=False)
