"""A small fleet that runs to failure; `make wear` measures a large one."""

import numpy as np
import pytest

from tests.run_to_failure import simulated
from tests.run_to_failure.fleet import LIMITS, drawn_unit
from tests.run_to_failure.judged import ASKED_AT, judge_unit
from tests.run_to_failure.run import figures


@pytest.fixture(scope="module")
def told():
    return [judge_unit(drawn_unit(21, number)) for number in range(20)]


@pytest.mark.slow
def test_wear_is_named_early_and_no_healthy_unit_is_called_off(told):
    worn = [one for one in told if one.wears]
    assert np.mean([one.lost_when_named <= 0.2 for one in worn]) >= 0.9
    assert np.mean([one.first_named == one.wears for one in worn]) >= 0.9
    assert sum(one.false_alarm for one in told) <= 1
    assert sum(one.recordings for one in told) > 4000


@pytest.mark.slow
def test_intervals_hold_the_remaining_life_of_units_that_wear_by_many_laws(told):
    held = [answer for one in told for answer in one.held]
    assert len(held) >= 0.9 * len(ASKED_AT) * sum(one.wears is not None for one in told)
    assert held.count(None) <= 3
    assert 0.75 <= np.mean([answer for answer in held if answer is not None]) <= 1.0


@pytest.mark.slow
def test_the_figures_tell_all_of_it(told):
    text = figures(told)
    for part in ("20 units, 16 of which wear", "false alarms", "hold it", "named before 20 %"):
        assert part in text


def test_a_unit_that_has_failed_records_no_more():
    unit = drawn_unit(3, 0)
    assert unit.wears == next(iter(LIMITS)) and np.isfinite(unit.life)
    last = (unit.rows[-1]["time"] - unit.rows[0]["time"]).days
    assert unit.life - 14 <= last <= unit.life + 60
    assert len(unit.until(unit.onset).rows) < len(unit.rows)


@pytest.mark.slow
def test_simulated_units_are_judged_by_health_and_by_numbers(tmp_path, monkeypatch):
    """A short life of two units, from their recordings to the table of `make wear ARGS="--simulated 2"`."""
    for name, value in (("HEALTHY_TESTS", 4), ("TESTS", 8), ("REPEATS", 2), ("SECONDS", 4.0), ("LOST_AT_LAST", 0.3)):
        monkeypatch.setattr(simulated, name, value)
    monkeypatch.setattr(simulated, "WEARS", {kind: simulated.WEARS[kind] for kind in ("play", "nothing")})
    simulated.simulate_units(tmp_path, 2, 5)
    worn, well = simulated.judge_units(tmp_path, 1)
    assert (worn.name, well.name) == ("EMA-00 play", "EMA-01 nothing")
    assert worn.early and worn.changed == "backlash.width" and "backlash" in worn.missing
    assert well.lost_when_off == well.lost_when_changed == np.inf and well.missing == ()
    told = simulated.table([worn, well])
    assert "told before 20 % of the margin was lost: 1 of 1 units" in told
    assert "what wears is among what the model lacks: 1 of 1" in told


def test_wear_starts_after_the_healthy_tests():
    shares = [simulated.lost(test) for test in range(simulated.TESTS)]
    assert shares[: simulated.HEALTHY_TESTS + 2] == [0.0] * (simulated.HEALTHY_TESTS + 2)
    assert shares[-1] == simulated.LOST_AT_LAST and sorted(shares) == shares
