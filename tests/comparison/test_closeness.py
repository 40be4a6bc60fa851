"""How many times closer one model is than another, above the sensors' noise."""

import numpy as np
import pytest

from ema_twin_sim.commands.side_by_side import closeness_cell
from ema_twin_sim.comparison.closeness import AT_LEAST, AT_MOST, EXACTLY, Closeness, times_closer
from ema_twin_sim.comparison.independent_rows import independent_rows
from ema_twin_sim.words.sentences import by_number

FLOOR = 3e-3
SAMPLES = 10_000


def error(excess, floor=FLOOR):
    return {"rmse": float(np.hypot(excess, floor)), "relative": 0.0, "noise_floor": floor, "unit": "A", "driven": False}


def test_the_ratio_is_that_of_the_excesses():
    found = times_closer(error(0.02), error(0.002), SAMPLES)
    assert found.bound == EXACTLY and found.times == pytest.approx(10.0)


def test_what_is_lost_in_the_noise_gives_a_bound():
    random = np.random.default_rng(0)
    noise = {**error(0.0), "rmse": float(np.sqrt(np.mean(random.normal(0.0, FLOOR, SAMPLES) ** 2)))}
    better, worse = times_closer(error(0.02), noise, SAMPLES), times_closer(noise, error(0.02), SAMPLES)
    assert better.bound == AT_LEAST and 20.0 < better.times < 60.0
    assert worse.bound == AT_MOST and worse.times == pytest.approx(1.0 / better.times)
    assert times_closer(noise, noise, SAMPLES) is None
    few = times_closer(error(0.02), noise, 100)
    assert few.times < better.times  # the fewer the samples, the less they tell


def test_without_a_known_noise_it_is_the_ratio_of_the_errors():
    assert times_closer(error(0.3, 0.0), error(0.1, 0.0), SAMPLES).times == pytest.approx(3.0)
    assert times_closer(error(0.3, 0.0), error(0.0, 0.0), SAMPLES) is None


def test_cells():
    cells = [Closeness(14.62), Closeness(250.4), Closeness(0.9), Closeness(22.0, AT_LEAST), Closeness(0.31, AT_MOST)]
    assert list(map(closeness_cell, cells)) == ["14.6 ×", "250 ×", "0.90 ×", "≥ 22.0 ×", "≤ 0.31 ×"]
    assert closeness_cell(None) == "–"
    far = [Closeness(8570.0), Closeness(20953.0, AT_LEAST), Closeness(1e-5)]
    assert list(map(closeness_cell, far)) == ["over 1000 ×", "over 1000 ×", "under 0.001 ×"]


def test_names_are_sorted_as_people_count():
    names = ["ramp_0.1", "ramp_0.09", "ramp_10", "ramp_2", "ramp_0.01", "sine", "10", "9"]
    assert sorted(names, key=by_number) == [
        "9",
        "10",
        "ramp_0.01",
        "ramp_0.09",
        "ramp_0.1",
        "ramp_2",
        "ramp_10",
        "sine",
    ]


def test_neighbours_that_are_alike_are_worth_less():
    """A residual of which 25 neighbours move together scatters as a 25th or so of its samples would."""
    random = np.random.default_rng(1)
    white = random.normal(0.0, FLOOR, SAMPLES)
    assert independent_rows(white) > 0.6 * SAMPLES
    alike = np.repeat(random.normal(0.0, FLOOR, SAMPLES // 25), 25)
    assert SAMPLES / 50 < independent_rows(alike) < SAMPLES / 12
    for constant in (0.0, 0.1, 0.3333, -2.0, 1e-5):  # some of whose squares' means are rounded
        assert independent_rows(np.full(SAMPLES, constant)) == SAMPLES
    assert independent_rows(white[:1]) == 1


def test_an_excess_within_the_scatter_of_correlated_noise_is_none():
    """Of 400 draws of noise that is no model's error, hardly one is called nearer than another."""
    random = np.random.default_rng(2)
    called = {"as white": 0, "as it is": 0}
    for _ in range(400):
        rows = np.repeat(random.normal(0.0, FLOOR, SAMPLES // 25), 25)
        noise = {**error(0.0), "rmse": float(np.sqrt(np.mean(rows**2)))}
        called["as white"] += times_closer(noise, error(0.0), SAMPLES) is not None
        called["as it is"] += times_closer(noise, error(0.0), independent_rows(rows)) is not None
    assert called["as white"] > 80
    assert called["as it is"] < 24
