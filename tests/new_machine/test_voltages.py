"""Recordings without a current or torque: a voltage or a duty cycle may stand for it, and init says so."""

import numpy as np
import pytest

from ema_bench_replay.load import load

TIME = np.arange(1500) * 2e-3
MOTION = {"time [s]": TIME, "motor position [rad]": 1.0 - np.cos(3.0 * TIME), "motor speed [rad/s]": np.sin(3.0 * TIME)}


@pytest.mark.parametrize(
    ("columns", "named"),
    [
        (("motor voltage [V]",), "If motor voltage [V] commands"),
        (("pwm",), "If pwm commands"),
        (("Duty cycle [%]",), "If Duty cycle [%] commands"),
        (("voltage [V]", "PWM_duty"), "If voltage [V], PWM_duty commands"),
    ],
)
def test_a_voltage_that_may_serve_is_named(columns, named, drafted):
    said = drafted({**MOTION, **{name: np.cos(3.0 * TIME) for name in columns}}).said
    assert f"{named} the drive's torque, it can serve" in said and "with its `gain`" in said


def test_without_a_voltage_none_is_spoken_of(drafted):
    said = drafted(MOTION).said
    assert "add its column to" in said and "can serve" not in said


def test_the_way_told_reads_a_duty_cycle_as_torque(drafted, tmp_path):
    """Of 24 V, at 0.1 N m/V."""
    draft = drafted({**MOTION, "pwm": np.cos(3.0 * TIME)})
    prepared = next(line for line in draft.map.splitlines() if line.startswith("#  motor_torque: "))
    line = prepared[1:].replace("['…']", "['pwm']").replace("unit: V,", "unit: V, factor: 24,").replace("…", "0.1")
    (tmp_path / "m_map.yaml").write_text(draft.map.replace(prepared, line))
    recording = load(tmp_path / "run0.csv", import_map=tmp_path / "m_map.yaml")
    assert np.allclose(recording.signals["motor_torque"], 2.4 * np.cos(3.0 * TIME), atol=1e-3)
