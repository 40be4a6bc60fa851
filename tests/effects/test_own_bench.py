"""Every effect on its own virtual bench, whole and cut, with all signals and with counters and current only.

The twin that made a noise-free recording leaves nothing of it unexplained: what it leaves is its own error, which must
be small beside the sensors' noise. An effect is tested by being in the catalogue.
"""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.effects import catalogue
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.compared_signals import noise_floors
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.twin import Twin
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.recorded import changed

STARTED_BEFORE = ("thermal_friction", "spring_load", "presliding_friction", "backlash", "shaft_compliance")
"""Effects with a past (warmth, a relaxed spring, a bent bristle, a side of the gap) that a cut does not tell."""


def torque_noise(model, recording):
    """The unexplained torque's RMS over its noise floor, away from reversals, where teeth and bristles turn."""
    found = simulate(model, recording).signals["unexplained_torque"]
    speed = recording.signals.get("speed")
    if speed is None:
        speed = np.gradient(recording.signals["motor_position"], recording.time)
    settled = (np.abs(speed) > 2.0) & (recording.time > 0.5)
    floor = noise_floors(model, has_speed=recording.has("speed"))["unexplained_torque"]
    return np.sqrt(np.mean(found[settled] ** 2)) / floor


def unexplained(model, recording):
    """RMS [N m] of the unexplained torque."""
    return np.sqrt(np.nanmean(simulate(model, recording).signals["unexplained_torque"] ** 2))


@pytest.mark.parametrize("id", sorted(catalogue()))
def test_a_right_twin_leaves_nothing_unexplained(stock, id):
    model = stock.with_effect(id)
    bench = virtual_bench(model, parse_command("ramp:0.05"), 4.0, seed=None)
    twin = simulate(model, bench)
    floors = noise_floors(model)
    for name in ("current", "speed", "motor_position", "output_position"):
        error = np.sqrt(np.mean((bench.signals[name] - twin.signals[name]) ** 2))
        assert error < 0.3 * floors[name], (name, error / floors[name])
    assert torque_noise(model, bench) < 1.0
    bare = {name: bench.signals[name] for name in ("current", "motor_position", "output_position")}
    counters = Recording("counters", bench.stamps, bare, motor_angle_origin=0.0, output_angle_origin=0.0)
    assert torque_noise(model, counters) < 3.0


@pytest.mark.parametrize("id", sorted(set(catalogue()) - set(STARTED_BEFORE)))
def test_a_recording_that_starts_in_motion_is_explained_too(stock, id):
    model = stock.with_effect(id)
    cut = virtual_bench(model, parse_command("ramp:0.05"), 6.0, seed=None).between(3.0)
    twin = simulate(model, cut)
    floors = noise_floors(model)
    for name in ("current", "output_position"):
        error = np.sqrt(np.mean((cut.signals[name] - twin.signals[name])[250:] ** 2))
        assert error < 1.5 * floors[name], (name, error / floors[name])


def test_an_end_stop_stays_where_it_is_when_a_recording_is_cut(stock):
    model = stock.with_value("transmission.end_stop_upper", 0.05)
    bench = virtual_bench(model, parse_command("ramp:0.1"), 1.2, seed=None)
    for recording in (bench, bench.between(0.3)):
        twin = simulate(model, recording)
        error = np.sqrt(np.mean((recording.signals["current"] - twin.signals["current"]) ** 2))
        assert error < 10 * 0.003


def test_the_unexplained_torque_does_not_depend_on_the_assumed_stiffness(stock):
    model = stock.with_effect("backlash")
    bench = virtual_bench(model, parse_command("sine:0.02:1"), 4.0, seed=None)
    soft, stiff = (
        unexplained(model.with_value("transmission.contact_stiffness", value), bench) for value in (1e4, 3e4)
    )
    assert stiff == pytest.approx(soft, rel=0.02)


def test_with_the_right_backlash_less_is_unexplained_than_without(stock):
    bench = virtual_bench(stock.with_effect("backlash", {"width": 0.004}), parse_command("sine:0.02:1"), 4.0, seed=None)
    little, right = (unexplained(stock.with_effect("backlash", {"width": width}), bench) for width in (0.0005, 0.004))
    assert right < 0.5 * little


def test_a_hole_in_a_signal_does_not_last(stock):
    bench = virtual_bench(stock, parse_command("ramp:0.05"), 4.0, seed=None)
    speed = np.array(bench.signals["speed"])
    speed[1000:1003] = np.nan
    found = simulate(stock, changed(bench, speed=speed)).signals["unexplained_torque"]
    assert np.isfinite(found[1010:]).all()
    assert np.abs(found[1500:]).max() < 0.002


def test_a_late_encoder_switched_on_in_a_running_twin_slams_nothing(stock):
    twin = Twin(stock, "standalone")
    twin.start({"output_command": 0.0})
    currents = []
    for k in range(1, 1000):
        if k == 500:
            twin.change({"effects.encoder_delay.enabled": True})
        currents.append(twin.advance(2_000_000, {"output_command": 0.05 * 2e-3 * k})["current"])
    assert max(currents[480:]) < 2.0 * currents[480]
