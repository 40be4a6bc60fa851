"""The gains of a speed controller, found where a recording shows its setpoint."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.new_machine.drive_gains import drive_gains
from ema_twin_sim.simulation.simulate import has_speed_controller
from tests.accuracy.strangers.servo import Servo, run
from tests.recorded import sampled

SIZES = (1e-6, 1e-4, 1e-2)


def _recorded(servo, setpoint, period):
    true, random = run(servo, setpoint, period, 0.0), np.random.default_rng(2)
    return Recording(
        "run",
        np.arange(len(setpoint), dtype=np.int64) * round(period * 1e9),
        {
            "current": true.current + random.normal(0.0, 1e-4 * servo.top_current, len(setpoint)),
            "speed": true.speed + random.normal(0.0, 1e-4 * servo.top_speed, len(setpoint)),
            "speed_setpoint": setpoint,
        },
    )


def _servo(inertia):
    return Servo(
        inertia=inertia,
        viscous=0.01 * inertia,
        dry=100.0 * inertia,
        torque_constant=1e3 * inertia,
        top_speed=300.0,
        top_current=5.0,
        ratio=10.0,
        share_behind=0.3,
    )


@pytest.mark.slow
@pytest.mark.parametrize("inertia", SIZES)
def test_the_gains_of_a_pi_controller_are_found_on_machines_of_all_sizes(inertia):
    servo, time = _servo(inertia), np.arange(8000) * 5e-4
    setpoint = 60.0 * np.sin(6.0 * time) + 30.0 * np.sin(40.0 * time)
    found = drive_gains(_recorded(servo, setpoint, 5e-4), servo.torque_constant)
    assert found.speed_gain == pytest.approx(servo.bandwidth * inertia, rel=0.1)
    assert found.integral_time == pytest.approx(servo.integral_time, rel=0.25)


def test_a_torque_that_is_no_controllers_tells_no_gains():
    servo, time = _servo(1e-4), np.arange(4000) * 5e-4
    recording = _recorded(servo, 60.0 * np.sin(6.0 * time), 5e-4)
    torque = np.random.default_rng(3).normal(0.0, 1.0, len(time))
    signals = {**recording.signals, "current": torque}
    assert drive_gains(Recording("run", recording.stamps, signals), 1.0) is None
    del signals["speed_setpoint"]
    assert drive_gains(Recording("run", recording.stamps, signals), 1.0) is None


@pytest.mark.filterwarnings("error")
def test_a_torque_always_at_its_limit_shows_no_gains():
    """As of a relay; a warning of a library came out in place of nothing."""
    time = np.arange(2000) * 2e-3
    speed = np.cos(3.0 * time)
    signals = {"current": np.sign(speed) + (speed == 0.0), "speed": speed, "speed_setpoint": 1.1 * speed}
    recording = sampled("relay", time, signals)
    assert drive_gains(recording, 1.0) is None


def test_a_setpoint_without_a_controller_is_told_with_lines_to_fill_in(drafted, tmp_path, drawn):
    """The current here knows nothing of the setpoint: the twin is driven by it, and no command can be simulated."""
    time = np.arange(0.0, 6.0, 0.002)
    columns = {
        "time [s]": time,
        "motor speed [rad/s]": 50.0 * np.sin(3.0 * time),
        "motor current [A]": 2.0 * np.cos(3.0 * time) + np.sign(np.sin(3.0 * time)),
    }
    assert "speed controller" not in drafted(columns).told
    draft = drafted({**columns, "speed setpoint [rad/s]": 50.0 * np.sin(7.0 * time)})
    assert "No speed controller found: no recording shows that the current follows the speed setpoint" in draft.said
    assert not has_speed_controller(drawn())
    filled = draft.model.replace("…", "0.5")
    for line in ("drive:", "  speed_gain", "  integral_time", "  integral_limit"):
        filled = filled.replace(f"# {line}", line)
    (tmp_path / "m.yaml").write_text(filled)
    assert has_speed_controller(drawn())
