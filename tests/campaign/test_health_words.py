"""What `units` says of a unit's health: how its fault is named over its tests, and what could not be judged."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.campaign.health_rows import health_row, run_of
from ema_twin_sim.campaign.healthy import Healthy
from ema_twin_sim.campaign.results import DONE
from ema_twin_sim.campaign.unit_health import JudgedTest, unit_health
from ema_twin_sim.campaign.units import units_of
from ema_twin_sim.health import Family
from ema_twin_sim.health.acquisition import Acquisition, Extent
from ema_twin_sim.words.unit_health import test_cells as cells_of
from ema_twin_sim.words.units import unit_words
from tests.health_by_hand import run_by_hand
from tests.stored_rows import complete

WELL = 12
FRICTION = {"friction": 20.0, "slow_roughness": 20.0}
PLAY = {"lost_motion": 30.0, "fast_roughness": 8.0}
UNKNOWN = {"lost_motion": -30.0}


def judged(*others, duration=20.0):
    """The unit and its health after a dozen healthy days and ``others``, of which the last lasts ``duration`` [s]."""
    rng = np.random.default_rng(1)
    runs = [run_by_hand(f"day {k:02}", rng, **off) for k, off in enumerate([{}] * WELL + [*others])]
    durations = [20.0] * (len(runs) - 1) + [duration]
    rows = [
        {"unit": "A", "name": run.name, "key": run.name, "status": DONE, "task": "health", "duration": lasts,
         "health": health_row(run)}
        for run, lasts in zip(runs, durations, strict=True)
    ]  # fmt: skip
    (unit,) = units_of(complete(rows))
    return unit, unit_health(unit, Healthy(WELL))


@pytest.mark.parametrize(
    ("others", "differently"),
    [
        ([FRICTION, PLAY, FRICTION, UNKNOWN], True),
        ([FRICTION, FRICTION, FRICTION, UNKNOWN], False),
        ([PLAY, PLAY], False),
        ([{}], False),
    ],
)
def test_a_fault_that_is_named_differently_from_test_to_test_is_told(others, differently):
    unit, health = judged(*others)
    assert ("named differently from test to test" in " ".join(unit_words(unit, [], health))) is differently


def test_what_no_family_explains_is_told_with_its_feature():
    _, health = judged(UNKNOWN)
    cells = cells_of(health.tests[0])
    assert cells[3] == "unknown" and health.tests[0].named is None
    assert "It differs from the healthy recordings, clearly" in cells[4]
    assert "none of the families of damage explains: lost motion between the encoders by -" in cells[4]
    assert health.tests[0].as_json()["family"] is None


def test_a_test_that_is_unknown_says_why_even_if_its_farthest_recording_has_a_family():
    _, health = judged(PLAY, UNKNOWN)
    runs = health.tests[0].runs + health.tests[1].runs * 3
    mixed = JudgedTest("mixed", (replace(runs[0], distance=99.0), *runs[1:]))
    assert mixed.named is None and mixed.worst.family is Family.PLAY
    told = cells_of(mixed)
    assert told[3] == "unknown" and told[4].endswith("Check what was changed on the unit and in its test.")


def test_a_recording_that_was_cut_names_no_family_and_is_counted():
    unit, health = judged({}, PLAY, duration=12.0)
    cut = health.tests[1]
    assert cut.judged == 0 and cut.as_json()["family"] is None and cut.as_json()["runs"][0]["detected"] is None
    assert "0 of 2 tests deviate from its healthy ones; 1 could not be judged." in " ".join(
        unit_words(unit, [], health)
    )
    assert "The duration is 12 s and that of the healthy recordings 20 s" in cells_of(cut)[4]


def test_the_number_of_strokes_is_kept_with_the_features():
    run = run_by_hand(
        "a run", np.random.default_rng(2), acquisition=Acquisition(True, True, False, (), Extent(20.0, 8))
    )
    kept = run_of("a run", health_row(run), 20.0)
    assert kept.acquisition.extent == Extent(20.0, 8)
    assert kept.features.values == run.features.values
