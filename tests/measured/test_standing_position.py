"""A position column that stands still beside a speed that moves: named for what it is, and not drafted by init."""

import math

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.measured.quieter_motion import as_measured
from ema_twin_sim.measured.way_by_speed import standing_position
from ema_twin_sim.model import load_model
from tests.command_line import done
from tests.recorded import sampled
from tests.trace_text import write_columns

TIME = np.arange(4000) * 2e-3
SPEED = 20.0 * np.sin(1.5 * TIME)


def run(position, speed=SPEED, noise=0.05):
    """A motor that swings, by a noisy speed, with a ``position`` (n,) of whatever it is."""
    rng = np.random.default_rng(4)
    current = 0.5 * np.sign(speed) + 0.02 * speed + 0.01 * rng.standard_normal(len(TIME))
    signals = {"current": current, "speed": speed + noise * rng.standard_normal(len(TIME)), "motor_position": position}
    return sampled("run", TIME, signals, motor_angle_origin=0.0, output_angle_origin=0.0)


STANDING = np.full(len(TIME), math.pi / 2.0)
FOLLOWING = 20.0 / 1.5 * (1.0 - np.cos(1.5 * TIME))


def test_it_is_told_with_what_to_do(stock):
    told = "run: motor_position stands still, while by the speed the motor moves by 26.7 rad; remove the line of"
    with pytest.raises(InputError, match=told):
        discover([run(STANDING)], stock)
    assert [warning for warning in compare([run(STANDING)], stock).warnings if warning.startswith(told)]


@pytest.mark.parametrize(
    ("position", "speed"),
    [(FOLLOWING, SPEED), (FOLLOWING / 1000.0, SPEED), (STANDING, 0.0 * SPEED), (FOLLOWING, 0.0 * SPEED)],
)
def test_what_follows_or_rests_is_none(position, speed):
    """In another unit, and where the speed shows its noise alone."""
    assert standing_position(run(position, speed)) is None


COARSE = np.round(FOLLOWING / 100.0 * 1024 / (2.0 * math.pi)) * 2.0 * math.pi / 1024
STEPS = 0.1 * (np.arange(len(TIME)) % 400 == 0)


@pytest.mark.parametrize(
    ("position", "speed", "noise"), [(COARSE, SPEED, 0.05), (STANDING, STEPS, 0.0), (STANDING, 0.01 + 0.0 * TIME, 1e-4)]
)
def test_a_coarse_output_or_a_speed_at_rest_is_none(position, speed, noise):
    """Behind a gear of 100:1 by 1024 counts; a speed that shows its last digit now and then, or an offset."""
    assert standing_position(run(position, speed, noise)) is None


def test_a_counter_that_trembles_by_a_count_stands_still():
    trembling = STANDING + 1e-3 * (np.arange(len(TIME)) % 7 == 0)
    assert standing_position(run(trembling)) == pytest.approx(80.0 / 3.0, rel=0.01)


def test_the_speed_is_not_left_out_for_it(stock):
    """However quiet it is: it shows no acceleration."""
    [taken] = as_measured([run(STANDING, noise=2.0)], stock)
    assert taken.has("speed")


def written(tmp_path, name, **columns):
    names = {"current [A]": "current", "speed [rad/s]": "speed", "motor angle [rad]": "motor_position"}
    signals = run(**columns).signals
    return write_columns(tmp_path / name, {"time [s]": TIME, **{head: signals[n] for head, n in names.items()}})


def test_init_leaves_it_out_and_says_so(tmp_path):
    written(tmp_path, "a.csv", position=STANDING)
    said = done("init", "a.csv", "-o", "a", "--torque-constant", "0.1", cwd=tmp_path).stdout
    assert "motor angle [rad]: not used: it stands still, while by the speed the motor moves by 26.7 rad" in said
    drawn = (tmp_path / "a_map.yaml").read_text()
    assert "motor_position" not in drawn and "# not used: motor angle [rad]" in drawn
    assert "encoder_counts" not in (tmp_path / "a.yaml").read_text()
    assert load_model(tmp_path / "a.yaml").value("sensors.speed_noise") == pytest.approx(0.05, rel=0.1)


@pytest.mark.parametrize("beside", [{"position": FOLLOWING}, {"position": STANDING, "speed": 0.0 * SPEED}])
def test_init_keeps_a_position_that_may_be_right(tmp_path, beside):
    """It follows in another recording, or nothing moves."""
    traces = [written(tmp_path, "b.csv", **beside)]
    if beside["position"] is FOLLOWING:
        traces.append(written(tmp_path, "a.csv", position=STANDING))
    init(str(tmp_path / "m"), traces)
    assert "motor_position: {columns" in (tmp_path / "m_map.yaml").read_text()
