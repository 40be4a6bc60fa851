"""A shaft that friction holds, and that only gives way: refused with what is true, and with what would help."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import POINTS, Recording
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.measured.observe import observe_all
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.model.own_units import OwnUnits, recording_in
from tests.recorded import sampled

STEP = 5e-6  # rad, of the encoder


def pushed(way):
    """A shaft that a slow torque of ±20 mN m pushes to and fro by a ``way`` [rad], late, as a bristle; by a counter."""
    time = np.arange(2000) * 5e-3
    signals = {
        "motor_torque": 0.02 * np.sin(1.2 * time),
        "motor_position": STEP * np.floor(0.5 * way * np.sin(1.2 * time - 0.3) / STEP),
    }
    return sampled("pushed", time, signals)


@pytest.mark.parametrize("way", [3.5e-4, 2.0 * STEP])
@pytest.mark.parametrize("units", [OwnUnits(), OwnUnits(time=30.0, torque=0.2)])
def test_a_shaft_that_only_gives_way_is_refused_with_a_remedy_that_applies(motor, way, units):
    """On fast and on slow machines: it was to be recorded longer, which shows no more."""
    with pytest.raises(
        InputError, match=r"less than an encoder's step \(5.00 µrad\) a sample.*record it sliding"
    ) as said:
        discover([recording_in(pushed(way), units)], motor)
    assert "longer, or" not in str(said.value)
    assert "operating points (init --operating-points)" in str(said.value)


def test_one_that_slides_far_is_judged(motor):
    assert len(observe_all(*to_own_units([pushed(3.0)], motor))[0].rows) > 100


def test_a_brief_slide_at_less_than_a_step_a_sample_is_not_said_to_rest(motor):
    """There and back over hundreds of an encoder's steps, in a tenth of the time: that is too little, but no rest."""
    step, time = 4e-4, np.arange(8000) * 1e-3
    turned = 0.2 * np.interp(time, [3.6, 4.0, 4.4], [0.0, 1.0, 0.0])
    signals = {"motor_torque": 0.02 * np.sign(np.gradient(turned)), "motor_position": step * np.floor(turned / step)}
    assert np.mean(np.abs(np.diff(signals["motor_position"]))) < step
    told = refused([sampled("brief", time, signals)], motor)
    assert "rests" not in told and "of motion faster than" in told


def test_the_way_is_told_to_and_fro(motor):
    """Two swings of ±10 steps go 80 steps, within a range of 20."""
    said = refused([pushed(20.0 * STEP)], motor)
    way = float(said.split("moves by ")[1].split(" µrad")[0])
    assert way == pytest.approx(20.0 * STEP * 2.0 * 1.2 * 10.0 / (2.0 * np.pi) * 1e6, rel=0.2)


def wound(name, torque=3.0):
    """A stiff spring that a clamped motor winds up by a ``torque`` [N m] either way, slowly; its encoder has noise."""
    time = np.arange(0.0, 35.0, 0.01)
    loads = np.interp(time, [0, 5, 10, 15, 20, 25, 30, 35], [0, 0, 1, 1, 0, -1, -1, 0])
    rng = np.random.default_rng(4)
    turned = 1.2e-3 * loads + 2e-5 * rng.standard_normal(len(time))
    signals = {
        "motor_torque": torque * loads + 0.002 * rng.standard_normal(len(time)),
        "motor_position": 1.4e-5 * np.rint(turned / 1.4e-5),
    }
    return sampled(name, time, signals)


def refused(runs, model):
    with pytest.raises(InputError) as said:
        observe_all(*to_own_units(runs, model))
    return str(said.value)


def test_a_spring_that_is_wound_up_is_to_be_read_as_operating_points(motor):
    """It was to be moved faster, which shows nothing of its stiffness."""
    told = refused([wound(f"a_long_name_of_a_run_{k}") for k in range(8)], motor)
    assert told.startswith("a_long_name_of_a_run_0 and 7 more: ")
    assert "a test of stiffness, held at each load, is read as operating points: `operating_points: true`" in told
    assert told.endswith("init --operating-points")


def test_a_shaft_that_rests_unloaded_is_no_test_of_stiffness(motor):
    assert "operating" not in refused([wound("a", torque=0.0)], motor)


@pytest.mark.parametrize("loaded", [False, True])
def test_operating_points_without_a_current_are_refused_unless_a_load_is_measured(motor, loaded):
    """The wrong column, as a rule. A motor that another one turns gives no torque, and a sensor beside it tells all."""
    speed = np.linspace(-20.0, 20.0, 80)
    signals = {"current": np.zeros(80), "speed": speed}
    if loaded:
        signals["load_torque"] = -0.1 * np.sign(speed) - 0.02 * speed
    points = Recording("points", np.arange(80) * 10**9, signals, metadata={POINTS: "true"})
    if loaded:
        noisy = signals["load_torque"] + np.random.default_rng(3).normal(0.0, 5e-3, 80)
        found = discover([replace(points, signals={**signals, "load_torque": noisy})], motor)
        assert np.isfinite(found.unseen.rmse).all() and found.added == ()
    else:
        with pytest.raises(InputError, match="its current is 0 A all along; is that the right column"):
            discover([points], motor)


def test_compare_asks_about_a_current_that_is_zero_all_along(motor):
    """Its relative torque error would be divided by zero; a machine that runs down beside others is no question."""
    time = np.arange(4000) * 1e-3
    speed = 20.0 * np.sin(3.0 * time)
    signals = {"current": np.zeros(4000), "speed": speed, "motor_position": -20.0 / 3.0 * np.cos(3.0 * time)}
    zero = Recording("zero", np.arange(4000) * 10**6, signals)
    driven = replace(zero, name="driven", signals={**signals, "current": 0.5 * np.sign(speed)})
    found = compare([zero], motor)
    assert [text for text in found.misread if "its current is 0 A all along; is that the right column" in text]
    assert found.recordings[0].torque_error is None
    assert not [text for text in compare([zero, driven], motor).misread if "all along" in text]


def points(name, count, seed):
    speed = np.linspace(20.0, 200.0, count)
    noise = 1e-3 * np.random.default_rng(seed).standard_normal(count)
    signals = {"current": 0.1 + 2e-5 * speed**2 + noise, "speed": speed}
    return Recording(name, np.arange(count) * 10**9, signals, metadata={POINTS: "yes"})


def test_the_operating_points_of_all_recordings_count_together(motor):
    """Each of three tables was refused as too short by itself."""
    tables = [points("a", 11, 1), points("b", 11, 2), points("c", 11, 3)]
    assert [len(o.rows) for o in observe_all(tables, motor)] == [11, 11, 11]
    few = [points("a", 5, 1), points("b", 6, 2)]
    with pytest.raises(InputError, match="a, b: 11 operating points are too few: at least 12 are needed; measure"):
        observe_all(few, motor)
    with pytest.raises(InputError, match="d: has 3 operating points; at least 4 are needed to see their noise"):
        observe_all([*tables, points("d", 3, 4)], motor)


def stepped(torque, speed, seconds=8.0):
    """A motor that is given one ``torque`` [N m] all along, at a ``speed`` (a function of time)."""
    time = np.arange(0.0, seconds, 2e-3)
    turned = np.array([speed(t) for t in time])
    noise = 1e-3 * np.random.default_rng(round(1e3 * torque)).standard_normal(len(time))
    signals = {
        "motor_torque": np.full(len(time), torque),
        "speed": turned + noise,
        "motor_position": np.cumsum(turned) * 2e-3,
    }
    return sampled(f"step {torque:g}", time, signals)


def test_a_step_test_of_several_levels_is_judged(motor):
    """Each was refused, as if its column were the wrong one: together they are the curve of the friction."""
    steps = [stepped(torque, lambda t, torque=torque: 500.0 * torque) for torque in (0.02, 0.03, 0.04)]
    assert all(len(o.rows) > 100 for o in observe_all(*to_own_units(steps, motor)))


def test_a_step_from_rest_is_judged_alone_if_the_inertia_is_known(motor):
    """Else dry friction alone explains one level of torque, and the inertia came out as none."""
    start = [stepped(0.02, lambda t: 10.0 * (1.0 - np.exp(-t)))]

    def known(tolerance):
        inertias = [f"machine.{part}_inertia" for part in ("motor", "gearbox", "output")]
        sure = {name: replace(motor.constants[name], tolerance=tolerance) for name in inertias}
        return replace(motor, constants={**motor.constants, **sure})

    assert len(observe_all(*to_own_units(start, known(0.1)))[0].rows) > 100
    assert "or give the model its inertia; or is that the right column" in refused(start, known(math.inf))


def test_one_level_at_one_speed_is_refused_in_its_own_unit(motor):
    steady = [replace(stepped(0.02, lambda t: 10.0), name=name) for name in ("one", "two")]
    assert refused(steady, motor) == (
        "one and 1 more: motor_torque is 20.0 mN m all along, which dry friction alone explains, whatever the inertia; "
        "record several levels, or a motion that changes; or is that the right column of the trace? Name it in the "
        "import map"
    )


def test_a_constant_torque_does_not_turn_a_motion_to_and_fro(motor):
    steps = [stepped(0.02, lambda t: 10.0 * np.sin(2.0 * t), seconds=7.5), stepped(0.03, lambda t: 15.0)]
    assert "step 0.02: its motor_torque is 20.0 mN m all along, while the motion reverses 4 times" in refused(
        steps, motor
    )
    once = [stepped(0.02, lambda t: 5.0 * (t - 4.0)), steps[1]]
    assert len(observe_all(*to_own_units(once, motor))) == 2
