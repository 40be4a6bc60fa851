"""Stops at reversals: friction that holds is no inertia, and what friction cannot be is none of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.identification.stops import Stops
from ema_twin_sim.model import load_model
from ema_twin_sim.new_machine.drafts import checked_model
from ema_twin_sim.new_machine.given import Given
from ema_twin_sim.new_machine.shaft import Shaft
from tests.accuracy.strangers.servo import Servo, run

PERIOD = 2e-3
SERVO = Servo(
    inertia=2e-4, viscous=1e-4, dry=0.03, torque_constant=0.1, top_speed=100.0, top_current=10.0, ratio=1.0,
    share_behind=0.3, integral_time=0.06,
)  # fmt: skip


def recordings(servo, seed):
    """Three motions with many reversals, as a current, a fine position and a noisy speed tell them."""
    random, time = np.random.default_rng(seed), np.arange(3000) * PERIOD
    found = []
    for number, (quick, share) in enumerate(((5.0, 0.3), (9.0, 0.2), (2.0, 0.1))):
        true = run(servo, share * servo.top_speed * np.sin(quick * time), PERIOD, 0.0)
        signals = {
            "motor_position": true.motor,
            "speed": true.speed + random.normal(0.0, 0.03, len(time)),
            "current": true.current + random.normal(0.0, 0.01, len(time)),
        }
        found.append(Recording(f"run{number}", np.arange(len(time)) * 2_000_000, signals))
    return found


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_friction_that_holds_at_reversals_is_no_inertia(tmp_path, seed):
    runs = recordings(SERVO, seed)
    (tmp_path / "m.yaml").write_text(checked_model(runs, Given("m", 1.0, SERVO.torque_constant), Shaft()).text)
    found = discover(runs, load_model(tmp_path / "m.yaml"))
    assert found.added == ()
    inertia = found.constants["machine"]["inertia"]
    assert abs(inertia["value"] - SERVO.inertia) < 2.0 * inertia["std"]
    assert inertia["std"] < 0.01 * SERVO.inertia


def test_what_stops_add_is_taken_out_of_rows_and_of_columns():
    direction = np.array([0.0, 0.6, 0.8])
    stops = Stops(((slice(1, 4), direction),))
    rows = np.arange(1.0, 7.0)
    out = stops.taken_out(rows)
    assert direction @ out[1:4] == pytest.approx(0.0)
    assert out[[0, 4, 5]] == pytest.approx(rows[[0, 4, 5]])
    assert stops.taken_out(np.stack([rows, 2.0 * rows], 1)) == pytest.approx(np.stack([out, 2.0 * out], 1))
    assert stops.taken_out(out) == pytest.approx(out)


@pytest.mark.parametrize(("pushes", "is_friction"), [(0.2, True), (-0.5, False), (1.5, False)])
def test_only_what_friction_can_be_is_taken_for_it(pushes, is_friction):
    """Friction at stops pushes with the drive, by a share of its level; what does otherwise is no friction."""
    time = np.arange(8000) * PERIOD
    swing = 5.0 * np.sin(2.0 * time)
    speed = np.where(np.abs(swing) < 1.0, 0.0, swing)
    acceleration = 10.0 * np.cos(2.0 * time)
    friction = np.where(speed == 0.0, pushes * np.sign(acceleration), np.sign(speed))
    o = SimpleNamespace(
        geared=False, of_points=False, rows=np.arange(50, 7950, 5), kernel=np.ones(1),
        motion=np.zeros((8000, 7)), torque_noise=np.full(1580, 0.01),
    )  # fmt: skip
    o.motion[:, 1], o.motion[:, 2], o.motion[:, 3] = np.cumsum(speed) * PERIOD, speed, acceleration
    o.acceleration = np.where(speed == 0.0, 0.0, acceleration)[o.rows]
    o.torque = 0.1 * o.acceleration + friction[o.rows]
    assert bool(Stops.of([o], [slice(0, 1580)]).parts) is is_friction
