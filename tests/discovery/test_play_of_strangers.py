"""Play and eccentric encoders of machines of which nothing is known beforehand: any ratio, gap and sample rate."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.identification.hypothesis import INERTIAS
from ema_twin_sim.identification.local_minima import output_weights, starting
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.measured.ratio_of_positions import ratio_of_positions
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.measured.speed_lag import speed_lag
from ema_twin_sim.new_machine.shaft import positions_part, whole_ratio
from tests.accuracy.strangers.cases import stranger_cases
from tests.by_draft import by_draft
from tests.play import behind_play
from tests.problems import problem_of
from tests.recorded import changed, scaled

PLAY, OFF_CENTRE = (
    next(case for case in stranger_cases(7, 9, plain=True) if case.hidden == (effect,))
    for effect in ("backlash", "encoder_eccentricity")
)
"""Servos of 8.3e-6 and 2.5e-5 kg m²."""


def of_servo(case, rate, **constants: object):
    """A stranger's case at another sample rate [Hz], of a servo with other constants."""
    return replace(case, period=1.0 / rate, servo=replace(case.servo, **constants), knows=())


def drafted(case, folder):
    """A case's recordings, and its model as ``init`` drafts it."""
    files = case.write(folder)
    return by_draft(folder, files, files[:1])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "gap", "rate"),  # rad of the motor, Hz
    [(1.0, 0.3, 500.0), (5.0, 0.8, 500.0), (25.9375, 0.03, 250.0), (200.0, 0.2, 500.0)],
)
def test_play_is_named_whatever_its_width(ratio, gap, rate, tmp_path):
    width = gap / ratio
    recordings, model = drafted(of_servo(PLAY, rate, ratio=ratio, hidden={"backlash": {"width": width}}), tmp_path)
    assert model.value("machine.gear_ratio") == pytest.approx(ratio, rel=1e-5)
    found = discover(recordings, model)
    assert (found.verdict, found.added) == ("explained", ("backlash",))
    assert found.parameters["backlash"]["width"]["value"] == pytest.approx(width, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("late", [2, 6])  # samples
def test_play_is_named_beside_a_late_encoder(late, tmp_path):
    """What the delay leaves of the encoder difference is little of it, and far above the noise."""
    play = {"backlash": {"width": 1e-3}}
    recordings, model = drafted(of_servo(PLAY, 500.0, ratio=50.0, hidden=play), tmp_path)
    shown = [recording.signals["output_position"] for recording in recordings]
    seen = [np.r_[np.full(late, output[0]), output[:-late]] for output in shown]
    found = discover([changed(r, output_position=o) for r, o in zip(recordings, seen, strict=True)], model)
    assert (found.verdict, {*found.added}) == ("explained", {"backlash", "encoder_delay"})
    assert found.parameters["backlash"]["width"]["value"] == pytest.approx(1e-3, rel=0.05)
    assert found.parameters["encoder_delay"]["delay"]["value"] == pytest.approx(late / 500.0, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "rate"), [(1.0, 500.0), (50.0, 250.0)])
def test_an_encoder_off_its_centre_is_named_beside_any_ratio(ratio, rate, tmp_path):
    recordings, model = drafted(of_servo(OFF_CENTRE, rate, ratio=ratio), tmp_path)
    assert model.value("machine.gear_ratio") == ratio
    found = discover(recordings, model)
    assert (found.verdict, found.added) == ("explained", ("encoder_eccentricity",))


def test_a_ratio_of_one_has_two_sides_where_its_encoders_part(tmp_path):
    """Motor and output of a direct drive turn alike; only play between them tells that they are two."""
    for number, (hidden, sided) in enumerate((({"backlash": {"width": 0.05}}, True), ({}, False))):
        _, model = drafted(of_servo(PLAY, 500.0, ratio=1.0, hidden=hidden), tmp_path / str(number))
        assert (model.value("machine.output_inertia") > 0.0) == sided


@pytest.mark.parametrize("ratio", [1.0, 5.0, 25.9375, 160.0])
@pytest.mark.parametrize("amplitude", [0.0, 5e-3])
def test_a_ratio_is_found_beside_play_and_an_angle_error(ratio, amplitude):
    time = np.arange(4000) * 1e-3
    motor = ratio * 2.5 * np.sin(1.7 * time) * np.minimum(time, 1.0)
    output = behind_play(motor, 0.2) / ratio
    seen = output + amplitude * np.sin(output + 1.0)
    recording = Recording("a", np.rint(time * 1e9).astype(np.int64), {"motor_position": motor, "output_position": seen})
    found = ratio_of_positions(recording)
    assert found == pytest.approx(ratio, rel=2e-5)
    assert whole_ratio(found, recording) == (ratio if ratio != 25.9375 else None)
    assert positions_part(recording, ratio)


@pytest.mark.parametrize("half", [0.2, 0.5, 0.7])
def test_a_ratio_is_found_where_play_is_crossed_slowly_and_often(half):
    """A motor that moves by 4 rad to and fro crosses a wide play in up to two fifths of its samples."""
    time = np.arange(4000) * 1e-3
    speed = 4.0 * np.abs(np.mod(0.75 * time + 0.25, 1.0) - 0.5) - 1.0
    motor = 4.0 * np.cumsum(speed) / np.ptp(np.cumsum(speed))
    output = behind_play(motor, 2.0 * half) / 10.0
    stamps = np.rint(time * 1e9).astype(np.int64)
    assert np.mean(np.diff(output) == 0.0) > 0.2
    found = ratio_of_positions(Recording("a", stamps, {"motor_position": motor, "output_position": output}))
    assert found == pytest.approx(10.0, rel=2e-4)


@pytest.mark.parametrize("lag", [0.0, 3e-4, 2e-3])
def test_the_lag_of_a_speed_is_found_below_a_sample(lag):
    time = np.arange(5000) * 1e-3
    noise = np.random.default_rng(2)
    smoothed = [40.0 / math.hypot(1.0, 5.0 * lag) * np.cos(5.0 * time - math.atan(5.0 * lag)), 3.0]
    position = 8.0 * np.sin(5.0 * time) + 3.0 * time + noise.normal(0.0, 1e-5, 5000)
    signals = {"motor_position": position, "speed": sum(smoothed) + noise.normal(0.0, 0.02, 5000)}
    recording = Recording("a", np.rint(time * 1e9).astype(np.int64), signals)
    if lag == 0.0:
        assert speed_lag(recording) is None
    else:
        assert speed_lag(recording) == pytest.approx(lag, rel=0.1)
    assert speed_lag(scaled(recording, speed=9.55)) is None


@pytest.mark.slow
def test_a_motor_counter_that_steps_has_lost_no_counts(tmp_path):
    """At a high rate most samples of a coarse counter repeat the one before, and a count stands out."""
    case = of_servo(PLAY, 8000.0, ratio=2.0, hidden={"backlash": {"width": 0.15}})
    case = replace(case, servo=replace(case.servo, top_speed=0.1 * case.servo.top_speed))
    recordings, model = drafted(case, tmp_path)
    count = 2.0 * math.pi / 2**12
    coarse = [changed(r, motor_position=np.rint(r.signals["motor_position"] / count) * count) for r in recordings]
    own, told = to_own_units(coarse, model.with_value("sensors.motor_encoder_counts", 2.0**12))
    for recording in own:
        assert not observe(recording, told).encoder_piece.any()


def test_encoders_do_not_tell_how_heavy_all_is_behind_play(tmp_path):
    """Inertia, friction and contact behind it are told by how they compare: the torque must tell their size."""
    recordings, model = drafted(of_servo(PLAY, 500.0, ratio=10.0, hidden={"backlash": {"width": 0.03}}), tmp_path)
    recordings, model = to_own_units(recordings, model)
    problem = problem_of(recordings, model)
    h = null_hypothesis(model).with_effect("backlash", {}, {"width": 0.03})
    light, *_, heavy = (starting(h, factors) for factors in output_weights(h))
    assert sum(heavy.model().value(path) for path in INERTIAS) == pytest.approx(
        sum(light.model().value(path) for path in INERTIAS)
    )
    torque, apart = np.split(np.abs(problem.predict(heavy).rows - problem.predict(light).rows), [problem.size])
    assert np.max(apart) < 1e-6 < 1.0 < np.max(torque)
