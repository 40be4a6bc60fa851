"""Where each model fails: residuals against speed, output position, direction and order."""

from __future__ import annotations

from collections.abc import Mapping

from ..comparison.beyond_noise import is_noise
from ..comparison.where import FEWEST_SAMPLES
from ..quantities import quantity
from .chart import MODELS, Charts
from .content import Content, Shown, signals_listed
from .markup import Markup, capitalised, items, joined, section, swatch, table, tag
from .residual_charts import failures, named_orders


def where(content: Content, charts: Charts) -> Markup:
    """The section with the residuals against the quantities that they may depend on."""
    figures: list[Markup] = []
    orders: dict[str, list[list[str]]] = {}
    for each in failures(content.given, content.models[0], content.labels, limited=True):
        figures += [charts.add(chart) for chart in each.charts]
        if each.orders is not None:
            figures.append(charts.add(each.orders.chart))
            unit = each.orders.unit
            orders[content.given.words(each.signal)] = [
                [quantity(a, unit) for a in peaks] for *_, peaks in each.orders.named
            ]
    if not figures:
        takes = f"{FEWEST_SAMPLES} samples, the current, and the motor's position or speed"
        return section("where", "Where the models fail", tag("p", f"This needs {takes}."))
    key = tag(
        "p",
        *(swatch(colour.removeprefix("@"), name) for colour, name in zip(MODELS, content.labels, strict=False)),
        "Line: median; shaded: between the quartiles; grey: two standard deviations of the sensors' noise.",
        class_="key",
    )
    named = [_orders_table(content, orders)] if orders else []
    told = [
        joined([tag("strong", name), f": {said}"])
        for name, said in zip(content.labels, sentences(content.given), strict=True)
    ]
    return section("where", "Where the models fail", items(*told), key, tag("div", *figures, class_="grid"), *named)


def _orders_table(content: Content, amplitudes: Mapping[str, list[list[str]]]) -> Markup:
    """Table of the orders that the machine's file names, by their numbers in the spectra, with the amplitudes there."""
    named = named_orders(content.models[0])
    if not named:
        return tag("p", f"{content.names[0]} names no orders (`orders:` in its file).", class_="aside")
    columns = [f"{signal}, {model}" for signal in amplitudes for model in content.labels]
    rows = [
        (f"{k + 1}: {name}", f"{order:g}", *(cell for each in amplitudes.values() for cell in each[k]))
        for k, (order, name) in enumerate(named)
    ]
    whole = table(("order", "cycles per turn", *columns), rows, stacked=False)
    return tag(
        "details", tag("summary", "The machine's own orders, by their numbers above the spectra"), whole, open=""
    )


def sentences(given: Shown) -> list[str]:
    """What the errors of each model depend on, in words."""
    lines = []
    for comparison in given.comparisons:
        errors = comparison.overall
        poor = [name for name in given.headlines if not is_noise(errors[name])]
        found = [next((d.sentence() for d in comparison.where if d.signal == signal), "") for signal in poor]
        said = " ".join(text for text in found if text)
        if not poor:
            said = f"{capitalised(signals_listed(given, given.headlines))}: at the sensors' noise."
        lines.append(said or "The location cannot be determined.")
    return lines
