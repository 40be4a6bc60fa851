"""The content of a report."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timezone

from ema_bench_replay.recording import NO_DATE, Recording
from ema_bench_replay.traces.import_map import TIME_UNITS

from ..comparison.beyond_noise import shown_signals
from ..comparison.compare import Comparison, compare_all, explained_signals
from ..listing import listed
from ..model import Model
from ..quantities import signal_words
from ..simulation.simulate import DRIVING
from ..words.findings import Findings
from ..words.fit_findings import FitFindings
from .beside import Beside, beside
from .difference import NewEffect, TwoValues, new_effects, two_values

ROLES = ("your model", "with the effects found", "fitted")
"""Names of three models in the tables and legends of a page or view."""

_CLOCKS = (631_152_000.0, 4_102_444_800.0)  # s since 1970: the years 1990 to 2100, in which recordings were made


@dataclass(frozen=True, eq=False)
class Shown:
    """Recordings with one to three models, the earliest first: errors as ``compare`` gives them, and the curves."""

    recordings: Sequence[Recording]
    comparisons: tuple[Comparison, ...]
    curves: tuple[list[Beside], ...]

    @property
    def signals(self) -> list[str]:
        """The signals whose errors are meaningful."""
        first = self.comparisons[0]
        return [name for name in shown_signals(first.input, first.overall) if name in self.comparisons[-1].overall]

    def words(self, name: str) -> str:
        """``motor torque``, of a carriage ``motor force``: a signal as people call it."""
        overall = self.comparisons[0].overall
        return signal_words(name, overall[name]["unit"] if name in overall else "")

    @property
    def headlines(self) -> list[str]:
        """The signals by which models are judged, the output's position first."""
        headlines = (*explained_signals(self.comparisons[0].input), "motor_torque")
        telling = [name for name in self.signals if name in headlines]
        return sorted(telling or self.signals[:1], key=lambda name: name != "output_position")

    @property
    def input_of_all(self) -> str | None:
        """The input that drove every twin; None if it differs between recordings."""
        chosen = self.comparisons[0].input
        return chosen if chosen in DRIVING else None

    @property
    def telling(self) -> int:
        """Index of the recording with the largest error of the earlier model."""
        if not self.headlines:
            return 0
        name = self.headlines[-1]
        errors = [
            recording.signals[name]["rmse"] if name in recording.signals else 0.0
            for recording in self.comparisons[0].recordings
        ]
        return errors.index(max(errors))


def shown(
    recordings: Sequence[Recording],
    models: Sequence[Model],
    source: str | None = None,
    *,
    step: float | None = None,
    comparisons: Sequence[Comparison] = (),
) -> Shown:
    """Compare models with the recordings, unless that was done (``comparisons``); ``step`` [s] is the integration step.

    Raises InputError if a recording lacks the input's signal.
    """
    compared = comparisons or compare_all(recordings, models, source, step=step)
    return Shown(recordings, tuple(compared), tuple(beside(recordings, model, source, step=step) for model in models))


@dataclass(frozen=True, eq=False)
class Content:
    """Everything that a report shows; ``names`` are the models' names, made distinct.

    The models are those before and after the search, and perhaps a third: the second with its numbers fitted.
    """

    models: tuple[Model, ...]
    names: tuple[str, ...]
    given: Shown
    held_out: Shown | None
    findings: Findings | None
    version: str
    story: str = ""  # printed below the verdict
    undiagnosed: str = ""  # why there are no findings
    fit: FitFindings | None = None
    note: str = ""  # printed below the table of errors

    @property
    def before_and_after(self) -> tuple[Model, Model]:
        """The first two models, which the verdict is about."""
        return self.models[0], self.models[1]

    @property
    def new(self) -> list[NewEffect]:
        """The effects that only the later model has."""
        return new_effects(*self.before_and_after, self.findings)

    @property
    def gone(self) -> list[NewEffect]:
        """The effects that only the earlier model has."""
        return new_effects(self.models[1], self.models[0])

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the models in tables and legends."""
        return self.names if len(self.models) == 2 else ROLES

    @property
    def fitted_numbers(self) -> list[TwoValues]:
        """What fitting changed; empty if there is no third model."""
        if len(self.models) == 2:
            return []
        return two_values(self.models[1], self.models[2], self.findings, self.fit)


def dates(recordings: Sequence[Recording]) -> str:
    """When recordings were made: ``2026-03-14 09:21 UTC to …``; without ``UTC`` by the clock of a text trace."""
    known = sorted(date for date in map(_date, recordings) if date is not None)
    if not known:
        return "no date in the files"
    missing = len(recordings) - len(known)
    ends = dict.fromkeys(text for _, text in (known[0], known[-1]))
    return " to ".join(ends) + (f" ({missing} without a date)" if missing else "")


def _date(recording: Recording) -> tuple[float, str] | None:
    """The time of the first sample [s since 1970], and in words; None if it is not known.

    The clock of a text trace has no time zone, and counts from any time: it tells a date if it counts from 1970.
    """
    seconds, zone = recording.start * 1e-9, " UTC"
    if recording.start == NO_DATE:
        text = json.loads(recording.metadata.get("text", "{}"))
        seconds = text.get("time_origin", 0.0) * TIME_UNITS[text.get("time_unit", "s")] * 1e-9
        if not _CLOCKS[0] <= seconds < _CLOCKS[1]:
            return None
        zone = ""
    return seconds, f"{datetime.fromtimestamp(seconds, timezone.utc):%Y-%m-%d %H:%M}{zone}"


def signals_listed(given: Shown, names: Sequence[str]) -> str:
    """``the output position and the current``."""
    return listed(f"the {given.words(name)}" for name in names)
