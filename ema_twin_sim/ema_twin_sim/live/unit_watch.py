"""Judge the running unit by its own healthy recordings: the health numbers of a campaign, live."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..campaign.healthy import Healthy
from ..campaign.histories import FEWEST_HEALTHY
from ..campaign.store import Store
from ..campaign.unit_health import Learnt, healthy_runs, learnt_from
from ..campaign.units import units_of
from ..criteria import NEARLY_ALL
from ..health.acquisition import Extent
from ..health.judgement import HealthJudgement
from ..health.motion_record import MotionRecord
from ..health.naming import in_words
from ..quantities import quantity

_NOW = "the running test"


class UnitWatch:
    """Judges runs of a unit as `units` does, by the baseline of a campaign's results.

    Attributes:
        unit: its name.
        last: the judgement of the last run; None before one, or if the last run could not be judged.
        refused: why it could not be judged; empty if it could.
    """

    def __init__(self, unit: str, learnt: Learnt) -> None:
        """Judge a unit by what was learnt from its healthy recordings. Raises InputError if that is nothing."""
        if not learnt.kinds:
            raise InputError(f"{unit}: {learnt.remarks[0]}")
        self.unit = unit
        self.last: HealthJudgement | None = None
        self.refused = ""
        self._cut = ""  # what is said of a run whose beginning is not held
        self._learnt = learnt

    @classmethod
    def opened(cls, results: Path, unit: str, healthy: str | None) -> UnitWatch:
        """Use a campaign's results; `unit` may be empty if they hold one. Raises InputError if they do not suffice."""
        found = units_of(Store.opened(results).rows())
        named = [one for one in found if one.name == unit or (not unit and len(found) == 1)]
        if not named:
            names = ", ".join(one.name for one in found) or "none is there"
            raise InputError(f"{results}: holds no unit {unit!r}; give the unit: one of {names}")
        runs, flags = healthy_runs(named[0], Healthy.of(healthy or None, FEWEST_HEALTHY))
        if not runs:
            raise InputError(f"{results}: holds no health of {named[0].name}; run ema-twin campaign --do health")
        return cls(named[0].name, learnt_from([run for run, flag in zip(runs, flags, strict=True) if flag]))

    def judge(self, read: Callable[[], Recording], asked: float = 0.0) -> None:
        """Judge the run, or part of one, that `read` returns; if it cannot be judged, `refused` says why.

        `asked` is how long it should be [s]; of one that is shorter, the words say so.
        """
        self.last, self._cut = None, ""
        try:
            recording = read()
            if recording.duration < NEARLY_ALL * asked:
                self._cut = (
                    f"; only its last {recording.duration:.0f} of {asked:.0f} s are held and judged: give the monitor "
                    f"a history of {1.1 * len(recording) * asked / recording.duration:.0f} samples"
                )
            record = MotionRecord.from_recording(recording, _NOW)
            run = self._learnt.features(record)
            # Of a run that goes on, the monitor reads a part: its length is no sign of a fault.
            acquisition = replace(run.acquisition, extent=Extent())
            self.last = self._learnt.judge(replace(run, acquisition=acquisition))
            self.refused = ""
        except InputError as error:
            self.refused = str(error)
        except Exception as error:  # our own fault: traceback to standard error, one line in `refused`
            traceback.print_exc()
            self.refused = f"internal error (traceback on the monitor's standard error): {error!r}"

    @property
    def off(self) -> bool:
        """Whether the last run differs from the healthy ones."""
        return self.last is not None and bool(self.last.detected)

    @property
    def words(self) -> str:
        """The judgement of the last run in words, or why there is none."""
        if self.refused:
            return self.refused
        if self.last is None:
            return "no run judged yet; a run is judged at its end"
        return " ".join(self.last.words) + self._cut

    @property
    def figures(self) -> Mapping[str, object]:
        """The health numbers of the last run, each with its healthy value."""
        last = self.last
        if last is None:
            return {}
        changes = {
            change.name.replace("_", " "): (
                f"{quantity(change.value, change.unit)}, healthy {quantity(change.healthy, change.unit)} "
                f"({change.standard_deviations:+.1f} standard deviations)"
            )
            for change in in_words(last.changes)
        }
        return {
            "judged": last.name,
            "distance, in times of the limit's": None if last.detected is None else f"{last.distance:.2f}",
            "family": None if last.family is None else last.family.value,
            **changes,
        }
