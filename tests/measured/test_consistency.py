"""Units, counts and signs that are wrong in an import map are named before anything is fitted."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.measured.consistency import inconsistencies, told_once
from ema_twin_sim.model.matching import matched
from ema_twin_sim.model.own_units import OwnUnits, model_in, recording_in
from tests.recorded import benched, scaled, with_signals

DEGREE = math.pi / 180.0


@pytest.fixture(scope="module")
def driven(stock):
    return benched(stock, "sine:0.02:2", 5.0, name="driven", seed=1)


def test_signals_that_fit_each_other_are_left_in_peace(driven, stock):
    assert not list(inconsistencies(driven, stock))


@pytest.mark.parametrize(
    ("factors", "words"),
    [
        ({"speed": 1.0 / DEGREE}, ("speed is 57.3 times", "speed were in degrees")),
        ({"speed": 30.0 / math.pi}, ("speed is 9.5", "speed were in rpm")),
        ({"motor_position": 1000.0}, ("motor_position is 1000 times", "motor_position were in mrad and read as rad")),
        ({"motor_position": 4.0}, ("motor_position is 4", "counts_per_revolution of motor_position", "fourfold")),
        ({"motor_position": 0.25}, ("motor_position is 0.25", "four twice")),
        ({"output_position": 4.0}, ("output_position is 4", "fourfold", "machine.gear_ratio")),
        ({"output_position": 124.0}, ("output_position is 124", "the gear ratio")),
        ({"output_position": -1.0}, ("output_position is -1", "other sign")),
        (
            {"current": 1000.0, "current_setpoint": 1000.0},
            ("current reaches", "mA and read as A", "drive.current_limit"),
        ),
        ({"current": -1.0, "current_setpoint": -1.0}, ("current is -", "sign were turned round")),
        (
            dict.fromkeys(("speed", "speed_setpoint", "motor_position", "output_position"), 1.0 / DEGREE),
            ("current is 0.01", "the motion were in degrees"),
        ),
    ],
    ids=lambda value: " ".join(f"{k} {v:.3g}" for k, v in value.items()) if isinstance(value, dict) else "",
)
def test_a_wrong_unit_is_named(driven, stock, factors, words):
    wrong = scaled(driven, **factors)
    found = str(next(inconsistencies(wrong, stock)))
    assert all(word in found for word in ("driven: ", "check unit", *words)), found


def test_a_spoilt_sample_is_named_before_anything_is_compared(driven, stock):
    speed = driven.signals["speed"].copy()
    speed[1234] = 1e6
    with pytest.raises(InputError, match=r"speed is 1e\+06 rad/s at [0-9.]+ s \(sample 1234\).*speed_limit.*--from"):
        matched(with_signals(driven, {**driven.signals, "speed": speed}), stock)


def test_nothing_is_fitted_to_it(driven, stock):
    wrong = scaled(driven, speed=30.0 / math.pi)
    for judge in (discover, fit_model):
        with pytest.raises(InputError, match="speed were in rpm"):
            judge([wrong], stock)
    assert any("speed were in rpm" in warning for warning in compare([wrong], stock).warnings)


def test_an_output_that_hardly_follows_is_no_wrong_count(stock):
    """Within its play the output rests: no factor, and none is named."""
    play = stock.with_effect("backlash", {"width": 0.5})
    rocking = benched(play, "sine:0.001:1", 5.0, name="rocking", seed=3)
    assert not list(inconsistencies(rocking, stock))


def test_a_gap_in_a_signal_hides_nothing(driven, stock):
    speed = driven.signals["speed"] * 30.0 / math.pi
    holed = with_signals(driven, {**driven.signals, "speed": np.where(driven.time > 2.0, speed, np.nan)})
    assert "speed were in rpm" in str(next(inconsistencies(replace(holed, name="holed"), stock)))


@pytest.mark.parametrize("ratio", [8.0, 36.0, 300.0])
def test_both_encoders_tell_a_gear_ratio_that_is_another_machines(driven, stock, ratio):
    """No play and no spring makes an output go ten times as far as its motor turns it."""
    (found,) = inconsistencies(driven, stock.with_value("machine.gear_ratio", ratio))
    assert "output_position is" in found.what and "machine.gear_ratio (with 124 they fit)" in found.remedy


@pytest.mark.parametrize("ratio", [77.5, 100.0, 150.0])
def test_a_ratio_no_unit_explains_is_told_where_the_shafts_part_by_the_angle_alone(stock, ratio):
    """A factor of 1.6 is no usual mistake, and a spring could make it: but not of an angle that no torque follows."""
    ramp = benched(stock, "ramp:0.1", 5.0, name="ramp", seed=2)
    inertia = replace(stock.constants["machine.motor_inertia"], tolerance=math.inf)
    for unknown in (stock, replace(stock, constants={**stock.constants, "machine.motor_inertia": inertia})):
        wrong = unknown.with_value("machine.gear_ratio", ratio)
        assert "with 124 they fit" in str(next(inconsistencies(ramp, wrong)))


def test_a_shaft_that_winds_up_under_its_load_is_no_wrong_gear_ratio(stock):
    """An output on a spring winds its shaft up by the angle, and the torque goes with it."""
    held = stock.with_effect("spring_load", {"stiffness": 31.0})
    wound = held.with_effect("shaft_compliance", {"stiffness": 1.0, "damping": 0.02})
    swung = benched(wound, "sine:0.02:0.5", 5.0, name="swung", seed=4, origins=(0.0, 0.0))
    turned = swung.signals["motor_position"] / held.value("machine.gear_ratio")
    assert 0.7 < np.ptp(swung.signals["output_position"]) / np.ptp(turned) < 0.9
    assert not list(inconsistencies(swung, held))


def test_an_output_that_swings_on_its_shaft_is_no_wrong_gear_ratio(driven, stock):
    """Near its resonance it goes farther than the motor turns it; on a ramp both go the same way."""
    swung = scaled(driven, output_position=1.6)
    ramp = benched(stock, "ramp:0.1", 5.0, name="ramp", seed=2)
    assert [found.what for found in inconsistencies(swung, stock, [swung, scaled(ramp, output_position=1.6)])]
    assert not list(inconsistencies(swung, stock, [swung, ramp]))


def test_an_output_that_rings_goes_as_far_from_end_to_end(driven, stock):
    """A soft shaft's output swings about where the motor takes it: it goes farther way by way, not from end to end."""
    ramp = benched(stock, "ramp:0.1", 5.0, name="ramp", seed=2)
    output = ramp.signals["output_position"]
    ringing = output + 0.05 * np.ptp(output) * np.sin(60.0 * ramp.time)
    rings = replace(ramp, signals={**ramp.signals, "output_position": ringing})
    swung = scaled(driven, output_position=1.6)
    assert not list(inconsistencies(swung, stock, [swung, rings]))
    assert list(inconsistencies(swung, stock, [swung, scaled(rings, output_position=1.6)]))


def test_counts_taken_twice_are_told_beside_another_recording_that_fits(driven, stock):
    ramp = benched(stock, "ramp:0.1", 5.0, name="ramp", seed=2)
    (found,) = inconsistencies(scaled(driven, output_position=2.0), stock, [driven, ramp])
    assert "counted twice" in found.what


def test_what_no_unit_explains_is_a_question_beside_most_that_fit(driven, stock):
    """The noise of a slow run's speed drifts by more than its way."""
    others = [replace(driven, name=f"other_{k}") for k in range(3)]
    drifted = scaled(driven, speed=1.0 / 1.16)
    (alone,) = inconsistencies(drifted, stock)
    (beside,) = inconsistencies(drifted, stock, [drifted, *others])
    assert alone.certain and not beside.certain and "motor_position is 1.16 times" in beside.what
    degrees = next(inconsistencies(scaled(driven, speed=1.0 / DEGREE), stock, others))
    assert degrees.certain


def test_a_comparison_judges_a_slow_machine_as_a_discovery_does(stock):
    """What moves slowly is looked at over as much of its own time: one verb warns of what the other refuses."""
    units = OwnUnits(time=1e-2)  # a hundred times slower than the bench
    bench = stock.with_value("sensors.output_encoder_counts", 65536.0)
    slow = replace(model_in(bench, units), units=None)
    run = recording_in(benched(bench, "sine:0.02:0.5", 8.0, name="slow", seed=1), units)
    wrong = scaled(run, output_position=4.0)
    with pytest.raises(InputError) as refused:
        discover([wrong], slow)
    assert str(refused.value) in compare([wrong], slow).warnings
    assert not compare([run], slow).warnings


def test_a_current_quieter_than_the_noise_that_the_model_states_is_told_unless_another_recording_moves_it(
    stock, driven
):
    quiet = scaled(driven, current=1e-4)
    (found,) = (each for each in inconsistencies(quiet, stock) if "noise" in each.what)
    assert "current is" in found.what and "3.00 mA of noise" in found.what
    assert "import map" in found.remedy and "sensors.current_noise" in found.remedy
    assert not [each for each in inconsistencies(quiet, stock, [quiet, driven]) if "noise" in each.what]


def test_the_same_mistake_in_several_recordings_is_told_in_one_line_with_the_worst(stock, driven):
    runs = [replace(scaled(driven, current=times), name=f"run{times:g}") for times in (500.0, 2000.0, 1000.0)]
    found = [each for run in runs for each in inconsistencies(run, stock) if "limited" in each.what]
    (line,) = told_once(found, 4)
    assert line.startswith("3 of 4 recordings, the worst is run2000: current reaches")
    assert told_once(found[:1], 4) == [str(found[0])]
