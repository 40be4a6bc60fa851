"""A feature over a unit's life: changes, drift and remaining life hold what they state, over drawn histories."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.health.change_point import alarm_limit, change_point
from ema_twin_sim.health.drift import drift
from ema_twin_sim.health.remaining_life import margin, remaining_life

HEALTHY, LIMIT = 5.0, 8.0


@pytest.mark.slow
def test_at_most_one_false_alarm_in_a_thousand_recordings():
    rng = np.random.default_rng(1)
    alarms = values = 0
    for _ in range(150):
        history = rng.normal(size=200)
        found = change_point(history, np.ones(200), 20)
        alarms += found is not None
        values += 180 if found is None else found.alarm - 19
    assert alarms / values <= 1e-3


@pytest.mark.slow
def test_errors_that_are_too_small_raise_no_alarms():
    """Scatter between days that the standard errors do not hold: the baseline shows it."""
    rng = np.random.default_rng(2)
    alarms = sum(change_point(rng.normal(size=120), np.full(120, 0.3), 20) is not None for _ in range(100))
    assert alarms <= 12


def test_the_limit_is_the_one_of_its_rate():
    assert alarm_limit(1e-4) > alarm_limit(1e-3)
    assert alarm_limit(1e-3) == pytest.approx(3.9, abs=0.3)  # Siegmund and Venkatraman's tables: two-sided, 1000 values


def test_a_step_is_found_where_it_is():
    rng = np.random.default_rng(3)
    inside = 0
    for _ in range(100):
        history = 2.0 + 0.1 * rng.normal(size=80)
        history[50:] += 0.3
        found = change_point(history, np.full(80, 0.1), 20)
        if found and found.begin > 40:
            inside += found.earliest <= 50 <= found.latest
            assert found.size > 0.0 and found.distance > found.limit
    assert inside >= 85


def worn(rng, life, noise, onset, count=100):
    """A history of wear from an onset on that reaches the limit at `life`, both in its 100 times."""
    times = np.arange(count, dtype=float)
    truth = HEALTHY + (LIMIT - HEALTHY) * np.maximum(0.0, times - onset) / (life - onset)
    return times, truth + noise * rng.normal(size=count), np.full(count, noise)


def test_wear_is_named_before_a_fifth_of_the_margin_is_lost():
    rng = np.random.default_rng(4)
    early = []
    for _ in range(100):
        onset = rng.uniform(25, 50)
        life = onset + rng.uniform(100, 200)
        noise = 0.05 * (LIMIT - HEALTHY)
        _, values, errors = worn(rng, life, noise, onset, 140)
        found = change_point(values, errors, 20)
        early.append(found is not None and (found.alarm - onset) / (life - onset) < 0.2 and found.size > 0.0)
    assert np.mean(early) >= 0.95


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["from the beginning", "from an onset"])
def test_intervals_of_remaining_life_hold_it(kind):
    """Wear in proportion to time is the likeliest of the laws that the interval allows for, so more than nine in ten
    hold it. Over fleets of many laws it is nine in ten (tests/run_to_failure).
    """
    rng = np.random.default_rng(5)
    held, told = [], 0
    for _ in range(100):
        onset = rng.uniform(20, 50) if kind == "from an onset" else 0.0
        life = rng.uniform(110, 180)
        times, values, errors = worn(rng, life, 0.05 * (LIMIT - HEALTHY), onset)
        found = remaining_life(drift(times, values, errors), LIMIT)
        told += found is not None
        if found is not None:
            held.append(found.earliest <= life - times[-1] <= found.latest)
            assert found.earliest <= found.median <= found.latest
    assert told >= 95
    assert 0.85 <= np.mean(held) <= 0.99


def test_no_trend_is_told_as_none():
    rng = np.random.default_rng(6)
    trends = 0
    for _ in range(100):
        steady = drift(np.arange(60.0), HEALTHY + 0.15 * rng.normal(size=60), np.full(60, 0.15))
        trends += remaining_life(steady, LIMIT) is not None
    assert trends <= 3
    left = margin(steady, HEALTHY, LIMIT)
    assert left.share == pytest.approx(1.0, abs=4.0 * left.standard_error)


def test_what_drifts_away_from_a_limit_never_reaches_it():
    times = np.arange(50.0)
    found = drift(times, HEALTHY - 0.05 * times, np.full(50, 0.1))
    assert found.slope == pytest.approx(-0.05, rel=0.05) and remaining_life(found, LIMIT) is None


def test_a_trend_too_slow_to_reach_the_limit_gives_no_life():
    """Its earliest time would be thousands of times the history away."""
    times = np.arange(50.0)
    found = drift(times, HEALTHY + 1e-3 * times, np.full(50, 1e-4))
    assert found.is_trend and remaining_life(found, HEALTHY + 1e4) is None


def test_what_has_passed_its_limit_has_no_life_left():
    times = np.arange(50.0)
    step = 1.1 * (LIMIT - HEALTHY) / times[-1]
    found = remaining_life(drift(times, HEALTHY + step * times, np.full(50, 0.01)), LIMIT, healthy=HEALTHY)
    assert (found.earliest, found.median, found.latest) == (0.0, 0.0, 0.0)
    beyond = np.full(50, HEALTHY + 1.1 * (LIMIT - HEALTHY)) + 0.01 * np.random.default_rng(3).normal(size=50)
    assert remaining_life(drift(times, beyond, np.full(50, 0.01)), LIMIT, healthy=HEALTHY).latest == 0.0


def test_a_margin_is_what_is_left_of_the_way():
    times = np.arange(50.0)
    left = margin(drift(times, HEALTHY + 1.5 * times / 49.0, np.full(50, 0.1)), HEALTHY, LIMIT)
    assert left.share == pytest.approx(0.5, abs=0.02) and 0.0 < left.standard_error < 0.05


def test_too_short_histories_are_refused():
    with pytest.raises(InputError, match="baseline of 3 values"):
        change_point(np.zeros(9), np.ones(9), 3)
    with pytest.raises(InputError, match="4 values"):
        drift(np.arange(4.0), np.zeros(4), np.ones(4))
