"""Dates of recordings: those without a time of day, and those that only their names hold."""

from datetime import datetime, timezone

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.campaign.dates import when_words
from ema_twin_sim.campaign.health_rows import health_row
from ema_twin_sim.campaign.healthy import Healthy
from ema_twin_sim.campaign.healthy_chosen import check_choice
from ema_twin_sim.campaign.histories import histories
from ema_twin_sim.campaign.results import DONE
from ema_twin_sim.campaign.unit_health import unit_health
from ema_twin_sim.campaign.units import units_of
from tests.health_by_hand import run_by_hand
from tests.stored_rows import complete

DAYS = [datetime(2026, 1, day, tzinfo=timezone.utc) for day in range(5, 17)]
ALONE = "so each counts as a test of its own"


def a_row(name, at, **held):
    return {"unit": "A", "name": name, "key": name, "status": DONE, "task": "health", "time": at, "duration": 12.0,
            "content": [name], **held}  # fmt: skip


def a_unit(name_of, days=DAYS, times=(None,) * 3):
    """A unit with three recordings on each of a dozen days, whose names alone may hold the date."""
    rng = np.random.default_rng(1)
    runs = [(run_by_hand(name_of(day, k), rng), at) for day in days for k, at in enumerate(times)]
    (unit,) = units_of(complete([a_row(run.name, at, health=health_row(run)) for run, at in runs]))
    return unit


def test_repeats_of_a_date_that_only_their_names_hold_are_one_test():
    for name_of in (
        lambda day, k: f"A/A_{day:%Y-%m-%d}_{k}.csv",
        lambda day, k: f"A/{day:%Y%m%d}/run{k}.csv",
        lambda day, k: f"A/lot_20251399/{day:%Y_%m_%d} {k}.csv",
    ):
        unit = a_unit(name_of)
        health = unit_health(unit, Healthy(21))
        assert (health.baselines[0].tests, health.baselines[0].runs) == (7, 21)
        assert [test.name for test in health.tests] == [f"{day:%Y-%m-%d}" for day in DAYS[7:]]
        assert not any(ALONE in remark for remark in health.remarks) and unit.last == DAYS[-1]


def test_recordings_that_tell_neither_date_nor_test_are_warned_of():
    health = unit_health(a_unit(lambda day, k: f"A/serial {day:%d}{k}.csv"), Healthy(21))
    assert health.baselines[0].tests == 21 and any(ALONE in remark for remark in health.remarks)


@pytest.mark.parametrize(
    ("name_of", "healthy", "told"),
    [
        (lambda day, k: f"A/serial {day:%d}{k}.csv", Healthy(), True),
        (lambda day, k: f"A/serial {day:%d}{k}.csv", Healthy(21), False),
        (lambda day, k: f"A/A_{day:%Y-%m-%d}_{k}.csv", Healthy(), False),
    ],
)
def test_a_reference_that_names_alone_put_first_is_warned_of(name_of, healthy, told):
    health = unit_health(a_unit(name_of), healthy)
    assert any("by name counts as healthy" in remark for remark in health.remarks) == told


def test_a_test_is_healthy_as_a_whole():
    unit = a_unit(lambda day, k: f"{day:%Y-%m-%d}_{k}.csv")
    health = unit_health(unit, Healthy(20))
    assert health.baselines[0].runs == 21 and [len(test.runs) for test in health.tests] == [3] * 5
    with pytest.raises(InputError, match="has 36 results; give 4 to 33"):
        check_choice([unit], Healthy(34), "34", 4)


def test_dates_without_a_time_of_day_contradict_no_clock():
    rows = [a_row(f"{day:%d} run {k}", day) for day in DAYS for k in range(3)]
    assert units_of(complete(rows))[0].remarks == ()
    noon = DAYS[0].replace(hour=12)
    late = [a_row("a", noon), a_row("b", noon.replace(second=5))]
    assert units_of(complete(late))[0].remarks == ("b begins before a ends: one of their clocks is wrong",)
    assert (when_words(DAYS[0]), when_words(noon)) == ("2026-01-05", "2026-01-05 12:00")


def test_parameters_of_dates_without_a_time_of_day_are_followed_over_days():
    def fitted(day, k):
        width = {"owner": "backlash", "name": "width", "value": 1e-3 + 1e-6 * k, "std": 1e-5, "unit": "rad"}
        return a_row(f"{day:%d} {k}", day, task="fit", parameters=[width])

    (unit,) = units_of(complete([fitted(day, k) for day in DAYS for k in range(3)]))
    (history,) = histories(unit)
    assert history.dated and history.times.tolist() == list(range(12))
