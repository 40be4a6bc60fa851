"""Operating points: recordings of rest and of constant speed, each sample by itself."""

import math
from dataclasses import replace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import MOTION, POINTS, Recording
from ema_twin_sim.commands.judged import write_evidence_bag
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.plan import plan
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.measured.folds import operating_point_folds
from ema_twin_sim.model import load_model
from ema_twin_sim.model.model_file import TORQUE_CONSTANT
from ema_twin_sim.simulation.operating_points import approached, directed
from ema_twin_sim.simulation.simulate import simulate
from tests.command_line import refused, twin

CONSTANT = 0.025
NOISE = 0.002


def points(name="points", **signals):
    count = len(next(iter(signals.values())))
    return Recording(name, np.arange(count) * 1_000_000_000, signals, motor_angle_origin=0.0, metadata={POINTS: "yes"})


@pytest.fixture(scope="module")
def motor():
    model = load_model("laas_motor")
    return model.with_value("sensors.current_noise", NOISE)


@pytest.fixture(scope="module")
def held():
    """A motor held at angles, come to from both sides: cogging of order 7 (in no list) and Coulomb friction."""
    rng = np.random.default_rng(5)
    up = np.linspace(0.0, 2.0 * math.pi, 1500)
    angle = np.concatenate([up, up[::-1]])
    sense = np.repeat([1.0, -1.0], 1500)
    torque = 4e-3 * np.sin(7.0 * angle + 0.5) + 1e-3 * sense
    return points(motor_position=angle, current=torque / CONSTANT + NOISE * rng.standard_normal(3000))


def test_an_order_that_is_in_no_list_is_found(held, motor):
    found = discover([held], motor)
    assert found.verdict == "explained"
    assert set(found.added) == {"cogging", "coulomb_friction"}
    cogging = found.parameters["cogging"]
    assert found.model.effects["cogging"].options["order"] == "7"
    assert abs(cogging["torque"]["value"] - 4e-3) < max(3.0 * cogging["torque"]["std"], 4e-5)
    assert abs(cogging["phase"]["value"] - 0.5) < max(3.0 * cogging["phase"]["std"], 0.01)
    assert found.parameters["coulomb_friction"]["torque"]["value"] == pytest.approx(1e-3, rel=0.03)
    assert found.unseen.rmse[-1] == pytest.approx(NOISE, rel=0.1)
    assert found.unseen.recordings[0][0] == "points, eighths 1 3 5 7 of its positions"


def test_no_order_is_found_on_a_machine_that_has_no_others(held, motor):
    """What repeats there is unknown."""
    found = discover([held], replace(motor, other_orders=False))
    assert "7" not in {i.options.get("order") for i in found.model.effects.values()}
    assert found.verdict == "unknown"


@pytest.mark.parametrize(("count", "order"), [(60, 7), (100, 12)])
def test_no_alias_is_named(motor, count, order):
    """So few angles a turn resolve no high order; the one that is there is below."""
    rng = np.random.default_rng(8)
    up = np.arange(count) * 2.0 * math.pi / count
    angle = np.concatenate([up, up[::-1]])
    torque = 4e-3 * np.sin(order * angle + 0.5) + 1e-3 * np.repeat([1.0, -1.0], count)
    held = points(motor_position=angle, current=torque / CONSTANT + NOISE * rng.standard_normal(2 * count))
    found = discover([held], motor)
    assert found.model.effects["cogging"].options["order"] == str(order)


def test_random_order_tells_the_way_to_each_point():
    position = np.random.default_rng(9).permutation(np.linspace(0.0, 6.0, 200))
    assert (approached(position)[1:] == np.sign(np.diff(position))).all()
    holed = position.copy()
    holed[5] = math.nan
    assert np.mean(approached(holed) != 0.0) > 0.98


def test_friction_is_found_where_angles_were_taken_at_random(motor):
    """Each half keeps the way to its points, though the points before them are in the other."""
    rng = np.random.default_rng(12)
    angle = rng.permutation(np.linspace(0.0, 2.0 * math.pi, 600, endpoint=False))
    torque = 4e-3 * np.sin(12.0 * angle) + 1e-3 * np.sign(np.diff(angle, prepend=0.0))
    held = points(motor_position=angle, current=torque / CONSTANT + NOISE * rng.standard_normal(600))
    found = discover([held], motor)
    assert set(found.added) == {"cogging", "coulomb_friction"}
    assert found.parameters["coulomb_friction"]["torque"]["value"] == pytest.approx(1e-3, rel=0.05)


def test_a_ripple_in_proportion_to_the_current_explains_nothing_by_itself(motor):
    rng = np.random.default_rng(10)
    wandering = points(motor_position=np.zeros(100), current=np.cumsum(0.1 * rng.standard_normal(100)))
    assert not {"torque_ripple", "torque_constant_error"} & {*discover([wandering], motor).added}


def test_a_carriages_friction_curve_needs_no_position():
    rng = np.random.default_rng(11)
    speed = np.concatenate([s * np.geomspace(2e-3, 0.2, 40) for s in (1.0, -1.0)])
    force = 203.0 * speed + 20.0 * np.sign(speed) - 3.0 + 0.05 * rng.standard_normal(80)
    curve = replace(points("rail", speed=speed, motor_torque=force), metadata={POINTS: "yes", MOTION: "linear"})
    fitted = fit_model([curve], load_model("emps")).parameters
    assert fitted["viscous_friction"]["coefficient"]["value"] == pytest.approx(203.0, rel=0.02)
    assert fitted["coulomb_friction"]["torque"]["value"] == pytest.approx(20.0, rel=0.02)
    assert fitted["constant_load"]["torque"]["value"] == pytest.approx(-3.0, rel=0.05)


def test_points_and_motions_are_judged_apart(held, motor):
    with pytest.raises(InputError, match="one kind at a time"):
        discover([held, replace(held, name="run", metadata={})], motor)


def test_an_error_of_points_depends_on_no_time(held, motor):
    """A table without a clock was said to fail "at 322 to 343 s"."""
    found = compare([held], motor).where
    assert found and "time" not in {dependence.variable for dependence in found}


def test_the_evidence_of_a_lone_table_is_written(held, motor, tmp_path):
    found = discover([held], motor)
    write_evidence_bag(found, tmp_path / "found.mcap", force=False)
    with (tmp_path / "found.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        messages = [
            (channel.topic, message.log_time, decoded)
            for _, channel, message, decoded in reader.iter_decoded_messages()
        ]
    assert {topic.rpartition("/")[0] for topic, _, _ in messages} >= {
        f"/evidence/step_1_cogging/points/over_position/{way}" for way in ("forward", "backward")
    }
    of_one = "/evidence/step_1_cogging/points/over_position/backward/torque"
    one = [(time, decoded) for topic, time, decoded in messages if topic == of_one]
    assert len(one) == pytest.approx(len(held) / 2, abs=2)
    first, last = (time for time, _ in (one[0], one[-1]))
    assert (last - first) * 1e-9 == pytest.approx(2.0 * math.pi, abs=0.02)
    names, torques = one[0][1].name, np.array([decoded.effort for _, decoded in one])
    assert list(names) == ["measured", "model before", "model after"]
    assert np.std(torques[:, 0] - torques[:, 2]) < 0.5 * np.std(torques[:, 0] - torques[:, 1])


def test_what_rest_does_not_show_is_left_as_it_was(held, motor):
    """At rest no viscous friction acts: it is neither fitted nor lost."""
    found = discover([held], motor)
    assert found.model.effects["viscous_friction"] == motor.effects["viscous_friction"]


def test_a_friction_curve_gives_its_law(motor):
    """Constant speeds both ways, no position: viscous and Coulomb friction and their standard errors."""
    rng = np.random.default_rng(6)
    speed = np.concatenate([s * np.geomspace(2.0, 300.0, 40) for s in (1.0, -1.0)])
    torque = 2e-5 * speed + 1.5e-3 * np.sign(speed)
    curve = points("curve", speed=speed, current=torque / CONSTANT + NOISE * rng.standard_normal(80))
    model = motor.with_effect("coulomb_friction", {"torque": 1e-3, "static_ratio": 1.0})
    fitted = fit_model([curve], model)
    assert fitted.method == "equation"
    for path, truth in (("viscous_friction.coefficient", 2e-5), ("coulomb_friction.torque", 1.5e-3)):
        name, parameter = path.split(".")
        told = fitted.parameters[name][parameter]
        assert abs(told["value"] - truth) < 3.0 * told["std"] < 0.2 * truth
    found = discover([curve], motor)
    assert set(found.added) == {"coulomb_friction"}


def test_a_measured_load_is_taken_off_the_drives_torque(motor):
    """A dynamometer's sweep: load torque measured at constant speed."""
    load_torque = np.linspace(-5e-3, 5e-3, 60)
    speed = np.full(60, 100.0)
    needed = load_torque + 1e-5 * speed
    sweep = points("sweep", speed=speed, load_torque=load_torque, current=needed / CONSTANT)
    own = simulate(motor, sweep)
    assert own.signals["current"] == pytest.approx(sweep.signals["current"], abs=1e-9)
    assert compare([sweep], motor).overall["current"]["rmse"] < 1e-9


@pytest.mark.parametrize("braking", [True, False])
def test_a_load_sensor_tells_the_torque_constant(braking, motor):
    """A motor that gives a tenth less per ampere; unless it also brakes, friction that follows the load is the same."""
    unknown = replace(motor.effects["viscous_friction"], open=True)
    constant = replace(motor.constants[TORQUE_CONSTANT], source="data sheet")  # an assumed one would be fitted
    model = replace(
        motor,
        effects={**motor.effects, "viscous_friction": unknown},
        constants={**motor.constants, TORQUE_CONSTANT: constant},
    )
    rng = np.random.default_rng(3)
    load = np.tile(np.linspace(-5e-3 if braking else 5e-4, 5e-3, 60), 2)
    speed = np.repeat([60.0, 100.0], 60)
    current = (load + 1e-5 * speed) / (0.9 * CONSTANT) + NOISE * rng.standard_normal(120)
    found = discover([points("sweep", speed=speed, load_torque=load, current=current)], model)
    alike = {"torque_constant_error", "mesh_friction"}
    assert {*found.added} <= alike and len(found.added) == 1
    if braking:
        told = found.parameters["torque_constant_error"]["scale"]
        assert abs(told["value"] - 0.9) < 3.0 * told["std"]
    else:
        assert [set(group) for group in found.groups] == [alike]


def test_the_way_a_point_was_come_to():
    rng = np.random.default_rng(7)
    up = np.linspace(0.0, 1.0, 400)
    position = np.concatenate([up, up[::-1]]) + 1e-3 * rng.standard_normal(800)
    sense = approached(position)
    assert (sense[20:380] == 1.0).all() and (sense[420:780] == -1.0).all()
    assert not approached(np.zeros(100)).any()


def test_lone_points_are_judged_by_halves(held, motor):
    odd, even = operating_point_folds([held], motor)
    assert len(odd) + len(even) == len(held)
    assert abs(len(odd) - len(even)) < 0.02 * len(held)
    for part in (odd, even):  # both span the whole, and share no place
        assert np.ptp(part.signals["motor_position"]) > 0.8 * np.ptp(held.signals["motor_position"])
    places = [set(np.round(part.signals["motor_position"], 9)) for part in (odd, even)]
    assert len(places[0] & places[1]) <= 8
    top = points("top", motor_position=np.r_[np.zeros(20), np.ones(40)], current=np.arange(60.0))
    assert min(len(part) for part in operating_point_folds([top], motor)) >= 24
    assert operating_point_folds([held, held], motor) == [held, held]


def test_what_points_cannot_tell_is_refused(held, motor, stock):
    with pytest.raises(InputError, match="operating points need current"):
        discover([points("odd", motor_position=np.arange(50.0))], motor)
    with pytest.raises(InputError, match="operating points cannot drive a twin"):
        compare([held], motor, "current")
    with pytest.raises(InputError, match="record a motion"):
        plan([held], motor)
    with pytest.raises(InputError, match="play or a spring"):
        compare([held], stock.with_effect("backlash", {"width": 0.001}))


@pytest.mark.slow
def test_a_table_without_time_is_read(tmp_path):
    (tmp_path / "curve.csv").write_text("speed [rpm],current [A]\n" + "".join(f"{10 * k},0.{k}\n" for k in range(1, 9)))
    (tmp_path / "curve_map.yaml").write_text(
        "version: 1\noperating_points: true\nsignals:\n  speed: {columns: ['speed \\[rpm\\]'], unit: rpm}\n"
        "  current: {columns: ['current \\[A\\]'], unit: A}\n"
    )
    recording = load(tmp_path / "curve.csv", import_map=tmp_path / "curve_map.yaml")
    assert recording.of_points and not recording.gaps and not recording.warnings
    assert recording.signals["speed"][0] == pytest.approx(10.0 * math.pi / 30.0)
    done = twin("import", "curve.csv", "--map", "curve_map.yaml", "-o", "bags", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert load(tmp_path / "bags" / "curve").of_points
    shown = twin("info", "curve.csv", "--map", "curve_map.yaml", cwd=tmp_path).stdout
    assert "8 operating points" in shown and "sample period" not in shown
    text = (tmp_path / "curve_map.yaml").read_text().replace("operating_points: true\n", "")
    (tmp_path / "timeless.yaml").write_text(text)
    refused(
        "info", "curve.csv", "--map", "timeless.yaml", cwd=tmp_path, naming=("timeless.yaml: time", "operating_points")
    )


def test_points_are_not_played(tmp_path):
    (tmp_path / "curve.csv").write_text("current [A],speed [rad/s]\n" + "".join(f"0.{k},{k}\n" for k in range(1, 9)))
    (tmp_path / "m.yaml").write_text(
        "version: 1\noperating_points: true\nsignals:\n"
        "  speed: {columns: ['speed .*']}\n  current: {columns: ['current .*']}\n"
    )
    refused("live", "curve.csv", "--map", "m.yaml", "--model", "laas_motor", cwd=tmp_path, naming=("operating points",))


def test_a_speed_beyond_its_noise_keeps_its_direction_however_slow_it_is():
    """From 0.1 mrad/s to 1 rad/s, with positions that tell nothing of the direction."""
    rng = np.random.default_rng(3)
    speed = np.geomspace(1e-4, 1.0, 80) * rng.choice([-1.0, 1.0], 80)
    signals = {"current": np.sign(speed), "speed": speed, "motor_position": rng.uniform(0.0, 6.0, 80)}
    table = Recording("table", np.arange(80) * 1_000_000, signals, metadata={"operating_points": "true"})
    assert np.array_equal(np.sign(directed(table, 1e-6).signals["speed"]), np.sign(speed))
