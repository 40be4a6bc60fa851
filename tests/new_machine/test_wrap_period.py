"""`init` on positions that start again after another period than one turn, as drives send them in few bits."""

import numpy as np
import pytest

from ema_twin_sim.new_machine.wrap_period import wrap_period

TIME = np.arange(4000) * 5e-3
SPEED = 30.0 * np.sin(1.1 * TIME) + 8.0 * np.sin(3.2 * TIME)
WAY = np.cumsum(SPEED) * 5e-3  # rad, over more than 50
TORQUE = 0.01 * np.gradient(SPEED, TIME) + 0.02 * SPEED + 0.3 * np.sign(SPEED)
TURN = 2.0 * np.pi


def wrapped(way, period):
    return np.mod(way + 0.5 * period, period) - 0.5 * period


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("period", [25.0, 4.0 * TURN, 2.0 * TURN, 23.456])
def test_a_period_is_seen_in_any_unit(size, period):
    found = wrap_period(size * wrapped(WAY, period), size * TURN)
    assert found == pytest.approx(size * period, rel=1e-3 if period == 23.456 else 1e-12)


def test_a_few_lost_samples_and_missing_values_do_not_matter():
    shown = wrapped(WAY, 25.0)
    shown[::97] = np.nan
    kept = np.ones(len(shown), bool)
    kept[np.random.default_rng(3).integers(0, len(shown), 100)] = False
    assert wrap_period(shown[kept]) == 25.0


SWING = 10.0 * np.sin(2.0 * TIME)
SAW = np.mod(np.cumsum(1.0 + 0.5 * np.sin(0.7 * TIME)) * 0.01, np.where(np.sin(0.3 * TIME) > 0.0, 9.0, 6.0))
RESETS = np.concatenate([np.linspace(0.0, height, 300) for height in (9.0, 5.0, 11.0, 7.0)])
RUNS = np.concatenate([12.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 400)))] * 5)


NO_STARTS = {
    "swing": SWING,
    "cut off": np.clip(3.0 * SWING, -12.5, 12.5),
    "steps": 12.5 * np.sign(np.sin(2.0 * TIME + 0.1)),
    "noisy steps": 12.5 * np.sign(SWING + 1e-9) + 0.01 * np.random.default_rng(4).standard_normal(len(TIME)),
    "saw": SAW,
    "set back": RESETS,
    "runs": RUNS,
    "spikes": np.where(np.arange(len(TIME)) % 500 == 250, 300.0, SWING),
    "noise": np.random.default_rng(5).uniform(-12.5, 12.5, 4000),
    "moved": np.where(TIME < 10.0, SWING, SWING + 40.0),
    "constant": np.zeros(50),
    "missing": np.full(50, np.nan),
    "empty": np.zeros(0),
}


@pytest.mark.parametrize("kind", NO_STARTS)
def test_what_is_no_new_start_is_left_as_it_is(kind):
    """Steps, resets at any height, runs one after the other, wrong samples, and a signal that is cut off."""
    assert wrap_period(NO_STARTS[kind]) is None


@pytest.fixture
def positioned(drafted, read):
    """The line of the map of a position (n,), what is said, and the position as it is read."""

    def of(name, values, **more):
        draft = drafted({"time [s]": TIME, name: values, **more, "motor torque [Nm]": TORQUE})
        return draft.line("motor_position"), draft.said, read().signals["motor_position"]

    return of


@pytest.mark.parametrize(
    ("name", "values", "period"),
    [
        ("position [rad]", wrapped(WAY, 25.0), "{value: 25, unit: rad}"),
        ("position [rad]", wrapped(WAY, 4.0 * TURN), "{value: 25.13274123, unit: rad}"),
        ("position [deg]", wrapped(np.rad2deg(WAY), 1440.0), "{value: 1440, unit: deg}"),
    ],
)
def test_init_writes_the_period_into_the_map_and_says_so(positioned, name, values, period):
    """The jumps were taken for motion, or the position dropped."""
    line, told, read = positioned(name, values)
    assert f"wraps_after: {period}" in line and "# CHECK: its jumps are those of a position that starts again" in line
    assert f"Assumed: {name}: starts again after" in told
    assert read == pytest.approx(WAY - WAY[0], abs=1e-3)


def test_beside_a_speed_the_position_is_kept(positioned):
    """It was not used, since in many rows it jumped farther than the speed goes."""
    line, told, read = positioned("position [rad]", wrapped(WAY, 25.0), **{"speed [rad/s]": SPEED})
    assert "wraps_after: {value: 25, unit: rad}" in line and "not used" not in told
    assert read == pytest.approx(WAY - WAY[0], abs=1e-3)


def test_without_a_unit_the_speed_tells_it(positioned):
    values = wrapped(np.rad2deg(WAY), 1440.0)
    line, _, read = positioned("position", values, **{"speed [rad/s]": SPEED})
    assert "unit: deg, wraps_after: {value: 1440, unit: deg}" in line
    assert read == pytest.approx(WAY - WAY[0], abs=1e-3)


def test_one_turn_needs_no_key(positioned):
    line, told, read = positioned("position [rad]", wrapped(WAY, TURN))
    assert "wraps_after" not in line + told and read == pytest.approx(WAY - WAY[0], abs=1e-3)
