"""What `units` says of a unit's health: how its fault is named over its tests, and what could not be judged."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.campaign.health_rows import health_row, run_of
from ema_twin_sim.campaign.healthy import Healthy
from ema_twin_sim.campaign.results import DONE
from ema_twin_sim.campaign.unit_health import JudgedTest, sickest_first, unit_health
from ema_twin_sim.campaign.units import units_of
from ema_twin_sim.health import Family
from ema_twin_sim.health.acquisition import Acquisition, Extent
from ema_twin_sim.report.fleet import write_fleet
from ema_twin_sim.words.unit_health import health_words, naming_words
from ema_twin_sim.words.unit_health import test_cells as cells_of
from ema_twin_sim.words.unit_results import result_columns
from ema_twin_sim.words.units import fleet_words, unit_words
from tests.health_by_hand import run_by_hand
from tests.stored_rows import complete

WELL = 12
FRICTION = {"friction": 20.0, "slow_roughness": 20.0}
PLAY = {"lost_motion": 30.0, "fast_roughness": 8.0}
UNKNOWN = {"lost_motion": -30.0}


def judged(*others, duration=20.0, unit="A", cut=1):
    """The unit and its health after a dozen healthy days and ``others``, of which the last (``cut``) last so long."""
    rng = np.random.default_rng(1)
    runs = [run_by_hand(f"day {k:02}", rng, **off) for k, off in enumerate([{}] * WELL + [*others])]
    durations = [20.0] * (len(runs) - cut) + [duration] * cut
    rows = [
        {"unit": unit, "name": run.name, "key": run.name, "status": DONE, "task": "health", "duration": lasts,
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
    assert cells[4].startswith("Lost motion between the encoders is ") and naming_words(health) == ""
    assert "none of the families of damage explains: lost motion between the encoders by -" in cells[4]
    assert health.tests[0].as_json()["family"] is None


def test_a_test_that_is_unknown_says_why_even_if_its_farthest_recording_has_a_family():
    _, health = judged(PLAY, UNKNOWN)
    runs = health.tests[0].runs + health.tests[1].runs * 3
    mixed = JudgedTest("mixed", (replace(runs[0], distance=99.0), *runs[1:]), (0,) * len(runs))
    assert mixed.named is None and mixed.worst.family is Family.PLAY
    told = cells_of(mixed)
    assert told[3] == "unknown" and told[4].endswith("Check what was changed on the unit and in its test.")


def test_a_name_and_its_reason_are_of_the_motions_that_deviate():
    """One recording of another motion that is off by chance has no say in either."""
    _, health = judged(PLAY, UNKNOWN, {})
    play, unknown, healthy = (test.runs[0] for test in health.tests)
    mixed = JudgedTest("mixed", (play, unknown, unknown, unknown, healthy, healthy, healthy), (0, 1, 1, 1, 1, 1, 1))
    assert mixed.deviates and mixed.named is not None and mixed.named.family is Family.PLAY
    assert mixed.why.startswith("This is play")


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


def test_a_unit_whose_last_tests_could_not_be_judged_is_not_said_to_be_like_its_healthy_ones():
    _, health = judged({}, {}, {}, {}, {}, duration=12.0, cut=3)
    reason = "the duration is 12 s and that of the healthy recordings 20 s"
    assert health_words(health) == (
        f"its last 3 tests could not be judged ({reason}); before, like its healthy tests (2 others)"
    )
    assert health.as_json()["not_judged_since"] == health.tests[2].name
    _, never = judged({}, {}, duration=12.0, cut=2)
    assert health_words(never) == f"none of its 2 tests could be judged ({reason})"
    _, worn = judged({}, PLAY, {}, duration=12.0)
    assert "1 of 3 tests deviate, since day 13" in health_words(worn)
    assert health_words(worn).endswith(f"; its last test could not be judged ({reason})")


def test_the_page_of_a_unit_that_was_not_judged_lately_advises_what_to_do(tmp_path):
    unit, health = judged({}, {}, duration=12.0)
    write_fleet(tmp_path, [unit], {"A": []}, {"A": health})
    page = (tmp_path / "units" / "A.html").read_text()
    assert "How it is now is not known. The duration is 12" in page and "Nothing to do" not in page


def test_a_test_in_between_that_could_not_be_judged_is_counted():
    unit, _ = judged({}, {}, {})
    runs = [{**row, "duration": 12.0} if row["name"] == "day 13" else row for row in unit.rows]
    (unit,) = units_of(runs)
    assert health_words(unit_health(unit, Healthy(WELL))) == (
        "like its healthy tests (2 others; 1 could not be judged)"
    )


def test_units_that_could_not_be_judged_lately_come_right_after_those_that_deviate():
    of = {
        "gone": judged({}, PLAY, {}, unit="gone"),
        "cut": judged({}, {}, duration=12.0, unit="cut"),
        "well": judged({}, {}, unit="well"),
        "worn": judged({}, PLAY, unit="worn"),
    }
    units, health = [unit for unit, _ in of.values()], {name: its for name, (_, its) in of.items()}
    assert [unit.name for unit in sickest_first(units, health)] == ["worn", "cut", "gone", "well"]
    assert "1 whose last test could not be judged" in fleet_words(units, {name: [] for name in of}, health)


def test_each_recording_is_told_with_what_was_judged():
    unit, health = judged({}, PLAY, {}, duration=12.0)
    columns = result_columns(unit, health)
    assert [*columns] == [
        "recording", "task", "verdict", "distance / limit", "largest change (standard deviations)", "reason",
    ]  # fmt: skip
    *reference, well, worn, cut = columns["verdict"]
    assert {*reference} == {"healthy reference"}
    assert (well, worn, cut) == ("like the healthy ones", "deviates", "not judged")
    assert [bool(cell) for cell in columns["distance / limit"]][-3:] == [True, True, False]
    assert columns["largest change (standard deviations)"][-2].startswith("lost motion +")
    assert columns["reason"][-1] == "the duration is 12 s and that of the healthy recordings 20 s"
    assert cells_of(health.tests[-1])[1] == "not judged"


def test_healthy_recordings_that_cannot_be_learnt_from_are_told_with_why():
    unit, _ = judged({}, {})
    first, *others = unit.rows
    clipped = {**first["health"], "effort_usable": False, "findings": ["The effort is clipped."]}
    (unit,) = units_of([{**first, "health": clipped}, *others])
    columns = result_columns(unit, unit_health(unit, Healthy(WELL)))
    assert (columns["verdict"][0], columns["reason"][0]) == ("not used as healthy", "The effort is clipped.")


def test_what_changed_is_told_in_short_and_the_last_fault_with_what_to_look_at():
    _, health = judged(PLAY, FRICTION)
    cell = cells_of(health.tests[1])[4]
    assert cell.count("standard deviations") == 1 and "It differs" not in cell and "This is" not in cell
    assert naming_words(health).startswith("Test day 13: This is friction up (probability ")
    assert "Look at lubricant, seals and bearings." in naming_words(health)
