"""The unexplained torque near standstill, at reversals, and at the start of a recording."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.model.own_units import OwnUnits, model_in, recording_in
from ema_twin_sim.plant.balance import BALANCE_LAG, SETTLED
from ema_twin_sim.plant.counter import COUNTER_LAG
from ema_twin_sim.simulation.simulate import simulate

BEYOND = 0.02  # N m that the drive gives beyond what the model needs


def turning(stock, speed):
    """The stock bench at a constant motor speed [rad/s] with a torque that its model does not explain."""
    time = np.arange(1000) * 2e-3
    friction = sum(i.parameters["torque"] for i in stock.active.values() if i.effect == "coulomb_friction")
    viscous = sum(i.parameters["coefficient"] for i in stock.active.values() if i.effect == "viscous_friction")
    current = (friction + viscous * speed + BEYOND) / stock.value("machine.torque_constant")
    signals = {
        "motor_position": speed * time,
        "speed": np.full_like(time, speed),
        "current": np.full_like(time, current),
    }
    return Recording("turning", np.rint(time * 1e9).astype(np.int64), signals)


@pytest.mark.parametrize("slower", [0.1, 1.0, 10.0, 100.0])
def test_a_machine_that_turns_slowly_does_not_rest(stock, slower):
    """At 0.4 rad/s the bench slides. So does a machine that is the same but a hundred times as slow."""
    units = OwnUnits(time=1.0 / slower)
    alike, twin = recording_in(turning(stock, 0.4), units), model_in(stock, units)
    left = simulate(twin, alike, "current").signals["unexplained_torque"]
    assert left[-1] == pytest.approx(BEYOND, rel=1e-3)


def test_the_inertia_of_a_draft_hides_nothing(stock):
    """A millionth of the inertia, as a guess may be, does not make a shaft of 0.4 rad/s rest."""
    draft = stock
    for part in ("motor", "gearbox", "output"):
        path = f"machine.{part}_inertia"
        draft = draft.with_value(path, 1e-6 * stock.value(path))
    left = simulate(draft, turning(stock, 0.4), "current").signals["unexplained_torque"]
    assert left[-1] == pytest.approx(BEYOND, rel=1e-3)


def test_a_shaft_that_hardly_moves_is_held(stock):
    left = simulate(stock, turning(stock, 0.01), "current").signals["unexplained_torque"]
    assert left[-1] == pytest.approx(0.0, abs=1e-12)


LAWS = {
    "shear_thinning": ({"fraction": 0.5, "speed": 20.0}, {}, lambda w, a, q, b: -0.5 * b * w * w / (w + 20.0)),
    "quadratic_drag": ({"coefficient": 5e-5}, {}, lambda w, a, q, b: 5e-5 * w**2),
    "stribeck_friction": ({"torque": 0.05, "speed": 20.0}, {}, lambda w, a, q, b: 0.05 * np.exp(-w / 20.0)),
    "added_inertia": ({"inertia": 1e-3}, {}, lambda w, a, q, b: 1e-3 * a),
    "sun_runout": ({"torque": 0.05, "phase": 0.3}, {"kind": "dissipative"}, lambda w, a, q, b: 0.05 * np.sin(q + 0.3)),
    "cogging": ({"torque": 0.05, "phase": 0.3}, {"order": "3"}, lambda w, a, q, b: 0.05 * np.sin(3.0 * q + 0.3)),
}


TIME, TURN = np.arange(4000) * 1e-3, 4.0 * np.pi
SPEED, ACCELERATION = 32.0 - 28.0 * np.cos(TURN * TIME), 28.0 * TURN * np.sin(TURN * TIME)
ANGLE = 32.0 * TIME - 28.0 / TURN * np.sin(TURN * TIME)
"""The machine turns forward, from 4 to 60 rad/s and back twice a second, so that what is left is no reversal."""


def friction(stock, id, *sides):
    """The sum of a friction's first parameter over both sides, or those named."""
    held = [i for i in stock.active.values() if i.effect == id and i.options["side"] in (sides or ("motor", "output"))]
    return sum(next(iter(i.parameters.values())) for i in held)


def left_with(model, extra):
    """What a model leaves of the stock machine with an ``extra`` torque (n,) [N m], told by its counter alone."""
    inertia = sum(model.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    drive = inertia * ACCELERATION + friction(model, "viscous_friction") * SPEED + friction(model, "coulomb_friction")
    signals = {"motor_position": ANGLE, "current": (drive + extra) / model.value("machine.torque_constant")}
    bench = Recording("turning", np.rint(TIME * 1e9).astype(np.int64), signals)
    return simulate(model, bench, "current").signals["unexplained_torque"][500:]


@pytest.mark.parametrize("effect", LAWS)
def test_a_counter_alone_delays_no_effect(stock, effect):
    """Every torque passes the same filter, whether it follows the counter's speed, which has passed a part, or not."""
    parameters, options, law = LAWS[effect]
    extra = law(SPEED, ACCELERATION, ANGLE, friction(stock, "viscous_friction"))
    left = left_with(stock.with_effect(effect, parameters, options), extra)
    assert np.std(left) < 0.02 * np.std(extra)


def test_friction_of_the_teeth_follows_a_load_without_delay(stock):
    """A load over the shaft's angle passes the first lag, and so does the friction that it causes."""
    order = 3.0 * stock.value("machine.gear_ratio")
    model = stock.with_effect("constant_load", {"torque": 2.0})
    model = model.with_effect("output_ripple", {"torque": 0.5, "phase": 0.0}, {"order": f"{order:g}"})
    load = 2.0 + 0.5 * np.sin(3.0 * ANGLE)
    own = model.value("machine.output_inertia") * ACCELERATION + friction(stock, "coulomb_friction", "output")
    teeth = 0.3 * (own + friction(stock, "viscous_friction", "output") * SPEED + load)
    left = left_with(model.with_effect("mesh_friction", {"coefficient": 0.3}), load + teeth)
    assert np.std(left) < 0.02 * np.std(teeth)


def speeding_up(model, period, *, signal):
    """A constant acceleration of the model's own machine, sampled every ``period`` [s], with or without its speed."""
    time = np.arange(round(1.0 / period)) * period
    rising, begun = 100.0, 20.0
    speed = begun + rising * time
    parts = {"motor": [], "output": []}
    for held in model.active.values():
        if "side" in held.options:
            parts[held.options["side"]].append(next(iter(held.parameters.values())) * np.ones_like(time))
            if held.effect == "viscous_friction":
                parts[held.options["side"]][-1] = parts[held.options["side"]][-1] * speed
    passed = model.value("machine.output_inertia") * rising + sum(parts["output"])
    inertia = model.value("machine.motor_inertia") + model.value("machine.gearbox_inertia")
    teeth = model.active["mesh_friction"].parameters["coefficient"] * passed
    torque = passed + teeth + inertia * rising + sum(parts["motor"])
    signals = {
        "motor_position": begun * time + 0.5 * rising * time**2,
        "speed": speed,
        "current": torque / model.value("machine.torque_constant"),
    }
    if not signal:
        del signals["speed"]
    return Recording("speeding_up", np.rint(time * 1e9).astype(np.int64), signals)


@pytest.mark.parametrize("period", [5e-4, 2e-3, 1e-2, 2.5e-2])
@pytest.mark.parametrize("signal", [True, False], ids=["speed", "counter"])
def test_what_follows_the_acceleration_is_right_at_any_sample_rate(stock, period, signal):
    """Friction of the teeth carries the output's inertia: a trace of 100 Hz shows it as well as one of 2 kHz."""
    model = stock.with_effect("mesh_friction", {"coefficient": 0.5})
    model = model.with_value("sensors.speed_smoothing", 0.0)
    recording = speeding_up(model, period, signal=signal)
    left = simulate(model, recording, "current").signals["unexplained_torque"]
    carried = 0.5 * model.value("machine.output_inertia") * 100.0
    assert abs(left[-1]) < 0.02 * carried


def test_a_counter_read_once_a_second_leaves_no_gap(stock):
    """So long after a sample, the lag has settled to the last digit."""
    bench = turning(stock, 20.0)
    time = np.arange(12.0)
    slow = {"motor_position": 20.0 * time, "current": np.full(len(time), bench.signals["current"][-1])}
    recording = Recording("slow", np.rint(time * 1e9).astype(np.int64), slow)
    left = simulate(stock, recording, "current").signals["unexplained_torque"]
    assert left[1:] == pytest.approx(BEYOND, rel=1e-6)


def reversing(model, *, begun, step):
    """The model's own machine turning to and fro at up to 60 rad/s, told by its counter alone, in steps of ``step``.

    The recording starts ``begun`` seconds into the motion.
    """
    time = begun + np.arange(4000) * 1e-3
    speed, acceleration = 60.0 * np.sin(TURN * time), 60.0 * TURN * np.cos(TURN * time)
    angle = -60.0 / TURN * np.cos(TURN * time)
    inertia = sum(model.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    dry, uneven = friction(model, "coulomb_friction"), 0.0
    if "asymmetric_friction" in model.active:
        uneven = model.active["asymmetric_friction"].parameters["fraction"]
    rubbing = dry * np.sign(speed) + friction(model, "viscous_friction") * speed
    torque = inertia * acceleration + rubbing * (1.0 + uneven * np.sign(speed))
    shown = np.floor(angle / step + 0.5) * step if step else angle
    signals = {"motor_position": shown - shown[0], "current": torque / model.value("machine.torque_constant")}
    return Recording("reversing", np.rint((time - begun) * 1e9).astype(np.int64), signals), dry


@pytest.mark.parametrize("uneven", [0.0, 0.3])
@pytest.mark.parametrize("step", [0.0, 2e-4])
def test_a_counter_alone_shows_when_its_shaft_turns_round(stock, step, uneven):
    """The lagged speed turns round later than the shaft: friction by its sign missed the level after each reversal."""
    model = stock
    if uneven:  # of dry friction alone: what is uneven of the viscous one follows the lagged speed's size
        model = stock.with_effect("asymmetric_friction", {"fraction": uneven})
        for side in ("viscous_friction", "viscous_friction_2"):
            model = model.with_value(f"effects.{side}.coefficient", 0.0)
    model = model.with_value("sensors.motor_encoder_counts", 2.0 * np.pi / (step or 1e-6))
    recording, dry = reversing(model, begun=0.13, step=step)
    left = simulate(model, recording, "current").signals["unexplained_torque"]
    assert np.sqrt(np.nanmean(left**2)) < 0.06 * dry  # by the lagged speed's sign: 0.4


@pytest.mark.parametrize("signal", ["motor_position", "speed"])
def test_a_recording_that_begins_while_its_shaft_speeds_up_tells_nothing_until_the_filters_have_settled(stock, signal):
    """Nothing is known of the motion before the first sample, and the inertia's torque would be an error."""
    model = stock.with_value("sensors.speed_smoothing", 0.0)
    recording = speeding_up(model.with_effect("mesh_friction", {"coefficient": 0.0}), 1e-3, signal=signal == "speed")
    left = simulate(model, recording, "current").signals["unexplained_torque"]
    lag = BALANCE_LAG if signal == "speed" else COUNTER_LAG
    assert np.isnan(left[recording.time < 0.99 * SETTLED * lag]).all()
    inertia = 100.0 * sum(model.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
    assert np.max(np.abs(left[recording.time > 1.01 * SETTLED * lag])) < 0.03 * inertia
