"""A machine that nobody here has seen: `init` drafts its map and its model, and discover names what it hides."""

import re
import shlex
import shutil

import numpy as np
import pytest
import yaml

from docs.examples import press
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.measured.consistency import inconsistencies
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.model.matching import matched
from ema_twin_sim.new_machine.steps import smallest_step
from tests.command_line import done, refused, twin
from tests.conftest import RECORDINGS
from tests.trace_text import write_columns

RATIO = press.CONSTANTS["machine.gear_ratio"]


@pytest.fixture(scope="module")
def traces(tmp_path_factory):
    """Recordings of a press: ratio 12, 4 ms, degrees and rpm, and an unbalanced arm of 90 mN m on its output."""
    return press.write(tmp_path_factory.mktemp("press"))


@pytest.mark.slow
def test_its_map_and_model_are_drafted_and_what_it_hides_is_named(traces, tmp_path):
    ended = twin("init", traces[1], "-o", "press", "--torque-constant", "0.4", cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    model, drawn = load_model(tmp_path / "press.yaml"), (tmp_path / "press_map.yaml").read_text()
    assert model.value("machine.gear_ratio") == pytest.approx(RATIO, rel=2e-3)
    assert model.value("sensors.motor_encoder_counts") == pytest.approx(8192.0, rel=1e-3)
    assert model.value("sensors.sample_period") == pytest.approx(4e-3)
    assert "CHECK" not in drawn.partition("\n")[2]
    recording = load(traces[1], import_map=tmp_path / "press_map.yaml")
    assert set(recording.signals) == {"current", "speed", "motor_position", "output_position", "temperature"}
    assert np.abs(recording.signals["output_position"]).max() == pytest.approx(0.6, rel=0.1)

    found = twin(
        "discover", *traces, "--map", "press_map.yaml", "--model", "press.yaml", "-o", "better.yaml", cwd=tmp_path
    )
    assert found.returncode == 0, found.stderr
    better = yaml.safe_load((tmp_path / "better.yaml").read_text())
    assert {entry["effect"] for entry in better["effects"].values()} == {
        "viscous_friction", "coulomb_friction", "gravity_load",
    }  # fmt: skip
    assert better["effects"]["gravity_load"]["parameters"]["torque"] == pytest.approx(0.09, rel=0.05)
    both = [better["machine"][name]["value"] for name in ("inertia", "output_inertia")]
    assert sum(both) == pytest.approx(7.0e-4, rel=0.05)


def test_what_init_says_to_run_next_runs_as_it_is(traces, tmp_path):
    said = done("init", *traces, "-o", "press", "--torque-constant", "0.4", cwd=tmp_path).stdout
    (command,) = re.findall(r"ema-twin (info .*(?:\n .*)?)\n *ema-twin discover", said)
    assert "output_position" in done(*shlex.split(command), cwd=tmp_path).stdout
    shutil.copy(tmp_path / "press.yaml", tmp_path / "found.yaml")
    for verb in ("compare", "report"):  # with the map, and beside what discover writes
        (command,) = re.findall(rf"ema-twin ({verb} .*)", said)
        assert "--map press_map.yaml --model press.yaml --model found.yaml" in command
    (command,) = re.findall(r"ema-twin (compare .*)", said)
    assert "RMSE" in done(*shlex.split(command), cwd=tmp_path).stdout


def test_the_commands_after_a_model_alone_take_the_map_too(traces, tmp_path):
    done("init", traces[1], "-o", "press", "--torque-constant", "0.4", cwd=tmp_path)
    given = ("init", traces[1], "-o", "model", "--map", "press_map.yaml", "--torque-constant", "0.4")
    said = done(*given, cwd=tmp_path).stdout
    listed = re.findall(r"  ema-twin (\w+) .* --map press_map.yaml --model model.yaml", said)
    assert listed == ["discover", "compare", "report"]


@pytest.mark.slow
def test_play_is_named_in_a_machine_of_which_no_constant_is_known(tmp_path):
    """The project's own recordings, as a logger without a setpoint and without Siemens' names would have them."""
    for path in sorted(RECORDINGS.glob("*.CSV")):
        run = load(path)
        names = {"current": "current_A", "motor_position": "motor_angle_rad", "speed": "motor_speed_rad_s",
                 "output_position": "output_angle_rad"}  # fmt: skip
        columns = {word: run.signals[name] for name, word in names.items()}
        write_columns(tmp_path / f"{path.stem}.csv", {"time_s": run.time, **columns})
    traces = sorted(tmp_path.glob("*.csv"))
    told = done("init", traces[1], "-o", "own", "--gear-ratio", "124", cwd=tmp_path)
    assert "own_map.yaml: no line to check" in told.stdout
    done("discover", *traces, "--map", "own_map.yaml", "--model", "own.yaml", "-o", "own_better.yaml", cwd=tmp_path)
    effects = yaml.safe_load((tmp_path / "own_better.yaml").read_text())["effects"]
    assert effects["backlash"]["parameters"]["width"] == pytest.approx(4e-3, rel=0.03)
    assert "encoder_delay" not in effects


def test_what_cannot_be_guessed_is_marked(drafted):
    count, one = np.arange(9.0), np.ones(9)
    draft = drafted({"Time": count, "Iq": 0.1 * count, "Position": count, "Velocity": one, "foo": 2.0 * one})
    for name in ("current", "motor_position", "speed", "torque_constant"):
        assert "CHECK" in draft.line(name)
    assert "not used: foo" in draft.map and "marked CHECK" in draft.said


def test_a_column_that_numbers_runs_is_told_with_the_key_of_the_map(drafted):
    count = np.arange(100)
    columns = {"time [ms]": count, "sequence": count // 50, "current [A]": count % 7, "motor position [rad]": count}
    said = "sequence: seems to number 2 runs; with `run: sequence` in the import map, ema-twin campaign judges"
    assert said in drafted(columns).said


@pytest.mark.parametrize(
    ("answers", "question", "remedy"),
    [
        ([], "Name of the time column", "give a trace, whose columns answer it: ema-twin init TRACE.csv"),
        (["t [s]", "I [A]", "", "phi [rad]", "", ""], "Turns of the motor", "give --gear-ratio"),
        (["t [s]", "I [A]", "", "phi [rad]", "", "", "1"], "Torque per ampere", "give --torque-constant"),
    ],
)
def test_where_the_input_ends_at_a_question_what_answers_it_is_told(tmp_path, answers, question, remedy):
    """It was said to be interrupted."""
    naming = f'the input ended before an answer to "{question}', remedy
    refused("init", "-o", "press", cwd=tmp_path, answers="".join(f"{line}\n" for line in answers), naming=naming)


def test_without_a_trace_questions_are_asked(tmp_path):
    answers = ["time [ms]", "", "force [N]", "s [mm]", "", "", "1"]
    ended = twin("init", "-o", "slide", cwd=tmp_path, answers="\n".join(answers) + "\n")
    assert ended.returncode == 0, ended.stderr
    assert load_model(tmp_path / "slide.yaml").motion == "linear"
    assert "unit: mm" in (tmp_path / "slide_map.yaml").read_text()


def test_an_answer_with_another_unit_is_refused_and_nothing_is_written(tmp_path):
    answers = ["time [s]", "motor_position [deg]", "", "current [A]", "", ""]
    naming = "'motor_position [deg]'", "unit", "A, mA"
    refused("init", "-o", "slip", cwd=tmp_path, answers="\n".join(answers) + "\n", naming=naming)
    assert not list(tmp_path.iterdir())


def test_an_output_that_turns_the_other_way_is_said(drafted, tmp_path):
    count = np.arange(50.0)
    columns = {"time [s]": count, "current [A]": 0.1 * count, "motor position [deg]": 12.0 * count % 700.0}
    columns["output position [deg]"] = -count % 700.0
    draft = drafted(write_columns(tmp_path / "a: b.csv", columns))
    assert "marked CHECK" in draft.said and "the output turns against the motor" in draft.map


def test_counts_are_no_radians(drafted):
    count = np.arange(50)
    columns = {"time [ms]": count, "encoder_counts": (count * 37) % 4096, "iq [A]": 0.1 * count}
    line = drafted(columns).line("motor_position")
    assert "encoder_counts" in line and "counts_per_revolution" in line and "CHECK" in line


def test_an_encoder_without_steps_is_as_fine_as_its_noise(drafted, drawn):
    rng = np.random.default_rng(3)
    time = np.arange(500) * 1e-3
    position = 30.0 * np.sin(6.0 * time) + 0.01 * rng.standard_normal(500)
    drafted({"time [s]": time, "motor position [deg]": position, "current [A]": np.cos(6.0 * time)})
    counts = drawn().value("sensors.motor_encoder_counts")
    assert 360.0 / counts / np.sqrt(12.0) == pytest.approx(0.01, rel=0.2)


def test_a_steady_speed_is_no_counters_step():
    """Each sample goes by about as much as the one before; a counter's would stand still now, or go twice as far."""
    rng = np.random.default_rng(3)
    way = np.cumsum(1.5e-3 * (1.0 + 0.02 * rng.standard_normal(3000)))
    assert smallest_step(np.round(way, 5)) is None
    assert smallest_step(2e-3 * np.floor(way / 2e-3)) == pytest.approx(2e-3)


def test_a_counter_of_a_fast_shaft_shows_single_steps_where_it_reverses():
    time = np.arange(15_000) * 1e-3
    way = 60.0 * np.cumsum(np.clip(2.0 * np.sin(1.26 * time), -1.0, 1.0)) * 1e-3
    assert smallest_step(1.5e-3 * np.rint(way / 1.5e-3)) == pytest.approx(1.5e-3)
    noisy = way + 1e-4 * np.random.default_rng(1).standard_normal(len(way))
    assert smallest_step(np.round(noisy, 9)) is None


def test_what_init_refuses(tmp_path):
    (tmp_path / "odd.csv").write_text("foo,bar\n1,2\n3,4\n")
    refused("init", "odd.csv", "-o", "odd", cwd=tmp_path, naming=("odd.csv: header", "foo, bar", "rename them"))
    (tmp_path / "there.yaml").write_text("")
    for name in ("there", "there.yaml"):  # a file's name is the machine's all the same
        refused("init", "odd.csv", "-o", name, cwd=tmp_path, naming=("there.yaml: exists already", "--force"))
    refused("init", "none.csv", "-o", "none", cwd=tmp_path, naming=("none.csv", "check the path"))


def test_a_torque_in_place_of_a_current_has_its_noise(drafted, drawn):
    rng = np.random.default_rng(5)
    time = np.arange(800) * 1e-3
    force = 20.0 * np.cos(time) + 0.3 * rng.standard_normal(800)
    drafted({"time [s]": time, "position [mm]": np.cumsum(np.sin(time)), "force [N]": force})
    assert drawn().value("sensors.current_noise") == pytest.approx(0.3, rel=0.1)


def turning(ratio, *, both=False, speed=True):
    """Columns of a motor whose position counts the turns of an output behind a gearbox."""
    time = np.arange(1000) * 2e-3
    angle = 40.0 * np.sin(3.0 * time)  # rad of the motor
    columns = {"time [s]": time, "current [A]": np.cos(3.0 * time), "position [deg]": angle / ratio * press.DEGREES}
    columns |= {"output position [deg]": columns["position [deg]"]} if both else {}
    return columns | ({"speed [rpm]": np.gradient(angle, time) * press.RPM} if speed else {})


@pytest.mark.parametrize("both", [False, True])
def test_the_shaft_of_a_position_is_told_by_the_speed(drafted, read, drawn, both):
    draft = drafted(turning(50.0, both=both))
    line = draft.line("motor_position")
    assert "shaft: output" in line and "CHECK" in line and "0.02 times" in line
    assert drawn().value("machine.gear_ratio") == pytest.approx(50.0, rel=1e-3)
    assert "CHECK" in draft.line("gear_ratio")
    moved = matched(read(), drawn())
    assert np.ptp(moved.signals["motor_position"]) == pytest.approx(80.0, rel=1e-3)
    assert not list(inconsistencies(moved, drawn()))


def test_the_shaft_of_a_position_is_told_by_the_output_and_the_ratio(drafted):
    draft = drafted(turning(50.0, both=True, speed=False), gear_ratio=50.0)
    assert "shaft: output" in draft.line("motor_position")


@pytest.mark.parametrize(("ratio", "given"), [(1.0, None), (press.RPM, None), (20.0, 50.0)])
def test_a_position_of_the_motor_stays_the_motors(drafted, ratio, given):
    """It goes the way of the speed, or a factor that wrong units make, or one that is no gear ratio."""
    line = drafted(turning(ratio), gear_ratio=given).line("motor_position")
    assert ", shaft: output}" not in line
    assert ("CHECK" in line) == (ratio != 1.0)


def test_the_shaft_is_asked_for_behind_a_gearbox(tmp_path):
    answers = ["time [s]", "current [A]", "", "q [deg]", "", "", "50", "output", "0"]
    done("init", "-o", "arm", cwd=tmp_path, answers="\n".join(answers) + "\n")
    assert re.search("motor_position.*shaft: output", (tmp_path / "arm_map.yaml").read_text())
    refused(
        "init", "-o", "leg", cwd=tmp_path, answers="\n".join([*answers[:7], "wheel", "0"]) + "\n",
        naming=("'wheel' is not a shaft",),
    )  # fmt: skip


def joint(peak, position="position [rad]", torque="current [A]"):
    """Columns of position and speed of one shaft, up to ``peak`` [rad/s], which do not say whose they are."""
    time = np.arange(1500) * 8e-3
    angle, speed = peak / 2.0 * np.sin(2.0 * time), peak * np.cos(2.0 * time)
    current = 3.0 * np.cos(angle) + np.sign(speed)
    return {"time [s]": time, position: angle, "speed [rad/s]": speed, torque: current}


GEARED = {"gear_ratio": 100.0, "torque_constant": 0.1}
MOVING = ("motor_position", "speed")


@pytest.mark.parametrize(
    ("peak", "position", "at_output"),
    [(0.6, "position [rad]", True), (60.0, "position [rad]", False), (0.6, "motor position [rad]", False)],
)
def test_a_motor_does_not_stay_within_a_turn_behind_its_gear(drafted, read, drawn, peak, position, at_output):
    """Within a turn it is the output that is told, unless the column names the motor."""
    draft = drafted(joint(peak, position), **GEARED)
    assert ["shaft: output}" in draft.line(signal) for signal in MOVING] == [at_output, at_output]
    assert ("CHECK" in draft.line("motor_position")) == at_output
    moved = matched(read(), drawn())
    assert np.abs(moved.signals["speed"]).max() == pytest.approx(peak * (100.0 if at_output else 1.0), rel=1e-3)
    assert drawn().value("sensors.speed_noise") < 1e-2 * np.abs(moved.signals["speed"]).max()


@pytest.mark.parametrize(
    ("position", "at_output"),
    [("measured steering angle [rad]", True), ("pedal position [rad]", True), ("steering motor angle [rad]", False)],
)
def test_the_angle_of_what_a_motor_moves_is_not_the_motors(drafted, position, at_output):
    """By 3 turns it may be either shaft's; the inertia and the counts of a turn would be off by the gear ratio."""
    draft = drafted(joint(20.0, position), **GEARED)
    assert ["shaft: output}" in draft.line(signal) for signal in MOVING] == [at_output, at_output]


def test_whose_angle_it_is_behind_a_gear_is_told_where_no_name_tells(drafted):
    draft = drafted(joint(20.0), **GEARED)
    assert "position [rad]: read as the motor's, which turns 100 times as fast as the output" in draft.said
    assert "as in 'output position [rad]'" in draft.said
    asked = "it goes 3.18 turns in all, which as the motor's would turn the output by 11.5 deg: is it the motor's?"
    assert all(asked in draft.line(signal) for signal in MOVING)
    assert "read as the motor's" not in drafted(joint(20.0, "motor position [rad]"), **GEARED).said


@pytest.mark.parametrize(("ratio", "told", "at_joint"), [(100.0, 20.0, True), (100.0, 0.2, False), (1.0, 20.0, False)])
def test_a_torque_constant_that_no_drive_could_feed_is_the_joints(tmp_path, drafted, drawn, ratio, told, at_joint):
    """20 N m/A are 20 V s/rad: 1200 V at the motor's 60 rad/s."""
    draft = drafted(joint(0.6), gear_ratio=ratio, torque_constant=told)
    own = told / (ratio if at_joint else 1.0)
    assert drawn().value("machine.torque_constant") == pytest.approx(own)
    later = save_model(drawn(), tmp_path / "later.yaml").read_text()
    for text in (draft.model, later):
        assert bool(re.search("torque_constant.*CHECK", text)) == at_joint


@pytest.mark.parametrize(("ratio", "told"), [(100.0, 4e5), (9.0, 420.0), (1.0, 4200.0)])
def test_a_torque_constant_that_no_motor_has_is_refused(tmp_path, drafted, ratio, told):
    """A motor behind a gear turns 1000 times a minute at least; in thousandths, data sheets are right."""
    with pytest.raises(InputError, match=rf"if it is in mN m/A, give {told / 1000.0:g}") as refusal:
        drafted(joint(0.6), gear_ratio=ratio, torque_constant=told)
    assert "\n" not in str(refusal.value)
    assert not (tmp_path / "m.yaml").exists()


def test_a_torque_constant_that_hardly_a_motor_has_is_asked_about(drafted):
    """420 N m/A at a joint behind a gear of 50 are 8.4 at the motor: 880 V at 1000 turns a minute."""
    asked = drafted(joint(0.6), gear_ratio=50.0, torque_constant=420.0).warned
    assert asked.count("--torque-constant") == 1 and "880 V" in asked and "in mN m/A, give 0.42" in asked
    assert "--torque-constant" not in drafted(joint(0.6), gear_ratio=50.0, torque_constant=0.42).warned


@pytest.mark.parametrize(("torque", "at_output"), [("torque [N m]", True), ("motor torque [N m]", False)])
def test_each_column_that_follows_a_joint_is_to_be_looked_at(drafted, torque, at_output):
    draft = drafted(joint(0.6, torque=torque), gear_ratio=100.0)
    for signal, flipped in (("motor_position", True), ("speed", True), ("motor_torque", at_output)):
        assert ("shaft: output}  # CHECK: " in draft.line(signal)) == flipped, draft.line(signal)
    columns = ("torque [N m], " if at_output else "") + "speed [rad/s], position [rad]"
    why = "it goes 0.0955 turns in all, which as the motor's would turn the output by 0.344 deg"
    assert f"Assumed: {columns}: read as values of the output shaft: {why} (" in draft.said
    assert "'motor position [rad]', and run init again" in draft.said
    assert f"{why}: assumed to be the output's" in draft.line("motor_position")


def test_what_a_drives_voltage_decided_is_said_with_the_number_and_the_remedy(drafted, tmp_path):
    given = {"gear_ratio": 100.0, "torque_constant": 20.0}
    drafted(joint(0.6), **given)
    said = drafted(joint(0.6), import_map=str(tmp_path / "m_map.yaml"), **given).said
    said = said.partition("Assumed: torque constant read as that of")[2]
    assert "20 N m/A would induce 1200 V" in said and "600 V" in said and "remove `shaft: output`" in said


def test_a_siemens_trace_needs_no_map(tmp_path):
    trace = next(RECORDINGS.glob("*.CSV"))
    told = refused("init", trace, "-o", tmp_path / "machine.yaml")
    assert told.endswith(
        f"{trace}: is a Siemens drive's trace, which needs no map; leave init out: ema-twin info {trace}"
    )
